"""The exemplars' energy under masks of known pixels: what the patch search needs of every window."""

from __future__ import annotations

from threading import Lock
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from . import reduce_kernels

MASKS = 64
Array = NDArray[Any]


class Masks:
    """Sums of squares under masks, kept: few masks occur again and again.

    Parameters
    ----------
    padded : list of (rows, columns)
        For every variant the shape that its spectra belong to.
    spectra : list of arrays
        Spectra of the variants' squares.
    shapes : list of (rows, columns)
        How many positions of each variant are looked at.
    """

    def __init__(
        self, padded: list[tuple[int, int]], spectra: list[Array], shapes: list[tuple[int, ...]]
    ) -> None:
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
                product = self.spectra[v] * np.conj(scipy.fft.rfft2(mask.astype(np.float64), shape))
                self._squares[v][slot] = np.rint(scipy.fft.irfft2(product, shape)[:rows, :columns])
        return slot

    def _forget(self) -> None:
        # Fresh arrays: another thread may still be reading the old ones.
        self._known: dict[int, int] = {}
        self._squares = [np.empty((MASKS, *shape), np.int32) for shape in self.shapes]
