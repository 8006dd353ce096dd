"""The timings of Multrus 2003, its sizes and parameters: what ``make bench`` measures of them.

    python benchmarks/bench.py --only source-000     measure these alone; all of ``make bench`` measures them, too
    python benchmarks/source_000.py                  the tables of docs/sources-000.md, from bench/results.json

CPU seconds of one thread, rendering included, kernels compiled beforehand, and the same in R: the CPU time of
100 x ``scipy.fft.rfft2`` of 512 x 512 float32, measured in the same run.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

import intarsia as ia
from bench import ONE, RESULTS, Result, in_r

SLOW = 0.2  # s; what takes longer is measured once
TREE = "Multrus 2003, pixels, window 9x3: distance of neighbourhoods, tree over exact"
AS_THERE = {"repetition": "none", "search": "exact"}
PIXELS = {"window": (3, 9), "matching": "exact"}
ALIKE = {"boundary_patch": 0, "boundary_isometries": "none", "boundary_tolerance": 10_000, "boundary_join": "same"}
"""What painting adds to the source, off."""
QUIET = ("patch", "overlap", "window", "avoid", "weight", *ALIKE)  # parameters that the table tells otherwise


@dataclass(frozen=True)
class Task:
    """One row of the source's timings: exemplar and output side (px), colour or gray, its seconds, parameters."""

    side: int
    size: int | tuple[int, int]
    colour: bool
    seconds: str
    parameters: dict[str, Any] = field(default_factory=dict)
    what: str = ""  # "extend" or "paint" where it is neither patches nor pixels on an empty canvas

    @property
    def sizes(self) -> tuple[str, str]:
        """Exemplar and output, as the table has them."""
        high, wide = (self.size, self.size) if isinstance(self.size, int) else self.size
        return f"{self.side}x{self.side}", f"{wide}x{high}"

    @property
    def reported(self) -> str:
        """What was set."""
        p = self.parameters
        shown = [
            f"{p['patch']}/{p['overlap']}" if "patch" in p else f"pixels, window {p['window'][1]}x{p['window'][0]}"
        ]
        shown += ["colour" if self.colour else "gray"]
        shown += [f"{k} {v}" for k, v in p.items() if k not in QUIET]
        shown += ["avoid"] * bool(p.get("avoid")) + [self.what] * bool(self.what)
        if self.what == "paint":
            shown += [f"weight {p['weight']:g}"] + ["our boundaries"] * ("boundary_patch" not in p)
        return ", ".join(shown).replace("_", " ")

    @property
    def name(self) -> str:
        """The name of its line in the results."""
        return f"Multrus 2003, {self.sizes[1]} from {self.sizes[0]}: {self.reported}"


