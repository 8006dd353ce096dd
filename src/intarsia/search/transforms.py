"""Exact correlations by Fourier transform: of pictures of whole numbers they are whole, and rounded to them.

What a transform in floating point is wrong by is bounded by the norms of what it correlates. Single precision is used
where that bound fits, for most windows of most textures, and double precision elsewhere: the numbers are the same.
"""

from __future__ import annotations

import math
from functools import cache
from threading import Lock, local
from typing import Any

import numpy as np
from scipy import fft

from ..arrays import Array
from . import fourier_kernels, reduce_kernels

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

    def __init__(self, pictures: list[Array], cells: tuple[int, int]) -> None:
        self.pictures = pictures
        self.shapes = [
            (fft.next_fast_len(p.shape[1], real=False), fft.next_fast_len(p.shape[2], real=True))
            for p in pictures
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

    def correlations(self, v: int, spectra: dict[tuple[int, int], Array], rows: int) -> Array:
        """Correlate windows, by their :meth:`spectra`, with picture `v`: (n, rows, columns) for every position.

        Only the first `rows` are made.
        """
        mine = spectra[self.shapes[v]]
        product = np.empty((len(mine), self.shapes[v][0], mine.shape[4]), mine.dtype)
        fourier_kernels.correlate(self._transformed(mine.dtype.type)[v], mine, product)
        inner = fft.ifft(product, axis=1, overwrite_x=True)[:, :rows]
        return np.asarray(fft.irfft(inner, self.shapes[v][1], axis=2))

    def spectra(self, templates: Array) -> dict[tuple[int, int], Array]:
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

    def _spectra(self, templates: Array, shape: tuple[int, int]) -> Array:
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

    def __init__(self, padded: list[tuple[int, int]], spectra: list[Array], shapes: list[tuple[int, ...]]) -> None:
        self.padded, self.spectra, self.shapes, self._lock = padded, spectra, shapes, Lock()
        self._forget()

    def slots(self, masks: Array) -> tuple[Array, list[Array]]:
        """Number of each mask (n, rows, columns), and the sums of squares under the numbered masks."""
        with self._lock:
            if len(self._known) + len(masks) > MASKS:
                self._forget()
            keys = reduce_kernels.mask_keys(masks).tolist()
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
