"""A store that is a folder of files: one or more for each cell, each written whole or not at all."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..disk import whole
from ..errors import InputError, IntarsiaError, ParameterError, ResourceError
from ..run import Run
from .cells import Cell, Grid
from .clearing import HEADER, LEDGER, check_free, check_woven, clear
from .ledger import Ledger, read_header, sound
from .picture import Picture


@dataclass
class FolderStore(ABC):
    """A folder, its ledger, and the files that say what it holds."""

    path: Path
    printable: str
    texture: Picture
    origin: tuple[int, int]
    grid: Grid
    header: dict[str, Any]
    force: bool
    ledger: Ledger | None = field(default=None, init=False)
    _ways: set[Path] = field(default_factory=set, init=False)  # folders that were found to be such

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

    def second(self) -> dict[str, Any] | None:
        """What the store holds as it is known beside its ledger; None where nothing tells."""
        return read_header(self.path / HEADER)

    def look(self) -> None:
        """Refuse, before any work, a place where this store cannot be; writes nothing."""
        check_folder(self.path, self.printable)
        if self._found() is None:
            self._check_free()

    def open(self) -> Iterable[int]:
        """Begin or go on; yield the numbers of the cells of which a file is missing or damaged."""
        self.ledger = self._begun()
        whole.sweep(self.path)
        return [cell.number for cell in self.grid if not all(self.sound(name) for name in self.files_of(cell))]

    def sound(self, name: str) -> bool:
        """Say whether a file is there as it was written."""
        entry = self.known.entries.get(name)
        return entry is not None and sound(self._place(name), entry)

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
        target = self._place(name)
        target.parent.mkdir(parents=True, exist_ok=True)
        whole.put(target, data, by=self.path)
        self.known.add(name, data)

    def finish(self, run: Run) -> None:
        """Put the ledger in order, so that equal stores are equal in all their files."""
        self.known.settle(self.all_files())

    def close(self) -> None:
        """Let go of the ledger."""
        if self.ledger is not None:
            self.ledger.close()

    def _begun(self) -> Ledger:
        """The ledger that is there, or a new one; what the store holds is told in both places, for good."""
        check_folder(self.path, self.printable)
        found = self._found()
        if found is not None:
            self._sign()
            if found.damaged:
                found.settle()
            return found
        self._check_free()
        new = not self.path.exists()
        if new:
            self.path.mkdir()
            whole.settle(self.path.parent)
        else:
            clear(self.path)
        try:
            self._sign()
            return Ledger.begin(self.path / LEDGER, self.header)
        except BaseException:
            with suppress(OSError):
                clear(self.path)
                if new:
                    self.path.rmdir()
            raise

    def _sign(self) -> None:
        """Write the files that belong to no cell, where they are not as they should be."""
        for name, data in self.signs().items():
            place = self.path / name
            if not whole.is_file(place) or place.read_bytes() != data:
                whole.put(place, data, durable=True)

    def _found(self) -> Ledger | None:
        """The ledger of what is there; None where nothing is, or where it may be replaced."""
        try:
            return Ledger.load(self.path / LEDGER, self.header, self.printable, self.second())
        except IntarsiaError:
            if not self.force:
                raise
            return None

    def _check_free(self) -> None:
        """Refuse a place where anything is but, with force, another texture that was woven."""
        if self.force and (whole.is_file(self.path / LEDGER) or self.second() is not None):
            check_woven(self.path, self.printable)
        else:
            check_free(self.path, self.printable)

    def _place(self, name: str) -> Path:
        """Where a file belongs; ParameterError where the way there leads out of the store."""
        for folder in reversed(Path(name).parents[:-1]):
            way = self.path / folder
            if way not in self._ways and os.path.lexists(way):
                if way.is_symlink() or not way.is_dir():
                    raise ParameterError(f"{way} is no folder; move it elsewhere, or name another place.")
                self._ways.add(way)
        return self.path / name


def check_folder(path: Path, name: str) -> None:
    """Refuse a place whose folder is not there or cannot be written."""
    try:
        folder = Path(os.path.realpath(path)).parent
        if len(os.fsencode(path.name)) > 240:
            raise InputError(f"{name} is too long a name; give at most 240 bytes.")
        if not folder.is_dir():
            raise InputError(f"the folder of {name} does not exist; make it first, or name another.")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise ResourceError(f"the folder of {name} cannot be written; name another one.")
    except ValueError:  # a zero byte in the name
        raise InputError(f"{name!r} is no name of a file; choose another.") from None
