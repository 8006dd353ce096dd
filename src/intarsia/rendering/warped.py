"""Draw maps whose pieces are scaled, turned, bent or moved by fractions of a pixel: read between exemplar pixels.

Colours and data are read by Catmull-Rom, colours in linear light with opacity premultiplied, and never leave the range
of the pixels read; normals too, then turned by the frame and made unit length again; labels are those of the nearest
pixel. Where a frame shows the exemplar smaller, the footprint of the pixel is averaged. A pixel that is
masked is never read: next to one the reading is shorter, and where none around may be read, the entry's own pixel
stands for it. Where a place falls on a pixel, and the frame is an isometry or none, the copy is exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..arrays import Array, Mask
from ..blend import Blend, Mixing
from ..errors import InputError, ParameterError
from ..exemplar import Exemplars
from ..image import Kind, Plane
from ..sourcemap import SourceMap
from .colour import Curve, code_shelf, code_steps
from .ground import OUTSIDE, enlarged, ground_of, masks_of, refuse_holes
from .mixing import LabelMixer, Mixer, NormalCoding, coding_of, mixer_of
from .warped_kernels import Part, Reach, WarpField, lay_part, read_labels, read_light, read_vectors, settle_light

MAX_SPREAD = 256
"""The widest feather in px of a plane: every vote is read on its own."""



class Reader(Protocol):
    """How the pixels of one kind of plane are read."""

    def read(self, part: Part, reach: Reach, feather: int) -> tuple[Array, Mask]:
        """Return codes (h, w, C) of a cell, and where nobody voted."""


@dataclass(frozen=True)
class Warped:
    """All that a cell of such a map needs to be drawn."""

    field: WarpField
    wrap: tuple[bool, bool]
    scale: int
    feather: int  # in px of the plane
    reach: Reach
    samples: Array  # (N, C) codes of all exemplars
    reader: Reader
    mixer: Mixer  # only to average blocks

    @classmethod
    def of(
        cls, exemplars: Exemplars, planes: list[Plane], scale: int, smap: SourceMap, blend: Blend
    ) -> Warped:
        """Prepare to draw; ParameterError for a blend that such a map cannot have."""
        grow, shrink = max(scale, 1), max(-scale, 1)
        check_blend(blend, grow, planes[0].kind)
        pixels = [enlarged(p.samples, shrink) for p in planes]
        samples, ground = ground_of(exemplars, pixels, grow, blend.feather * grow)
        masked = any(e.usable is not None for e in exemplars)
        free = masks_of(exemplars, grow) if masked else np.zeros(0, bool)
        curve = Curve.of(planes[0], blend.mixing)
        coding = coding_of(planes)
        return cls(
            _warp_field(smap), (smap.wrap.y, smap.wrap.x), grow, blend.feather * grow,
            Reach(ground.table, free, ground.near), samples, _reader(planes[0], samples, coding, curve),
            mixer_of(planes[0], samples[:1], coding, curve, Mixing.MEAN, None),
        )  # fmt: skip

    def draw(self, y: int, x: int, height: int, width: int) -> Array:
        """Return the codes (h, w, C) of a cell whose first pixel is (y, x)."""
        f = self.feather
        size, origin = (height + f, width + f), (y - f // 2, x - f // 2)
        part = Part(np.empty(size, np.uint8), np.empty((*size, 2)), np.empty((*size, 4)), np.empty(size, np.int64))
        if not lay_part(self.field, origin, self.scale, self.wrap, self.reach.table, part):
            raise InputError(OUTSIDE)
        core = (slice(f // 2, f // 2 + height), slice(f // 2, f // 2 + width))
        refuse_holes(part.which[core], self.field.which)
        codes, lost = self.reader.read(part, self.reach, f)
        if f and lost.any():  # nobody votes: the pixel speaks for itself
            inner = Part(part.which[core].copy(), part.at[core].copy(), part.j[core].copy(), part.own[core].copy())
            codes[lost] = self.reader.read(inner, self.reach, 0)[0][lost]
        return codes


@dataclass(frozen=True)
class Light:
    """Colours and data."""

    samples: Array  # (N, C) codes
    light: Array  # (N, C), int32 or floats
    curve: Curve
    alpha: bool

    def read(self, part: Part, reach: Reach, feather: int) -> tuple[Array, Mask]:
        height, width = (n - feather for n in part.which.shape)
        plain = np.zeros((height, width, self.samples.shape[1]))
        seen = np.zeros_like(plain) if self.alpha else np.zeros((height, width, 1))
        first, opaque, weight = np.full((height, width), -1), np.zeros((height, width)), np.zeros((height, width))
        read_light(part, reach, feather, self.light, self.alpha, (seen, plain), first, (opaque, weight))
        if self.curve.srgb and self.curve.integer and not self.alpha:  # plainly: as below
            coding = code_steps(self.curve.dtype.itemsize), *code_shelf(self.curve.dtype.itemsize)
            codes = np.empty(plain.shape, self.samples.dtype)
            settle_light(plain, weight, first, self.light, self.samples, coding, codes)
            return codes, weight == 0.0
        first = np.maximum(first, 0)
        away = plain / np.maximum(weight, 1.0)[..., None]
        if self.alpha:
            some = opaque > 0.0
            colours = seen[..., :-1] / np.where(some, opaque, 1.0)[..., None]
            away[..., :-1] = np.where(some[..., None], colours, away[..., :-1])
        codes = self.samples[first]
        return np.where(away == 0.0, codes, self.curve.code(self.light[first] + away)), weight == 0.0


@dataclass(frozen=True)
class Vectors:
    """Normals."""

    samples: Array  # (N, 3) codes
    vectors: Array  # (N, 3)
    coding: NormalCoding

    def read(self, part: Part, reach: Reach, feather: int) -> tuple[Array, Mask]:
        size = part.which.shape[0] - feather, part.which.shape[1] - feather
        first, weight = np.zeros(size, np.int64), np.zeros(size)
        lead, total = np.zeros((*size, 3)), np.zeros((*size, 3))
        cross = 1 if self.coding.green_down else -1
        read_vectors(part, reach, feather, self.vectors, cross, first, (lead, total), weight)
        copied = (first >= 0) & (total == 0.0).all(axis=2)
        first = np.where(first >= 0, first, -1 - first)
        v = lead * weight[..., None] + total
        codes = self.coding.turned(self.samples[first >> 3], first & 7)
        return self.coding.of_length_1(v, copied, codes), (weight == 0.0) | ~v.any(axis=2)


@dataclass(frozen=True)
class Names:
    """Labels: the largest share of the nearest pixels."""

    labels: LabelMixer

    def read(self, part: Part, reach: Reach, feather: int) -> tuple[Array, Mask]:
        size = part.which.shape[0] - feather, part.which.shape[1] - feather
        out, weight = np.zeros(size, np.int32), np.zeros(size, np.int64)
        read_labels(part, reach, feather, self.labels.ranks, out, weight)
        return self.labels.names[out], weight == 0


def check_blend(blend: Blend, grow: int = 1, kind: Kind = Kind.COLOUR) -> None:
    """Refuse what cannot be done between pixels, before any work, on a plane `grow` times larger than the map."""
    reason = "pieces of this map are turned, scaled or moved by fractions of a pixel"
    if blend.feather * grow > MAX_SPREAD:
        raise ParameterError(
            f"feather={blend.feather} is too wide where {reason}; give at most {MAX_SPREAD // grow} px."
        )
    if kind in (Kind.NORMAL, Kind.LABEL):
        return
    if blend.finish:
        raise ParameterError(f"{reason}, and levelling compares whole pixels only; draw it without (--level 0).")
    if blend.feather and blend.mixing is Mixing.VARIANCE:
        raise ParameterError(f"mixing=variance needs pieces of whole pixels, but {reason}; give mean or source.")


def _warp_field(smap: SourceMap) -> WarpField:
    size = smap.yx.shape[:2]
    none: Array = np.zeros((0, 0), np.uint8)
    return WarpField(
        smap.yx, np.zeros(size, np.uint8) if smap.which is None else smap.which,
        none if smap.pose is None else smap.pose,
        np.zeros((0, 0, 2, 2), np.float32) if smap.frame is None else smap.frame,
        np.zeros((0, 0, 2), np.float32) if smap.sub is None else smap.sub,
    )  # fmt: skip


def _reader(plane: Plane, samples: Array, coding: NormalCoding | None, curve: Curve) -> Reader:
    """Choose how a plane is read."""
    if coding is not None:
        return Vectors(samples, coding.vectors(samples), coding)
    if plane.kind is Kind.LABEL:
        return Names(LabelMixer.of(samples))
    light = curve.linear(samples)
    light = light.astype(np.int32) if light.dtype.kind == "u" else light  # kernels need one kind of whole numbers
    return Light(samples, light, curve, plane.alpha)
