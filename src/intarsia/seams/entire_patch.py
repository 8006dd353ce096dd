"""Entire patch matching: how well the whole exemplar fits over the map, wherever it is shifted to.

Squared differences are added up over all that both share and divided by how much that is (Kwatra et al. 2003, 4).
All shifts are measured at once on reduced pictures by FFT, in whole numbers; the best are then followed to full
resolution.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import pose_array
from ..exemplar import Exemplar
from ..filtering import fourier
from ..kernels import windows
from ..search import reduce_kernels
from ..search.candidates import Candidates, Search
from ..search.fourier import PatchSearch
from ..search.posed import PosedExemplars
from . import placement_kernels
from .energy_kernels import Pieces

Array = NDArray[Any]
LISTED = 6
SAMPLES = 32  # a side of what map and exemplar share is looked at in about so many places, to find the last px
FINE = 256  # mean squared differences are kept in 1 / FINE
NEVER = 1 << 60


class EntireSearch:
    """The search for the shifts of whole exemplars that cover a window.

    Parameters
    ----------
    search : PatchSearch
        Whose reduced pictures, windows and valid positions are meant.
    pieces : Pieces
        The variants, and which of their pixels may be shown.
    """

    def __init__(self, search: Search, pieces: Pieces) -> None:
        assert isinstance(search, PatchSearch)
        self.search, self.variants, self.pieces, self.factor = search, search.variants, pieces, search.factor
        self._spectra = [self._transformed(v) for v in range(len(self.variants))]

    def find(self, variant: Array, yx: Array, at: tuple[int, int], wraps: tuple[bool, bool]) -> Candidates:
        """Return the candidates for the window that begins at `at`, as the patch search does.

        Distances are means over all that is shared, times the pixels of the window.
        """
        area = self.search.patch[0] * self.search.patch[1]
        every, usual = np.empty((0, 4), np.int64), NEVER
        for v, allowed in enumerate(self.search.valid):
            if not allowed.any():
                continue
            means = self._means(v, variant, yx, at, wraps)
            order = np.argsort(means, axis=None, kind="stable")
            order = order[means.ravel()[order] < NEVER]
            if not len(order):
                continue
            usual = min(usual, int(means.ravel()[order[len(order) // 20]]))
            y, x = np.divmod(order[:LISTED], means.shape[1])
            rows = np.stack([np.zeros(len(y), np.int64), np.full(len(y), v), y * self.factor, x * self.factor], 1)
            every = np.concatenate([every, self._followed(v, rows, variant, yx, at, wraps)])
        if not len(every):
            return Candidates(every, 0, every, np.zeros(self.search.patch, np.uint8), free=True)
        every = every[np.lexsort((*every.T[:0:-1], every[:, 0]))][:LISTED]
        every[:, 0] = every[:, 0] * area // FINE
        usual = self.search.full(usual * area // (FINE * self.factor**2))
        return Candidates(every, usual, every, np.ones(self.search.patch, np.uint8))

    def _size(self, v: int) -> tuple[int, int]:
        """Rows and columns of the canvas around a window, reduced, that the exemplar may lie over."""
        rows, columns = self._reduced(v)
        return 2 * rows - max(self.search.cells[0], 1), 2 * columns - max(self.search.cells[1], 1)

    def _reduced(self, v: int) -> tuple[int, int]:
        rows, columns = self.variants.picture(v).shape[:2]
        return rows // self.factor, columns // self.factor

    def _transformed(self, v: int) -> list[Array]:
        """Spectra of an exemplar along the axes, of where it is usable, and of its squares."""
        search, f = self.search, self.factor
        picture = self.variants.picture(v)
        rows, columns = self._reduced(v)
        begin = int(self.variants.table[v, 0]) // self.variants.channels
        usable = self.pieces.usable[begin : begin + picture.shape[0] * picture.shape[1]].reshape(picture.shape[:2])
        usable = usable[: rows * f, : columns * f].reshape(rows, f, columns, f).min(axis=(1, 3)).astype(np.float64)
        reduced = reduce_kernels.coarse_picture(picture, f, search.mean, search.axes, search.clip)
        reduced = reduced.astype(np.float64) * usable
        shape = self._padded(v)
        return [np.conj(fourier.rfft2(a, shape)) for a in (*reduced, usable, (reduced**2).sum(axis=0))]

    def _padded(self, v: int) -> tuple[int, int]:
        size = self._size(v)
        return fourier.next_fast_len(size[0], real=False), fourier.next_fast_len(size[1], real=True)

    def _means(self, v: int, variant: Array, yx: Array, at: tuple[int, int], wraps: tuple[bool, bool]) -> Array:
        """Mean squared difference on reduced pictures, in 1 / FINE, for every coarse position; NEVER where none is."""
        search, f, size, shape = self.search, self.factor, self._size(v), self._padded(v)
        beyond = [a - max(b, 1) for a, b in zip(self._reduced(v), search.cells, strict=True)]
        feats = np.empty((1, size[0] * f, size[1] * f, self.variants.channels), np.int16)
        known = np.empty(feats.shape[:3], np.uint8)
        first = at[0] - beyond[0] * f, at[1] - beyond[1] * f
        windows.gather_window(windows.Grown(variant, yx, wraps), self.variants.posed, *first, feats[0], known[0])
        here, mask = np.empty((1, len(search.axes), *size), np.float32), np.empty((1, *size), np.float32)
        reduce_kernels.coarse_templates(feats, known, f, search.mean, search.axes, search.clip, here, mask)
        map_ = here[0].astype(np.float64)
        parts = [fourier.rfft2(a, shape) for a in (*map_, mask[0].astype(np.float64), (map_**2).sum(axis=0))]
        *axes, usable, squares = self._spectra[v]
        total = parts[-1] * usable + parts[-2] * squares
        for mine, theirs in zip(parts[:-2], axes, strict=True):
            total -= 2 * mine * theirs
        cost, count = (
            np.rint(fourier.irfft2(product, shape)).astype(np.int64)[beyond[0] :: -1, beyond[1] :: -1]
            if min(beyond) >= 0 else np.zeros((0, 0), np.int64)
            for product in (total, parts[-2] * usable)
        )  # fmt: skip
        allowed = search.valid[v]
        rows, columns = (min(a, b) for a, b in zip(allowed.shape, cost.shape, strict=True))
        cost, count = cost[:rows, :columns], count[:rows, :columns]
        there = allowed[:rows, :columns] & (count > 0)
        return np.where(there, np.maximum(cost, 0) * FINE // np.maximum(count, 1), NEVER)

    def _followed(
        self, v: int, rows: Array, variant: Array, yx: Array, at: tuple[int, int], wraps: tuple[bool, bool]
    ) -> Array:
        """Follow coarse positions to full resolution; those that lead nowhere are dropped."""
        all_, patch = self.variants, self.search.patch
        size = all_.picture(v).shape
        around = size[0] - patch[0], size[1] - patch[1]
        step = max(1, max(size[0] + around[0], size[1] + around[1]) // SAMPLES)
        placement_kernels.follow(
            windows.Grown(variant, yx, wraps), self.pieces, at, patch, all_.valid[v], around, self.factor, step, rows
        )  # fmt: skip
        return rows[rows[:, 0] >= 0]


def pieces_of(variants: PosedExemplars, exemplars: Sequence[Exemplar], unseen: int = 0) -> Pieces:
    """Return the variants as kernels of seams take them: with every pixel, whether it may be shown.

    The last `unseen` channels are left out: what is not seen makes no seam.
    """
    parts = []
    for v in range(len(variants)):
        rows, columns = variants.picture(v).shape[:2]
        usable = exemplars[int(variants.exemplar[v])].usable
        if usable is None:
            parts.append(np.ones(rows * columns, np.uint8))
            continue
        posed = pose_array(usable, int(variants.pose[v]))
        pad = ((0, rows - posed.shape[0]), (0, columns - posed.shape[1]))
        parts.append(np.pad(posed, pad, mode="wrap").astype(np.uint8).ravel())
    (flat, table), seen = variants.posed, variants.channels - unseen
    if unseen:
        flat = np.ascontiguousarray(flat.reshape(-1, variants.channels)[:, :seen]).ravel()
        table = table.copy()
        table[:, 0] = table[:, 0] // variants.channels * seen
    return Pieces(flat, table, np.concatenate(parts), variants.toroidal, seen)
