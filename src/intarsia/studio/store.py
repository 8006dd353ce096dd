"""The studio's folder: files named by content with a JSON note beside each, and a table of rows in SQLite.

What is removed can be restored until the studio ends. Listeners get an event for every change.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import os
import re
import shutil
import sqlite3
import time
from collections.abc import AsyncIterator, Callable, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

from starlette.exceptions import HTTPException

from ..foundation import ParameterError, ResourceError, printable

Row = dict[str, Any]

FILED = ("exemplars", "images", "results")
"""Kinds with files; jobs, state of the page and findings are rows alone."""

KINDS = (*FILED, "jobs", "kept", "found")
MARKER = ".intarsia-studio"
"""A folder is the studio's own if this file lies in it."""

TABLE = "studio.sqlite"
AUTHORIZATION = ".authorization"
OWN = {*FILED, MARKER, TABLE, f"{TABLE}-wal", f"{TABLE}-shm", f"{TABLE}-journal", AUTHORIZATION, ".lock"}

ID = re.compile("[0-9a-f]{16}")
HIDDEN = ".under-way-"
UNDER_WAY = re.compile(re.escape(HIDDEN) + ID.pattern)
TOLD = ".told.json"
"""The note beside files: their row, from which a lost table is restored."""

OPEN = ("queued", "running")

MOST = 1000  # events queued for a listener; one that is further behind is disconnected
BREATH = 10.0  # s without an event after which a comment keeps the connection alive


