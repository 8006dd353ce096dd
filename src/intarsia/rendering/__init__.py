"""Rendering of a map: source pixels, blending at seams, tone correction, normal maps and magnification.

This module has the source atlas that a map is drawn from (the pixels of all exemplars in one array, distances to
unusable pixels, the map), the sRGB curve in both directions, exact for integers, and the conversion of planes to the
whole numbers that matching uses.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..foundation import InputError, ndimage
from ..foundation.arrays import Array, Floats, Int32, Int64, Mask, UInt8
from ..foundation.blend import Mixing
from ..foundation.geometry import Box
from ..kernels.maps import HOLE
from ..model import Exemplar, Exemplars
from ..model.image import Kind, Plane, Transfer, from_srgb
from ..model.sourcemap import SourceMap
from .vote_kernels import Map, Reach, cut_window, encode_light

OUTSIDE = "the map points outside its exemplars; it belongs to others, or is damaged."


@dataclass(frozen=True)
class SourceAtlas:
    """A map and one plane of its exemplars, concatenated into one array (the source atlas), in px of the plane."""

    samples: Array  # (N, C) codes of all exemplars
    reach: Reach
    smap: SourceMap
    full: Map
    scale: int  # how many times the plane is larger than the map, at least 1

    @classmethod
    def of(cls, exemplars: Exemplars, planes: list[Plane], scale: int, smap: SourceMap, feather: int) -> SourceAtlas:
        """Concatenate the planes of the exemplars; those -`scale` times smaller than the map are enlarged to its size.

        `feather`: in px of the plane. If it is 0 there are no votes, and distances to unusable pixels are left empty.
        """
        grow = max(scale, 1)
        layers = [enlarged(p.samples, max(-scale, 1)) for p in planes]
        flat = [layer.reshape(-1, layer.shape[2]) for layer in layers]
        samples = flat[0] if len(flat) == 1 else np.concatenate(flat)
        starts = np.cumsum([0] + [len(f) for f in flat[:-1]])
        table = [(n, *la.shape[:2], e.toroidal) for n, la, e in zip(starts, layers, exemplars, strict=True)]
        masked = [e for e in exemplars if any(other.usable is not None for other in exemplars)]
        free = [np.zeros(0, bool), *(enlarged(e.free, grow).reshape(-1) for e in masked)]
        near = [_distances_to_unusable(e, grow, (feather + 1) // 2 + 1).reshape(-1) for e in exemplars if feather]
        reach = Reach(
            np.array(table, np.int64), np.concatenate(free), np.concatenate([np.zeros(0, np.uint16), *near])
        )
        full = smap.yx, smap.numbers, smap.turns
        for array in (samples, *full):
            array.flags.writeable = False
        return cls(samples, reach, smap, full, grow)

    @property
    def usable(self) -> Mask | None:
        """Which pixels (N,) may be used; None if all or none may."""
        free = self.reach.free
        return free if free.any() and not free.all() else None

    def cut(self, box: Box) -> tuple[Array, ...]:
        """Return a box of the map, in px of the plane: (yx, which, pose), and for maps that are not exact `at` and `j`.

        See :func:`~.vote_kernels.cut_window` and :class:`~.warped_kernels.Part`.

        Raise InputError if it points outside its exemplars.
        """
        size, smap = (box.height, box.width), self.smap
        part = np.empty((*size, 2), np.int32), np.empty(size, np.uint8), np.empty(size, np.uint8)
        places = None if smap.exact else (np.empty((*size, 2)), np.empty((*size, 4)))
        wrap = smap.wrap.y, smap.wrap.x
        warp = smap.frame, smap.sub
        if not cut_window(self.full, *warp, (box.y0, box.x0), self.scale, wrap, self.reach.table, part, places):
            raise InputError(OUTSIDE)
        return (*part, *(places or ()))

    def refuse_holes(self, here: UInt8) -> None:
        """Raise InputError if the exemplar numbers `here`, which are to be drawn, hold holes."""
        if (here == HOLE).any():
            holes = int(self.smap.holes.sum())
            raise InputError(
                f"the map has {holes} holes, where nothing was chosen; fill them, or draw a window without."
            )


def enlarged(samples: Array, times: int) -> Array:
    """Return an array (H, W, ...) with each pixel repeated as a square of `times` px; once: the array itself."""
    return samples if times == 1 else np.repeat(np.repeat(samples, times, 0), times, 1)


def _distances_to_unusable(exemplar: Exemplar, grow: int, cap: int) -> NDArray[np.uint16]:
    """Return the chessboard distance of every pixel to the nearest unusable one: 0 there, at most `cap`."""
    height, width = exemplar.height * grow, exemplar.width * grow
    if exemplar.usable is None:
        if exemplar.toroidal:
            return np.full((height, width), cap, np.uint16)
        rows, columns = (np.minimum(np.arange(1, n + 1), np.arange(n, 0, -1)) for n in (height, width))
        return np.minimum(np.minimum.outer(rows, columns), cap).astype(np.uint16)
    usable = enlarged(exemplar.usable, grow)
    # On a torus the nearest one is never further than its longer side.
    edge = min(cap, max(height, width)) if exemplar.toroidal else 1
    padded = np.pad(usable, edge, mode="wrap") if exemplar.toroidal else np.pad(usable, edge)
    distance = ndimage.distance_transform_cdt(padded, metric="chessboard")[edge:-edge, edge:-edge]
    return np.minimum(distance, cap).astype(np.uint16)


BITS = 28
"""Linear light of integer planes is fixed point: white is 1 << BITS."""

_KNEE = (4045, 100_000)  # a fraction of white, 0.04045: codes up to it are on the linear part of the sRGB curve


@dataclass(frozen=True)
class Curve:
    """Conversion between the codes of one plane and linear light, in which they are blended.

    Parameters
    ----------
    dtype : numpy dtype
        Of the codes: uint8, uint16 or a float.
    srgb : bool
        True where codes follow the sRGB curve; otherwise they pass through.
    alpha : bool
        True where the last channel is opacity, which always passes through.
    """

    dtype: np.dtype[Any]
    srgb: bool
    alpha: bool

    @classmethod
    def of(cls, plane: Plane, mixing: Mixing = Mixing.MEAN) -> Curve:
        """Return the curve of a plane: sRGB for sRGB colours, unless their codes are to be blended."""
        coded = plane.kind is Kind.COLOUR and plane.transfer is Transfer.SRGB
        return cls(plane.pixels.dtype, coded and mixing is not Mixing.SOURCE, plane.alpha)

    @property
    def integer(self) -> bool:
        """True for uint8 and uint16 codes."""
        return self.dtype.kind == "u"

    @property
    def table(self) -> Int32:
        """The light of every code; for integers only."""
        return (
            light_table(self.dtype.itemsize)
            if self.srgb
            else np.arange(1 << 8 * self.dtype.itemsize, dtype=np.int32)
        )

    def linear(self, samples: Array) -> Array:
        """Return the light of codes (..., C): int32 fixed point, or float64; codes themselves if they are not sRGB.

        Half floats become single precision, as kernels have no half floats.
        """
        if samples.dtype == np.float16:
            samples = samples.astype(np.float32)
        if not self.srgb:
            return samples
        light = samples.astype(np.int32 if self.integer else np.float64)
        colours, codes = light[..., : samples.shape[-1] - self.alpha], samples[..., : samples.shape[-1] - self.alpha]
        with np.errstate(over="ignore"):
            colours[...] = self.table[codes] if self.integer else np.copysign(from_srgb(np.abs(codes)), codes)
        return light

    def code(self, light: Array) -> Array:
        """Return the codes of light (..., C), rounded half up and clipped for integers."""
        if not self.srgb:
            return self._stored(light)
        colours = light.shape[-1] - self.alpha
        codes = np.empty(light.shape, self.dtype)
        codes[..., colours:] = self._stored(light[..., colours:])
        if self.integer:
            whole = np.fmax(np.fmin(light[..., :colours], 1 << BITS), 0).astype(np.int64)  # NaN becomes white
            codes[..., :colours] = self.divided(whole, np.ones(whole.shape[:2], np.int64))
        else:
            codes[..., :colours] = self._stored(_float_from_linear(light[..., :colours].astype(np.float64)))
        return codes

    def divided(self, total: Array, weight: Array) -> Array:
        """Return the light total / weight, (H, W, C) and (H, W), as codes, rounded once, half up; 0 if weight is 0."""
        codes, size = np.zeros(total.shape, self.dtype), self.dtype.itemsize
        none = np.zeros(0, np.int32)
        coding = (code_steps(size), *code_lookup(size)) if self.srgb else (none, none, 0)
        encode_light(total, weight, coding, codes)
        return codes

    def _stored(self, values: Array) -> Array:
        if self.integer:
            if values.dtype.kind == "f":
                values = np.floor(values + 0.5)
            values = np.clip(values, 0, np.iinfo(self.dtype).max)
        with np.errstate(over="ignore", invalid="ignore"):  # masked pixels may have any value
            return values.astype(self.dtype)


def to_linear(plane: Plane) -> Array:
    """Return the light of a plane, (H, W, C).

    sRGB colours become int32 fixed point (white 2**28) or float64; all else is returned as it is.
    """
    return Curve.of(plane).linear(plane.samples)


def from_linear(values: Array, plane: Plane) -> Array:
    """Return light (H, W, C) in the coding of `plane`: the inverse of `to_linear`, exact for integers."""
    return Curve.of(plane).code(values)


@cache
def light_table(size: int) -> Int32:
    """Return the fixed-point light of every sRGB code of `size` bytes."""
    table = _ceiling(np.arange(65536, dtype=np.int64), 65535)
    return np.ascontiguousarray(table[:: 257 if size == 1 else 1])


@cache
def code_steps(size: int) -> Int32:
    """Return the light at which codes 1, 2, ... begin: half-way between two neighbouring codes."""
    top = 256**size - 1
    return _ceiling(2 * np.arange(top, dtype=np.int64) + 1, 2 * top)


@cache
def code_lookup(size: int) -> tuple[Int32, int]:
    """Return (codes, shift): the search for the code of a light starts at ``codes[light >> shift]``."""
    shift = BITS - 8 * size - 4 * (size == 1)
    starts = np.arange((1 << BITS - shift) + 1, dtype=np.int64) << shift
    return np.searchsorted(code_steps(size), starts, side="right").astype(np.int32), shift


def _ceiling(numerator: Int64, denominator: int) -> Int32:
    """Return the light of numerator / denominator in fixed point, rounded up exactly, on every machine.

    The power 2.4 = 12 / 5 of floats may err in the last bits, so values close to an integer r are decided in whole
    numbers: light <= r  <=>  z**12 * 2**(5 BITS) <= r**5.
    """
    line = -(-(numerator * 25 << BITS) // (323 * denominator))  # v / 12.92
    z = (1000 * numerator + 55 * denominator, 1055 * denominator)
    estimate = (z[0] / z[1]) ** 2.4 * (1 << BITS)
    nearest = np.rint(estimate)
    power = np.ceil(estimate).astype(np.int64)
    for i in np.flatnonzero(np.abs(estimate - nearest) < 1e-4):
        r = int(nearest[i])
        power[i] = r if int(z[0][i]) ** 12 << 5 * BITS <= r**5 * z[1] ** 12 else r + 1
    straight = numerator * _KNEE[1] <= _KNEE[0] * denominator
    return np.where(straight, line, power).astype(np.int32)


def _float_from_linear(v: Floats) -> Floats:
    size = np.abs(v)
    return np.copysign(np.where(size <= 0.04045 / 12.92, size * 12.92, 1.055 * size ** (1 / 2.4) - 0.055), v)


@dataclass(frozen=True)
class Unit:
    """Unit in which the values of planes are converted to whole numbers, for matching.

    Attributes
    ----------
    origin : float
        The value that becomes 0.
    exponent : int
        origin + 2**exponent becomes ``65535 << bits``.
    bits : int
        Bits of resolution beyond 16.
    """

    origin: float = 0.0
    exponent: int = 0
    bits: int = 0

    @classmethod
    def of(cls, values: Floats) -> Unit:
        """Return the unit of floats of any range: the power of two at or above their largest absolute value.

        So heights in metres or millimetres give the same numbers as heights from 0 to 1: exactly if they are a power
        of two times as large, else up to rounding by 2**-23 of the largest value. Codes of 8 and 16 bits given as
        floats become multiples of ``1 << bits``, the resolution of single precision. If the range of the values, but
        for one in a thousand at either end, is less than 2**-16 of the largest, the unit is that range, counted from
        its least value.
        """
        size = float(np.abs(values).max(initial=0.0))
        if not size:
            return cls(bits=FINE)
        least, most = inner_range(values)
        within = min(float(most) - float(least), _GREATEST) or min(float(values.max()) - float(values.min()), _GREATEST)
        if within and _power(size) - _power(within) > 16:
            return cls(float(least), _power(within), FINE)
        return cls(0.0, _power(size), FINE)

    def count(self, values: Floats) -> Int32:
        """Return floats in this unit, rounded half up and clipped to +-2**24; what is not finite counts as 0."""
        finite = np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)
        with np.errstate(over="ignore"):  # masked pixels may have any value
            whole = np.floor(np.ldexp(finite - self.origin, -self.exponent) * float(65535 << self.bits) + 0.5)
        return np.clip(whole, -(1 << 24), 1 << 24).astype(np.int32)


FINE = 7  # bits of resolution beyond 16 of floats of any range: 23, as in single precision
TAIL = 1000  # one of so many values at either end is left out of an inner range
COUNTED = 1 << 17  # range of whole numbers below which quantiles come from a histogram instead of sorting
_GREATEST = float(np.finfo(np.float64).max)
WHITE = Unit()
"""The unit in which white, or the top of an integer's range, is 65535."""


