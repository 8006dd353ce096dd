"""What lies at a path, before anything is opened; files written whole or not at all, over others only if asked."""

from __future__ import annotations

import errno
import os
import stat
import sys
from contextlib import suppress
from pathlib import Path

from ..errors import InputError, ParameterError, ResourceError, printable
from . import whole

PathLike = str | os.PathLike[str]


def write_bytes(path: PathLike, data: bytes, force: bool = False) -> None:
    """Write a file whole or not at all; "-" is the standard output."""
    if os.fspath(path) == "-":
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
        return
    put_all([(path, data)], force)


def check_writable(path: PathLike, force: bool = False) -> None:
    """Refuse, before any work, a place where a file cannot be written."""
    name, text = printable(whole.asked_for(path)), os.fspath(path)
    if text == "-":
        return
    if not text:
        raise ParameterError("an empty file name was given; name the file to write.")
    try:
        target = os.path.realpath(path)
        folder = os.path.dirname(target)
        exists = os.path.lexists(target)
        if os.path.isdir(target):
            raise ParameterError(f"{name} is a folder; name a file in it.")
        if exists and not os.path.isfile(target):
            raise ParameterError(f"{name} is no ordinary file; name another, or - for the standard output.")
        if exists and not force:
            raise ParameterError(f"{name} exists; name another file, or allow to replace it with --force (force=True).")
        if not os.path.isdir(folder):
            raise InputError(f"the folder {printable(folder)} does not exist; make it first, or name another.")
        if len(os.fsencode(os.path.basename(target))) > 255:
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
            target = os.path.realpath(path)
            whole.sweep(os.path.dirname(target))
            temporary[target] = whole.name_in(os.path.dirname(target))
            whole.fill(temporary[target], data)
            with suppress(OSError):
                os.chmod(temporary[target], os.stat(target).st_mode & 0o777)
        for path, _ in files:
            check_writable(path, force)
            os.replace(temporary[os.path.realpath(path)], os.path.realpath(path))
    except OSError as e:
        raise _failed(path, e) from None
    finally:
        for name in temporary.values():
            whole.take_away(name)


def _failed(path: PathLike, e: OSError) -> ResourceError:
    path = whole.asked_for(path)
    if e.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return ResourceError(f"there is no room for {printable(path)}; free some space, or name another folder.")
    return ResourceError(f"{printable(path)} cannot be written ({(e.strerror or str(e)).lower()}); name another place.")


def ordinary(path: Path, name: str, instead: str = "a sample such as sample:brick") -> int:
    """Return the size of an ordinary file, and refuse all else without opening it; `instead` is what may be given."""
    try:
        state = os.stat(path)
    except FileNotFoundError:
        if os.path.islink(path):
            raise InputError(f"{name} is a link to a file that does not exist; mend the link.") from None
        raise InputError(f"{name} does not exist; check the name, or give {instead}.") from None
    except (OSError, ValueError) as e:
        reason = getattr(e, "strerror", None) or str(e)
        raise InputError(f"{name} cannot be opened ({reason.lower()}); check the name and the permissions.") from None
    if stat.S_ISDIR(state.st_mode):
        raise InputError(f"{name} is a folder; name a file in it.")
    if not stat.S_ISREG(state.st_mode):
        raise InputError(f"{name} is a pipe or a device; name an ordinary file.")
    return state.st_size
