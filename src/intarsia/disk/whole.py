"""Files appear whole or not at all, over others only if asked; what lies at a path is known before it is opened.

This is the one place for temporary files, and what killed runs left is swept.

A temporary name says who writes there: ``.intarsia-HOST-PID-CHANCE`` beside an output, ``intarsia-HOST-PID-CHANCE``
below TMPDIR. So the next run sees which writers are dead. A name is chosen before anything is made under it, and the
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
"""How temporary names begin: beside outputs, and below TMPDIR."""

_NAME = re.compile(r"(\.?intarsia-)([0-9a-f]{8})-([1-9][0-9]{0,8})-[0-9a-f]{16}")
_FOLLOW_NOTHING = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
_swept: set[tuple[int, str]] = set()
_asked: dict[str, str] = {}  # file under way -> the name that was asked for


@cache
def host() -> str:
    """Name this machine and its space of process ids, in 8 digits: where it is equal, a pid means the same process."""
    space = ""
    with suppress(OSError):
        space = os.readlink("/proc/self/ns/pid")
    return hashlib.blake2b(f"{platform.node()} {space}".encode(errors="replace"), digest_size=4).hexdigest()


def name_in(folder: PathLike, mark: str = HIDDEN) -> str:
    """Choose a new temporary name in a folder, that nobody can guess; nothing is made yet."""
    return join(folder, f"{mark}{host()}-{os.getpid()}-{os.urandom(8).hex()}")


def is_file(path: PathLike) -> bool:
    """Tell whether an ordinary file lies here, False for nothing; ParameterError for links, folders, pipes and devices.

    For files whose names are ours: whoever put something else there is not followed, and loses nothing.
    """
    try:
        mode = os.lstat(path).st_mode
    except (FileNotFoundError, NotADirectoryError):
        return False
    if stat.S_ISREG(mode):
        return True
    found = "a link" if stat.S_ISLNK(mode) else "a folder" if stat.S_ISDIR(mode) else "a pipe, a socket or a device"
    raise ParameterError(f"{printable(path)} is {found}, no ordinary file; move it elsewhere, or name another place.")


def open_again(path: PathLike, mode: str = "r+b") -> BinaryIO:
    """Open an ordinary file to read and change it, or only to read it ("rb"); follows no link, waits for no pipe."""
    is_file(path)
    number = os.open(path, (os.O_RDONLY if mode == "rb" else os.O_RDWR) | _FOLLOW_NOTHING)
    file = cast(BinaryIO, os.fdopen(number, mode))
    if not stat.S_ISREG(os.fstat(number).st_mode):  # put there since it was looked at
        file.close()
        is_file(path)
    return file


def put(path: PathLike, data: bytes, durable: bool = False, by: PathLike | None = None) -> None:
    """Write a file whole or not at all, in the place of the ordinary file that may be there.

    `durable`: on return it has survived a loss of power, name and content. `by`: the folder to prepare it in, of the
    same file system. OSError where that fails, ParameterError where no ordinary file lies; what was there is untouched.
    """
    folder = dirname(abspath(path))
    draft = name_in(folder if by is None else by)
    try:
        fill(draft, data, durable)
        is_file(path)
        os.replace(draft, path)
    except BaseException:
        take_away(draft)
        raise
    if durable:
        settle(folder)


def fill(path: PathLike, data: bytes, durable: bool = True) -> None:
    """Write a new file; with `durable`, its content has reached the disk.

    FileExistsError where anything lies, even a link that leads nowhere.
    """
    number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _FOLLOW_NOTHING, 0o666)
    with os.fdopen(number, "wb") as file:
        file.write(data)
        if durable:
            sync(file)


def sync(file: BinaryIO) -> None:
    """Wait until what was written lies on the disk."""
    file.flush()
    os.fsync(file.fileno())


def settle(folder: PathLike) -> None:
    """Wait until the names in a folder lie on the disk, where the system can do that."""
    with suppress(OSError):
        number = os.open(folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
        try:
            os.fsync(number)
        finally:
            os.close(number)


def take_away(path: PathLike) -> None:
    """Remove a temporary file or folder, if it is there; never fails, follows no link."""
    try:
        _remove(path)
    except BaseException:  # a signal, just now: once more, so that nothing stays
        _remove(path)
        raise


@contextmanager
def working_folder() -> Iterator[str]:
    """Lend an empty folder below TMPDIR; it is gone afterwards, however the work ends."""
    parent = tempfile.gettempdir()
    sweep(parent, PLAIN)
    name = name_in(parent, PLAIN)
    try:
        try:
            os.mkdir(name, 0o700)
        except OSError as e:
            raise ResourceError(f"no folder can be made in {printable(parent)} ({reason_of(e)}); set TMPDIR.") from None
        yield name
    finally:
        take_away(name)


def sweep(folder: PathLike, mark: str = HIDDEN) -> None:
    """Take away what runs of this user and machine left that were killed; once for each folder and process.

    Only what bears exactly such a name, belongs to us, and whose process is gone; never a link, never anything else.
    """
    place = join(abspath(folder), mark)
    if (os.getpid(), place) in _swept:
        return
    _swept.add((os.getpid(), place))
    with suppress(OSError), os.scandir(folder) as found:
        for name in [e.name for e in found if e.name.startswith(mark)]:
            if left_over(join(folder, name)):
                take_away(join(folder, name))


def left_over(path: PathLike) -> bool:
    """Say whether a run left this that does not live any more: by its name, its owner, and what it is."""
    match = _NAME.fullmatch(basename(path))
    if match is None or match[2] != host() or not hasattr(os, "getuid"):
        return False
    try:
        state = os.lstat(path)
    except OSError:
        return False
    ordinary = stat.S_ISREG(state.st_mode) or stat.S_ISDIR(state.st_mode)
    return ordinary and state.st_uid == os.getuid() and not _lives(int(match[3]))


def is_temporary(name: str) -> bool:
    """Say whether a file name is one of those that are given here."""
    return _NAME.fullmatch(name) is not None


def asked_for(path: PathLike, name: PathLike | None = None) -> str:
    """The name that messages give to a file: the one that was asked for, which `name` tells beforehand."""
    text = os.fspath(path)
    if name is not None:
        _asked[text] = os.fspath(name)
    for staged, asked in _asked.items():  # the file, or a recipe beside it
        if text == staged or text.startswith(staged + "."):
            return asked + text[len(staged) :]
    return text


def forget(path: PathLike) -> None:
    """A file under way is done; its name means itself again."""
    _asked.pop(os.fspath(path), None)


def _lives(pid: int) -> bool:
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
    """Write a file whole or not at all; "-" is the standard output."""
    if os.fspath(path) == "-":
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
        return
    put_all([(path, data)], force)


def check_writable(path: PathLike, force: bool = False) -> None:
    """Refuse, before any work, a place where a file cannot be written."""
    name, text = printable(asked_for(path)), os.fspath(path)
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
        raise _failed(path, e) from None


def put_all(files: list[tuple[PathLike, bytes]], force: bool) -> None:
    """Write files under temporary names beside their targets; only when all are whole, they take their places."""
    temporary: dict[str, str] = {}
    path: PathLike = ""
    try:
        for path, data in files:
            check_writable(path, force)
            target = realpath(path)
            sweep(dirname(target))
            temporary[target] = name_in(dirname(target))
            fill(temporary[target], data)
            with suppress(OSError):
                os.chmod(temporary[target], os.stat(target).st_mode & 0o777)
        for path, _ in files:
            check_writable(path, force)
            os.replace(temporary[realpath(path)], realpath(path))
    except OSError as e:
        raise _failed(path, e) from None
    finally:
        for name in temporary.values():
            take_away(name)


def _failed(path: PathLike, e: OSError) -> ResourceError:
    path = asked_for(path)
    if e.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return ResourceError(f"there is no room for {printable(path)}; free some space, or name another folder.")
    return ResourceError(f"{printable(path)} cannot be written ({reason_of(e)}); name another place.")


def ordinary(path: Path, name: str, instead: str = "a sample such as sample:brick") -> int:
    """Return the size of an ordinary file, and refuse all else without opening it; `instead` is what may be given."""
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
