"""A file or some bytes, looked at with care before anything is decoded."""

from __future__ import annotations

import os
import shutil
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..disk.limits import no_room
from ..disk.whole import working_folder
from ..disk.writing import ordinary
from ..errors import InputError, ResourceError, printable
from .formats import READABLE, sniff

HEAD = 1 << 16
MAX_WHOLE = 1 << 32
"""Formats that are read into memory whole may have this many bytes."""

_RECEIVED: dict[str, Any] = {}  # what came of the standard input, and which object that was

_SUFFIX = {"jpeg": ".jpg", "tiff": ".tif"}


@dataclass(frozen=True)
class PictureFile:
    """A picture file that may be opened: what to call it, its format, where its bytes are, and how many."""

    name: str
    format: str
    path: Path | None
    held: bytes | None
    size: int

    def head(self) -> bytes:
        """The first 64 KiB."""
        if self.held is not None:
            return self.held[:HEAD]
        assert self.path is not None
        return _first_bytes(self.path, self.name, HEAD)

    def data(self) -> bytes:
        """All bytes."""
        if self.held is not None:
            return self.held
        assert self.path is not None
        data = _first_bytes(self.path, self.name, MAX_WHOLE + 1)
        if len(data) > MAX_WHOLE:
            raise InputError(f"{self.name} is larger than {MAX_WHOLE >> 30} GiB; crop it, or save it as TIFF or EXR.")
        return data

    @contextmanager
    def plain_path(self, data: bytes | None = None) -> Iterator[str]:
        """Lend a path with the true ending and no surprising characters, for libraries that judge by name."""
        held = self.held if data is None else data
        with working_folder() as folder:
            target = os.path.join(folder, "picture" + _SUFFIX.get(self.format, "." + self.format))
            if held is not None:
                try:
                    Path(target).write_bytes(held)
                except OSError as e:
                    reason = (e.strerror or str(e)).lower()
                    raise ResourceError(
                        f"there is no room for a copy of {self.name} in {folder} ({reason}); free some, or set TMPDIR."
                    ) from None
            else:
                assert self.path is not None
                _lend(os.path.abspath(self.path), target)
            yield target


def damaged(name: str, why: str) -> InputError:
    """Say in one line that a file cannot be decoded."""
    why = " ".join(str(why).split())[:160].rstrip(".")
    return InputError(f"{name} is damaged or cut off ({why}); copy or save it again.")


def look(source: str | os.PathLike[str] | bytes) -> PictureFile:
    """Find out what a path or some bytes hold; never waits, whatever lies there."""
    if isinstance(source, bytes | bytearray | memoryview):
        return _known_picture("the data", None, bytes(source), len(source))
    text = os.fspath(source)
    if text == "-":
        data = _standard_input()
        return _known_picture("the standard input", None, data, len(data))
    path, name = Path(text), printable(text)
    if not text:
        raise InputError("an empty file name was given; name a picture, or a sample such as sample:brick.")
    size = ordinary(path, name)
    return _known_picture(name, path, None, size)


def _standard_input() -> bytes:
    """Read the standard input, or return again what came of it: who plans and then works asks for it twice."""
    if sys.stdin is None:
        raise InputError("the standard input is closed; name a file.")
    if _RECEIVED.get("from") is not sys.stdin:
        _RECEIVED.update({"from": sys.stdin, "data": sys.stdin.buffer.read(MAX_WHOLE + 1)})
    data: bytes = _RECEIVED["data"]
    if len(data) > MAX_WHOLE:
        raise InputError(f"the standard input is larger than {MAX_WHOLE >> 30} GiB; name a file.")
    return data


def _known_picture(name: str, path: Path | None, held: bytes | None, size: int) -> PictureFile:
    if size == 0:
        raise InputError(f"{name} is empty (0 bytes); copy or save it again.")
    head = held[:HEAD] if held is not None else _first_bytes(path or Path(), name, HEAD)
    kind, seems = sniff(head[:4096], size)
    if kind is None:
        raise InputError(f"{name} seems to be {seems}; only {READABLE} are read, so convert it first.")
    return PictureFile(name, kind, path, held, size)


def _first_bytes(path: Path, name: str, limit: int) -> bytes:
    try:
        # Not blocking: should the file have become a pipe since it was looked at, this returns at once.
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        with os.fdopen(number, "rb") as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise InputError(f"{name} is no ordinary file; name a picture file.")
            return file.read(min(limit, os.fstat(file.fileno()).st_size))
    except MemoryError:
        raise no_room(name) from None
    except OSError as e:
        raise InputError(f"{name} cannot be read ({(e.strerror or str(e)).lower()}); check the permissions.") from None


def _lend(path: str, target: str) -> None:
    try:
        os.symlink(path, target)
    except OSError:  # no links here, as on some Windows machines
        shutil.copyfile(path, target)
