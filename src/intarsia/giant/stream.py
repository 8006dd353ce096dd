"""Stream a texture into a store: what is there and whole stays, the rest is drawn; in any order, the same bytes."""

from __future__ import annotations

import errno
from collections.abc import Iterable
from contextlib import closing
from dataclasses import dataclass
from typing import Any, Protocol

from ..errors import ParameterError, ResourceError
from ..geometry import Box
from ..image import Array
from ..run import Run
from .cells import Cell, Grid
from .executors import ExecutorLike, executor_of
from .ledger import ABOUT
from .texture import Weave, shifted

LEAST = 16  # px: shortest side of chunks and tiles


class Packer(Protocol):
    """Turns the pixels of a cell into the bytes that a store holds; sent to the workers."""

    def __call__(self, pixels: Array, cell: Cell) -> list[bytes]:
        """Return the pieces of a cell."""


class Store(Protocol):
    """A picture on disk, made cell by cell."""

    @property
    def grid(self) -> Grid:
        """How it is cut into cells."""

    @property
    def packer(self) -> Packer:
        """What packs a cell."""

    @property
    def texture(self) -> Weave:
        """What is stored."""

    @property
    def origin(self) -> tuple[int, int]:
        """The pixel of the endless plane that comes first."""

    @property
    def shown(self) -> str:
        """Its name in messages."""

    def look(self) -> None:
        """Refuse, before any work, a place where this store cannot be; writes nothing."""

    def open(self) -> Iterable[int]:
        """Begin or go on; return the numbers of the cells that are missing or damaged, rising."""

    def put(self, cell: Cell, pieces: list[bytes]) -> None:
        """Write a cell; cells come in the order that was asked for."""

    def finish(self, run: Run) -> None:
        """Make the store whole once all cells are there."""

    def close(self) -> None:
        """Let go of all files."""


@dataclass(frozen=True)
class DrawnAndPacked:
    """The task of a worker: draw a cell, pack it."""

    texture: Weave
    origin: tuple[int, int]
    packer: Packer

    def __call__(self, cell: Cell) -> list[bytes]:
        pixels = self.texture.draw(shifted(cell.box, *self.origin))
        return self.packer(pixels.reshape(*pixels.shape[:2], -1), cell)


def stream(store: Store, executor: ExecutorLike, run: Run) -> None:
    """Fill a store; the same bytes, whoever draws, and however often it was interrupted."""
    total = len(store.grid)
    try:
        store.look()
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
        raise failed(store.shown, e) from None
    finally:
        store.close()


def header_of(
    texture: Weave, sides: tuple[int, int], origin: tuple[int, int], layout: dict[str, Any]
) -> dict[str, Any]:
    """What a store holds: all that its bytes depend on."""
    place = {"size": [sides[1], sides[0]], "origin": [origin[1], origin[0]]}
    kind = {"type": texture.dtype.name, "channels": texture.channels, "kind": texture.like.kind.value}
    return {"holds": ABOUT, "recipe": texture.recipe | place} | kind | layout


def checked(texture: Weave, sides: tuple[int, int], origin: Any) -> tuple[int, int]:
    """Return the first pixel of a picture, or refuse one that lies too far away."""
    try:
        y, x = (int(n.__index__()) for n in origin)
    except (TypeError, ValueError, AttributeError):
        raise ParameterError(f"origin={origin!r} is no pixel; give (y, x).") from None
    height, width = sides
    texture.map_box(Box(y, x, y + height, x + width))
    return y, x


def check_side(name: str, side: Any, most: int, multiple: int = 1) -> int:
    """Refuse a side of chunks or tiles that cannot be."""
    whole = hasattr(side, "__index__") and not isinstance(side, bool)
    if not whole or not LEAST <= int(side) <= most or int(side) % multiple:
        step = "" if multiple == 1 else f", a multiple of {multiple}"
        raise ParameterError(f"{name}={side} is not allowed; give {LEAST} to {most} px{step}.")
    return int(side)


def failed(shown: str, e: OSError) -> Exception:
    """Say in one line why a store could not be written."""
    if e.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return ResourceError(f"there is no room for {shown}; free some space, then the same command goes on.")
    return ResourceError(f"{shown} cannot be written ({(e.strerror or str(e)).lower()}); name another place.")