def inner_range(values: Array) -> tuple[Any, Any]:
    """Return the least and the greatest value, without one in a thousand at either end."""
    flat, k = values.ravel(), values.size // TAIL
    ends = (k, flat.size - 1 - k)
    if flat.dtype.kind != "f" and (least := int(flat.min())) > int(flat.max()) - COUNTED:
        low, high = np.searchsorted(np.cumsum(np.bincount(flat - least)), ends, side="right")
        return least + low, least + high
    low, high = np.partition(flat, ends)[list(ends)]
    return low, high


def _power(size: float) -> int:
    """Return the least e with size <= 2**e."""
    share, exponent = math.frexp(size)
    return exponent - (share == 0.5)


def has_own_unit(plane: Plane) -> bool:
    """Return whether values have a unit of their own: floats of data and sRGB, not of light, normals, labels."""
    coded = plane.kind is Kind.COLOUR and plane.transfer is Transfer.SRGB
    return plane.is_float and (coded or plane.kind is Kind.DATA)


def code_values(plane: Plane, unit: Unit = WHITE) -> Int32:
    """Return the whole numbers that matching uses, (H, W, C) int32, equal for equal data of any bit depth.

    Data and sRGB colours are converted in `unit`, opacity and normals always in WHITE: there white, or the top of the
    range, is 65535, and floats are rounded half up. Colours in linear light, integers too, are replaced by an odd
    logarithm, piecewise linear between powers of two: 0 at 0, about 65535 at 1. It is read from the bits of
    float32(abs(v) + 2**-8), so that it is the same on every machine. Labels keep their value modulo 2**32. Values that
    are not finite become 0.
    """
    samples = plane.samples
    if plane.kind is Kind.LABEL:
        whole = np.rint(np.nan_to_num(samples)) if plane.is_float else samples
        return whole.astype(np.int64).astype(np.int32)
    values = np.empty(samples.shape, np.int32)
    colours = samples.shape[2] - plane.alpha
    if plane.kind is Kind.COLOUR and plane.transfer is Transfer.LINEAR:
        values[..., :colours] = _logarithm(code_shares(samples[..., :colours]))
    else:
        values[..., :colours] = _counted(samples[..., :colours], WHITE if plane.kind is Kind.NORMAL else unit)
    values[..., colours:] = _counted(samples[..., colours:], WHITE)
    return values


def _counted(samples: Array, unit: Unit) -> Int32:
    if samples.dtype.kind == "u" and unit is WHITE:  # the same as unit.count(code_shares(samples)), faster
        return samples.astype(np.int32) * np.int32(257 if samples.itemsize == 1 else 1)
    return unit.count(code_shares(samples))


def code_shares(samples: Array) -> Floats:
    """Return integer codes divided by the top of their range, and floats as float64, 0 where they are not finite."""
    if samples.dtype.kind == "u":
        return samples / np.float64(np.iinfo(samples.dtype).max)
    return np.nan_to_num(samples.astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)


def _logarithm(v: Floats) -> Int32:
    # Rounded to float32 first, so that 8 bits, 16 bits and floats of the same data give the same number.
    size = np.minimum(np.abs(v), 1e38).astype(np.float32).astype(np.float64)
    bits = (size + 2.0**-8).astype(np.float32).view(np.int32)
    stops = (bits - np.float32(2.0**-8).view(np.int32)) >> 10  # 2**13 a stop
    return np.where(v < 0, -stops, stops).astype(np.int32)
