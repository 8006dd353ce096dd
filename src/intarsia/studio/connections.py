"""Connections: each asks something soon or ends, quiet ones give way to new ones, and what is no HTTP is told so."""

from __future__ import annotations

import asyncio

from uvicorn.protocols.http.h11_impl import H11Protocol

from .safety import HEADERS

SOON = 10.0  # s for all headers of a request, from the beginning of the connection or from the answer before
QUIET = 256  # connections at once on which nothing is asked; a browser has six


class Connection(H11Protocol):
    """A connection of the server."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin; the one that was quiet longest ends where there are too many."""
        super().connection_made(transport)
        self._wait()
        quiet = [other for other in self.connections if isinstance(other, Connection) and other.is_quiet()]
        if len(quiet) > QUIET:
            min(quiet, key=lambda other: other.since).transport.close()

    def on_response_complete(self) -> None:
        """Wait for the next request."""
        self._wait()
        super().on_response_complete()

    def is_quiet(self) -> bool:
        """Whether nothing was asked, or all is answered."""
        return not self.transport.is_closing() and (self.cycle is None or self.cycle.response_complete)

    def _wait(self) -> None:
        self.since, before = self.loop.time(), self.cycle
        self.loop.call_later(SOON, lambda: self.transport.close() if self.cycle is before else None)

    def send_400_response(self, msg: str) -> None:
        """Refuse what is no HTTP, with the headers of every answer."""
        headers = {**HEADERS, "Content-Type": "text/plain", "Content-Length": str(len(msg)), "Connection": "close"}
        lines = ["HTTP/1.1 400 Bad Request", *(f"{name}: {value}" for name, value in headers.items()), "", msg]
        self.transport.write("\r\n".join(lines).encode("ascii"))
        self.transport.close()
