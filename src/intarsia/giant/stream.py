"""Stream a texture into a store: what is there and whole stays, the rest is drawn, by anybody in the same bytes."""

from __future__ import annotations

import errno
import os
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import Any

from ..disk.limits import taken
from ..errors import ResourceError
from ..methods.base import traits
from ..run import Run
from .cells import Cell
from .executors import AHEAD, ExecutorLike, check_sendable, executor_of
from .exports import HeldStore, TiffStore, TileStore
from .picture import Packer, Picture, Results, Store
from .zarrays import ZarrStore

STORES: dict[str, tuple[type[Store], int]] = {
    "zarr": (ZarrStore, 512),
    "tiff": (TiffStore, 512),
    "tiles": (TileStore, 256),
    "picture": (HeldStore, 0),
}
"""Name -> the store, and the usual side of its chunks or tiles; 0: it has none."""


PER_PX, BETWEEN = 16, 140
"""Bytes of memory of a px that is drawn, its map and weights; and what it takes besides where it is read between
pixels."""

DRAWN = 1 << 22
"""Px of the map that a worker holds at most."""


@dataclass(frozen=True)
class DrawnAndPacked:
    """The task of a worker: draw a cell, pack it."""

    texture: Picture
    origin: tuple[int, int]
    packer: Packer

    def __call__(self, cell: Cell) -> list[bytes]:
        pixels = self.texture.draw(cell.box.moved(*self.origin))
        return self.packer(pixels.reshape(*pixels.shape[:2], -1), cell)


@dataclass(frozen=True)
class Needed:
    """What filling a store will take: seconds, and bytes of this process's memory at its peak."""

    seconds: float
    memory: int


def memory_of(store: Store, workers: int) -> int:
    """Bytes that this process takes at least while so many workers fill a store."""
    return taken() + store.held + min(workers, len(store.grid)) * _drawn(store)


def estimated(store: Store, workers: int) -> Needed:
    """Draw a cell of a store to tell what so many workers like this one will need to fill it; nothing is written."""
    task, cell = DrawnAndPacked(store.texture, store.origin, store.packer), store.grid.cell(0)
    task(cell)
    began = time.perf_counter()
    pieces = task(cell)
    spent, packed = time.perf_counter() - began, sum(map(len, pieces))
    share = cell.box.height * cell.box.width / (store.grid.height * store.grid.width)
    others = min(workers, len(store.grid)) - 1  # the first was measured just now
    memory = taken() + store.held + others * _drawn(store) + AHEAD * (others + 1) * packed
    return Needed((spent / workers + store.packing(cell, pieces)) / share, memory)


def _drawn(store: Store) -> int:
    """What a worker holds while it draws a cell, in bytes."""
    box, texture = store.grid.cell(0).box, store.texture
    px, each = box.height * box.width, PER_PX + (0 if traits(texture.method).exact else BETWEEN)
    return int(min(px * texture.scale[1] ** 2, DRAWN) * each + px * 2 * texture.channels * texture.dtype.itemsize)


def stream(store: Store, executor: ExecutorLike, run: Run) -> None:
    """Make a store; the same bytes, whoever draws, and however often it was interrupted."""
    try:
        fill(store, executor, run)
        finish(store)
    finally:
        store.close()


def fill(store: Store, executor: ExecutorLike, run: Run) -> None:
    """Draw what a store misses, and write it; the store stays open."""
    total = len(store.grid)
    with legible(store):
        store.look()
        check_sendable(store.texture.method, executor)
        with executor_of(executor, run) as workers:
            missing = list(store.open())
            run.tick(total - len(missing), total)
            task = DrawnAndPacked(store.texture, store.origin, store.packer)

            def counted(results: Results) -> Results:
                for done, result in enumerate(results, total - len(missing) + 1):
                    yield result
                    run.tick(done, total)

            with closing(workers.in_order(task, map(store.grid.cell, missing))) as results:
                store.fill(counted(results), run)


def finish(store: Store) -> None:
    """Let a store that is full bear its name."""
    with legible(store):
        store.finish()


@contextmanager
def legible(store: Store) -> Iterator[None]:
    """Say in one line why a store could not be written."""
    try:
        yield
    except OSError as e:
        if e.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            after = "goes on" if store.resumes else "begins anew"
            raise ResourceError(
                f"there is no room for {store.printable}; free some space, then the same command {after}."
            ) from None
        reason = (e.strerror or str(e)).lower()
        raise ResourceError(f"{store.printable} cannot be written ({reason}); name another place.") from None


def store_of(
    kind: str, texture: Picture, path: str | os.PathLike[str], sides: tuple[int, int], origin: Any, side: int | None,
    force: bool,
) -> Store:  # fmt: skip
    """Plan a store; nothing is written yet."""
    cls, usual = STORES[kind]
    return cls.of(texture, path, sides, origin, usual if side is None else side, force)
