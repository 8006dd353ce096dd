"""A picture of what the analysis by segments sees: borders, groups, and the group that was chosen."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.ranges import counted, ends
from ..exemplar import Exemplar
from ..rendering.colour import code_values, has_own_unit
from ..segments.segments import Segments, segments

TINTS = ((86, 180, 233), (0, 158, 115), (204, 121, 167), (0, 114, 178), (230, 159, 0), (120, 94, 240), (128, 128, 128))
CHOSEN = (213, 94, 0)
LINE, FAINT_LINE = (255, 255, 90), (20, 20, 20)
GROUND = 40  # gray of pixels that do not count


def segment_overlay(exemplar: Exemplar, found: Segments | None = None) -> NDArray[np.uint8]:
    """Draw the segments of an exemplar over it: (H, W, 3), 8 bit.

    The chosen group keeps its light under a tint of orange and has yellow borders; the others are dimmed, each
    group with a tint of its own and dark borders. Pixels that do not count are dark gray. Nothing is drawn over a
    picture without segments.

    Parameters
    ----------
    exemplar : Exemplar
        Its base plane is shown.
    found : Segments, optional
        What to draw, by default :func:`segments` of the exemplar.
    """
    found = segments(exemplar) if found is None else found
    picture = _picture(exemplar).astype(np.int32)
    group = found.group_map
    tints = np.array([TINTS[g % len(TINTS)] for g in range(int(group.max(initial=0)) + 1)], np.int32)
    if found.chosen is not None:
        tints[found.chosen] = CHOSEN
    mine = group == (-2 if found.chosen is None else found.chosen)
    out = np.where(mine[..., None], (3 * picture + tints[group]) // 4, (2 * picture + tints[group]) // 5)
    out[group < 0] = GROUND
    edge = borders(found.labels)
    around = mine.copy()  # a border belongs to the chosen group if either side does
    for axis in (0, 1):
        a, b = (np.s_[:-1], np.s_[1:]) if axis == 0 else (np.s_[:, :-1], np.s_[:, 1:])
        around[a] |= mine[b]
        around[b] |= mine[a]
    out[edge & ~around] = FAINT_LINE
    out[edge & around] = LINE
    return out.astype(np.uint8)


def borders(labels: NDArray[Any]) -> NDArray[np.bool_]:
    """Mark the pixels whose right or lower neighbour is in another segment."""
    edge = np.zeros(labels.shape, bool)
    edge[:-1] |= labels[:-1] != labels[1:]
    edge[:, :-1] |= labels[:, :-1] != labels[:, 1:]
    return edge


def _picture(exemplar: Exemplar) -> NDArray[np.uint8]:
    """The base plane as 8-bit RGB; gray is repeated, opacity left out, floats beyond 0 to 1 have their own range."""
    codes = code_values(exemplar.base)
    low, high = 0, 65535
    if has_own_unit(exemplar.base) and not (low <= codes.min() and codes.max() <= high):
        (codes,), _ = counted([exemplar.base], [exemplar.usable])
        low, high = ends([codes if exemplar.usable is None else codes[exemplar.usable]])
    colours = codes.shape[2] - exemplar.base.alpha
    codes = codes[:, :, :3] if colours >= 3 else codes[:, :, [0, 0, 0]]
    return ((np.clip(codes, low, high).astype(np.int64) - low) * 255 // max(high - low, 1)).astype(np.uint8)
