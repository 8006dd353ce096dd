"""Every kind of store keeps the promises of a store."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from giant.giants import needs
from giant.store_contract import StoreContract, StorePromises, endless

import intarsia as ia
from intarsia.errors import ParameterError
from intarsia.files import read_plane, read_recipe
from intarsia.giant import bigtiff, deepzoom, held, zarrays
from intarsia.giant.picture import Store
from intarsia.giant.stream import STORES, store_of
from intarsia.run import Run


class OfTheGiant(StorePromises):
    """A kind that has a name; of small cells, so that a small picture has several."""

    kind = ""
    side: int | None = 32

    @pytest.fixture(autouse=True)
    def cut(self, monkeypatch: pytest.MonkeyPatch) -> None:
        for module in (zarrays, deepzoom, held):
            monkeypatch.setattr(module, "SIDE", 64)
        monkeypatch.setattr(bigtiff, "AREA", 64 * 64)

    def make(self, picture: ia.Weave, path: Path, force: bool = False) -> Store:
        return store_of(self.kind, picture, path, self.sides, self.origin, self.side, force)


class TestZarr(OfTheGiant, StoreContract):
    kind = "zarr"

    @pytest.fixture(autouse=True)
    def extra(self) -> None:
        needs("zarr")

    def read(self, path: Path) -> Any:
        return needs("zarr").open_array(path, mode="r")[:]


class TestTiff(OfTheGiant, StoreContract):
    kind = "tiff"

    def read(self, path: Path) -> Any:
        named = path.with_suffix(".tif")
        named.symlink_to(path)
        return needs("tifffile").imread(named)


class TestTiles(OfTheGiant, StoreContract):
    kind = "tiles"

    def read(self, path: Path) -> Any:
        levels = sorted((path / "image_files").iterdir(), key=lambda p: int(p.name))
        rows: dict[int, dict[int, Any]] = {}
        for tile in levels[-1].iterdir():
            column, row = map(int, tile.stem.split("_"))
            rows.setdefault(row, {})[column] = read_plane(tile).samples
        return np.concatenate([np.concatenate([r[n] for n in sorted(r)], axis=1) for _, r in sorted(rows.items())])


class TestPicture(OfTheGiant):
    kind, side, ending = "picture", None, ".png"

    def read(self, path: Path) -> Any:
        return read_plane(path).pixels

    def test_nothing_lies_there_before_it_is_whole(self, tmp_path: Path) -> None:
        """After every number of cells; the next run draws all of them."""
        count = len(self.make(endless(), tmp_path / "o.png").grid)
        for stop in range(count + 1):
            assert self._fill(tmp_path / "o.png", stop) == stop
            assert not list(tmp_path.iterdir())
        store = self.make(endless(), tmp_path / "o.png")
        for number in store.open():
            cell = store.grid.cell(number)
            pixels = endless().draw(cell.box.moved(*self.origin))
            store.put(cell, store.packer(pixels, cell))
        assert not list(tmp_path.iterdir())
        store.finish(Run(1))
        assert [p.name for p in tmp_path.iterdir()] == ["o.png"]

    def test_a_file_gives_way_to_force_alone(self, tmp_path: Path) -> None:
        """Even to the same picture; and a recipe of old beside it where the format holds none."""
        self._fill(tmp_path / "o.png")
        before = self.files(tmp_path)
        for seed in (0, 1):
            with pytest.raises(ParameterError, match=r"o\.png exists; name another file"):
                self._fill(tmp_path / "o.png", seed=seed)
        assert self.files(tmp_path) == before
        self._fill(tmp_path / "o.png", seed=1, force=True)
        assert read_recipe(tmp_path / "o.png")["seed"] == 1
        (tmp_path / "p.bmp.recipe.json").write_text("mine")
        with pytest.raises(ParameterError, match=r"p.bmp.recipe.json exists"):
            self.make(endless(), tmp_path / "p.bmp").look()

    def test_what_its_format_does_not_hold_is_refused_in_the_plan(self, tmp_path: Path) -> None:
        for dtype, channels, ending, words in (
            ("float32", 3, "png", "png holds 8 or 16 bit, not float; name a .zarr or a .tif."),
            ("uint16", 3, "bmp", "bmp holds 8 bit, not 16 bit; name a .zarr or a .tif."),
            ("uint8", 2, "ppm", "ppm holds 3 channels, not 2"),
        ):
            with pytest.raises(ParameterError, match=re.escape(f"o.{ending}: {words}")):
                self.make(endless(0, dtype, channels), tmp_path / f"o.{ending}")
        with pytest.raises(ParameterError, match=r"at most 1000000 px a side, not 1000001x1; name a \.zarr"):
            store_of(self.kind, endless(), tmp_path / "o.png", (1, 1_000_001), self.origin, None, False)
        with pytest.raises(ParameterError, match=r"a picture in one piece has no chunks; drop --chunk"):
            store_of(self.kind, endless(), tmp_path / "o.png", self.sides, self.origin, 32, False)


def test_every_kind_of_store_is_under_contract() -> None:
    assert {made.kind for made in OfTheGiant.__subclasses__()} == set(STORES)
