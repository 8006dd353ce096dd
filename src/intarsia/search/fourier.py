"""Patch search by masked FFT correlation on reduced pictures, refined to exact distances at full resolution.

All decisions are made on whole numbers, so the candidates are the same on every machine. The reduced pictures are whole
numbers, so their correlations are, too: results of the transforms, in double precision, are rounded to them, and their
errors are about a billionth of what could change the rounding.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy import fft

from ..analysis import principal_axes
from ..foundation import ParameterError
from ..foundation.arrays import Array, Pair
from ..foundation.filters import fast_length
from ..kernels.maps import PartialMap
from . import SHORT_LIST, Candidates, PosedExemplars, Prices, Reduced, fourier_kernels, in_one_row
from .fourier_kernels import Listed

MASKS = 64  # masks of known cells for which the exemplars' sums of squares are cached


AXES = 2  # channels of a reduced picture, at most
ENOUGH, ENOUGH_EXACT = 0.97, 0.8  # share of the variance on one principal axis from which it is used alone
STEPS, FINE_STEPS = 31, 63  # largest absolute value of reduced pictures: default, and limit in the exact search
TAILS = 3.0  # reduced pictures are clipped at so many standard deviations
FINENESS = 1.2e-7  # limits the values of the exact search by size of exemplars and patch: the larger, the coarser
BATCH_BYTES = 4 << 20  # bytes of spectra of the windows searched at a time, which fit into a core's cache
FINEST_SIDE = 600  # px: reduction goes on while the longer side of a reduced exemplar is larger, if patches allow
NOWHERE = np.zeros((0, 0), bool)  # stands for a variant without any valid patch, which is skipped


class PatchSearch:
    """Searches patches of one size in a set of variants.

    Pictures are reduced by `factor` and projected on one or two principal axes. Distances at all coarse positions are
    computed by FFT; the best are refined to full resolution and measured exactly.

    Parameters
    ----------
    variants : PosedExemplars
        Made for patches of this size.
    patch : (rows, columns)
        Size of windows and patches, px.
    overlap : int
        Overlap of neighbouring windows, px, by which the reduction is chosen.
    exact : bool
        Do not reduce the resolution, and also find the best patch of all exactly.
    listed : int
        Number of candidates returned.
    factor : int
        Reduction; 0: chosen by exemplars, patch and overlap.
    """

    factor: int

    def __init__(
        self, variants: PosedExemplars, patch: Pair, overlap: int, exact: bool = False,
        listed: int = SHORT_LIST, factor: int = 0,
    ) -> None:  # fmt: skip
        self.variants, self.patch, self.listed = variants, patch, listed
        self.exact = exact
        self.factor = factor or (1 if exact else _factor(variants, patch, overlap))
        self.cells = (patch[0] // self.factor, patch[1] // self.factor)
        self.mean, self.axes, self.scale, self.clip = self._reduction()
        pictures = [self._reduced(variants.picture(v)) for v in range(len(variants))]
        sizes = [p.shape[1:] for p in pictures]
        self.padded = [(fast_length(h), fast_length(w)) for h, w in sizes]
        self._spectra = [fft.rfft2(p, shape) for p, shape in zip(pictures, self.padded, strict=True)]
        h, w = self.cells
        self._places = [(max(rows - h + 1, 0), max(columns - w + 1, 0)) for rows, columns in sizes]
        self._squares = [fft.rfft2((p**2).sum(axis=0), shape) for p, shape in zip(pictures, self.padded, strict=True)]
        self._limit(variants.valid)
        self._under = lru_cache(MASKS)(self._energies)  # few masks occur, each many times

    def _energies(self, mask: bytes) -> list[Array]:
        """Return the sums of squares of each variant under a mask of cells (its bytes), at every coarse position."""
        cells, out = np.frombuffer(mask, np.uint8).reshape(self.cells).astype(np.float64), []
        for squares, shape, valid in zip(self._squares, self.padded, self.valid, strict=True):
            sums = fft.irfft2(squares * np.conj(fft.rfft2(cells, shape)), shape)
            out.append(np.rint(sums[: valid.shape[0], : valid.shape[1]]).astype(np.int32))
        return out

    def within(self, valid: Sequence[Array]) -> PatchSearch:
        """Return the same search restricted to some first pixels of each variant."""
        narrow = copy.copy(self)
        narrow._limit(valid)
        narrow.valid = [v if v.any() else NOWHERE for v in narrow.valid]
        return narrow

    def _reduction(self) -> tuple[Array, Array, float, int]:
        """Return mean, principal axes, scale and range of the reduced pictures.

        Two axes hold nearly all of the variance of colours, and one does in most photographs (measured: the best
        patches found with it are 0.1 % worse); the exact distance corrects the order. The scale makes the standard
        deviation about a third of the range. Axes are returned times the scale, in 2**-24.
        """
        c = self.variants.channels
        total, products, n = np.zeros(c, np.int64), np.zeros((c, c), np.int64), 0
        for v in range(len(self.variants)):
            picture = self.variants.picture(v).reshape(-1, c).astype(np.float64)  # whole numbers: exact sums
            total += picture.sum(axis=0).astype(np.int64)
            products += (picture.T @ picture).astype(np.int64)
            n += len(picture)
        mean = total // n
        covariance = products / n - np.outer(total / n, total / n)
        kept, axes = principal_axes(covariance, 1)
        if kept < (ENOUGH_EXACT if self.exact else ENOUGH) * float(np.trace(covariance)):
            kept, axes = principal_axes(covariance, min(c, AXES))
        clip = STEPS
        if self.exact:  # the larger the coarser; other limits would change the candidates
            size = math.sqrt(n * math.prod(self.cells)) * len(axes) / self.factor
            clip = min(max(int(TAILS * math.sqrt(0.4 / (FINENESS * size))), STEPS), FINE_STEPS)
        clip = min(clip, most_steps(self.patch, self.cells, len(axes)))
        scale = min(clip / (TAILS * math.sqrt(max(kept / len(axes), 1.0))), 1.0)
        return mean, np.rint(axes * scale * (1 << 24)).astype(np.int64, order="C"), scale, clip

    def _limit(self, valid: Sequence[Array]) -> None:
        """Restrict the search to these first pixels."""
        self.flat_valid, self.offsets = in_one_row(valid)
        self.valid = list(map(self._reachable, self._places, valid))

    def _reachable(self, shape: Pair, allowed: Array) -> Array:
        """Return the coarse positions (rows, columns) from which refinement can reach an allowed patch.

        `shape`: number of coarse positions; `allowed`: the valid first pixels of a variant.
        """
        if not allowed.size:
            return NOWHERE
        beyond = self.factor - 1
        for axis, length in enumerate(shape):
            at = np.minimum(np.arange(length) * self.factor, allowed.shape[axis] - 1)
            wide = np.pad(allowed, [(beyond, beyond) if a == axis else (0, 0) for a in (0, 1)])
            allowed = np.logical_or.reduce([wide.take(at + k, axis) for k in range(2 * beyond + 1)])
        return np.asarray(allowed)

    def _reduced(self, picture: Array) -> Array:
        """Return the reduced picture (K, rows, columns) of (H, W, C): whole numbers, as float64."""
        cells = [n // self.factor for n in picture.shape[:2]]
        out = np.zeros((1, len(self.axes), *cells))
        known, masks = np.ones((1, *picture.shape[:2]), np.uint8), np.empty((1, *cells), np.uint8)
        fourier_kernels.coarse(picture[None], known, self.factor, self.mean, self.axes, self.clip, out, masks)
        return np.asarray(out[0])

    def batch(self) -> int:
        """Return how many windows are best searched at a time."""
        size = max(a * (b // 2 + 1) for a, b in self.padded) * 16 * (len(self.axes) + 1)
        return max(1, min(32, (BATCH_BYTES << self.exact) // size))

    def find(self, grown: PartialMap, at: Array, prices: Prices) -> list[Candidates]:
        """Return the candidates for the windows that begin at `at` (n, 2) of a map under synthesis."""
        feats, known = self.variants.windows(grown, at, self.patch)
        reduced, usual = self.reduce(feats, known), np.full(len(at), -1, np.int64)
        correlations = {v: self.correlations(v, reduced) for v, valid in enumerate(self.valid) if valid.size}
        best, counts, _ = self.short_list(reduced, correlations, prices, usual)  # refined and measured exactly below
        found, posed = np.empty_like(best), self.variants.posed
        among = fourier_kernels.Among(self.flat_valid, self.offsets)
        fourier_kernels.refine(feats, known, posed, among, best, counts, self.factor, found)
        for v, values in correlations.items() if self.exact else ():
            if self.valid[v].size:
                mine = reduced.correlated(v, values, self.valid[v])
                fourier_kernels.complete(mine, len(self.axes), self.scale, feats, known, posed, found, counts)
        return Candidates.of_all(found, counts, list(map(self.full, usual.tolist())), feats, known)

    def short_list(
        self, reduced: Reduced, correlations: dict[int, Array], prices: Prices, usual: Array
    ) -> Listed:
        """Return the short-lists of n windows, by their correlations with each variant.

        `usual` (n,): the usual distance of each, in units of reduced pictures; where it is -1, it is computed and
        written.
        """
        n = len(usual)
        listed = Listed(np.empty((n, self.listed, 4), np.int64), np.zeros(n, np.int64), usual)
        for v, values in correlations.items():
            if self.valid[v].size:
                mine = reduced.correlated(v, values, self.valid[v])
                fourier_kernels.short_list(mine, prices.counts[v], prices.weight, listed)
        return listed

    def reduce(self, feats: Array, known: Array) -> Reduced:
        """Return windows (n, h, w, C) reduced as the exemplars are; `known` (n, h, w): 1 where a pixel is known."""
        templates = np.zeros((len(feats), len(self.axes), *self.cells))
        masks = np.empty((len(feats), *self.cells), np.uint8)
        energies = fourier_kernels.coarse(
            feats, known, self.factor, self.mean, self.axes, self.clip, templates, masks
        )
        slots = dict[bytes, int]()
        numbers = np.array([slots.setdefault(mask.tobytes(), len(slots)) for mask in masks], np.int64)
        squares = list(map(np.stack, zip(*map(self._under, slots), strict=True)))
        spectra = {shape: _conjugates(templates, shape) for shape in set(self.padded)}
        return Reduced(energies, numbers, squares, spectra)

    def full(self, coarse: int) -> int:
        """Return a squared distance of reduced pictures, converted to units of the exact distance."""
        return max(round(coarse * (self.factor**2 / self.scale**2)), 0)

    def correlations(self, v: int, reduced: Reduced) -> Array:
        """Return the correlations of windows with variant `v`: (n, >= rows, >= columns) for every coarse position."""
        pictures, (height, width) = self._spectra[v], self.padded[v]
        windows = reduced.spectra[height, width]
        product = pictures[0] * windows[:, 0]
        for k in range(1, len(pictures)):
            product += pictures[k] * windows[:, k]
        rows = fft.ifft(product, axis=1, out=product)[:, : len(self.valid[v])]
        return np.asarray(fft.irfft(rows, width, axis=2))


def _conjugates(templates: Array, shape: Pair) -> Array:
    """Return the conjugate spectra of windows (n, K, rows, columns), padded to `shape`.

    Rows are transformed first, then columns, so that rows of padding need no transform.
    """
    rows = fft.rfft(templates, shape[1], axis=3)
    return np.asarray(fft.ifft(rows.conj(), shape[0], axis=2, norm="forward"))


def most_steps(patch: Pair, cells: Pair, axes: int) -> int:
    """Return the highest whole number of reduced pictures whose squared distances stay below 2**31.

    ParameterError where a patch is so large that even -1 to 1 is too much.
    """
    most = math.isqrt((int(fourier_kernels.NONE) - 1) // (4 * axes * max(math.prod(cells), 1)))
    if most < 1:
        raise ParameterError(f"patch={patch[1]}x{patch[0]} px is too large to search for; choose at most 16384 px.")
    return most


def _factor(variants: PosedExemplars, patch: Pair, overlap: int) -> int:
    """Return the reduction: 2, doubled while exemplars are larger than FINEST_SIDE and patch and overlap remain large.

    A patch keeps at least 16 cells, an overlap 4. 1 for patches below 8 px or overlaps below 2 px.
    """
    side = int(variants.table[:, 1:3].max())
    factor = 2
    while side / factor > FINEST_SIDE and min(patch) // (2 * factor) >= 16 and overlap // (2 * factor) >= 4:
        factor *= 2
    return factor if min(patch) >= 8 and overlap >= 2 else 1
