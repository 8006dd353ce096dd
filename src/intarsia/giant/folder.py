"""A store that is a folder of files: one or more for each cell, each written whole or not at all.

What in a folder was woven is told by its names; `--force` takes away just that, and only where nothing else is.
"""

from __future__ import annotations

import json
import os
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..disk import whole
from ..errors import InputError, IntarsiaError, ParameterError, ResourceError, printable
from ..run import Run
from .cells import Cell
from .ledger import Ledger, read_header, sound
from .picture import Kept

LEDGER, HEADER = "weave.ledger", "weave.header"

_N = "(0|[1-9][0-9]*)"
FILES = re.compile(rf"weave\.(ledger|header)|zarr\.json|c/{_N}/{_N}(/0)?|image\.dzi|image_files/{_N}/{_N}_{_N}\.png")
FOLDERS = re.compile(rf"c(/{_N}){{0,2}}|image_files(/{_N})?")


@dataclass
class FolderStore(Kept, ABC):
    """A folder, its ledger, and the files that say what it holds."""

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
        self._ledger = self._begun()
        whole.sweep(self.path)
        return [cell.number for cell in self.grid if not all(self.sound(name) for name in self.files_of(cell))]

    def sound(self, name: str) -> bool:
        """Say whether a file is there as it was written."""
        entry = self.ledger.entries.get(name)
        return entry is not None and sound(self._place(name), entry)

    def put(self, cell: Cell, pieces: list[bytes]) -> None:
        """Write the files of a cell."""
        for name, data in zip(self.files_of(cell), pieces, strict=True):
            self.keep(name, data)

    def keep(self, name: str, data: bytes) -> None:
        """Write a file, then write it down."""
        target = self._place(name)
        target.parent.mkdir(parents=True, exist_ok=True)
        whole.put(target, data, by=self.path)
        self.ledger.add(name, data)

    def finish(self, run: Run) -> None:
        """Put the ledger in order, so that equal stores are equal in all their files."""
        self.ledger.settle(self.all_files())

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


def clear(path: Path) -> None:
    """Remove all that was woven in a folder; the folder itself stays, empty."""
    folders, names = woven(path)
    for name in names:  # the ledger comes first: without it, nobody goes on with the rest
        (path / name).unlink(missing_ok=True)
    for name in reversed(folders):
        with suppress(FileNotFoundError):
            (path / name).rmdir()


def check_woven(path: Path, name: str) -> None:
    """Refuse to replace a folder that holds anything which was not woven; removes nothing."""
    folders, names = woven(path)
    known = {*folders, *names}
    for at, below, here in os.walk(path):
        for entry in sorted(below + here):
            full = Path(at, entry)
            if full.relative_to(path).as_posix() not in known:
                raise ParameterError(
                    f"{name} holds {printable(full.relative_to(path))}, which was not woven; move it elsewhere, or "
                    "name another place."
                )


def check_free(path: Path, name: str) -> None:
    """Refuse a place where something else is."""
    if not os.path.lexists(path):
        return
    if not path.is_dir() or any(not whole.is_temporary(e.name) for e in path.iterdir()):
        raise ParameterError(f"{name} exists, and is no texture that was woven; name another place.")


def woven(path: Path) -> tuple[list[str], list[str]]:
    """The folders (each before those in it) and the files below a folder that bear names of stores, links never."""
    folders, names = list[str](), list[str]()
    for at, below, here in os.walk(path):
        inside = Path(at).relative_to(path)
        for name in sorted(below):
            place = (inside / name).as_posix()
            if FOLDERS.fullmatch(place) and not Path(at, name).is_symlink():
                folders.append(place)
        below[:] = [name for name in below if (inside / name).as_posix() in folders]
        names += [place for name in here if _own(path, place := (inside / name).as_posix())]
    return folders, sorted(names, key=lambda name: (name != LEDGER, name))


def _own(path: Path, name: str) -> bool:
    """Say whether a file was woven here, or left by a weave that was killed."""
    place = path / name
    if whole.left_over(place):
        return True
    if not FILES.fullmatch(name) or place.is_symlink() or not place.is_file():
        return False
    return name != "zarr.json" or recipe_in_zarr(place) is not None


def recipe_in_zarr(place: Path) -> dict[str, Any] | None:
    """The description of a zarr array, {} where it is damaged; None where it is no texture."""
    try:
        whole.is_file(place)
        with whole.open_again(place, "rb") as file:
            found = json.loads(file.read(1 << 26))
    except (OSError, ValueError, RecursionError):
        return {}
    attributes = found.get("attributes") if isinstance(found, dict) else None
    return found if isinstance(attributes, dict) and "intarsia" in attributes else None
