"""The folder of compiled kernels: private, told of where it cannot be used, and pruned."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import pytest

import intarsia.kernels as kept
from intarsia.kernels import cache_folder

posix = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners and rights as of POSIX")
root = pytest.mark.skipif(getattr(os, "geteuid", lambda: 1)() != 0, reason="only root can give files away")
not_root = pytest.mark.skipif(getattr(os, "geteuid", lambda: 0)() == 0, reason="root may write to all")


@pytest.fixture(autouse=True)
def untroubled(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a process that has said nothing yet."""
    monkeypatch.setattr(kept, "_troubles", [])
    monkeypatch.setattr(kept, "_listeners", [])


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
def test_the_folder_is_private(home: Path) -> None:
    before = os.umask(0)
    try:
        place = resolved()
    finally:
        os.umask(before)
    assert [p.stat().st_mode & 0o777 for p in (home, place)] == [0o700, 0o700]


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
def test_a_folder_that_is_read_only_is_told_of(home: Path) -> None:
    place = resolved()
    place.chmod(0o500)
    refused("permission denied")
    place.chmod(0o700)


def test_a_full_disk_is_told_of_once_also_to_who_listens_later(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(kept.tempfile, "TemporaryFile", full)
    cache_folder.cache_clear()
    said: list[str] = []
    kept.on_trouble(said.append)
    assert cache_folder() is None
    assert cache_folder() is None
    (line,) = said
    assert "(no space left on device)" in line
    late: list[str] = []
    kept.on_trouble(late.append)
    assert late == said


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
