"""The numbers of a plane in one unit for all exemplars, and the range that is stretched: what lies far off is cut.

Heights may be metres, millimetres or shares, and hold a hole of -1e30: what the rest looks like must still be seen.
No 8-bit picture is ever cut, so that such a picture and its floats give the same features (law 13).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exemplar import resized
from ..image import Plane
from ..rendering.colour import WHITE, Unit, code_shares, code_values, has_own_unit, inner_range

MOST_SPREAD = 256  # all values may span so many times what 998 of 1000 do; 8 bits cannot tell more apart

Int32 = NDArray[np.int32]
Mask = NDArray[np.bool_]


def counted(planes: Sequence[Plane], usable: Sequence[Mask | None]) -> tuple[list[Int32], int]:
    """Return planes of one name as whole numbers (H, W, C) that can be compared, and what 0 is in them.

    Floats are counted in units of their own size, taken from their usable pixels (masks are those of the base, and
    may be a multiple or fraction of a plane's size). Where they hold nothing but whole codes of 16 bits within 0 to 1,
    those are returned, as for integers.
    """
    if not any(map(has_own_unit, planes)):
        return [code_values(p) for p in planes], 0
    masks = [... if m is None else resized(m, (p.height, p.width)) for m, p in zip(usable, planes, strict=True)]
    colours = planes[0].channels - planes[0].alpha
    seen = [code_shares(p.samples[..., :colours])[m] for p, m in zip(planes, masks, strict=True)]
    if not any(s.size for s in seen):
        return [code_values(p) for p in planes], 0
    unit = Unit.of(np.concatenate([s.ravel() for s in seen]))
    if not unit.origin and -16 <= unit.exponent <= 0:
        codes = [WHITE.count(s) for s in seen]
        if all((unit.count(s) == c << unit.bits - unit.exponent).all() for s, c in zip(seen, codes, strict=True)):
            unit = WHITE
    return [code_values(p, unit) for p in planes], int(unit.count(np.zeros(1))[0])


def ends(values: Sequence[NDArray[Any]]) -> tuple[int, int]:
    """Return least and greatest of whole numbers, or less where a few of them lie very far from the rest.

    Where they span over 256 times what is left without one of a thousand at either end, that range is returned,
    widened by itself on both sides.
    """
    low, high = min(int(v.min()) for v in values), max(int(v.max()) for v in values)
    if high - low <= MOST_SPREAD:
        return low, high
    least, most = map(int, inner_range(np.concatenate([v.ravel() for v in values])))
    within = most - least
    if 0 < within * MOST_SPREAD < high - low:
        return max(low, least - within), min(high, most + within)
    return low, high
