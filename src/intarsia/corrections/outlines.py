"""How far every exemplar pixel lies from the outlines of what is in the picture: a channel more to compare.

Where colours alone say too little, the distance to the nearest feature keeps it whole (Lefebvre and Hoppe 2006, section
3; Wu and Yu 2004). Features are drawn by hand, or are the strong ridges of the gradient. All steps are whole numbers,
or single IEEE operations on them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..analysis.stretched import RANGE
from ..analysis.sums import spreads
from ..errors import InputError
from ..exemplar import Exemplar
from ..field import Field
from ..lazy import ndimage
from .appearance import stack_of

FAR = 16  # px beyond which it does not matter how far an outline is
PARTS = 16  # of a px that distances count in
STRONG, FAINT = 0.9, 0.75  # shares of all pixels whose gradient is less: of outlines somewhere, and everywhere
SHORTEST = 8  # px that an outline has at least
BLUR = 2  # level of the stack that is differentiated: what is finer is grain

Array = NDArray[Any]


@dataclass(frozen=True)
class Outlines:
    """Which outlines count, and how much: 1 as much as all the colours together.

    ``drawn``: a picture that is light on one side of them and dark on the other; None: edges are looked for.
    """

    drawn: Field | None
    weight: float

    @classmethod
    def of(cls, method: Any) -> Outlines | None:
        """Take from the fields of a method which outlines count; None: none."""
        if method.feature is None or not method.feature_weight:
            return None
        return cls(method.feature if isinstance(method.feature, Field) else None, method.feature_weight)

    def over(self, exemplar: Exemplar) -> Outlines:
        """Return the same outlines, known by the pixels of the exemplar that lie inside, not by a function."""
        if self.drawn is None or not self.drawn.is_function:
            return self
        drawn = self.drawn  # asked once for each exemplar, not for every window
        inside = exemplar.latest("drawn", drawn, lambda: Field(marked(drawn, exemplar)))
        return replace(self, drawn=inside)

    def channel(self, exemplar: Exemplar, picture: Array) -> Array:
        """Return the channel (H, W, 1) to append to features (H, W, C) of the exemplar: int16."""
        torus = exemplar.toroidal
        if self.drawn is None:
            far = outline_distances(edges(picture, torus), torus)
        else:
            inside = marked(self.drawn, exemplar)
            far = outline_distances(~inside, torus) - outline_distances(inside, torus)
        centred = far - int(far.sum()) // far.size
        own, much = (sum(spreads(p.reshape(far.size, -1))) / float(far.size**2) for p in (centred, picture))
        share = round(65536 * math.sqrt(self.weight * much / max(own, 1.0)))
        return np.asarray(np.clip((centred * share + 32768) >> 16, -RANGE, RANGE)[:, :, None], np.int16)


def painted(drawn: Field, rows: Array, cols: Array) -> Array:
    """Return which places lie inside what is drawn: bool (rows, columns)."""
    return np.asarray(drawn.at(rows, cols) > 0.5)


def marked(drawn: Field, exemplar: Exemplar) -> Array:
    """Return which pixels lie inside what is drawn: bool (H, W); InputError where it has no outline."""
    inside = painted(drawn, np.arange(exemplar.height), np.arange(exemplar.width))
    if inside.all() or not inside.any():
        kind = "light" if inside.all() else "dark"
        raise InputError(f"feature is {kind} everywhere, and so has no outline; paint white what belongs together.")
    return inside


def outline_distances(there: Array, toroidal: bool) -> Array:
    """Return how far each pixel is from the nearest that is `there`: int64 (H, W), 1 / 16 px, at most 16 px."""
    if not there.any():
        return np.full(there.shape, FAR * PARTS, np.int64)
    around = np.pad(there, FAR, mode="wrap") if toroidal else there
    far = ndimage.distance_transform_edt(~around)
    inner = far[FAR : FAR + there.shape[0], FAR : FAR + there.shape[1]] if toroidal else far
    return np.asarray(np.minimum(np.rint(inner * PARTS), FAR * PARTS), np.int64)


def edges(picture: Array, toroidal: bool) -> Array:
    """Return the strong edges of features (H, W, C): bool (H, W).

    A pixel is on a ridge if no neighbour across has a steeper gradient. Of ridges, faint ones stay where they hang
    together with strong ones; how steep that is follows from the picture itself.
    """
    levels = BLUR + 1 if min(picture.shape[:2]) > 4 * BLUR else 1
    mode: Literal["wrap", "edge"] = "wrap" if toroidal else "edge"
    blurred = np.pad(stack_of(picture, levels, toroidal)[-1].astype(np.int64), ((1, 1), (1, 1), (0, 0)), mode=mode)
    down, across = blurred[2:, 1:-1] - blurred[:-2, 1:-1], blurred[1:-1, 2:] - blurred[1:-1, :-2]
    xx, yy, xy = ((a * b).sum(axis=2) for a, b in ((across, across), (down, down), (across, down)))
    steep, straight, turned = xx + yy, xx - yy, 2 * xy
    along = np.where(abs(turned) < abs(straight), np.where(straight > 0, 0, 1), np.where(turned > 0, 2, 3))
    around, (height, width) = np.pad(steep, 1, mode=mode), steep.shape
    ridge = np.zeros(steep.shape, bool)
    for number, (dy, dx) in enumerate(((0, 1), (1, 0), (1, 1), (1, -1))):
        ahead = around[1 + dy : 1 + dy + height, 1 + dx : 1 + dx + width]
        behind = around[1 - dy : 1 - dy + height, 1 - dx : 1 - dx + width]
        ridge |= (along == number) & (steep >= ahead) & (steep > behind)
    ranked = np.sort(steep, axis=None)
    strong, faint = (ranked[int(share * (len(ranked) - 1))] for share in (STRONG, FAINT))
    pieces, count = ndimage.label(ridge & (steep > faint), structure=np.ones((3, 3)))
    sizes = np.bincount(pieces.ravel(), minlength=count + 1)
    seeds = np.bincount(pieces.ravel(), (ridge & (steep > strong)).ravel(), minlength=count + 1)
    kept = (sizes >= SHORTEST) & (seeds > 0)
    kept[0] = False
    return np.asarray(kept[pieces])
