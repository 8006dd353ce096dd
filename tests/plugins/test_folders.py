"""Temporary folders of plug-ins: removed at the end, and at the next call where a host was killed."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from intarsia.plugins.hosts import calling

KEEPS = "import sys; from intarsia.plugins.hosts.calling import Folder; f = Folder(); print(f.name, flush=True); "


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    return tmp_path


def other_host() -> tuple[subprocess.Popen[str], Path]:
    host = subprocess.Popen(
        [sys.executable, "-c", KEEPS + "sys.stdin.read()"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert host.stdout is not None
    return host, Path(host.stdout.readline().strip())


def aged(folder: Path, seconds: float) -> None:
    then = time.time() - seconds
    os.utime(folder, (then, then))


def test_it_goes_at_the_end(here: Path) -> None:
    with calling.Folder() as name:
        Path(name, "layer1.tif").write_bytes(b"x")
    assert list(here.iterdir()) == []


@pytest.mark.skipif(calling.fcntl is None, reason="no locks of folders here")
def test_what_a_killed_host_left_goes_at_the_next_call(here: Path) -> None:
    host, left = other_host()
    aged(left, 2 * calling.MADE)
    with calling.Folder():
        assert left.exists()  # its host lives
    host.kill()
    host.communicate()
    (left / "layer1.tif").write_bytes(b"x")
    aged(left, 2 * calling.MADE)
    with calling.Folder():
        assert not left.exists()


def test_without_locks_it_goes_after_a_day(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calling, "fcntl", None)
    left = here / f"{calling.Folder.MARK}x"
    left.mkdir()
    aged(left, calling.DAY / 2)
    with calling.Folder():
        assert left.exists()
    aged(left, calling.DAY + 60)
    with calling.Folder():
        assert not left.exists()
