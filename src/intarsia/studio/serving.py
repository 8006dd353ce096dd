"""The server: on loopback alone, with a token; it opens the browser and leaves nothing behind."""

from __future__ import annotations

import asyncio
import os
import shutil
import threading
import webbrowser
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import uvicorn

from ..errors import InputError, ResourceError, printable
from .app import Studio, app_of
from .connections import Connection
from .safety import Safety
from .store import AUTHORIZATION


class Server(uvicorn.Server):
    """A server that says when it is there."""

    def __init__(self, config: uvicorn.Config, there: Callable[[], None]) -> None:
        super().__init__(config)
        self._there = there

    async def startup(self, sockets: Any = None) -> None:
        await super().startup(sockets)
        if self.started:
            self._there()


def serve(files: Sequence[str], folder: str, port: int, browser: bool, say: Callable[[str], None]) -> None:
    """Serve the studio until it is stopped; `files` become exemplars."""
    given = [(Path(path).name, _read(path)) for path in files if not path.startswith("sample:")]
    samples = [path.partition(":")[2] for path in files if path.startswith("sample:")]
    os.umask(0o077)  # what is opened and made here is nobody else's, also what the processes beside write
    studio = Studio(folder)
    app = app_of(studio)
    config = uvicorn.Config(
        app, http=Connection, log_config=None, log_level="critical", access_log=False, server_header=False,
        timeout_graceful_shutdown=1, ws="none",
    )  # fmt: skip
    listening = _listening(config, studio.store.home, port)
    app.host, app.port = listening.getsockname()

    async def take() -> None:
        for name in samples:
            await studio.uploads.sample(name)
        for name, data in given:
            await studio.uploads.exemplar([(name, data)])

    tasks = []

    def there() -> None:
        say(f"the studio is at {app.entrance(entered)} (Ctrl-C ends it); its folder is {printable(folder)}")
        if files:
            tasks.append(asyncio.get_running_loop().create_task(_told(take(), say)))
        if opening is not None:
            _open(app, opening)

    def entered() -> None:
        say(f"a browser came in; another one comes in at {app.entrance(entered)}")

    opening = studio.store.under_way("images") if browser else None
    bearer = studio.store.folder / AUTHORIZATION
    try:
        bearer.unlink(missing_ok=True)
        bearer.write_text(f"Authorization: Bearer {app.token}\n", encoding="utf-8")
        with suppress(KeyboardInterrupt):
            Server(config, there).run([listening])
    finally:
        bearer.unlink(missing_ok=True)
        if opening is not None:
            shutil.rmtree(opening, ignore_errors=True)
        say("the studio has ended")


def _listening(config: uvicorn.Config, home: tuple[str, int], port: int) -> Any:
    """Listen at a loopback address of the folder's own, if the system has more than one; at its usual port if it can.

    A browser sends cookies to all ports of a host, so no other server on this machine shall have the same.
    """
    for host in (home[0], "127.0.0.1"):
        for number in (port or home[1], port):
            config.host, config.port = host, number
            with suppress(SystemExit):
                return config.bind_socket()
    raise ResourceError(f"port {port} cannot be had; name another with --port.")


def _open(app: Safety, folder: Path) -> None:
    """Open the page by a file that sends the browser on, since everybody can read what a program is started with."""
    page, address = folder / "open.html", app.entrance(lambda: shutil.rmtree(folder, ignore_errors=True))
    page.write_text(f'<!doctype html><title>intarsia</title><meta http-equiv="refresh" content="0;url={address}">')
    threading.Thread(target=webbrowser.open, args=[page.as_uri()], daemon=True).start()  # some wait for their end


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
