"""The patch search: which patches of the exemplars fit best over what is already known.

A short-list is found on reduced pictures by FFT, for all positions at once; its members are then followed to
full resolution and measured exactly. Everything that decides is a whole number, so the list is the same on
every machine. Used by all methods that lay patches.

Correlations of pictures of whole numbers are whole, and rounded to them. What a transform in floating point is wrong by
is bounded by the norms of what it correlates. Single precision is used where that bound fits, for most windows of most
textures, and double precision elsewhere: the numbers are the same.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from functools import cache
from threading import Lock, local
from typing import Any

import numpy as np
from scipy import fft

from ..analysis.sums import principal_axes
from ..arrays import Array, Pair
from ..errors import ParameterError
from ..kernels.windows import Grown
from . import fourier_kernels
from .candidates import SHORT_LIST, Candidates, PosedExemplars, Prices, Reduced, in_one_row
from .fourier_kernels import Listed

ROUNDING = 3e-7
"""By which share of the two norms a correlation in single precision may be wrong, at most: so much for windows far
smaller than the picture, and in proportion up to twice as much for those as long as it. Measured over plates, stripes
and checks of all sizes: 2.5e-7 and 4.6e-7 (docs/design/002)."""

MASKS = 64  # whose sums of squares are kept
FITS = 0.45  # errors below a half leave the nearest whole number what it is; the rest is for adding 1/2 in floats


class Correlator:
    """Correlate windows with pictures of whole numbers.

    `pictures`, float32 (K, rows, columns) each: a correlation adds up all K; `cells`: rows and columns of the windows.
    """

    def __init__(self, pictures: list[Array], cells: Pair) -> None:
        self.pictures = pictures
        self.shapes = [
            (fft.next_fast_len(p.shape[1], real=False), fft.next_fast_len(p.shape[2], real=True)) for p in pictures
        ]
        self.norms = [math.sqrt(float((p.astype(np.float64) ** 2).sum())) for p in pictures]
        self.error = max(  # of single precision, for windows of norm 1
            ROUNDING * (1.0 + max(n / max(m, 1) for n, m in zip(cells, p.shape[1:], strict=True))) * norm
            for p, norm in zip(pictures, self.norms, strict=True)
        )
        self._padded, self._lock = local(), Lock()
        self._made: dict[Any, list[Array]] = {}

    def precision(self, energies: Array) -> Any:
        """Return in which floats windows of these energies (sums of squares) must be, so that rounding is exact."""
        return np.float32 if self.error * math.sqrt(float(energies.max(initial=0))) < FITS else np.float64

    def correlations(self, v: int, spectra: dict[Pair, Array], rows: int) -> Array:
        """Correlate windows, by their :meth:`spectra`, with picture `v`: (n, rows, columns) for every position.

        Only the first `rows` are made.
        """
        mine = spectra[self.shapes[v]]
        product = np.empty((len(mine), self.shapes[v][0], mine.shape[4]), mine.dtype)
        fourier_kernels.correlate(self._transformed(mine.dtype.type)[v], mine, product)
        inner = fft.ifft(product, axis=1, overwrite_x=True)[:, :rows]
        return np.asarray(fft.irfft(inner, self.shapes[v][1], axis=2))

    def spectra(self, templates: Array) -> dict[Pair, Array]:
        """Transform windows (n, K, rows, columns), floats of their :meth:`precision`, padded as the pictures are."""
        return {shape: self._spectra(templates, shape) for shape in set(self.shapes)}

    def _transformed(self, kind: Any) -> list[Array]:
        """The spectra of all pictures, complex64 or complex128, made when they are first asked for."""
        with self._lock:
            if kind not in self._made:
                self._made[kind] = [
                    fft.rfft2(p.astype(np.float64), shape).astype(kind)
                    for p, shape in zip(self.pictures, self.shapes, strict=True)
                ]
            return self._made[kind]

    def _spectra(self, templates: Array, shape: Pair) -> Array:
        """Transform windows, padded to `shape`: (n, K, p, rows / p, columns), frequency p k + r at [r, k].

        Their rows come first, which are few. Down the columns most is padding: p short transforms of the rows,
        each turned by what its frequencies differ, do the work of a long one (decimation in frequency).
        """
        rows = fft.rfft(templates, shape[1], axis=3)
        parts = next(p for p in (4, 2, 1) if shape[0] % p == 0 and shape[0] // p >= rows.shape[2])
        size = (*rows.shape[:2], parts, shape[0] // parts, rows.shape[3])
        name = f"{shape}{rows.dtype}"
        padded = getattr(self._padded, name, None)  # of this thread: overwritten by the next windows
        if padded is None or len(padded) < len(rows):
            padded = np.empty(size, rows.dtype)
            setattr(self._padded, name, padded)
        padded = padded[: len(rows)]
        fourier_kernels.turn(rows, _turns(shape[0], parts, rows.shape[2]).astype(rows.dtype, copy=False), padded)
        return np.asarray(fft.fft(padded, axis=3, overwrite_x=True))


class Masks:
    """Sums of squares under masks, kept: few masks occur again and again.

    For every variant: `padded`, the rows and columns that its spectra belong to; `spectra` of its squares; `shapes`,
    the rows and columns of the positions that are looked at.
    """

    def __init__(self, padded: list[Pair], spectra: list[Array], shapes: list[tuple[int, ...]]) -> None:
        self.padded, self.spectra, self.shapes, self._lock = padded, spectra, shapes, Lock()
        self._forget()

    def slots(self, masks: Array) -> tuple[Array, list[Array]]:
        """Number of each mask (n, rows, columns), and the sums of squares under the numbered masks."""
        with self._lock:
            if len(self._known) + len(masks) > MASKS:
                self._forget()
            keys = fourier_kernels.mask_keys(masks).tolist()
            return np.array([self._slot(*pair) for pair in zip(keys, masks, strict=True)], np.int64), self._squares

    def _slot(self, key: int, mask: Array) -> int:
        slot = self._known.get(key)
        if slot is None:
            slot = self._known[key] = len(self._known)
            for v, (shape, (rows, columns)) in enumerate(zip(self.padded, self.shapes, strict=True)):
                product = self.spectra[v] * np.conj(fft.rfft2(mask.astype(np.float64), shape))
                self._squares[v][slot] = np.rint(fft.irfft2(product, shape)[:rows, :columns])
        return slot

    def _forget(self) -> None:
        # Fresh arrays: another thread may still be reading the old ones.
        self._known: dict[int, int] = {}
        self._squares = [np.empty((MASKS, *shape), np.int32) for shape in self.shapes]


@cache
def _turns(length: int, parts: int, rows: int) -> Array:
    return np.asarray(np.exp(-2j * np.pi / length * np.outer(np.arange(parts), np.arange(rows))))


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
        self, variants: PosedExemplars, patch: Pair, overlap: int, exact: bool = False,
        listed: int = SHORT_LIST, factor: int = 0,
    ) -> None:  # fmt: skip
        self.variants, self.patch, self.listed = variants, patch, listed
        self.exact = exact
        self.factor = factor or (1 if exact else _factor(variants, patch, overlap))
        self.cells = (patch[0] // self.factor, patch[1] // self.factor)
        self.mean, self.axes, self.scale, self.clip = self._reduction()
        pictures = [
            fourier_kernels.coarse_picture(variants.picture(v), self.factor, self.mean, self.axes, self.clip)
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
        return mean, np.rint(axes * scale * (1 << 24)).astype(np.int64, order="C"), scale, clip

    def _limit(self, valid: Sequence[Array]) -> None:
        """Search among these first pixels only."""
        self.flat_valid, self.offsets = in_one_row(valid)
        self.valid = list(map(self._reachable, self._places, valid))

    def _reachable(self, shape: Pair, allowed: Array) -> Array:
        """Coarse positions, so many rows and columns, from which refinement can reach a patch that is allowed."""
        out = np.empty(shape if allowed.size else (0, 0), bool)
        fourier_kernels.reachable(allowed.view(np.uint8), self.factor, out.view(np.uint8))
        return out

    @property
    def unpriced(self) -> Prices:
        """Prices of which none is more than 0."""
        return Prices([np.zeros(v.shape, np.int32) for v in self.valid], 0)

    def batch(self) -> int:
        """How many windows are best searched together."""
        size = max(a * (b // 2 + 1) for a, b in self.coarse) * 8 * (len(self.axes) + 1)
        return max(1, min(32, (BATCH_BYTES << self.exact) // size))

    def find(self, grown: Grown, at: Array, prices: Prices) -> list[Candidates]:
        """Return the candidates for the windows that begin at `at` (n, 2) of a growing map."""
        return self.search(*self.variants.windows(grown, at, self.patch), prices)

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
            fourier_kernels.complete(mine, len(self.axes), self.scale, feats, known, posed, found, counts)

    def reduce(self, feats: Array, known: Array) -> Reduced:
        """Reduce windows (n, h, w, C) as the exemplars are."""
        templates = np.empty((len(feats), len(self.axes), *self.cells), np.float32)
        masks = np.empty((len(feats), *self.cells), np.float32)
        energies = fourier_kernels.coarse_templates(
            feats, known, self.factor, self.mean, self.axes, self.clip, templates, masks
        )
        slots, squares = self._masks.slots(masks)
        templates = templates.astype(self.correlator.precision(energies), copy=False)
        return Reduced(energies, slots, squares, self.correlator.spectra(templates))

    def full(self, coarse: int) -> int:
        """Return a distance of reduced pictures in units of the exact distance."""
        return max(round(coarse * (self.factor**2 / self.scale**2)), 0)

    def correlations(self, v: int, reduced: Reduced) -> Array:
        """Correlate windows with variant `v`: (n, rows, columns) for every coarse position."""
        return self.correlator.correlations(v, reduced.spectra, self.valid[v].shape[0])


def most_steps(patch: Pair, cells: Pair, axes: int) -> int:
    """Return the highest whole number of reduced pictures whose squared distances stay below 2**31.

    ParameterError where a patch is so large that even -1 to 1 is too much.
    """
    most = math.isqrt((int(fourier_kernels.NONE) - 1) // (4 * axes * max(math.prod(cells), 1)))
    if most < 1:
        raise ParameterError(f"patch={patch[1]}x{patch[0]} px is too large to search for; choose at most 16384 px.")
    return most


def _factor(variants: PosedExemplars, patch: Pair, overlap: int) -> int:
    """Reduce by 2 or more: until the exemplar is small, while patch and overlap keep their shape."""
    side = int(variants.table[:, 1:3].max())
    factor = 2
    while side / factor > FINEST_SIDE and min(patch) // (2 * factor) >= 16 and overlap // (2 * factor) >= 4:
        factor *= 2
    return factor if min(patch) >= 8 and overlap >= 2 else 1
