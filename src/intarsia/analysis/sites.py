"""An exemplar as corrections see it: level by level, what is compared, where candidates may lie, where to jump."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_cdt, distance_transform_edt

from ..exemplar import Exemplar
from ..kernels.correction import Site
from .appearance import WEIGHTS, appearance_table, bordered, colour_table, filled, packed, stack_of, transformed
from .features import features
from .jumps import similar_places

KEPT = 1 << 28  # bytes of tables that are kept; larger ones are made anew for every window

Array = NDArray[Any]
EMPTY = np.zeros((0, 2), np.uint64)


@dataclass(frozen=True)
class Sites:
    """The levels of an exemplar, by the spacing of their pixels: 1, 2, 4, ... px up to `top`.

    ``sites`` holds the levels that are corrected, from spacing 1 on; coarser ones see more than the exemplar holds.
    ``home``: for each pixel the usable one in its place, or empty.
    """

    exemplar: Exemplar
    neighbourhood: str
    top: int
    sites: tuple[Site, ...]
    home: NDArray[np.int32]

    @property
    def levels(self) -> int:
        """The number of levels; the coarsest has a pixel for all of the exemplar."""
        return self.top.bit_length()

    def site(self, level: int) -> Site:
        """Return the level of spacing 2**level with its table."""
        site = self.sites[level]
        return site if len(site.table) else site._replace(table=self._table(site))

    def _table(self, site: Site) -> Array:
        height, width, h, torus = (int(site.shape[k]) for k in (0, 1, 2, 6))
        if len(site.packed):
            around = site.packed.astype("<u8").view("<u2").reshape(height + 2 * h, width + 2 * h, -1)
            own = around[h : h + height, h : h + width].astype(np.int16) - 1023
            return appearance_table(own, h, bool(torus))
        return colour_table(site.values.reshape(height, width, -1), h, site.mask, bool(torus))


def sites_of(
    exemplar: Exemplar, neighbourhood: str, k: int, weights: tuple[float, ...] | None
) -> Sites:
    """Return the levels of an exemplar; made once for all seeds and sizes, the same on every machine.

    ``neighbourhood``: "appearance", or "colour" for plain 5 x 5 neighbourhoods; ``k`` - 1 jumps for each pixel.
    """
    key = ("sites", neighbourhood, k, weights)
    return exemplar.memo(key, lambda: _sites(exemplar, neighbourhood, k, weights))


def _sites(exemplar: Exemplar, neighbourhood: str, k: int, weights: tuple[float, ...] | None) -> Sites:
    height, width, torus = exemplar.height, exemplar.width, exemplar.toroidal
    top = 1 << (max(height, width) - 1).bit_length()
    corrected = sum(4 * (1 << n) + 1 <= min(height, width) for n in range(top.bit_length()))
    picture = filled(features([exemplar], weights).pictures[0], exemplar)
    far = depths(exemplar)
    sites = []
    for level, blurred in enumerate(stack_of(picture, corrected, torus)):
        h = 1 << level
        pad = h if neighbourhood == "appearance" else 0
        closed = far <= min(2 * h, int(far.max()) // 4)
        shape = np.array([height, width, h, pad, width + 2 * pad, max(level - 1, 0), torus], np.int64)
        if neighbourhood == "appearance":
            own = transformed(blurred, h, torus)
            words, values = packed(own, h, torus), np.zeros((0, 1), np.int16)
            table = appearance_table(own, h, torus)
        else:
            own = ((blurred + 8) >> 4).astype(np.int16)
            words, values = EMPTY, np.ascontiguousarray(own.reshape(height * width, -1))
            table = colour_table(own, h, WEIGHTS, torus)
        jumps = similar_places(table, (height, width, torus), h, closed, k - 1)
        keep = table if corrected * table.nbytes <= KEPT else table[:0]
        sites.append(Site(shape, words, values, WEIGHTS, keep, (~closed).astype(np.uint8).ravel(), jumps))
    return Sites(exemplar, neighbourhood, top, tuple(sites), _home(exemplar))


def depths(exemplar: Exemplar) -> Array:
    """Return how far, along rows, columns and diagonals, each pixel is from what is unusable or outside; 0 there."""
    height, width = exemplar.height, exemplar.width
    usable = np.ones((height, width), bool) if exemplar.usable is None else exemplar.usable
    reach = max(height, width)
    if exemplar.toroidal and usable.all():
        return np.full((height, width), 1 << 30)
    around = bordered(usable, reach, True) if exemplar.toroidal else np.pad(usable, reach)
    far = distance_transform_cdt(around, metric="chessboard")
    return np.asarray(far[reach : reach + height, reach : reach + width], np.int64)


def _home(exemplar: Exemplar) -> NDArray[np.int32]:
    """For each pixel itself, or the nearest usable one."""
    if exemplar.usable is None:
        return np.zeros(0, np.int32)
    y, x = distance_transform_edt(~exemplar.usable, return_distances=False, return_indices=True)
    return np.asarray(y * exemplar.width + x, np.int32).ravel()
