"""A texture as a sharded zarr array (version 3), the one store that is resumed after an interruption.

The files alone hold the progress: each shard holds several chunks with checksums (CRC-32C). A file that is missing,
truncated or damaged is rendered again. The recipe is an attribute of the array, in ``zarr.json``, which is synced to
disk before the first chunk is rendered; nothing else is synced, as a loss of power costs only time.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from ..disk import atomic
from ..disk.atomic import PathLike
from ..foundation import InputError, ParameterError, Record
from ..foundation.arrays import Array, Pair
from ..foundation.run import Run
from .picture import SIDE, Cell, EndlessPlane, Grid, Results, Store, check_side, extra

SIGN = "zarr.json"  # the metadata of a zarr array
LONGEST = 1 << 26  # most bytes of it that are read


@dataclass(frozen=True)
class ZarrPacker:
    """Encodes cells as shards of a zarr array: chunks of `chunk` px a side in files of `side` px a side."""

    chunk: int
    side: int
    tail: tuple[int, ...]  # the channels, if the array has an axis for them
    dtype: str

    def array(self, shape: Pair, attributes: Record, files: Record) -> Any:
        """Return an array whose files are stored in `files`."""
        zarr = extra("zarr")
        names = ("y", "x", "channel")[: 2 + len(self.tail)]
        return zarr.create_array(
            zarr.storage.MemoryStore(store_dict=files), shape=(*shape, *self.tail),
            chunks=(self.chunk, self.chunk, *self.tail),
            shards=None if self.chunk == self.side else (self.side, self.side, *self.tail), dtype=self.dtype,
            compressors=(zarr.codecs.ZstdCodec(level=0), zarr.codecs.Crc32cCodec()),
            fill_value=0, attributes=attributes, dimension_names=names, config={"write_empty_chunks": True},
        )  # fmt: skip

    def name(self, row: int, column: int) -> str:
        """Return the path of a cell's file in the folder of the array."""
        return "/".join(["c", str(row), str(column), *("0" for _ in self.tail)])

    def __call__(self, pixels: Array, cell: Cell) -> list[bytes]:
        files: Record = {}
        alone = self.array((self.side, self.side), {}, files)
        height, width = pixels.shape[:2]
        alone[:height, :width] = pixels.reshape(height, width, *self.tail)
        return [files[self.name(0, 0)].to_bytes()]

    def sound(self, data: bytes) -> bool:
        """Whether a file can be decoded, checksums included."""
        files: Record = {}
        alone = self.array((self.side, self.side), {}, files)
        files[self.name(0, 0)] = type(files[SIGN]).from_bytes(data)
        try:
            alone[:]
        except Exception:  # codecs raise many kinds of errors for damaged bytes
            return False
        return bool(data)  # zarr takes an empty file for one that is missing


@dataclass
class ZarrStore(Store):
    """A zarr array of a texture."""

    packer: ZarrPacker
    resumes: ClassVar[bool] = True

    @classmethod
    def cut(
        cls, texture: EndlessPlane, path: PathLike, sides: Pair, side: int
    ) -> tuple[Grid, ZarrPacker]:
        """Cut into shards of several chunks; MissingExtraError without zarr."""
        extra("zarr")
        chunk = check_side("chunk", side, 8192)
        together = chunk * max(SIDE // chunk, 1)
        tail = () if texture.like.pixels.ndim == 2 else (texture.channels,)
        return Grid(*sides, together, together), ZarrPacker(chunk, together, tail, texture.dtype.name)

    def look(self) -> None:
        """Raise, before any work, if the array cannot be made at its path; writes nothing."""
        self._begun()

    def open(self) -> Iterable[int]:
        """Start or resume; return the numbers of the cells whose files are missing or damaged."""
        if not self._begun():
            self._begin()
        atomic.sweep(self.path)
        return [cell.number for cell in self.grid if not self._sound(cell)]

    def fill(self, results: Results, run: Run) -> None:
        """Write the files of the cells as they arrive."""
        for cell, (data,) in results:
            place = self._place(cell)
            place.parent.mkdir(parents=True, exist_ok=True)
            atomic.replace_file(place, data, by=self.path)

    def _begun(self) -> bool:
        """Whether this array exists at its path; raise if it cannot be made there."""
        if not os.path.lexists(self.path):
            atomic.check_writable(self.path)
            return False
        found = described(self.path / SIGN)
        if found is None:
            atomic.sweep(self.path)
            if not self.path.is_dir() or any(self.path.iterdir()):
                raise ParameterError(f"{self.path} exists, and is no texture that was woven; name another place.")
            return False
        own = json.loads(self._sign())
        recipes = [held["attributes"]["intarsia"] for held in (found, own)]
        names = [name for name in {**recipes[1], **recipes[0]} if recipes[0].get(name) != recipes[1].get(name)]
        if differing := names or [name for name in own if name != "attributes" and found.get(name) != own[name]]:
            raise ParameterError(
                f"{self.path} holds another recipe ({', '.join(differing)}); name another place, or remove it first."
            )
        return True

    def _begin(self) -> None:
        """Make a new array without chunks."""
        target = Path(os.path.realpath(self.path))
        new = not target.exists()
        try:
            target.mkdir(exist_ok=True)
            atomic.sync_folder(target.parent)
            atomic.replace_file(target / SIGN, self._sign(), durable=True)
        except BaseException:
            with suppress(OSError):
                if new:
                    target.rmdir()
            raise

    def _sign(self) -> bytes:
        """Return the content of ``zarr.json``, with the recipe among the attributes."""
        files: Record = {}
        recipe = self.recipe | {"chunk": self.packer.chunk}
        self.packer.array(self.grid.shape, {"intarsia": recipe}, files)
        data: bytes = files[SIGN].to_bytes()
        return data

    def _sound(self, cell: Cell) -> bool:
        """Whether the file of a cell exists and is valid; ParameterError if it is no ordinary file."""
        try:
            with atomic.open_regular(self._place(cell), "rb") as file:
                return self.packer.sound(file.read())
        except OSError:
            return False

    def _place(self, cell: Cell) -> Path:
        """Return the path of a cell's file; ParameterError if it leads out of the store."""
        name = self.packer.name(cell.row, cell.column)
        for folder in reversed(Path(name).parents[:-1]):
            way = self.path / folder
            if os.path.lexists(way) and (way.is_symlink() or not way.is_dir()):
                raise ParameterError(f"{way} is no folder; move it elsewhere, or name another place.")
        return self.path / name


def described(place: Path) -> Record | None:
    """Return the metadata of a zarr array; None if there is none, or it is no texture of this package.

    Raises InputError if it is damaged.
    """
    try:
        with atomic.open_regular(place, "rb") as file:
            found = json.loads(file.read(LONGEST))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (ValueError, RecursionError):
        raise InputError(f"{place} cannot be read any more; name another place.") from None
    attributes = found.get("attributes") if isinstance(found, dict) else None
    return found if isinstance(attributes, dict) and isinstance(attributes.get("intarsia"), dict) else None
