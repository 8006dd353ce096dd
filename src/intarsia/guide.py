"""A guide says what the output should look like where: a picture beside each exemplar, one for the canvas."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real

import numpy as np

from .arguments import called, expect, whole
from .errors import InputError
from .image import Kind, Plane

MAX_WEIGHT = 100.0
MAX_REACH = 256
MAX_LABELS = 32


@dataclass(frozen=True)
class Guide:
    """Labels, or a target picture, on both sides: beside the exemplars and over the canvas.

    With labels (kind LABEL) the inside of a region of the target is made of patches that lie wholly in that label,
    and its boundaries of patches that hold a boundary. With other pictures every patch should look like the target
    in the guide: texture transfer.

    Parameters
    ----------
    source : Plane, or a sequence of Planes
        One value (or colour) for each exemplar pixel; one picture for each exemplar.
    target : Plane
        The same for each canvas pixel, of the same kind and number of channels.
    weight : float
        How much the guide counts against the seams, 0 to 100; alpha of Multrus 2003, 5.3. A patch costs
        ``d + weight * g``. Both are root mean squares on a scale of 0 to 1: d of the differences where the patch
        meets what is there, 1 being the range of the exemplars' values; g of the guide's differences over the whole
        patch, so that with labels g * g is the share of pixels of another label.
    reach : int
        With labels: pixels within so many px of a boundary count as partly of both labels, so that patches whose
        boundary lies close by are better than others. 0: a label differs or it does not.

    Raises
    ------
    InputError
        where kind or channels of the pictures differ, or the target names labels that no source has.
    """

    source: Plane | Sequence[Plane]
    target: Plane
    weight: float = 2.0
    reach: int = 0

    def __post_init__(self) -> None:
        expect(self.source, (Plane, Sequence), "the guide's source", "a Plane, or one for each exemplar", InputError)
        expect(self.target, Plane, "the guide's target", "a Plane", InputError)
        sources = (self.source,) if isinstance(self.source, Plane) else tuple(self.source)
        for source in sources:
            expect(source, Plane, "a source of the guide", "a Plane", InputError)
        object.__setattr__(self, "source", sources)
        if not sources:
            raise InputError("the guide has no source picture; give one for each exemplar.")
        if any((s.kind, s.channels) != (self.target.kind, self.target.channels) for s in sources):
            raise InputError("the guide's pictures differ in kind or channels; give all of one kind.")
        number = isinstance(self.weight, Real) and not isinstance(self.weight, bool)
        if not number or not 0 <= self.weight <= MAX_WEIGHT:
            raise InputError(f"weight={called(self.weight)} of the guide is not allowed; give 0 to {MAX_WEIGHT:g}.")
        try:
            reach = whole(self.reach)
        except ValueError:
            reach = -1
        if not 0 <= reach <= MAX_REACH:
            raise InputError(f"reach={called(self.reach)} of the guide is not allowed; give 0 to {MAX_REACH} px.")
        object.__setattr__(self, "reach", reach)
        if self.target.kind is Kind.NORMAL:
            raise InputError("a guide is made of labels, colours or data, not of normals; give another picture.")
        if self.is_labels:
            self._check_labels()

    @property
    def sources(self) -> tuple[Plane, ...]:
        """The pictures beside the exemplars."""
        return (self.source,) if isinstance(self.source, Plane) else tuple(self.source)

    @property
    def is_labels(self) -> bool:
        """True where the guide holds labels."""
        return self.target.kind is Kind.LABEL

    @property
    def names(self) -> tuple[int, ...]:
        """The labels that the target asks for, in their order."""
        return tuple(np.unique(self.target.pixels).tolist()) if self.is_labels else ()

    def name_of(self, label: int) -> str:
        """What a label is called: its colour, where it was one."""
        called = self.target.meta.get("labels", ())
        return str(called[label]) if label < len(called) else str(label)

    @property
    def digest(self) -> str:
        """SHA-256 of all that matters for a result."""
        h = hashlib.sha256(f"{float(self.weight)!r}|{int(self.reach)}".encode())
        for plane in (*self.sources, self.target):
            p = plane.pixels
            h.update(f"|{plane.kind}|{plane.transfer}|{p.dtype}|{p.shape}|".encode())
            h.update(p.astype(p.dtype.newbyteorder("<"), copy=False).data)
        return h.hexdigest()

    @property
    def digests(self) -> tuple[str, ...]:
        """SHA-256 of each source and of the target; of labels by what they are called, so that each stands alone."""
        return tuple(self._digest(plane) for plane in (*self.sources, self.target))

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
        missing = sorted(set(self.names) - there)
        if missing:
            named = ", ".join(map(str, missing[:8])) + ("" if len(missing) <= 8 else ", ...")
            raise InputError(
                f"the target's label{'s' * (len(missing) > 1)} {named} do{'es' * (len(missing) == 1)} not occur beside "
                "the exemplar; map to labels that do."
            )
