"""Where a texture agrees with itself: the correlation map that lattices are read from.

Two pictures are correlated with themselves: the colours without slow changes of light, and the strength of
the edges, which joints have in common where stones differ in colour. The map is their mean.

Source: Lopez Recas 2011, sections 3.1 and 3.2. Departures: high-pass, second channel, whole numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn

from ..analysis.correlation import autocorrelation, gaussian
from ..analysis.sums import spreads
from ..lazy import ndimage

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

MILLION = 1_000_000  # correlations are kept in millionths: rounding errors of transforms are far below
READ = 0.3  # offsets at which less than this share of the pixels overlaps have weight 0
REACH = 0.8  # of each side: the largest offset looked at
LIGHT = 6  # the short side over this is the sigma of what counts as light


@dataclass(frozen=True)
class CorrelatedPictures:
    """The two pictures that are correlated, and which of their pixels count.

    Whole numbers, 0 where pixels do not count; no mask where all of them do.
    """

    colours: Floats  # (H, W, C)
    edges: Floats  # (H, W, 1)
    usable: Mask | None  # (H, W): which pixels of the colours count,
    inner: Mask | None  # and of the edges: those with four usable neighbours


@dataclass(frozen=True)
class CorrelationMap:
    """How well the texture agrees with itself at every offset; the offset 0 is in the middle.

    All are (2 rows + 1, 2 columns + 1).
    """

    values: NDArray[np.int32]  # correlations in millionths,
    smooth: NDArray[np.int32]  # and after a Gaussian of sigma 1 px
    # 1000 times the root of the share of pixels that overlap; 0 where that share is below 0.3.
    weights: NDArray[np.int32]
    share: NDArray[np.int32]  # the share of pixels that overlap, in thousandths


def pictures(features: NDArray[np.int64], usable: Mask | None) -> CorrelatedPictures:
    """Prepare what is correlated: colours without slow light, and edges, of features in 1/16."""
    weight = None if usable is None else usable.astype(np.float64)
    values = _evened(features, usable)
    colours = np.rint(high_pass(values, weight, min(features.shape[:2]) / LIGHT))
    strength = np.zeros(features.shape[:2])
    for axis in (0, 1):
        if features.shape[axis] > 1:
            step = np.gradient(values, axis=axis)
            strength += (step * step).sum(axis=2)
    edges = np.rint(np.sqrt(strength))[..., None]
    inner = None
    if usable is not None:
        inner = usable.copy()
        for axis in (0, 1):
            near, far = np.moveaxis(inner, axis, 0), np.moveaxis(usable, axis, 0)
            near[1:] &= far[:-1]
            near[:-1] &= far[1:]
        colours[~usable] = 0
        edges[~inner] = 0
    return CorrelatedPictures(colours, edges, usable, inner)


def _evened(features: NDArray[np.int64], usable: Mask | None) -> Floats:
    """Let channels count alike, whatever weights the features gave to colours; faint ones at most fourfold."""
    chosen = features.reshape(-1, features.shape[2]) if usable is None else features[usable]
    deviation = np.sqrt(np.array([s / max(len(chosen), 1) ** 2 for s in spreads(chosen)]))
    top = deviation.max()
    if top <= 0:
        return features.astype(np.float64)
    evened: Floats = np.rint(features * (top / np.maximum(deviation, top / 4)))
    return evened


def correlation_map(prepared: CorrelatedPictures) -> CorrelationMap | None:
    """Correlate the pictures with themselves; None where there is nothing to correlate."""
    height, width = prepared.colours.shape[:2]
    reach = int(REACH * height), int(REACH * width)
    colours, pairs = autocorrelation(prepared.colours, prepared.usable, reach)
    edges, _ = autocorrelation(prepared.edges, prepared.inner, reach)
    middle = colours.shape[0] // 2, colours.shape[1] // 2
    given = [c for c in (colours, edges) if c[middle] > 0.5]
    if not given or pairs[middle] < 1:
        return None
    values = np.rint(MILLION * sum(given) / len(given))
    smooth = np.rint(ndimage.gaussian_filter(values, 1.0, mode="nearest"))
    share = pairs / pairs[middle]
    weights = np.where(share >= READ, np.rint(1000 * np.sqrt(share)), 0)
    arrays = (values, smooth, weights, np.rint(1000 * share))
    return CorrelationMap(*(array.astype(np.int32) for array in arrays))


def high_pass(picture: Floats, weight: Floats | None, sigma: float) -> Floats:
    """Take away what changes slowly: a Gaussian of `sigma` px with mirrored borders, channel by channel.

    Such a Gaussian is a product in the cosine transform; any width costs the same. With a mask it is divided
    by the blurred mask, so that what does not count does not leak in.
    """
    passed = gaussian(picture.shape[:2], sigma)[..., None]

    def slow(values: Floats) -> Floats:
        return np.asarray(idctn(dctn(values, axes=(0, 1)) * passed, axes=(0, 1)))

    if weight is None:
        return picture - slow(picture)
    light, mass = slow(picture * weight[..., None]), slow(weight[..., None])
    return np.asarray((picture - light / np.maximum(mass, 1e-9)) * weight[..., None])
