"""Whether an output is of the texture of its exemplar at all: three questions, asked of windows of every size.

*Is what it shows there?* How far windows are from the exemplar, of what its own are from one another. *Does it go on as
there?* At how many steps from window to window another place of the exemplar begins. *Is it like it on the whole?* By
how much the cosines of windows differ in mean and spread.

What is grown may show a part of its exemplar alone, or be cut into small pieces; what is plain finds its like in a rich
exemplar: each fails one question or two. Only another texture fails all three, so the answers are multiplied.

Sources: statistics of filters as what a texture is, Heeger and Bergen 1995; the product is our own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from .sources import NEXT, STEP, Sources, continued
from .windows import poses

# Halved and doubled on 143 textures; what is seen then stands in docs/design/012.
MANY = 625  # windows: four beside four that do not overlap; mean and spread of fewer are chance,
LEAST = 16  # and of an output that has not the area of so many
PLAIN = 0.2  # of what any two windows differ by is added to what the exemplar's own do: in a lattice that is nothing
FAINT = 0.04  # of the largest spread is added to each: a cosine that hardly varies says nothing
TURNED = 300  # windows that are looked for in every pose,
CHANCE = 1.5  # times as far: of eight poses one is nearer by chance


def unlike(sources: Sequence[Sources], enough: float) -> float:
    """By how much an output is of another texture than its exemplar, in percent.

    Where that is more than `enough`, pieces may have been mirrored and turned: windows are looked for in every pose.
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
    some = _flat(sources)[:: -(-sources.number.size // TURNED)]
    least = np.min([sources.level.windows.nearest(waves)[0] for waves in poses(some)], axis=0)
    return CHANCE * float(least.mean()) / _usual(sources)


def _usual(sources: Sources) -> float:
    return float(sources.level.own.mean()) + PLAIN * sources.level.unrelated


def _flat(sources: Sources) -> Array:
    return sources.waves.reshape(-1, sources.waves.shape[2])


def _begun(sources: Sources) -> float:
    begun = steps = 0
    for step in NEXT[:2]:
        ahead, inside = continued(sources.level, sources.number, step)
        begun += int((inside & (ahead != sources.number)).sum())
        steps += int(inside.sum())
    return begun / max(steps, 1)


def _differs(sources: Sources) -> float:
    return _off(_flat(sources), sources.level.windows.waves)


def _differs_turned(sources: Sources) -> float:
    return _off(*(np.concatenate(poses(waves)) for waves in (_flat(sources), sources.level.windows.waves)))


def _off(some: Array, others: Array) -> float:
    (mean, spread), (usual, wide) = _moments(some), _moments(others)
    off = np.abs(mean - usual) + np.abs(spread - wide)
    return float((off / (spread + wide + max(FAINT * float(wide.max()), 1.0))).mean())


def _moments(waves: Array) -> tuple[Array, Array]:
    """The mean and the spread of every cosine; sums of whole numbers below 2**53 are exact."""
    total, squares = (w.sum(axis=0, dtype=np.float64) / len(waves) for w in (waves, waves * waves))
    return total, np.sqrt(np.maximum(squares - total * total, 0))
