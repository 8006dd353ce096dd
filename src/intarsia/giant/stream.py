"""Stream a texture into a store: what is there and whole stays, the rest is drawn; in any order, the same bytes."""

from __future__ import annotations

import errno
import os
from contextlib import closing
from dataclasses import dataclass
from typing import Any

from ..errors import ResourceError
from ..run import Run
from .bigtiff import TiffStore
from .cells import Cell
from .deepzoom import TileStore
from .executors import ExecutorLike, check_sendable, executor_of
from .picture import Packer, Picture, Store
from .zarrays import ZarrStore

STORES: dict[str, tuple[type[ZarrStore] | type[TiffStore] | type[TileStore], int]] = {
    "zarr": (ZarrStore, 512),
    "tiff": (TiffStore, 512),
    "tiles": (TileStore, 256),
}
"""Name -> the store, and the usual side of its chunks or tiles."""


@dataclass(frozen=True)
class DrawnAndPacked:
    """The task of a worker: draw a cell, pack it."""

    texture: Picture
    origin: tuple[int, int]
    packer: Packer

    def __call__(self, cell: Cell) -> list[bytes]:
        pixels = self.texture.draw(cell.box.moved(*self.origin))
        return self.packer(pixels.reshape(*pixels.shape[:2], -1), cell)


def stream(store: Store, executor: ExecutorLike, run: Run) -> None:
    """Fill a store; the same bytes, whoever draws, and however often it was interrupted."""
    total = len(store.grid)
    try:
        store.look()
        check_sendable(store.texture.method, executor)
        with executor_of(executor, run) as workers:
            missing = list(store.open())
            run.tick(total - len(missing), total)
            task = DrawnAndPacked(store.texture, store.origin, store.packer)
            with closing(workers.in_order(task, map(store.grid.cell, missing))) as results:
                for done, (cell, pieces) in enumerate(results, total - len(missing) + 1):
                    store.put(cell, pieces)
                    run.tick(done, total)
        store.finish(run)
    except OSError as e:
        raise failed(store.printable, e) from None
    finally:
        store.close()


def failed(name: str, e: OSError) -> Exception:
    """Say in one line why a store could not be written."""
    if e.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return ResourceError(f"there is no room for {name}; free some space, then the same command goes on.")
    return ResourceError(f"{name} cannot be written ({(e.strerror or str(e)).lower()}); name another place.")


def store_of(
    kind: str, texture: Picture, path: str | os.PathLike[str], sides: tuple[int, int], origin: Any, side: int | None,
    force: bool,
) -> Store:  # fmt: skip
    """Plan a store; nothing is written yet."""
    cls, usual = STORES[kind]
    return cls.of(texture, path, sides, origin, usual if side is None else side, force)
