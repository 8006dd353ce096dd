"""Where a canvas is not empty at the start: a picture to be continued, or one with holes to be filled.

Extending and healing are no modes of their own: both are a start map, that is a map with holes, and any method
that can continue one fills them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arguments import whole_within
from ..arrays import marks
from ..canvas import Canvas
from ..errors import InputError, ParameterError
from ..exemplar import Exemplar
from ..frames import UPRIGHT
from ..geometry import Box, Wrap
from ..image import MAX_SIDE
from ..lazy import ndimage
from ..sourcemap import HOLE, Source, SourceMap, identity
from ..synthesis import Scene

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Margins:
    """How far a picture is extended on each side, px."""

    left: int = 0
    right: int = 0
    top: int = 0
    bottom: int = 0

    def __post_init__(self) -> None:
        for side in ("left", "right", "top", "bottom"):
            object.__setattr__(self, side, whole_within(side, getattr(self, side), 0))
        if not (self.left or self.right or self.top or self.bottom):
            raise ParameterError("no side is extended; give at least one of left, right, top and bottom, in px.")

    def around(self, height: int, width: int) -> Box:
        """The extended picture as a box, seen from the first pixel of the old one."""
        return Box(-self.top, -self.left, height + self.bottom, width + self.right)


def extended(sources: Sequence[Source], number: int, margins: Margins) -> SourceMap:
    """Return the map that shows exemplar `number` in the middle of empty margins."""
    old = identity(sources, number)
    height, width = old.height + margins.top + margins.bottom, old.width + margins.left + margins.right
    Canvas(height, width)  # refuses what is too large
    yx, which = np.zeros((height, width, 2), np.int32), np.full((height, width), HOLE, np.uint8)
    inside = slice(margins.top, margins.top + old.height), slice(margins.left, margins.left + old.width)
    yx[inside], which[inside] = old.yx, number
    return replace(old, yx=yx, which=which)


def with_hole(smap: SourceMap, hole: ArrayLike) -> SourceMap:
    """Return a map without the pixels where `hole` (H, W) is true."""
    holes = marks(hole, "the hole's mask")
    if holes.shape != (smap.height, smap.width):
        raise InputError(
            f"the hole's mask is {holes.shape[-1]}x{holes.shape[0]} px, the map {smap.width}x{smap.height}; "
            "make them equal."
        )
    which = np.zeros(holes.shape, np.uint8) if smap.which is None else smap.which
    pose = None if smap.pose is None else np.where(holes, 0, smap.pose)
    frame = None if smap.frame is None else np.where(holes[:, :, None, None], UPRIGHT, smap.frame)
    sub = None if smap.sub is None else np.where(holes[:, :, None], np.float32(0), smap.sub)
    yx, which = np.where(holes[:, :, None], 0, smap.yx), np.where(holes, HOLE, which)
    return replace(smap, yx=yx, which=which, pose=pose, frame=frame, sub=sub)


def grown_hole(hole: ArrayLike, px: int, wrap: Wrap = Wrap.NONE) -> Mask:
    """Return a hole larger by `px` on every side, corners included; around the border where the canvas wraps."""
    px = whole_within("grow", px, 0, MAX_SIDE)
    out = marks(hole, "the hole's mask").astype(np.uint8)
    for axis, round_it in enumerate((wrap.y, wrap.x)):
        shape = tuple(2 * px + 1 if a == axis else 1 for a in (0, 1))
        out = ndimage.maximum_filter(out, size=shape, mode="wrap" if round_it else "constant")
    return out.astype(bool)


def extension(
    picture: Exemplar, margins: Margins, donors: Sequence[Exemplar] = (), wrap: Wrap = Wrap.NONE
) -> Scene:
    """Prepare to extend a picture with pieces of itself, or of `donors` alone if any are given."""
    exemplars = shelf_of(picture, donors)
    start = replace(extended([e.source for e in exemplars], 0, margins), wrap=wrap)
    sides = [margins.left, margins.right, margins.top, margins.bottom]
    return Scene(exemplars, Canvas(start.height, start.width, wrap, start), {"extend": sides})


def scene_to_heal(
    picture: Exemplar, hole: ArrayLike, donors: Sequence[Exemplar] = (), wrap: Wrap = Wrap.NONE, grow: int = 0
) -> Scene:
    """Prepare to fill the holes of a picture with other parts of it, or with pieces of `donors` alone.

    The holes are enlarged by `grow` px first. Nothing is sampled from the hole, and no pixel outside of it changes.

    Raises
    ------
    InputError
        where the hole is nowhere, everywhere, or of another size than the picture.
    """
    holes = grown_hole(hole, grow, wrap)
    if holes.shape != (picture.height, picture.width):
        raise InputError(
            f"the hole's mask is {holes.shape[-1]}x{holes.shape[0]} px, {picture.name} "
            f"{picture.width}x{picture.height}; make them equal."
        )
    described = f"{picture.name} ({picture.width}x{picture.height} px)"
    if not holes.any():
        raise InputError(f"the hole of {described} is empty; mark in white what is to be healed.")
    if holes.all():
        raise InputError(f"the hole covers all of {described}; leave something of it to continue from.")
    usable = ~holes if picture.usable is None else picture.usable & ~holes
    if not donors and not usable.any():
        raise InputError(f"nothing of {picture.name} may be used for healing; mark less, or name another source.")
    exemplars = shelf_of(picture if donors else replace(picture, usable=usable), donors)
    start = replace(with_hole(identity([e.source for e in exemplars], 0), holes), wrap=wrap)
    return Scene(exemplars, Canvas(start.height, start.width, wrap, start, rim=0), {"heal": {"grow": grow}})


def shelf_of(picture: Exemplar, donors: Sequence[Exemplar]) -> tuple[Exemplar, ...]:
    """The picture and its donors; beside donors the picture is only shown."""
    if not donors:
        return (picture,)
    nothing = np.zeros((picture.height, picture.width), bool)
    return replace(picture, usable=nothing), *donors
