"""The promises of a store, as tests of whatever makes one: see `intarsia.giant.picture.Store`.

`StorePromises` are those of every store; `StoreContract` adds those of a store that goes on where it was stopped.
"""

from __future__ import annotations

from multiprocessing.reduction import ForkingPickler
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from intarsia.errors import IntarsiaError
from intarsia.geometry import Box
from intarsia.giant.picture import Store
from intarsia.giant.stream import stream
from intarsia.giant.texture import Weave, weave
from intarsia.image import Array
from intarsia.methods.repeat import Repeat
from intarsia.run import Run
from intarsia.testing.cases import as_depth, texture

DEPTHS = (("uint8", 1), ("uint8", 2), ("uint8", 3), ("uint8", 4), ("uint16", 1), ("uint16", 3), ("float32", 3))
"""Types of samples, and numbers of channels."""


def endless(seed: int = 0, dtype: str = "uint8", channels: int = 3) -> Weave:
    """An endless texture that is quick to draw."""
    return weave(as_depth(texture(29, 31, channels, seed), dtype), Repeat(), seed)


class StorePromises:
    """What every :class:`intarsia.giant.picture.Store` promises; subclass it and say how one is made, and read.

    Attributes
    ----------
    sides : (height, width)
        Of the picture that is stored, px: several cells along both axes, the last ones smaller.
    origin : (y, x)
        Its first pixel on the endless plane.
    ending : str
        How the names of such stores end.
    """

    sides: ClassVar[tuple[int, int]] = (150, 170)
    origin: ClassVar[tuple[int, int]] = (3, -8)
    ending: ClassVar[str] = ""

    def make(self, picture: Weave, path: Path, force: bool = False) -> Store:
        """Plan a store of a picture at a place; ParameterError where it cannot hold such pixels."""
        raise NotImplementedError

    def read(self, path: Path) -> Array:
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
            stream(store, None, Run(1))
            shown = self.read(path)
            assert shown.dtype == picture.dtype
            assert (shown.reshape(*self.sides, -1) == self._window(picture).reshape(*self.sides, -1)).all()
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
        stream(store, None, Run(3))
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
        """Fill a store, and finish it; or stop before a cell. Return how many cells were drawn."""
        picture = endless(seed)
        store, drawn = self.make(picture, path, force), 0
        try:
            for number in list(store.open()):
                if drawn == stop:
                    return drawn
                cell = store.grid.cell(number)
                pixels = picture.draw(cell.box.moved(*self.origin))
                store.put(cell, store.packer(pixels.reshape(*pixels.shape[:2], -1), cell))
                drawn += 1
            if stop is None:
                store.finish(Run(1))
        finally:
            store.close()
        return drawn

    def _window(self, picture: Weave) -> Any:
        (y, x), (height, width) = self.origin, self.sides
        return picture.draw(Box(y, x, y + height, x + width))


class StoreContract(StorePromises):
    """What a :class:`intarsia.giant.picture.Store` promises that goes on where it was stopped, as `StorePromises`."""

    def test_a_new_store_misses_every_cell_a_whole_one_none(self, tmp_path: Path) -> None:
        """Rising; opened again and finished again it is the same in every byte."""
        store = self.make(endless(), tmp_path / "o")
        assert list(store.open()) == list(range(len(store.grid)))
        store.close()
        assert self._fill(tmp_path / "o") == len(store.grid)
        before = self.files(tmp_path / "o")
        assert self._fill(tmp_path / "o") == 0
        assert self.files(tmp_path / "o") == before

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

    def test_a_stop_in_the_middle_of_a_file_is_no_harm(self, tmp_path: Path) -> None:
        """What a kill leaves behind, a file cut short or of zeros, is made again; names and all other bytes stay."""
        self._fill(tmp_path / "o", 3)
        begun = self.files(tmp_path / "o")
        self._fill(tmp_path / "whole")
        whole = self.files(tmp_path / "whole")
        for name, data in begun.items():
            for left in (b"", data[: len(data) // 2], data[:-1], bytes(len(data))):
                self._put(tmp_path / "o", begun | {name: left})
                if self._go_on(tmp_path / "o", begun | {name: left}):
                    assert self.files(tmp_path / "o") == whole, name

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

    def test_another_picture_is_refused_not_mixed(self, tmp_path: Path) -> None:
        """With `force` it gives way as a whole."""
        self._fill(tmp_path / "o", 2)
        self._fill(tmp_path / "other", seed=1)
        before = self.files(tmp_path / "o")
        for attempt in ("look", "open"):
            store = self.make(endless(1), tmp_path / "o")
            with pytest.raises(IntarsiaError):
                getattr(store, attempt)()
            store.close()
            assert self.files(tmp_path / "o") == before
        self._fill(tmp_path / "o", seed=1, force=True)
        assert self.files(tmp_path / "o") == self.files(tmp_path / "other")

    def _go_on(self, path: Path, before: dict[str, bytes]) -> bool:
        """Fill a store that was damaged, with a second call where the first asks for it; False: it is refused."""
        for _ in range(2):
            try:
                self._fill(path)
                return True
            except IntarsiaError as e:
                if "the same command goes on" not in str(e):
                    break
        assert self.files(path) == before
        return False

    def _put(self, path: Path, files: dict[str, bytes]) -> None:
        """Make the files of a store these, and no others."""
        for name in self.files(path):
            Path(str(path) + name).unlink()
        for name, data in files.items():
            place = Path(str(path) + name)
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(data)
