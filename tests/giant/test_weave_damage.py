"""Stores after a loss of power, and beside what is not theirs: the work goes on, and nothing else is ever removed."""

from __future__ import annotations

import os
import re
import shutil
import stat
from pathlib import Path
from typing import Any

import pytest
from giant.giants import files_below, needs, small
from giant.test_weave import SIDES, drawn
from long import going_round

import intarsia as ia
from intarsia.errors import IntarsiaError, ParameterError
from intarsia.giant import bigtiff, deepzoom, zarrays


@pytest.fixture(autouse=True)
def cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small cells, so that a small picture has several."""
    needs("zarr")
    for module in (zarrays, deepzoom):
        monkeypatch.setattr(module, "SIDE", 64)
    monkeypatch.setattr(bigtiff, "AREA", 64 * 64)


def ledger_of(how: str, path: Path) -> Path:
    return path.with_name(path.name + ".ledger") if how == "tiff" else path / "weave.ledger"


def begun(how: str, path: Path, cells: int) -> None:
    """A store that was stopped after so many cells."""
    store, left = ia.giant.stream.store_of(how, small(), path, (170, 150), (3, -8), SIDES[how], False), [cells]
    put = store.put

    def some(cell: Any, pieces: list[bytes]) -> None:
        if not left[0]:
            raise KeyboardInterrupt
        left[0] -= 1
        put(cell, pieces)

    store.put = some  # type: ignore[method-assign]
    with pytest.raises(KeyboardInterrupt):
        ia.giant.stream.stream(store, None, ia.Run(1))


LOST = {
    "empty": lambda data, at: b"",
    "zeros": lambda data, at: bytes(len(data)),
    "garbage": lambda data, at: bytes((7 * n + 131) % 256 for n in range(len(data))),
    "cut in the first line": lambda data, at: data[: at // 2],
    "cut behind the first line": lambda data, at: data[:at],
    "cut at its end": lambda data, at: data[: at - 1],
    "cut in a further line": lambda data, at: data[: (len(data) + at) // 2],
    "first line missing": lambda data, at: data[at:],
    "first line of zeros": lambda data, at: bytes(at) + data[at:],
    "zeros behind": lambda data, at: data[: len(data) // 2] + bytes(len(data) - len(data) // 2),
}
"""What a loss of power makes of a ledger whose first line is `at` bytes long."""


@pytest.mark.parametrize(("lost", "how"), going_round([*LOST], [*SIDES]))
def test_a_lost_ledger_is_made_again(lost: str, how: str, tmp_path: Path) -> None:
    """Of a finished store, and of one under way: the same call goes on, and all bytes are those of one never harmed."""
    cells = drawn(how, tmp_path / "whole")
    sound = files_below(tmp_path / "whole")
    drawn(how, tmp_path / "done")
    begun(how, tmp_path / "some", 3)
    for name, missing in (("done", 0), ("some", cells - 3)):
        path = tmp_path / name
        ledger = ledger_of(how, path)
        data = ledger.read_bytes()
        ledger.write_bytes(LOST[lost](data, data.index(b"\n") + 1))
        again = drawn(how, path)
        if lost.startswith("first"):  # pieces that were written down are only looked at
            assert again == missing
        assert files_below(path) == sound


@pytest.mark.parametrize("how", SIDES)
def test_a_lost_ledger_does_not_let_another_recipe_in(how: str, tmp_path: Path) -> None:
    for cells in (2, 99):
        path = tmp_path / str(cells)
        begun(how, path, cells) if cells == 2 else drawn(how, path)
        ledger_of(how, path).write_bytes(b"")
        before = files_below(path)
        with pytest.raises(ParameterError):
            drawn(how, path, seed=6)
        assert files_below(path) == before
        assert drawn(how, path, force=True, seed=6) > 0


@pytest.mark.parametrize("how", SIDES)
def test_where_no_recipe_is_left_nothing_is_advised_that_destroys(how: str, tmp_path: Path) -> None:
    begun(how, tmp_path / "o", 2)
    ledger_of(how, tmp_path / "o").write_bytes(b"\0" * 99)
    second = tmp_path / {"tiff": "o.header", "zarr": "o/zarr.json"}.get(how, "o/weave.header")
    second.write_bytes(b"")
    before = files_below(tmp_path / "o")
    with pytest.raises(IntarsiaError, match="cannot be read any more; name another place") as caught:
        drawn(how, tmp_path / "o")
    assert not re.search("force|remove|delete|replace", str(caught.value))
    assert files_below(tmp_path / "o") == before


@pytest.mark.parametrize("how", SIDES)
def test_what_is_not_made_again_is_on_the_disk(how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Content before name: a file is synced, renamed, and the folder synced, before anything else is done."""
    done: list[tuple[str, str]] = []
    fsync, replace = os.fsync, os.replace
    monkeypatch.setattr(os, "fsync", lambda n: (done.append(("sync", os.readlink(f"/proc/self/fd/{n}"))), fsync(n))[1])
    monkeypatch.setattr(os, "replace", lambda a, b: (done.append((os.fspath(a), os.fspath(b))), replace(a, b))[1])
    drawn(how, tmp_path / "o")
    second = {"tiff": "o.header", "zarr": "o/zarr.json"}.get(how, "o/weave.header")
    names = [str(tmp_path / second), str(ledger_of(how, tmp_path / "o"))]
    if how == "tiff":
        names.append(str(tmp_path / "o"))
    for name in names:
        moves = [n for n, (_, b) in enumerate(done) if b == name]
        assert moves, name
        for n in moves:
            assert ("sync", done[n][0]) in done[:n], name
            assert ("sync", os.path.dirname(name)) in done[n : n + 2], name
    first = [min(n for n, (_, b) in enumerate(done) if b == name) for name in names]
    assert first == sorted(first), "the second place is written before the ledger"


