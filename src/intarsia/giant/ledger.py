"""What of a store is done: its recipe, and a checksum for every piece, in a text file that is only appended to.

The first line is what the store holds, as JSON; each further line a piece: name, bytes, checksum. A line that a kill
cut off has no end, and counts as not written.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import os
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from ..errors import InputError, ParameterError

ABOUT = "intarsia weave"
LONGEST = 1 << 26  # bytes of the first line
_COUNT = itertools.count()


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
    """

    path: Path
    header: str
    entries: dict[str, Entry] = field(default_factory=dict)
    _file: BinaryIO | None = field(default=None, repr=False)

    @classmethod
    def load(cls, path: Path, header: dict[str, Any], shown: str) -> Ledger | None:
        """Read the ledger of a store; None where there is none, ParameterError where it is another recipe's."""
        wanted = json.dumps(header, sort_keys=True)
        if not path.is_file():
            return None
        ledger = cls(path, wanted)
        with path.open("rb") as file:
            first = file.readline(LONGEST)
            differing = difference(first, header)
            if differing is not None:
                raise ParameterError(
                    f"{shown} holds another recipe ({differing}); name another place, or replace it with --force "
                    "(force=True)."
                )
            for line in file:
                words = line.split()
                if line.endswith(b"\n") and len(words) == 3 and words[1].isdigit():
                    ledger.entries[words[0].decode(errors="replace")] = Entry(int(words[1]), words[2].decode("latin-1"))
        return ledger

    @classmethod
    def begin(cls, path: Path, header: dict[str, Any]) -> Ledger:
        """Begin a ledger without pieces."""
        ledger = cls(path, json.dumps(header, sort_keys=True))
        ledger.settle()
        return ledger

    def add(self, name: str, data: bytes) -> None:
        """Write down a piece that is whole where it belongs."""
        entry = Entry(len(data), checksum(data))
        self.entries[name] = entry
        if self._file is None:
            self._file = self.path.open("ab")
            if not _ends_line(self.path):
                self._file.write(b"\n")
        self._file.write(f"{name} {entry.size} {entry.digest}\n".encode())
        self._file.flush()

    def settle(self, names: Iterable[str] | None = None) -> None:
        """Write the ledger anew, with the pieces named, in their order."""
        self.close()
        if names is not None:
            self.entries = {name: self.entries[name] for name in names}
        lines = [self.header, *(f"{name} {e.size} {e.digest}" for name, e in self.entries.items())]
        replace_file(self.path, "".join(line + "\n" for line in lines).encode())

    def close(self) -> None:
        """Let go of the file."""
        if self._file is not None:
            self._file.close()
            self._file = None


def checksum(data: bytes) -> str:
    """The checksum of a piece."""
    return hashlib.blake2b(data, digest_size=16).hexdigest()


def whole(path: Path, entry: Entry) -> bool:
    """Say whether a file is the piece that was written."""
    try:
        return path.stat().st_size == entry.size and checksum(path.read_bytes()) == entry.digest
    except OSError:
        return False


def replace_file(path: Path, data: bytes) -> None:
    """Write a file whole or not at all."""
    temporary = path.with_name(f".intarsia-{os.getpid()}-{next(_COUNT)}")
    try:
        temporary.write_bytes(data)
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):
            temporary.unlink()
        raise


def difference(first: bytes, header: dict[str, Any]) -> str | None:
    """Say in which entry two recipes differ; None where they are equal."""
    try:
        there = json.loads(first)
        if not isinstance(there, dict) or there.get("holds") != ABOUT:
            raise ValueError
    except ValueError:
        raise InputError("the ledger of the store is damaged; replace the store with --force (force=True).") from None
    here = json.loads(json.dumps(header))
    if here == there:
        return None
    flat = [{**h, **h.get("recipe", {})} for h in (here, there)]
    names = [n for n in {**flat[0], **flat[1]} if n != "recipe" and flat[0].get(n) != flat[1].get(n)]
    return ", ".join(names) or "recipe"


def _ends_line(path: Path) -> bool:
    with path.open("rb") as file:
        file.seek(-1, os.SEEK_END)
        return file.read(1) == b"\n"
