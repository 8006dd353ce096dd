"""What stores ask of an endless picture, and what is asked of them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Protocol

import numpy as np

from ..arguments import called, pair, whole
from ..errors import ParameterError
from ..geometry import Box
from ..image import Array, Plane
from ..methods.base import WindowMethod
from ..run import Run
from .cells import Cell, Grid
from .ledger import ABOUT

LEAST = 16  # px: shortest side of chunks and tiles


class Picture(Protocol):
    """One plane of an endless texture, drawn where it is asked for; :class:`.texture.Picture` is one."""

    @property
    def method(self) -> WindowMethod:
        """What makes it, with every parameter decided."""

    @property
    def like(self) -> Plane:
        """A plane of the kind, type and channels of what is drawn."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of a sample."""

    @property
    def channels(self) -> int:
        """Channels, alpha included."""

    @property
    def scale(self) -> tuple[int, int]:
        """How many times larger, and how many times smaller, it is than its map."""

    @property
    def digest(self) -> str:
        """What all its pixels follow from, as a hash."""

    def shape_of(self, height: int, width: int) -> tuple[int, ...]:
        """Shape of the array of a box of so many px."""

    def draw(self, box: Box, run: Run | None = None) -> Array:
        """Draw a box of it."""

    def map_box(self, box: Box) -> Box:
        """Return the box of the map under a box of pixels; refused where it lies too far away."""

    def recipe_over(self, box: Box) -> dict[str, Any]:
        """Return all that the pixels of a box follow from."""


class Packer(Protocol):
    """Turns the pixels of a cell into the bytes that a store holds; sent to the workers."""

    def __call__(self, pixels: Array, cell: Cell) -> list[bytes]:
        """Return the pieces of a cell."""


class Store(Protocol):
    """A picture on disk, made cell by cell."""

    @property
    def grid(self) -> Grid:
        """How it is cut into cells."""

    @property
    def packer(self) -> Packer:
        """What packs a cell."""

    @property
    def texture(self) -> Picture:
        """What is stored."""

    @property
    def origin(self) -> tuple[int, int]:
        """The pixel of the endless plane that comes first."""

    @property
    def printable(self) -> str:
        """Its name in messages."""

    def look(self) -> None:
        """Refuse, before any work, a place where this store cannot be; writes nothing."""

    def open(self) -> Iterable[int]:
        """Begin or go on; return the numbers of the cells that are missing or damaged, rising."""

    def put(self, cell: Cell, pieces: list[bytes]) -> None:
        """Write a cell; cells come in the order that was asked for."""

    def finish(self, run: Run) -> None:
        """Make the store whole once all cells are there."""

    def close(self) -> None:
        """Let go of all files."""


def header_of(
    texture: Picture, sides: tuple[int, int], origin: tuple[int, int], layout: dict[str, Any]
) -> dict[str, Any]:
    """What a store holds: all that its bytes depend on; functions by what they say over the whole of it."""
    place = {"size": [sides[1], sides[0]], "origin": [origin[1], origin[0]]}
    kind = {"type": texture.dtype.name, "channels": texture.channels, "kind": texture.like.kind.value}
    recipe = texture.recipe_over(Box(origin[0], origin[1], origin[0] + sides[0], origin[1] + sides[1]))
    return {"holds": ABOUT, "recipe": recipe | place} | kind | layout


def checked(texture: Picture, sides: tuple[int, int], origin: Any) -> tuple[int, int]:
    """Return the first pixel of a picture, or refuse one that lies too far away."""
    try:
        y, x = pair(origin if hasattr(origin, "__len__") else None)
    except ValueError:
        raise ParameterError(f"origin={called(origin)} is no pixel; give (y, x).") from None
    height, width = sides
    texture.map_box(Box(y, x, y + height, x + width))
    return y, x


def check_side(name: str, side: Any, most: int, multiple: int = 1) -> int:
    """Refuse a side of chunks or tiles that cannot be."""
    try:
        number = whole(side)
    except ValueError:
        number = 0
    if not LEAST <= number <= most or number % multiple:
        step = "" if multiple == 1 else f", a multiple of {multiple}"
        raise ParameterError(f"{name}={called(side)} is not allowed; give {LEAST} to {most} px{step}.")
    return number
