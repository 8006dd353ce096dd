"""Wall times of two threads against one, of what takes longest.

    python benchmarks/two_threads.py    prints the rows; `make bench` has them among the others

They mean something only while nobody else works on the machine; where somebody does nothing is told.
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable
from typing import Any

import intarsia as ia
from bench import IDLE, REPEATS, Result, pixels, table

LEAST = 1 / 1.7  # of one thread's wall time


def ratio(work: Callable[[ia.Run], object]) -> float | None:
    """Return the wall time of two threads relative to one; none where others took the processor meanwhile."""
    pairs = []
    for _ in range(REPEATS + 1):
        walls = []
        for threads in (1, 2):
            begin, cpu = time.perf_counter(), time.process_time()
            work(ia.Run(threads=threads))
            walls.append(time.perf_counter() - begin)
            if threads == 1 and pairs and walls[0] > 1.15 * (time.process_time() - cpu):
                return None
        pairs.append(walls[1] / walls[0])
    return statistics.median(pairs[1:])


def cases() -> dict[str, Callable[[ia.Run], object]]:
    """The six: one for each way to grow."""
    stones, tiles = ia.Exemplar.of(pixels()), ia.Exemplar.of(pixels("tiles"))
    lattice = ((64.22, -0.14), (0.07, 63.82))

    def grown(exemplar: ia.Exemplar, method: Any, side: int = 1024) -> Callable[[ia.Run], object]:
        return lambda run: ia.synthesize(exemplar, side, method, seed=1, run=run).render(run=run)

    return {
        "image quilting, patch 40, overlap 10": grown(stones, ia.ImageQuilting(patch=40, overlap=10)),
        "patch sampling, patch 25, overlap 5": grown(stones, ia.PatchSampling(patch=25, overlap=5)),
        "near-regular, lattice known": grown(tiles, ia.NearRegular(lattice=lattice)),
        "parallel-controllable": grown(stones, ia.ParallelControllable()),
        "parallel-controllable, turned by 30 degrees": grown(stones, ia.ParallelControllable(angle=30)),
        "graph cut, to 512x512": grown(stones, ia.Graphcut(), 512),
    }


def measured() -> list[Result]:
    """Measure all rows, if nobody else is at work."""
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 1.0
    idle, rows = load < IDLE and (os.cpu_count() or 1) > 1, []
    for name, work in cases().items():
        found = ratio(work) if idle else None
        note = "" if found is not None else f"load {load:.1f}" if not idle else "others at work"
        rows.append(Result(f"two threads: wall, relative to one, {name}", found, "x", LEAST, note))
    return rows


if __name__ == "__main__":
    print(table(measured()))
