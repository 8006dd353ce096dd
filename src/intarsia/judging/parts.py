"""The parts of a score: what is measured of an output, in which unit, and what the ends of its scale are.

Every part is 1 for an output as good as a true continuation of the exemplar, and 0 for one of squares laid side by side
without looking, or what the table names in place of it. Whatever is measured is a ratio of sums of whole numbers.

Sources: patches both ways, Simakov et al. 2008 (Summarizing visual data using bidirectional similarity, section 3);
pieces and where they meet, Ashikhmin 2001 (section 3) and Kwatra et al. 2003 (section 3.1); the scales are our own.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..analysis.sums import window_sums
from ..arrays import Array
from .reference import Level, Reference
from .sources import STEP, Sources
from .windows import nearest, smaller


class Part(NamedTuple):
    """One part of a score: its name, its unit, what it means, its weight in the total, and its anchors.

    ``good`` is what a true continuation measures; ``bad`` what is worth nothing, None: what tiles of the exemplar
    measure, which is held at least ``least`` away. ``grainy`` parts are seen as far as the exemplar does not repeat.
    """

    name: str
    unit: str
    says: str
    weight: float
    good: float
    bad: float | None
    least: float = 1.0
    grainy: bool = False


# fmt: off
PARTS = (
    Part("joins", "%", "what changes where pieces meet, of what any two windows differ by", 0.23, 0.0, None),
    Part("steps", "%", "what slow tone changes where pieces meet, of what any two tones differ by", 0.24, 0.0, None),
    Part("overused", "times", "how often the most used 2 % are shown, of the mean", 0.27, 1.0, 6.0, grainy=True),
    Part("striking", "times", "how often the most striking spots are shown, of their share", 0.08, 1.0, 4.0),
    Part("strange", "%", "windows farther from the exemplar than nine of ten of its own", 0.07, 10.0, 100.0),
    Part("blurred", "%", "by how much steps between neighbours are smaller", 0.11, 0.0, 50.0),
    Part("lost", "%", "windows of the exemplar as far from the output", 0.0, 10.0, 100.0),
    Part("unused", "%", "places of the exemplar that are hardly shown", 0.0, 0.0, 100.0),
    Part("tone", "%", "by how much slow tones differ, of the exemplar's range of them", 0.0, 0.0, 50.0),
)
# fmt: on


def measured(reference: Reference, picture: NDArray[np.int16]) -> dict[str, float]:
    """Measure all parts of an output picture (H, W, C), in the features of its exemplars."""
    levels = [level for level in reference.levels if min(picture.shape[:2]) >= level.least_side]
    every = [Sources.of(level, picture) for level in levels]
    sources = every[:2]
    return {
        "joins": _mean([100 / 1024 * float(s.changes.mean()) for s in sources]),
        "steps": _mean([100 / 1024 * float(s.steps.mean()) for s in every[1:]]),
        "overused": _mean([_overused(s) for s in sources], 1.0),
        "striking": _mean([_striking(reference, s, picture.shape[0] * picture.shape[1]) for s in sources]),
        "strange": _mean([_above(s.distance, s.level) for s in sources]),
        "lost": _mean([_above(_lost(s.level, picture), s.level) for s in sources]),
        "unused": _mean([_unused(s) for s in sources]),
        "blurred": _blurred(reference, picture),
        "tone": _tone(reference, picture),
    }


def _mean(values: list[float], nothing: float = 0.0) -> float:
    return sum(values) / len(values) if values else nothing


def _above(distance: Array, level: Level) -> float:
    """The share of distances that one of ten of the exemplar's own exceeds, in percent."""
    return 100 * int((distance > level.strange).sum()) / max(distance.size, 1)


def _lost(level: Level, picture: Array) -> Array:
    """How far windows of the exemplar are from the nearest of the output."""
    waves = level.windows.cut(picture, STEP // 2)
    waves = waves.reshape(-1, waves.shape[2])
    return nearest(level.windows.waves[level.asked], waves, (waves * waves).sum(axis=1))[0]


def _local(sources: Sources) -> tuple[Array, float]:
    """How often every square, a twelfth of the exemplar wide, is shown, and how often one would be on average."""
    table = sources.level.windows.table
    side = max(3, min(table.shape) // 12)
    if min(table.shape) < side:
        return np.zeros(0, np.int64), 1.0
    size = (side, side)
    shown, there = window_sums(sources.usage, size), window_sums((table >= 0).astype(np.int64), size)
    whole = shown[there == side * side]
    return whole, float(whole.sum()) / max(whole.size, 1)


def _overused(sources: Sources) -> float:
    """How often the place is shown that 2 % are shown more often than, by the mean."""
    shown, mean = _local(sources)
    return float(np.sort(shown)[shown.size * 98 // 100]) / mean if shown.size and mean else 1.0


def _striking(reference: Reference, sources: Sources, area: int) -> float:
    """How often the striking spots are shown on average, of as often as the areas say."""
    there = sum(p.shape[0] * p.shape[1] for p in reference.pictures)
    returns = sources.returns
    return float(sum(returns) * there / (len(returns) * area)) if returns else 1.0


def _unused(sources: Sources) -> float:
    """The share of places that are shown less than a seventh as often as on average, in percent."""
    shown, mean = _local(sources)
    return 100 * int((7 * shown < mean).sum()) / shown.size if shown.size else 0.0


def mean_step(pictures: Sequence[Array], usable: Sequence[NDArray[np.bool_] | None]) -> float:
    """Return the mean step between neighbours, summed over channels; only where both may be used."""
    total = count = 0
    for p, free in zip(pictures, usable, strict=True):
        wide = p.astype(np.int32)
        for axis in (0, 1):
            steps = np.abs(np.diff(wide, axis=axis)).sum(axis=2)
            if free is not None:
                ends = (np.take(free, range(k, free.shape[axis] - 1 + k), axis) for k in (0, 1))
                steps = steps[np.logical_and(*ends)]
            total, count = total + int(steps.sum()), count + steps.size
    return total / max(count, 1)


def _blurred(reference: Reference, picture: Array) -> float:
    usual = mean_step(reference.pictures, reference.usable)
    return max(0.0, 100 * (1 - mean_step((picture,), (None,)) / usual)) if usual else 0.0


def _tone(reference: Reference, picture: Array) -> float:
    """By how much the sorted means of squares of 16 px differ, of the spread of the exemplar's."""
    block = 16
    mine = smaller(picture, block).reshape(-1, picture.shape[2])
    theirs = np.concatenate([smaller(p, block).reshape(-1, p.shape[2]) for p in reference.pictures])
    if not len(mine) or not len(theirs):
        return 0.0
    share = np.arange(2, 99, 4)
    a, b = (np.sort(x, axis=0)[share * (len(x) - 1) // 100] for x in (mine, theirs))
    spread = int((b[-1] - b[0]).sum())
    return 100 * float(np.abs(a - b).sum()) / len(share) / spread if spread else 0.0
