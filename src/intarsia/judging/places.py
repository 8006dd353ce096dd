"""Where an output loses its score: squares for the parts that have places.

Of joins the worst are marked; of what is shown too often the place of the exemplar that is, wherever the output has it.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from ..analysis import window_sums
from ..foundation.arrays import Array
from . import Judged
from .parts import seen_again
from .sources import STEP, Sources
from .windows import SIDE

MOST = 8  # squares of a part
WIDE = 5  # windows along a side of a square


def places(judged: Judged) -> dict[str, list[list[int]]]:
    """Return squares (x, y, side) in px of the output, the worst first, at most MOST by part.

    They may reach over its border. In a large output each judged part of it has its share of them.
    """
    out: dict[str, list[list[int]]] = {}
    for (top, left), sources in judged.looks:
        for s in sources[:1]:
            px, side = STEP * judged.factor, ((WIDE - 1) * STEP + SIDE * s.level.windows.factor) * judged.factor
            at, strikes = s.level.windows.at[s.number], s.level.windows.middles(judged.reference.salient)
            heats = {
                "joins": s.join_costs.sum(axis=0),
                "overused": _most_shown(s, np.ones(s.number.shape)),
                "salient": _most_shown(s, strikes[at[..., 0], at[..., 1]]),
                "repeats": _most_shown(s, seen_again(judged.reference, s)),
            }
            for name, heat in heats.items():
                found = islice(_squares(heat.astype(float)), MOST // len(judged.looks))
                out.setdefault(name, []).extend([left + x * px, top + y * px, side] for y, x in found)
    return out


def _squares(heat: Array) -> Iterator[list[int]]:
    """Yield first row and column of the squares of the largest sums that do not meet: at least half the first one."""
    worst = 0.0
    while min(heat.shape) >= WIDE:
        sums = window_sums(heat, (WIDE, WIDE), float)
        y, x = divmod(int(sums.argmax()), sums.shape[1])
        worst = max(worst, float(sums[y, x]))
        if sums[y, x] < max(worst / 2, 1e-3):
            return
        yield [y, x]
        heat[max(y - 1, 0) : y + WIDE + 1, max(x - 1, 0) : x + WIDE + 1] = 0


def _most_shown(sources: Sources, weights: Array) -> Array:
    """Return the weights of the windows that show the place of the exemplar that is shown most, 0 elsewhere."""
    windows = sources.level.windows
    at, near = windows.at[sources.number], WIDE * STEP // (2 * windows.factor * windows.stride)
    counts = np.zeros(windows.table.shape)
    np.add.at(counts, (at[..., 0], at[..., 1]), weights)
    sums = window_sums(np.pad(counts, near), (2 * near + 1,) * 2, float)
    far = np.abs(at - divmod(int(sums.argmax()), sums.shape[1])).max(axis=2)
    return np.where(far <= near, weights, 0)
