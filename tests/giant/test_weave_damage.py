"""Stores after a loss of power, and beside what is not theirs: the work goes on, and nothing else is ever removed."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import pytest
from giant.giants import SMALL, files_below, needs

import intarsia as ia
from intarsia.foundation import InputError, IntarsiaError, ParameterError
from intarsia.giant import exports, zarrays
from intarsia.giant.picture import Results
from intarsia.giant.stream import stream
from intarsia.testing import texture

STORES = {"zarr": zarrays.ZarrStore, "tiff": exports.TiffStore}


@pytest.fixture(autouse=True)
def cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small cells, so that a small picture has several."""
    needs("zarr")
    for module in (zarrays, exports):
        monkeypatch.setattr(module, "SIDE", 64)
    monkeypatch.setattr(exports, "AREA", 64 * 64)


def drawn(path: Path, force: bool = False, seed: int = 5, how: str = "zarr", stop: int | None = None) -> int:
    """Weave, or as many cells as a stop leaves time for, and return how many were drawn."""
    woven = ia.weave(texture(80, 77, 3, 1), SMALL, seed)
    store, counted = STORES[how].of(woven, path, (170, 150), (3, -8), 32, force), list[int]()
    fill = store.fill

    def some(results: Results) -> Results:
        for result in results:
            if len(counted) == stop:
                raise KeyboardInterrupt
            counted.append(result[0].number)
            yield result

    store.fill = lambda results, run: fill(some(results), run)  # type: ignore[method-assign]
    try:
        stream(store, None, ia.Run(1))
    except KeyboardInterrupt:
        assert stop is not None
    return len(counted)


