"""Reduced pictures of exemplars and windows: whole numbers along a few axes, for the short-list of the patch search."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.jit import kernel


class Correlated(NamedTuple):
    """n windows correlated with one posed exemplar, and what turns that into distances."""

    values: NDArray[np.floating[Any]]  # (n, >= rows, >= columns): correlation at every position
    squares: NDArray[np.int32]  # (m, rows, columns): the exemplar's energy under m masks
    slots: NDArray[np.int64]  # (n,): which of the masks is the window's
    energies: NDArray[np.int64]  # (n,): of the windows
    valid: NDArray[np.bool_]  # (rows, columns): where a patch may begin
    variant: int  # number of the posed exemplar


class Fee(NamedTuple):
    """What repeats cost at the positions of one posed exemplar."""

    counts: NDArray[np.int32]  # (rows, columns): uses; 256 = one full repeat
    weight: int  # price of such a repeat, in 1 / 65536 of the usual distance


class Listed(NamedTuple):
    """The short-lists of n windows, K positions each and what more a search needs to sort them."""

    best: NDArray[np.int64]  # (n, K, 4): cost, variant, row, column, cheapest first
    counts: NDArray[np.int64]  # (n,): how many there are
    usual: NDArray[np.int64]  # (n,): the usual distance, -1 while unknown


@kernel
def coarse_picture(picture: Any, factor: int, mean: Any, axes: Any, clip: int) -> Any:
    """Average cells of factor x factor px, project and quantise them: float32 (K, rows, columns) within `clip`.

    `mean` (C,) is the features' mean; `axes` (K, C) int64 are the K directions kept, in 2**-24.
    """
    rows, columns, channels = picture.shape[0] // factor, picture.shape[1] // factor, picture.shape[2]
    out = np.empty((len(axes), rows, columns), np.float32)
    total = np.empty(channels, np.int64)
    for y in range(rows):
        for x in range(columns):
            total[:] = 0
            for i in range(factor):
                for j in range(factor):
                    for c in range(channels):
                        total[c] += picture[y * factor + i, x * factor + j, c]
            for k in range(len(axes)):
                out[k, y, x] = quantised(total, factor * factor, mean, axes[k], clip)
    return out


@kernel
def quantised(total: Any, count: int, mean: Any, axis: Any, clip: int) -> Any:
    """Turn the sums (C,) of `count` feature values into a whole number from -clip to clip along an axis."""
    q = np.int64(0)
    for c in range(len(axis)):
        q += (total[c] - mean[c] * count) * axis[c]
    q = q >> 2 if count == 4 else q // count  # 4 by far the most often, and a shift is much faster
    q = (q + (1 << 23)) >> 24
    return min(max(q, -clip), clip)


@kernel
def coarse_template(
    feats: Any, known: Any, factor: int, mean: Any, axes: Any, clip: int, template: Any, mask: Any
) -> Any:
    """Reduce a window as :func:`coarse_picture` does; cells at least half known count. Returns sum of squares.

    `template` float (K, rows, columns), 0 where `mask` float32 (rows, columns) is 0.
    """
    axis, rows, columns = template.shape
    channels = feats.shape[2]
    need = (factor * factor + 1) // 2
    energy = np.int64(0)
    total = np.empty(channels, np.int64)
    template[:] = 0
    for y in range(rows):
        for x in range(columns):
            count = 0
            for i in range(factor):
                for j in range(factor):
                    count += known[y * factor + i, x * factor + j]
            mask[y, x] = count >= need
            if count < need:
                continue
            for c in range(channels):
                part = np.int64(0)
                for i in range(factor):
                    for j in range(factor):
                        part += feats[y * factor + i, x * factor + j, c]  # 0 where not known
                total[c] = part
            for k in range(axis):
                q = quantised(total, count, mean, axes[k], clip)
                template[k, y, x] = q
                energy += q * q
    return energy


@kernel
def coarse_templates(
    feats: Any, known: Any, factor: int, mean: Any, axes: Any, clip: int, templates: Any, masks: Any
) -> Any:
    """Apply :func:`coarse_template` to n windows; return their energies (n,) int64."""
    energies = np.empty(len(feats), np.int64)
    for k in range(len(feats)):
        energies[k] = coarse_template(feats[k], known[k], factor, mean, axes, clip, templates[k], masks[k])
    return energies


@kernel
def mask_keys(masks: Any) -> Any:
    """Return a hash (n,) int64 of each of n masks (n, rows, columns): FNV-1a over its cells."""
    keys = np.empty(len(masks), np.uint64)
    for k in range(len(masks)):
        h = np.uint64(0xCBF29CE484222325)
        for y in range(masks.shape[1]):
            for x in range(masks.shape[2]):
                h = (h ^ np.uint64(masks[k, y, x] != 0)) * np.uint64(0x100000001B3)
        keys[k] = h
    return keys
