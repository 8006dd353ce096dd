"""What more cores would give: what threads share is timed piece by piece, and laid out on as many cores.

    python benchmarks/more_cores.py                    2, 4 and 8 cores, pebbles to 512, 1024 and 2048 px
    python benchmarks/more_cores.py sample:brick 512   another exemplar, one size

A whole `intarsia grow`, start and imports included, in CPU seconds of one thread: pieces that threads would share are
done one after another, as large as they are with so many threads, and the time of each is noted. Then each lot of
them is laid out on so many cores, each piece on the one that is free first, as threads take them; all else takes as
long as it took. A wake of threads costs WAKE. What cores share, memory and the interpreter's lock, is not in it.
"""

from __future__ import annotations

import heapq
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

CORES = (2, 4, 8)
SIZES = (512, 1024, 2048)
WAKE = 50e-6  # s: what it takes until the first of those that wait is at work


def makespan(pieces: list[float], cores: int) -> float:
    """Return how long pieces take that are taken in their order by so many cores, each as soon as one is free."""
    free = [0.0] * cores
    for piece in pieces:
        heapq.heapreplace(free, free[0] + piece)
    return max(free) + (WAKE if len(pieces) > 1 else 0.0)


class Pools:
    """Pools that do all themselves, and add up what so many cores would have saved."""

    def __init__(self, cores: int) -> None:
        self.cores, self.saved = cores, [0.0]  # s: in all, and within each piece that is being done

    def each(self, function: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
        """Do what a pool does, one piece after another."""
        made, whole, alone = [], 0.0, list[float]()
        for item in items:
            self.saved.append(0.0)
            begin = time.process_time()
            made.append(function(item))
            took = time.process_time() - begin
            whole += took
            alone.append(took - self.saved.pop())
        self.saved[-1] += whole - makespan(alone, self.cores)
        return made

    @contextmanager
    def pool(self) -> Iterator[Callable[..., list[Any]]]:
        """Stand in for :meth:`intarsia.Run.pool`."""
        yield self.each


def once(exemplar: str, size: str, cores: str) -> None:
    """Grow in this process, and print the seconds on one core and on so many."""
    from click.testing import CliRunner

    from intarsia.cli import cli
    from intarsia.foundation.run import Run

    pools = Pools(int(cores))
    Run.pool = lambda _: pools.pool()  # type: ignore[method-assign]
    with TemporaryDirectory() as folder:
        words = ["grow", exemplar, "-o", str(Path(folder) / "o.png"), "--size", size, "--seed", "1", "--quiet"]
        done = CliRunner().invoke(cli, [*words, "--threads", cores], prog_name="intarsia")
    assert done.exit_code == 0, done.output
    whole = time.process_time()
    print(json.dumps([whole, whole - pools.saved[0]]))


def measured(exemplar: str, size: int, cores: int) -> tuple[float, float]:
    """Return the seconds on one core, and on so many, in a process that finds its kernels compiled."""
    command = [sys.executable, __file__, "--once", exemplar, str(size), str(cores)]
    env = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    runs = [json.loads(subprocess.run(command, check=True, capture_output=True, text=True, env=env).stdout)
            for _ in range(3 if size < 1024 else 2)]  # fmt: skip
    one, many = min(runs[1:])  # the first may have compiled
    return one, many


def main(words: list[str]) -> None:
    """Print a table."""
    exemplar = words[0] if words else "sample:pebbles"
    for size in map(int, words[1:]) if words[1:] else SIZES:
        for cores in CORES:
            one, many = measured(exemplar, size, cores)
            print(f"{exemplar} to {size} px, {cores} cores: {one:.2f} s to {many:.2f} s, {one / many:.2f} times")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--once"]:
        once(*sys.argv[2:])
    else:
        main(sys.argv[1:])
