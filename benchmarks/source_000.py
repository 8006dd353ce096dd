"""Repeat the timings of Multrus 2003 (source 000): ``python benchmarks/source_000.py``.

The same sizes and parameters. CPU seconds of one thread, rendering included, kernels compiled beforehand, and the
same in R: the CPU time of 100 x ``scipy.fft.rfft2`` of 512 x 512 float32, measured in the same run. Prints the tables
of docs/sources-000.md: the source's timings, then (``speeds``: these alone) what must be fast, the least of some runs.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

import intarsia as ia
from bench import ONE, in_r


@dataclass(frozen=True)
class Task:
    """One row of the source's timings: exemplar and output side (px), colour or gray, parameters, its seconds."""

    side: int
    size: int | tuple[int, int]
    colour: bool
    seconds: str
    parameters: dict[str, Any] = field(default_factory=dict)
    extend: bool = False


SEAM5 = {"patch": 25, "overlap": 5}
TASKS = (
    Task(128, 200, False, "10", SEAM5),
    Task(192, 200, False, "32; 33", SEAM5),
    Task(192, 200, True, "64", {"patch": 40, "overlap": 5}),
    Task(192, 200, True, "57", {"patch": 35, "overlap": 5}),
    Task(192, 200, True, "83", SEAM5),
    Task(192, 200, True, "88", {"patch": 20, "overlap": 5}),
    Task(200, 200, True, "93", SEAM5),
    Task(300, 200, True, "128 (B-01)", SEAM5),
    Task(400, 200, True, "440", SEAM5),
    Task(500, 200, True, "716", SEAM5),
    *(
        Task(150, (150, 300), False, t, SEAM5 | {"isometries": k, "candidates": 2}, True)
        for k, t in (("none", "9"), ("180", "23"), ("90", "30"), ("both", "45"))
    ),
    *(
        Task(150, 200, False, t, SEAM5 | {"isometries": k})
        for k, t in (("none", "17"), ("180", "46; 43"), ("90", "57"), ("both", "83; 84"))
    ),
    Task(200, 300, False, "73; 72", SEAM5 | {"candidates": 1}),
    Task(200, 300, False, "73", SEAM5 | {"candidates": 1, "repetition": "counter"}),
    Task(200, 300, True, "183", SEAM5 | {"candidates": 1}),
    Task(200, 300, True, "182", SEAM5 | {"candidates": 1, "repetition": "counter"}),
    Task(150, 300, False, "34", SEAM5 | {"candidates": 1, "repetition": "counter"}),
    Task(200, 200, False, "1.0", SEAM5 | {"search": "pyramid", "pyramid_kept": 1}),
    Task(200, 200, False, "-", SEAM5 | {"search": "pyramid"}),
    Task(200, 200, True, "2.8 to 2.9", SEAM5 | {"search": "pyramid", "pyramid_kept": 1}),
    Task(200, 200, True, "-", SEAM5 | {"search": "pyramid"}),
    Task(500, 200, True, "-", SEAM5 | {"search": "pyramid", "pyramid_kept": 1}),
    Task(500, 200, True, "-", SEAM5 | {"search": "fast"}),
    Task(300, 300, False, "243", SEAM5 | {"avoid": True}),
)


@cache
def stones() -> np.ndarray:
    """The built-in exemplar, painted once."""
    return np.asarray(ia.read("sample:stones").base)[:, :, :3]


def exemplar(task: Task) -> ia.Exemplar:
    """A square of a built-in exemplar, mirrored where it is too small; a corner is masked where pixels are avoided."""
    pixels = np.pad(stones(), ((0, 256), (0, 256), (0, 0)), mode="symmetric")[: task.side, : task.side]
    usable = np.ones(pixels.shape[:2], bool)
    if task.parameters.get("avoid"):
        usable[:40, :40] = False
    return ia.Exemplar.of(np.ascontiguousarray(pixels if task.colour else pixels[:, :, 1]), usable=usable)


def start_of(task: Task, e: ia.Exemplar) -> ia.SourceMap | None:
    """For extending: the exemplar at the left, holes at the right."""
    if not task.extend or isinstance(task.size, int):
        return None
    yx = np.zeros((*task.size, 2), np.int32)
    yx[:, : task.side] = np.stack(np.mgrid[: task.side, : task.side], axis=2)
    which = np.full(task.size, 255, np.uint8)
    which[:, : task.side] = 0
    return ia.SourceMap(yx, which, None, (e.source,))


def square(side: int, colour: bool = True) -> ia.Exemplar:
    """A square of a built-in exemplar, of which nothing is known yet."""
    pixels = stones()[:side, :side]
    return ia.Exemplar.of(np.ascontiguousarray(pixels if colour else pixels[:, :, 1]))


