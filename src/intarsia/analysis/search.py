"""The patch search: which patches of the exemplars fit best over what is already known.

A short-list is found on reduced pictures by FFT, for all positions at once; its members are then followed to
full resolution and measured exactly. Everything that decides is a whole number, so the list is the same on
every machine. Used by all methods that lay patches.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from threading import local
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from ..kernels import match, nearest, reduce, windows
from ..lazy import lazy
from .axes import principal_axes
from .masks import Masks
from .variants import Variants

if TYPE_CHECKING:
    from scipy import ndimage
else:  # only masked exemplars need it
    ndimage = lazy("scipy.ndimage")

SHORT_LIST = 16
AXES = 2
ENOUGH, ENOUGH_EXACT = 0.97, 0.8  # share of the variance that one axis must hold to do alone
STEPS, FINE_STEPS = 31, 63  # reduced pictures are whole numbers up to this; the exact search wants finer ones
ROUNDING = 1e-7  # a correlation in single precision is wrong by at most this share of the norms (measured: 9.3e-8)
BATCH_BYTES = 2 << 20  # spectra of one batch: what stays in a core's cache
FINEST_SIDE = 600  # reduced exemplars are at most about this large
Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Candidates:
    """What fits one window: rows of (distance, variant, row, column), best first, and the usual distance.

    ``usual`` is the 5 % quantile of the distance over all positions, in units of the exact distance; ``feats``
    and ``known`` are what the window holds; ``free`` says that nothing is known in it yet: any patch fits.
    """

    rows: NDArray[np.int64]
    usual: int
    feats: Array
    known: Array
    free: bool = False


@dataclass(frozen=True, eq=False)
class Reduced:
    """Windows as the search compares them: energies, spectra by shape, and the exemplars' energy under their masks.

    ``slots`` says which of the ``squares`` of every variant belongs to which window.
    """

    energies: Array
    slots: Array
    squares: list[Array]
    spectra: dict[tuple[int, int], Array]


@dataclass(frozen=True, eq=False)
class Prices:
    """What the short-list is told of repeats.

    ``counts``: for every variant an int32 map over its coarse positions, 256 = one full repeat. Such a repeat
    costs ``weight`` / 65536 of the usual distance; with ``multiply`` distances are multiplied by 1 + repeats.
    """

    counts: list[Array]
    weight: int
    multiply: bool = False


class Search(Protocol):
    """A way to find patches: what growing a map needs of it.

    ``valid``: for every variant the positions that can be found, each for `factor` x `factor` px of it; ``cells``:
    the patch in such units.
    """

    variants: Variants
    patch: tuple[int, int]
    valid: list[Array]
    factor: int
    cells: tuple[int, int]

    def batch(self) -> int:
        """How many windows are best searched together."""

    def find(self, variant: Array, yx: Array, at: Array, wrap: tuple[bool, bool], prices: Prices) -> list[Candidates]:
        """Return the candidates for the windows that begin at `at` (n, 2) of a growing map."""


class PatchSearch:
    """Search patches of one size in a set of variants.

    Parameters
    ----------
    variants : Variants
        Posed exemplars, laid out for the patch size.
    patch : (rows, columns)
        Size of the windows.
    exact : bool
        Search every position at full resolution, in place of the reduced short-list.
    factor : int
        By what pictures are reduced; 0: as it suits exemplars and patch.
    """

    factor: int
    tails = 3.0  # the reduced pictures are cut off at so many standard deviations

    def __init__(
        self, variants: Variants, patch: tuple[int, int], overlap: int, exact: bool = False, listed: int = SHORT_LIST,
        factor: int = 0,
    ) -> None:  # fmt: skip
        self.variants, self.patch, self.listed = variants, patch, listed
        self.exact = exact
        self.factor = factor or (1 if exact else _factor(variants, patch, overlap))
        self.cells = (patch[0] // self.factor, patch[1] // self.factor)
        self.mean, self.axes, self.scale, self.clip = self._reduction()
        self._padded = local()
        self._load()
        self._masks = Masks(self.coarse, self.square_spectra, [v.shape for v in self.valid])

    def within(self, valid: Sequence[Array]) -> PatchSearch:
        """Return the same search among some patches only: of every variant, where they may begin."""
        narrow = copy.copy(self)
        narrow._limit(valid)
        narrow.valid = [v if v.any() else np.zeros((0, 0), bool) for v in narrow.valid]  # these are not even looked at
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
        if self.exact:  # as fine as single precision allows
            size = math.sqrt(n * math.prod(self.cells)) * len(axes) / self.factor
            clip = min(max(int(self.tails * math.sqrt(0.4 / (ROUNDING * 1.2 * size))), STEPS), FINE_STEPS)
        scale = min(clip / (3.0 * math.sqrt(max(kept / len(axes), 1.0))), 1.0)
        return mean, np.rint(axes * scale * (1 << 24)).astype(np.int64), scale, clip

    def _load(self) -> None:
        f, (h, w) = self.factor, self.cells
        self.coarse, self.spectra, self.square_spectra, total = [], [], [], 0.0
        for v in range(len(self.variants)):
            picture = reduce.coarse_picture(self.variants.picture(v), f, self.mean, self.axes, self.clip)
            rows, columns = picture.shape[1:]
            shape = (scipy.fft.next_fast_len(rows, real=False), scipy.fft.next_fast_len(columns, real=True))
            energy = (picture.astype(np.float64) ** 2).sum(axis=0)
            self.coarse.append(shape)
            self.spectra.append(scipy.fft.rfft2(picture.astype(np.float64), shape))
            total = max(total, float(energy.sum()))
            self.square_spectra.append(scipy.fft.rfft2(energy, shape))
        self._limit(self.variants.valid)
        # Correlations are whole numbers. Where single precision could miss one by half, double precision is used.
        window = 1.2 * math.sqrt(h * w * len(self.axes)) * self.clip / self.tails
        single = ROUNDING * window * math.sqrt(total) < 0.45
        self.real = np.float32 if single else np.float64
        self.spectra = [s.astype(np.complex64 if single else np.complex128) for s in self.spectra]

    def _limit(self, valid: Sequence[Array]) -> None:
        """Search among these first pixels only."""
        f, (h, w) = self.factor, self.cells
        self.valid, offsets, begin = [], [], 0
        for v, allowed in enumerate(valid):
            height, stride = self.variants.picture(v).shape[:2]
            self.valid.append(_reachable(allowed, f, max(height // f - h + 1, 0), max(stride // f - w + 1, 0)))
            offsets.append((begin, *allowed.shape))
            begin += allowed.size
        self.offsets = np.array(offsets, np.int64)
        self.flat_valid = np.concatenate([allowed.astype(np.uint8).ravel() for allowed in valid])

    def batch(self) -> int:
        """How many windows are best searched together."""
        size = max(a * (b // 2 + 1) for a, b in self.coarse) * 8 * (len(self.axes) + 1)
        return max(1, min(32, BATCH_BYTES // size))

    def find(self, variant: Array, yx: Array, at: Array, wrap: tuple[bool, bool], prices: Prices) -> list[Candidates]:
        """Return the candidates for the windows that begin at `at` (n, 2) of a growing map.

        `wrap`: whether rows and columns of the canvas continue in themselves; `prices`: what repeats cost.
        """
        n = len(at)
        feats, known = self.windows(variant, yx, at, wrap)
        reduced = self.reduce(feats, known)
        slots, squares, energies = reduced.slots, reduced.squares, reduced.energies
        best = np.empty((n, self.listed, 4), np.int64)
        counts, usual = np.zeros(n, np.int64), np.full(n, -1, np.int64)
        correlations = {v: self.correlations(v, reduced) for v in range(len(self.coarse)) if self.valid[v].size}
        for v, correlation in correlations.items():
            match.short_list(
                correlation, squares[v], slots, energies, self.valid[v], prices.counts[v], prices.weight,
                prices.multiply, v, best, counts, usual,
            )  # fmt: skip
        found = np.empty((n, self.listed, 4), np.int64)
        match.refine_all(
            feats, known, self.variants.flat, self.variants.table, self.flat_valid, self.offsets, best, counts,
            self.factor, found,
        )  # fmt: skip
        for v, correlation in correlations.items() if self.exact else ():
            nearest.complete(
                correlation, squares[v], slots, energies, self.valid[v], v, len(self.axes), self.scale, feats, known,
                self.variants.flat, self.variants.table, found, counts,
            )  # fmt: skip
        return [
            Candidates(found[k, : max(c, 0)], self.full(u), feats[k], known[k], free=c < 0)
            for k, (c, u) in enumerate(zip(counts.tolist(), usual.tolist(), strict=True))
        ]

    def windows(self, variant: Array, yx: Array, at: Array, wrap: tuple[bool, bool]) -> tuple[Array, Array]:
        """Read what the windows that begin at `at` hold: features (n, h, w, C), and where there are any."""
        n, (h, w) = len(at), self.patch
        feats, known = np.empty((n, h, w, self.variants.channels), np.int16), np.empty((n, h, w), np.uint8)
        windows.gather_all(variant, yx, self.variants.flat, self.variants.table, at, wrap, feats, known)
        return feats, known

    def reduce(self, feats: Array, known: Array) -> Reduced:
        """Reduce windows (n, h, w, C) as the exemplars are reduced."""
        templates = np.empty((len(feats), len(self.axes), *self.cells), self.real)
        masks = np.empty((len(feats), *self.cells), np.float32)
        energies = reduce.coarse_templates(feats, known, self.factor, self.mean, self.axes, self.clip, templates, masks)
        slots, squares = self._masks.slots(masks)
        return Reduced(energies, slots, squares, {shape: self._spectra(templates, shape) for shape in set(self.coarse)})

    def full(self, coarse: int) -> int:
        """Return a distance of reduced pictures in units of the exact distance."""
        return max(round(coarse * (self.factor**2 / self.scale**2)), 0)

    def _spectra(self, templates: Array, shape: tuple[int, int]) -> Array:
        """Transform the templates, padded to `shape`: (n, K, p, rows / p, columns), frequency p k + r at [r, k].

        Their rows come first, which are few. Down the columns most is padding: p short transforms of the rows,
        each turned by what its frequencies differ, do the work of a long one (decimation in frequency).
        """
        rows = scipy.fft.rfft(templates, shape[1], axis=3)
        parts = next(p for p in (4, 2, 1) if shape[0] % p == 0 and shape[0] // p >= rows.shape[2])
        size = (*rows.shape[:2], parts, shape[0] // parts, rows.shape[3])
        padded = getattr(self._padded, str(shape), None)  # of this thread: overwritten by the next windows
        if padded is None or len(padded) < len(rows):
            padded = np.empty(size, rows.dtype)
            setattr(self._padded, str(shape), padded)
        padded = padded[: len(rows)]
        turns = np.exp(-2j * np.pi / shape[0] * np.outer(np.arange(parts), np.arange(rows.shape[2])))
        match.turn(rows, turns.astype(rows.dtype), padded)
        return np.asarray(scipy.fft.fft(padded, axis=3, overwrite_x=True))

    def correlations(self, v: int, reduced: Reduced) -> Array:
        """Correlate windows with variant `v`: (n, rows, columns) for every coarse position."""
        shape, rows = self.coarse[v], self.valid[v].shape[0]
        spectra = reduced.spectra[shape]
        product = np.empty((len(spectra), shape[0], spectra.shape[4]), spectra.dtype)
        match.correlate(self.spectra[v], spectra, product)
        inner = scipy.fft.ifft(product, axis=1, overwrite_x=True)[:, :rows]
        return np.asarray(scipy.fft.irfft(inner, shape[1], axis=2))


def every_patch(valid: Sequence[Array]) -> Array:
    """All patches that are `valid`, variant by variant, as rows of candidates not measured yet: (n, 4)."""
    places = [np.argwhere(allowed) for allowed in valid]
    rows = np.zeros((sum(map(len, places)), 4), np.int64)
    rows[:, 1] = np.repeat(np.arange(len(places)), [len(p) for p in places])
    rows[:, 2:] = np.concatenate(places)
    return rows


def measured(variants: Variants, found: Candidates, rows: Array) -> Candidates:
    """Return the nearest among given patches (n, 4) in place of the short-list's."""
    out = np.empty((SHORT_LIST, 4), np.int64)
    count = nearest.best_of(found.feats, found.known, variants.flat, variants.table, rows, out)
    return replace(found, rows=out[:count])


def _factor(variants: Variants, patch: tuple[int, int], overlap: int) -> int:
    """Reduce by 2 or more: until the exemplar is small, while patch and overlap keep their shape."""
    side = int(variants.table[:, 1:3].max())
    factor = 2
    while side / factor > FINEST_SIDE and min(patch) // (2 * factor) >= 16 and overlap // (2 * factor) >= 4:
        factor *= 2
    return factor if min(patch) >= 8 and overlap >= 2 else 1


def _reachable(valid: Array, factor: int, rows: int, columns: int) -> Array:
    """Coarse positions from which refinement can reach a valid patch."""
    if not valid.size:
        return np.zeros((0, 0), bool)
    if valid.all():
        return np.ones((rows, columns), bool)
    near = ndimage.maximum_filter(valid.astype(np.uint8), size=2 * factor - 1, mode="constant")
    y = np.minimum(np.arange(rows) * factor, valid.shape[0] - 1)
    x = np.minimum(np.arange(columns) * factor, valid.shape[1] - 1)
    return near[np.ix_(y, x)].astype(bool)