class Store:
    """Files below a folder, and rows in its `studio.sqlite`."""

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder).absolute()
        try:
            self._claim()
            self._lock()
            self._rows = sqlite3.connect(self.folder / TABLE, isolation_level=None, check_same_thread=False)
            self._rows.execute("PRAGMA journal_mode=DELETE")  # so that a copy of the file is complete
            for kind in KINDS:
                columns = "number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT UNIQUE NOT NULL, about TEXT NOT NULL"
                self._rows.execute(f"CREATE TABLE IF NOT EXISTS {kind} ({columns})")
            self._keep_to_oneself()
        except (OSError, sqlite3.OperationalError) as e:
            why = getattr(e, "strerror", None) or e
            raise ResourceError(f"{printable(self.folder)}: {why}; name another place with --folder.") from None
        except sqlite3.DatabaseError as e:
            hint = f"move {TABLE} away, and it is made anew from what lies beside it."
            raise ResourceError(f"{printable(self.folder)}: {e}; {hint}") from None
        self._reconcile()

    def _claim(self) -> None:
        """Make the folder the studio's own; refuse one that holds other files."""
        self.folder.mkdir(parents=True, exist_ok=True)
        if not (self.folder / MARKER).is_file():
            if any(self.folder.iterdir()) and not _is_table(self.folder / TABLE):
                place = printable(self.folder)
                raise ParameterError(
                    f"{place} holds files that are not the studio's, and stays as it is; "
                    f"name a folder for the studio alone, such as --folder {place}/intarsia-studio."
                )
            (self.folder / MARKER).write_text(f"the folder of a studio: {os.urandom(8).hex()}\n", encoding="utf-8")
        for kind in FILED:
            (self.folder / kind).mkdir(exist_ok=True)

    def _keep_to_oneself(self) -> None:
        """Make the folder private."""
        for kind in FILED:
            (self.folder / kind).chmod(0o700)
        (self.folder / TABLE).chmod(0o600)
        if {path.name for path in self.folder.iterdir()} <= OWN:  # an older one may contain other files
            self.folder.chmod(0o700)

    def _lock(self) -> None:
        """Refuse a folder that another studio uses."""
        try:
            import fcntl
        except ImportError:  # Windows
            return
        self._held = open(self.folder / ".lock", "w")  # noqa: SIM115 - held as long as the store is open
        try:
            fcntl.flock(self._held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._held.close()
            place = printable(self.folder)
            raise ResourceError(f"another studio works in {place}; end it, or name another --folder.") from None

    @property
    def home(self) -> tuple[str, int]:
        """The loopback address and port of this folder, derived from its marker, so that browsers know it again."""
        drawn = hashlib.sha256((self.folder / MARKER).read_bytes()).digest()
        return f"127.{drawn[0]}.{drawn[1]}.{drawn[2] % 254 + 1}", 20_000 + int.from_bytes(drawn[3:5]) % 10_000

    def close(self) -> None:
        """Close the table."""
        self._rows.close()
        if hasattr(self, "_held"):
            self._held.close()

    # rows

    def put(self, kind: str, row: Row) -> Row:
        """Write a row, replacing one of the same id, and the note beside its files."""
        note, fresh = self._note(kind, row["id"]), self._fresh(kind)
        if kind in FILED and note.parent.is_dir():
            fresh.write_text(json.dumps(row), encoding="utf-8")
            fresh.replace(note)
        self._rows.execute(
            f"INSERT INTO {kind} (id, about) VALUES (?, ?) ON CONFLICT(id) DO UPDATE SET about = excluded.about",
            (row["id"], json.dumps(row)),
        )
        return row

    def get(self, kind: str, name: str, gone: bool = False) -> Row | None:
        """Return the row of an id, or None; with `gone` only removed rows, else only others."""
        found = self._rows.execute(f"SELECT about FROM {kind} WHERE id = ?", (name,)).fetchone()
        row: Row | None = None if found is None else json.loads(found[0])
        return row if row is not None and ("gone" in row) == gone else None

    def row(self, kind: str, name: str) -> Row:
        """Return the row of an id that a client gave; HTTPException 404 if there is none."""
        row = self.get(kind, name)
        if row is None:
            raise HTTPException(404, f"there is no such {kind[:-1]}.")
        return row

    def all(self, kind: str, gone: bool = False) -> list[Row]:
        """Return all rows in order of creation; with `gone` the removed ones."""
        rows = [json.loads(about) for (about,) in self._rows.execute(f"SELECT about FROM {kind} ORDER BY number")]
        return [row for row in rows if ("gone" in row) == gone]

    def drop(self, kind: str, name: str) -> None:
        """Delete a row and its files: files are renamed first, so that no note restores half of them.

        Nothing else deletes stored files; what lacks an id and a note of the studio's form is left.
        """
        if kind in FILED and ID.fullmatch(name) and self._note(kind, name).is_file():
            for path in (self.place(kind, name), self._note(kind, name)):
                if path.exists():
                    _remove(path.rename(self._fresh(kind)))
        self.drop_row(kind, name)

    def drop_row(self, kind: str, name: str) -> None:
        """Delete a row, and leave its files."""
        self._rows.execute(f"DELETE FROM {kind} WHERE id = ?", (name,))

    # files

    def place(self, kind: str, name: str) -> Path:
        """Return the path of the files of an id: a folder; an image is one file."""
        return self.folder / kind / (f"{name}.png" if kind == "images" else name)

    def _note(self, kind: str, name: str) -> Path:
        return self.folder / kind / (f"{name}{TOLD}" if kind == "images" else f"{name}/{TOLD}")

    def weight(self) -> int:
        """Return how many bytes of disk the folder takes."""
        total = 0
        for path in self.folder.rglob("*"):
            with suppress(OSError):  # it may just have gone
                total += path.lstat().st_size
        return total

    def _fresh(self, kind: str) -> Path:
        """Return an unused path for temporary files."""
        return self.folder / kind / f"{HIDDEN}{os.urandom(8).hex()}"

    def begun(self, kind: str) -> Path:
        """Make a folder for new files; `keep` moves it to its place, else the next start removes it."""
        path = self._fresh(kind)
        path.mkdir()
        return path

    @contextmanager
    def under_way(self, kind: str) -> Iterator[Path]:
        """Yield such a folder, and remove it afterwards if it was not kept."""
        path = self.begun(kind)
        try:
            yield path
        finally:
            shutil.rmtree(path, ignore_errors=True)

    def keep(self, kind: str, path: Path, row: Row) -> Row:
        """Move complete files with their note to the place of their id, then write their row."""
        place = self.place(kind, row["id"])
        if place.exists():
            shutil.rmtree(path, ignore_errors=True)
            return self.get(kind, row["id"]) or self.put(kind, row)
        (path / TOLD).write_text(json.dumps(row), encoding="utf-8")
        path.rename(place)
        return self.put(kind, row)

    def _reconcile(self) -> None:
        """Delete rows without files, restore rows from notes, and mark running jobs as interrupted."""
        for kind in FILED:
            known = {row["id"]: row for row in self.all(kind)}
            for path in (self.folder / kind).iterdir():
                if UNDER_WAY.fullmatch(path.name):
                    _remove(path)
            for name, row in known.items():
                if row.get("sample"):  # of an older studio, which made no folder for it
                    self.place(kind, name).mkdir(exist_ok=True)
                if not self.place(kind, name).exists():
                    self.drop(kind, name)
                elif not self._note(kind, name).is_file():
                    self.put(kind, row)
            names = {path.name[:16] for path in (self.folder / kind).iterdir()} - set(known)
            lost = [told for name in names if (told := self._told(kind, name)) is not None]
            for row in sorted(lost, key=lambda row: row.get("created") or row.get("made") or 0.0):
                self._adopt(kind, row)
        for job in self.all("jobs"):
            if job["state"] == "running" or (job["state"] == "done" and self.get("results", job["result"]) is None):
                ended = job["ended"] or time.time()
                self.put("jobs", job | {"state": "interrupted", "result": None, "error": None, "ended": ended})

    def _told(self, kind: str, name: str) -> Row | None:
        """Return the row in the note beside files, if both are valid."""
        with suppress(OSError, ValueError, KeyError, TypeError):
            row: Row = json.loads(self._note(kind, name).read_text(encoding="utf-8"))
            whole = kind != "results" or {"job", "made"} <= row.keys()
            if row["id"] == name and ID.fullmatch(name) and whole and self.place(kind, name).exists():
                return row
        return None

    def _adopt(self, kind: str, row: Row) -> None:
        """Restore a row that the table lost, or that was not written before a crash, and its job's."""
        self.put(kind, row)
        if kind == "results":
            total = (row.get("score") or {}).get("total")
            job = {key: row.get(key) for key in ("verb", "exemplars", "options", "label", "began")}
            job |= {"id": row["job"], "created": row["made"], "stage": "done", "score": total}
            done = {"state": "done", "result": row["id"], "fraction": 1.0, "ended": row["made"], "error": None}
            self.put("jobs", (self.get("jobs", row["job"]) or job) | done)


def _is_table(path: Path) -> bool:
    """Return whether a file is the table of a studio; one whose rows were in a lost log counts."""
    try:
        with closing(sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True)) as rows:
            found = rows.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
    except sqlite3.Error:
        return False
    return {name for (name,) in found} <= {*KINDS, "sqlite_sequence"}


