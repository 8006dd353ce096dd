"""What lies around each pixel: blurred, its mean, the largest and the smallest of it, a mask grown.

With the same bytes as the functions of ``scipy.ndimage`` that are named beside; importing that takes 0.1 s, longer than
all that a picture asks of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..lazy import lazy

if TYPE_CHECKING:
    from scipy import ndimage as ndimage
else:  # all else that is asked for more rarely
    ndimage = lazy("scipy.ndimage")

Array = NDArray[Any]

MIRRORED, HELD = "symmetric", "edge"
"""How pictures go on beyond their borders: ``reflect`` and ``nearest``, as others call it."""
WIDEST = 4.0  # standard deviations, where a Gaussian is cut off


def blurred(values: NDArray[np.float64], sigmas: Sequence[float], beyond: str = MIRRORED) -> NDArray[np.float64]:
    """Return values blurred by a Gaussian of `sigmas` px along each axis, 0 for none (``gaussian_filter``)."""
    for axis, sigma in enumerate(sigmas):
        if sigma > 0:
            values = _along(values, axis, partial(_gaussian, sigma=float(sigma), beyond=beyond))
    return values


def _gaussian(lines: Array, sigma: float, beyond: str) -> Array:
    radius, length = int(WIDEST * sigma + 0.5), len(lines)
    weights = np.exp(-0.5 / (sigma * sigma) * np.arange(-radius, radius + 1) ** 2)
    weights /= weights.sum()
    far = _beyond(lines, radius, radius, beyond)
    out, both = far[radius : radius + length] * weights[radius], np.empty_like(lines)
    for k in range(radius):  # from afar, and both sides at once
        np.add(far[k : k + length], far[2 * radius - k : 2 * radius - k + length], out=both)
        both *= weights[k]
        out += both
    return np.asarray(out)


def mean_around(values: Array, sizes: Sequence[int]) -> Array:
    """Return the mean of `sizes` px along each axis, of whole numbers cut off to such (``uniform_filter``)."""
    for axis, size in enumerate(sizes):
        if size > 1:
            values = _along(values, axis, partial(_mean, size=int(size)))
    return values


def _mean(lines: Array, size: int) -> Array:
    far = _beyond(lines, size // 2, size - size // 2 - 1, MIRRORED).astype(np.float64)
    far[size:] -= far[:-size].copy()  # what comes in, less what goes out
    return (np.cumsum(far, axis=0)[size - 1 :] / size).astype(lines.dtype)


def highest(values: Array, size: int, beyond: str = MIRRORED) -> Array:
    """Return the largest of `size` x `size` px around each, an odd number (``maximum_filter``)."""
    return _most(values, size, beyond, np.maximum)


def lowest(values: Array, size: int, beyond: str = MIRRORED) -> Array:
    """Return the smallest of `size` x `size` px around each, an odd number (``minimum_filter``)."""
    return _most(values, size, beyond, np.minimum)


def _most(values: Array, size: int, beyond: str, larger: Callable[..., Array]) -> Array:
    for axis in range(values.ndim):
        values = _along(values, axis, partial(_widest, size=size, beyond=beyond, larger=larger))
    return values


def _widest(lines: Array, size: int, beyond: str, larger: Callable[..., Array]) -> Array:
    found, seen, length = _beyond(lines, size // 2, size // 2, beyond), 1, len(lines)
    while 2 * seen <= size:
        found, seen = larger(found[:-seen], found[seen:]), 2 * seen
    return larger(found[:length], found[size - seen : size - seen + length])


def filled(values: Array, size: int, beyond: str = MIRRORED) -> Array:
    """Return a picture (H, W) without dark things less than `size` px wide (``grey_closing``)."""
    return lowest(highest(values, size, beyond), size, beyond)


def worn(values: Array, size: int, beyond: str = MIRRORED) -> Array:
    """Return a picture (H, W) without bright things less than `size` px wide (``grey_opening``)."""
    return highest(lowest(values, size, beyond), size, beyond)


def grown(mask: NDArray[np.bool_], steps: int) -> NDArray[np.bool_]:
    """Return a mask (H, W) and what is at most so many steps along rows and columns beside (``binary_dilation``)."""
    for _ in range(steps):
        out = mask.copy()
        out[1:] |= mask[:-1]
        out[:-1] |= mask[1:]
        out[:, 1:] |= mask[:, :-1]
        out[:, :-1] |= mask[:, 1:]
        mask = out
    return mask


def depths(inside: NDArray[np.bool_], most: int) -> NDArray[np.float64]:
    """Return how far each pixel of a mask (H, W) lies from the nearest outside of it, px (``distance_transform_edt``).

    Where that is more than `most` px, `most` is returned.
    """
    at = np.arange(inside.shape[1])
    before = np.maximum.accumulate(np.where(inside, -most, at), axis=1)
    behind = np.minimum.accumulate(np.where(inside, at[-1] + most, at)[:, ::-1], axis=1)[:, ::-1]
    squares = np.minimum(np.minimum(at - before, behind - at), most) ** 2
    found = squares.copy()
    for k in range(1, min(most, len(inside))):
        np.minimum(found[k:], squares[:-k] + k * k, out=found[k:])
        np.minimum(found[:-k], squares[k:] + k * k, out=found[:-k])
    return np.asarray(np.sqrt(found))


def _along(values: Array, axis: int, work: Callable[[Array], Array]) -> Array:
    """Do with the lines of an axis what is done with those of the first."""
    lines = np.ascontiguousarray(np.moveaxis(values, axis, 0))
    return np.ascontiguousarray(np.moveaxis(work(lines), 0, axis))


def _beyond(lines: Array, before: int, after: int, beyond: str) -> Array:
    """Lines, and what lies before and after them."""
    pad: Any = np.pad
    return np.asarray(pad(lines, ((before, after), *((0, 0),) * (lines.ndim - 1)), beyond))
