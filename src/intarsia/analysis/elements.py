"""Size of the elements (texels) of a texture, from the first minima of its autocorrelation; the autocorrelation itself.

A patch smaller than one element cuts all of them, so patch methods choose their patches by the size of the elements. It
is measured in the autocorrelation of the exemplar: the first minimum along a direction is at the offset that puts
bright elements on the dark gaps between them, about half an element.

The function :func:`autocorrelation` normalises at every offset over the overlap of the picture with itself; its peaks
form the lattice of a near-regular texture.

Source of the autocorrelation: Lopez Recas 2011 (near-regular textures), sections 3.1 and 3.2, eq. 3.3 and 3.13. The
rule for sizes is our own, chosen by eye and by measuring 12 photographs. Departures: a picture is compared with itself
only, so eq. 3.8, in which sizes are misprinted if they differ, is not needed. All sums are those of the overlap, whose
ends are limited to the picture.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from ..foundation.arrays import Array, Floats, Int16, Mask, Pair
from ..foundation.filters import blurred, fast_length, widely_blurred
from . import factor_for, principal_axes, reduced, running_sums

DIRECTIONS = 12  # of a half circle, 15 degrees each
LEAST_SIDE = 8  # px: smallest short side that has enough lags; halved and doubled: the same on 92 textures
CONTRAST = 4096  # steps per standard deviation of the component that is measured; 256: no size differs
GRAIN = 100_000  # steps of correlation per 1, above FFT rounding errors; halved or doubled: 1 size differs, 1000: 39
LEAST_SHARE = 1 / 32  # least share of all pixel pairs for a lag of a masked exemplar; 0 to 1/16: the same on 92


# After each value: on how many of 92 textures another value changes the size by a tenth or more, and on how many the
# automatic choice then follows another rule.
LOW = 0.1  # a minimum of the correlation counts below this; halved: 10 sizes and 2 rules, doubled: 8 and 1, 0: 34 and 6
LIMIT = 0.4  # largest size, of the short side, to leave a choice of patches; halved: 59 and 12, doubled: 12 and 0
LARGE = 0.75  # quantile over directions, so that long stones count by their length; halved: 68 and 3, 1: 55 and 2
LIGHT = 0.25  # sigma, of the short side, above which variation is removed as illumination; halved: 14, 5, doubled: 3, 2
SMOOTH = 1.5  # px: sigma of the smoothing over lags; halved: 13 and 4, doubled: 27 and 2
UNSEEN = 0.5  # size, of the short side, for directions without a minimum; halved: 8 and 0, doubled: the same
NOISE = 0.1  # channels of less than this share of the largest deviation are not fully amplified; 0 to 0.2: 1, 0.5: 14


@dataclass(frozen=True)
class ElementSize:
    """Size of the elements of a texture.

    Attributes
    ----------
    height, width : int
        Size along each axis, px: the median over the 3 directions around the axis.
    size : int
        The size to choose patches by, px: the 75 % quantile over all directions, so that long stones count by
        their length. At most 0.4 of the short side, at least 1.
    directions : tuple of 12 int
        Lag of the first minimum, px, at 0, 15, ... 165 degrees (0 along x, 90 along y, downwards): half an
        element. 0: none.
    found : int
        How many directions have a minimum. 0: `size` is a guess, from the side of the exemplar alone.
    reduction : int
        The exemplar was measured this many times smaller. All lengths are scaled back to its own px, and so
        are accurate to about this many px.
    """

    height: int
    width: int
    size: int
    directions: tuple[int, ...]
    found: int
    reduction: int = 1


def element_size(features: Int16, usable: Mask | None = None) -> ElementSize:
    """Measure the size of the elements of a texture.

    Parameters
    ----------
    features : int16 array, shape (H, W, C)
        Any size. Above 512 px a side a box-reduced copy is measured, and the result scaled back.
    usable : bool array, shape (H, W), optional
        False where pixels do not count; sides are then those of the box around the usable pixels.

    Returns
    -------
    ElementSize
        For a constant exemplar, or less than 8 px on the short side: a quarter of the short side, at least
        1 px, `found` 0. A direction without a minimum counts as half the short side.
    """
    features, usable = _usable_box(features, usable)
    short = min(features.shape[:2])
    if short < LEAST_SIDE:
        return _guess(short)
    factor = factor_for(features.shape, least=4 * LEAST_SIDE)
    colours, half = reduced(features, usable, factor)
    weight = None if half is None else half.astype(np.float64)
    component = _first_component(colours, weight)
    if component is None:
        return _guess(short)
    side = min(component.shape)
    correlation = _autocorrelation(_band_pass(component, weight, LIGHT * side), weight, side // 2)
    if correlation is None:
        return _guess(short)
    lags = [lag * factor for lag in _first_minima(correlation)]
    sizes = np.array([2.0 * lag if lag else UNSEEN * short for lag in lags])
    limit = max(1, int(LIMIT * short))
    third = DIRECTIONS // 2
    width, height = np.median(sizes[[-1, 0, 1]]), np.median(sizes[[third - 1, third, third + 1]])
    size = np.quantile(sizes, LARGE)
    height, width, size = (min(limit, max(1, int(v + 0.5))) for v in (height, width, size))
    return ElementSize(height, width, size, tuple(lags), sum(lag > 0 for lag in lags), factor)


def _guess(short: int) -> ElementSize:
    quarter = max(1, short // 4)
    return ElementSize(quarter, quarter, quarter, (0,) * DIRECTIONS, 0)


def _usable_box(features: Int16, usable: Mask | None) -> tuple[Int16, Mask | None]:
    """Return features and mask cropped to the bounding box of the usable pixels; no rows if there are none."""
    if usable is None or bool(usable.all()):
        return features, None
    rows, columns = np.flatnonzero(usable.any(axis=1)), np.flatnonzero(usable.any(axis=0))
    if not rows.size:
        return features[:0], None
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    return features[box], usable[box]


def _first_component(colours: Array, weight: Floats | None) -> Floats | None:
    """Return colours projected on their first principal axis, as whole numbers; None if all are equal.

    Channels are normalised to equal contrast (see NOISE) first, which undoes the weights that features give to colours
    (green most): in a field leaves differ from one another in green, but plants from soil in all channels.
    """
    chosen = colours.reshape(-1, colours.shape[2]) if weight is None else colours[weight > 0]
    n = len(chosen)
    if not n:
        return None
    # Features of 11 bit, so colours of 15: sums of their products are exact, in any order.
    x = chosen.astype(np.float64)
    mean = x.sum(axis=0) / n
    covariance = x.T @ x / n - np.outer(mean, mean)
    deviation = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    if deviation.max() ** 2 < 0.25 / n:  # less variance than one pixel that differs by 1
        return None
    deviation = np.maximum(deviation, NOISE * deviation.max())
    correlation = covariance / np.outer(deviation, deviation)
    vector = principal_axes(correlation, 1)[1][0]
    component: Floats = np.rint((colours.astype(np.float64) - mean) @ (vector / deviation) * CONTRAST)
    return component


def _band_pass(picture: Floats, weight: Floats | None, wide: float) -> Floats:
    """Return a picture without pixel noise (Gaussian, sigma 1) and slow illumination (Gaussian, sigma `wide`).

    Borders are mirrored. With a mask both are normalised by the blurred mask, so that masked pixels do not leak in.
    """
    if weight is None:
        return blurred(picture, 1.0, "symmetric") - widely_blurred(picture, wide)
    value = picture * weight
    narrow = blurred(value, 1.0, "symmetric") / np.maximum(blurred(weight, 1.0, "symmetric"), 1e-9)
    broad = widely_blurred(value, wide) / np.maximum(widely_blurred(weight, wide), 1e-9)
    return (narrow - broad) * weight


def _autocorrelation(picture: Floats, weight: Floats | None, reach: int) -> Floats | None:
    """Return the autocorrelation at lags of up to `reach` px each way: an array with 1 at its centre.

    Unbiased: every lag is divided by the number of pixel pairs that it compares. Lags that compare hardly any
    are 1, which is never a minimum. None if there is no variance.
    """
    lags = np.arange(-reach, reach + 1)
    product = _products(picture, lags)
    pairs = _overlaps(picture.shape, lags, lags) if weight is None else np.rint(_products(weight, lags))
    here = product[reach, reach] / pairs[reach, reach]
    if here < 1e-6:
        return None
    few = pairs < LEAST_SHARE * pairs[reach, reach]
    correlation = np.where(few, 1.0, product / np.maximum(pairs, 1.0) / here)
    return blurred(correlation, SMOOTH, "symmetric")


def _between(picture: Floats, y: Floats, x: Floats) -> Floats:
    """Return a picture interpolated bilinearly at positions."""
    top, left = (np.clip(at.astype(np.int64), 0, n - 2) for at, n in zip((y, x), picture.shape, strict=True))
    down, right = y - top, x - left
    upper = picture[top, left] * (1 - right) + picture[top, left + 1] * right
    lower = picture[top + 1, left] * (1 - right) + picture[top + 1, left + 1] * right
    return np.asarray(upper * (1 - down) + lower * down)


def _first_minima(correlation: Floats) -> list[int]:
    """Return the lag of the first minimum below 0.1 along each of 12 directions, px; 0 for none."""
    reach = correlation.shape[0] // 2
    angle = np.pi * np.arange(DIRECTIONS)[:, None] / DIRECTIONS
    lag = np.arange(reach + 1)
    profile = np.rint(GRAIN * _between(correlation, reach + np.sin(angle) * lag, reach + np.cos(angle) * lag))
    # A profile starts at 1, so its first low minimum is where it first rises again from a low value.
    dip = (profile[:, :-1] < LOW * GRAIN) & (profile[:, 1:] > profile[:, :-1])
    dip[:, 0] = False  # lag 0 is no minimum: the smoothing lowers it for one-pixel patterns
    return [int(np.argmax(row)) for row in dip]


Spans = tuple[NDArray[np.intp], NDArray[np.intp]]

FLAT = 1e-9  # variances below this share of the largest are rounding errors


def autocorrelation(
    picture: Array, usable: Mask | None = None, reach: Pair | None = None
) -> tuple[Floats, Floats]:
    """Return the normalised correlation of a picture with itself at every offset, and how many pixels overlap.

    Channels are weighted by their variance in the overlap, so a constant one has no weight (eq. 3.13).

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
        Offset 0 is in the middle, where the correlation is 1 unless the picture is constant. Both are equal at opposite
        offsets. `pairs` holds whole numbers: the pixels that overlap at each offset, and are usable in both.
    """
    rows, columns = (min(n - 1, r) for n, r in zip(picture.shape[:2], reach or picture.shape[:2], strict=True))
    down, right = np.arange(rows + 1), np.arange(-columns, columns + 1)
    size = _padded(picture.shape, down, right)
    f = picture.reshape(*picture.shape[:2], -1).astype(np.float64)  # less the mean below: rounding errors shrink
    if usable is None:
        f = f - f.mean(axis=(0, 1))
        here, there = (
            [_span(sign * lag, n) for lag, n in zip((down, right), f.shape, strict=False)] for sign in (1, -1)
        )
        pairs = _overlaps(f.shape, down, right)

        def both_ways(values: Floats) -> tuple[Floats, Floats]:
            """Return the sums over the overlap at every lag, and at the opposite one."""
            sums = running_sums(values, np.float64)
            return _inside(sums, *here), _inside(sums, *there)
    else:
        mask = usable.astype(np.float64)
        f = (f - np.tensordot(mask, f, 2) / max(mask.sum(), 1.0)) * mask[..., None]
        counted = fft.rfft2(mask, size)

        def both_ways(values: Floats) -> tuple[Floats, Floats]:
            transformed = fft.rfft2(values, size)
            sums = fft.irfft2(transformed * np.conj(counted), size)
            return _at_lags(sums, down, right), _at_lags(sums, -down, -right)

        pairs = np.rint(both_ways(mask)[0])
    half = _correlation(f, pairs, both_ways, (down, right), size)
    half[0, :columns] = half[0, :columns:-1]  # opposite offsets are equal to the last bit
    return _mirrored(half), _mirrored(pairs)


def _correlation(
    f: Floats, pairs: Floats, both_ways: Callable[[Floats], tuple[Floats, Floats]], lags: tuple[Array, Array],
    size: list[int],
) -> Floats:  # fmt: skip
    """Return eq. 3.13 for every lag (down, right): `pairs` px overlap there, of which `both_ways` returns sums."""
    spectrum: Any = 0.0
    above, below, largest = np.zeros(pairs.shape), np.zeros(pairs.shape), 0.0
    for own in np.moveaxis(f, 2, 0):
        transformed, squares = fft.rfft2(own, size), own * own
        spectrum = spectrum + transformed * np.conj(transformed)
        (before, after), (square, other) = both_ways(own), both_ways(squares)
        above -= before * after
        below += np.sqrt(
            np.maximum(pairs * square - before * before, 0.0) * np.maximum(pairs * other - after * after, 0.0)
        )
        largest = max(largest, float(squares.sum()))
    above += pairs * _at_lags(fft.irfft2(spectrum, size), *lags)
    counts = below > FLAT * pairs * largest
    return np.clip(np.where(counts, above / np.where(counts, below, 1.0), 0.0), -1.0, 1.0)


def _mirrored(half: Floats) -> Floats:
    return np.concatenate([half[:0:-1, ::-1], half])


def _products(f: Floats, lags: Array) -> Floats:
    """Return the sums of f(x) f(x - lag) over x, for lags (n,) along both axes: (n, n)."""
    size = _padded(f.shape, lags, lags)
    return _at_lags(fft.irfft2(np.abs(fft.rfft2(f, size)) ** 2, size), lags, lags)


def _overlaps(shape: tuple[int, ...], down: Array, right: Array) -> Floats:
    """Return how many pixels of (H, W) overlap at every lag (down, right)."""
    return np.asarray(np.multiply.outer(shape[0] - np.abs(down), shape[1] - np.abs(right)), np.float64)


def _padded(shape: tuple[int, ...], down: Array, right: Array) -> list[int]:
    """Return the smallest fast size of a transform in which lags do not wrap onto one another."""
    return [fast_length(n + int(np.abs(lag).max())) for n, lag in zip(shape, (down, right), strict=False)]


def _at_lags(sums: Floats, down: Array, right: Array) -> Floats:
    result: Floats = sums[np.ix_(down % sums.shape[0], right % sums.shape[1])]
    return result


def _span(lag: Array, length: int) -> Spans:
    """Return the first and one past the last of `length` rows that overlap with themselves moved by `lag`."""
    return np.maximum(lag, 0), np.minimum(lag + length, length)


def _inside(total: Floats, rows: Spans, columns: Spans) -> Floats:
    """Return the sums over rectangles of `rows` and `columns`, from a summed-area table."""
    bands = total[rows[1]] - total[rows[0]]
    result: Floats = bands[:, columns[1]] - bands[:, columns[0]]
    return result