def _remove(path: Path) -> None:
    """Remove temporary or deleted files; of a link only the link."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def digest(files: Iterable[Path], *more: str) -> str:
    """Return the id of files: 16 hexadecimal digits of the SHA-256 of their names and contents."""
    whole = hashlib.sha256()
    for path in sorted(files):
        with path.open("rb") as f:
            whole.update(f"{path.name}\n{hashlib.file_digest(f, 'sha256').hexdigest()}\n".encode())
    for word in more:
        whole.update(word.encode())
    return whole.hexdigest()[:16]


class Bin:
    """Removed jobs with their results, and removed exemplars; they can be restored until the studio ends."""

    def __init__(self, store: Store, events: Events) -> None:
        self.store, self.events = store, events

    def take(self, kind: str, name: str) -> None:
        """Remove a job or an exemplar; status 409 if it is in use."""
        row = self.store.row(kind, name)
        if kind == "jobs" and row["state"] in OPEN:
            raise HTTPException(409, f"this job is {row['state']}; cancel it first.")
        under_way = [job["exemplars"] for job in self.store.all("jobs") if job["state"] in OPEN]
        if kind == "exemplars" and any(name in names for names in under_way):
            raise HTTPException(409, "a job with this exemplar is under way; cancel it first.")
        self.store.put(kind, row | {"gone": time.time()})
        self.events.tell("gone", {kind[:-1]: name})

    def back(self, kind: str, name: str) -> Row:
        """Restore what was removed."""
        row = self.store.get(kind, name, gone=True)
        if row is None:
            raise HTTPException(404, f"no such {kind[:-1]} was taken away.")
        del row["gone"]
        self.events.tell(kind[:-1], row)
        return self.store.put(kind, row)

    def empty(self) -> None:
        """Delete all that is removed: first the files, of a result unless another job has the same, then the row."""
        kept = {job["result"] for job in self.store.all("jobs")}
        for job in self.store.all("jobs", gone=True):
            if job["result"] is not None and job["result"] not in kept:
                self.store.drop("results", job["result"])
            self.store.drop_row("jobs", job["id"])
        for exemplar in self.store.all("exemplars", gone=True):
            self.store.drop("exemplars", exemplar["id"])
            self.store.drop_row("found", exemplar["id"])


class Events:
    """Listeners, and the events sent to them."""

    def __init__(self) -> None:
        self._ears: set[asyncio.Queue[bytes | None]] = set()

    def tell(self, kind: str, said: Any) -> None:
        """Send an event to all listeners."""
        line = written(kind, said)
        for ear in list(self._ears):
            if ear.qsize() >= MOST:
                self._ears.discard(ear)
                ear.put_nowait(None)
            else:
                ear.put_nowait(line)

    def close(self) -> None:
        """Disconnect all listeners."""
        for ear in self._ears:
            ear.put_nowait(None)
        self._ears.clear()

    async def heard(self, first: Callable[[], list[tuple[str, Any]]]) -> AsyncIterator[bytes]:
        """Yield what a listener gets: the current state, then each event."""
        ear: asyncio.Queue[bytes | None] = asyncio.Queue()
        self._ears.add(ear)
        try:
            for kind, said in first():
                yield written(kind, said)
            while True:
                try:
                    line = await asyncio.wait_for(ear.get(), BREATH)
                except TimeoutError:
                    yield b": here\n\n"
                    continue
                if line is None:
                    return
                yield line
        finally:
            self._ears.discard(ear)


def written(kind: str, said: Any) -> bytes:
    """Return an event in the form of server-sent events."""
    return f"event: {kind}\ndata: {json.dumps(said)}\n\n".encode()
