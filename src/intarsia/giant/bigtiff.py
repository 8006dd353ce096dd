"""A texture as one tiled BigTIFF, compressed with zlib; every tile is appended, and the directory comes last.

TIFF 6.0 (Adobe 1992) and the BigTIFF extension: 64-bit offsets. Tiles lie in the file row by row, so that its bytes do
not depend on how many of them were drawn together.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ..errors import IntarsiaError, ParameterError, ResourceError
from ..files.encode import MARK
from ..image import Array, Kind
from ..run import Run
from .cells import Cell, Grid
from .folder import check_folder
from .ledger import Ledger, checksum
from .stream import check_side, checked, header_of
from .texture import Weave

START = 16  # bytes before the first tile
AREA = 1 << 20  # px drawn together, about
LONGEST = (1 << 32) - 1
LEVEL = 6  # of zlib


@dataclass(frozen=True)
class TiffPacker:
    """Packs a row of tiles: differences along rows for whole numbers, then zlib."""

    tile: int

    def __call__(self, pixels: Array, cell: Cell) -> list[bytes]:
        pixels = pixels.astype(np.uint8) * np.uint8(255) if pixels.dtype == bool else pixels
        return [self._tile(pixels[:, x : x + self.tile]) for x in range(0, pixels.shape[1], self.tile)]

    def _tile(self, pixels: Array) -> bytes:
        height, width = pixels.shape[:2]
        if (height, width) != (self.tile, self.tile):  # tiles at the border are whole, too
            pixels = np.pad(pixels, ((0, self.tile - height), (0, self.tile - width), (0, 0)), mode="edge")
        if pixels.dtype.kind == "u":
            steps = pixels.copy()
            steps[:, 1:] -= pixels[:, :-1]
            pixels = steps
        little = np.ascontiguousarray(pixels.astype(pixels.dtype.newbyteorder("<"), copy=False))
        return zlib.compress(little.tobytes(), LEVEL)


@dataclass
class TiffStore:
    """A BigTIFF of a texture: ``PATH.part`` until it is whole, and ``PATH.ledger`` beside it."""

    path: Path
    shown: str
    texture: Weave
    origin: tuple[int, int]
    grid: Grid
    header: dict[str, Any]
    force: bool
    packer: TiffPacker
    ledger: Ledger | None = field(default=None, init=False)
    file: BinaryIO | None = field(default=None, init=False)
    ends: list[int] = field(default_factory=lambda: [START], init=False)  # where each tile ends, and the next begins

    @classmethod
    def of(
        cls, texture: Weave, path: str | os.PathLike[str], sides: tuple[int, int], origin: Any, tile: int, force: bool
    ) -> TiffStore:
        """Plan a file; ParameterError for sides that TIFF does not hold."""
        origin, tile = checked(texture, sides, origin), check_side("tile", tile, 4096, 16)
        if max(sides) > LONGEST:
            raise ParameterError(f"a TIFF holds at most {LONGEST} px a side; write a zarr array.")
        header = header_of(texture, sides, origin, {"format": "tiff", "tile": tile, "zlib": zlib.ZLIB_RUNTIME_VERSION})
        grid = Grid(*sides, tile, tile * max(AREA // tile**2, 1))
        return cls(Path(path), str(path), texture, origin, grid, header, force, TiffPacker(tile))

    @property
    def tiles(self) -> Grid:
        """The tiles, row by row, as they lie in the file."""
        return Grid(self.grid.height, self.grid.width, self.packer.tile, self.packer.tile)

    @property
    def part(self) -> Path:
        """Where the file grows."""
        return self.path.with_name(self.path.name + ".part")

    def look(self) -> None:
        """Refuse, before any work, a place where this store cannot be; writes nothing."""
        check_folder(self.path, self.shown)
        self._found()

    def open(self) -> Iterable[int]:
        """Begin or go on; the tiles that are there are checked, and what follows the last whole one is cut off."""
        check_folder(self.path, self.shown)
        self.ledger = self._begun()
        place = self.path if self.path.exists() else self.part
        self.file = place.open("r+b" if place.exists() else "w+b")
        bad, count = set[int](), len(self.tiles)
        length = self.file.seek(0, os.SEEK_END)
        self.file.seek(START)
        kept = 0
        for number in range(count):
            entry = self.ledger.entries.get(str(number))
            if entry is None or self.ends[-1] + entry.size > length:
                break
            if checksum(self.file.read(entry.size)) != entry.digest:
                bad.add(number)
            self.ends.append(self.ends[-1] + entry.size)
            kept += 1
        across, together = self.tiles.across, self.grid.columns // self.packer.tile
        while kept and self._cell_of(kept, across, together) == self._cell_of(kept - 1, across, together):
            kept -= 1  # a cell is written anew as a whole
        if kept < count:
            del self.ends[kept + 1 :]
            self.ledger.settle([str(n) for n in range(kept)])
            self.file.truncate(max(self.ends[-1], START))
        return [
            cell.number
            for cell in self.grid
            if any(n >= kept or n in bad for n in self._numbers(cell))
        ]  # fmt: skip

    def put(self, cell: Cell, pieces: list[bytes]) -> None:
        """Append the tiles of a cell, or write them where they were damaged."""
        assert self.file is not None
        assert self.ledger is not None
        for number, data in zip(self._numbers(cell), pieces, strict=True):
            begin, new = self.ends[number], number + 1 == len(self.ends)
            if not new and self.ends[number + 1] - begin != len(data):
                raise ResourceError(
                    f"{self.shown} is damaged in its ledger, too; begin it anew: remove {self.path.name}.ledger."
                )
            self.file.seek(begin)
            self.file.write(data)
            if new:
                self.ends.append(begin + len(data))
            self.file.flush()
            self.ledger.add(str(number), data)

    def finish(self, run: Run) -> None:
        """Write the head and the directory; then the file takes its name."""
        assert self.file is not None
        assert self.ledger is not None
        where = self.ends[-1] + self.ends[-1] % 2
        tail = b"\0" * (where - self.ends[-1]) + self._directory(where)
        for at, data in ((0, _head(where)), (self.ends[-1], tail)):
            self.file.seek(at)
            if self.file.read(len(data)) != data:
                self.file.seek(at)
                self.file.write(data)
        self.file.truncate(self.ends[-1] + len(tail))
        self.file.flush()
        self.ledger.settle([str(n) for n in range(len(self.tiles))])
        if self.part.exists():
            os.replace(self.part, self.path)

    def close(self) -> None:
        """Let go of the files."""
        for held in (self.file, self.ledger):
            if held is not None:
                held.close()

    def _begun(self) -> Ledger:
        """The ledger that is there, or a new one."""
        found = self._found()
        if found is not None:
            return found
        place = self.path.with_name(self.path.name + ".ledger")
        for old in (place, self.path, self.part):
            with suppress(FileNotFoundError):
                old.unlink()
        return Ledger.begin(place, self.header)

    def _found(self) -> Ledger | None:
        """The ledger of what is there; None where nothing is, or where it may be replaced."""
        try:
            found = Ledger.load(self.path.with_name(self.path.name + ".ledger"), self.header, self.shown)
        except IntarsiaError:
            if not self.force:
                raise
            found = None
        if found is not None and (not self.path.exists() or self._ours(found)):
            return found
        if self.path.is_dir() or (os.path.lexists(self.path) and not self.path.is_file()):
            raise ParameterError(f"{self.shown} is no ordinary file; name another.")
        for old in (self.path, self.part):
            if os.path.lexists(old) and not self.force:
                raise ParameterError(f"{old} exists; name another file, or replace it with --force (force=True).")
        return None

    def _ours(self, ledger: Ledger) -> bool:
        """Say whether a whole file begins as the ledger has it; who put another in its place wants to keep that."""
        known = [ledger.entries[n] for n in map(str, range(len(self.tiles))) if n in ledger.entries]
        end = START + sum(e.size for e in known)
        with self.path.open("rb") as file:
            return len(known) == len(self.tiles) and file.read(START) == _head(end + end % 2)

    def _numbers(self, cell: Cell) -> list[int]:
        """The numbers of the tiles of a cell."""
        first, last = cell.box.x0 // self.packer.tile, -(-cell.box.x1 // self.packer.tile)
        return [cell.row * self.tiles.across + n for n in range(first, last)]

    @staticmethod
    def _cell_of(number: int, across: int, together: int) -> tuple[int, int]:
        return number // across, number % across // together

    def _directory(self, where: int) -> bytes:
        """The image file directory, and what does not fit into it, as it lies at `where`."""
        like, tile = self.texture.like, self.packer.tile
        count, bits = like.channels, 8 if like.pixels.dtype == bool else 8 * like.pixels.dtype.itemsize
        colours = 3 if count >= 3 and like.kind is not Kind.DATA else 1
        whole = like.pixels.dtype.kind in "bu"
        text = (MARK + _json(self.header["recipe"])).encode() + b"\0"
        sizes = np.diff(self.ends)
        fields: list[tuple[int, str, Any]] = [
            (256, "I", [self.grid.width]),
            (257, "I", [self.grid.height]),
            (258, "H", [bits] * count),
            (259, "H", [8]),
            (262, "H", [2 if colours == 3 else 1]),
            (270, "s", text),
            (277, "H", [count]),
            (284, "H", [1]),
            (317, "H", [2 if whole else 1]),
            (322, "I", [tile]),
            (323, "I", [tile]),
            (324, "Q", self.ends[:-1]),
            (325, "Q", sizes.tolist()),
            *([(338, "H", [2 if like.alpha else 0] * (count - colours))] if count > colours else []),
            (339, "H", [1 if whole else 3] * count),
            *([(34675, "B", list(like.meta["icc"]))] if like.meta.get("icc") else []),
        ]
        return _packed(fields, where)


def _head(where: int) -> bytes:
    """The first bytes of a file whose directory lies at `where`."""
    return struct.pack("<2sHHHQ", b"II", 43, 8, 0, where)


def _packed(fields: list[tuple[int, str, Any]], where: int) -> bytes:
    """A directory of tags: entries of 20 bytes, then the values that are longer than 8."""
    types = {"s": 2, "B": 1, "H": 3, "I": 4, "Q": 16}
    entries, more = b"", b""
    after = where + 8 + 20 * len(fields) + 8
    for tag, kind, values in fields:
        data = values if kind == "s" else struct.pack(f"<{len(values)}{kind}", *values)
        if len(data) > 8:
            more += b"\0" * (-len(more) % 8)
            place = struct.pack("<Q", after + len(more))
            more += data
        else:
            place = data.ljust(8, b"\0")
        entries += struct.pack("<HHQ", tag, types[kind], len(values)) + place
    return struct.pack("<Q", len(fields)) + entries + struct.pack("<Q", 0) + more


def _json(recipe: dict[str, Any]) -> str:
    import json

    return json.dumps(recipe, sort_keys=True, separators=(",", ":"))
