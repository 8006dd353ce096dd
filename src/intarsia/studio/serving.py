"""The server: on loopback alone, at a free port, with a token; it opens the browser and leaves nothing behind."""

from __future__ import annotations

import asyncio
import webbrowser
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import uvicorn

from ..errors import InputError, ResourceError, printable
from .app import Studio, app_of

HOST = "127.0.0.1"
CONNECTIONS = 256  # at once, those of pages that listen included


class Server(uvicorn.Server):
    """A server that says where it is, once it is there."""

    def __init__(self, config: uvicorn.Config, there: Callable[[int], Any]) -> None:
        super().__init__(config)
        self._there = there

    async def startup(self, sockets: Any = None) -> None:
        try:
            await super().startup(sockets)
        except SystemExit:
            raise ResourceError(f"port {self.config.port} cannot be had; name another with --port.") from None
        if self.started:
            self._there(self.servers[0].sockets[0].getsockname()[1])


def serve(files: Sequence[str], folder: str, port: int, browser: bool, say: Callable[[str], None]) -> None:
    """Serve the studio until it is stopped; `files` become exemplars."""
    given = [(Path(path).name, _read(path)) for path in files if not path.startswith("sample:")]
    samples = [path.partition(":")[2] for path in files if path.startswith("sample:")]
    studio = Studio(folder)
    app = app_of(studio)

    async def take() -> None:
        for name in samples:
            await studio.uploads.sample(name)
        for name, data in given:
            await studio.uploads.exemplar([(name, data)])

    tasks = []

    def there(port: int) -> None:
        app.port = port
        address = f"http://{HOST}:{port}/?token={app.token}"
        say(f"the studio is at {address} (Ctrl-C ends it); its folder is {printable(folder)}")
        if files:
            tasks.append(asyncio.get_running_loop().create_task(_told(take(), say)))
        if browser:
            webbrowser.open(address)

    config = uvicorn.Config(
        app, host=HOST, port=port, log_config=None, log_level="critical", access_log=False, server_header=False,
        timeout_graceful_shutdown=1, ws="none", limit_concurrency=CONNECTIONS,
    )  # fmt: skip
    try:
        with suppress(KeyboardInterrupt):
            Server(config, there).run()
    finally:
        if app.port:
            say("the studio has ended")


async def _told(work: Any, say: Callable[[str], None]) -> None:
    """Do some work beside; its error is told."""
    try:
        await work
    except Exception as e:
        say(f"intarsia: {e}")


def _read(path: str) -> bytes:
    try:
        return Path(path).read_bytes()
    except OSError as e:
        raise InputError(f"{printable(path)}: {(e.strerror or str(e)).lower()}; name a picture.") from None
