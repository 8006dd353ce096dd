"""The studio removes nothing that it did not make, and finds what its table lost."""

from __future__ import annotations

import os
import shutil
import sqlite3
import stat
import subprocess
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from studio.served import QUICK, Served, pixels, png, run, studio

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


def images_of(folder: Path) -> set[str]:
    """The images that a studio at rest knows."""
    with closing(Store(folder)) as store:
        return {row["id"] for row in store.all("images")}


class Filled:
    """What a studio knew that opened, uploaded and made some of each, and its folder while it was at work."""

    def __init__(self, served: Served) -> None:
        exemplar = served.exemplar(wall=png(pixels()))["id"]
        served.post("/api/exemplars", {"sample": "tiles"}, 201)
        served.image(np.zeros((32, 36), np.uint8))
        served.done("grow", [exemplar], **QUICK)
        served.done("grow", [exemplar], **QUICK, seed=3)
        self.known = self.listed(served)
        self.files = all_of(served.folder)
        self.files.pop("studio.sqlite-journal", None)  # of a row that was being written just then

    def listed(self, served: Served) -> object:
        """What the page asks for at its start, but for the moments at which it was made."""
        jobs = [[job[key] for key in ("id", "state", "label", "began", "result")] for job in served.get("/api/jobs")]
        files = [served.get(f"/api/results/{job[-1]}")["files"] for job in jobs]
        return served.get("/api/exemplars"), jobs, files


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Filled]:
    """A folder in which a studio worked; to be copied."""
    folder = tmp_path_factory.mktemp("filled") / "folder"
    with studio(folder) as served:
        return folder, Filled(served)


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
        if table == b"":  # no rows at all are those of a studio whose log was lost
            Store(tmp_path).close()
            before["studio.sqlite"] = (tmp_path / "studio.sqlite").read_bytes()
            assert before.items() <= all_of(tmp_path).items()
        else:
            assert run("--folder", str(tmp_path)).returncode == 2
            assert all_of(tmp_path) == before

    def test_other_files_in_its_own_folder_stay(self, tmp_path: Path) -> None:
        """Also where a name has the form of an id, or a note lies beside what has not."""
        store = Store(tmp_path)
        foreign(tmp_path)
        for name in (f"results/{'ab' * 8}/x.png", "results/mygame/.told.json", f"images/{'cd' * 8}.png",
                     f"exemplars/{'ef' * 8}/x.png", "images/.under-way-mine/x.png"):  # fmt: skip
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text('{"id": "mygame", "job": "j", "made": 1.0}')
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
    @pytest.mark.parametrize("how", ["deleted", "old", "log", "sqlite alone"])
    def test_what_the_table_lost_is_found(self, tmp_path: Path, filled: tuple[Path, Filled], how: str) -> None:
        folder, before = tmp_path / "copy", filled[1]
        shutil.copytree(filled[0], folder, ignore=shutil.ignore_patterns(".lock"))
        kept = {name: data for name, data in all_of(folder).items() if name.startswith(("exem", "images", "results"))}
        (folder / "studio.sqlite").unlink()
        if how == "old":  # of the day before, when there was one exemplar more
            store = Store(tmp_path / "other")
            store.put("exemplars", {"id": "ee" * 8, "name": "old", "planes": []})
            store.close()
            shutil.copy(tmp_path / "other" / "studio.sqlite", folder)
        elif how == "log":
            (folder / "studio.sqlite-wal").write_bytes(b"what a log holds whose table is gone")
        elif how == "sqlite alone":  # a table of before, whose rows lay in a log that was not copied
            with sqlite3.connect(folder / "studio.sqlite") as rows:
                rows.execute("PRAGMA journal_mode=WAL")
            rows.close()
            (folder / ".intarsia-studio").unlink()
        with studio(folder) as served:
            assert before.listed(served) == before.known
        assert images_of(folder) == {name[7:23] for name in kept if name.endswith(".png") and name.startswith("images")}
        assert kept
        assert kept.items() <= all_of(folder).items()

    def test_it_is_whole_while_the_studio_works(self, tmp_path: Path, filled: tuple[Path, Filled]) -> None:
        """A copy that takes the one file has every row."""
        (tmp_path / "studio.sqlite").write_bytes(filled[1].files["studio.sqlite"])
        with sqlite3.connect(tmp_path / "studio.sqlite") as rows:
            counts = [rows.execute(f"SELECT count(*) FROM {kind}").fetchone()[0] for kind in ("exemplars", "jobs")]
        rows.close()
        assert counts == [2, 2]

    def test_a_folder_from_before_is_taken_over(self, tmp_path: Path, filled: tuple[Path, Filled]) -> None:
        """It had no marker, notes beside results alone, no folder for a sample, and could be read by all."""
        folder, before = tmp_path / "folder", filled[1]
        shutil.copytree(filled[0], folder)
        (folder / ".intarsia-studio").unlink()
        for note in [*folder.glob("exemplars/*/.told.json"), *folder.glob("images/*.told.json")]:
            note.unlink()
        for place in folder.glob("exemplars/*"):
            if not list(place.iterdir()):
                place.rmdir()
        assert len(list(folder.glob("exemplars/*"))) == 1
        for path in (folder, *folder.rglob("*")):
            path.chmod(0o755 if path.is_dir() else 0o644)
        for _ in range(2):
            with studio(folder) as served:
                assert before.listed(served) == before.known
            assert all_of(folder).keys() >= before.files.keys() - {".authorization"}
            assert not others_may(folder)
            (folder / "studio.sqlite").unlink()


def others_may(folder: Path) -> list[str]:
    """What other users could read, way and all."""
    top = [] if folder.stat().st_mode & 0o77 == 0 else [folder]
    inner = [folder / kind for kind in ("exemplars", "images", "results", "studio.sqlite")]
    return [str(path) for path in (*top, *inner) if path.stat().st_mode & 0o77]


def test_nobody_else_can_read_the_folder(filled: tuple[Path, Filled]) -> None:
    found = {str(p.relative_to(filled[0])): stat.S_IMODE(p.stat().st_mode) for p in (filled[0], *filled[0].rglob("*"))}
    assert len(found) > 10
    assert {name: mode for name, mode in found.items() if mode not in (0o700, 0o600)} == {}


def test_a_shared_folder_from_before_stays_open_but_for_what_is_the_studios(tmp_path: Path) -> None:
    Store(tmp_path).close()
    (tmp_path / "notes.txt").write_text("of the whole team")
    tmp_path.chmod(0o755)
    (tmp_path / "results").chmod(0o755)
    Store(tmp_path).close()
    assert tmp_path.stat().st_mode & 0o77 == 0o55
    assert others_may(tmp_path) == [str(tmp_path)]


def test_a_table_that_is_damaged_is_told_of(tmp_path: Path) -> None:
    Store(tmp_path).close()
    (tmp_path / "studio.sqlite").write_bytes(b"SQLite format 3\0" + os.urandom(9000))
    done: subprocess.CompletedProcess[str] = run("--folder", str(tmp_path))
    assert done.returncode == 1
    assert len(done.stderr.strip().splitlines()) == 1
    assert "move studio.sqlite away" in done.stderr
