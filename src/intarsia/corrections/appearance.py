"""What a pixel looks like with all that is around it, at every level of detail (Lefebvre and Hoppe 2006).

A Gaussian stack keeps the exemplar's full size and only blurs it more from level to level (2005, section 3.2), so that
any size and shape will do. The 5 x 5 neighbourhood of every pixel, weighted by a Gaussian, is projected on its eight
main axes and rounded once: the transformed exemplar. All steps are whole numbers, or sums that are exact in doubles.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..analysis.sums import nearest, principal_axes
from ..exemplar import Exemplar
from . import appearance_kernels as kernels
from .correction_kernels import MIDDLE

AXES = 8  # of appearance vectors (2006)
SAMPLE = 8192  # neighbourhoods that axes are measured on; halved and doubled: scores move by 1 % (docs/design/012)
BITS = 4  # of the stack, after the point
WEIGHTS = np.array([[round(256 * 2.0 ** -(dy * dy + dx * dx)) for dx in (-1.0, -0.5, 0.0, 0.5, 1.0)]
                    for dy in (-1.0, -0.5, 0.0, 0.5, 1.0)], np.int64).ravel()  # fmt: skip
"""What the 5 x 5 taps are multiplied by, 256 = 1: a Gaussian that halves 2 px from the middle; squares, a quarter."""

Array = NDArray[Any]


def without_gaps(picture: Array, exemplar: Exemplar) -> Array:
    """Show at every unusable pixel the nearest usable one, so that what is masked out leaves no trace around it."""
    home = None if exemplar.usable is None else nearest(exemplar.usable)
    return picture if home is None else np.asarray(picture[home[0], home[1]])


def bordered(picture: Array, border: int, toroidal: bool) -> Array:
    """Continue a picture (H, W, ...) on all sides: in itself, or mirrored."""
    mode: Literal["wrap", "symmetric"] = "wrap" if toroidal else "symmetric"
    return np.pad(picture, [(border, border)] * 2 + [(0, 0)] * (picture.ndim - 2), mode=mode)


def stack_of(picture: Array, levels: int, toroidal: bool) -> list[Array]:
    """Return the Gaussian stack of features (H, W, C): levels of spacing 1, 2, 4, ... px, int32 in 1 / 16.

    From one level to the next the pixels at 0, +-h/2, +-h px are weighted 6, 4, 1 along either axis.
    """
    stack = [np.asarray(picture, np.int32) << BITS]
    for level in range(1, levels):
        spacing, out = 1 << (level - 1), stack[-1]
        for axis in (0, 1):
            n = out.shape[axis]
            taps = [np.take(out, places_along(n, t * spacing, toroidal), axis) for t in (-2, -1, 0, 1, 2)]
            out = (taps[0] + taps[4] + 4 * (taps[1] + taps[3]) + 6 * taps[2] + 8) >> 4
        stack.append(out)
    return stack[:levels]


def places_along(n: int, move: int, toroidal: bool) -> Array:
    """The pixels that lie `move` px further along an axis of `n`, beyond whose ends it goes on, or is mirrored."""
    at = np.arange(move, move + n)
    if toroidal:
        return at % n
    at %= 2 * n
    return np.minimum(at, 2 * n - 1 - at)


def transformed(picture: Array, h: int, toroidal: bool) -> Array:
    """Return the transformed exemplar of one level of the stack: (H, W, 8) int16, -1023 .. 1023 at most."""
    height, width, channels = picture.shape
    halved = (picture + 4) >> 3
    halved = halved - halved.reshape(-1, channels).astype(np.int64).sum(axis=0) // (height * width)
    planes = np.ascontiguousarray(np.moveaxis(bordered(halved.astype(np.int32), 2 * h, toroidal), 2, 0))
    every = max(1, height * width // SAMPLE)
    some = np.empty((-(-height * width // every), 25 * channels))
    kernels.sample_neighbourhoods(planes, h, every, some)
    weights = np.repeat(WEIGHTS, channels) / 256
    covariance = whole_products(some) / len(some) * weights[:, None] * weights
    axes = principal_axes(covariance, AXES)[1] * weights
    whole = np.zeros((AXES, 25 * channels), np.int64)
    whole[: len(axes)] = np.rint(axes * 16384)
    out = np.empty((height, width, AXES), np.int32)
    kernels.project_neighbourhoods(planes, h, whole.reshape(AXES, 25, channels), out)
    most = max(int(np.abs(out).max()), 1)
    return np.asarray(out * MIDDLE // most, np.int16) if most > MIDDLE else out.astype(np.int16)


def whole_products(vectors: Array) -> Array:
    """Return the sums of products (n, n) of centred whole vectors (N, n): below 2**53, so exact in any order."""
    centred = vectors - np.floor(vectors.sum(axis=0) / len(vectors))
    return np.asarray(centred.T @ centred)


def packed(lifted: Array) -> Array:
    """Lay the eight values of each pixel, 0 .. 2046, (rows, columns, 8) int16 into two words: (positions, 2) uint64."""
    return np.ascontiguousarray(lifted.astype("<u2")).reshape(-1, AXES).view("<u8").astype(np.uint64)


def unpacked_words(words: Array, width: int) -> Array:
    """Return what :func:`packed` was given."""
    return words.astype("<u8").view("<u2").astype(np.int16).reshape(-1, width, AXES)
