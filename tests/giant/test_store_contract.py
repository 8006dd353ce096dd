"""Every kind of store keeps the promises of a store: see `intarsia.giant.picture.Store`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import closing, suppress
from multiprocessing.reduction import ForkingPickler
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from giant.giants import needs

import intarsia as ia
from intarsia.cli.weaving import STORES
from intarsia.files import read_plane, read_recipe
from intarsia.foundation import IntarsiaError, ParameterError
from intarsia.foundation.geometry import Box
from intarsia.giant import exports, zarrays
from intarsia.giant.picture import Cell, Store
from intarsia.giant.stream import stream
from intarsia.testing import as_depth, texture

DEPTHS = (("uint8", 1), ("uint8", 2), ("uint8", 3), ("uint8", 4), ("uint16", 1), ("uint16", 3), ("float32", 3))
"""Types of samples, and numbers of channels."""


def endless(seed: int = 0, dtype: str = "uint8", channels: int = 3) -> ia.Weave:
    """An endless texture that is quick to draw."""
    return ia.weave(as_depth(texture(29, 31, channels, seed), dtype), ia.Repeat(), seed)


class StoppedError(Exception):
    """Whoever draws was stopped."""


class StorePromises:
    """What every :class:`intarsia.giant.picture.Store` promises; subclass it and say which one, and how it is read."""

    sides: ClassVar[tuple[int, int]] = (150, 170)
    origin: ClassVar[tuple[int, int]] = (3, -8)
    kind: ClassVar[type[Store]]
    ending: ClassVar[str] = ""
    side: ClassVar[int | None] = 32

    @pytest.fixture(autouse=True)
    def cut(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Small cells, so that a small picture has several along both axes, the last ones smaller."""
        for module in (zarrays, exports):
            monkeypatch.setattr(module, "SIDE", 64)
        monkeypatch.setattr(exports, "AREA", 64 * 64)

    def make(self, picture: ia.Weave, path: Path, force: bool = False) -> Store:
        """Plan a store of a picture at a place; ParameterError where it cannot hold such pixels."""
        return self.kind.of(picture, path, self.sides, self.origin, self.side, force)

    def read(self, path: Path) -> Any:
        """Read the pixels of a store that is whole, by other means than its own."""
        raise NotImplementedError

    def files(self, path: Path) -> dict[str, bytes]:
        """Every file of a store, by its name behind that of the store."""
        beside = [path, *path.parent.glob(f"{path.name}.*")]
        found = [p for p in (*beside, *path.rglob("*")) if p.is_file()]
        return {str(p)[len(str(path)) :]: p.read_bytes() for p in found}

    def test_its_cells_are_the_picture_once_over(self, tmp_path: Path) -> None:
        """Several, numbered row by row; no pixel belongs to two of them or to none."""
        store = self.make(endless(), tmp_path / f"o{self.ending}")
        assert (store.grid.height, store.grid.width) == self.sides
        assert store.origin == self.origin
        times = np.zeros(self.sides, int)
        for number, cell in enumerate(store.grid):
            assert cell.number == number
            assert store.grid.cell(number) == cell
            times[cell.box.y0 : cell.box.y1, cell.box.x0 : cell.box.x1] += 1
        assert (times == 1).all()
        assert store.grid.down > 1
        assert len(store.grid) > 3

    def test_it_holds_the_picture_whatever_its_type(self, tmp_path: Path) -> None:
        """Every depth and number of channels is read as it was drawn, or refused before anything is written."""
        held = 0
        for dtype, channels in DEPTHS:
            path = tmp_path / f"{dtype}-{channels}{self.ending}"
            picture = endless(4, dtype, channels)
            try:
                store = self.make(picture, path)
            except IntarsiaError:
                assert not self.files(path)
                continue
            stream(store, None, ia.Run(1))
            shown = self.read(path)
            assert shown.dtype == picture.dtype
            (y, x), (height, width) = self.origin, self.sides
            window = picture.draw(Box(y, x, y + height, x + width))
            assert (shown.reshape(*self.sides, -1) == window.reshape(*self.sides, -1)).all()
            held += 1
        assert held

    def test_looking_and_planning_write_nothing(self, tmp_path: Path) -> None:
        """Only `open` begins."""
        store = self.make(endless(), tmp_path / f"o{self.ending}")
        store.look()
        store.close()
        assert not list(tmp_path.iterdir())

    def test_who_draws_and_how_many_changes_no_byte(self, tmp_path: Path) -> None:
        """One thread or three; a packer is sent to other processes, and packs a cell the same there."""
        self._fill(tmp_path / f"one{self.ending}")
        store = self.make(endless(), tmp_path / f"three{self.ending}")
        packer = ForkingPickler.loads(ForkingPickler.dumps(store.packer))
        for cell in store.grid:
            pixels = endless().draw(cell.box.moved(*self.origin))
            pixels = pixels.reshape(*pixels.shape[:2], -1)
            assert packer(pixels, cell) == store.packer(pixels.copy(), cell)
        stream(store, None, ia.Run(3))
        assert self.files(tmp_path / f"three{self.ending}") == self.files(tmp_path / f"one{self.ending}")

    def test_what_is_not_its_own_is_never_touched(self, tmp_path: Path) -> None:
        """A folder with somebody's work, with `force`, too; a file without it. A folder that is missing is not made."""
        folder, file = tmp_path / f"folder{self.ending}", tmp_path / f"file{self.ending}"
        folder.mkdir()
        (folder / "thesis.txt").write_text("years")
        file.write_text("work")
        missing = tmp_path / "missing" / f"o{self.ending}"
        for path, force in ((folder, False), (folder, True), (file, False), (missing, False)):
            for attempt in ("look", "open"):
                store = self.make(endless(), path, force)
                with pytest.raises(IntarsiaError) as caught:
                    getattr(store, attempt)()
                store.close()
                assert "\n" not in str(caught.value)
                assert (path.parent if path is missing else path).name in str(caught.value)
        assert self.files(folder) == {"/thesis.txt": b"years"}
        assert file.read_text() == "work"
        assert not missing.parent.exists()

    def test_closing_lets_go_of_every_file(self, tmp_path: Path) -> None:
        """At any time, and twice; then the store can be moved."""
        store = self.make(endless(), tmp_path / f"o{self.ending}")
        store.close()
        assert list(store.open())
        store.close()
        store.close()
        for path in list(tmp_path.iterdir()):
            path.rename(path.with_name(path.name.replace("o", "p", 1)))
        assert self._fill(tmp_path / f"p{self.ending}") == len(store.grid)

    def _fill(self, path: Path, stop: int | None = None, seed: int = 0, force: bool = False) -> int:
        """Make a store, or stop after so many cells. Return how many cells were drawn."""
        picture, drawn = endless(seed), [0]
        store = self.make(picture, path, force)

        def results(missing: list[int]) -> Iterator[tuple[Cell, list[bytes]]]:
            for number in missing:
                if drawn[0] == stop:
                    raise StoppedError
                cell = store.grid.cell(number)
                pixels = picture.draw(cell.box.moved(*self.origin))
                drawn[0] += 1
                yield cell, store.packer(pixels.reshape(*pixels.shape[:2], -1), cell)
            if drawn[0] == stop:
                raise StoppedError

        with closing(store), suppress(StoppedError):
            store.fill(results(list(store.open())), ia.Run(1))
            store.finish()
        return drawn[0]


