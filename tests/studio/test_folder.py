"""The studio removes nothing that it did not make, and nobody else reads what it keeps."""

from __future__ import annotations

import os
import sqlite3
import stat
import subprocess
from pathlib import Path

import numpy as np
import pytest
from studio.served import QUICK, pixels, png, run, studio

from intarsia.studio.store import Store

FOREIGN = ("images/holiday.jpg", "images/sub/a.png", "results/mygame/thesis.txt", "exemplars/wall/a.png", "notes.txt")


def foreign(folder: Path) -> None:
    """Files of somebody else, at places that the studio uses, too."""
    for name in FOREIGN:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(f"mine: {name}")
    (folder / "images" / "link").symlink_to(folder / "results")


def all_of(folder: Path) -> dict[str, bytes]:
    """Every file below a folder."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, bytes]:
    """A folder in which a studio made some of each, and its table while it was at work."""
    folder = tmp_path_factory.mktemp("filled") / "folder"
    with studio(folder) as served:
        exemplar = served.exemplar(wall=png(pixels()))["id"]
        served.post("/api/exemplars", {"sample": "tiles"}, 201)
        served.image(np.zeros((32, 36), np.uint8))
        served.done("grow", [exemplar], **QUICK)
        served.done("grow", [exemplar], **QUICK, seed=3)
        return folder, (folder / "studio.sqlite").read_bytes()


class TestNothingIsRemoved:
    @pytest.mark.parametrize("given", ["", "sub"])
    def test_a_folder_of_other_files_is_refused_and_stays(self, tmp_path: Path, given: str) -> None:
        folder = tmp_path / given
        foreign(folder)
        before = all_of(tmp_path)
        done = run("--folder", str(folder))
        assert done.returncode == 2
        assert len(done.stderr.strip().splitlines()) == 1
        assert "not the studio's" in done.stderr
        assert f"--folder {folder}/intarsia-studio" in done.stderr
        assert all_of(tmp_path) == before
        assert sorted(p.name for p in folder.iterdir()) == ["exemplars", "images", "notes.txt", "results"]
        with studio(folder / "intarsia-studio") as served:
            served.exemplar(wall=png(pixels()))
        assert {name: data for name, data in all_of(tmp_path).items() if "intarsia-studio" not in name} == before

    @pytest.mark.parametrize("table", [b"", b"no table", None], ids=["empty", "other", "of another program"])
    def test_a_table_of_another_program_makes_no_studio(self, tmp_path: Path, table: bytes | None) -> None:
        foreign(tmp_path)
        if table is None:
            with sqlite3.connect(tmp_path / "studio.sqlite") as rows:
                rows.execute("CREATE TABLE songs (name TEXT)")
            rows.close()
        else:
            (tmp_path / "studio.sqlite").write_bytes(table)
        before = all_of(tmp_path)
        assert run("--folder", str(tmp_path)).returncode == 2
        assert all_of(tmp_path) == before

    def test_other_files_in_its_own_folder_stay(self, tmp_path: Path) -> None:
        """Also where a name has the form of an id."""
        store = Store(tmp_path)
        foreign(tmp_path)
        for name in (f"results/{'ab' * 8}/x.png", f"images/{'cd' * 8}.png",
                     f"exemplars/{'ef' * 8}/x.png", "images/.under-way-mine/x.png"):  # fmt: skip
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text("mine")
        (tmp_path / "results" / f".under-way-{'0' * 16}").mkdir()
        before = all_of(tmp_path)
        before.pop("studio.sqlite")
        for kind, name in (("results", "mygame"), ("results", "ab" * 8), ("images", "cd" * 8), ("exemplars", "wall")):
            store.drop(kind, name)
        store.close()
        store = Store(tmp_path)
        assert not any(store.all(kind) for kind in ("exemplars", "images", "results", "jobs"))
        store.close()
        assert before.items() <= all_of(tmp_path).items()
        assert not (tmp_path / "results" / f".under-way-{'0' * 16}").exists()


class TestTheTable:
    def test_it_is_whole_while_the_studio_works(self, tmp_path: Path, filled: tuple[Path, bytes]) -> None:
        """A copy that takes the one file has every row."""
        (tmp_path / "studio.sqlite").write_bytes(filled[1])
        with sqlite3.connect(tmp_path / "studio.sqlite") as rows:
            counts = [rows.execute(f"SELECT count(*) FROM {kind}").fetchone()[0] for kind in ("exemplars", "jobs")]
        rows.close()
        assert counts == [2, 2]


def others_may(folder: Path) -> list[str]:
    """What other users could read, way and all."""
    top = [] if folder.stat().st_mode & 0o77 == 0 else [folder]
    inner = [folder / kind for kind in ("exemplars", "images", "results", "studio.sqlite")]
    return [str(path) for path in (*top, *inner) if path.stat().st_mode & 0o77]


def test_nobody_else_can_read_the_folder(filled: tuple[Path, bytes]) -> None:
    found = {str(p.relative_to(filled[0])): stat.S_IMODE(p.stat().st_mode) for p in (filled[0], *filled[0].rglob("*"))}
    assert len(found) > 10
    assert {name: mode for name, mode in found.items() if mode not in (0o700, 0o600)} == {}


def test_a_folder_that_others_could_read_is_closed_to_them(tmp_path: Path) -> None:
    Store(tmp_path).close()
    for path in (tmp_path, *tmp_path.rglob("*")):
        path.chmod(0o755 if path.is_dir() else 0o644)
    Store(tmp_path).close()
    assert others_may(tmp_path) == []


def test_a_table_that_is_damaged_is_told_of(tmp_path: Path) -> None:
    Store(tmp_path).close()
    (tmp_path / "studio.sqlite").write_bytes(b"SQLite format 3\0" + os.urandom(9000))
    done: subprocess.CompletedProcess[str] = run("--folder", str(tmp_path))
    assert done.returncode == 1
    assert len(done.stderr.strip().splitlines()) == 1
    assert "move studio.sqlite away" in done.stderr
