"""A store that is a folder of files: one or more for each cell, each written whole or not at all."""

from __future__ import annotations

import os
import shutil
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import InputError, IntarsiaError, ParameterError, ResourceError
from ..run import Run
from .cells import Cell, Grid
from .ledger import Ledger, replace_file, whole
from .texture import Weave

LEDGER = "weave.ledger"


@dataclass
class FolderStore(ABC):
    """A folder, its ledger, and the files that say what it holds."""

    path: Path
    shown: str
    texture: Weave
    origin: tuple[int, int]
    grid: Grid
    header: dict[str, Any]
    force: bool
    ledger: Ledger | None = field(default=None, init=False)

    @abstractmethod
    def files_of(self, cell: Cell) -> list[str]:
        """The files of a cell, below the folder, in the order of its pieces."""

    @abstractmethod
    def signs(self) -> dict[str, bytes]:
        """The files that belong to no cell."""

    def all_files(self) -> Iterator[str]:
        """Every file that the ledger knows in the end, in order."""
        for cell in self.grid:
            yield from self.files_of(cell)

    def look(self) -> None:
        """Refuse, before any work, a place where this store cannot be; writes nothing."""
        check_folder(self.path, self.shown)
        if self._found() is None and not self._replaced():
            check_free(self.path, self.shown)

    def open(self) -> Iterable[int]:
        """Begin or go on; yield the numbers of the cells of which a file is missing or damaged."""
        self.ledger = self._begun()
        sweep(self.path)
        for name, data in self.signs().items():
            if not (self.path / name).is_file() or (self.path / name).read_bytes() != data:
                replace_file(self.path / name, data)
        return [cell.number for cell in self.grid if not all(self.sound(name) for name in self.files_of(cell))]

    def sound(self, name: str) -> bool:
        """Say whether a file is there as it was written."""
        entry = self.known.entries.get(name)
        return entry is not None and whole(self.path / name, entry)

    @property
    def known(self) -> Ledger:
        """The ledger of the store, which must be open."""
        assert self.ledger is not None
        return self.ledger

    def put(self, cell: Cell, pieces: list[bytes]) -> None:
        """Write the files of a cell."""
        for name, data in zip(self.files_of(cell), pieces, strict=True):
            self.keep(name, data)

    def keep(self, name: str, data: bytes) -> None:
        """Write a file, then write it down."""
        target = self.path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        replace_file(target, data)
        self.known.add(name, data)

    def finish(self, run: Run) -> None:
        """Put the ledger in order, so that equal stores are equal in all their files."""
        self.known.settle(self.all_files())

    def close(self) -> None:
        """Let go of the ledger."""
        if self.ledger is not None:
            self.ledger.close()

    def _begun(self) -> Ledger:
        """The ledger that is there, or a new one."""
        check_folder(self.path, self.shown)
        found = self._found()
        if found is not None:
            return found
        if self._replaced():
            shutil.rmtree(self.path)
        check_free(self.path, self.shown)
        self.path.mkdir(exist_ok=True)
        try:
            return Ledger.begin(self.path / LEDGER, self.header)
        except BaseException:
            with suppress(OSError):
                self.path.rmdir()
            raise

    def _found(self) -> Ledger | None:
        """The ledger of what is there; None where nothing is, or where it may be replaced."""
        try:
            return Ledger.load(self.path / LEDGER, self.header, self.shown)
        except IntarsiaError:
            if not self.force:
                raise
            return None

    def _replaced(self) -> bool:
        """Say whether another texture that was woven here gives way."""
        return self.force and (self.path / LEDGER).is_file()


def sweep(folder: Path) -> None:
    """Take away files that a kill left half-written."""
    for at, _, names in os.walk(folder):
        for name in names:
            if name.startswith(".intarsia-"):
                os.unlink(os.path.join(at, name))


def check_free(path: Path, shown: str) -> None:
    """Refuse a place where something else is."""
    if not os.path.lexists(path):
        return
    if not path.is_dir() or any(not e.name.startswith(".intarsia-") for e in path.iterdir()):
        raise ParameterError(f"{shown} exists, and is no texture that was woven; name another place.")


def check_folder(path: Path, shown: str) -> None:
    """Refuse a place whose folder is not there or cannot be written."""
    try:
        folder = Path(os.path.realpath(path)).parent
        if len(os.fsencode(path.name)) > 240:
            raise InputError(f"{shown} is too long a name; give at most 240 bytes.")
        if not folder.is_dir():
            raise InputError(f"the folder of {shown} does not exist; make it first, or name another.")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise ResourceError(f"the folder of {shown} cannot be written; name another one.")
    except ValueError:  # a zero byte in the name
        raise InputError(f"{shown!r} is no name of a file; choose another.") from None