class TestZarr(StorePromises):
    """And that it goes on where it was stopped."""

    kind = zarrays.ZarrStore

    @pytest.fixture(autouse=True)
    def extra(self) -> None:
        needs("zarr")

    def read(self, path: Path) -> Any:
        return needs("zarr").open_array(path, mode="r")[:]

    def test_what_was_put_before_a_stop_is_there_after_it(self, tmp_path: Path) -> None:
        """After every number of cells: only the others are missing, and the files end as if nobody had stopped."""
        self._fill(tmp_path / "whole")
        whole = self.files(tmp_path / "whole")
        count = len(self.make(endless(), tmp_path / "whole").grid)
        for stop in range(count + 1):
            path = tmp_path / str(stop)
            self._fill(path, stop)
            assert self._fill(path) == count - stop, stop
            assert self.files(path) == whole, stop

    def test_a_byte_that_turns_over_is_found(self, tmp_path: Path) -> None:
        """In any file, anywhere: the same call makes it good, or refuses in one line and touches nothing."""
        self._fill(tmp_path / "o")
        whole, mended = self.files(tmp_path / "o"), 0
        for name, data in whole.items():
            for at in sorted({0, 3, len(data) // 3, len(data) // 2, len(data) - 1}):
                turned = bytes([*data[:at], data[at] ^ 0x55, *data[at + 1 :]])
                self._put(tmp_path / "o", whole | {name: turned})
                if self._go_on(tmp_path / "o", whole | {name: turned}):
                    assert self.files(tmp_path / "o") == whole, (name, at)
                    mended += 1
        assert mended

    def _go_on(self, path: Path, before: dict[str, bytes]) -> bool:
        """Fill a store that was damaged; False: it is refused."""
        try:
            self._fill(path)
        except IntarsiaError:
            assert self.files(path) == before
            return False
        return True

    def _put(self, path: Path, files: dict[str, bytes]) -> None:
        """Make the files of a store these, and no others."""
        for name in self.files(path):
            Path(str(path) + name).unlink()
        for name, data in files.items():
            place = Path(str(path) + name)
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(data)


class ExportPromises(StorePromises):
    """And that there is nothing before all of it is there."""

    def test_nothing_is_left_of_one_that_was_stopped(self, tmp_path: Path) -> None:
        """After every number of cells; the next run draws all of them. While it is written, its name is free."""
        path = tmp_path / f"o{self.ending}"
        count = len(self.make(endless(), path).grid)
        for stop in range(count + 1):
            assert self._fill(path, stop) == stop
            assert not list(tmp_path.iterdir())
        with pytest.MonkeyPatch.context() as patch:
            seen = list[bool]()
            finish = self.kind.finish
            patch.setattr(self.kind, "finish", lambda s: (seen.append(path.exists()), finish(s)))
            assert self._fill(path) == count
        assert seen == [False]
        assert [p.name for p in tmp_path.iterdir()] == [path.name]

    def test_what_is_there_gives_way_to_force_alone(self, tmp_path: Path) -> None:
        """Even to the same picture; it stays whole until the new one is."""
        path = tmp_path / f"o{self.ending}"
        self._fill(path)
        before = self.files(tmp_path)
        for seed in (0, 1):
            with pytest.raises(ParameterError, match="exists; name another file, or allow to replace it with --force"):
                self._fill(path, seed=seed)
        self._fill(path, 3, seed=1, force=True)
        assert self.files(tmp_path) == before
        self._fill(path, seed=1, force=True)
        assert self.recipe(path)["seed"] == 1
        self._fill(tmp_path / f"p{self.ending}", seed=1)
        assert self.files(path) == self.files(tmp_path / f"p{self.ending}")

    def recipe(self, path: Path) -> Any:
        """The recipe that is kept with the pixels."""
        return read_recipe(path)


class TestTiff(ExportPromises):
    kind, ending = exports.TiffStore, ".tif"

    @pytest.fixture(autouse=True)
    def extra(self) -> None:
        needs("tifffile")

    def read(self, path: Path) -> Any:
        return needs("tifffile").imread(path)


class TestPicture(ExportPromises):
    kind, side, ending = exports.PictureStore, None, ".png"

    def read(self, path: Path) -> Any:
        return read_plane(path).pixels

    def test_a_recipe_beside_goes_with_its_picture(self, tmp_path: Path) -> None:
        """Where the format holds none: it is in nobody's way, and one of old does not outlive its picture."""
        beside = tmp_path / "p.bmp.recipe.json"
        beside.write_text("mine")
        with pytest.raises(ParameterError, match=r"p.bmp.recipe.json exists"):
            self.make(endless(), tmp_path / "p.bmp").look()
        self._fill(tmp_path / "p.bmp", force=True)
        assert read_recipe(tmp_path / "p.bmp")["seed"] == 0
        (tmp_path / "o.png.recipe.json").write_text("old")
        self._fill(tmp_path / "o.png", force=True)
        assert sorted(p.name for p in tmp_path.iterdir()) == ["o.png", "p.bmp", "p.bmp.recipe.json"]

    def test_what_its_format_does_not_hold_is_refused_in_the_plan(self, tmp_path: Path) -> None:
        for dtype, channels, ending, words in (
            ("float32", 3, "png", "png holds 8 bit or 16 bit, not float; name a .zarr or a .tif."),
            ("uint16", 3, "bmp", "bmp holds 8 bit, not 16 bit; name a .zarr or a .tif."),
            ("uint8", 2, "ppm", "ppm holds 3 channels, not 2"),
        ):
            with pytest.raises(ParameterError, match=re.escape(f"o.{ending}: {words}")):
                self.make(endless(0, dtype, channels), tmp_path / f"o.{ending}")
        with pytest.raises(ParameterError, match=r"at most 1000000 px a side, not 1000001x1; name a \.zarr"):
            self.kind.of(endless(), tmp_path / "o.png", (1, 1_000_001), self.origin, None, False)
        with pytest.raises(ParameterError, match=r"a picture in one piece has no chunks; drop --chunk"):
            self.kind.of(endless(), tmp_path / "o.png", self.sides, self.origin, 32, False)


def test_every_kind_of_store_is_under_contract() -> None:
    assert {made.kind for made in (TestZarr, TestTiff, TestPicture)} == set(STORES.values())
