"""The server's end of a worker process: one request at a time; killed and restarted if it no longer answers."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from collections.abc import Awaitable, Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..foundation import IntarsiaError

Json = dict[str, Any]
Heard = Callable[[Json, bytes], None]

Gone = Callable[[], Awaitable[bool]]
"""Whether the client no longer waits for an answer."""

LONGEST = 1 << 28  # bytes of a line


class FailedError(IntarsiaError):
    """A request to a worker process failed: one line, and the exit code that a shell would get."""

    def __init__(self, line: str, code: int = 1) -> None:
        super().__init__(line)
        self.exit_code = code


class Process:
    """A process that runs `worker.py`, started at the first request.

    ``limit``: bytes of address space at most, 0: no limit; ``nice``: how far its priority is lowered.
    """

    def __init__(self, limit: int = 0, nice: int = 0) -> None:
        self._words, self._number = [str(limit), str(nice)], 0
        self._process: asyncio.subprocess.Process | None = None
        self._turn = asyncio.Lock()

    @property
    def pid(self) -> int | None:
        """The number of the process, or None."""
        return None if self._process is None else self._process.pid

    async def ask(
        self, do: str, heard: Heard | None = None, within: float | None = None, gone: Gone | None = None,
        **given: Any,
    ) -> tuple[Any, bytes]:  # fmt: skip
        """Return what the process answers, as (JSON, bytes); FailedError if that fails.

        `heard` is called with what it reports meanwhile. After `within` seconds the process is killed, which is a
        failure. A request whose client has `gone` when its turn comes is not sent, and fails.
        """
        async with self._turn:
            if gone is not None and await gone():
                raise FailedError("nobody waits for this any more.")
            try:
                return await asyncio.wait_for(self._ask(do, heard, given), within)
            except TimeoutError:
                await self.end()
                raise FailedError(f"this took longer than {within:.0f} s and was stopped.") from None
            except asyncio.CancelledError:
                await self.end()
                raise

    async def _ask(self, do: str, heard: Heard | None, given: Json) -> tuple[Any, bytes]:
        process = await self._started()
        self._number += 1
        assert process.stdin is not None
        try:
            process.stdin.write(json.dumps({"number": self._number, "do": do, **given}).encode() + b"\n")
            await process.stdin.drain()
            while True:
                said, data = await self._frame(process)
                if said.get("number") != self._number:
                    continue
                if "done" in said:
                    return said["done"], data
                if "failed" in said:
                    raise FailedError(said["failed"], said["code"])
                if heard is not None:
                    heard(said, data)
        except (OSError, asyncio.IncompleteReadError):
            with suppress(TimeoutError):  # killing one that has just ended would lose its exit code
                await asyncio.wait_for(process.wait(), 1)
            code = await self.end()
            why = "out of memory, mostly" if code in (-9, 137, -11) else f"code {code}"
            raise FailedError(f"the process that did the work ended early ({why}); ask again.") from None

    async def _started(self) -> asyncio.subprocess.Process:
        if self._process is not None and self._process.returncode is None:
            return self._process
        pipe, words = asyncio.subprocess.PIPE, [sys.executable, "-m", "intarsia.studio.workers.worker", *self._words]
        home = Path(__file__).absolute().parents[2]
        found = os.environ | {"PYTHONPATH": os.pathsep.join([str(home), *filter(None, [os.environ.get("PYTHONPATH")])])}
        self._process = await asyncio.create_subprocess_exec(
            *words, stdin=pipe, stdout=pipe, stderr=asyncio.subprocess.DEVNULL, limit=LONGEST, env=found,
            start_new_session=True,
        )  # fmt: skip
        await self._frame(self._process)
        return self._process

    async def _frame(self, process: asyncio.subprocess.Process) -> tuple[Json, bytes]:
        assert process.stdout is not None
        said = json.loads(await process.stdout.readuntil(b"\n"))
        return said, await process.stdout.readexactly(said["bytes"])

    def cancel(self) -> None:
        """Ask the process to stop its current work."""
        if self._process is not None and self._process.stdin is not None:
            with suppress(OSError, RuntimeError):
                self._process.stdin.write(json.dumps({"do": "cancel", "number": self._number}).encode() + b"\n")

    async def end(self) -> int | None:
        """Kill the process; return its exit code."""
        process, self._process = self._process, None
        if process is None:
            return None
        with suppress(ProcessLookupError):
            process.kill()
        return await process.wait()
