"""The canvas: how large, how it wraps, and what is already on it."""

from __future__ import annotations

from dataclasses import dataclass
from types import NoneType

from .arguments import MAX_PIXELS, called, chosen, expect, whole_within
from .errors import InputError, ParameterError
from .geometry import Wrap
from .guide import Guide
from .sourcemap import SourceMap


@dataclass(frozen=True)
class Canvas:
    """The place to fill.

    Parameters
    ----------
    height, width : int
        Size in px, at least 1; at most 2**31 px in all.
    wrap : Wrap
        Along which axes the output must continue in itself.
    start : SourceMap, optional
        A map of the same size, partly filled (``which`` = 255 in its holes); what is there stays.
    guide : Guide, optional
        What should be where.
    rim : int, optional
        How deep, in px from the nearest hole, start pixels may be replaced. None: the method's choice.
    endless : bool
        True where the size is only one to think of: what is made are windows of an endless plane.
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
        if min(self.height, self.width) < 1 or self.height * self.width > MAX_PIXELS:
            refused = f"size={called(self.width)}x{called(self.height)} is not allowed"
            raise ParameterError(f"{refused}; give sides of at least 1 px, at most 2**31 px in all.")
        object.__setattr__(self, "wrap", chosen(Wrap, "wrap", self.wrap))
        expect(self.start, (SourceMap, NoneType), "start", "a SourceMap")
        expect(self.guide, (Guide, NoneType), "guide", "a Guide")
        target = None if self.guide is None else self.guide.target
        for what, its in (("start map", self.start), ("guide's target", target)):
            if its is not None and (its.height, its.width) != (self.height, self.width):
                size = f"{its.width}x{its.height} px"
                raise InputError(f"the {what} is {size}, the canvas {self.width}x{self.height}; make them equal.")
        if self.rim is not None:
            object.__setattr__(self, "rim", whole_within("rim", self.rim, 0))
