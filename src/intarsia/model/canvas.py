"""The canvas: size, periodicity, a partly filled start map, and a guide (labels or a target for texture transfer).

A guide holds one picture for each exemplar and one for the canvas.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from numbers import Real
from types import NoneType
from typing import Any

import numpy as np

from ..foundation import (
    MAX_PIXELS,
    REACHES,
    WEIGHT,
    WEIGHTS,
    InputError,
    ParameterError,
    called,
    chosen,
    expect,
    whole,
    whole_within,
)
from ..foundation.arrays import Array
from ..foundation.geometry import Shaped, Wrap
from .image import Kind, Plane
from .sourcemap import SourceMap


@dataclass(frozen=True)
class Canvas(Shaped):
    """The output to fill.

    Parameters
    ----------
    height, width : int
        Size in px, at least 1; at most 2**31 px in all.
    wrap : {"none", "x", "y", "both"}
        Along which axes the output must be periodic, default "none".
    start : SourceMap, optional
        A map of the same size, partly filled (``which`` = 255 in its holes); filled pixels are kept, but for the rim.
    guide : Guide, optional
        Labels or a target picture of the same size.
    rim : int, optional
        Up to which distance from the nearest hole, in px, start pixels may be replaced. None, the default: decided by
        the method.
    endless : bool
        True if windows of an endless plane are made, default False; the size is then only a typical one.

    Raises
    ------
    ParameterError
        for a size or another argument out of range.
    InputError
        if start map or guide have another size.
    """

    height: int
    width: int
    wrap: Wrap = Wrap.NONE
    start: SourceMap | None = None
    guide: Guide | None = None
    rim: int | None = None
    endless: bool = False

    def __post_init__(self) -> None:
        for side in ("height", "width"):
            object.__setattr__(self, side, whole_within(side, getattr(self, side), -MAX_PIXELS))
        if min(self.shape) < 1 or self.height * self.width > MAX_PIXELS:
            refused = f"size={called(self.width)}x{called(self.height)} is not allowed"
            raise ParameterError(f"{refused}; give sides of at least 1 px, at most 2**31 px in all.")
        object.__setattr__(self, "wrap", chosen(Wrap, "wrap", self.wrap))
        expect(self.start, (SourceMap, NoneType), "start", "a SourceMap")
        expect(self.guide, (Guide, NoneType), "guide", "a Guide")
        target = None if self.guide is None else self.guide.target
        for what, its in (("start map", self.start), ("guide's target", target)):
            if its is not None and its.shape != self.shape:
                size = f"{its.width}x{its.height} px"
                raise InputError(f"the {what} is {size}, the canvas {self.width}x{self.height}; make them equal.")
        if self.rim is not None:
            object.__setattr__(self, "rim", whole_within("rim", self.rim, 0))


MAX_LABELS = 32  # most labels of a guide
RARE = 1000  # a colour on less than one in so many pixels is no label, unless it is common in another picture
SNAPPED = 200  # such colours become their nearest label if they cover less than one in so many pixels, else an error
SHIFTS = (32, 16, 0)  # bits: positions of red, green and blue, 16 bits each, in the number of a colour


@dataclass(frozen=True)
class Guide:
    """Guidance by labels or by a target picture: one picture for each exemplar and one for the canvas.

    With labels (kind LABEL, texture by numbers) the inside of a region of the target is filled with patches that lie
    wholly in that label, and its boundaries with patches that contain a boundary. With other pictures patches are
    chosen whose guide picture resembles the target: texture transfer.

    Parameters
    ----------
    source : Plane, or a sequence of Planes
        One value (or colour) for each exemplar pixel (H, W); one picture for each exemplar.
    target : Plane
        The same for each canvas pixel, of the same kind and number of channels.
    weight : float
        Weight of the guide against the seams, 0 to 100, default 2; alpha of Multrus 2003, 5.3. A patch costs
        ``d * d + weight * weight * g * g``. Both are root mean squares on a scale of 0 to 1: d of the differences
        in the overlap region, 1 being the range of the exemplars' values; g of the guide's differences over the whole
        patch, so that with labels g * g is the share of pixels of another label.
    reach : int
        With labels: pixels within so many px of a boundary, 0 to 256, count as partly of both labels, so that patches
        whose boundary lies close by cost less than others. 0, the default: labels are equal or different.

    Raises
    ------
    InputError
        if kind or channels of the pictures differ, the target has labels that no source has, or a number is out of
        range.
    """

    source: Plane | Sequence[Plane]
    target: Plane
    weight: float = WEIGHT
    reach: int = 0

    def __post_init__(self) -> None:
        expect(self.source, (Plane, Sequence), "the guide's source", "a Plane, or one for each exemplar", InputError)
        expect(self.target, Plane, "the guide's target", "a Plane", InputError)
        sources = self.sources
        for source in sources:
            expect(source, Plane, "a source of the guide", "a Plane", InputError)
        object.__setattr__(self, "source", sources)
        if not sources:
            raise InputError("the guide has no source picture; give one for each exemplar.")
        if any((s.kind, s.channels) != (self.target.kind, self.target.channels) for s in sources):
            raise InputError("the guide's pictures differ in kind or channels; give all of one kind.")
        number = isinstance(self.weight, Real) and not isinstance(self.weight, bool)
        if not number or not 0 <= self.weight <= WEIGHTS:
            raise InputError(f"weight={called(self.weight)} of the guide is not allowed; give 0 to {WEIGHTS:g}.")
        try:
            reach = whole(self.reach)
        except ValueError:
            reach = -1
        if not 0 <= reach <= REACHES:
            raise InputError(f"reach={called(self.reach)} of the guide is not allowed; give 0 to {REACHES} px.")
        object.__setattr__(self, "reach", reach)
        if self.target.kind is Kind.NORMAL:
            raise InputError("a guide is made of labels, colours or data, not of normals; give another picture.")
        if self.is_labels:
            self._check_labels()

    @property
    def sources(self) -> tuple[Plane, ...]:
        """The guide pictures of the exemplars."""
        return (self.source,) if isinstance(self.source, Plane) else tuple(self.source)

    @property
    def is_labels(self) -> bool:
        """Whether the guide holds labels."""
        return self.target.kind is Kind.LABEL

    @property
    def names(self) -> tuple[int, ...]:
        """The labels of the target, ascending."""
        return tuple(np.unique(self.target.pixels).tolist()) if self.is_labels else ()

    def name_of(self, label: int) -> str:
        """Return the name of a label: its colour if it was read from one, else its number."""
        called = self.target.meta.get("labels", ())
        return str(called[label]) if label < len(called) else str(label)

    @property
    def digests(self) -> tuple[str, ...]:
        """SHA-256 of each source and of the target; of labels by their names, so that each is comparable alone."""
        return tuple(self._digest(plane) for plane in (*self.sources, self.target))

    @property
    def as_recipe(self) -> dict[str, Any]:
        """The guide as saved in recipes: hashes of the pictures, weight and reach."""
        *labels, target = self.digests
        return {"labels": labels, "target": target, "weight": self.weight, "reach": self.reach}

    def _digest(self, plane: Plane) -> str:
        pixels, called = plane.pixels, ""
        if self.is_labels:
            found, pixels = np.unique(plane.samples, return_inverse=True)
            called, pixels = ",".join(map(self.name_of, found.tolist())), pixels.astype(np.uint32)
        h = hashlib.sha256(f"{plane.width}x{plane.height}|{called}|{pixels.dtype.name}|".encode())
        h.update(np.ascontiguousarray(pixels, pixels.dtype.newbyteorder("<")).data)
        return h.hexdigest()

    def _check_labels(self) -> None:
        if self.target.channels != 1 or self.target.is_float:
            raise InputError("labels are whole numbers in one channel; number the colours first.")
        there = set().union(*(np.unique(s.pixels).tolist() for s in self.sources))
        if missing := sorted(set(self.names) - there):
            unknown, known = (", ".join(map(self.name_of, some[:8])) for some in (missing, sorted(there)))
            raise InputError(
                f"the target asks for {unknown}, which is in no label picture; paint with {known}, or label it."
            )


def numbered(pictures: Sequence[tuple[str, Plane]], warn: Callable[[str], object]) -> list[Plane]:
    """Convert label pictures from colours to numbers; the same colour gets the same number in all of them.

    Parameters
    ----------
    pictures : sequence of (name, Plane)
        Those of the exemplars, and last the target: gray or colour, 8 or 16 bits a channel.
    warn : function
        Called with one line if a few stray pixels, of smoothed edges, were given the label of the nearest colour.

    Returns
    -------
    list of Plane
        Of kind LABEL, with the colours as names.

    Raises
    ------
    InputError
        for other pixels, too many colours, and too many stray pixels.
    """
    counted = [_counted(*one) for one in pictures]
    areas = [plane.height * plane.width for _, plane in pictures]
    common = [colours[counts * RARE >= area] for (colours, _, counts), area in zip(counted, areas, strict=True)]
    labels = np.unique(np.concatenate(common))
    if len(labels) > MAX_LABELS:
        sizes = [len(colours) for colours, _, _ in counted]
        raise InputError(
            f"{pictures[sizes.index(max(sizes))][0]} has {max(sizes)} colours; save it without smoothed edges, "
            f"with one colour for each of at most {MAX_LABELS} labels."
        )
    meta, numbers = {"labels": tuple(map(_hex, labels.tolist()))}, []
    for (name, plane), (colours, at, counts), area in zip(pictures, counted, areas, strict=True):
        odd = ~np.isin(colours, labels)
        stray, kinds = int(counts[odd].sum()), int(odd.sum())
        if stray * SNAPPED >= area:
            raise InputError(
                f"{name} has {kinds} odd colours on {100 * stray / area:.1f} % of its pixels; "
                "save it without smoothed edges, with one colour for each label."
            )
        if stray:
            warn(f"{name}: {stray} px of {kinds} odd colours were given the nearest label.")
        apart = ((_channels(colours)[:, None] - _channels(labels)) ** 2).sum(axis=2)
        numbers.append(apart.argmin(axis=1)[at].reshape(plane.shape).astype(np.uint8))
    return [Plane(n, Kind.LABEL, meta=meta) for n in numbers]


def _counted(name: str, plane: Plane) -> tuple[Array, Array, Array]:
    """Return the colours of a picture, ascending, which of them each pixel has, and how many pixels have each.

    A colour is one number, with 16 bits each of red, green and blue.
    """
    samples = plane.samples
    if plane.is_float or samples.dtype == np.uint32:
        raise InputError(f"{name} has {samples.dtype} pixels; save labels with 8 or 16 bits a channel.")
    if samples.shape[2] in (2, 4):
        if (samples[:, :, -1] != samples[0, 0, -1]).any():
            raise InputError(f"{name} is partly transparent; save labels without opacity, one colour for each.")
        samples = samples[:, :, :-1]
    if samples.shape[2] not in (1, 3):
        raise InputError(f"{name} has {samples.shape[2]} channels; save labels as gray or colour.")
    full = {"bool": 65535, "uint8": 257}.get(samples.dtype.name, 1)
    if samples.shape[2] == 3:
        samples, full = (samples.astype(np.int64) * full << SHIFTS).sum(axis=2), 1
    else:  # bytes are sorted quickly
        full *= 0x1_0001_0001
    colours, at, counts = np.unique(samples, return_inverse=True, return_counts=True)
    return colours.astype(np.int64) * full, at, counts


def _channels(colours: Array) -> Array:
    return np.asarray(colours[:, None] >> SHIFTS & 65535)


def _hex(colour: int) -> str:
    parts = [colour >> bits & 65535 for bits in SHIFTS]
    if all(p % 257 == 0 for p in parts):
        return "#" + bytes(p // 257 for p in parts).hex()
    return "#" + "".join(f"{p:04x}" for p in parts)
