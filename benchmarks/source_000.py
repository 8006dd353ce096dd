"""Repeat the timings of Multrus 2003 (source 000): ``python benchmarks/source_000.py``.

The same sizes and parameters. CPU seconds of one thread, rendering included, kernels compiled beforehand, and the
same in R: the CPU time of 100 x ``scipy.fft.rfft2`` of 512 x 512 float32, measured in the same run. Prints the table
of docs/sources-000.md.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from bench import ONE, in_r

import intarsia as ia


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


def exemplar(task: Task) -> ia.Exemplar:
    """A square of a built-in exemplar, mirrored where it is too small; a corner is masked where pixels are avoided."""
    pixels = np.asarray(ia.read("sample:stones").base)[:, :, :3]
    pixels = np.pad(pixels, ((0, 256), (0, 256), (0, 0)), mode="symmetric")[: task.side, : task.side]
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
    main()
