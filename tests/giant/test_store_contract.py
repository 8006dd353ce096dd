"""Every kind of store keeps the promises of a store."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from giant.giants import needs

import intarsia as ia
from intarsia.files import read_plane
from intarsia.giant import bigtiff, deepzoom, zarrays
from intarsia.giant.picture import Store
from intarsia.giant.stream import STORES, store_of
from intarsia.testing import StoreContract


class OfTheGiant(StoreContract):
    """A kind that has a name; of small cells, so that a small picture has several."""

    kind = ""

    @pytest.fixture(autouse=True)
    def cut(self, monkeypatch: pytest.MonkeyPatch) -> None:
        for module in (zarrays, deepzoom):
            monkeypatch.setattr(module, "SIDE", 64)
        monkeypatch.setattr(bigtiff, "AREA", 64 * 64)

    def make(self, picture: ia.Weave, path: Path, force: bool = False) -> Store:
        return store_of(self.kind, picture, path, self.sides, self.origin, 32, force)


class TestZarr(OfTheGiant):
    kind = "zarr"

    @pytest.fixture(autouse=True)
    def extra(self) -> None:
        needs("zarr")

    def read(self, path: Path) -> Any:
        return needs("zarr").open_array(path, mode="r")[:]


class TestTiff(OfTheGiant):
    kind = "tiff"

    def read(self, path: Path) -> Any:
        named = path.with_suffix(".tif")
        named.symlink_to(path)
        return needs("tifffile").imread(named)


class TestTiles(OfTheGiant):
    kind = "tiles"

    def read(self, path: Path) -> Any:
        levels = sorted((path / "image_files").iterdir(), key=lambda p: int(p.name))
        rows: dict[int, dict[int, Any]] = {}
        for tile in levels[-1].iterdir():
            column, row = map(int, tile.stem.split("_"))
            rows.setdefault(row, {})[column] = read_plane(tile).samples
        return np.concatenate([np.concatenate([r[n] for n in sorted(r)], axis=1) for _, r in sorted(rows.items())])


def test_every_kind_of_store_is_under_contract() -> None:
    assert {made.kind for made in OfTheGiant.__subclasses__()} == set(STORES)
