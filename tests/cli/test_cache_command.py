"""Whole commands with a damaged, open or missing folder of compiled kernels; see test_cache.py for the parts."""

from __future__ import annotations

import json
import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from hostile import caches
from long import but_some

WORDS = [sys.executable, "-m", "intarsia", "grow", "sample:tiles", "-m", "repeat", "--size", "40", "--force"]


def grow(home: Path, out: Path, *more: str) -> subprocess.CompletedProcess[str]:
    around = {**os.environ, "INTARSIA_CACHE": str(home)}
    return subprocess.run([*WORDS, "-o", str(out), *more], env=around, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, bytes]:
    """A cache that two first runs at once have filled, and the picture of both."""
    folder = tmp_path_factory.mktemp("warm")
    around = {**os.environ, "INTARSIA_CACHE": str(folder / "c")}
    paths = [folder / "one.png", folder / "two.png"]
    both = [subprocess.Popen([*WORDS, "-q", "-o", str(path)], env=around) for path in paths]
    assert [work.wait() for work in both] == [0, 0]
    one, two = (path.read_bytes() for path in paths)
    assert one == two
    return folder / "c", one


def test_two_first_runs_at_once_leave_a_whole_cache(warm: tuple[Path, bytes], tmp_path: Path) -> None:
    home, right = warm
    done = grow(home, tmp_path / "o.png")
    assert (done.returncode, done.stderr.count("\n")) == (0, 1)  # nothing to tell of but the picture
    assert (tmp_path / "o.png").read_bytes() == right


@pytest.mark.parametrize("damage", but_some(["empty", "no cache", "a planted pickle"], "a planted pickle"))
def test_a_damaged_cache_is_made_anew_with_one_line(damage: str, warm: tuple[Path, bytes], tmp_path: Path) -> None:
    """The picture is right all the same, nothing of what lay there is opened, and the next run finds a whole cache."""
    home, out, trap = tmp_path / "c", tmp_path / "o.png", tmp_path / "sprung"
    shutil.copytree(warm[0], home)
    data = {"empty": b"", "no cache": b"\xff" * 999, "a planted pickle": pickle.dumps(caches.Planted(trap))}[damage]
    for path in caches.entries(home):
        path.write_bytes(data)
    done = grow(home, out, "--json")
    assert not trap.exists()
    assert done.returncode == 0, done.stderr
    assert out.read_bytes() == warm[1]
    (told,) = [line for line in done.stderr.splitlines() if "o.png" not in line]
    assert "was damaged; it is compiled anew" in told
    assert [told.endswith(w) for w in json.loads(done.stdout)["warnings"]] == [True]
    done = grow(home, out)
    assert (done.returncode, done.stderr.count("\n")) == (0, 1)
    assert out.read_bytes() == warm[1]


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="rights as of POSIX")
def test_a_folder_open_to_others_is_left_alone_and_told_of_in_one_line(tmp_path: Path) -> None:
    home = tmp_path / "open"
    home.mkdir()
    home.chmod(0o777)
    done = grow(home, tmp_path / "o.png")
    assert list(home.iterdir()) == []
    assert done.returncode == 0
    (told,) = [line for line in done.stderr.splitlines() if "o.png" not in line]
    assert "others may write to it" in told


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
def test_caches_damaged_at_random_end_in_the_right_picture(thorough: bool) -> None:
    words = [sys.executable, caches.__file__, "--plain", "--count", "12" if thorough else "3", "--seed", "7"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
