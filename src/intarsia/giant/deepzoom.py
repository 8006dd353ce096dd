"""A texture as DeepZoom tiles: PNG, and a pyramid of ever smaller pictures of it for viewers."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import expect_path
from ..errors import ParameterError
from ..files.png import decode_png, encode_png
from ..image import Array, Plane
from ..rendering.mixers import averaged
from ..run import Run
from .cells import SIDE, Cell, Grid
from .folder import HEADER, FolderStore
from .ledger import as_line
from .picture import Picture, check_side, checked, header_of


@dataclass(frozen=True)
class TilePacker:
    """Packs a cell as its tiles, row by row."""

    tile: int
    like: Plane

    def __call__(self, pixels: Array, cell: Cell) -> list[bytes]:
        tile, (height, width) = self.tile, pixels.shape[:2]
        return [
            self.one(pixels[y : y + tile, x : x + tile]) for y in range(0, height, tile) for x in range(0, width, tile)
        ]

    def one(self, pixels: Array) -> bytes:
        """A tile (h, w, C) as PNG."""
        return encode_png(pixels, self.like.meta.get("icc"))


@dataclass
class TileStore(FolderStore):
    """A folder of tiles: ``image.dzi``, and ``image_files/LEVEL/COLUMN_ROW.png``; the last level is the texture."""

    packer: TilePacker

    @classmethod
    def of(
        cls, texture: Picture, path: str | os.PathLike[str], sides: tuple[int, int], origin: Any, tile: int, force: bool
    ) -> TileStore:
        """Plan a pyramid; ParameterError for pixels that PNG does not hold."""
        expect_path(path)
        origin, tile = checked(texture, sides, origin), check_side("tile", tile, 4096)
        if texture.dtype.name not in ("bool", "uint8", "uint16") or texture.channels > 4:
            raise ParameterError(
                f"tiles are PNG of 1 to 4 channels, 8 or 16 bit, not {texture.channels} of {texture.dtype.name}; write "
                "a zarr array or a TIFF."
            )
        side = tile * max(SIDE // tile, 1)
        grid = Grid(*sides, side, side)
        header = header_of(texture, sides, origin, {"format": "tiles", "tile": tile})
        like = texture.like
        small = Plane(like.pixels[:1, :1], like.kind, like.transfer, like.meta)
        packer = TilePacker(tile, small)
        return cls(Path(path), str(path), texture, origin, grid, header, force, packer)

    @property
    def levels(self) -> int:
        """How many levels there are; the first is a single pixel."""
        return (max(self.grid.height, self.grid.width) - 1).bit_length() + 1

    def tiles(self, level: int) -> Grid:
        """The tiles of a level."""
        times = 1 << (self.levels - 1 - level)
        return Grid(-(-self.grid.height // times), -(-self.grid.width // times), self.packer.tile, self.packer.tile)

    def files_of(self, cell: Cell) -> list[str]:
        """The tiles of a cell, of the last level."""
        tile, level, box = self.packer.tile, self.levels - 1, cell.box
        rows, columns = range(box.y0 // tile, -(-box.y1 // tile)), range(box.x0 // tile, -(-box.x1 // tile))
        return [name_of_tile(level, row, column) for row in rows for column in columns]

    def all_files(self) -> Iterator[str]:
        """The tiles of all levels, the largest first."""
        yield from super().all_files()
        for level in range(self.levels - 2, -1, -1):
            yield from (name_of_tile(level, cell.row, cell.column) for cell in self.tiles(level))

    def signs(self) -> dict[str, bytes]:
        """What a viewer reads first; and the header once more, as tiles hold no recipe."""
        text = (
            '<?xml version="1.0" encoding="UTF-8"?>\n<Image xmlns="http://schemas.microsoft.com/deepzoom/2008" '
            f'Format="png" Overlap="0" TileSize="{self.packer.tile}">'
            f'<Size Width="{self.grid.width}" Height="{self.grid.height}"/></Image>\n'
        )
        return {HEADER: (as_line(self.header) + "\n").encode(), "image.dzi": text.encode()}

    def finish(self, run: Run) -> None:
        """Make the smaller levels, each of the one below it."""
        with run.pool() as each:
            for level in range(self.levels - 2, -1, -1):
                todo = [c for c in self.tiles(level) if not self.sound(name_of_tile(level, c.row, c.column))]
                for begin in range(0, len(todo), 8 * run.workers):
                    some = todo[begin : begin + 8 * run.workers]
                    for cell, data in zip(some, each(partial(self._smaller, level), some), strict=True):
                        self.keep(name_of_tile(level, cell.row, cell.column), data)
                    run.tick(len(self.grid), len(self.grid))
        super().finish(run)

    def _smaller(self, level: int, cell: Cell) -> bytes:
        """A tile of a level, from the four of the next."""
        below = self.tiles(level + 1)
        rows = range(2 * cell.row, min(2 * cell.row + 2, below.down))
        columns = range(2 * cell.column, min(2 * cell.column + 2, below.across))
        parts = [[self._read(level + 1, row, column) for column in columns] for row in rows]
        pixels = np.concatenate([np.concatenate(p, axis=1) for p in parts])
        height, width = pixels.shape[:2]
        even = np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        return self.packer.one(averaged(self.packer.like.like(even), 2))

    def _read(self, level: int, row: int, column: int) -> Array:
        pixels = decode_png((self.path / name_of_tile(level, row, column)).read_bytes())
        return pixels > 0 if self.texture.dtype == bool else pixels


def name_of_tile(level: int, row: int, column: int) -> str:
    """The file of a tile."""
    return f"image_files/{level}/{column}_{row}.png"
