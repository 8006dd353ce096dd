"""How well two pictures agree for every way of laying one over the other, even where they overlap only in part.

Moved over itself, a picture of bricks agrees again and again: the peaks of that agreement are its lattice.

Source: Lopez Recas 2011 (near-regular textures), sections 3.1 and 3.2, eq. 3.3 and 3.13; with a hole,
section 4.2.2. Departures: the printed eq. 3.8 takes the sums of g at the wrong place
unless both pictures are equal in size. Here every sum is that of the rectangle that overlaps, whose ends are
kept inside the picture, for f and g alike, so that neither the misprint nor sums beyond the last row can occur.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ..errors import InputError
from .sums import running_sums

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Spans = tuple[NDArray[np.intp], NDArray[np.intp]]

FLAT = 1e-9  # of the largest variance: less is rounding, and says nothing


def gncc(
    f: NDArray[Any], g: NDArray[Any], usable_f: Mask | None = None, usable_g: Mask | None = None
) -> Floats:
    """Correlate two pictures at every offset, each offset over the pixels that then overlap.

    Parameters
    ----------
    f, g : arrays, shape (H, W) or (H, W, C)
        Any sizes, equally many channels. A channel counts by its contrast in the overlap, so a constant one
        counts nothing.
    usable_f, usable_g : bool arrays, shape (H, W), optional
        False where pixels do not count: a mask, or the hole of a border that looks for its patch.

    Returns
    -------
    float64 array, shape (Hf + Hg - 1, Wf + Wg - 1)
        Entry (y + Hg - 1, x + Wg - 1) is the correlation, -1 to 1, with the upper left pixel of `g` laid on
        pixel (y, x) of `f`. 0 where nothing, or nothing but constant colour, overlaps.

    Raises
    ------
    InputError
        where the channels differ in number, a picture is empty, or a mask does not fit.
    """
    f, g = _checked(f, usable_f), _checked(g, usable_g)
    if f.shape[2] != g.shape[2]:
        raise InputError(f"the pictures have {f.shape[2]} and {g.shape[2]} channels; give equally many.")
    lags = [np.arange(1 - b, a) for a, b in zip(f.shape[:2], g.shape[:2], strict=True)]
    if usable_f is None and usable_g is None:
        return _from_rectangles(_centred(f, None), _centred(g, None), lags[0], lags[1])
    return _from_masks(f, g, _weights(f, usable_f), _weights(g, usable_g), lags[0], lags[1])[0]


def autocorrelation(
    picture: NDArray[Any], usable: Mask | None = None, reach: tuple[int, int] | None = None
) -> tuple[Floats, Floats]:
    """Correlate a picture with itself, and count the pixels that each offset compares.

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
    f = _checked(picture, usable)
    rows, columns = (n - 1 for n in f.shape[:2]) if reach is None else reach
    rows, columns = min(rows, f.shape[0] - 1), min(columns, f.shape[1] - 1)
    down, right = np.arange(rows + 1), np.arange(-columns, columns + 1)
    if usable is None:
        f = _centred(f, None)
        half = _from_rectangles(f, f, down, right)
        pairs = overlaps(f.shape[:2], down, right)
    else:
        mask = _weights(f, usable)
        half, pairs = _from_masks(f, f, mask, mask, down, right)
    half[0, :columns] = half[0, :columns:-1]  # opposite offsets agree to the last bit
    return _mirrored(half), _mirrored(pairs)


def _checked(picture: NDArray[Any], usable: Mask | None) -> Floats:
    if picture.ndim not in (2, 3) or not picture.size:
        raise InputError(f"an array of shape {picture.shape} is no picture; give (height, width, channels).")
    if usable is not None and usable.shape != picture.shape[:2]:
        raise InputError(f"the mask has shape {usable.shape}, the picture {picture.shape[:2]}; make them equal.")
    floats: Floats = picture.reshape(*picture.shape[:2], -1).astype(np.float64)
    return floats


def _weights(picture: Floats, usable: Mask | None) -> Floats:
    return np.ones(picture.shape[:2]) if usable is None else usable.astype(np.float64)


def _centred(picture: Floats, weights: Floats | None) -> Floats:
    """Take away each channel's mean: correlations do not change, rounding errors shrink."""
    if weights is None:
        centred: Floats = picture - picture.mean(axis=(0, 1))
    else:
        centred = (picture - np.tensordot(weights, picture, 2) / max(weights.sum(), 1.0)) * weights[..., None]
    return centred


def _mirrored(half: Floats) -> Floats:
    return np.concatenate([half[:0:-1, ::-1], half])


def products(f: Floats, g: Floats, down: NDArray[Any], right: NDArray[Any]) -> Floats:
    """Sum f(x) g(x - lag) over x, for every lag (down, right)."""
    size = _padded(f, g, down, right)
    transformed = fft.rfft2(f, size)
    both = np.abs(transformed) ** 2 if f is g else transformed * np.conj(fft.rfft2(g, size))
    return _at_lags(both, size, down, right)


def overlaps(shape: tuple[int, ...], down: NDArray[Any], right: NDArray[Any]) -> Floats:
    """Count the pixels (H, W) that lie on one another for every lag (down, right)."""
    return np.asarray(np.multiply.outer(shape[0] - np.abs(down), shape[1] - np.abs(right)), np.float64)


