"""Normal maps: what codes mean as vectors, and how a vector turns when its piece is turned."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..geometry import ISOMETRIES
from ..image import Array, Plane
from .mix_kernels import turn_codes

SAMPLED = 1 << 18
"""Vectors of a map that are looked at, about."""


@dataclass(frozen=True)
class NormalCoding:
    """How a normal map stores its vectors.

    Parameters
    ----------
    dtype : numpy dtype
        Integers store (n + 1) / 2 of their range, so the opposite of a code v is max - v.
    signed : bool
        Floats only: True where they store n itself (-1..1), False for (n + 1) / 2.
    green_down : bool
        True where green points down the picture (``meta["normals"] == "dx"``); otherwise up ("gl").
    """

    dtype: np.dtype[Any]
    signed: bool
    green_down: bool

    @property
    def top(self) -> int:
        """The code of +1."""
        return int(np.iinfo(self.dtype).max) if self.dtype.kind == "u" else 1

    def turn(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return (channel, sign), (8, 3) each: laid with a pose, component c is sign * old[channel].

        An output pixel p shows the exemplar at u(p), with J = du/dp. A height h(u(p)) has by the chain rule the slope
        J^T times that of h; a normal holds the slope in x and y, so n_yx' = J^T n_yx, and n_z is kept. All this in the
        picture's axes, x right and y down. Where green points up it is -y, which changes the sign of whatever crosses
        from red to green and back.
        """
        channel = np.tile(np.arange(3), (8, 1))
        sign = np.ones((8, 3), dtype=np.int64)
        for pose, isometry in enumerate(ISOMETRIES):
            (a, b), (c, d) = isometry.j
            cross = 1 if self.green_down else -1
            if isometry.swaps:
                channel[pose, :2] = 1, 0
                sign[pose, :2] = b * cross, c * cross
            else:
                sign[pose, :2] = d, a
        return channel, sign

    def vectors(self, codes: Array) -> Array:
        """Return codes as vectors, times the top of the range: int32 for integers, float64 for floats."""
        if self.dtype.kind == "u":
            return 2 * codes.astype(np.int32) - self.top
        values = codes.astype(np.float64)
        return values if self.signed else 2.0 * values - 1.0

    def codes(self, unit: NDArray[np.float64]) -> Array:
        """Return vectors of unit length as codes, rounded half up."""
        if self.signed:
            return unit.astype(self.dtype)
        share = (unit + 1.0) / 2.0
        if self.dtype.kind == "u":
            share = np.floor(np.clip(share, 0.0, 1.0) * self.top + 0.5)
        return share.astype(self.dtype)

    def of_length_1(self, vectors: Array, kept: NDArray[np.bool_], codes: Array) -> Array:
        """Return the codes of vectors (h, w, 3) of any length; `codes` where these are `kept`, or the vector is 0."""
        v = vectors.astype(np.float64)
        length = np.sqrt((v[..., 0] * v[..., 0] + v[..., 1] * v[..., 1]) + v[..., 2] * v[..., 2])
        unit = v / np.where(length > 0, length, 1.0)[..., None]
        return np.where((kept | (length == 0))[..., None], codes, self.codes(unit))

    def turned(self, codes: Array, pose: NDArray[np.integer[Any]]) -> Array:
        """Return codes (h, w, 3) turned by the poses (h, w) of their pieces; only 1 - v of floats rounds."""
        if not pose.any():
            return codes
        channel, sign = self.turn()
        if self.dtype.kind == "u":
            turned = np.empty_like(codes)
            turn_codes(codes, pose, (channel, sign), self.top, turned)
            return turned
        out = np.take_along_axis(codes, channel[pose], axis=2)
        opposite = -out if self.signed else (1 - out).astype(self.dtype)
        return np.where(sign[pose] < 0, opposite, out)


def off_unit(plane: Plane) -> float:
    """Return by how much the vectors of a normal map differ from length 1, on average.

    0.02 in maps of 8 bits, 0.1 where these were reduced; 58 of 61 photographs have 0.17 and more. Of large maps every
    few pixels are looked at.
    """
    codes = plane.samples
    step = max(1, math.isqrt(codes.shape[0] * codes.shape[1] // SAMPLED))
    codes = codes[::step, ::step]
    coding = NormalCoding(codes.dtype, plane.is_float and bool((codes < 0).any()), False)
    vectors = coding.vectors(codes).astype(np.float64) / coding.top
    with np.errstate(invalid="ignore", over="ignore"):
        lengths = np.sqrt((vectors * vectors).sum(axis=2))
    lengths = lengths[np.isfinite(lengths)]
    return float(np.abs(lengths - 1.0).mean()) if lengths.size else 0.0
