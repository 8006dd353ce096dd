"""Planes: images with a kind (colour, data, normal, label) and a transfer curve; packed maps; conversion of depths.

Packed maps are files whose channels hold one map each, such as occlusion, roughness and metallic in red, green and
blue. Each channel becomes a plane of its own, so that it is compared by its own range; they are rendered and written as
one picture again.

Below planes: conversion between depths, rounded to the nearest value, and to 8 bits for display.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np

from ..foundation import CHANNELS, InputError, ParameterError, chosen, expect, said
from ..foundation.arrays import Array, Floats, pixels_of
from ..foundation.geometry import Shaped

DTYPES = ("bool", "uint8", "uint16", "uint32", "float16", "float32", "float64")
MAX_SIDE = 1 << 20  # px: longest side of a plane

PACKINGS = {
    "orm": ("ao", "roughness", "metallic"),
    "arm": ("ao", "roughness", "metallic"),
    "rma": ("roughness", "metallic", "ao"),
}
"""Contents of the channels of packed maps with these names."""

PACKED = "packed"
"""Name of a packed map without a fixed order of channels; also the key of `Plane.meta` for where a plane was packed."""


class Kind(StrEnum):
    """What the values of a plane mean, which decides how overlapping pieces are mixed.

    COLOUR is mixed in linear light with premultiplied opacity; DATA (height, roughness, occlusion) as it is; of NORMAL
    vectors are rotated with their piece, mixed and normalised; of LABEL the label of the largest total weight is taken.
    """

    COLOUR = "colour"  # mixed in linear light, with alpha premultiplied
    DATA = "data"  # mixed as it is: height, roughness, occlusion
    NORMAL = "normal"  # vectors: rotated with the piece, mixed, normalised to unit length
    LABEL = "label"  # labels: that of the largest total weight


class Transfer(StrEnum):
    """Transfer curve of colour values."""

    SRGB = "srgb"
    LINEAR = "linear"


@dataclass(frozen=True)
class Plane(Shaped):
    """One picture of a surface: an array, its kind and its transfer curve.

    Parameters
    ----------
    pixels : array, shape (H, W) or (H, W, C), C in 1..64
        bool, uint8, uint16, uint32 (labels only), float16, float32 or float64. Copied, unless the array and its base
        are read-only. Pillow images are taken as Pillow displays them, at their depth; palettes of labels by index.
        Integer colour and data span the range of their type; float colour is 1.0 at white.
    kind : {"colour", "data", "normal", "label"}
        Default "colour". Colour with 2 or 4 channels has opacity (alpha) last, not premultiplied.
    transfer : {"srgb", "linear"}
        Transfer curve of colour values, default "srgb"; not used for other kinds.
    meta : dict
        Metadata copied to the output file: ``icc`` (bytes), ``name`` (the format it was read from).

    Raises
    ------
    InputError
        for other dtypes or shapes, or an empty array; for normals without 3 channels, or bool or uint32 that are no
        labels.
    ParameterError
        for an unknown kind or transfer curve.
    """

    pixels: Array
    kind: Kind = Kind.COLOUR
    transfer: Transfer = Transfer.SRGB
    meta: dict[str, Any] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        kind = chosen(Kind, "kind", self.kind)
        pixels = pixels_of(self.pixels, kind is Kind.LABEL)
        if pixels.dtype.name not in DTYPES:
            raise InputError(f"pixels of type {pixels.dtype} are not supported; convert to one of {', '.join(DTYPES)}.")
        if pixels.ndim not in (2, 3) or 0 in pixels.shape:
            raise InputError(f"an array of shape {pixels.shape} is no picture; give (height, width[, channels]).")
        if pixels.ndim == 3 and pixels.shape[2] > 64:
            raise InputError(f"{pixels.shape[2]} channels are too many; at most 64.")
        if max(pixels.shape[:2]) > MAX_SIDE:
            raise InputError(f"a side of {max(pixels.shape[:2])} px is too long; at most {MAX_SIDE}.")
        if kind is Kind.NORMAL and (pixels.ndim != 3 or pixels.shape[2] != 3):
            raise InputError("a normal map needs 3 channels; drop the others first.")
        if kind is not Kind.LABEL and pixels.dtype.name in ("uint32", "bool"):
            raise InputError(f"{pixels.dtype} pixels can only be labels; convert to uint8 or uint16.")
        own = pixels.astype(pixels.dtype.newbyteorder("="), order="C", copy=not _frozen(pixels))
        own.flags.writeable = False
        object.__setattr__(self, "pixels", own)
        object.__setattr__(self, "kind", kind)
        object.__setattr__(self, "transfer", chosen(Transfer, "transfer", self.transfer))
        expect(self.meta, dict, "meta", "a dict")

    def __repr__(self) -> str:
        return f"<plane: {self.width}x{self.height} px, {self.kind.value}, {self.pixels.dtype} x {self.channels}>"

    @property
    def height(self) -> int:
        """Rows."""
        return int(self.pixels.shape[0])

    @property
    def width(self) -> int:
        """Columns."""
        return int(self.pixels.shape[1])

    @property
    def channels(self) -> int:
        """Channels, alpha included."""
        return 1 if self.pixels.ndim == 2 else int(self.pixels.shape[2])

    @property
    def samples(self) -> Array:
        """The pixels as (H, W, C), a view."""
        return self.pixels.reshape(*self.shape, -1)

    @property
    def alpha(self) -> bool:
        """Whether the last channel is opacity."""
        return self.kind is Kind.COLOUR and self.channels in (2, 4)

    @property
    def is_float(self) -> bool:
        """Whether pixels are half, float or double."""
        return bool(np.issubdtype(self.pixels.dtype, np.floating))

    def like(self, pixels: Array) -> Plane:
        """Return pixels (H, W, C) as a plane of the same kind, transfer, meta and number of dimensions."""
        if self.pixels.ndim == 2:
            pixels = pixels[:, :, 0]
        return Plane(pixels, self.kind, self.transfer, self.meta)

    def hashed(self, digest: Any, name: str = "") -> None:
        """Update a hash with everything of the plane that affects a result."""
        p = self.pixels
        digest.update(f"{name}|{self.kind}|{self.transfer}|{p.dtype}|{p.shape}|".encode())
        digest.update(p.astype(p.dtype.newbyteorder("<"), copy=False).data)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(self.pixels, dtype=dtype) if copy or dtype else self.pixels

    def _repr_png_(self) -> bytes:
        """Return the plane as an 8-bit PNG, which notebooks show."""
        from PIL import Image

        shown, buffer = to_display(self.pixels, self.kind, self.transfer is Transfer.LINEAR), io.BytesIO()
        Image.fromarray(np.ascontiguousarray(shown)).save(buffer, "png")
        return buffer.getvalue()


def _frozen(pixels: Array) -> bool:
    """Whether an array and the array that it is a view of are both read-only."""
    under = pixels if pixels.base is None else pixels.base
    return type(under) is np.ndarray and under.base is None and not (pixels.flags.writeable or under.flags.writeable)


def unpacked(name: str, plane: Plane, order: Sequence[str] | None = None, file: str = "") -> dict[str, Plane]:
    """Split a packed map into planes of data, one for each channel, by name.

    Parameters
    ----------
    name : str
        Name of the map: ``orm``, ``arm``, ``rma`` or ``packed``.
    plane : Plane
        As many channels as are named, or more: those without a name are called ``orm_a`` and the like.
    order : sequence of str, optional
        Contents of the channels, ``""`` if not known; by default given by `name`.
    file : str
        Name of the map in messages.

    Raises
    ------
    ParameterError
        if neither `order` nor `name` gives the contents of the channels.
    InputError
        for a map with fewer channels.
    """
    names = PACKINGS.get(name) if order is None else order
    file = file or f"the plane {name}"
    if names is None:
        raise ParameterError(f"{file} is packed, and nothing says how; give --packed R=ao,G=roughness,B=metallic.")
    if plane.channels < len(names) or plane.channels > len(CHANNELS):
        held = ", ".join(n or "nothing" for n in names)
        raise InputError(f"{file} has {plane.channels} channels, and should hold {held}; give another --packed or map.")
    names = [*names, *[""] * (plane.channels - len(names))]
    about, samples = plane.meta, plane.samples
    return {
        own or f"{name}_{CHANNELS[c].lower()}": Plane(
            np.ascontiguousarray(samples[:, :, c]), Kind.DATA, plane.transfer,
            about | {PACKED: (name, c, plane.channels)},
        )
        for c, own in enumerate(names)
    }  # fmt: skip


def packs_of(planes: Mapping[str, Plane]) -> dict[str, tuple[str, ...]]:
    """Return the complete packed maps among planes: name of the map -> names of its planes, channel by channel."""
    found: dict[str, dict[int, str]] = {}
    counts: dict[str, int] = {}
    for name, plane in planes.items():
        if PACKED in plane.meta:
            pack, channel, counts[pack] = plane.meta[PACKED]
            found.setdefault(pack, {})[channel] = name
    return {pack: tuple(own[c] for c in sorted(own)) for pack, own in found.items() if len(own) == counts[pack]}


def packed(planes: Sequence[Plane]) -> Plane:
    """Return planes of one channel stacked as one plane."""
    first = planes[0]
    about = {key: value for key, value in first.meta.items() if key != PACKED}
    return Plane(np.dstack([p.pixels for p in planes]), first.kind, first.transfer, about)


EIGHT = np.dtype(np.uint8)


_TOGETHER = 1 << 18  # samples that are converted at a time
DTYPE_OF_DEPTH = {"8": "uint8", "16": "uint16", "half": "float16", "float": "float32"}


def dtype_of(depth: int | str) -> str:
    """Return the dtype of a depth: 8, 16, half or float."""
    word = str(depth).lower() if isinstance(depth, (int, str)) else ""
    if isinstance(depth, bool) or word not in DTYPE_OF_DEPTH:
        raise ParameterError(f"depth={said(depth)} is not allowed; choose 8, 16, half or float.")
    return DTYPE_OF_DEPTH[word]


def converted(pixels: Array, kind: str, linear: bool, dtype: np.dtype[Any]) -> Array:
    """Return pixels (H, W) or (H, W, C) in another type; `kind` is "colour", "data" or "label".

    Colour: from floats to integers linear light (`linear`) is encoded by the sRGB curve; from integers to floats sRGB
    values are decoded to linear light. Floats are clipped to 0..1 when they become integers, NaN becomes 0. Labels keep
    their numbers; ParameterError if these do not fit.
    """
    floats = pixels.dtype.kind == "f"
    if pixels.dtype == dtype:
        return pixels
    if kind == "label":
        return _numbers_kept(pixels, dtype)
    if floats and dtype.kind == "f":
        with np.errstate(over="ignore"):
            return pixels.astype(dtype)
    if not floats and dtype.kind == "u":
        return _by_rows(pixels, dtype, _other_codes)
    if floats:
        return _by_rows(pixels, dtype, lambda p: _to_codes(p, kind, linear, dtype))
    top = np.float64(np.iinfo(pixels.dtype).max)
    return _by_rows(pixels, dtype, lambda p: _on_colour(p / top, kind, from_srgb).astype(dtype))


def _by_rows(pixels: Array, dtype: np.dtype[Any], change: Callable[[Array], Array]) -> Array:
    """Apply a conversion to a few rows at a time, as intermediate results take 40 bytes a sample."""
    made = np.empty(pixels.shape, dtype)
    rows = max(1, _TOGETHER // max(1, pixels[:1].size))
    for y in range(0, len(pixels), rows):
        made[y : y + rows] = change(pixels[y : y + rows])
    return made


def _to_codes(pixels: Array, kind: str, linear: bool, dtype: np.dtype[Any]) -> Array:
    values = pixels.astype(np.float64)
    if linear:
        values = _on_colour(values, kind, to_srgb)
    values = np.clip(np.nan_to_num(values, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    return np.floor(values * np.iinfo(dtype).max + 0.5).astype(dtype)


def to_srgb(linear: Array) -> Floats:
    """Return linear light encoded by the sRGB curve (IEC 61966-2-1)."""
    v = np.clip(np.nan_to_num(linear, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    code: Floats = np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.power(v, 1 / 2.4) - 0.055)
    return code


def from_srgb(code: Array) -> Floats:
    """Return sRGB values decoded to linear light."""
    v = np.asarray(code, np.float64)
    return np.where(v <= 0.04045, v / 12.92, np.power((v + 0.055) / 1.055, 2.4))


def _on_colour(values: Array, kind: str, curve: Callable[[Array], Array]) -> Array:
    if kind != "colour":
        return values
    if values.ndim == 2 or values.shape[2] not in (2, 4):
        return curve(values)
    return np.concatenate([curve(values[..., :-1]), values[..., -1:]], axis=-1)


def _other_codes(pixels: Array) -> Array:
    if pixels.dtype == np.uint8:
        return pixels.astype(np.uint16) * np.uint16(257)
    return ((pixels.astype(np.uint32) + 128) // 257).astype(np.uint8)


def _numbers_kept(pixels: Array, dtype: np.dtype[Any]) -> Array:
    kept = pixels.astype(dtype)
    if not np.array_equal(kept.astype(pixels.dtype), pixels):
        raise ParameterError(f"labels up to {pixels.max()} do not fit {dtype}; choose a larger depth, or .tif.")
    return kept


def to_display(pixels: Array, kind: str, linear: bool) -> Array:
    """Return 8 bits for display: floats clipped, data normalised to its range, labels in distinct colours.

    `pixels` and the result: (H, W) or (H, W, C). `kind` is "colour", "data" or "label"; `linear`: whether colours are
    linear light.
    """
    samples = pixels.reshape(*pixels.shape[:2], -1)
    if kind == "label":
        seen = _in_colours(samples)
    else:
        seen = converted(_to_its_range(samples) if kind == "data" else samples, kind, linear, EIGHT)
    if seen.shape[2] > 4:
        seen = seen[:, :, :3]
    return seen[:, :, 0] if seen.shape[2] == 1 else seen


def _to_its_range(samples: Array) -> Array:
    if samples.dtype.kind != "f":
        return samples
    values = samples.astype(np.float64)
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    return (values - low) / ((high - low) or 1.0) if low < 0.0 or high > 1.0 else values


def _in_colours(values: Array) -> Array:
    """Return a distinct colour for every label; coloured label maps keep their colours."""
    if values.dtype == bool:
        return values.astype(np.uint8) * np.uint8(255)
    if values.shape[2] > 1:
        return values.astype(np.uint8) if values.dtype == np.uint32 else converted(values, "data", False, EIGHT)
    if values.dtype.kind == "f":
        values = values.astype(np.float32).view(np.uint32)
    mixed = values[:, :, 0].astype(np.uint32)
    mixed = (mixed ^ (mixed >> np.uint32(16))) * np.uint32(0x7FEB352D)
    mixed = (mixed ^ (mixed >> np.uint32(15))) * np.uint32(0x846CA68B)
    mixed ^= mixed >> np.uint32(16)
    colours = np.stack([(mixed >> np.uint32(s)) & np.uint32(255) for s in (0, 8, 16)], axis=2)
    colours = (colours * 3 // 4 + 48).astype(np.uint8)
    colours[values[:, :, 0] == 0] = 0
    return colours
