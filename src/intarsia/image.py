"""A plane is one picture of a surface: pixels, what they mean, and how they are coded.

Packed maps are files whose channels hold one map each: occlusion, roughness and metallic in red, green and blue. Each
channel becomes a plane of its own, so that it is compared by its own range; they are drawn, and written, as one
picture again, channel beside channel.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np

from .arguments import CHANNELS, chosen, expect
from .arrays import Array, pixels_of
from .errors import InputError, ParameterError

DTYPES = ("bool", "uint8", "uint16", "uint32", "float16", "float32", "float64")
MAX_SIDE = 1 << 20

PACKINGS = {
    "orm": ("ao", "roughness", "metallic"),
    "arm": ("ao", "roughness", "metallic"),
    "rma": ("roughness", "metallic", "ao"),
}
"""What the channels of a packed map hold whose name says it."""

PACKED = "packed"
"""A packed map whose name does not say what it holds; and the fact of a plane that tells where it was packed."""


class Kind(StrEnum):
    """What the numbers of a plane mean, and so how votes for a pixel mix."""

    COLOUR = "colour"  # mixed in linear light, with alpha premultiplied
    DATA = "data"  # mixed as it is: height, roughness, occlusion
    NORMAL = "normal"  # vectors: turned with the piece, mixed, made unit length again
    LABEL = "label"  # names: the strongest vote wins


class Transfer(StrEnum):
    """How light became numbers."""

    SRGB = "srgb"
    LINEAR = "linear"


@dataclass(frozen=True)
class Plane:
    """One picture of a surface: an array, its kind and its transfer curve.

    Parameters
    ----------
    pixels : array, shape (H, W) or (H, W, C), C in 1..64
        bool, uint8, uint16, uint32 (labels only), float16, float32 or float64. Copied, unless it is read-only with
        all that lies under it; then never written to.
        A picture of Pillow is taken as Pillow shows it, at its depth; a palette of labels by its numbers.
        Integer colour and data span the range of their type; float colour is 1.0 at white.
    kind : Kind
        COLOUR with 2 or 4 channels has alpha last, not premultiplied.
    transfer : Transfer
        SRGB or LINEAR; matters for COLOUR only.
    meta : dict
        Facts that travel to the output file: ``icc`` (bytes), ``name`` (the format it was read from).

    Raises
    ------
    InputError
        for another dtype or shape, or a plane without pixels.
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
        return self.pixels.reshape(self.height, self.width, -1)

    @property
    def alpha(self) -> bool:
        """True where the last channel is opacity."""
        return self.kind is Kind.COLOUR and self.channels in (2, 4)

    @property
    def is_float(self) -> bool:
        """True for half, float and double pixels."""
        return bool(np.issubdtype(self.pixels.dtype, np.floating))

    def like(self, pixels: Array) -> Plane:
        """Return other pixels (H, W, C) as a plane of the same kind, coding and number of dimensions."""
        if self.pixels.ndim == 2:
            pixels = pixels[:, :, 0]
        return Plane(pixels, self.kind, self.transfer, self.meta)

    def hashed(self, digest: Any, name: str = "") -> None:
        """Feed a digest with all of a plane that matters for a result."""
        p = self.pixels
        digest.update(f"{name}|{self.kind}|{self.transfer}|{p.dtype}|{p.shape}|".encode())
        digest.update(p.astype(p.dtype.newbyteorder("<"), copy=False).data)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        return np.array(self.pixels, dtype=dtype) if copy or dtype else self.pixels

    def _repr_png_(self) -> bytes:
        from .disk.depth import encoded, looked_at

        return encoded(looked_at(self.pixels, self.kind, self.transfer is Transfer.LINEAR))


def _frozen(pixels: Array) -> bool:
    """Whether nobody can write to an array any more, neither through it nor through the array that it is a view of."""
    under = pixels if pixels.base is None else pixels.base
    return type(under) is np.ndarray and under.base is None and not (pixels.flags.writeable or under.flags.writeable)


def unpacked(name: str, plane: Plane, order: Sequence[str] | None = None, file: str = "") -> dict[str, Plane]:
    """Return the channels of a packed map as planes of data, by their names.

    Parameters
    ----------
    name : str
        What the map is called: ``orm``, ``arm``, ``rma`` or ``packed``.
    plane : Plane
        As many channels as are named, or more: those without a name are called ``orm_a`` and the like.
    order : sequence of str, optional
        What the channels hold, ``""`` where that is not known; by default as `name` says.
    file : str
        What messages call the map.

    Raises
    ------
    ParameterError
        where neither `order` nor `name` says what the channels hold.
    InputError
        for a map of fewer channels.
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
    """Tell which planes lie in one packed map: its name -> theirs, channel by channel."""
    found: dict[str, dict[int, str]] = {}
    counts: dict[str, int] = {}
    for name, plane in planes.items():
        if PACKED in plane.meta:
            pack, channel, counts[pack] = plane.meta[PACKED]
            found.setdefault(pack, {})[channel] = name
    return {pack: tuple(own[c] for c in sorted(own)) for pack, own in found.items() if len(own) == counts[pack]}


def packed(planes: Sequence[Plane]) -> Plane:
    """Return planes of one channel as one plane again."""
    first = planes[0]
    about = {key: value for key, value in first.meta.items() if key != PACKED}
    return Plane(np.dstack([p.pixels for p in planes]), first.kind, first.transfer, about)
