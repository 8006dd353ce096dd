"""Stores that are written atomically: a tiled BigTIFF, a folder of DeepZoom tiles, a picture of another format.

Each is written in a hidden folder next to its place, and moved there at the end. An interrupted run leaves nothing, and
the next one renders all cells; only zarr arrays are resumed.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import time
import zlib
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import islice, product
from pathlib import Path

import numpy as np

from ..disk import atomic
from ..disk.atomic import PathLike, check_writable
from ..files.decode import decode
from ..files.formats import format_of, open_picture
from ..files.write import MARK, check_depth, encode, holds_recipe, recipe_path, write
from ..foundation import InputError, ParameterError, ResourceError, printable
from ..foundation.arrays import Array, Pair
from ..foundation.run import Run
from ..model.image import Kind, Plane
from ..rendering.blending import averaged
from .picture import SIDE, Cell, Cut, EndlessPlane, Grid, Results, Store, check_side, extra

_N = "(0|[1-9][0-9]*)"  # a whole number, for the two patterns of names of files and folders that stores consist of
FILES = re.compile(rf"zarr\.json|c/{_N}/{_N}(/0)?|image\.dzi(\.recipe\.json)?|image_files/{_N}/{_N}_{_N}\.png")
FOLDERS = re.compile(rf"c(/{_N}){{0,2}}|image_files(/{_N})?")


def check_place(path: Path, woven: bool = False) -> None:
    """Raise if a path cannot be written, or holds anything but a folder that is empty or has only temporary files.

    `woven`: the path holds a store that is to be replaced; the folder must hold nothing but the store.
    """
    try:
        folder = Path(os.path.realpath(path)).parent
        if len(os.fsencode(path.name)) > 240:
            raise InputError(f"{path} is too long a name; give at most 240 bytes.")
        if not folder.is_dir():
            raise InputError(f"the folder of {path} does not exist; make it first, or name another.")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise ResourceError(f"the folder of {path} cannot be written; name another one.")
    except ValueError:  # a zero byte in the name
        raise InputError(f"{str(path)!r} is no name of a file; choose another.") from None
    if woven:
        _check_woven(path)
    elif os.path.lexists(path) and not (path.is_dir() and all(atomic.is_temporary(e.name) for e in path.iterdir())):
        raise ParameterError(f"{path} exists, and is no texture that was woven; name another place.")


def _check_woven(path: Path) -> None:
    """Raise ParameterError if a folder holds anything that is not part of a store."""
    for at, below, here in os.walk(path):
        for entry in sorted(below + here):
            full = Path(at, entry)
            place, names = full.relative_to(path), FOLDERS if entry in below else FILES
            plain = (full.is_dir() or full.is_file()) and not full.is_symlink()
            if not ((plain and names.fullmatch(place.as_posix())) or atomic.is_left_over(full)):
                raise ParameterError(
                    f"{path} holds {printable(place)}, which was not woven; move it elsewhere, or name another place."
                )


AREA = 1 << 20  # px of a TIFF that are rendered together as one cell, about; a row of tiles
LONGEST = (1 << 32) - 1  # px: longest side of a TIFF, whose header stores it in 32 bits
LEVEL = 6  # compression level of zlib, its default

COPIES = {"png": 3, "exr": 3, "hdr": 3, "webp": 12}
"""Peak memory of encoding, in multiples of the bytes of all pixels, by format.

