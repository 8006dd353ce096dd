"""The places of an exemplar that may fit a border best, short-listed by Fourier transforms."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft2, next_fast_len, rfft2

Array = NDArray[Any]


class ShortList:
    """Leave those of many places that may fit a border best, by one Fourier transform (eq. 4.5, S1-33).

    Its rounding errors decide nothing: places that are as good up to far more than these stay, to be compared in
    whole numbers.
    """

    def __init__(
        self, picture: Array, ring: Array, sums: tuple[Array, Array], correlate: bool, everywhere: Array | None
    ) -> None:
        self.size = tuple(next_fast_len(n, real=k == 1) for k, n in enumerate(picture.shape[:2]))
        self.ring, self.sums, self.correlate = ring, sums, correlate
        self.known = None if everywhere is None else self._sums(everywhere)
        self.spectra = [rfft2(channel.astype(np.float64), self.size) for channel in np.moveaxis(picture, 2, 0)]

    def best(self, border: Array, places: Array) -> Array:
        """The places (n, 2) among which is the best for a border (n C,), all ties included, in their order."""
        values = border.reshape(len(self.ring), -1).astype(np.float64)
        total: Any = 0.0
        for c, spectrum in enumerate(self.spectra):
            laid = np.zeros(self.size)
            laid[self.ring[:, 0], self.ring[:, 1]] = values[:, c]
            total = total + spectrum * np.conj(rfft2(laid))
        product = irfft2(total, self.size)[places[:, 0], places[:, 1]]
        sums, squares, energy = self.known or self._sums(places)
        if not self.correlate:
            loss = energy - 2 * product
            return np.asarray(places[loss <= loss.min() + 1e-6 * max(1.0, float(energy.max()))])
        n, own, own_squares = len(self.ring), values.sum(axis=0), (values * values).sum(axis=0)
        spread = (n * squares - sums * sums) * (n * own_squares - own * own)
        below = np.sqrt(np.maximum(spread, 0)).sum(axis=1)
        fit = np.where(below > 0, (n * product - sums @ own) / np.maximum(below, 1.0), 0.0)
        return np.asarray(places[fit >= fit.max() - 1e-5])

    def _sums(self, places: Array) -> tuple[Array, Array, Array]:
        sums, squares = (s[places[:, 0], places[:, 1]].astype(np.float64) for s in self.sums)
        return sums, squares, squares.sum(axis=1)
