"""Lattice candidates: pairs of peaks of the autocorrelation, and pairs of peaks of the spectrum.

A texture that repeats has autocorrelation peaks at its lattice vectors and spectral peaks at the frequencies of its
reciprocal lattice. Either alone misses some textures; together they miss few. Both only propose candidates; the score
in ``fit.py`` decides.

Two pictures are correlated with themselves: the high-pass filtered colours, and the edge strength, which repeats at
joints even if the stones differ in colour. The correlation map is the mean of both.

Source: Lopez Recas 2011, sections 3.1 to 3.3 (correlation, peaks, pairs, reduction); regions of dominance: Liu, Collins
and Tsin, "A computational model for periodic pattern perception", PAMI 2004. Departures: high-pass filter, edge
strength as second channel, whole numbers, pairs of waves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..analysis import scaled_variances
from ..analysis.elements import autocorrelation
from ..foundation import ndimage
from ..foundation.arrays import Array, Floats, Int32, Int64, Mask, Pair
from ..foundation.filters import blurred, fast_length, highest, widely_blurred
from ..foundation.geometry import UNIT
from .scoring_kernels import top_of

MILLION = 1_000_000  # correlations are kept in millionths; rounding errors of the transforms are far smaller
READ = 0.3  # offsets at which less than this share of the pixels overlaps have weight 0
REACH = 0.8  # the largest offset, as a share of each side
LIGHT = 6  # the shorter side divided by this is the sigma of the high-pass filter, which removes illumination


class CorrelatedPictures(NamedTuple):
    """The two pictures that are correlated, and their masks.

    Whole numbers, 0 where pixels do not count; masks are None if all pixels count.
    """

    colours: Floats  # (H, W, C)
    edges: Floats  # (H, W, 1)
    usable: Mask | None  # (H, W): which pixels of `colours` count
    inner: Mask | None  # (H, W): which pixels of `edges` count: usable ones with four usable neighbours


class CorrelationMap(NamedTuple):
    """The normalised autocorrelation of a texture at every offset; offset 0 is in the middle.

    All arrays are (2 rows + 1, 2 columns + 1).
    """

    values: Int32  # correlations in millionths
    smooth: Int32  # `values` blurred by a Gaussian of sigma 1 px
    # 1000 times the root of the share of pixels that overlap; 0 where that share is below 0.3.
    weights: Int32
    share: Int32  # the share of pixels that overlap, in thousandths


def pictures(features: Int64, usable: Mask | None) -> CorrelatedPictures:
    """Return the high-pass filtered colours and the edge strength of features in 1/16."""
    values = _evened(features, usable)
    colours = np.rint(high_pass(values, usable, min(features.shape[:2]) / LIGHT))
    down, along = ((step * step).sum(axis=2) for step in np.gradient(values, axis=(0, 1)))
    edges, inner = np.rint(np.sqrt(down + along))[..., None], None
    if usable is not None:
        inner = ndimage.binary_erosion(usable, border_value=1)
        colours[~usable] = 0
        edges[~inner] = 0
    return CorrelatedPictures(colours, edges, usable, inner)


def _evened(features: Int64, usable: Mask | None) -> Floats:
    """Return the features with all channels scaled to the contrast of the strongest, at most fourfold."""
    chosen = features.reshape(-1, features.shape[2]) if usable is None else features[usable]
    deviation = np.sqrt(np.array([s / max(len(chosen), 1) ** 2 for s in scaled_variances(chosen)]))
    top = deviation.max()
    return np.rint(features * (top / np.maximum(deviation, top / 4))) if top > 0 else features.astype(np.float64)


def correlation_map(prepared: CorrelatedPictures) -> CorrelationMap | None:
    """Return the mean autocorrelation of both pictures, up to 0.8 of each side; None if both are constant."""
    height, width = prepared.colours.shape[:2]
    reach = int(REACH * height), int(REACH * width)
    colours, pairs = autocorrelation(prepared.colours, prepared.usable, reach)
    edges, _ = autocorrelation(prepared.edges, prepared.inner, reach)
    middle = colours.shape[0] // 2, colours.shape[1] // 2
    given = [c for c in (colours, edges) if c[middle] > 0.5]
    if not given or pairs[middle] < 1:
        return None
    values = np.rint(MILLION * sum(given) / len(given))
    smooth = np.rint(blurred(values, 1.0, "edge"))
    share = pairs / pairs[middle]
    weights = np.where(share >= READ, np.rint(1000 * np.sqrt(share)), 0)
    arrays = (values, smooth, weights, np.rint(1000 * share))
    return CorrelationMap(*(array.astype(np.int32) for array in arrays))


def high_pass(picture: Floats, usable: Mask | None, sigma: float) -> Floats:
    """Subtract a Gaussian blur of `sigma` px with mirrored borders, channel by channel.

    With a mask the blur is divided by the blurred mask, so that masked pixels do not leak in.
    """
    planes = np.moveaxis(picture, 2, 0).copy()  # transformed one by one, each stays in the cache of a core
    weight = np.ones(picture.shape[:2]) if usable is None else usable.astype(np.float64)
    mass = 1.0 if usable is None else np.maximum(widely_blurred(weight, sigma), 1e-9)
    return np.stack([(plane - widely_blurred(plane * weight, sigma) / mass) * weight for plane in planes], axis=2)


SHORTEST = 4  # px: shorter vectors are repetitions of grain, not of elements
PEAKS = 45  # correlation peaks of which all pairs become candidates
LOOKED_AT = 1000  # strongest peaks for which the dominance is computed
EQUAL = 10_000  # millionths: peaks whose heights differ by less count as equally high
WAVES = 10  # spectral peaks of each picture of which all pairs become candidates
LONGEST_WAVE = 1.5  # periods that fit fewer times into the shorter side count as illumination


def overlap(shape: Sequence[int], shift: Pair) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
    """Return the indices of the two parts of a picture that overlap if it is shifted by (y, x).

    The second part lies (y, x) from the first; both have the same shape.
    """
    here, there = (
        tuple(slice(max(0, -k * d), max(0, n - max(0, k * d))) for d, n in zip(shift, shape, strict=False))
        for k in (1, -1)
    )
    return here, there


def lattice_points(first: Pair, v1: Pair, v2: Pair, low: Sequence[int], high: Sequence[int]) -> Int64:
    """Return the points first + a v1 + b v2 that lie, rounded to px, in a box: (n, 2) in 1/256 px, by a, then b.

    `first`, `v1`, `v2`: (y, x) in 1/256 px; `low`, `high`: first and last px of the box, (y, x).
    """
    ends = [(a * UNIT - UNIT // 2, b * UNIT + UNIT // 2 - 1) for a, b in zip(low, high, strict=True)]
    corners = [((y - first[0]) * v2[1] - (x - first[1]) * v2[0]) // (v1[0] * v2[1] - v1[1] * v2[0])
               for y in ends[0] for x in ends[1]]  # fmt: skip
    a = np.arange(min(corners), max(corners) + 2)
    least, most = np.full(len(a), -(1 << 60)), np.full(len(a), 1 << 60)
    for p, along, step, (begin, last) in zip(first, v1, v2, ends, strict=True):
        at = p + a * along
        if step == 0:
            most[(at < begin) | (at > last)] = -(1 << 61)
            continue
        to, back = (last - at, at - begin) if step > 0 else (at - begin, last - at)
        least, most = np.maximum(least, -(back // abs(step))), np.minimum(most, to // abs(step))
    counts = np.maximum(most - least + 1, 0)
    b = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts - least, counts)
    return np.asarray(first + np.repeat(a, counts)[:, None] * v1 + b[:, None] * v2, np.int64)


class Sensible:
    """Bounds of candidates: lattices beyond them cannot be observed in the exemplar."""

    cells = 0.6  # largest cell as a share of the exemplar's area, which holds more than one; halved, doubled: no change
    overlap = 200  # thousandths: least share of pixels that overlap at a peak; 400: 2 lattices of 35 differ
    parallel = 1e-7  # cycles^2 per px^2: least determinant of two frequencies; below it they are parallel
    far = 1e6  # px: longest vector component; larger than any picture


def canonical(vectors: Int64) -> Int64:
    """Reduce pairs of whole vectors (n, 2, 2) to the shortest pair of the same lattice (Gauss reduction).

    The shorter one comes first; both have dx > 0, or dx = 0 and dy > 0. Equal lattices give equal pairs, unless two
    vectors have the same length.
    """
    v, w = vectors[:, 0].copy(), vectors[:, 1].copy()
    for _ in range(64):
        longer = (v * v).sum(axis=1) > (w * w).sum(axis=1)
        v[longer], w[longer] = w[longer], v[longer]
        square = np.maximum((v * v).sum(axis=1), 1)
        times = (2 * (v * w).sum(axis=1) + square) // (2 * square)  # round half up
        times[2 * np.abs((v * w).sum(axis=1)) <= square] = 0
        if not times.any():
            break
        w -= times[:, None] * v
    result = np.stack([v, w], axis=1)
    y, x = result[..., 0], result[..., 1]
    result[(x < 0) | ((x == 0) & (y < 0))] *= -1
    return result


def correlation_peaks(found: CorrelationMap) -> Floats:
    """Return the best correlation peaks of one half plane: (n, 2) offsets in px.

    Ranked by height times dominance. The dominance of a peak is the distance to the nearest peak that is as high or
    higher, the origin included: large for peaks of the lattice, small for those between its points.
    """
    smooth = found.smooth
    i, j = _maxima(smooth, found.share >= Sensible.overlap).T
    value = smooth[i, j].astype(np.int64)
    at = np.stack([i, j], axis=1) - (smooth.shape[0] // 2, smooth.shape[1] // 2)
    square = (at * at).sum(axis=1)
    order = np.lexsort((at[:, 1], at[:, 0], square, -value))[:LOOKED_AT]
    at, value, square = at[order], value[order], square[order]
    apart, far = ((at[:, None] - at) ** 2).sum(axis=2), np.iinfo(np.int64).max
    apart[value < value[:, None] - EQUAL] = far
    np.fill_diagonal(apart, far)
    dominance = np.minimum(apart.min(axis=1, initial=far), square)
    half = (square >= SHORTEST**2) & ((at[:, 1] > 0) | ((at[:, 1] == 0) & (at[:, 0] > 0)))
    at, value, dominance, square = at[half], value[half], dominance[half], square[half]
    rank = value * value // 1000 * dominance  # proportional to (height x distance)^2
    order = np.lexsort((at[:, 1], at[:, 0], square, -rank))[:PEAKS]
    return _refined(smooth, at[order])


def _maxima(values: Array, among: Mask) -> Int64:
    """Return the positions (n, 2) of local maxima above 0; the last of equal neighbours, none on the border."""
    ranked = values.astype(np.int64) * values.size + np.arange(values.size).reshape(values.shape)  # no two are equal
    top = (highest(ranked, 3, "edge") == ranked) & (values > 0) & among
    return np.asarray(np.argwhere(top[1:-1, 1:-1]) + 1, np.int64)


def _refined(values: Array, at: Int64) -> Floats:
    """Return peaks (n, 2), px from the middle, moved to the vertex of a parabola through 3 values along each axis."""
    result = at.astype(np.float64)
    for n, (i, j) in enumerate((at + np.array(values.shape) // 2).tolist()):
        result[n, 0] += top_of(*values[i - 1 : i + 2, j].astype(np.float64).tolist())
        result[n, 1] += top_of(*values[i, j - 1 : j + 2].astype(np.float64).tolist())
    return result


def spectral_peaks(picture: Floats) -> Floats:
    """Return the strongest peaks of a picture's (H, W, C) spectrum, at most 10, strongest first: (n, 2), (fy, fx).

    In cycles per px. Only periods of at least 4 px that fit 1.5 times or more into the shorter side.
    """
    height, width = picture.shape[:2]
    window = [0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(n) + 0.5) / n) for n in (height, width)]
    size = fast_length(2 * height), fast_length(2 * width)
    power = np.zeros((size[0], size[1] // 2 + 1))
    for c in range(picture.shape[2]):
        wave = np.fft.rfft2(picture[..., c] * window[0][:, None] * window[1], size)
        power += wave.real**2 + wave.imag**2
    power = np.fft.fftshift(power, axes=0)
    opposite = power[::-1] if size[0] % 2 else np.roll(power[::-1], 1, axis=0)
    power = np.concatenate([opposite[:, 2:0:-1], power], axis=1)  # two columns of negative fx before fx = 0
    scale = power.max()
    if scale <= 0:
        return np.zeros((0, 2))
    level = np.rint(np.sqrt(power / scale) * 1e6).astype(np.int64)
    low = size[0] // 2
    fy = (np.arange(size[0]) - low)[:, None] / size[0]
    fx = (np.arange(level.shape[1]) - 2)[None, :] / size[1]
    f = np.hypot(fy, fx)
    whole = (f >= LONGEST_WAVE / min(height, width)) & (f <= 1 / SHORTEST) & ((fx > 0) | ((fx == 0) & (fy > 0)))
    at = _maxima(level, whole)
    order = np.lexsort((at[:, 1], at[:, 0], -level[at[:, 0], at[:, 1]]))[:WAVES]
    middle = np.array(level.shape) // 2
    return np.asarray((_refined(level, at[order] - middle) + middle - (low, 2)) / size)


def lattice_candidates(found: CorrelationMap, waves: list[Floats], height: int, width: int) -> Int64:
    """Return the candidates: pairs of correlation peaks and of frequencies, reduced; (n, 2, 2) in 1/256 px.

    `waves`: one array of frequencies per picture, from :func:`waves_of`; `height`, `width`: of the exemplar, px.
    """
    peaks = correlation_peaks(found)
    i, j = np.triu_indices(len(peaks), 1)
    pairs = [np.stack([peaks[i], peaks[j]], axis=1)]
    for f in waves:
        i, j = np.triu_indices(len(f), 1)
        a, b = f[i], f[j]
        determinant = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        good = np.abs(determinant) > Sensible.parallel
        a, b, determinant = a[good], b[good], determinant[good]
        # The vectors v with v1.a = 1, v1.b = 0, v2.a = 0, v2.b = 1.
        v1 = np.stack([b[:, 1], -b[:, 0]], axis=1) / determinant[:, None]
        v2 = np.stack([-a[:, 1], a[:, 0]], axis=1) / determinant[:, None]
        pairs.append(np.stack([v1, v2], axis=1))
    whole = np.concatenate(pairs)
    whole = whole[np.abs(whole).max(axis=(1, 2), initial=0) < Sensible.far]
    return distinct(canonical(np.rint(UNIT * whole).astype(np.int64)), height, width)


def distinct(lattices: Int64, height: int, width: int) -> Int64:
    """Return reduced lattices in their order, of those that agree to half a px only the first.

    Left out: vectors below 4 px, and cells of more than 0.6 of height x width.
    """
    area = np.abs(lattices[:, 0, 0] * lattices[:, 1, 1] - lattices[:, 0, 1] * lattices[:, 1, 0])
    long = (lattices[:, 0] ** 2).sum(axis=1) >= (SHORTEST * UNIT) ** 2
    lattices = lattices[long & (area > 0) & (area <= Sensible.cells * height * width * UNIT**2)]
    coarse = (lattices + UNIT // 4) // (UNIT // 2)
    _, first = np.unique(coarse.reshape(-1, 4), axis=0, return_index=True)
    return lattices[np.sort(first)]


def waves_of(prepared: CorrelatedPictures) -> list[Floats]:
    """Return the spectral peaks, cycles per px, of both pictures: the colours, and the edges minus their mean."""
    edges = prepared.edges
    known = np.ones(edges.shape[:2], bool) if prepared.inner is None else prepared.inner
    steps = (edges - edges[known].mean()) * known[..., None] if known.any() else edges
    return [spectral_peaks(prepared.colours), spectral_peaks(steps)]
