"""Kernels compiled beside the work, by a process of their own: the second core has nothing else to do at a first start.

Which kernels a command runs, and in which order, is known from `kernels.json`. The process beside begins at the end
of the list, the work at its beginning; each finds on disk what the other has made. The list only saves time: what it
lacks is compiled when it is needed, and what it has too much is compiled for nothing.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections import deque
from contextlib import suppress
from functools import cache
from pathlib import Path
from threading import Thread
from typing import Any

LIST = Path(__file__).with_name("kernels.json")
WITHOUT, ONLY, GROW = "without", "only", "grow"
FEW = 6  # kernels, which take about two seconds
ALONE = f"""import sys
sys.path.append({str(Path(__file__).parents[2])!r})
from intarsia.tasks.helper import work
work()
"""


@cache
def lists() -> dict[str, list[str]]:
    """Name of a list -> lines of :mod:`intarsia.kernels.listed`, in the order in which they are needed."""
    kept = json.loads(LIST.read_text(encoding="utf-8"))
    kernels = kept["kernels"]
    return {name: [kernels[n] for n in numbers] for name, numbers in kept["lists"].items()}


def every_kernel() -> list[str]:
    """Return all lines of all lists once, those of a file together: they call the same functions."""
    return sorted({line for lines in lists().values() for line in lines})


class Beside:
    """A process that compiles what it is told, until this one ends.

    It says what it works at: this one waits for a kernel that is being made there, and has it leave out what is made
    here.
    """

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", ALONE], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, start_new_session=True, text=True,
        )  # fmt: skip
        self._now, self.taken = "", ""
        self._work: deque[str] | None = None
        self._listener = Thread(target=self._listen, daemon=True)
        self._listener.start()

    @property
    def process(self) -> int:
        """The number of the process."""
        return self._process.pid

    def compile(self, *words: str) -> None:
        """Go on with the lists of these names."""
        self._tell(" ".join(words))

    def take_from(self, work: deque[str]) -> None:
        """Take one line after another from the end and do what it says, until none is left.

        ``taken`` is the one at hand, empty when there is none; a process that ends leaves it undone.
        """
        self._work = work
        self._take()

    def share_work(self) -> None:
        """From now on kernels that this process needs are not made twice."""
        from ..kernels.compiling import before_each

        before_each(self._wait)

    def running(self) -> bool:
        """Tell whether the process is still at work."""
        return self._process.poll() is None

    def close(self) -> int | None:
        """End the process now; return its exit code if it ended by itself."""
        from ..kernels.compiling import before_each

        before_each(None)
        code = self._process.poll()
        with suppress(OSError):
            self._process.kill()
        self._process.wait()
        self._listener.join()
        for pipe in (self._process.stdin, self._process.stdout):
            with suppress(OSError):
                pipe.close()  # type: ignore[union-attr]
        if code is None:
            _sweep(self._process.pid)
        return code

    def _tell(self, line: str) -> None:
        with suppress(OSError, ValueError):  # it has ended; see `close`
            self._process.stdin.write(f"{line}\n")  # type: ignore[union-attr]
            self._process.stdin.flush()  # type: ignore[union-attr]

    def _listen(self) -> None:
        for line in self._process.stdout:  # type: ignore[union-attr]
            self._now = line.strip()
            if not self._now and self._work is not None:
                self._take()
        self._now = ""

    def _take(self) -> None:
        assert self._work is not None
        try:
            self.taken = self._work.pop()
        except IndexError:
            self.taken = ""
        else:
            self._tell(f"{ONLY} {self.taken}")

    def _wait(self, kernel: Any, types: tuple[Any, ...]) -> None:
        from ..kernels.listed import line_of

        try:
            line = line_of(kernel, types)
        except ValueError:  # on no list
            return
        self._tell(f"{WITHOUT} {line}")
        while self._now == line and self.running():
            time.sleep(0.005)


def beside() -> Beside | None:
    """Start a process that compiles; None where none can be started."""
    if not sys.executable:
        return None
    try:
        return Beside()
    except OSError:
        return None


def _sweep(pid: int) -> None:
    """Remove what a process that was ended had begun to write into the cache."""
    from ..kernels.cache import cache_folder, unfinished

    if (folder := cache_folder()) is not None:
        for path in unfinished(folder, pid):
            with suppress(OSError):
                path.unlink()


def lists_for(slug: str) -> tuple[str, ...]:
    """Return which lists a command needs that grows by a method, or chooses one: most often the first of these two."""
    return ("auto", "auto-graphcut") if slug == "auto" else (slug,)


def worth_it(slug: str) -> bool:
    """Tell whether so many kernels are needed that a second process helps: it takes a second to start."""
    return sum(len(lists().get(name, ())) for name in lists_for(slug)) > FEW


def as_json(found: dict[str, list[str]]) -> str:
    """Write lists as `kernels.json` holds them."""
    kernels = sorted({line for lines in found.values() for line in lines})
    number = {line: n for n, line in enumerate(kernels)}
    kept: dict[str, Any] = {"kernels": kernels, "lists": {}}
    text = json.dumps(kept["kernels"], indent=1)
    rows = ",\n  ".join(f"{json.dumps(name)}: {[number[line] for line in lines]}" for name, lines in found.items())
    return f'{{"kernels": {text},\n "lists": {{\n  {rows}\n }}}}\n'