def test_damaged_pieces_are_found_and_made_again(tmp_path: Path) -> None:
    """Bytes that were turned over, files that were cut, emptied or removed; nothing else is drawn again."""
    path = tmp_path / "o"
    assert drawn(path) == 9
    sound = files_below(path)
    assert drawn(path) == 0
    data = [path / name.lstrip("/") for name in sorted(sound) if not name.endswith(".json")]
    for target in data[4::3]:
        whole = target.read_bytes()
        for left in (None, b"", whole[: len(whole) // 3], bytes(len(whole)), bytes([*whole[:99], whole[99] ^ 1])):
            target.unlink() if left is None else target.write_bytes(left)
            assert drawn(path) == 1
            assert files_below(path) == sound


def test_another_recipe_is_refused_not_mixed(tmp_path: Path) -> None:
    """Finished or not, with force, too: it is named in what it differs, and stays as it is."""
    for name, stop in (("done", None), ("some", 3)):
        path = tmp_path / name
        drawn(path, stop=stop)
        before = files_below(path)
        for force in (False, True):
            with pytest.raises(ParameterError, match=rf"{name} holds another recipe \(seed\); name another place, or "):
                drawn(path, force, seed=6)
        woven = ia.weave(texture(80, 77, 3, 1), SMALL, 5)
        with pytest.raises(ParameterError, match=r"holds another recipe \(chunk\)"):
            woven.to_zarr(path, (170, 150), origin=(3, -8), chunk=64)
        assert files_below(path) == before
        assert drawn(path) == (0 if stop is None else 6)


def test_where_no_recipe_is_left_nothing_is_advised_that_destroys(tmp_path: Path) -> None:
    """Nobody can say whose it is: it is refused with force, too, and stays as it is."""
    drawn(tmp_path / "o", stop=2)
    for left in (b"", b"\0" * 99, b"[" * 9999, b"{\"zarr_format\": 3"):
        (tmp_path / "o" / "zarr.json").write_bytes(left)
        before = files_below(tmp_path / "o")
        for force in (False, True):
            with pytest.raises(InputError, match="cannot be read any more; name another place") as caught:
                drawn(tmp_path / "o", force)
            assert not re.search("force|remove|delete|replace", str(caught.value))
        assert files_below(tmp_path / "o") == before


@pytest.mark.parametrize(("how", "name"), [("zarr", "o/zarr.json"), ("tiff", "o")])
def test_what_is_not_made_again_is_on_the_disk(
    how: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Content before name: a file is synced, renamed, and the folder synced, before anything else is done."""
    done: list[tuple[str, str]] = []
    fsync, replace = os.fsync, os.replace
    monkeypatch.setattr(os, "fsync", lambda n: (done.append(("sync", os.readlink(f"/proc/self/fd/{n}"))), fsync(n))[1])
    monkeypatch.setattr(os, "replace", lambda a, b: (done.append((os.fspath(a), os.fspath(b))), replace(a, b))[1])
    drawn(tmp_path / "o", how=how)
    named = str(tmp_path / name)
    (moved,) = (n for n, (_, b) in enumerate(done) if b == named)
    assert ("sync", done[moved][0]) in done[:moved]
    assert done[moved + 1] == ("sync", os.path.dirname(named))
    assert moved < 3 or how == "tiff", "the recipe comes first"


@pytest.mark.parametrize("text", ['{"zarr_format": 3, "attributes": {"of": "somebody"}}', "[]"])
def test_what_somebody_else_made_in_the_same_format_is_no_store(text: str, tmp_path: Path) -> None:
    """An array without our recipe stays, with force, too."""
    (tmp_path / "o").mkdir()
    (tmp_path / "o" / "zarr.json").write_text(text)
    for force in (False, True):
        with pytest.raises(ParameterError, match="o exists, and is no texture that was woven; name another place"):
            drawn(tmp_path / "o", force)
    assert (tmp_path / "o" / "zarr.json").read_text() == text


@pytest.mark.parametrize("what", ["fifo", "folder"])
def test_a_tiff_never_takes_the_place_of_what_is_no_file(what: str, tmp_path: Path) -> None:
    place = tmp_path / "o.tif"
    os.mkfifo(place) if what == "fifo" else place.mkdir()
    before = place.lstat()
    for force in (False, True):
        with pytest.raises(ParameterError, match=r"o\.tif is (no ordinary file|a folder)"):
            drawn(place, force, how="tiff")
    assert (place.lstat().st_mode, place.lstat().st_ino) == (before.st_mode, before.st_ino)
    assert [p.name for p in tmp_path.iterdir()] == ["o.tif"]


@pytest.mark.parametrize("where", ["c", "c/0", "c/0/0", "zarr.json"])
def test_no_link_in_a_store_is_followed(where: str, tmp_path: Path) -> None:
    """A store may be a link itself, which somebody made; what lies in it is never one."""
    drawn(tmp_path / "o")
    inside, away = tmp_path / "o" / where, tmp_path / "away"
    inside.rename(away)
    inside.symlink_to(away)
    before = files_below(away) | {"": away.read_bytes()} if away.is_file() else files_below(away)
    for force in (False, True):
        with pytest.raises(ParameterError, match="elsewhere, or name another place"):
            drawn(tmp_path / "o", force)
    assert inside.is_symlink()
    assert before == (files_below(away) | {"": away.read_bytes()} if away.is_file() else files_below(away))


@pytest.mark.parametrize("how", ["zarr", "tiff"])
def test_a_link_to_a_place_is_woven_through(how: str, tmp_path: Path) -> None:
    """What it leads to is made, and a file is replaced with force; the link stays one."""
    (tmp_path / "far").mkdir()
    link: Any = tmp_path / "o"
    link.symlink_to(tmp_path / "far" / "store")
    if how != "tiff":
        (tmp_path / "far" / "store").mkdir()
    for seed, force in ((5, False), (6, True))[: 1 if how == "zarr" else 2]:
        assert drawn(link, force, seed=seed, how=how)
        drawn(tmp_path / f"plain{seed}", seed=seed, how=how)
        assert link.is_symlink()
        assert files_below(tmp_path / "far" / "store") == files_below(tmp_path / f"plain{seed}")
    assert os.listdir(tmp_path / "far") == ["store"]


@pytest.mark.parametrize("how", ["zarr", "tiff"])
def test_a_full_disk_is_told_in_one_line(how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(
        "intarsia.disk.atomic.sync_file" if how == "tiff" else "intarsia.disk.atomic.write_new", full
    )
    with pytest.raises(IntarsiaError, match=r"no room for .*o; free some space, or name another folder"):
        drawn(tmp_path / "o", how=how)
    assert not list(tmp_path.iterdir())
