"""A texture as a zarr array (version 3): small chunks, several of them in a file."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..arguments import expect_path
from ..disk import whole
from ..image import Array
from .cells import SIDE, Cell, Grid
from .extras import extra
from .folder import FolderStore, recipe_in_zarr
from .picture import Picture, check_side, checked, header_of


@dataclass(frozen=True)
class ZarrPacker:
    """Packs cells as the files of a zarr array: chunks of `chunk` px in files of `side` px."""

    chunk: int
    side: int
    tail: tuple[int, ...]  # the channels, where the array has an axis for them
    dtype: str

    def array(self, shape: tuple[int, int], attributes: dict[str, Any], files: dict[str, Any]) -> Any:
        """Make an array whose files land in `files`."""
        zarr = extra("zarr")
        names = ("y", "x", "channel")[: 2 + len(self.tail)]
        return zarr.create_array(
            zarr.storage.MemoryStore(store_dict=files), shape=(*shape, *self.tail),
            chunks=(self.chunk, self.chunk, *self.tail),
            shards=None if self.chunk == self.side else (self.side, self.side, *self.tail), dtype=self.dtype,
            fill_value=0, attributes=attributes, dimension_names=names, config={"write_empty_chunks": True},
        )  # fmt: skip

    def __call__(self, pixels: Array, cell: Cell) -> list[bytes]:
        files: dict[str, Any] = {}
        alone = self.array((self.side, self.side), {}, files)
        height, width = pixels.shape[:2]
        alone[:height, :width] = pixels.reshape(height, width, *self.tail)
        return [files["/".join(["c", "0", "0", *("0" for _ in self.tail)])].to_bytes()]


@dataclass
class ZarrStore(FolderStore):
    """A zarr array of a texture."""

    packer: ZarrPacker

    @classmethod
    def of(
        cls, texture: Picture, path: str | os.PathLike[str], sides: tuple[int, int], origin: Any, chunk: int,
        force: bool,
    ) -> ZarrStore:  # fmt: skip
        """Plan an array; MissingExtraError without zarr."""
        extra("zarr")
        expect_path(path)
        origin, chunk = checked(texture, sides, origin), check_side("chunk", chunk, 8192)
        side = chunk * max(SIDE // chunk, 1)
        tail = () if texture.like.pixels.ndim == 2 else (texture.channels,)
        grid = Grid(*sides, side, side)  # refuses what is too large before functions are asked for all of it
        header = header_of(texture, sides, origin, {"format": "zarr", "chunk": chunk})
        packer = ZarrPacker(chunk, side, tail, texture.dtype.name)
        return cls(Path(path), str(path), texture, origin, grid, header, force, packer)

    def files_of(self, cell: Cell) -> list[str]:
        """One file a cell."""
        return ["/".join(["c", str(cell.row), str(cell.column), *("0" for _ in self.packer.tail)])]

    def second(self) -> dict[str, Any] | None:
        """What the array says of itself: its recipe, and how it is cut."""
        place = self.path / "zarr.json"
        held = recipe_in_zarr(place) if whole.is_file(place) else None
        if not held:
            return None
        own = json.loads(self.signs()["zarr.json"])
        differing = {name: held.get(name) for name in own if name != "attributes" and held.get(name) != own[name]}
        return self.header | {"recipe": held["attributes"]["intarsia"]} | differing

    def signs(self) -> dict[str, bytes]:
        """The description of the array, with the recipe among its attributes."""
        files: dict[str, Any] = {}
        self.packer.array((self.grid.height, self.grid.width), {"intarsia": self.header["recipe"]}, files)
        return {"zarr.json": files["zarr.json"].to_bytes()}
