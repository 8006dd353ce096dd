"""Boxes, toroidal wrapping, the eight isometries of the square, and positions of patches along an axis."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, NamedTuple

from . import Pair

UNIT = 256  # lattice vectors are whole numbers of 1/256 px


class Shaped:
    """What has a height and a width in px."""

    @property
    def shape(self: Any) -> Pair:
        """(height, width), px."""
        return self.height, self.width


class Wrap(StrEnum):
    """Along which axes a canvas is periodic (toroidal): NONE, X, Y or BOTH."""

    NONE = "none"
    X = "x"
    Y = "y"
    BOTH = "both"

    @property
    def y(self) -> bool:
        """True where the bottom row continues in the top row."""
        return self in (Wrap.Y, Wrap.BOTH)

    @property
    def x(self) -> bool:
        """True where the last column continues in the first."""
        return self in (Wrap.X, Wrap.BOTH)

    @property
    def closed(self) -> tuple[bool, bool]:
        """Whether the canvas is periodic along y, and along x."""
        return self.y, self.x


@dataclass(frozen=True, order=True)
class Box(Shaped):
    """A rectangle of pixels.

    Parameters
    ----------
    y0, x0 : int
        First row and column, px; may be negative.
    y1, x1 : int
        Row and column after the last ones, px.
    """

    y0: int
    x0: int
    y1: int
    x1: int

    @property
    def height(self) -> int:
        return self.y1 - self.y0

    @property
    def width(self) -> int:
        return self.x1 - self.x0

    def moved(self, y: int, x: int) -> Box:
        """Return the box translated by (y, x) px."""
        return Box(self.y0 + y, self.x0 + x, self.y1 + y, self.x1 + x)


class Isometry(NamedTuple):
    """One of the eight isometries of the square (Multrus 2003, 4.1.1, with the misprint of isometry 7 corrected).

    ``j`` is the matrix from output steps to exemplar steps, rows (y, x): moving by d in the output moves by
    ``j d`` in the exemplar. For a square of side N, ``source(i, j)`` is the exemplar pixel shown at (i, j).
    """

    id: int
    name: str
    j: tuple[Pair, Pair]

    @property
    def swaps(self) -> bool:
        """True where rows become columns, so that only square patches fit."""
        return self.j[0][0] == 0

    def start(self, height: int, width: int) -> Pair:
        """Return the exemplar pixel shown at (0, 0) when a whole height x width picture is placed in this pose."""
        (a, b), (c, d) = self.j
        return (height - 1 if a < 0 or b < 0 else 0), (width - 1 if c < 0 or d < 0 else 0)


ISOMETRIES = (
    Isometry(0, "identity", ((1, 0), (0, 1))),
    Isometry(1, "mirror left-right", ((1, 0), (0, -1))),
    Isometry(2, "mirror up-down", ((-1, 0), (0, 1))),
    Isometry(3, "transpose", ((0, 1), (1, 0))),
    Isometry(4, "anti-transpose", ((0, -1), (-1, 0))),
    Isometry(5, "rotate 90", ((0, 1), (-1, 0))),
    Isometry(6, "rotate 180", ((-1, 0), (0, -1))),
    Isometry(7, "rotate 270", ((0, -1), (1, 0))),
)

ISOMETRY_SETS = {
    "none": (0,),
    "180": (0, 1, 2, 6),
    "90": (0, 3, 4, 5, 7),
    "both": (0, 1, 2, 3, 4, 5, 6, 7),
}


def spread(length: int, patch: int, overlap: int, wrap: bool) -> tuple[list[int], int]:
    """Place patches along one axis so that they fill it exactly, overlapping by at least `overlap` px.

    Returns the first pixels of the patches and the patch length used. If the length is no multiple of the pitch the
    overlaps widen evenly; nothing is cropped. On a periodic axis of more than 1 px at least two patches are placed, so
    that none has to be joined to itself.
    """
    pitch = patch - overlap
    if wrap:
        if length == 1:
            return [0], 1
        count = max(2, -(-length // pitch))
        return [i * length // count for i in range(count)], min(patch, length)
    patch = min(patch, length)
    count = 1 if patch == length else -(-(length - overlap) // pitch)
    count = max(count, 1 if patch == length else 2)
    return [i * (length - patch) // max(count - 1, 1) for i in range(count)], patch


def patch_starts(length: int, patch: int, overlap: int, wrap: bool, hangs: int | None = None) -> tuple[list[int], int]:
    """Place patches along one axis: spread evenly, or at their exact pitch and cropped at the border.

    `hangs` None, or a periodic axis: spread evenly. Otherwise the first patch begins `hangs` times the overlap before
    pixel 0: with 1 its overlap region lies outside (Multrus 2003, 3.2.1), with 0 it begins at pixel 0 (Robinson 2004).
    Returns the first pixels of the patches, ascending, and the patch length; all in px.
    """
    if hangs is None or wrap:
        return spread(length, patch, overlap, wrap)
    return list(range(-hangs * overlap, max(length - overlap, 1 - hangs * overlap), patch - overlap)), patch


def overlap_range(length: int, patch: int, overlap: int, wrap: bool, hangs: int | None = None) -> Pair:
    """Return the least and the most overlap, px, of neighbouring patches placed by :func:`patch_starts`."""
    starts, side = patch_starts(length, patch, overlap, wrap, hangs)
    after = [*starts[1:], starts[0] + length] if wrap else starts[1:]
    found = [side - (b - a) for a, b in zip(starts, after, strict=False)] or [overlap]
    return min(found), max(found)


def apart(a: float, b: float, length: int, wrap: bool) -> float:
    """Return the distance of two coordinates, the short way round if the canvas wraps."""
    away = abs(a - b)
    return min(away % length, -away % length) if wrap else away
