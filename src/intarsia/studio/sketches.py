"""Sketches: what each method makes of an exemplar, small; grown only while nothing else is to be done, and kept."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from ..choosing.auto import AUTO_METHOD
from ..errors import InputError, said
from ..methods.base import METHODS
from .pictures import Pictures
from .processes import FailedError, Process, Wanted
from .store import Row
from .uploads import Uploads

WITHIN = 120.0  # s: the first one of a method may have to be compiled
AGAIN = 0.1  # s between two looks whether there is something else to do
IDLE = 60.0  # s after which the process ends that nobody asks


class Sketches:
    """Grows sketches in a process of its own, which gives way to jobs at once, and ends when it is not asked."""

    def __init__(self, uploads: Uploads, pictures: Pictures, busy: Callable[[], bool]) -> None:
        self.uploads, self.pictures, self.busy = uploads, pictures, busy
        self.process = Process(nice=19)
        self._asked = 0
        self._rest: asyncio.TimerHandle | None = None

    async def get(self, row: Row, method: str, wanted: Wanted) -> bytes:
        """Return the sketch of a method as PNG, empty where it cannot serve this exemplar.

        FailedError where it is no longer wanted.
        """
        if method not in (AUTO_METHOD, *METHODS):
            raise InputError(f"{said(method)} is no method; give one of {', '.join((AUTO_METHOD, *METHODS))}.")
        key = ("sketch", row["id"], method)
        while (found := self.pictures.get(key)) is None:
            grown = await self._grown(row, method, wanted)
            if grown is not None:
                return self.pictures.keep(key, grown)
        return found

    async def end(self) -> None:
        """Stop at once."""
        if self._rest is not None:
            self._rest.cancel()
        await self.process.end()

    async def _grown(self, row: Row, method: str, wanted: Wanted) -> bytes | None:
        """A sketch; none where it gave way to something else, which may have ended since."""
        watch: list[asyncio.Task[None]] = []

        async def free() -> bool:
            """Whether it is still wanted, once there is nothing else to do."""
            while self.busy() and await wanted():
                await asyncio.sleep(AGAIN)
            watch.append(asyncio.create_task(self._give_way()))
            return await wanted()

        self._asked += 1
        try:
            paths = self.uploads.paths_of(row)
            _, data = await self.process.ask("sketch", within=WITHIN, wanted=free, paths=paths, method=method)
            picture: bytes = data
            return picture
        except FailedError:
            if any(task.done() for task in watch):
                return None
            raise
        finally:
            for task in watch:
                task.cancel()
            self._asked -= 1
            self._let_rest()

    async def _give_way(self) -> None:
        while not self.busy():
            await asyncio.sleep(AGAIN)
        self.process.cancel()

    def _let_rest(self) -> None:
        if self._rest is not None:
            self._rest.cancel()
        self._rest = asyncio.get_running_loop().call_later(IDLE, self._end_idle)

    def _end_idle(self) -> None:
        if not self._asked:
            self._ending = asyncio.create_task(self.process.end())
