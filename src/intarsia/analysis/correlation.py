"""How well a picture agrees with itself for every way of moving it over itself, where they overlap only in part.

A picture of bricks agrees again and again: the peaks of that agreement are its lattice.

Source: Lopez Recas 2011 (near-regular textures), sections 3.1 and 3.2, eq. 3.3 and 3.13. Departures: only one picture
and itself are compared, so the misprint of eq. 3.8, which shows where sizes differ, cannot occur. Every sum is that of
the part that overlaps, whose ends are kept inside the picture, so sums beyond the last row cannot either.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ..arrays import Array, Floats, Mask, Pair
from . import running_sums

Spans = tuple[NDArray[np.intp], NDArray[np.intp]]

FLAT = 1e-9  # of the largest variance: less is rounding, and says nothing


def autocorrelation(
    picture: Array, usable: Mask | None = None, reach: Pair | None = None
) -> tuple[Floats, Floats]:
    """Correlate a picture with itself at every offset over the pixels that then overlap, and count these.

    A channel counts by its contrast in the overlap, so a constant one counts nothing.

    Parameters
    ----------
    picture : array, shape (H, W) or (H, W, C)
    usable : bool array, shape (H, W), optional
        False where pixels do not count.
    reach : (rows, columns), optional
        The largest offsets wanted, px. None: all, (H - 1, W - 1).

    Returns
    -------
    correlation, pairs : float64 arrays, shape (2 rows + 1, 2 columns + 1)
        Offset 0 is in the middle, where the correlation is 1 unless the picture is constant. Both are the
        same at opposite offsets. `pairs` holds whole numbers.
    """
    rows, columns = (min(n - 1, r) for n, r in zip(picture.shape[:2], reach or picture.shape[:2], strict=True))
    down, right = np.arange(rows + 1), np.arange(-columns, columns + 1)
    if usable is None:
        f = _centred(picture)
        half, pairs = _from_rectangles(f, down, right), overlaps(f.shape, down, right)
    else:
        half, pairs = _from_mask(picture, usable.astype(np.float64), down, right)
    half[0, :columns] = half[0, :columns:-1]  # opposite offsets agree to the last bit
    return _mirrored(half), _mirrored(pairs)


def _centred(picture: Array) -> Floats:
    """A picture (H, W, C) without each channel's mean: correlations do not change, rounding errors shrink."""
    floats = picture.reshape(*picture.shape[:2], -1).astype(np.float64)
    return np.asarray(floats - floats.mean(axis=(0, 1)))


def _mirrored(half: Floats) -> Floats:
    return np.concatenate([half[:0:-1, ::-1], half])


def products(f: Floats, g: Floats, down: Array, right: Array) -> Floats:
    """Sum f(x) g(x - lag) over x, for every lag (down, right)."""
    size = _padded(f, g, down, right)
    transformed = fft.rfft2(f, size)
    both = np.abs(transformed) ** 2 if f is g else transformed * np.conj(fft.rfft2(g, size))
    return _at_lags(both, size, down, right)


def overlaps(shape: tuple[int, ...], down: Array, right: Array) -> Floats:
    """Count the pixels (H, W) that lie on one another for every lag (down, right)."""
    return np.asarray(np.multiply.outer(shape[0] - np.abs(down), shape[1] - np.abs(right)), np.float64)


def gaussian(shape: tuple[int, ...], sigma: float) -> Floats:
    """Return by what the cosine transform of a picture (H, W) is multiplied to blur it, its borders mirrored."""
    decay = [np.pi * np.arange(n) / n for n in shape]
    return np.asarray(np.exp(-0.5 * sigma * sigma * (decay[0][:, None] ** 2 + decay[1] ** 2)))


def _padded(f: Floats, g: Floats, down: Array, right: Array) -> list[int]:
    """The smallest fast transform in which no wanted lag meets another."""
    size = []
    for axis, lag in ((0, down), (1, right)):
        needed = max(f.shape[axis] - int(lag.min()), g.shape[axis] + int(lag.max()), f.shape[axis], g.shape[axis])
        size.append(int(fft.next_fast_len(needed, real=axis == 1)))
    return size


def _at_lags(spectrum: Array, size: list[int], down: Array, right: Array) -> Floats:
    result: Floats = fft.irfft2(spectrum, size)[np.ix_(down % size[0], right % size[1])]
    return result


def _from_rectangles(f: Floats, down: Array, right: Array) -> Floats:
    """Eq. 3.13 where all pixels count: one transform per channel, all other sums by running sums."""
    here = _span(down, f.shape[0]), _span(right, f.shape[1])
    there = _span(-down, f.shape[0]), _span(-right, f.shape[1])
    n = overlaps(f.shape, down, right)
    size = _padded(f, f, down, right)
    spectrum: Any = 0.0
    above, below, largest = np.zeros(n.shape), np.zeros(n.shape), 0.0
    for own in np.moveaxis(f, 2, 0):
        transformed = fft.rfft2(own, size)
        spectrum = spectrum + transformed * np.conj(transformed)
        sums, squares = (running_sums(values, np.float64) for values in (own, own * own))
        before, after = _inside(sums, *here), _inside(sums, *there)
        above -= before * after
        spread_here = _clamped(n * _inside(squares, *here) - before * before)
        spread_there = _clamped(n * _inside(squares, *there) - after * after)
        below += np.sqrt(spread_here * spread_there)
        largest = max(largest, float((own * own).sum()))
    above += n * _at_lags(spectrum, size, down, right)
    return _ratio(above, below, FLAT * n * largest)


def _from_mask(picture: Array, mask: Floats, down: Array, right: Array) -> tuple[Floats, Floats]:
    """Eq. 3.13 of a picture with itself where some pixels do not count: overlaps are no rectangles, all is transformed.

    Also returns how many pixels each offset compares.
    """
    floats = picture.reshape(*picture.shape[:2], -1).astype(np.float64)
    f = (floats - np.tensordot(mask, floats, 2) / max(mask.sum(), 1.0)) * mask[..., None]
    size = _padded(f, f, down, right)
    counted = fft.rfft2(mask, size)

    def product(one: Array, other: Array) -> Floats:
        return _at_lags(one * np.conj(other), size, down, right)

    n = np.rint(product(counted, counted))
    above, below, largest = np.zeros(n.shape), np.zeros(n.shape), 0.0
    for own in np.moveaxis(f, 2, 0):
        plain, squared = (fft.rfft2(part, size) for part in (own, own * own))
        before, after = product(plain, counted), product(counted, plain)
        above += n * product(plain, plain) - before * after
        below += np.sqrt(
            _clamped(n * product(squared, counted) - before * before)
            * _clamped(n * product(counted, squared) - after * after)
        )
        largest = max(largest, float((own * own).sum()))
    return _ratio(above, below, FLAT * n * largest), n


def _span(lag: Array, length: int) -> Spans:
    """First and last + 1 of so many rows that these, moved by `lag`, lie on."""
    return np.maximum(lag, 0), np.minimum(lag + length, length)


def _inside(total: Floats, rows: Spans, columns: Spans) -> Floats:
    """Sum what is inside every rectangle of `rows` and `columns`, by running sums."""
    bands = total[rows[1]] - total[rows[0]]
    result: Floats = bands[:, columns[1]] - bands[:, columns[0]]
    return result


def _clamped(values: Floats) -> Floats:
    return np.maximum(values, 0.0, out=values)


def _ratio(above: Floats, below: Floats, flat: Floats) -> Floats:
    counts = below > flat
    return np.clip(np.where(counts, above / np.where(counts, below, 1.0), 0.0), -1.0, 1.0)