def gaussian(shape: tuple[int, ...], sigma: float) -> Floats:
    """Return by what the cosine transform of a picture (H, W) is multiplied to blur it, its borders mirrored."""
    decay = [np.pi * np.arange(n) / n for n in shape]
    return np.asarray(np.exp(-0.5 * sigma * sigma * (decay[0][:, None] ** 2 + decay[1] ** 2)))


def _padded(f: Floats, g: Floats, down: NDArray[Any], right: NDArray[Any]) -> list[int]:
    """The smallest fast transform in which no wanted lag meets another."""
    size = []
    for axis, lag in ((0, down), (1, right)):
        needed = max(f.shape[axis] - int(lag.min()), g.shape[axis] + int(lag.max()), f.shape[axis], g.shape[axis])
        size.append(int(fft.next_fast_len(needed, real=axis == 1)))
    return size


def _at_lags(spectrum: NDArray[Any], size: list[int], down: NDArray[Any], right: NDArray[Any]) -> Floats:
    result: Floats = fft.irfft2(spectrum, size)[np.ix_(down % size[0], right % size[1])]
    return result


def _from_rectangles(f: Floats, g: Floats, down: NDArray[Any], right: NDArray[Any]) -> Floats:
    """Eq. 3.13 where all pixels count: one transform per channel, all other sums by running sums."""
    spans_f = _span(down, f.shape[0], g.shape[0]), _span(right, f.shape[1], g.shape[1])
    spans_g = _span(-down, g.shape[0], f.shape[0]), _span(-right, g.shape[1], f.shape[1])
    n = np.multiply.outer(spans_f[0][1] - spans_f[0][0], spans_f[1][1] - spans_f[1][0]).astype(np.float64)
    size = _padded(f, g, down, right)
    spectrum: Any = 0.0
    above, below, largest = np.zeros(n.shape), np.zeros(n.shape), 0.0
    for c in range(f.shape[2]):
        own_f, own_g = f[..., c], g[..., c]
        transformed = fft.rfft2(own_f, size)
        spectrum = spectrum + transformed * np.conj(transformed if f is g else fft.rfft2(own_g, size))
        sums_f, squares_f = (running_sums(own, np.float64) for own in (own_f, own_f * own_f))
        sums_g, squares_g = (
            (sums_f, squares_f) if f is g else (running_sums(own, np.float64) for own in (own_g, own_g * own_g))
        )
        sum_f, sum_g = _inside(sums_f, *spans_f), _inside(sums_g, *spans_g)
        above -= sum_f * sum_g
        spread_f = _clamped(n * _inside(squares_f, *spans_f) - sum_f * sum_f)
        spread_g = _clamped(n * _inside(squares_g, *spans_g) - sum_g * sum_g)
        below += np.sqrt(spread_f * spread_g)
        largest = max(largest, float((own_f * own_f).sum()), float((own_g * own_g).sum()))
    above += n * _at_lags(spectrum, size, down, right)
    return _ratio(above, below, FLAT * n * largest)


def _from_masks(
    f: Floats, g: Floats, mf: Floats, mg: Floats, down: NDArray[Any], right: NDArray[Any]
) -> tuple[Floats, Floats]:
    """Eq. 3.13 where some pixels do not count: all sums by transforms, as the overlap is no rectangle."""
    size, alike = _padded(f, g, down, right), f is g and mf is mg
    f = _centred(f, mf)
    g = f if alike else _centred(g, mg)
    mask_f, waves_f = _transformed(f, mf, size)
    mask_g, waves_g = (mask_f, waves_f) if alike else _transformed(g, mg, size)

    def product(one: NDArray[Any], other: NDArray[Any]) -> Floats:
        return _at_lags(one * np.conj(other), size, down, right)

    n = np.rint(product(mask_f, mask_g))
    above, below, largest = np.zeros(n.shape), np.zeros(n.shape), 0.0
    for c in range(f.shape[2]):
        own_f, own_g = f[..., c], g[..., c]
        (plain_f, squared_f), (plain_g, squared_g) = waves_f[c], waves_g[c]
        sum_f, sum_g = product(plain_f, mask_g), product(mask_f, plain_g)
        spread_f = _clamped(n * product(squared_f, mask_g) - sum_f * sum_f)
        spread_g = _clamped(n * product(mask_f, squared_g) - sum_g * sum_g)
        above += n * product(plain_f, plain_g) - sum_f * sum_g
        below += np.sqrt(spread_f * spread_g)
        largest = max(largest, float((own_f * own_f).sum()), float((own_g * own_g).sum()))
    return _ratio(above, below, FLAT * n * largest), n


def _transformed(f: Floats, mask: Floats, size: list[int]) -> tuple[NDArray[Any], list[list[NDArray[Any]]]]:
    """The transforms of a mask, and of the values and squares of each channel."""
    own = [[fft.rfft2(part, size) for part in (f[..., c], f[..., c] * f[..., c])] for c in range(f.shape[2])]
    return fft.rfft2(mask, size), own


def _span(lag: NDArray[Any], mine: int, other: int) -> Spans:
    """First and last + 1 of my rows that the other one, moved by `lag`, lies on."""
    return np.maximum(lag, 0), np.minimum(lag + other, mine)


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
