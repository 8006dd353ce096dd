"""What of a store is done: its recipe, and a checksum for every piece, in a text file that is only appended to.

The first line is what the store holds, as JSON; each further line a piece: name, bytes, checksum. A line that a kill
cut off has no end, and counts as not written.

After a loss of power, lines and pieces of the last seconds may be missing, cut or zeros: pieces are compared with their
checksums whenever a store is opened, so those cost time only, and nothing waits for the disk. What is not made again,
the first line, is on the disk before the first piece is drawn, and in a second place, which the store knows.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from ..disk import whole
from ..errors import InputError, ParameterError

ABOUT = "intarsia weave"
LONGEST = 1 << 26  # bytes of the first line
LINE = 1 << 12  # bytes of another


@dataclass(frozen=True)
class Entry:
    """A piece that was written: its bytes, and their checksum."""

    size: int
    digest: str


@dataclass
class Ledger:
    """The ledger of a store.

    Attributes
    ----------
    path : Path
        Where it lies.
    header : str
        What the store holds, as JSON of one line.
    entries : dict
        Entry by name, in the order in which the pieces were written.
    damaged : bool
        Whether its first line was lost, and must be written anew.
    """

    path: Path
    header: str
    entries: dict[str, Entry] = field(default_factory=dict)
    damaged: bool = False
    _file: BinaryIO | None = field(default=None, repr=False)

    @classmethod
    def load(cls, path: Path, header: dict[str, Any], name: str, second: dict[str, Any] | None) -> Ledger | None:
        """Read the ledger of a store.

        `second`: what the store holds as another place knows it, where the first line is lost; None: no other knows it.
        None where there is neither. ParameterError where it is another recipe's, InputError where nothing can be read.
        """
        ledger, there = cls(path, as_line(header)), whole.is_file(path)
        if not there and second is None:
            return None
        first = b""
        if there:
            with whole.open_again(path, "rb") as file:
                first = file.readline(LONGEST)
                ledger._read(file)
        header_read = parsed(first)
        if header_read is None:
            ledger.damaged, header_read = True, second
            ledger._take(first)
        if header_read is None:
            raise InputError(
                f"{name} was begun, but its ledger and its recipe cannot be read any more; name another place."
            )
        differing = difference(header_read, header)
        if differing is not None:
            raise ParameterError(
                f"{name} holds another recipe ({differing}); name another place, or replace it with --force "
                "(force=True)."
            )
        return ledger

    @classmethod
    def begin(cls, path: Path, header: dict[str, Any]) -> Ledger:
        """Begin a ledger without pieces."""
        ledger = cls(path, as_line(header))
        ledger.settle()
        return ledger

    def add(self, name: str, data: bytes) -> None:
        """Write down a piece that is whole where it belongs."""
        entry = Entry(len(data), checksum(data))
        self.entries[name] = entry
        if self._file is None:
            ended = _ends_line(self.path)
            self._file = whole.open_again(self.path, "ab")
            if not ended:
                self._file.write(b"\n")
        self._file.write(f"{name} {entry.size} {entry.digest}\n".encode())
        self._file.flush()

    def settle(self, names: Iterable[str] | None = None) -> None:
        """Write the ledger anew, with the pieces named, in their order; it then outlives a loss of power."""
        self.close()
        if names is not None:
            self.entries = {name: self.entries[name] for name in names}
        lines = [self.header, *(f"{name} {e.size} {e.digest}" for name, e in self.entries.items())]
        whole.put(self.path, "".join(line + "\n" for line in lines).encode(), durable=True)
        self.damaged = False

    def close(self) -> None:
        """Let go of the file."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _read(self, file: BinaryIO) -> None:
        """Read the lines of pieces; those that are damaged are none."""
        while line := file.readline(LINE):
            self._take(line)

    def _take(self, line: bytes) -> None:
        words = line.lstrip(b"\0").split()  # zeros lie where a loss of power left a hole
        if line.endswith(b"\n") and len(words) == 3 and words[1].isdigit() and len(words[1]) < 16:
            self.entries[words[0].decode(errors="replace")] = Entry(int(words[1]), words[2].decode("latin-1"))


def checksum(data: bytes) -> str:
    """The checksum of a piece."""
    return hashlib.blake2b(data, digest_size=16).hexdigest()


def sound(path: Path, entry: Entry) -> bool:
    """Say whether a file is the piece that was written; ParameterError where no ordinary file lies."""
    try:
        if not whole.is_file(path):
            return False
        with whole.open_again(path, "rb") as file:
            return os.fstat(file.fileno()).st_size == entry.size and checksum(file.read()) == entry.digest
    except OSError:
        return False


def as_line(header: dict[str, Any]) -> str:
    """What a store holds, as the first line of its ledger."""
    return json.dumps(header, sort_keys=True)


def read_header(path: Path) -> dict[str, Any] | None:
    """Read what a store holds from a file that says nothing else; None where it cannot be read."""
    if not whole.is_file(path):
        return None
    with whole.open_again(path, "rb") as file:
        return parsed(file.readline(LONGEST))


def parsed(line: bytes) -> dict[str, Any] | None:
    """Understand a first line; None where it is damaged."""
    try:
        header_read = json.loads(line)
    except (ValueError, RecursionError):
        return None
    whole = isinstance(header_read, dict) and header_read.get("holds") == ABOUT and line.endswith(b"\n")
    return header_read if whole else None


def difference(there: dict[str, Any], header: dict[str, Any]) -> str | None:
    """Say in which entries two recipes differ; None where they are equal."""
    here, there = (json.loads(json.dumps(h)) for h in (header, there))
    if here == there:
        return None
    flat = [{**h, **(h["recipe"] if isinstance(h.get("recipe"), dict) else {})} for h in (here, there)]
    names = [n for n in {**flat[0], **flat[1]} if n != "recipe" and flat[0].get(n) != flat[1].get(n)]
    return ", ".join(names) or "recipe"


def _ends_line(path: Path) -> bool:
    with whole.open_again(path, "rb") as file:
        if file.seek(0, os.SEEK_END) == 0:
            return True
        file.seek(-1, os.SEEK_END)
        return file.read(1) == b"\n"
