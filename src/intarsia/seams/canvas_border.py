"""Candidates for windows at the border of the canvas that end at the border of the exemplar.

A patch lies inside the exemplar, so few patches contain pixels near its border. Inside the canvas such pixels are shown
only where a cut runs along the border of the exemplar, in a straight line; where the canvas ends no seam is needed.
Therefore a third of the placements that are drawn for a window at the border of the canvas end at the border of the
exemplar on the same side. As elsewhere the cheapest cut is kept; pixels with few occurrences are cheap.

Source: none known; occurrences are counted as in :mod:`.occurrence_kernels`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..foundation.arrays import Array, Mask, Pair
from ..foundation.run import Run
from ..search import Candidates
from .graphcut_textures import Box, GraphcutMap

SHARE = 3  # 1 / SHARE of the placements of such a window; with all, rows of the exemplar recur along the border


def border_candidates(sewn: GraphcutMap, boxes: Sequence[Box], run: Run) -> list[Candidates | None]:
    """Return the candidates that end at the exemplar's border on the sides where the canvas ends.

    None for windows elsewhere, and where :meth:`GraphcutMap.apart` rejects all of them.
    """
    out, alike = list[Candidates | None]([None] * len(boxes)), dict[Pair, list[int]]()
    for number, box in enumerate(boxes):
        alike.setdefault(sides_of(sewn, box), []).append(number)
    for sides, numbers in alike.items():
        valid = at_border(sewn.variants.valid, sewn.variants.toroidal, sides)
        if any(sides) and any(v.any() for v in valid):
            for n, found in zip(numbers, sewn.found([boxes[n] for n in numbers], run, valid), strict=True):
                rows = found.rows[sewn.apart(boxes[n], found.rows)]
                out[n] = replace(found, rows=rows) if len(rows) else None
    return out


def sides_of(sewn: GraphcutMap, box: Box) -> Pair:
    """Return for both axes at which end of the canvas a window lies: -1 the first, 1 the last, 0 none or both.

    0 also along an axis that wraps, and along one on which the canvas is shorter than 1.5 times the longest exemplar.
    """
    longest, ends = sewn.variants.table[:, 1:3].max(axis=0).tolist(), list[int]()
    for k, (length, wrap) in enumerate(zip(sewn.variant.shape, sewn.wraps, strict=True)):
        open_ended = not wrap and 2 * length >= 3 * longest[k]
        ends.append(int(box[k] + box[2 + k] >= length) - int(box[k] <= 0) if open_ended else 0)
    return ends[0], ends[1]


def at_border(valid: Sequence[Mask], toroidal: Array, sides: Pair) -> list[Mask]:
    """Return the valid first pixels of patches that end at a variant's border on those sides; none if toroidal."""
    out = []
    for allowed, torus in zip(valid, toroidal.tolist(), strict=True):
        kept = np.zeros_like(allowed)
        ends = tuple({-1: slice(0, 1), 0: slice(None), 1: slice(-1, None)}[side] for side in sides)
        if not torus:
            kept[ends] = allowed[ends]
        out.append(kept)
    return out