OTHERS = ("src/a.c", "diary.txt", "c/notes.txt", "c/0/x", "c/01/2", "c/1/2.bak", "image_files/1/0_0.png.bak", ".hidden",
          "image_files/photo.png", "weave.ledger.old", ".intarsia-draft", "photos/")  # fmt: skip


@pytest.mark.parametrize("ledger", ["sound", b"", b"buy milk\n"])
@pytest.mark.parametrize("how", ["zarr", "tiles"])
def test_force_removes_nothing_that_was_not_woven(how: str, ledger: Any, tmp_path: Path) -> None:
    """Whatever else is there, it is named, and everything stays as it was; without it, the store gives way."""
    path = tmp_path / "o"
    drawn(how, path)
    if ledger != "sound":
        (path / "weave.ledger").write_bytes(ledger)
    for name in OTHERS:
        other = path / name
        new = next(p for p in (*reversed(other.relative_to(path).parents[:-1]), Path(name)) if not (path / p).exists())
        other.parent.mkdir(parents=True, exist_ok=True)
        other.mkdir() if name.endswith("/") else other.write_text("years of work")
        before = files_below(path)
        with pytest.raises(ParameterError, match=r"o holds .*, which was not woven; move it elsewhere, or name"):
            drawn(how, path, force=True, seed=6)
        assert files_below(path) == before
        assert other.exists()
        shutil.rmtree(path / new) if (path / new).is_dir() else (path / new).unlink()
    drawn(how, path, force=True, seed=6)
    drawn(how, tmp_path / "other", seed=6)
    assert files_below(path) == files_below(tmp_path / "other")


