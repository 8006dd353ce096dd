"""Atomic writing of files: written under a temporary name, then renamed; existing files are replaced only on request.

All temporary files are made here, and those that killed runs left are removed.

A temporary name identifies its writer: ``.intarsia-HOST-PID-CHANCE`` beside an output, ``intarsia-HOST-PID-CHANCE``
below TMPDIR. So the next run knows which writers are dead. A name is chosen before anything is made under it, and the
``try`` that takes it away again begins before that, too: a signal finds no moment in between.
"""

from __future__ import annotations

import errno
import hashlib
import os
import platform
import re
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from os.path import abspath, basename, dirname, isdir, isfile, islink, join, lexists, realpath
from pathlib import Path
from typing import BinaryIO, cast

from ..foundation import InputError, ParameterError, ResourceError, printable
from . import reason_of

PathLike = str | os.PathLike[str]


HIDDEN, PLAIN = ".intarsia-", "intarsia-"
"""Prefixes of temporary names: beside outputs, and below TMPDIR."""

_NAME = re.compile(r"(\.?intarsia-)([0-9a-f]{8})-([1-9][0-9]{0,8})-[0-9a-f]{16}")
_FOLLOW_NOTHING = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
_swept: set[tuple[int, str]] = set()
_asked: dict[str, str] = {}  # file under way -> the name that was asked for


@cache
def host() -> str:
    """Return 8 digits that identify this machine and its pid namespace: if equal, a pid means the same process."""
    space = ""
    with suppress(OSError):
        space = os.readlink("/proc/self/ns/pid")
    return hashlib.blake2b(f"{platform.node()} {space}".encode(errors="replace"), digest_size=4).hexdigest()


def temporary_name(folder: PathLike, mark: str = HIDDEN) -> str:
    """Return a new, unguessable temporary name in a folder; nothing is made yet."""
    return join(folder, f"{mark}{host()}-{os.getpid()}-{os.urandom(8).hex()}")


def is_file(path: PathLike) -> bool:
    """Return whether a regular file exists here; ParameterError for links, folders, pipes and devices.

    For files whose names are chosen by intarsia: a link that somebody planted there is not followed.
    """
    try:
        mode = os.lstat(path).st_mode
    except (FileNotFoundError, NotADirectoryError):
        return False
    if stat.S_ISREG(mode):
        return True
    raise ParameterError(
        f"{printable(path)} is a link, a folder, a pipe or a device, no ordinary file; move it elsewhere, or name "
        "another place."
    )


def open_regular(path: PathLike, mode: str = "r+b") -> BinaryIO:
    """Open a regular file to read and change it, or only to read it ("rb"); follows no link, never blocks on a pipe."""
    is_file(path)
    number = os.open(path, (os.O_RDONLY if mode == "rb" else os.O_RDWR) | _FOLLOW_NOTHING)
    file = cast(BinaryIO, os.fdopen(number, mode))
    if not stat.S_ISREG(os.fstat(number).st_mode):  # put there since it was looked at
        file.close()
        is_file(path)
    return file


def replace_file(path: PathLike, data: bytes, durable: bool = False, by: PathLike | None = None) -> None:
    """Write a file atomically, replacing a regular file of that name.

    `durable`: name and content have reached the disk on return. `by`: the folder to prepare it in, of the
    same file system. OSError where that fails, ParameterError where no regular file lies; what was there is untouched.
    """
    folder = dirname(abspath(path))
    draft = temporary_name(folder if by is None else by)
    try:
        write_new(draft, data, durable)
        is_file(path)
        os.replace(draft, path)
    except BaseException:
        remove_temporary(draft)
        raise
    if durable:
        sync_folder(folder)


def write_new(path: PathLike, data: bytes, durable: bool = True) -> None:
    """Write a new file; with `durable`, its content has reached the disk on return.

    FileExistsError if the name is taken, even by a dangling link.
    """
    number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _FOLLOW_NOTHING, 0o666)
    with os.fdopen(number, "wb") as file:
        file.write(data)
        if durable:
            sync_file(file)


def sync_file(file: BinaryIO) -> None:
    """Flush what was written to the disk (fsync)."""
    file.flush()
    os.fsync(file.fileno())


