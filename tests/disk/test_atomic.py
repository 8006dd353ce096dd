"""Temporary files: nothing of a killed run stays, nothing of a living one is touched, and no link is followed."""

from __future__ import annotations

import os
import signal
import tempfile
from collections.abc import Callable
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from cli.commands import full_disk, run
from corpus import pillow

import intarsia as ia
from intarsia.disk import atomic
from intarsia.files import formats, read_plane, write
from intarsia.foundation import InputError, ParameterError
from intarsia.testing import texture

PICTURE = texture(20, 24, 3, 1)

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork, and the signals of such systems")


@pytest.fixture(autouse=True)
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty TMPDIR, and an empty folder for the work."""
    made = tmp_path / "tmp"
    made.mkdir()
    (tmp_path / "work").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(made))
    monkeypatch.chdir(tmp_path / "work")
    return made


def started(work: Callable[[], object]) -> int:
    """Do something in a process of its own; return how it ended."""
    pid = os.fork()
    if pid == 0:
        code = 1
        try:
            work()
            code = 0
        finally:
            os._exit(code)
    return os.waitpid(pid, 0)[1]


def die(*_: object, **__: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def test_what_a_killed_run_left_is_gone_after_the_next(temporary: Path) -> None:
    """Beside the output, below TMPDIR, and the folder of a command with its files."""

    def half_a_picture() -> None:
        os.replace = die  # type: ignore[assignment]
        write("a.tif", PICTURE)

    def a_copy() -> None:
        with formats.open_picture(pillow("png", PICTURE)).plain_path():
            die()

    write("b.png", PICTURE)
    assert os.WIFSIGNALED(started(half_a_picture))
    assert os.WIFSIGNALED(started(a_copy))
    assert len(os.listdir()) == 2, "a file was left beside the output"
    assert len(os.listdir(temporary)) == 1, "a folder was left"
    assert started(lambda: write("a.tif", PICTURE)) == 0
    assert sorted(os.listdir()) == ["a.tif", "b.png"]
    assert os.listdir(temporary) == []
    started(lambda: (setattr(os, "replace", die), run("grow b.png -m repeat -o c.png")))
    assert len(os.listdir()) == 3
    started(lambda: run("grow b.png -m repeat -o d.png"))
    assert sorted(os.listdir()) == ["a.tif", "b.png", "d.png"]


def test_only_what_is_exactly_ours_and_dead_is_swept(temporary: Path) -> None:
    pid = os.fork()
    if pid == 0:
        os._exit(0)
    os.waitpid(pid, 0)  # there was such a process
    dead = atomic.temporary_name(".").replace(f"-{os.getpid()}-", f"-{pid}-")
    other = dead.replace(atomic.host(), "0" * 8)
    kept = [atomic.temporary_name("."), f"./.intarsia-{pid}-1", f"{dead}.txt", f"{dead}0", other,
            dead.replace("/.", "/x"), dead.replace(f"-{pid}-", f"-{os.getppid()}-"),
            dead.replace("/.", "/")]  # fmt: skip
    for name in kept:
        Path(name).write_text("work")
    Path("victim").mkdir()
    Path("victim/thesis").write_text("years")
    link, folder, pipe = dead[:-1] + "0", dead[:-1] + "1", dead[:-1] + "2"
    os.symlink("victim", link)
    os.mkfifo(pipe)
    os.mkdir(folder)
    os.symlink("../victim", f"{folder}/inside")
    Path(dead[:-1] + "3").write_text("half a picture")
    atomic.sweep(".")
    left = {os.path.join(".", name) for name in os.listdir()}
    assert left == {*kept, "./victim", link, pipe}
    assert Path("victim/thesis").read_text() == "years"


def test_what_belongs_to_others_is_not_swept(monkeypatch: pytest.MonkeyPatch) -> None:
    name = atomic.temporary_name(".").replace(f"-{os.getpid()}-", "-999999999-")
    Path(name).write_text("work")
    monkeypatch.setattr(os, "getuid", lambda: os.geteuid() + 1)
    assert not atomic.is_left_over(name)


@pytest.mark.parametrize("work", ["encode", "plain_path", "command"])
def test_a_stop_right_after_a_folder_was_made_leaves_none(
    work: str, temporary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write("a.png", PICTURE)
    mkdir = os.mkdir

    def made_and_stopped(*given: object, **more: object) -> None:
        mkdir(*given, **more)  # type: ignore[arg-type]
        if ".intarsia-" in str(given[0]) or work != "command":
            raise KeyboardInterrupt

    monkeypatch.setattr(os, "mkdir", made_and_stopped)
    if work == "command":
        run("grow", "a.png", "-o", "b.png", "-m", "repeat", code=130)
    else:
        with pytest.raises(KeyboardInterrupt):
            write("b.tif", PICTURE) if work == "encode" else read_plane(pillow("tiff", PICTURE))
    assert os.listdir(temporary) == []
    assert os.listdir() == ["a.png"]


def test_a_planted_link_is_neither_followed_nor_replaced() -> None:
    Path("victim").write_text("work")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("os.urandom", lambda n: b"U" * n)
        planted = atomic.temporary_name(".")
        os.symlink("victim", planted)
        with pytest.raises(FileExistsError):
            atomic.write_new(planted, b"mine")
        with pytest.raises(FileExistsError):
            atomic.replace_file("a.txt", b"mine")
    assert Path("victim").read_text() == "work"
    os.symlink("victim", "a.txt")
    os.mkfifo("pipe")
    for name in ("a.txt", "pipe"):
        with pytest.raises(ParameterError, match="no ordinary file; move it elsewhere"):
            atomic.replace_file(name, b"mine")
        with pytest.raises(ParameterError):
            atomic.open_regular(name)
    assert Path("victim").read_text() == "work"
    assert Path("a.txt").is_symlink()
    assert Path("pipe").is_fifo()


def test_a_full_disk_is_told_by_the_name_that_was_asked_for(tmp_path: Path) -> None:
    (tmp_path / "full").mkdir()
    write("a.png", PICTURE)
    for words in ("../full/x.bmp", "../full/x.bmp --save-map ../full/x.npz"):
        with full_disk(8000):
            done = run(f"grow a.png -m repeat -s 90 -o {words}", code=1)
        assert "there is no room for ../full/x.bmp; free some" in done.stderr
        assert os.listdir(tmp_path / "full") == []


def test_a_map_that_may_not_be_read_is_no_damaged_map(monkeypatch: pytest.MonkeyPatch) -> None:
    ia.synthesize(PICTURE, 30, ia.Repeat()).map.save("map.npz")
    monkeypatch.setattr("builtins.open", Mock(side_effect=PermissionError(13, "Permission denied")))
    with pytest.raises(InputError, match=r"map\.npz cannot be read \(permission denied\); check the permissions"):
        ia.SourceMap.load("map.npz")


def test_pictures_replace_what_a_link_leads_to() -> None:
    """A link that the user names as the output is his wish: the file behind it is replaced."""
    write("real.png", PICTURE)
    os.symlink("real.png", "link.png")
    write("link.png", PICTURE // 2, force=True)
    assert Path("link.png").is_symlink()
    np.testing.assert_array_equal(read_plane("real.png").pixels, PICTURE // 2)