def test_a_file_called_as_a_ledger_makes_no_store(tmp_path: Path) -> None:
    (tmp_path / "proj" / "src").mkdir(parents=True)
    (tmp_path / "proj" / "src" / "a.c").write_text("code")
    (tmp_path / "proj" / "weave.ledger").write_text("x\n")
    with pytest.raises(ParameterError, match="proj holds src, which was not woven"):
        small().to_tiles(tmp_path / "proj", 64, force=True)
    assert (tmp_path / "proj" / "src" / "a.c").read_text() == "code"
    (tmp_path / "array").mkdir()
    (tmp_path / "array" / "zarr.json").write_text('{"zarr_format": 3, "attributes": {"of": "somebody"}}')
    (tmp_path / "array" / "weave.ledger").write_text("")
    with pytest.raises(ParameterError, match=r"array holds zarr\.json, which was not woven"):
        small().to_zarr(tmp_path / "array", 64, force=True)
    assert "somebody" in (tmp_path / "array" / "zarr.json").read_text()


@pytest.mark.parametrize("what", ["fifo", "link", "dangling", "folder"])
@pytest.mark.parametrize("ending", ["", ".ledger", ".part", ".header"])
def test_a_tiff_never_takes_the_place_of_what_is_no_file(ending: str, what: str, tmp_path: Path) -> None:
    """A pipe, a link or a folder where a file of the weave belongs is refused, with force, too."""
    (tmp_path / "victim").write_text("work")
    place = tmp_path / f"o.tif{ending}"
    if what == "fifo":
        os.mkfifo(place)
    elif what == "folder":
        place.mkdir()
    else:
        place.symlink_to(tmp_path / ("victim" if what == "link" else "nowhere"))
    before = place.lstat()
    for force in (False, True):
        with pytest.raises(ParameterError, match=r"o\.tif\S* is a (pipe|link|folder).*, no ordinary file"):
            small().to_tiff(tmp_path / "o.tif", 64, force=force)
    assert stat.S_IFMT(place.lstat().st_mode) == stat.S_IFMT(before.st_mode)
    assert place.lstat().st_ino == before.st_ino
    assert (tmp_path / "victim").read_text() == "work"
    assert not (tmp_path / "nowhere").exists()


@pytest.mark.parametrize("where", ["c", "c/0", "c/0/0", "zarr.json", "weave.ledger"])
def test_no_link_in_a_store_is_followed(where: str, tmp_path: Path) -> None:
    """A store may be a link itself, which somebody made; what lies in it is never one."""
    drawn("zarr", tmp_path / "o")
    inside, away = tmp_path / "o" / where, tmp_path / "away"
    inside.rename(away)
    inside.symlink_to(away)
    before = files_below(away) | {"": away.read_bytes()} if away.is_file() else files_below(away)
    for force in (False, True):
        with pytest.raises(ParameterError, match="elsewhere, or name another place"):
            drawn("zarr", tmp_path / "o", force, seed=6 if force else 5)
    assert inside.is_symlink()
    assert before == (files_below(away) | {"": away.read_bytes()} if away.is_file() else files_below(away))


def test_a_link_with_a_guessed_name_is_not_written_through(tmp_path: Path) -> None:
    (tmp_path / "victim").write_text("work")
    for n in range(3000):
        (tmp_path / f".intarsia-{os.getpid()}-{n}").symlink_to(tmp_path / "victim")
    small().to_tiff(tmp_path / "o.tif", 64)
    assert (tmp_path / "victim").read_text() == "work"
    assert not (tmp_path / "o.tif.ledger").is_symlink()


def test_a_whole_file_that_is_mended_does_not_bear_its_name_meanwhile(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "o.tif"
    small().to_tiff(path, 200, tile=32)
    sound = files_below(path)
    data = bytearray(path.read_bytes())
    data[len(data) // 3] ^= 255
    path.write_bytes(data)
    put, seen = bigtiff.TiffStore.put, []
    monkeypatch.setattr(bigtiff.TiffStore, "put", lambda s, *a: (seen.append(path.exists()), put(s, *a))[1])
    small().to_tiff(path, 200, tile=32)
    assert seen == [False] * len(seen)
    assert files_below(path) == sound
