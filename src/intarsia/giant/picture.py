"""Random-access rendering of one plane of an endless texture, and the interface of stores on disk.

Every window is computed on its own: its map with the margin that feather and finish need, then its rendering. So the
pixels do not depend on windows rendered before, on the size of cells, or on who renders them.
"""

from __future__ import annotations

import importlib
import json
import operator
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from ..disk.atomic import PathLike, check_writable
from ..foundation import (
    MissingExtraError,
    ParameterError,
    Record,
    called,
    expect_path,
    pair,
    said,
    size_of,
    whole_within,
)
from ..foundation.arrays import Array, Pair
from ..foundation.blend import Blend
from ..foundation.geometry import Box, Shaped
from ..foundation.run import Run
from ..methods import FARTHEST, WindowMethod, recipe_settings
from ..model import Exemplar
from ..model.image import Plane
from ..model.sourcemap import SourceMap
from ..rendering.render import render
from ..synthesis import recipe_exemplars
from ..version import VERSION

SIDE = 1024
"""Side of the cells, px, into which large windows are cut."""

MOST_CELLS = 1 << 22  # of one stored picture: a guard, so that listing them stays quick


class Cell(NamedTuple):
    """One cell of a stored picture: its number, its row and column among the cells, and its box in the picture."""

    number: int
    row: int
    column: int
    box: Box