SEAM5 = {"patch": 25, "overlap": 5}
SEAM4 = {"patch": 7, "overlap": 4}
TASKS = (
    Task(128, 200, False, "> 2100", PIXELS | {"window": (3, 7)}),
    Task(128, 200, False, "2780", PIXELS),
    Task(192, 200, False, "6447; 6488", PIXELS),
    Task(192, 200, False, "-", PIXELS | {"matching": "tree"}),
    Task(128, 200, False, "10", SEAM5),
    Task(192, 200, False, "32; 33", SEAM5),
    Task(192, 200, True, "64", {"patch": 40, "overlap": 5}),
    Task(192, 200, True, "57", {"patch": 35, "overlap": 5}),
    Task(192, 200, True, "83", SEAM5),
    Task(192, 200, True, "88", {"patch": 20, "overlap": 5}),
    Task(200, 200, True, "93", SEAM5),
    Task(300, 200, True, "128 (228?)", SEAM5),
    Task(400, 200, True, "440", SEAM5),
    Task(500, 200, True, "716", SEAM5),
    *(
        Task(150, (150, 300), False, t, SEAM5 | {"isometries": k, "candidates": 2}, "extend")
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
    Task(200, 200, False, "1.0", SEAM5 | {"pyramid": "mean", "pyramid_draws": "every"}),
    Task(200, 200, False, "-", SEAM5 | {"pyramid": "mean"}),
    Task(200, 200, True, "2.8 to 2.9", SEAM5 | {"pyramid": "mean", "pyramid_draws": "every"}),
    Task(200, 200, True, "-", SEAM5 | {"pyramid": "mean"}),
    Task(500, 200, True, "-", SEAM5 | {"pyramid": "mean", "pyramid_draws": "every"}),
    Task(500, 200, True, "-", SEAM5 | {"search": "fast"}),
    *(
        Task(256, 1024, True, "-", SEAM5 | {"repetition": "prices"} | search)
        for search in (
            {"search": "fast"},
            {"search": "exact"},
            {"pyramid": "mean", "pyramid_draws": "every"},
            {"pyramid": "mean"},
        )
    ),
    Task(300, 300, False, "243", SEAM5 | {"avoid": True}),
    *(
        Task(150, 150, False, t, SEAM4 | ALIKE | {"isometries": "both", "weight": w}, "paint")
        for w, t in ((0.5, "50"), (1, "51"), (2, "50"), (3, "49"), (5, "51"))
    ),
    Task(
        300,
        300,
        True,
        "35",
        SEAM5 | ALIKE | {"isometries": "both", "weight": 1, "pyramid": "mean", "pyramid_draws": "every"},
        "paint",
    ),
    Task(
        300,
        300,
        False,
        "598",
        {"patch": 10, "overlap": 5, "isometries": "both", "boundary_candidates": 2, "weight": 2} | ALIKE,
        "paint",
    ),
    *(
        Task(256, 256, False, t, SEAM4 | ALIKE | {"isometries": "both", "weight": w}, "paint")
        for w, t in ((1.5, "559"), (0, "560"))
    ),
    Task(256, 256, False, "-", SEAM4 | {"weight": 1.5}, "paint"),
)


@cache
def picture(name: str = "stones") -> np.ndarray:
    """A built-in exemplar, painted once; mirrored to 512x512 px where it is smaller."""
    found = np.atleast_3d(np.asarray(ia.read(f"sample:{name}").base))[:512, :512, :3]
    rows, columns = (512 - n for n in found.shape[:2])
    return np.pad(found, ((0, rows), (0, columns), (0, 0)), mode="symmetric")


def exemplar(task: Task) -> ia.Exemplar:
    """A square of a built-in exemplar, of which nothing is known yet; a corner is masked where pixels are avoided."""
    pixels = picture()[: task.side, : task.side]
    pixels = pixels if task.colour else pixels[:, :, 1]
    usable = None
    if task.parameters.get("avoid"):
        usable = np.ones(pixels.shape[:2], bool)
        usable[:40, :40] = False
    if task.what == "paint":
        other = picture("gravel")[: task.side, : task.side]
        marks = halves(task.side)
        pixels = np.where(marks[:, :, None], other, pixels) if task.colour else np.where(marks, other[:, :, 0], pixels)
    return ia.Exemplar.of(np.ascontiguousarray(pixels), usable=usable)


def halves(side: int) -> np.ndarray:
    """Two labels, one beside the other along a waving line."""
    y, x = np.mgrid[:side, :side]
    return np.asarray(x > side / 2 + side / 20 * np.sin(y / 12))


def guide(task: Task) -> ia.Guide | None:
    """For painting: a disc of the one label in the other."""
    if task.what != "paint":
        return None
    y, x = np.mgrid[: task.side, : task.side] - task.side / 2
    marks = (halves(task.side), y * y + x * x < (task.side / 3) ** 2)
    source, target = (ia.Plane(m.astype(np.uint8), ia.Kind.LABEL) for m in marks)
    return ia.Guide(source, target, weight=float(task.parameters["weight"]))


def start_of(task: Task, e: ia.Exemplar) -> ia.SourceMap | None:
    """For extending: the exemplar at the left, holes at the right."""
    if task.what != "extend" or isinstance(task.size, int):
        return None
    yx = np.zeros((*task.size, 2), np.int32)
    yx[:, : task.side] = np.stack(np.mgrid[: task.side, : task.side], axis=2)
    which = np.full(task.size, 255, np.uint8)
    which[:, : task.side] = 0
    return ia.SourceMap(yx, which, None, (e.source,))


def work_of(task: Task) -> Callable[[], object]:
    """What is to be measured."""
    values = {k: v for k, v in task.parameters.items() if k not in ("avoid", "weight")}
    method = ia.WeiLevoy(**values) if "window" in values else ia.PatchSampling(**(AS_THERE | values))
    e, marks = exemplar(task), guide(task)

    def work() -> object:
        fresh = ia.Exemplar(e.planes, e.usable)  # nothing known of it beforehand
        begin = start_of(task, fresh)
        return ia.synthesize(fresh, task.size, method, start=begin, guide=marks, run=ONE).render(run=ONE)

    return work


def measured() -> Iterator[Result]:
    """Measure every row; slow ones once, quick ones five times, each until it takes a twentieth of a second."""
    for task in TASKS:
        work = work_of(task)
        work()  # compiles
        ratio, seconds = in_r(work, 1, 1)
        if seconds < SLOW:
            ratio, seconds = in_r(work, max(1, int(0.05 / seconds)))
        yield Result(task.name, ratio, "R", None, f"{1000 * seconds:.3g} ms; there: {task.seconds} s", seconds)

    yield Result(TREE, tree_over_exact(), "x", None)


def tree_over_exact() -> float:
    """How much farther the neighbourhoods that the tree finds are than those of the exact search, squared."""
    made = (
        ia.synthesize(np.ascontiguousarray(picture()[:128, :128]), 200, ia.WeiLevoy(window=(3, 9), matching=m), run=ONE)
        for m in ("tree", "exact")
    )
    tree, exact = (far(out) for out in made)
    return tree / exact


def far(out: ia.Synthesis) -> float:
    """Mean squared difference of the pixels above and before each output pixel and those of where it comes from."""
    shown, exemplar = (np.asarray(p).astype(np.int64) for p in (out.render(feather=0), out.exemplars[0].base))
    yx, total = out.map.yx[3:-3, 5:-5].astype(np.int64), 0.0
    inside = (yx >= (2, 4)).all(axis=2) & (yx[:, :, 1] < exemplar.shape[1] - 4)
    for dy, dx in [(-y, x) for y in (1, 2) for x in range(-4, 5)] + [(0, -x) for x in range(1, 5)]:
        here = shown[3 + dy : shown.shape[0] - 3 + dy, 5 + dx : shown.shape[1] - 5 + dx][inside]
        total += float(((here - exemplar[yx[inside][:, 0] + dy, yx[inside][:, 1] + dx]) ** 2).mean())
    return total


def table(results: list[Result]) -> str:
    """The source's timings beside ours."""
    known = {r.name: r for r in results}
    lines = ["| exemplar | output | parameters | source, s | ours, s | ours, R |", "|---|---|---|---|---|---|"]
    for task in TASKS:
        r = known.get(task.name)
        ours = "not measured | " if r is None or r.seconds is None else f"{r.seconds:.3f} | {r.value:.2f}"
        lines.append(f"| {' | '.join(task.sizes)} | {task.reported} | {task.seconds} | {ours} |")
    tree = known.get(TREE)
    if tree is not None:
        lines += [
            "",
            f"Mean squared distance of neighbourhoods of the pixel method, tree over exact: {tree.value:.2f}.",
        ]
    return "\n".join(lines)


def main() -> None:
    """Print the table of what was measured last."""
    if not RESULTS.exists():
        raise SystemExit(f"{RESULTS} is not there; make it with: python benchmarks/bench.py --only source-000")
    print(table([Result(**r) for r in json.loads(RESULTS.read_text())["results"]]))


if __name__ == "__main__":
    main()
