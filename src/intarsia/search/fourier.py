"""The patch search: which patches of the exemplars fit best over what is already known.

A short-list is found on reduced pictures by FFT, for all positions at once; its members are then followed to
full resolution and measured exactly. Everything that decides is a whole number, so the list is the same on
every machine. Used by all methods that lay patches.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy import fft

from ..analysis.sums import principal_axes
from ..arrays import Array
from ..errors import ParameterError
from ..kernels import returns, windows
from . import exhaustive_kernels, fourier_kernels
from . import reduce_kernels as reduce
from .candidates import SHORT_LIST, Candidates, Prices, Reduced
from .posed import PosedExemplars, in_one_row
from .reduce_kernels import Listed
from .transforms import Correlator, Masks

AXES = 2
ENOUGH, ENOUGH_EXACT = 0.97, 0.8  # share of the variance that one axis must hold to do alone
STEPS, FINE_STEPS = 31, 63  # reduced pictures are whole numbers up to this; the exact search wants finer ones
FINENESS = 1.2e-7  # how fine the reduced pictures of the exact search are, for exemplars and patches of each size
BATCH_BYTES = 2 << 20  # spectra of one batch: what stays in a core's cache
FINEST_SIDE = 600  # reduced exemplars are at most about this large
NOWHERE = np.zeros((0, 0), bool)  # a variant without any patch is not even looked at


class PatchSearch:
    """Search patches of one size in a set of variants.

    `patch`, for which the variants are laid out: rows and columns of the windows; `exact`: search every position at
    full resolution, in place of the reduced short-list; `listed`: candidates returned; `factor`: by what pictures are
    reduced; 0: as it suits exemplars and patch.
    """

    factor: int
    tails = 3.0  # the reduced pictures are cut off at so many standard deviations

    def __init__(
        self, variants: PosedExemplars, patch: tuple[int, int], overlap: int, exact: bool = False,
        listed: int = SHORT_LIST, factor: int = 0,
    ) -> None:  # fmt: skip
        self.variants, self.patch, self.listed = variants, patch, listed
        self.exact = exact
        self.factor = factor or (1 if exact else _factor(variants, patch, overlap))
        self.cells = (patch[0] // self.factor, patch[1] // self.factor)
        self.mean, self.axes, self.scale, self.clip = self._reduction()
        pictures = [
            reduce.coarse_picture(variants.picture(v), self.factor, self.mean, self.axes, self.clip)
            for v in range(len(variants))
        ]
        self.correlator = Correlator(pictures, self.cells)
        self.coarse = self.correlator.shapes
        (h, w), sizes = self.cells, [p.shape[1:] for p in pictures]
        self._places = [(max(rows - h + 1, 0), max(columns - w + 1, 0)) for rows, columns in sizes]
        energies = [(p.astype(np.float64) ** 2).sum(axis=0) for p in pictures]
        squares = [fft.rfft2(e, shape) for e, shape in zip(energies, self.coarse, strict=True)]
        self._limit(variants.valid)
        self._masks = Masks(self.coarse, squares, [v.shape for v in self.valid])

    def within(self, valid: Sequence[Array]) -> PatchSearch:
        """Return the same search among some patches only: of every variant, where they may begin."""
        narrow = copy.copy(self)
        narrow._limit(valid)
        narrow.valid = [v if v.any() else NOWHERE for v in narrow.valid]
        return narrow

    def _reduction(self) -> tuple[Array, Array, float, int]:
        """Mean, the axes along which the reduced pictures vary most, the scale of these pictures, and their range.

        Two axes hold nearly all that colours say about likeness, in most photographs one does (measured: its best
        patches are 0.1 % worse); what they miss the exact distance finds. The scale makes the standard deviation
        about a third of the range.
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
        if self.exact:  # as fine as is quick: single precision does where windows are not too lively
            size = math.sqrt(n * math.prod(self.cells)) * len(axes) / self.factor
            clip = min(max(int(self.tails * math.sqrt(0.4 / (FINENESS * size))), STEPS), FINE_STEPS)
        clip = min(clip, most_steps(self.patch, self.cells, len(axes)))
        scale = min(clip / (3.0 * math.sqrt(max(kept / len(axes), 1.0))), 1.0)
        return mean, np.rint(axes * scale * (1 << 24)).astype(np.int64), scale, clip

    def _limit(self, valid: Sequence[Array]) -> None:
        """Search among these first pixels only."""
        self.flat_valid, self.offsets = in_one_row(valid)
        self.valid = list(map(self._reachable, self._places, valid))

    def _reachable(self, shape: tuple[int, int], allowed: Array) -> Array:
        """Coarse positions, so many rows and columns, from which refinement can reach a patch that is allowed."""
        out = np.empty(shape if allowed.size else (0, 0), bool)
        returns.reachable(allowed.view(np.uint8), self.factor, out.view(np.uint8))
        return out

    @property
    def unpriced(self) -> Prices:
        """Prices of which none is more than 0."""
        return Prices([np.zeros(v.shape, np.int32) for v in self.valid], 0)

    def batch(self) -> int:
        """How many windows are best searched together."""
        size = max(a * (b // 2 + 1) for a, b in self.coarse) * 8 * (len(self.axes) + 1)
        return max(1, min(32, (BATCH_BYTES << self.exact) // size))

    def find(self, variant: Array, yx: Array, at: Array, wrap: tuple[bool, bool], prices: Prices) -> list[Candidates]:
        """Return the candidates for the windows that begin at `at` (n, 2) of a growing map."""
        return self.search(*self.windows(variant, yx, at, wrap), prices)

    def search(
        self, feats: Array, known: Array, prices: Prices, among: Callable[[int, Array], Array | None] | None = None
    ) -> list[Candidates]:
        """Return the candidates for windows that hold `feats` (n, h, w, C) int16 where `known` (n, h, w) uint8 is 1.

        `among` is asked with the number of a window and its candidates: where it answers with a flat uint8 table like
        ``flat_valid``, the candidates are the best of its patches instead.
        """
        n, reduced = len(feats), self.reduce(feats, known)
        best, found = np.empty((n, self.listed, 4), np.int64), np.empty((n, self.listed, 4), np.int64)
        counts, usual = np.zeros(n, np.int64), np.full(n, -1, np.int64)
        correlations = {v: self.correlations(v, reduced) for v, valid in enumerate(self.valid) if valid.size}
        self._rank(feats, known, reduced, correlations, prices, (best, counts, usual, found))
        for k in range(n) if among else ():
            table = among(k, found[k, : counts[k]]) if among and counts[k] >= 0 else None
            if table is not None:
                one = slice(k, k + 1)
                some, counts[k] = {v: c[one] for v, c in correlations.items()}, 0
                out = best[one], counts[one], usual[one], found[one]
                among_it = self.within([table[b : b + h * w].reshape(h, w) for b, h, w in self.offsets.tolist()])
                among_it._rank(feats[one], known[one], reduced.only(one), some, prices, out)
        return Candidates.of_all(found, counts, list(map(self.full, usual.tolist())), feats, known)

    def _rank(
        self, feats: Array, known: Array, reduced: Reduced, correlations: dict[int, Array], prices: Prices,
        out: tuple[Array, Array, Array, Array],
    ) -> None:  # fmt: skip
        """Short-list positions by their correlations, and measure them: into (best, counts, usual, found)."""
        best, counts, usual, found = out
        listed, posed = Listed(best, counts, usual), self.variants.posed
        every = [reduced.correlated(v, c, self.valid[v]) for v, c in correlations.items() if self.valid[v].size]
        for mine in every:
            fourier_kernels.short_list(mine, prices.of(mine.variant), listed)
        among = fourier_kernels.Among(self.flat_valid, self.offsets)
        fourier_kernels.refine_all(feats, known, posed, among, best, counts, self.factor, found)
        for mine in every if self.exact else ():
            exhaustive_kernels.complete(mine, len(self.axes), self.scale, feats, known, posed, found, counts)

    def windows(self, variant: Array, yx: Array, at: Array, wrap: tuple[bool, bool]) -> tuple[Array, Array]:
        """Read what the windows that begin at `at` hold: features (n, h, w, C), and where there are any."""
        n, (h, w) = len(at), self.patch
        feats, known = np.empty((n, h, w, self.variants.channels), np.int16), np.empty((n, h, w), np.uint8)
        windows.gather_all(windows.Grown(variant, yx, wrap), self.variants.posed, at, feats, known)
        return feats, known

    def reduce(self, feats: Array, known: Array) -> Reduced:
        """Reduce windows (n, h, w, C) as the exemplars are."""
        templates = np.empty((len(feats), len(self.axes), *self.cells), np.float32)
        masks = np.empty((len(feats), *self.cells), np.float32)
        energies = reduce.coarse_templates(feats, known, self.factor, self.mean, self.axes, self.clip, templates, masks)
        slots, squares = self._masks.slots(masks)
        templates = templates.astype(self.correlator.precision(energies), copy=False)
        return Reduced(energies, slots, squares, self.correlator.spectra(templates))

    def full(self, coarse: int) -> int:
        """Return a distance of reduced pictures in units of the exact distance."""
        return max(round(coarse * (self.factor**2 / self.scale**2)), 0)

    def correlations(self, v: int, reduced: Reduced) -> Array:
        """Correlate windows with variant `v`: (n, rows, columns) for every coarse position."""
        return self.correlator.correlations(v, reduced.spectra, self.valid[v].shape[0])


def most_steps(patch: tuple[int, int], cells: tuple[int, int], axes: int) -> int:
    """Return the highest whole number of reduced pictures whose squared distances stay below 2**31.

    ParameterError where a patch is so large that even -1 to 1 is too much.
    """
    most = math.isqrt((int(fourier_kernels.NONE) - 1) // (4 * axes * max(math.prod(cells), 1)))
    if most < 1:
        raise ParameterError(f"patch={patch[1]}x{patch[0]} px is too large to search for; choose at most 16384 px.")
    return most


def _factor(variants: PosedExemplars, patch: tuple[int, int], overlap: int) -> int:
    """Reduce by 2 or more: until the exemplar is small, while patch and overlap keep their shape."""
    side = int(variants.table[:, 1:3].max())
    factor = 2
    while side / factor > FINEST_SIDE and min(patch) // (2 * factor) >= 16 and overlap // (2 * factor) >= 4:
        factor *= 2
    return factor if min(patch) >= 8 and overlap >= 2 else 1
