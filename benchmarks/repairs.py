"""What a repair does: seams, repeats and time before and after, over ten textures of several classes.

    python benchmarks/repairs.py FOLDER [PASSES ...]

FOLDER holds the pictures named in TEXTURES. Measures, each relative to the map as it was grown:

* seams: what all seams cost, as cuts price them; worst: what the dearest tenth of the places costs (the middle halves
  of the windows that a repair looks at, every 8 px; the same places before and after).
* score: the total by which `--trials` chooses (docs/score.md).
* repeat: median distance of an output pixel to the next one that shows the same exemplar pixel, px.
* time: CPU time of the repair over that of growing.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from better import TEXTURES, repeats

import intarsia as ia
from intarsia.judging import score_map
from intarsia.seams.repair import SeamRefinement
from intarsia.synthesis import Synthesis
from intarsia.tasks.repair import repair_of

SIDE, SEEDS, ONE = 512, (1, 2), ia.Run(1)
METHODS = (ia.ImageQuilting(), ia.PatchSampling())
NAMES = ("seams", "worst", "score", "repeat", "time")


def places(made: Synthesis) -> np.ndarray[Any, Any]:
    """What the seams in the middle of every window cost."""
    canvas = made.canvas
    assert canvas is not None
    return SeamRefinement(repair_of(made.method, made.exemplars, 1), made.exemplars, canvas, made.map).worst.scores()


def clocked(work: Any) -> tuple[Any, float]:
    began = time.process_time()
    done = work()
    return done, time.process_time() - began


def row(path: Path, method: Any, passes: int, seed: int) -> list[float]:
    """The measures of one texture, each after the repair over before."""
    exemplar = ia.read(path)
    made, grew = clocked(lambda: ia.synthesize(exemplar, SIDE, method, seed=seed, run=ONE))
    out, took = clocked(lambda: ia.repair(made, passes, run=ONE))
    before, after = places(made), places(out)
    worst = np.argsort(-before, axis=None, kind="stable")[: before.size // 10]
    totals = [score_map(made.exemplars, m.map).total for m in (out, made)]
    near = [float(np.median(repeats(m.map))) for m in (out, made)]
    return [after.sum() / before.sum(), after.flat[worst].sum() / before.flat[worst].sum(), totals[0] / totals[1],
            near[0] / near[1], took / grew]  # fmt: skip


def main() -> None:
    folder, passes = Path(sys.argv[1]), [int(n) for n in sys.argv[2:]] or [4]
    for method in METHODS:
        ia.repair(ia.synthesize(ia.read(folder / f"{TEXTURES[0]}.png"), 200, method, run=ONE), 1, run=ONE)  # compiles
        for number in passes:
            print(f"\n{method.slug}, {number} passes\n{'':36}" + "".join(f"{n:>8}" for n in NAMES))
            rows = []
            for name in TEXTURES:
                rows.append(np.mean([row(folder / f"{name}.png", method, number, s) for s in SEEDS], axis=0))
                print(f"{name:36}" + "".join(f"{v:8.2f}" for v in rows[-1]), flush=True)
            print(f"{'mean':36}" + "".join(f"{v:8.2f}" for v in np.mean(rows, axis=0)))


if __name__ == "__main__":
    main()
