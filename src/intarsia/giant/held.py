"""A texture as one picture of a format that is written at once: held in memory until all of it is drawn."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import expect_path
from ..disk.writing import check_writable
from ..errors import ParameterError
from ..files.encode import encode, holds_recipe
from ..files.formats import format_of
from ..files.recipe import recipe_path
from ..files.write import check_depth, write
from ..image import Array
from ..run import Run
from .cells import SIDE, Cell, Grid
from .picture import Kept, Picture, checked, header_of

COPIES = {"png": 3, "exr": 3, "hdr": 3, "webp": 12}
"""How often the bytes of all pixels are held while they are packed: by us, by who packs them, and packed.

Measured of noise, which nothing makes smaller: png 3.0 (16 bit 3.7), exr 3.0, hdr 2.3, webp 16 (of one colour 5.6).
"""

OTHERWISE = 4
"""The same for formats that are packed in memory and not in a file: 4.0 to 4.3."""


@dataclass(frozen=True)
class HeldPacker:
    """Sends the pixels of a cell as they are."""

    def __call__(self, pixels: Array, cell: Cell) -> list[bytes]:
        return [pixels.tobytes()]


@dataclass
class HeldStore(Kept):
    """A picture of any format that `write` knows, with the recipe; nothing lies on the disk before it is whole.

    So a run that was stopped has made nothing, and the next one draws all cells. `place` tells under which name the
    file is written first: a caller that writes several at once moves them to their places itself.
    """

    packer: HeldPacker
    place: Callable[[str], str] = str
    pixels: Array | None = field(default=None, init=False)

    @classmethod
    def of(
        cls, texture: Picture, path: str | os.PathLike[str], sides: tuple[int, int], origin: Any, side: int, force: bool
    ) -> HeldStore:
        """Plan a picture; ParameterError for pixels and sizes that its format does not hold, and for chunks."""
        expect_path(path)
        if side:
            raise ParameterError(f"{path}: a picture in one piece has no chunks; drop --chunk, or name a .zarr.")
        origin = checked(texture, sides, origin)
        try:
            check_depth(path, texture.like, size=(sides[1], sides[0]))
        except ParameterError as e:
            raise ParameterError(f"{path}: {str(e).partition('; ')[0]}; name a .zarr or a .tif.") from None
        grid = Grid(*sides, SIDE, SIDE)
        header = header_of(texture, sides, origin, {"format": format_of(path).name})
        return cls(Path(path), str(path), texture, origin, grid, header, force, HeldPacker())

    @property
    def recipe(self) -> str:
        """The recipe as it is embedded, or lies beside."""
        return json.dumps(self.header["recipe"], sort_keys=True)

    @property
    def held(self) -> int:
        """Bytes of memory that the pixels of the picture take until it is written."""
        whole = self.grid.height * self.grid.width * self.texture.channels * self.texture.dtype.itemsize
        return whole * COPIES.get(self.header["format"], OTHERWISE)

    def look(self) -> None:
        """Refuse, before any work, a place where no file can be written, or one lies; writes nothing."""
        check_writable(self.path, self.force)
        if not holds_recipe(format_of(self.path), self.recipe):
            check_writable(recipe_path(self.path), self.force)

    def open(self) -> Iterable[int]:
        """Begin; all cells are missing."""
        self.look()
        self.pixels = np.empty((self.grid.height, self.grid.width, self.texture.channels), self.texture.dtype)
        return range(len(self.grid))

    def packing(self, cell: Cell, pieces: list[bytes]) -> float:
        """Say how many seconds it took to pack a cell alone as a file is packed; nothing is kept."""
        began = time.perf_counter()
        encode(self.texture.like.like(self._part(cell, pieces)), self.header["format"])
        return time.perf_counter() - began

    def put(self, cell: Cell, pieces: list[bytes]) -> None:
        """Keep the pixels of a cell."""
        assert self.pixels is not None
        self.pixels[cell.box.y0 : cell.box.y1, cell.box.x0 : cell.box.x1] = self._part(cell, pieces)

    def _part(self, cell: Cell, pieces: list[bytes]) -> Array:
        return np.frombuffer(pieces[0], self.texture.dtype).reshape(cell.box.height, cell.box.width, -1)

    def finish(self, run: Run) -> None:
        """Write the file, whole or not at all."""
        assert self.pixels is not None
        plane = self.texture.like.like(self.pixels)
        write(self.place(str(self.path)), plane, recipe=self.recipe, force=self.force)

    def close(self) -> None:
        """Let go of the pixels."""
        super().close()
        self.pixels = None
