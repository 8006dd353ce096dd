"""The HTTP server: loopback only, with a token; opens the browser, and removes its temporary files at the end."""

from __future__ import annotations

import asyncio
import os
import re
import shutil
import threading
import webbrowser
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from ..foundation import InputError, ResourceError, printable
from .announcing import announced
from .app import Studio, app_of
from .security import HEADERS, Safety
from .store import AUTHORIZATION

SOON = 10.0  # s for all headers of a request, from the beginning of the connection or from the answer before
LAX = re.compile(rb"(?<!\r)\n|\n[ \t]")  # in the header of a request
QUIET = 256  # idle connections at once; a browser has six


class Connection(H11Protocol):
    """A connection of the server, with stricter parsing and limits on idle ones."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Accept a connection; close the one that was idle longest if there are too many."""
        super().connection_made(transport)
        self._wait()
        quiet = [other for other in self.connections if isinstance(other, Connection) and other.is_quiet()]
        if len(quiet) > QUIET:
            min(quiet, key=lambda other: other.since).transport.close()

    def on_response_complete(self) -> None:
        """Wait for the next request."""
        self._wait()
        super().on_response_complete()

    def handle_events(self) -> None:
        """Refuse header lines that parsers read differently: that end without CR, or continue on the next line."""
        head = self.conn.trailing_data[0].lstrip().partition(b"\r\n\r\n")[0]
        if self.conn.their_state is h11.IDLE and LAX.search(head):
            return self.send_400_response("Lines of a header end in CR and LF, and none goes on in the next one.")
        return super().handle_events()

    def is_quiet(self) -> bool:
        """Return whether no request is being answered."""
        return not self.transport.is_closing() and (self.cycle is None or self.cycle.response_complete)

    def _wait(self) -> None:
        self.since, before = self.loop.time(), self.cycle
        self.loop.call_later(SOON, lambda: self.transport.close() if self.cycle is before else None)

    def send_400_response(self, msg: str) -> None:
        """Answer what is no HTTP, with the headers of every answer."""
        headers = {**HEADERS, "Content-Type": "text/plain", "Content-Length": str(len(msg)), "Connection": "close"}
        lines = ["HTTP/1.1 400 Bad Request", *(f"{name}: {value}" for name, value in headers.items()), "", msg]
        self.transport.write("\r\n".join(lines).encode("ascii"))
        self.transport.close()


class Server(uvicorn.Server):
    """A server that calls a function once it listens."""

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
    os.umask(0o077)  # files are private, also those that the worker processes write
    studio = Studio(folder)
    app = app_of(studio)
    config = uvicorn.Config(
        app, http=Connection, log_config=None, log_level="critical", access_log=False, server_header=False,
        timeout_graceful_shutdown=1, ws="none",
    )  # fmt: skip
    listening = _listening(config, studio.store.home, port)
    app.host, app.port = listening.getsockname()

    async def take() -> None:
        try:
            for name in samples:
                await studio.uploads.sample(name)
            for name, data in given:
                await studio.uploads.exemplar([(name, data)])
        except Exception as e:
            say(f"intarsia: {e}")

    tasks = []

    def there() -> None:
        say(f"the studio is at {app.entrance(entered)} (Ctrl-C ends it); its folder is {printable(folder)}")
        if files:
            tasks.append(asyncio.get_running_loop().create_task(take()))
        if opening is not None:
            _open(app, opening)

    def entered() -> None:
        say(f"a browser came in; another one comes in at {app.entrance(entered)}")

    opening = studio.store.begun("images") if browser else None
    bearer = studio.store.folder / AUTHORIZATION
    try:
        bearer.unlink(missing_ok=True)
        bearer.write_text(f"Authorization: Bearer {app.token}\n", encoding="utf-8")
        address = f"http://{app.host}:{app.port}"
        with suppress(KeyboardInterrupt), announced(address, app.token, str(studio.store.folder)):
            Server(config, there).run([listening])
    finally:
        bearer.unlink(missing_ok=True)
        if opening is not None:
            shutil.rmtree(opening, ignore_errors=True)
        say("the studio has ended")


def _listening(config: uvicorn.Config, home: tuple[str, int], port: int) -> Any:
    """Return a socket at a loopback address of the folder's own, if possible, and at its usual port.

    A browser sends cookies to all ports of a host, so no other server on this machine should share its address.
    """
    for host in (home[0], "127.0.0.1"):
        for number in (port or home[1], port):
            config.host, config.port = host, number
            with suppress(SystemExit):
                return config.bind_socket()
    raise ResourceError(f"port {port} cannot be had; name another with --port.")


def _open(app: Safety, folder: Path) -> None:
    """Open the page by a file that redirects, since command lines of programs can be read by everybody."""
    page, address = folder / "open.html", app.entrance(lambda: shutil.rmtree(folder, ignore_errors=True))
    page.write_text(f'<!doctype html><title>intarsia</title><meta http-equiv="refresh" content="0;url={address}">')
    threading.Thread(target=webbrowser.open, args=[page.as_uri()], daemon=True).start()  # some browsers block


def _read(path: str) -> bytes:
    try:
        return Path(path).read_bytes()
    except OSError as e:
        raise InputError(f"{printable(path)}: {(e.strerror or str(e)).lower()}; name a picture.") from None