@dataclass(frozen=True)
class Grid(Shaped):
    """A picture of height x width px, cut into cells of rows x columns px; the last of each axis may be smaller."""

    height: int
    width: int
    rows: int
    columns: int

    def __post_init__(self) -> None:
        if self.down * self.across > MOST_CELLS:
            raise ParameterError(
                f"{self.width}x{self.height} px are {self.down * self.across} cells of {self.columns}x{self.rows}; "
                f"at most {MOST_CELLS}, so choose a smaller size or larger chunks."
            )

    @property
    def down(self) -> int:
        """Number of rows of cells."""
        return -(-self.height // self.rows)

    @property
    def across(self) -> int:
        """Number of columns of cells."""
        return -(-self.width // self.columns)

    def __len__(self) -> int:
        return self.down * self.across

    def cell(self, number: int) -> Cell:
        """Return the cell with a number, counted row by row."""
        row, column = divmod(number, self.across)
        y, x = row * self.rows, column * self.columns
        box = Box(y, x, min(y + self.rows, self.height), min(x + self.columns, self.width))
        return Cell(number, row, column, box)

    def __iter__(self) -> Iterator[Cell]:
        return (self.cell(n) for n in range(len(self)))


def box_of(key: Any) -> Box:
    """Return the box of the key of ``w[y0:y1, x0:x1]``; negative numbers are coordinates, not counted from an end."""
    try:
        rows, columns = key
        y0, y1, x0, x1 = (operator.index(end) for one in (rows, columns) for end in (one.start, one.stop))
        proper = y0 < y1 and x0 < x1 and {rows.step, columns.step} <= {None, 1}
    except (TypeError, ValueError, AttributeError):
        proper = False
    if not proper:
        raise ParameterError(
            "that is no window of an endless texture; give rows and columns as texture[y0:y1, x0:x1], whole numbers "
            "with y0 < y1 and x0 < x1, and no step."
        )
    return Box(y0, x0, y1, x1)


def sides_of(shape: Any) -> Pair:
    """Return (height, width) of a size; one number is a square. ParameterError if it is out of range."""
    height, width = size_of(shape, "shape")
    if min(height, width) < 1 or max(height, width) > FARTHEST:
        raise ParameterError(f"shape=({called(height)}, {called(width)}) is not allowed; give sides of 1 to 2**40 px.")
    return height, width


LEAST = 16  # px: least side of chunks and tiles


@dataclass(frozen=True, eq=False, repr=False)
class EndlessPlane:
    """One plane of an endless texture, rendered window by window.

    `method` has every parameter decided; `blend`: how pieces are blended; `name`: the plane that is rendered.
    """

    exemplars: tuple[Exemplar, ...]
    method: WindowMethod
    seed: int
    blend: Blend
    name: str

    @property
    def planes(self) -> tuple[str, ...]:
        """The names of all planes; packed maps count as one."""
        return self.exemplars[0].pictures

    def plane(self, name: str) -> Self:
        """Return the texture with another plane rendered, as ``texture.plane("normal")``."""
        if not isinstance(name, str) or name not in (*self.planes, *self.exemplars[0].drawn):
            raise ParameterError(f"plane={said(name)} is unknown; choose one of {', '.join(self.planes)}.")
        return replace(self, name=name)

    @property
    def like(self) -> Plane:
        """The plane of the exemplar that is rendered: its dtype, kind, transfer and meta are those of every window."""
        plane = self.exemplars[0].picture(self.name)
        assert plane is not None  # `plane` refuses others
        return plane

    @property
    def dtype(self) -> np.dtype[Any]:
        """The dtype of the pixels, that of the exemplar."""
        return self.like.pixels.dtype

    @property
    def channels(self) -> int:
        """The number of channels, opacity included."""
        return self.like.channels

    @property
    def scale(self) -> Pair:
        """By which whole factor the plane is larger than the map, and by which it is smaller; one of them is 1."""
        own, base = self.like.height, self.exemplars[0].height
        return max(own // base, 1), max(base // own, 1)

    def shape_of(self, height: int, width: int) -> tuple[int, ...]:
        """Return the shape of the array of a window."""
        return (height, width) if self.like.pixels.ndim == 2 else (height, width, self.channels)

    def draw(self, box: Box) -> Array:
        """Return the pixels (h, w[, C]) of a box; at most 2048 x 2048 px of the map are in memory at a time."""
        step = max(2 * SIDE // self.scale[1], 1)
        if max(box.shape) <= step:
            return self._drawn(box)
        return self._filled(box, step, self._drawn, map)

    def _filled(self, box: Box, side: int, draw: Callable[[Box], Array], each: Callable[..., Iterable[Any]]) -> Array:
        """Render a box in cells of `side` px by `each`, a parallel map.

        The first cell is rendered alone, as it fills the caches that the others share.
        """
        out = np.empty(self.shape_of(*box.shape), self.dtype)

        def fill(cell: Cell) -> None:
            at = cell.box
            out[at.y0 : at.y1, at.x0 : at.x1] = draw(at.moved(box.y0, box.x0))

        cells = iter(Grid(*box.shape, side, side))
        fill(next(cells))
        for _ in each(fill, cells):
            pass
        return out

    def _drawn(self, box: Box) -> Array:
        """Render a box at once: its map with the margin that feather and finish need, then the rendering."""
        inner, (grow, shrink) = self.map_box(box), self.scale
        outer = self._around(inner)
        reach = inner.y0 - outer.y0
        part = Box(reach, reach, reach + inner.height, reach + inner.width)
        pixels = render(self.exemplars, self.map(outer), self.name, self.blend, part, Run(1)).pixels
        dy, dx = box.y0 - inner.y0 * grow // shrink, box.x0 - inner.x0 * grow // shrink
        return pixels[dy : dy + box.height, dx : dx + box.width]

    def _around(self, inner: Box) -> Box:
        """Return a box of the map enlarged by the margin that feather and finish need."""
        reach = (self.blend.feather + 1) // 2 + sum(f.radius for f in self.blend.finish)
        reach = -(-reach // self.scale[1]) * self.scale[1]
        return Box(inner.y0 - reach, inner.x0 - reach, inner.y1 + reach, inner.x1 + reach)

    def map(self, box: Box) -> SourceMap:
        """Return the source map of a box, in px of the map."""
        return self.method.window(self.exemplars, box, self.seed, Run(1))

    def map_box(self, box: Box) -> Box:
        """Return the box of the map that covers a box of the plane; ParameterError if it is too far from the origin."""
        grow, shrink = self.scale
        found = Box(
            box.y0 // grow * shrink, box.x0 // grow * shrink, -(-box.y1 // grow) * shrink, -(-box.x1 // grow) * shrink
        )
        if min(found.y0, found.x0) < -FARTHEST or max(found.y1, found.x1) > FARTHEST:
            where = f"rows {found.y0}..{found.y1}, columns {found.x0}..{found.x1} px"
            raise ParameterError(f"{where} lie too far away; stay within 2**40 px.")
        return found

    @property
    def recipe(self) -> Record:
        """Everything that a pixel depends on besides its coordinates; functions among the parameters by name only."""
        return {
            "intarsia": VERSION,
            "method": self.method.slug,
            "parameters": recipe_settings(self.method),
            "seed": self.seed,
            "blend": self.blend.as_recipe,
            "exemplars": recipe_exemplars(self.exemplars),
            "plane": self.name,
        }

    def recipe_over(self, box: Box) -> Record:
        """Return everything that the pixels of a box depend on: functions with a hash of their values in it.

        They are evaluated over the whole box, in parts, which takes little time compared to rendering.
        """
        around = self._around(self.map_box(box))
        return self.recipe | {"parameters": recipe_settings(self.method, self.exemplars, around)}


Packer = Callable[[Array, Cell], list[bytes]]
"""Encodes the pixels of a cell as the bytes of a store; sent to the workers."""

Cut = tuple[Grid, Packer]
"""The cells of a picture, and the function that encodes them."""

Results = Generator[tuple[Cell, list[bytes]], None, None]
"""Cells with their encoded pieces, in order."""


@dataclass
class Store(ABC):
    """A picture on disk that is rendered cell by cell: its settings, and the interface of all stores.

    ``origin`` (y, x): the pixel of the endless plane that comes first; ``force``: whether an existing file is
    replaced.
    """

    path: Path
    texture: EndlessPlane
    origin: Pair  # the first pixel, in the endless plane
    grid: Grid
    recipe: Record
    force: bool
    packer: Packer

    resumes: ClassVar[bool] = False
    """Whether an interrupted store is resumed."""

    side: ClassVar[int] = 512
    """Default side of its chunks or tiles in px; 0: it has none."""

    @classmethod
    def of(
        cls, texture: EndlessPlane, path: PathLike, shape: Any, origin: Any, side: int | None, force: bool = False
    ) -> Self:
        """Return the store of a picture with chunks or tiles of `side` px; checks its arguments, writes nothing."""
        expect_path(path)
        sides = sides_of(shape)
        first = checked(texture, sides, origin)
        side = cls.side if side is None else side
        grid, packer = cls.cut(texture, path, sides, side)  # raises before functions are evaluated over all of it
        recipe = texture.recipe_over(Box(*first, first[0] + sides[0], first[1] + sides[1]))
        recipe |= {"size": [sides[1], sides[0]], "origin": [first[1], first[0]]}
        return cls(Path(path), texture, first, grid, recipe, force, packer)

    @classmethod
    @abstractmethod
    def cut(
        cls, texture: EndlessPlane, path: PathLike, sides: Pair, side: int
    ) -> Cut:
        """Return the cells and their packer; ParameterError for pixels or sizes that the store does not support."""

    @property
    def text(self) -> str:
        """The recipe as JSON."""
        return json.dumps(self.recipe, sort_keys=True)

    @property
    def held(self) -> int:
        """Bytes of memory besides the cells in progress; 0 if every piece is written to disk."""
        return 0

    def look(self) -> None:
        """Raise, before any work, if the store cannot be made at its path; writes nothing."""
        check_writable(self.path, self.force)

    def open(self) -> Iterable[int]:
        """Start or resume; return the numbers of the missing or damaged cells, ascending."""
        self.look()
        return range(len(self.grid))

    @abstractmethod
    def fill(self, results: Results, run: Run) -> None:
        """Write the missing cells as they arrive, in order, and everything derived from them."""

    def finish(self) -> None:  # noqa: B027
        """Move the complete store to its path."""

    def close(self) -> None:  # noqa: B027
        """Close all files and remove temporary ones."""


def checked(texture: EndlessPlane, sides: Pair, origin: Any) -> Pair:
    """Return the first pixel of a picture; ParameterError if the picture is too far from the origin."""
    try:
        y, x = pair(origin if hasattr(origin, "__len__") else None)
    except ValueError:
        raise ParameterError(f"origin={called(origin)} is no pixel; give (y, x).") from None
    height, width = sides
    texture.map_box(Box(y, x, y + height, x + width))
    return y, x


def check_side(name: str, side: Any, most: int, multiple: int = 1) -> int:
    """Return the side of chunks or tiles; ParameterError if it is out of range or no multiple of `multiple`."""
    step = "" if multiple == 1 else f", a multiple of {multiple}"
    number = whole_within(name, side, LEAST, most, f"px{step}")
    if number % multiple:
        raise ParameterError(f"{name}={number} is not allowed; give {LEAST} to {most} px{step}.")
    return number


def extra(module: str) -> Any:
    """Import a module of the extra ``giant``; MissingExtraError says how to install it."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as e:
        name = (e.name or module).partition(".")[0]
        raise MissingExtraError(f"{name} is not installed; run: pip install 'intarsia[giant]'") from None
