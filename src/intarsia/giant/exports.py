"""Stores that appear when they are complete: a tiled BigTIFF, and a picture of another format.

An interrupted run leaves nothing, and the next one renders all cells; only zarr arrays are resumed.
"""

from __future__ import annotations

import json
import os
import shutil
import zlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np

from ..disk import atomic
from ..disk.atomic import PathLike, check_writable
from ..files.formats import format_of
from ..files.write import MARK, check_depth, holds_recipe, recipe_path, write
from ..foundation import ParameterError
from ..foundation.arrays import Array, Pair
from ..foundation.run import Run
from ..model.image import Kind
from .picture import SIDE, Cell, Cut, EndlessPlane, Grid, Results, Store, check_side, extra

AREA = 1 << 20  # px of a TIFF that are rendered together as one cell, about; a row of tiles
LONGEST = (1 << 32) - 1  # px: longest side of a TIFF, whose header stores it in 32 bits
LEVEL = 6  # compression level of zlib, its default

COPIES = 4
"""Peak memory of encoding a picture, in multiples of the bytes of all its pixels: measured 2.3 (hdr) to 4.3 (tga)."""


def tiff_tiles(tile: int, pixels: Array, cell: Cell) -> list[bytes]:
    """Return a row of tiles of `tile` px encoded: horizontal differences for integers (predictor 2), then zlib."""
    pixels = pixels.astype(np.uint8) * np.uint8(255) if pixels.dtype == bool else pixels
    packed = []
    for x in range(0, pixels.shape[1], tile):
        part = pixels[:, x : x + tile]
        part = np.pad(part, ((0, tile - part.shape[0]), (0, tile - part.shape[1]), (0, 0)), mode="edge")
        if part.dtype.kind == "u":
            part[:, 1:] -= part[:, :-1].copy()
        packed.append(zlib.compress(part.astype(part.dtype.newbyteorder("<"), copy=False).tobytes(), LEVEL))
    return packed


@dataclass
class TiffStore(Store):
    """One tiled BigTIFF, compressed with zlib; tiles are stored row by row, whatever the size of cells.

    It is written under a temporary name beside its path.
    """

    _draft: str = field(default="", init=False)

    @classmethod
    def cut(
        cls, texture: EndlessPlane, path: PathLike, sides: Pair, side: int
    ) -> Cut:
        """Cut into rows of tiles; ParameterError for sides that TIFF does not support."""
        extra("tifffile")
        tile = check_side("tile", side, 4096, 16)
        if max(sides) > LONGEST:
            raise ParameterError(f"a TIFF holds at most {LONGEST} px a side; write a zarr array.")
        return Grid(*sides, tile, tile * max(AREA // tile**2, 1)), partial(tiff_tiles, tile)

    def fill(self, results: Results, run: Run) -> None:
        """Write the tiles as they arrive, and the metadata."""
        like, count, tile = self.texture.like, self.texture.channels, self.grid.rows
        colours = 3 if count >= 3 and like.kind is not Kind.DATA else 1
        folder = os.path.dirname(os.path.realpath(self.path))
        atomic.sweep(folder)
        self._draft = atomic.temporary_name(folder)
        with extra("tifffile").TiffWriter(self._draft, bigtiff=True, byteorder="<") as file:
            file.write(
                (piece for _, pieces in results for piece in pieces),
                shape=(*self.grid.shape, count) if count > 1 else self.grid.shape,
                dtype=np.uint8 if self.texture.dtype == bool else self.texture.dtype,
                photometric="rgb" if colours == 3 else "minisblack", planarconfig="contig" if count > 1 else None,
                extrasamples=[2 if like.alpha else 0] * (count - colours), tile=(tile, tile), compression="zlib",
                predictor=2 if self.texture.dtype.kind in "bu" else None, iccprofile=like.meta.get("icc"),
                description=MARK + json.dumps(self.recipe, sort_keys=True, separators=(",", ":")), metadata=None,
                software=False,
            )  # fmt: skip
        next(results, None)  # so that the last cell is counted
        with atomic.open_regular(self._draft) as written:
            atomic.sync_file(written)

    def finish(self) -> None:
        """Move the complete file to its place."""
        self.look()
        target = os.path.realpath(self.path)
        with suppress(OSError):
            shutil.copymode(target, self._draft)
        os.replace(self._draft, target)
        atomic.sync_folder(os.path.dirname(target))

    def close(self) -> None:
        """Remove the temporary file."""
        atomic.remove_temporary(self._draft)


def as_they_are(pixels: Array, cell: Cell) -> list[bytes]:
    """Return the raw bytes of a cell."""
    return [pixels.tobytes()]


@dataclass
class PictureStore(Store):
    """A picture of any format that `write` supports, with the recipe; held in memory until it is complete."""

    side: ClassVar[int] = 0
    _write: Callable[[], None] = field(default=lambda: None, init=False)

    @classmethod
    def cut(
        cls, texture: EndlessPlane, path: PathLike, sides: Pair, side: int
    ) -> Cut:
        """Cut into cells; ParameterError for pixels and sizes that the format does not support, and for chunks."""
        if side:
            raise ParameterError(f"{path}: a picture in one piece has no chunks; drop --chunk, or name a .zarr.")
        try:
            check_depth(path, texture.like, size=(sides[1], sides[0]))
        except ParameterError as e:
            raise ParameterError(f"{path}: {str(e).partition('; ')[0]}; name a .zarr or a .tif.") from None
        return Grid(*sides, SIDE, SIDE), as_they_are

    @property
    def held(self) -> int:
        """Bytes of memory that the pixels take until they are written."""
        return COPIES * self.grid.height * self.grid.width * self.texture.channels * self.texture.dtype.itemsize

    def look(self) -> None:
        """Raise, before any work, if no file can be written at the path, or one exists; writes nothing."""
        super().look()
        if not holds_recipe(format_of(self.path), self.text):
            check_writable(recipe_path(self.path), self.force)

    def fill(self, results: Results, run: Run) -> None:
        """Collect the pixels as they arrive."""
        pixels = np.empty((*self.grid.shape, self.texture.channels), self.texture.dtype)
        for cell, (data,) in results:
            box = cell.box
            pixels[box.y0 : box.y1, box.x0 : box.x1] = np.frombuffer(data, pixels.dtype).reshape(*box.shape, -1)
        like = self.texture.like.like(pixels)
        self._write = partial(write, self.path, like, recipe=self.text, force=self.force, run=run)

    def finish(self) -> None:
        """Write the picture."""
        self._write()
