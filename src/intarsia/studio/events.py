"""Server-sent events: everybody who listens hears the same, and nobody who is slow holds up the others."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from typing import Any

MOST = 1000  # events that wait for a listener; one that is further behind begins anew
BREATH = 10.0  # s without an event, after which a line says that the server is there


class Events:
    """Who listens, and what they are told."""

    def __init__(self) -> None:
        self._ears: set[asyncio.Queue[bytes | None]] = set()

    @property
    def listeners(self) -> int:
        """How many listen."""
        return len(self._ears)

    def tell(self, kind: str, said: Any) -> None:
        """Tell everybody."""
        line = written(kind, said)
        for ear in list(self._ears):
            if ear.qsize() >= MOST:
                self._ears.discard(ear)
                ear.put_nowait(None)
            else:
                ear.put_nowait(line)

    def close(self) -> None:
        """Let everybody go."""
        for ear in self._ears:
            ear.put_nowait(None)
        self._ears.clear()

    async def heard(self, first: Callable[[], list[tuple[str, Any]]]) -> AsyncIterator[bytes]:
        """What a listener hears: how things are, then each event."""
        ear: asyncio.Queue[bytes | None] = asyncio.Queue()
        self._ears.add(ear)
        try:
            for kind, said in first():
                yield written(kind, said)
            while True:
                try:
                    line = await asyncio.wait_for(ear.get(), BREATH)
                except TimeoutError:
                    yield b": here\n\n"
                    continue
                if line is None:
                    return
                yield line
        finally:
            self._ears.discard(ear)


def written(kind: str, said: Any) -> bytes:
    """An event as it is sent."""
    return f"event: {kind}\ndata: {json.dumps(said)}\n\n".encode()
