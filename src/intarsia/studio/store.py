"""The project folder: exemplars, images, results as files named by content, and the table of them and of jobs."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import sqlite3
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..errors import ResourceError

Row = dict[str, Any]

KINDS = ("exemplars", "images", "jobs", "results")
HIDDEN = ".under-way-"
TOLD = ".told.json"
"""What a result's folder tells of itself, so that a result without a row is found again."""

OPEN = ("queued", "running")


class Store:
    """Files below a folder, and rows in its `studio.sqlite`."""

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder).absolute()
        try:
            for name in ("exemplars", "images", "results"):
                (self.folder / name).mkdir(parents=True, exist_ok=True)
            self._rows = sqlite3.connect(self.folder / "studio.sqlite", isolation_level=None, check_same_thread=False)
            self._rows.execute("PRAGMA journal_mode=WAL")
            for kind in KINDS:
                columns = "number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT UNIQUE NOT NULL, about TEXT NOT NULL"
                self._rows.execute(f"CREATE TABLE IF NOT EXISTS {kind} ({columns})")
        except (OSError, sqlite3.Error) as e:
            raise ResourceError(f"{self.folder}: {e}; name another place with --folder.") from None
        self._lock()
        self._reconcile()

    def _lock(self) -> None:
        """Refuse a folder in which another studio works."""
        try:
            import fcntl
        except ImportError:  # Windows
            return
        self._held = open(self.folder / ".lock", "w")  # noqa: SIM115 - held as long as the store is open
        try:
            fcntl.flock(self._held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._held.close()
            raise ResourceError(f"another studio works in {self.folder}; end it, or name another --folder.") from None

    def close(self) -> None:
        """Close the table."""
        self._rows.close()
        if hasattr(self, "_held"):
            self._held.close()

    # rows

    def put(self, kind: str, row: Row) -> Row:
        """Keep a row, in place of one with the same id."""
        self._rows.execute(
            f"INSERT INTO {kind} (id, about) VALUES (?, ?) ON CONFLICT(id) DO UPDATE SET about = excluded.about",
            (row["id"], json.dumps(row)),
        )
        return row

    def get(self, kind: str, name: str) -> Row | None:
        """Return the row of this id, or None."""
        found = self._rows.execute(f"SELECT about FROM {kind} WHERE id = ?", (name,)).fetchone()
        return None if found is None else json.loads(found[0])

    def all(self, kind: str) -> list[Row]:
        """Return all rows, in the order in which they came."""
        return [json.loads(about) for (about,) in self._rows.execute(f"SELECT about FROM {kind} ORDER BY number")]

    def drop(self, kind: str, name: str) -> None:
        """Take a row and its files away: the row first."""
        self.drop_row(kind, name)
        if kind == "images":
            self.image(name).unlink(missing_ok=True)
        elif kind in ("exemplars", "results"):
            shutil.rmtree(self.folder / kind / name, ignore_errors=True)

    def drop_row(self, kind: str, name: str) -> None:
        """Take a row away, and leave its files."""
        self._rows.execute(f"DELETE FROM {kind} WHERE id = ?", (name,))

    # files

    def image(self, name: str) -> Path:
        """Where the image of this id lies."""
        return self.folder / "images" / f"{name}.png"

    def under_way(self, kind: str) -> Path:
        """Make a folder for files in the making; it becomes one of `kind` by `keep`."""
        path = self.folder / kind / f"{HIDDEN}{os.urandom(8).hex()}"
        path.mkdir()
        return path

    def keep(self, kind: str, path: Path, row: Row) -> Row:
        """Move files that are whole to the folder of their id, then write their row."""
        place = self.folder / kind / row["id"]
        if kind == "results":
            (path / TOLD).write_text(json.dumps(row), encoding="utf-8")
        if place.exists():
            shutil.rmtree(path, ignore_errors=True)
            return self.get(kind, row["id"]) or self.put(kind, row)
        os.rename(path, place)
        return self.put(kind, row)

    def files(self, kind: str, name: str) -> list[Path]:
        """The files of an exemplar or a result that people see, by name."""
        place = self.folder / kind / name
        return sorted(p for p in place.iterdir() if p.is_file() and not p.name.startswith("."))

    def _reconcile(self) -> None:
        """Rows without files go, files without rows get them again if they are whole, what ran is interrupted."""
        for kind in ("exemplars", "results"):
            known = {row["id"]: row for row in self.all(kind)}
            for path in (self.folder / kind).iterdir():
                if path.name.startswith(HIDDEN) or (path.name not in known and not self._adopted(kind, path)):
                    shutil.rmtree(path, ignore_errors=True)
            for name, row in known.items():
                if not row.get("sample") and not (self.folder / kind / name).is_dir():
                    self.drop_row(kind, name)
        self._reconcile_images()
        for job in self.all("jobs"):
            if job["state"] == "running" or (job["state"] == "done" and self.get("results", job["result"]) is None):
                ended = job["ended"] or time.time()
                self.put("jobs", job | {"state": "interrupted", "result": None, "error": None, "ended": ended})

    def _reconcile_images(self) -> None:
        known = {row["id"] for row in self.all("images")}
        for path in (self.folder / "images").iterdir():
            if path.stem not in known:
                path.unlink()
        for name in known:
            if not self.image(name).is_file():
                self.drop("images", name)

    def _adopted(self, kind: str, path: Path) -> bool:
        """Write the row of a result whose server was killed before it could."""
        if kind != "results":
            return False
        with suppress(OSError, ValueError, KeyError):
            row = json.loads((path / TOLD).read_text(encoding="utf-8"))
            if row["id"] == path.name:
                self.put("results", row)
                job = self.get("jobs", row["job"])
                if job is not None:
                    done = {"state": "done", "result": row["id"], "fraction": 1.0, "ended": row["made"], "error": None}
                    self.put("jobs", job | done)
                return True
        return False


def digest(files: Iterable[Path], *more: str) -> str:
    """The id of files: 16 hex digits of the SHA-256 of their names and contents."""
    whole = hashlib.sha256()
    for path in sorted(files):
        with path.open("rb") as f:
            whole.update(f"{path.name}\n{hashlib.file_digest(f, 'sha256').hexdigest()}\n".encode())
    for word in more:
        whole.update(word.encode())
    return whole.hexdigest()[:16]
