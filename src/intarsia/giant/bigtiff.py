"""A texture as one tiled BigTIFF, compressed with zlib; every tile is appended, and the directory comes last.

TIFF 6.0 (Adobe 1992) and the BigTIFF extension: 64-bit offsets. Tiles lie in the file row by row, so that its bytes do
not depend on how many of them were drawn together.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ..arguments import expect_path
from ..disk import whole
from ..errors import InputError, IntarsiaError, ParameterError, ResourceError
from ..image import Array
from ..run import Run
from .cells import Cell, Grid
from .folder import check_folder
from .ledger import Ledger, as_line, checksum, read_header
from .picture import Kept, Picture, check_side, checked, header_of
from .tiffhead import START, directory, head, sizes_in

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
class TiffStore(Kept):
    """A BigTIFF of a texture: ``PATH.part`` until it is whole, and ``PATH.ledger`` beside it.

    ``PATH.header`` holds the first line of the ledger once more, until the file is whole and tells its recipe itself.
    """

    packer: TiffPacker
    file: BinaryIO | None = field(default=None, init=False)
    ends: list[int] = field(default_factory=lambda: [START], init=False)  # where each tile ends, and the next begins

    @classmethod
    def of(
        cls, texture: Picture, path: str | os.PathLike[str], sides: tuple[int, int], origin: Any, tile: int, force: bool
    ) -> TiffStore:
        """Plan a file; ParameterError for sides that TIFF does not hold."""
        expect_path(path)
        origin, tile = checked(texture, sides, origin), check_side("tile", tile, 4096, 16)
        if max(sides) > LONGEST:
            raise ParameterError(f"a TIFF holds at most {LONGEST} px a side; write a zarr array.")
        grid = Grid(*sides, tile, tile * max(AREA // tile**2, 1))
        header = header_of(texture, sides, origin, {"format": "tiff", "tile": tile, "zlib": zlib.ZLIB_RUNTIME_VERSION})
        return cls(Path(path), str(path), texture, origin, grid, header, force, TiffPacker(tile))

    @property
    def tiles(self) -> Grid:
        """The tiles, row by row, as they lie in the file."""
        return Grid(self.grid.height, self.grid.width, self.packer.tile, self.packer.tile)

    @property
    def part(self) -> Path:
        """Where the file grows."""
        return self._beside("part")

    def look(self) -> None:
        """Refuse, before any work, a place where this store cannot be; writes nothing."""
        check_folder(self.path, self.printable)
        self._found()

    def open(self) -> Iterable[int]:
        """Begin or go on; the tiles that are there are checked, and what follows the last whole one is cut off."""
        check_folder(self.path, self.printable)
        whole.sweep(os.path.dirname(os.path.abspath(self.path)))
        self._ledger = self._begun()
        done, count = self.path.exists(), len(self.tiles)
        self.file = whole.open_again(self.path if done else self.part, new=not done)
        bad, kept = self._checked(), len(self.ends) - 1
        if done and (kept < count or bad):  # what is not whole does not bear the name
            self._tell_twice()
            os.replace(self.path, self.part)
        if kept < count or self.ledger.damaged:
            self.ledger.settle([str(n) for n in range(kept)])
        if kept < count:
            self.file.truncate(max(self.ends[-1], START))
        return [cell.number for cell in self.grid if any(n >= kept or n in bad for n in self._numbers(cell))]

    def _checked(self) -> set[int]:
        """Find where each tile ends that is there, up to the last good one; return the numbers of damaged ones."""
        assert self.file is not None
        bad, length = set[int](), self.file.seek(0, os.SEEK_END)
        self.file.seek(START)
        for number in range(len(self.tiles)):
            entry = self.ledger.entries.get(str(number))
            if entry is None or self.ends[-1] + entry.size > length:
                break
            if checksum(self.file.read(entry.size)) != entry.digest:
                bad.add(number)
            self.ends.append(self.ends[-1] + entry.size)
        kept, count = len(self.ends) - 1, len(self.tiles)
        while kept and kept - 1 in bad:  # no good one follows that says where they end
            kept -= 1
        across, together = self.tiles.across, self.grid.columns // self.packer.tile
        while 0 < kept < count and self._cell_of(kept, across, together) == self._cell_of(kept - 1, across, together):
            kept -= 1  # a cell is written anew as a whole
        del self.ends[kept + 1 :]
        return {number for number in bad if number < kept}

    def put(self, cell: Cell, pieces: list[bytes]) -> None:
        """Append the tiles of a cell, or write them where they were damaged."""
        assert self.file is not None
        for number, data in zip(self._numbers(cell), pieces, strict=True):
            begin, new = self.ends[number], number + 1 == len(self.ends)
            if not new and self.ends[number + 1] - begin != len(data):
                self.ledger.settle([str(n) for n in range(number)])
                raise ResourceError(f"the ledger of {self.printable} was damaged; the same command goes on from there.")
            self.file.seek(begin)
            self.file.write(data)
            if new:
                self.ends.append(begin + len(data))
            self.file.flush()
            self.ledger.add(str(number), data)

    def finish(self, run: Run) -> None:
        """Write the head and the directory; then the file takes its name."""
        assert self.file is not None
        where = self.ends[-1] + self.ends[-1] % 2
        tail = b"\0" * (where - self.ends[-1]) + self._directory(self.ends, where)
        for at, data in ((0, head(where)), (self.ends[-1], tail)):
            self.file.seek(at)
            if self.file.read(len(data)) != data:
                self.file.seek(at)
                self.file.write(data)
        self.file.truncate(self.ends[-1] + len(tail))
        whole.sync(self.file)
        self.ledger.settle([str(n) for n in range(len(self.tiles))])
        if whole.is_file(self.part):
            os.replace(self.part, self.path)
            whole.settle(self.path.absolute().parent)
        self._beside("header").unlink(missing_ok=True)

    def close(self) -> None:
        """Let go of all files."""
        super().close()
        if self.file is not None:
            self.file.close()

    def _begun(self) -> Ledger:
        """The ledger that is there, or a new one."""
        found = self._found()
        if found is not None:
            return found
        place = self._beside("ledger")
        for old in (place, self.path, self.part):
            old.unlink(missing_ok=True)
        try:
            self._tell_twice()
            return Ledger.begin(place, self.header)
        except BaseException:
            whole.take_away(self._beside("header"))
            raise

    def _tell_twice(self) -> None:
        """Write what the store holds beside the ledger, too, as long as the file does not tell it."""
        whole.put(self._beside("header"), (as_line(self.header) + "\n").encode(), durable=True)

    def _found(self) -> Ledger | None:
        """The ledger of what is there; None where nothing is, or where it may be replaced."""
        ledger, header = self._beside("ledger"), self._beside("header")
        there = {place: whole.is_file(place) for place in (ledger, header, self.path, self.part)}
        known = read_header(header) if there[ledger] or there[self.part] else None
        if there[ledger] and known is None and self._described():
            known = self.header
        try:
            found = Ledger.load(ledger, self.header, self.printable, known)
        except IntarsiaError as e:
            if not self.force and not (there[self.path] and isinstance(e, InputError)):
                raise
            found = None
        alone = not (there[self.path] and there[self.part])
        if found is not None and alone and (not there[self.path] or self._ours(found) or self._described()):
            return found
        for old in (self.path, self.part):
            if there[old] and not self.force:
                raise ParameterError(f"{old} exists; name another file, or replace it with --force (force=True).")
        return None

    def _ours(self, ledger: Ledger) -> bool:
        """Say whether a whole file begins as the ledger has it; who put another in its place wants to keep that."""
        known = [ledger.entries[n] for n in map(str, range(len(self.tiles))) if n in ledger.entries]
        end = START + sum(e.size for e in known)
        with whole.open_again(self.path, "rb") as file:
            return len(known) == len(self.tiles) and file.read(START) == head(end + end % 2)

    def _described(self) -> bool:
        """Say whether a file is whole and describes itself, byte for byte, as this texture."""
        if not whole.is_file(self.path):
            return False
        with whole.open_again(self.path, "rb") as file:
            first, count = file.read(START), len(self.tiles)
            where = struct.unpack("<8xQ", first)[0] if len(first) == START else 0
            if first != head(where) or where >= 1 << 62:
                return False
            length = len(self._directory([0] * (count + 1), where))
            file.seek(where)
            found = file.read(length + 1)
        sizes = sizes_in(found, where, count)
        if sizes is None:
            return False
        return found == self._directory(list(accumulate(sizes, initial=START)), where)

    def _directory(self, ends: list[int], where: int) -> bytes:
        return directory(self.texture.like, self.tiles, self.header["recipe"], ends, where)

    def _beside(self, ending: str) -> Path:
        return self.path.with_name(f"{self.path.name}.{ending}")

    def _numbers(self, cell: Cell) -> list[int]:
        """The numbers of the tiles of a cell."""
        first, last = cell.box.x0 // self.packer.tile, -(-cell.box.x1 // self.packer.tile)
        return [cell.row * self.tiles.across + n for n in range(first, last)]

    @staticmethod
    def _cell_of(number: int, across: int, together: int) -> tuple[int, int]:
        return number // across, number % across // together