def healed() -> ia.Synthesis:
    """A hole of 128x128 px in 256x256 px, healed."""
    hole = np.zeros((256, 256), bool)
    hole[64:192, 64:192] = True
    return ia.heal(square(256), hole, run=ONE)


def grown(side: int, size: int, method: Any, colour: bool = True) -> ia.Synthesis:
    """Grow one square from another."""
    return ia.synthesize(square(side, colour), size, method, run=ONE)


EXACT = {"repetition": "none", "search": "exact"}
SPEEDS: tuple[tuple[str, float, Any], ...] = (
    ("patch sampling 25/5, 200 to 200 px", 2, lambda: grown(200, 200, ia.PatchSampling(**SEAM5, **EXACT))),
    ("patch sampling 25/5, 256 to 1024 px, exact", 12, lambda: grown(256, 1024, ia.PatchSampling(**SEAM5, **EXACT))),
    ("the same, search fast", 12, lambda: grown(256, 1024, ia.PatchSampling(**SEAM5))),
    ("Efros-Leung, window 11, 64 to 128 px, gray", 65, lambda: grown(64, 128, ia.EfrosLeung(window=11), False)),
    ("Efros-Leung, window 11, 64 to 128 px", 65, lambda: grown(64, 128, ia.EfrosLeung(window=11))),
    ("Wei-Levoy 9x3, 128 to 200 px, exact", 60, lambda: grown(128, 200, ia.WeiLevoy(window=(3, 9), matching="exact"))),
    ("Wei-Levoy 9x3, 128 to 200 px, tree", 12, lambda: grown(128, 200, ia.WeiLevoy(window=(3, 9)))),
    ("healing a hole of 128x128 px in 256x256 px", 8, healed),
)


def speeds() -> None:
    """Print what must be fast: the least of five runs, in R."""
    print("| case | R | at most |\n|---|---|---|")
    made = {}
    for name, limit, work in SPEEDS:
        made[name] = work()
        least = min(in_r(work, 1, 1)[0] for _ in range(5 if limit < 20 else 3))
        print(f"| {name} | {least:.2f} | {limit:g} |", flush=True)
    exact, tree = (far(out) for name, out in made.items() if name.startswith("Wei-Levoy"))
    print(f"\nMean distance of neighbourhoods, tree over exact: {tree / exact:.3f}")


def far(out: ia.Synthesis) -> float:
    """Mean squared difference of the pixels above and before each output pixel and those of where it comes from."""
    shown, exemplar = (np.asarray(p).astype(np.int64) for p in (out.render(feather=0), out.exemplars[0].base))
    yx, total = out.map.yx[3:-3, 5:-5].astype(np.int64), 0.0
    inside = (yx >= (2, 4)).all(axis=2) & (yx[:, :, 1] < exemplar.shape[1] - 4)
    for dy, dx in [(-y, x) for y in (1, 2) for x in range(-4, 5)] + [(0, -x) for x in range(1, 5)]:
        here = shown[3 + dy : shown.shape[0] - 3 + dy, 5 + dx : shown.shape[1] - 5 + dx][inside]
        total += float(((here - exemplar[yx[inside][:, 0] + dy, yx[inside][:, 1] + dx]) ** 2).mean())
    return total


def main() -> None:
    """Print one line for each task."""
    print("| exemplar | output | parameters | source, s | ours, s | ours, R |")
    print("|---|---|---|---|---|---|")
    for task in TASKS:
        values = {"repetition": "none", "search": "exact"} | task.parameters
        values.pop("avoid", None)
        method, e = ia.PatchSampling(**values), exemplar(task)
        start = start_of(task, e)

        def work(method: Any = method, task: Task = task, e: Any = e, start: Any = start) -> object:
            fresh = ia.Exemplar(e.planes, e.usable)  # nothing known of it beforehand
            begin = None if start is None else ia.SourceMap(start.yx, start.which, None, (fresh.source,))
            return ia.synthesize(fresh, task.size, method, start=begin, run=ONE).render(run=ONE)

        ratio, seconds = in_r(work, 3)
        size = f"{task.size}x{task.size}" if isinstance(task.size, int) else f"{task.size[1]}x{task.size[0]}"
        shown = [f"{values['patch']}/{values['overlap']}", "colour" if task.colour else "gray"]
        shown += [f"{k} {v}" for k, v in task.parameters.items() if k not in ("patch", "overlap", "avoid")]
        shown += ["avoid"] * bool(task.parameters.get("avoid")) + ["extend"] * task.extend
        what = ", ".join(shown).replace("_", " ")
        ours = f"{task.seconds} | {seconds:.3f} | {ratio:.2f}"
        print(f"| {task.side}x{task.side} | {size} | {what} | {ours} |", flush=True)


if __name__ == "__main__":
    if "speeds" not in sys.argv:
        main()
        print()
    speeds()
