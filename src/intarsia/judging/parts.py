"""The parts of the score: definitions, units, anchors, and how each is measured.

Every part is 1 for an output as good as a true continuation of the exemplar, and 0 for random squares placed without
matching, or at the anchor in the table. All measurements are ratios of sums of integers.

Whether an output has the texture of its exemplar at all is measured on windows of every size as a product of three
numbers: the distance of windows to the exemplar, relative to distances within it; the share of steps from window to
window at which another place of the exemplar begins; the difference in mean and spread of the cosines of windows. A
synthesised texture may show only a part of its exemplar, or be cut into small pieces, and a plain one finds matches in
a rich exemplar: each is high in one or two of the numbers. Only another texture is high in all three.

Sources: pieces and where they meet, Ashikhmin 2001 (section 3) and Kwatra et al. 2003 (section 3.1); statistics of
filters as what a texture is, Heeger and Bergen 1995; the product, repeats and the scales are our own.
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
# maps this one agreed best with people on which of two outputs repeats itself.
REACH = 25  # windows of the output, 200 px: repeats are noticed within it; 128 px: fewer pairs are told apart
NEAR = 3  # windows: nearer ones overlap
AROUND = 2  # windows on every side are the surroundings, so 5 x 5, and
MOST = 14  # of them, over half, must be the same; 3 x 3 or 7 x 7 name the better output as often
SAME = 2  # px of the reduced picture: sources within it are the same


class Part(NamedTuple):
    """One part of the score: name, unit, meaning, weight in the total, and anchors.

    ``good``: the value of a true continuation; ``bad``: the value that is worth 0, None for that of random tiles of the
    exemplar, at least ``least`` away from ``good``. ``grainy`` parts are weighted by the grain of the exemplar.
    ``flaw``: what people see if this part takes most.
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
    """Return the measured parts of an output picture (H, W, C), given in the features of its exemplars."""
    every, sources = sources, sources[:2]
    sides = [min(p.shape[:2]) for p in reference.pictures]
    how: dict[str, Callable[[], float]] = {
        "joins": lambda: _mean([100 / 1024 * float(s.join_costs.mean()) for s in sources]),
        "steps": lambda: _mean([100 / 1024 * float(s.steps.mean()) for s in every[1:]]),
        "overused": lambda: _mean([_overused(s) for s in sources], 1.0),
        "salient": lambda: _mean([_salient(reference, s) for s in sources[1:2]], 1.0),
        "blurred": lambda: _blurred(reference, picture),
        "repeats": lambda: _mean([_again(s, sides) for s in sources[:1]]),
        "lattice": lambda: _lattice(reference, picture),
        TEXTURE.name: lambda: texture_distance(every, TEXTURE.good),
    }
    return {part.name: how[part.name]() for part in parts}


def _mean(values: list[float], nothing: float = 0.0) -> float:
    return sum(values) / len(values) if values else nothing


def square_side(table: Array) -> int:
    """Return the side of the squares whose use is counted, in windows of a table."""
    return max(3, int(min(table.shape)) // 12)


def square_usage(table: Array, usage: Array) -> Array:
    """Return the sum of `usage` over every square of a table of windows; -1 for squares with gaps."""
    side = square_side(table)
    if min(table.shape) < side:
        return np.zeros((0, 0), np.int64)
    counts, there = (window_sums(a, (side, side)) for a in (usage, (table >= 0).astype(np.int64)))
    return np.where(there == side * side, counts, -1)


def _overused(sources: Sources) -> float:
    """Return the 98th percentile of the use of squares, a twelfth of the exemplar wide, relative to the mean."""
    every = square_usage(sources.level.windows.table, sources.usage)
    often = np.sort(every[every >= 0])
    mean = float(often.sum()) / max(often.size, 1)
    return float(often[often.size * 98 // 100]) / mean if mean else 1.0


def _salient(reference: Reference, sources: Sources) -> float:
    """Return the use of salient places relative to the mean, weighted by saliency and use."""
    windows, usage = sources.level.windows, sources.usage
    half = SIDE // 4 // windows.stride  # counted within half a window, as sources are inexact
    often = window_sums(np.pad(usage, half), (2 * half + 1,) * 2)
    weight = usage * windows.middles(reference.salient)
    mean = usage.sum() * (2 * half + 1) ** 2 / np.count_nonzero(windows.table >= 0)
    return float((weight * often).sum() / weight.sum() / mean) if weight.any() else 1.0


def _again(sources: Sources, sides: Sequence[int]) -> float:
    """Return the share of windows that recur with their surroundings within 3/4 of the shorter side, in percent.

    `sides`: the shorter sides of the exemplars, px.
    """
    return 100 * float(recurring_windows(sources, min(REACH, max(sides) * 3 // 4 // STEP)).mean())


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


# Halved and doubled on 143 textures; results are in docs/design/012.
MANY = 625  # least windows of an exemplar for mean and spread (4 x 4 that do not overlap),
LEAST = 16  # and least area of an output, in windows
PLAIN = 0.2  # of the unrelated distance, added to the mean own distance, which is 0 for a perfect lattice
FAINT = 0.04  # of the largest spread, added to each: cosines that hardly vary are unreliable
TURNED = 300  # windows that are searched in every pose;
CHANCE = 1.5  # correction of their distance, as the nearest of eight poses is nearer by chance


def texture_distance(sources: Sequence[Sources], enough: float) -> float:
    """Return how much an output differs in texture from its exemplar, in percent.

    If that is more than `enough`, pieces may be mirrored or rotated, and windows are compared in every pose.
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
    """Return mean and standard deviation of every cosine; sums of integers below 2**53 are exact."""
    total, squares = (w.sum(axis=0, dtype=np.float64) / len(waves) for w in (waves, waves * waves))
    return total, np.sqrt(np.maximum(squares - total * total, 0))