Measured on noise, which cannot be compressed: png 3.0 (16 bit 3.7), exr 3.0, hdr 2.3, webp 16 (of one colour 5.6).
"""

OTHERWISE = 4
"""The same for all other formats, which are encoded in memory before they are written: measured 4.0 to 4.3."""


@dataclass
class Export(Store):
    """A store that is written in a hidden folder and moved to its place when it is complete."""

    _draft: str = field(default="", init=False)  # the hidden folder

    def look(self) -> None:
        """Raise, before any work, if no file can be written at the path, or one exists; writes nothing."""
        self._check_new(os.path.isfile(self.path))
        check_writable(self.path, self.force)

    def open(self) -> Iterable[int]:
        """Return all cells as missing."""
        self.look()
        return range(len(self.grid))

    def finish(self) -> None:
        """Move the complete file to its place."""
        self.look()
        beside, target = recipe_path(self._staged), recipe_path(self._target)
        with suppress(OSError):
            shutil.copymode(self._target, self._staged)
        os.replace(self._staged, self._target)
        if beside.exists():
            os.replace(beside, target)
        elif self.force:  # the recipe of the file that is replaced
            target.unlink(missing_ok=True)
        atomic.sync_folder(target.parent)

    def close(self) -> None:
        """Remove the hidden folder."""
        if self._draft:
            atomic.forget_name(self._staged)
            atomic.remove_temporary(self._draft)

    def _stage(self) -> Path:
        """Make the hidden folder; return the path in it with the name of the store."""
        atomic.sweep(self._target.parent)
        self._draft = atomic.temporary_name(self._target.parent)
        os.mkdir(self._draft, 0o700)
        atomic.displayed_name(self._staged, self.path)
        return self._staged

    def _check_new(self, exists: bool) -> None:
        if exists and not self.force:
            raise ParameterError(
                f"{self.path} exists, and nothing but a .zarr is gone on with; name another file, or replace it "
                "with --force (force=True)."
            )

    @property
    def _target(self) -> Path:
        return Path(os.path.realpath(self.path))

    @property
    def _staged(self) -> Path:
        return Path(self._draft, self._target.name)


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
class TiffStore(Export):
    """One tiled BigTIFF, compressed with zlib; tiles are stored row by row, whatever the size of cells."""

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
        staged, texts = self._stage(), json.dumps(self.recipe, sort_keys=True, separators=(",", ":"))
        with extra("tifffile").TiffWriter(staged, bigtiff=True, byteorder="<") as file:
            file.write(
                (piece for _, pieces in results for piece in pieces),
                shape=(*self.grid.shape, count) if count > 1 else self.grid.shape,
                dtype=np.uint8 if self.texture.dtype == bool else self.texture.dtype,
                photometric="rgb" if colours == 3 else "minisblack", planarconfig="contig" if count > 1 else None,
                extrasamples=[2 if like.alpha else 0] * (count - colours), tile=(tile, tile), compression="zlib",
                predictor=2 if self.texture.dtype.kind in "bu" else None, iccprofile=like.meta.get("icc"),
                description=MARK + texts, metadata=None, software=False,
            )  # fmt: skip
        next(results, None)  # so that the last cell is counted
        with atomic.open_regular(staged) as written:
            atomic.sync_file(written)


@dataclass(frozen=True)
class TilePacker:
    """Encodes a cell as its tiles, row by row."""

    tile: int
    like: Plane

    def __call__(self, pixels: Array, cell: Cell) -> list[bytes]:
        corners = product(*(range(0, side, self.tile) for side in pixels.shape[:2]))
        return [self.one(pixels[y : y + self.tile, x : x + self.tile]) for y, x in corners]

    def one(self, pixels: Array) -> bytes:
        """Return a tile (h, w, C) as PNG."""
        return encode(self.like.like(pixels), "png", run=Run(1))


@dataclass
class TileStore(Export):
    """A folder of DeepZoom tiles: ``image.dzi``, the recipe next to it, and ``image_files/LEVEL/COLUMN_ROW.png``.

    The last level is the texture; each other one is averaged from the next finer one.
    """

    packer: TilePacker

    @classmethod
    def cut(
        cls, texture: EndlessPlane, path: PathLike, sides: Pair, side: int
    ) -> tuple[Grid, TilePacker]:
        """Cut into squares of tiles; ParameterError for pixels that PNG does not support."""
        tile, like = check_side("tile", side, 4096), texture.like
        if texture.dtype.name not in ("bool", "uint8", "uint16") or texture.channels > 4:
            raise ParameterError(
                f"tiles are PNG of 1 to 4 channels, 8 or 16 bit, not {texture.channels} of {texture.dtype.name}; write "
                "a zarr array or a TIFF."
            )
        together = tile * max(SIDE // tile, 1)
        small = Plane(like.pixels[:1, :1], like.kind, like.transfer, like.meta)
        return Grid(*sides, together, together), TilePacker(tile, small)

    @property
    def levels(self) -> int:
        """The number of levels; the first is a single pixel."""
        return (max(self.grid.shape) - 1).bit_length() + 1

    def tiles(self, level: int) -> Grid:
        """Return the tiles of a level."""
        times = 1 << (self.levels - 1 - level)
        return Grid(-(-self.grid.height // times), -(-self.grid.width // times), self.packer.tile, self.packer.tile)

    def look(self) -> None:
        """Raise, before any work, if anything but, with force, other tiles is at the path; writes nothing."""
        woven = recipe_path(self.path / "image.dzi").is_file()
        self._check_new(woven)
        check_place(self.path, woven)

    def fill(self, results: Results, run: Run) -> None:
        """Write the tiles as they arrive, then the smaller levels, each from the next finer one, and ``image.dzi``."""
        staged, tile = self._stage(), self.packer.tile
        for level in range(self.levels):
            (staged / "image_files" / str(level)).mkdir(parents=True)
        for cell, pieces in results:
            box, data = cell.box, iter(pieces)
            for row in range(box.y0 // tile, -(-box.y1 // tile)):
                for column in range(box.x0 // tile, -(-box.x1 // tile)):
                    atomic.write_new(self._tile(self.levels - 1, row, column), next(data), durable=False)
        with run.pool() as each:
            for level in range(self.levels - 2, -1, -1):
                tiles = iter(self.tiles(level))
                while some := list(islice(tiles, 8 * run.workers)):
                    each(partial(self._reduce, level), some)
                    run.check()
        text = (
            '<?xml version="1.0" encoding="UTF-8"?>\n<Image xmlns="http://schemas.microsoft.com/deepzoom/2008" '
            f'Format="png" Overlap="0" TileSize="{tile}">'
            f'<Size Width="{self.grid.width}" Height="{self.grid.height}"/></Image>\n'
        )
        atomic.write_new(staged / "image.dzi", text.encode())
        atomic.write_new(recipe_path(staged / "image.dzi"), self.text.encode())
        getattr(os, "sync", lambda: None)()  # for many small files quicker than syncing each

    def finish(self) -> None:
        """Move the folder to its place; the one it replaces is removed with the hidden folder."""
        self.look()
        if self._target.exists():
            os.replace(self._target, f"{self._staged}.old")
        os.replace(self._staged, self._target)
        atomic.sync_folder(self._target.parent)

    def _reduce(self, level: int, cell: Cell) -> None:
        """Make a tile of a level from the four of the next finer one."""
        below = self.tiles(level + 1)
        rows = range(2 * cell.row, min(2 * cell.row + 2, below.down))
        columns = range(2 * cell.column, min(2 * cell.column + 2, below.across))
        parts = [
            [decode(open_picture(self._tile(level + 1, row, column))).pixels for column in columns] for row in rows
        ]
        pixels = np.atleast_3d(np.concatenate([np.concatenate(p, axis=1) for p in parts]))
        height, width = pixels.shape[:2]
        even = np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        even = even > 0 if self.texture.dtype == bool else even
        smaller = self.packer.one(averaged(self.packer.like.like(even), 2))
        atomic.write_new(self._tile(level, cell.row, cell.column), smaller, durable=False)

    def _tile(self, level: int, row: int, column: int) -> Path:
        """Return the path of a tile."""
        return self._staged / "image_files" / str(level) / f"{column}_{row}.png"


def as_they_are(pixels: Array, cell: Cell) -> list[bytes]:
    """Return the raw bytes of a cell."""
    return [pixels.tobytes()]


@dataclass
class BufferedStore(Export):
    """A picture of any format that `write` supports, with the recipe; held in memory until it is complete."""

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
        pixels = self.grid.height * self.grid.width * self.texture.channels * self.texture.dtype.itemsize
        return pixels * COPIES.get(self._format, OTHERWISE)

    def look(self) -> None:
        """Raise, before any work, if no file can be written at the path, or one exists; writes nothing."""
        super().look()
        if not holds_recipe(format_of(self.path), self.text):
            check_writable(recipe_path(self.path), self.force)

    def packing(self, cell: Cell, pieces: list[bytes]) -> float:
        """Return the seconds that it takes to encode a cell as a file of its own, which is discarded."""
        began = time.perf_counter()
        encode(self.texture.like.like(self._part(cell, pieces)), self._format)
        return time.perf_counter() - began

    def fill(self, results: Results, run: Run) -> None:
        """Collect the pixels as they arrive, then write them."""
        pixels = np.empty((*self.grid.shape, self.texture.channels), self.texture.dtype)
        for cell, pieces in results:
            pixels[cell.box.y0 : cell.box.y1, cell.box.x0 : cell.box.x1] = self._part(cell, pieces)
        write(self._stage(), self.texture.like.like(pixels), recipe=self.text, run=run)

    def _part(self, cell: Cell, pieces: list[bytes]) -> Array:
        return np.frombuffer(pieces[0], self.texture.dtype).reshape(*cell.box.shape, -1)

    @property
    def _format(self) -> str:
        return format_of(self.path).name
