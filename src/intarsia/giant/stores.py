"""The kinds of stores, by name."""

from __future__ import annotations

import os
from typing import Any

from .bigtiff import TiffStore
from .deepzoom import TileStore
from .picture import Picture, Store
from .zarrays import ZarrStore

STORES: dict[str, tuple[type[ZarrStore] | type[TiffStore] | type[TileStore], int]] = {
    "zarr": (ZarrStore, 512),
    "tiff": (TiffStore, 512),
    "tiles": (TileStore, 256),
}
"""Name -> the store, and the usual side of its chunks or tiles."""


def store_of(
    kind: str, texture: Picture, path: str | os.PathLike[str], sides: tuple[int, int], origin: Any, side: int | None,
    force: bool,
) -> Store:  # fmt: skip
    """Plan a store; nothing is written yet."""
    cls, usual = STORES[kind]
    return cls.of(texture, path, sides, origin, usual if side is None else side, force)
