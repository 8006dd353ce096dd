"""The folder of compiled kernels: private, checked before it is loaded, healed where it is damaged."""

from __future__ import annotations

import os
import random
import shutil
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from hostile import caches

import intarsia.kernels as kept
import intarsia.kernels.compiling as compiling
from intarsia.kernels import HEADER, cache_folder
from intarsia.kernels.compiling import Kernel, KernelCache

posix = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners and rights as of POSIX")
root = pytest.mark.skipif(getattr(os, "geteuid", lambda: 1)() != 0, reason="only root can give files away")
not_root = pytest.mark.skipif(getattr(os, "geteuid", lambda: 0)() == 0, reason="root may write to all")


def twice(a: int) -> int:
    return a + a


def thrice(a: int) -> int:
    return a + a + a


@pytest.fixture(autouse=True)
def untroubled(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a process that has said nothing yet."""
    monkeypatch.setattr(kept, "_troubles", {})
    monkeypatch.setattr(kept, "_listeners", [])


def loaded(function: Callable[..., Any], folder: Path | None) -> Any:
    """Return a function as another process would find it: nothing of it compiled, the cache on disk."""
    compiled: Any = Kernel(function)
    compiled._cache = KernelCache(function, lambda: folder and str(folder))
    return compiled


def hits(function: Any) -> int:
    return int(sum(function.stats.cache_hits.values()))


def named(function: Any, folder: Path) -> tuple[str, bytes]:
    """File and identity of the one compiled form of a function."""
    found: tuple[str, bytes] = function._cache._entry(str(folder), function.signatures[0], function.targetctx.codegen())
    return found


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with one entry, of `twice`."""
    place = tmp_path / "kernels"
    place.mkdir(0o700)
    assert loaded(twice, place)(21) == 42
    assert len(list(place.iterdir())) == 1
    return place


def entry(folder: Path) -> Path:
    (found,) = folder.glob("*twice*.kernel")
    return found


def test_a_whole_entry_is_loaded_and_nothing_is_said(folder: Path) -> None:
    again = loaded(twice, folder)
    assert (again(21), hits(again)) == (42, 1)
    assert again(0.5) == 1.0  # other types are another entry
    assert hits(again) == 1
    assert len(list(folder.iterdir())) == 2


def of_another_kernel(path: Path, _: random.Random) -> None:
    loaded(thrice, path.parent)(21)
    (other,) = path.parent.glob("*thrice*.kernel")
    other.replace(path)


def of_another_build(path: Path, _: random.Random) -> None:
    function = loaded(twice, path.parent)
    function(21)
    kept.write_entry(*named(function, path.parent), b"of another build")


def link(path: Path, _: random.Random) -> None:
    path.symlink_to(path.rename(path.parent.parent / "whole"))


def fifo(path: Path, _: random.Random) -> None:
    path.unlink()
    os.mkfifo(path)


DAMAGES = {n: f for n, f in caches.ON_FILES.items() if n not in ("swapped", "gone", "unreadable", "link", "fifo")}
DAMAGES |= {"another kernel": of_another_kernel, "another build": of_another_build}
DAMAGES |= {"link": link, "fifo": fifo} if hasattr(os, "geteuid") else {}


@pytest.mark.parametrize("kind", sorted(DAMAGES))
def test_a_damaged_entry_is_compiled_anew_and_replaced_with_one_line(folder: Path, kind: str) -> None:
    """What is no plain file is neither followed nor waited for."""
    length = entry(folder).stat().st_size
    DAMAGES[kind](entry(folder), random.Random(5))
    again = loaded(twice, folder)
    with pytest.warns(RuntimeWarning, match="was damaged; it is compiled anew") as said:
        assert (again(21), hits(again)) == (42, 0)
    assert len(said) == 1
    assert str(folder) in str(said[0].message)
    assert entry(folder).is_file()
    assert not entry(folder).is_symlink()
    assert entry(folder).stat().st_size == pytest.approx(length, abs=200)
    healed = loaded(twice, folder)
    assert (healed(21), hits(healed)) == (42, 1)
    assert not (folder.parent / "sprung").exists()


def test_every_cut_and_every_flipped_byte_of_the_header_is_found(folder: Path) -> None:
    path, function = entry(folder), loaded(twice, folder)
    whole = path.read_bytes()
    function(21)
    name, identity = named(function, folder)
    assert name == str(path)
    assert kept.read_entry(name, identity) == whole[HEADER:]
    ends = len(whole) // 2, len(whole) - 1
    for cut in (*range(HEADER + 2), *ends):
        path.write_bytes(whole[:cut])
        with pytest.raises(kept.Unfit):
            kept.read_entry(name, identity)
    for place in (*range(HEADER + 1), *ends):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        with pytest.raises(kept.Unfit):
            kept.read_entry(name, identity)


def test_several_damaged_entries_are_told_of_once(folder: Path) -> None:
    loaded(thrice, folder)(1)
    for path in folder.iterdir():
        path.write_bytes(b"")
    said: list[str] = []
    kept.on_trouble(said.append)
    assert (loaded(twice, folder)(21), loaded(thrice, folder)(1)) == (42, 3)
    assert len(said) == 1
    late: list[str] = []
    kept.on_trouble(late.append)
    assert late == said


def test_what_cannot_be_kept_is_computed_all_the_same(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(compiling, "write_entry", full)
    with pytest.warns(RuntimeWarning, match=r"are not kept in .* \(no space left on device\)"):
        assert loaded(thrice, folder)(1) == 3
    assert loaded(thrice, None)(1) == 3


def test_a_stop_while_an_entry_is_written_leaves_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    before = sorted(folder.iterdir())
    monkeypatch.setattr(os, "replace", stop)
    with pytest.raises(KeyboardInterrupt):
        kept.write_entry(str(folder / "x.kernel"), b"x", b"y")
    assert sorted(folder.iterdir()) == before


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder for kernels that is not there yet, named by INTARSIA_CACHE."""
    monkeypatch.setenv("INTARSIA_CACHE", str(tmp_path / "home"))
    cache_folder.cache_clear()
    yield tmp_path / "home"
    cache_folder.cache_clear()


def resolved() -> Path:
    """The folder as another process would choose it."""
    cache_folder.cache_clear()
    found = cache_folder()
    assert found is not None
    return Path(found)


def refused(why: str) -> None:
    """No folder is used, and one line says why."""
    cache_folder.cache_clear()
    kept._troubles.clear()
    with pytest.warns(RuntimeWarning, match=why) as said:
        assert cache_folder() is None
    assert len(said) == 1
    assert "INTARSIA_CACHE" in str(said[0].message)


@posix
def test_the_folder_and_what_is_in_it_are_private(home: Path) -> None:
    before = os.umask(0)
    try:
        place = resolved()
        loaded(twice, place)(1)
    finally:
        os.umask(before)
    assert [p.stat().st_mode & 0o777 for p in (home, place, entry(place))] == [0o700, 0o700, 0o600]


@posix
def test_a_folder_that_others_may_write_to_is_not_used(home: Path) -> None:
    place = resolved()
    for path, mode in product((place, home), (0o777, 0o770, 0o702)):
        path.chmod(mode)
        refused("others may write to it")
        path.chmod(0o755)  # they may read
        assert resolved() == place
    home.chmod(0o1777)  # as of /tmp, where none can touch what is another's
    assert resolved() == place


@posix
@root
def test_the_folder_of_another_user_is_not_used(home: Path) -> None:
    place = resolved()
    for path in (place, home):
        os.chown(path, 65534, -1)
        refused("it belongs to another user")
        os.chown(path, 0, -1)


@posix
def test_a_link_or_a_file_in_place_of_the_folder_is_not_used(home: Path) -> None:
    place = resolved()
    place.rename(home / "moved")
    place.symlink_to("moved")
    refused("it is a link")
    place.unlink()
    place.write_bytes(b"")
    refused("file exists")
    shutil.rmtree(home)
    home.write_bytes(b"")
    refused("file exists|not a directory")


@posix
def test_what_an_earlier_release_left_open_is_closed(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("INTARSIA_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(home))
    own = home / "intarsia"
    own.mkdir(parents=True)
    own.chmod(0o775)
    assert resolved().parent == own
    assert own.stat().st_mode & 0o777 == 0o700


@posix
@not_root
def test_a_folder_that_is_read_only_is_loaded_from(home: Path) -> None:
    place = resolved()
    loaded(twice, place)(1)
    place.chmod(0o500)
    home.chmod(0o500)
    again = loaded(twice, resolved())
    assert (again(1), hits(again)) == (2, 1)
    home.chmod(0o700)


def test_the_folders_used_last_are_kept_and_nothing_that_is_not_ours_goes(home: Path) -> None:
    home.mkdir(0o700)
    old = [home / f"kernels-{k:016x}" for k in range(5)]
    for k, path in enumerate(old):
        path.mkdir(0o700)
        os.utime(path, (1000 + k, 1000 + k))
    (home / "kernels-of-mine").mkdir()
    place = resolved()
    assert {p.name for p in home.iterdir()} == {"kernels-of-mine", place.name, old[3].name, old[4].name}
    os.utime(place, (0, 0))
    assert resolved().stat().st_mtime > 1e9  # each use counts


def test_a_folder_that_another_process_took_away_is_made_again(folder: Path) -> None:
    shutil.rmtree(folder)
    again = loaded(twice, folder)
    assert (again(21), hits(again)) == (42, 0)
    assert entry(folder).is_file()
