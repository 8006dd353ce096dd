"""The places of an exemplar that may fit a border best, short-listed by Fourier transforms."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.fft import fft, ifft, irfft, next_fast_len, rfft

from ...analysis.sums import running_sums
from ...arrays import Array

ERROR = 1e-5  # of two lengths' product: far above what rounding in single precision does to a sum of products
MOST = 0.9  # share of a picture's variance in its main colours


class ShortList:
    """Leave those of many places that may fit a border best, by Fourier transforms (Lopez Recas 2011, eq. 4.5).

    Rounding errors decide nothing: a place that may be the best but for them stays, to be compared in whole numbers.
    Of squared differences only the main axes of colour are transformed, mostly one, from dark to bright: a place that
    differs more along these than another does in all channels cannot be the best.
    """

    def __init__(self, picture: Array, ring: Array, sums: tuple[Array, Array], correlate: bool) -> None:
        self.picture, self.ring = picture, ring
        self.flat = [s.reshape(-1, picture.shape[2]).astype(np.float64) for s in sums]
        self.tall, self.wide = (int(n) + 1 for n in ring[:, :2].max(axis=0))
        self.size = tuple(next_fast_len(n, real=k == 1) for k, n in enumerate(picture.shape[:2]))
        self.mean = picture.mean(axis=(0, 1))
        centred = picture - self.mean
        self.axes = np.eye(len(self.mean)) if correlate else _main_colours(centred)
        seen = np.ascontiguousarray(np.moveaxis(centred @ self.axes, 2, 0), np.float32)
        self.length = float(np.sqrt(np.square(seen, dtype=np.float64).sum()))
        self.spectra = [fft(rfft(plane, self.size[1]), self.size[0], axis=0) for plane in seen]
        self.energy = None if correlate else self._energy(np.square(seen, dtype=np.float64).sum(axis=0))

    def best(self, border: Array, places: Array) -> Array:
        """The places (n, 2) among which is the best for a border (n C,), all ties included, in their order."""
        values = border.reshape(len(self.ring), -1)
        own = (values - self.mean) @ self.axes
        product = self._products(own.astype(np.float32))
        at = places[:, 0] * product.shape[1] + places[:, 1]
        if self.energy is not None:
            return self._least(values, own, product, places, at)
        return self._correlated(values, own, product.reshape(-1)[at], places, at)

    def _least(self, values: Array, own: Array, product: Array, places: Array, at: Array) -> Array:
        """Those that differ no more in the main colours than one of them does in all channels."""
        length = float(np.sqrt((own * own).sum()))
        least = (self.energy - 2 * product).reshape(-1)[at] + length * length
        y, x = self.ring[:, :2].T + places[int(np.argmin(least))][:, None]
        known = int(np.square(self.picture[y, x].astype(np.int64) - values).sum())
        return np.asarray(places[least <= known + ERROR * (known + 4 * length * self.length)])

    def _correlated(self, values: Array, own: Array, product: Array, places: Array, at: Array) -> Array:
        """Those that may correlate best (GNCC of all channels)."""
        n, exact = len(self.ring), values.astype(np.float64)
        sums, squares = (s.take(at, axis=0) for s in self.flat)
        own_sums, own_squares = exact.sum(axis=0), np.square(exact).sum(axis=0)
        spread = (n * squares - sums * sums) * (n * own_squares - own_sums * own_sums)
        below = np.sqrt(np.maximum(spread, 0)).sum(axis=1)
        covered = n * product - (sums - n * self.mean) @ (own_sums - n * self.mean)
        fit = np.where(below > 0, covered / np.maximum(below, 1.0), 0.0)
        error = ERROR * n * self.length * float(np.sqrt((own * own).sum())) / np.maximum(below, 1.0) * (below > 0)
        return np.asarray(places[fit + error >= (fit - error).max() - ERROR])

    def _products(self, own: Array) -> Array:
        """Sums of products of a border (n, k) and every place of the exemplar: (h, w)."""
        rows, columns = (n - m + 1 for n, m in zip(self.picture.shape, (self.tall, self.wide), strict=False))
        laid = np.zeros((self.tall, self.wide), np.float32)
        total: Any = 0.0
        for spectrum, values in zip(self.spectra, own.T, strict=True):
            laid[self.ring[:, 0], self.ring[:, 1]] = values
            mine = fft(rfft(laid, self.size[1]), self.size[0], axis=0, overwrite_x=True)
            total = total + spectrum * np.conj(mine, out=mine)
        lines = ifft(total, axis=0, overwrite_x=True)[:rows]  # no border begins in the rows below
        return np.asarray(irfft(lines, self.size[1]))[:, :columns]

    def _energy(self, squares: Array) -> Array:
        """Add up squares (H, W) in the border of every place: (h, w)."""
        running = running_sums(squares, np.float64)
        rows, columns = running.shape[0] - self.tall, running.shape[1] - self.wide
        hole = np.ones((self.tall, self.wide), bool)
        hole[self.ring[:, 0], self.ring[:, 1]] = False
        inner = np.argwhere(hole)
        boxes = [(1, 0, 0, self.tall, self.wide)]
        if len(inner):
            boxes.append((-1, *inner[0].tolist(), *(inner[-1] + 1).tolist()))
        total = np.zeros((rows, columns))
        for sign, y0, x0, y1, x1 in boxes:
            for y, x, part in ((y1, x1, sign), (y0, x1, -sign), (y1, x0, -sign), (y0, x0, sign)):
                total += part * running[y : y + rows, x : x + columns]
        return total.astype(np.float32)


def _main_colours(centred: Array) -> Array:
    """The fewest directions of colour (C, k), each of length 1, that hold most of how a picture (H, W, C) varies."""
    flat = centred.reshape(-1, centred.shape[2])
    spread, directions = np.linalg.eigh(flat.T @ flat)  # the strongest last; which way they point does not matter here
    held = spread[::-1].cumsum() >= MOST * spread.sum()
    return np.asarray(directions[:, ::-1][:, : int(held.argmax()) + 1])
