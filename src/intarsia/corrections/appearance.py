"""Appearance vectors of an exemplar: projected 5 x 5 neighbourhoods on all levels of a Gaussian stack.

Lefebvre and Hoppe 2006. The Gaussian stack (2005, section 3.2) keeps the exemplar's full size and is blurred more from
level to level, so that any size and shape is allowed. The 5 x 5 neighbourhoods of all pixels, weighted by a Gaussian,
are projected on their first eight principal axes and rounded once: the transformed exemplar. Arithmetic is in integers,
or in sums that are exact in doubles.

Optionally the distance to the nearest outline is a further channel (2006, section 3; Wu and Yu 2004): signed, to the
outline of a mask, or unsigned, to detected edges.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..analysis import nearest, principal_axes, scaled_variances
from ..analysis.features import RANGE
from ..analysis.oriented_energy import outline_distance, outlines_of
from ..foundation import InputError, ndimage
from ..foundation.arrays import Array
from ..foundation.field import Field
from ..model import Exemplar
from .appearance_kernels import project_neighbourhoods
from .correction_kernels import MIDDLE

FAR = 16  # px: larger distances to outlines are clipped to this
PARTS = 16  # units of distance per px


@dataclass(frozen=True)
class Outlines:
    """The outlines whose distance is a feature channel, and its weight: 1 gives it the variance of all other
    channels together.

    ``drawn``: a field above 0.5 on one side of the outlines and below on the other; None: detected edges.
    """

    drawn: Field | None
    weight: float

    @classmethod
    def of(cls, method: Any) -> Outlines | None:
        """Return the outlines given by the fields `feature` and `feature_weight` of a method, or None."""
        if method.feature is None or not method.feature_weight:
            return None
        return cls(method.feature if isinstance(method.feature, Field) else None, method.feature_weight)

    def over(self, exemplar: Exemplar) -> Outlines:
        """Return the same outlines; a function is replaced by its mask over the exemplar, evaluated once."""
        if self.drawn is None or not self.drawn.is_function:
            return self
        drawn = self.drawn  # cached with the exemplar for all windows
        return replace(self, drawn=exemplar.latest("drawn", drawn, lambda: Field(marked(drawn, exemplar))))

    def channel(self, exemplar: Exemplar, picture: Array) -> Array:
        """Return the channel (H, W, 1) to append to features (H, W, C) of the exemplar: int16."""
        torus = exemplar.toroidal
        if self.drawn is None:
            far = outline_distance(outlines_of(picture, exemplar.usable, torus), picture.shape, torus).astype(np.int64)
        else:
            inside = marked(self.drawn, exemplar)
            far = outline_distances(~inside, torus) - outline_distances(inside, torus)
        centred = far - int(far.sum()) // far.size
        own, much = (sum(scaled_variances(p.reshape(far.size, -1))) / float(far.size**2) for p in (centred, picture))
        share = round(65536 * math.sqrt(self.weight * much / max(own, 1.0)))
        return np.asarray(np.clip((centred * share + 32768) >> 16, -RANGE, RANGE)[:, :, None], np.int16)


def above_half(drawn: Field, rows: Array, cols: Array) -> Array:
    """Return where a field is above 0.5: bool (rows, columns)."""
    return np.asarray(drawn.at(rows, cols) > 0.5)


def marked(drawn: Field, exemplar: Exemplar) -> Array:
    """Return where a field is above 0.5 over the exemplar: bool (H, W); InputError if that is everywhere or nowhere."""
    inside = above_half(drawn, np.arange(exemplar.height), np.arange(exemplar.width))
    if inside.all() or not inside.any():
        kind = "light" if inside.all() else "dark"
        raise InputError(f"feature is {kind} everywhere, and so has no outline; paint white what belongs together.")
    return inside


def outline_distances(there: Array, toroidal: bool) -> Array:
    """Return the distance of each pixel to the nearest true one of `there`: int64 (H, W), 1 / 16 px, at most 16 px."""
    if not there.any():
        return np.full(there.shape, FAR * PARTS, np.int64)
    around = np.pad(there, FAR, mode="wrap") if toroidal else there
    far = ndimage.distance_transform_edt(~around)
    inner = far[FAR : FAR + there.shape[0], FAR : FAR + there.shape[1]] if toroidal else far
    return np.asarray(np.minimum(np.rint(inner * PARTS), FAR * PARTS), np.int64)


AXES = 8  # dimensions of appearance vectors (2006)
SAMPLE = 8192  # neighbourhoods from which axes are computed; halved, doubled: scores change by 1 % (docs/design/012)
BITS = 4  # fractional bits of values of the stack
WEIGHTS = np.array([[round(256 * 2.0 ** -(dy * dy + dx * dx)) for dx in (-1.0, -0.5, 0.0, 0.5, 1.0)]
                    for dy in (-1.0, -0.5, 0.0, 0.5, 1.0)], np.int64).ravel()  # fmt: skip
"""Weights of the 5 x 5 values, 256 = 1: a Gaussian, 1/2 at 2 px from the middle, so 1/4 for squared differences."""


def without_gaps(picture: Array, exemplar: Exemplar) -> Array:
    """Return a picture with every unusable pixel replaced by the nearest usable one."""
    home = nearest(exemplar.free)
    return picture if home is None else np.asarray(picture[home[0], home[1]])


def _mode(toroidal: bool) -> Any:
    return "wrap" if toroidal else "symmetric"


def bordered(picture: Array, border: int, toroidal: bool) -> Array:
    """Return a picture (H, W, ...) padded by `border` px on all sides: wrapped, or mirrored."""
    return np.pad(picture, [(border, border)] * 2 + [(0, 0)] * (picture.ndim - 2), mode=_mode(toroidal))


def stack_of(picture: Array, levels: int, closed: tuple[bool, bool]) -> Iterator[Array]:
    """Yield the Gaussian stack of a picture (H, W, ...): levels of spacing h = 1, 2, 4, ... px, int32 in 1 / 16.

    A level is blurred from the one before with weights 6, 4, 1 of 16 at 0, +-h/2, +-h px along both axes; `closed`:
    which axes wrap; others are mirrored.
    """
    out = np.asarray(picture, np.int32) << BITS
    for level in range(levels):
        for axis, around in enumerate(closed if level else ()):
            n = out.shape[axis]
            at = np.pad(np.arange(n), 1 << level, mode=_mode(around))
            taps = [np.take(out, at[(t << level) // 2 :][:n], axis) for t in range(5)]
            out = (taps[0] + taps[4] + 4 * (taps[1] + taps[3]) + 6 * taps[2] + 8) >> 4
        yield out


def transformed(picture: Array, h: int, toroidal: bool) -> Array:
    """Return the transformed exemplar of one level of the stack: (H, W, 8) int16, within -1023 .. 1023."""
    height, width, channels = picture.shape
    halved = (picture + 4) >> 3
    halved = halved - halved.reshape(-1, channels).astype(np.int64).sum(axis=0) // (height * width)
    planes = np.ascontiguousarray(np.moveaxis(bordered(halved.astype(np.int32), 2 * h, toroidal), 2, 0))
    every = max(1, height * width // SAMPLE)
    (y, x), (down, across) = np.divmod(np.arange(0, height * width, every), width), np.divmod(np.arange(25), 5)
    taps = planes[:, y[:, None] + h * down, x[:, None] + h * across]
    some = np.moveaxis(taps, 0, 2).reshape(len(y), -1).astype(np.float64)
    weights = np.repeat(WEIGHTS, channels) / 256
    covariance = whole_products(some) / len(some) * weights[:, None] * weights
    axes = np.rint(principal_axes(covariance, AXES)[1] * weights * 16384).astype(np.int64)
    out = np.empty((height, width, AXES), np.int32)
    project_neighbourhoods(planes, h, axes.reshape(AXES, 25, channels), out)
    most = max(int(np.abs(out).max()), 1)
    return np.asarray(out * MIDDLE // most, np.int16) if most > MIDDLE else out.astype(np.int16)


def whole_products(vectors: Array) -> Array:
    """Return the sums of products (n, n) of integer vectors (N, n), centred on their floored mean.

    They are below 2**53, so exact in any order of summation.
    """
    centred = vectors - np.floor(vectors.sum(axis=0) / len(vectors))
    return np.asarray(centred.T @ centred)


def packed(lifted: Array) -> Array:
    """Pack eight values per pixel, 0 .. 2046, (rows, columns, 8) int16 into two words: (positions, 2) uint64."""
    return np.ascontiguousarray(lifted.astype("<u2")).reshape(-1, AXES).view("<u8").astype(np.uint64)


def unpacked_words(words: Array, width: int) -> Array:
    """Return the values that :func:`packed` packed: (rows, width, 8) int16."""
    return words.astype("<u8").view("<u2").astype(np.int16).reshape(-1, width, AXES)
