"""The parts of the score: definitions, units, anchors, and how each is measured.

The normalised score of a part is 1 for an output as good as a true continuation of the exemplar. It is 0 at the bad
anchor: that in the table, or else the value of random squares of the exemplar placed side by side without matching. All
measurements are ratios of sums of integers.

Whether an output has the texture of its exemplar at all is measured on windows of every size as a product of three
numbers: the distance of windows to their nearest ones in the exemplar, relative to distances within the exemplar; the
share of neighbouring windows whose sources are not neighbours, too; the difference in mean and standard deviation of
the DCT coefficients of windows. A synthesised texture may show only a part of its exemplar, or be cut into small
pieces, and a plain texture finds matches in a rich exemplar: each of these is high in one or two of the numbers. Only
another texture is high in all three.

Sources: pieces and where they meet, Ashikhmin 2001 (section 3) and Kwatra et al. 2003 (section 3.1); statistics of
filter responses as a definition of texture, Heeger and Bergen 1995; the product, repeats and the anchors are our own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..analysis import window_sums
from ..foundation.arrays import Array, Int16, Mask
from ..foundation.filters import moving_sums
from .sources import NEXT, STEP, Reference, Sources, continued_sources
from .windows import SIDE, poses

# A single place of the exemplar may recur unseen; one that recurs with its surroundings is noticed. Of the measures on
# maps this one agreed most often with people on which of two outputs repeats itself. Unit: windows of the output, which
# are STEP (8) px from one another.
REACH = 25  # repeats are counted within so many windows, 200 px; within 128 px it agrees with people on fewer pairs
NEAR = 3  # nearer windows are not compared, as they overlap
AROUND = 2  # the surroundings of a window are so many on every side, 5 x 5; 3 x 3 and 7 x 7 agree as often
MOST = 14  # of the 5 x 5 windows that must have the same sources, over half
SAME = 2  # px of the reduced picture: sources at most so far from one another count as the same


class Part(NamedTuple):
    """One part of the score: name, unit, meaning, weight in the total, and anchors.

    ``good``: the value of a true continuation. ``bad``: the value at which the normalised score is 0; None for that of
    random tiles of the exemplar. It is at least ``least`` above ``good``. The loss of ``grainy`` parts is multiplied by
    the grain of the exemplar. ``says``: what is measured. ``flaw``: the word of the verdict if this part has the
    largest loss.
    """

    name: str
    unit: str
    says: str
    weight: float
    good: float
    bad: float | None
    least: float = 1.0
    grainy: bool = False
    flaw: str = ""


# fmt: off
TEXTURE = Part("texture", "%", "by how much it is another texture: not made of it, and not like it in all", 1.0,
               4.5, 5.0, flaw="unlikeness")
PARTS = (
    TEXTURE,
    Part("joins", "%", "what changes where pieces meet, of what any two windows differ by", 0.18, 0.0, None,
         flaw="cuts"),
    Part("steps", "%", "what slow tone changes where pieces meet, of what any two tones differ by", 0.09, 0.0, None,
         flaw="steps of tone"),
    Part("overused", "times", "how often the most used 2 % are shown, of the mean", 0.10, 1.0, 6.0, grainy=True,
         flaw="overuse of one place"),
    Part("salient", "times", "how often what strikes is shown, of the mean", 0.16, 1.0, 4.0, grainy=True,
         flaw="return of what strikes"),
    Part("repeats", "%", "windows shown again near by with what is around them", 0.25, 0.0, 100.0, grainy=True,
         flaw="repeats"),
    Part("lattice", "%", "by how much less it repeats by the periods of the exemplar", 0.13, 0.0, None, 20.0,
         flaw="slips of the rows"),
    Part("blurred", "%", "by how much steps between neighbours are smaller", 0.09, 0.0, 50.0, flaw="blur"),
)
# fmt: on


def sources_of(reference: Reference, picture: Int16) -> list[Sources]:
    """Return the sources of the windows of an output picture (H, W, C), for every size that fits."""
    return [Sources.of(level, picture) for level in reference.levels if min(picture.shape[:2]) >= level.least_side]


def measured(
    reference: Reference, picture: Int16, sources: Sequence[Sources], parts: Sequence[Part] = PARTS
) -> dict[str, float]:
    """Return the measured value of each part, by name, of an output (H, W, C) in the features of its exemplars.

    `sources`: those of its windows, by size, the smallest first. Joins and use are measured on the first two sizes.
    """
    every, sources = sources, sources[:2]
    how: dict[str, Callable[[], float]] = {
        "joins": lambda: _mean([100 / 1024 * float(s.join_costs.mean()) for s in sources]),
        "steps": lambda: _mean([100 / 1024 * float(s.steps.mean()) for s in every[1:]]),
        "overused": lambda: _mean([_overused(s) for s in sources], 1.0),
        "salient": lambda: _mean([_salient(reference, s) for s in sources[1:2]], 1.0),
        "blurred": lambda: _blurred(reference, picture),
        "repeats": lambda: _mean([100 * float(seen_again(reference, s).mean()) for s in sources[:1]]),
        "lattice": lambda: _lattice(reference, picture),
        TEXTURE.name: lambda: texture_distance(every, TEXTURE.good),
    }
    return {part.name: how[part.name]() for part in parts}


def _mean(values: list[float], nothing: float = 0.0) -> float:
    return sum(values) / len(values) if values else nothing


def square_side(table: Array) -> int:
    """Return the side, in windows of a table, of the squares whose use is counted: a twelfth of its shorter side."""
    return max(3, int(min(table.shape)) // 12)


def square_usage(table: Array, usage: Array) -> Array:
    """Return the sum of `usage` over every square of a table of windows; -1 for squares with gaps."""
    side = square_side(table)
    if min(table.shape) < side:
        return np.zeros((0, 0), np.int64)
    counts, there = (window_sums(a, (side, side)) for a in (usage, (table >= 0).astype(np.int64)))
    return np.where(there == side * side, counts, -1)


def _overused(sources: Sources) -> float:
    """Return the 98th percentile of the use of squares of `square_side`, relative to the mean."""
    every = square_usage(sources.level.windows.table, sources.usage)
    often = np.sort(every[every >= 0])
    mean = float(often.sum()) / max(often.size, 1)
    return float(often[often.size * 98 // 100]) / mean if mean else 1.0


def _salient(reference: Reference, sources: Sources) -> float:
    """Return the mean use of places, weighted by their saliency and use, relative to the mean use of all places."""
    windows, usage = sources.level.windows, sources.usage
    half = SIDE // 4 // windows.stride  # counted within half a window, as sources are inexact
    often = window_sums(np.pad(usage, half), (2 * half + 1,) * 2)
    weight = usage * windows.middles(reference.salient)
    mean = usage.sum() * (2 * half + 1) ** 2 / np.count_nonzero(windows.table >= 0)
    return float((weight * often).sum() / weight.sum() / mean) if weight.any() else 1.0


def seen_again(reference: Reference, sources: Sources) -> Mask:
    """Return a mask of the windows that recur with their surroundings within 3/4 of the exemplars' shorter side."""
    shorter = max(min(p.shape[:2]) for p in reference.pictures)
    return recurring_windows(sources, min(REACH, shorter * 3 // 4 // STEP))


def recurring_windows(sources: Sources, reach: int) -> Mask:
    """Return a mask of the windows that recur within `reach` windows together with most of the 5 x 5 around them."""
    windows = sources.level.windows
    at = (windows.at[sources.number] * windows.stride).astype(np.int16)
    y, x = (np.ascontiguousarray(at[..., k]) for k in (0, 1))
    rows, columns = y.shape
    out = np.zeros(y.shape, bool)
    for down in range(min(reach, rows - 1) + 1):
        for right in range(-min(reach, columns - 1), min(reach, columns - 1) + 1):
            if max(down, abs(right)) < NEAR or (down == 0 and right < 0):
                continue
            one = np.s_[down:, max(right, 0) : columns + min(right, 0)]
            other = np.s_[: rows - down, max(-right, 0) : columns - max(right, 0)]
            same = (np.abs(y[one] - y[other]) <= SAME) & (np.abs(x[one] - x[other]) <= SAME)
            if np.count_nonzero(same) >= MOST:
                both = _most(same)
                out[one] |= both
                out[other] |= both
    return out


def _most(same: Array) -> Mask:
    """Return a mask of where at least MOST of the 5 x 5 around are True; the outside counts as False."""
    counts = moving_sums(moving_sums(same.astype(np.int64), 0, AROUND, "constant"), 1, AROUND, "constant")
    return np.asarray(counts >= MOST)


def mean_step(pictures: Sequence[Array], usable: Sequence[Mask | None]) -> float:
    """Return the mean absolute difference of neighbours, summed over channels, where both are usable."""
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


def _lattice(reference: Reference, picture: Array) -> float:
    """Return the loss of periodicity in percent; 0 if the exemplar has no periods."""
    periods = reference.periods
    return max(0.0, periods.lost(picture, reference.pictures[0], reference.usable[0])) if periods else 0.0


# Each was halved and doubled on 143 textures; the results are in docs/design/012.
MANY = 625  # least number of windows of an exemplar for reliable mean and spread: 4 x 4 that do not overlap
LEAST = 16  # least area of an output, in windows, for the same
PLAIN = 0.2  # of the distance of unrelated windows: added to the mean own distance, which is 0 for a perfect lattice
FAINT = 0.04  # of the largest spread: least divisor, as coefficients that hardly vary are unreliable
TURNED = 300  # windows, about, whose nearest ones are searched in all eight isometries
CHANCE = 1.5  # factor of their distance, as the nearest of eight isometries is nearer by chance alone


def texture_distance(sources: Sequence[Sources], enough: float) -> float:
    """Return how much an output differs in texture from its exemplar, in percent.

    If that is more than `enough`, pieces may be mirrored or rotated: windows are compared in all eight isometries as
    well, and the lesser difference is returned.
    """
    many = [s for s in sources if _tells(s)] or sources[:1]
    found = math.inf
    for asked in ((_far, _differs), (_far_turned, _differs_turned)):
        if found > enough:
            found = min(found, 100 * math.prod(sum(map(ask, many)) / max(len(many), 1) for ask in (_begun, *asked)))
    return found


def _tells(sources: Sources) -> bool:
    area = sources.number.size * STEP**2
    return len(sources.level.windows.waves) >= MANY and area >= LEAST * sources.level.least_side**2


def _far(sources: Sources) -> float:
    return float(sources.distance.mean()) / _usual(sources)


def _far_turned(sources: Sources) -> float:
    some = sources.flat[:: -(-sources.number.size // TURNED)]
    least = np.min([sources.level.windows.nearest(waves)[0] for waves in poses(some)], axis=0)
    return CHANCE * float(least.mean()) / _usual(sources)


def _usual(sources: Sources) -> float:
    return float(sources.level.own.mean()) + PLAIN * sources.level.unrelated


def _begun(sources: Sources) -> float:
    begun = steps = 0
    for step in NEXT[:2]:
        ahead, inside = continued_sources(sources.level, sources.number, step)
        begun += int((inside & (ahead != sources.number)).sum())
        steps += int(inside.sum())
    return begun / max(steps, 1)


def _differs(sources: Sources) -> float:
    return _off(sources.flat, sources.level.windows.waves)


def _differs_turned(sources: Sources) -> float:
    return _off(*(np.concatenate(poses(waves)) for waves in (sources.flat, sources.level.windows.waves)))


def _off(some: Array, others: Array) -> float:
    (mean, spread), (usual, wide) = _moments(some), _moments(others)
    off = np.abs(mean - usual) + np.abs(spread - wide)
    return float((off / (spread + wide + max(FAINT * float(wide.max()), 1.0))).mean())


def _moments(waves: Array) -> tuple[Array, Array]:
    """Return mean and standard deviation of every DCT coefficient; sums of integers below 2**53 are exact."""
    total, squares = (w.sum(axis=0, dtype=np.float64) / len(waves) for w in (waves, waves * waves))
    return total, np.sqrt(np.maximum(squares - total * total, 0))
