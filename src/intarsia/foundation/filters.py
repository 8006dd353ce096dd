"""Separable filters (box sums, maxima, Gaussians) and fast lengths of Fourier transforms, in NumPy alone.

SciPy has the same, but importing it takes longer than all else in a small run.

`mode`: padding beyond the ends, as in ``numpy.pad``.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from .arrays import Array, Floats

Mode = Literal["constant", "edge", "symmetric", "wrap"]
CUT = 4  # standard deviations at which a Gaussian is truncated


def fast_length(least: int) -> int:
    """Return the least length of at least `least` px that has no prime factor above 5."""
    length = max(least, 1)
    while pow(30, length.bit_length(), length):  # 0 where it has no prime factor but 2, 3 and 5
        length += 1
    return length


def _padded(values: Array, axis: int, before: int, after: int, mode: Mode) -> Array:
    """Return the values padded along an axis, which is moved to the front."""
    pad = [(before, after) if a == axis else (0, 0) for a in range(values.ndim)]
    return np.moveaxis(np.pad(values, pad, mode=mode), axis, 0)


def moving_sums(values: Array, axis: int, radius: int, mode: Mode) -> Array:
    """Return the sums over 2 radius + 1 px around every pixel along an axis."""
    sums = np.cumsum(_padded(values, axis, radius + 1, radius, mode), axis=0)
    return np.moveaxis(sums[2 * radius + 1 :] - sums[: values.shape[axis]], 0, axis)


def averages(values: Array, radius: int) -> Array:
    """Return the means of whole numbers (H, W, ...) over 2 radius + 1 px along both axes, rounded down after each."""
    for axis in (0, 1):
        values = moving_sums(values, axis, radius, "symmetric") // (2 * radius + 1)
    return values


def highest(values: Array, size: int, mode: Mode) -> Array:
    """Return the highest of size x size px (an odd number) around every pixel of a picture (H, W, ...)."""
    for axis in (0, 1):
        wide = _padded(values, axis, size // 2, size // 2, mode)
        seen = 1
        while seen < size:  # each turn sees twice as far
            more = min(seen, size - seen)
            wide, seen = np.maximum(wide[: len(wide) - more], wide[more:]), seen + more
        values = np.moveaxis(wide, 0, axis)
    return values


def lowest(values: Array, size: int, mode: Mode) -> Array:
    """Return the lowest of size x size px (an odd number) around every pixel of numbers with a sign (H, W, ...)."""
    return -highest(-values, size, mode)


def blurred(values: Array, sigma: float, mode: Mode, axes: tuple[int, ...] = (0, 1)) -> Floats:
    """Return the values blurred along `axes` by direct convolution with a Gaussian of `sigma` px, truncated at CUT.

    The time grows with `sigma`; for wide Gaussians see `widely_blurred`.
    """
    radius = int(CUT * sigma + 0.5)
    weights = np.exp(-0.5 / sigma**2 * np.arange(-radius, 1) ** 2)
    weights /= 2 * weights.sum() - weights[-1]
    for axis in axes:
        n, wide = values.shape[axis], _padded(values, axis, radius, radius, mode)
        out = wide[radius : radius + n] * weights[-1]
        for k, weight in enumerate(weights[:-1]):
            out += (wide[k : k + n] + wide[2 * radius - k : 2 * radius - k + n]) * weight
        values = np.moveaxis(out, 0, axis)
    return values


def widely_blurred(values: Floats, sigma: float) -> Floats:
    """Return a picture (H, W), mirrored at its borders, blurred by a Gaussian of any `sigma`, px.

    Its cosine transform, computed as the Fourier transform of the picture and its mirror image, is multiplied by that
    of the Gaussian.
    """
    for _ in range(2):
        n = values.shape[1]
        waves = np.fft.rfft(np.concatenate([values, values[:, ::-1]], axis=1))
        waves *= np.exp(-0.5 * (sigma * np.pi / n * np.arange(n + 1)) ** 2)
        values = np.fft.irfft(waves, 2 * n)[:, :n].T
    return values