def sync_folder(folder: PathLike) -> None:
    """Flush the names in a folder to the disk (fsync), where the system can do that."""
    with suppress(OSError):
        number = os.open(folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
        try:
            os.fsync(number)
        finally:
            os.close(number)


def remove_temporary(path: PathLike) -> None:
    """Remove a temporary file or folder if it exists; never fails, follows no link."""
    try:
        _remove(path)
    except BaseException:  # a signal, just now: once more, so that nothing stays
        _remove(path)
        raise


@contextmanager
def working_folder() -> Iterator[str]:
    """Make an empty folder below TMPDIR for this context; it is removed however the work ends."""
    parent = tempfile.gettempdir()
    sweep(parent, PLAIN)
    name = temporary_name(parent, PLAIN)
    try:
        try:
            os.mkdir(name, 0o700)
        except OSError as e:
            raise ResourceError(f"no folder can be made in {printable(parent)} ({reason_of(e)}); set TMPDIR.") from None
        yield name
    finally:
        remove_temporary(name)


def sweep(folder: PathLike, mark: str = HIDDEN) -> None:
    """Remove temporary files that killed runs of this user on this machine left; once for each folder and process.

    Only what has exactly such a name, belongs to this user, and whose process is gone; never a link.
    """
    place = join(abspath(folder), mark)
    if (os.getpid(), place) in _swept:
        return
    _swept.add((os.getpid(), place))
    with suppress(OSError), os.scandir(folder) as found:
        for name in [e.name for e in found if e.name.startswith(mark)]:
            if is_left_over(join(folder, name)):
                remove_temporary(join(folder, name))


def is_left_over(path: PathLike) -> bool:
    """Return whether a run that is gone left this, judged by its name, its owner and its type."""
    match = _NAME.fullmatch(basename(path))
    if match is None or match[2] != host() or not hasattr(os, "getuid"):
        return False
    try:
        state = os.lstat(path)
    except OSError:
        return False
    ordinary = stat.S_ISREG(state.st_mode) or stat.S_ISDIR(state.st_mode)
    return ordinary and state.st_uid == os.getuid() and not lives(int(match[3]))


def displayed_name(path: PathLike, name: PathLike | None = None) -> str:
    """Return the name of a file for messages: that of its output, registered by an earlier call with `name`."""
    text = os.fspath(path)
    if name is not None:
        _asked[text] = os.fspath(name)
    for staged, asked in _asked.items():  # the file, or a recipe beside it
        if text == staged or text.startswith(staged + "."):
            return asked + text[len(staged) :]
    return text


def forget_name(path: PathLike) -> None:
    """Remove the registration of :func:`displayed_name` of a temporary file."""
    _asked.pop(os.fspath(path), None)


def lives(pid: int) -> bool:
    """Return whether a process runs; only where signals can be sent."""
    try:
        os.kill(pid, 0)
    except OSError as e:  # otherwise it is another user's
        return not isinstance(e, ProcessLookupError)
    return True


def _remove(path: PathLike) -> None:
    with suppress(OSError):
        if stat.S_ISDIR(os.lstat(path).st_mode):
            shutil.rmtree(path, ignore_errors=True)
        else:
            Path(path).unlink()


def write_bytes(path: PathLike, data: bytes, force: bool = False) -> None:
    """Write a file atomically; "-" is the standard output."""
    if os.fspath(path) == "-":
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
        return
    replace_files([(path, data)], force)


def check_writable(path: PathLike, force: bool = False) -> None:
    """Raise an error, before any work, if a file cannot be written at this path."""
    name, text = printable(displayed_name(path)), os.fspath(path)
    if text == "-":
        return
    if not text:
        raise ParameterError("an empty file name was given; name the file to write.")
    try:
        target = realpath(path)
        folder = dirname(target)
        exists = lexists(target)
        if isdir(target):
            raise ParameterError(f"{name} is a folder; name a file in it.")
        if exists and not isfile(target):
            raise ParameterError(f"{name} is no ordinary file; name another, or - for the standard output.")
        if exists and not force:
            raise ParameterError(f"{name} exists; name another file, or allow to replace it with --force (force=True).")
        if not isdir(folder):
            raise InputError(f"the folder {printable(folder)} does not exist; make it first, or name another.")
        if len(os.fsencode(basename(target))) > 255:
            raise InputError(f"{name} is too long a name; give at most 255 bytes.")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise ResourceError(f"the folder {printable(folder)} cannot be written; name another one.")
    except ValueError:  # a zero byte in the name
        raise InputError(f"{name} is no name of a file; choose another.") from None
    except OSError as e:
        raise failed(path, e) from None


def replace_files(files: list[tuple[PathLike, bytes]], force: bool) -> None:
    """Write files under temporary names beside their targets; rename them when all are complete."""
    temporary: dict[str, str] = {}
    path: PathLike = ""
    try:
        for path, data in files:
            check_writable(path, force)
            target = realpath(path)
            sweep(dirname(target))
            temporary[target] = temporary_name(dirname(target))
            write_new(temporary[target], data)
            with suppress(OSError):
                os.chmod(temporary[target], os.stat(target).st_mode & 0o777)
        for path, _ in files:
            check_writable(path, force)
            os.replace(temporary[realpath(path)], realpath(path))
    except OSError as e:
        raise failed(path, e) from None
    finally:
        for name in temporary.values():
            remove_temporary(name)


def failed(path: PathLike, e: OSError) -> ResourceError:
    """Return the error for a file that cannot be written."""
    path = displayed_name(path)
    if e.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return ResourceError(f"there is no room for {printable(path)}; free some space, or name another folder.")
    return ResourceError(f"{printable(path)} cannot be written ({reason_of(e)}); name another place.")


def file_size(path: Path, name: str, instead: str = "a sample such as sample:brick") -> int:
    """Return the size of a regular file; InputError for all else, without opening it. `instead`: what may be given."""
    try:
        state = os.stat(path)
    except FileNotFoundError:
        if islink(path):
            raise InputError(f"{name} is a link to a file that does not exist; mend the link.") from None
        raise InputError(f"{name} does not exist; check the name, or give {instead}.") from None
    except (OSError, ValueError) as e:
        raise InputError(f"{name} cannot be opened ({reason_of(e)}); check the name and the permissions.") from None
    if stat.S_ISDIR(state.st_mode):
        raise InputError(f"{name} is a folder; name a file in it.")
    if not stat.S_ISREG(state.st_mode):
        raise InputError(f"{name} is a pipe or a device; name an ordinary file.")
    return state.st_size
