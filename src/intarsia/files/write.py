"""Files are written whole or not at all, and nothing is overwritten unless asked."""

from __future__ import annotations

import errno
import os
import sys
from contextlib import suppress
from itertools import count
from typing import Any

import numpy as np

from ..errors import InputError, ParameterError, ResourceError
from ..image import Kind, Plane
from .depth import convert, dtype_of
from .encode import check_holds, encode, holds_recipe
from .formats import format_of, shown
from .recipe import recipe_path

PathLike = str | os.PathLike[str]
_COUNTER = count()


def write(
    path: PathLike,
    picture: Any,
    *,
    depth: int | str | None = None,
    recipe: str | None = None,
    force: bool = False,
) -> None:
    """Write a picture; its ending names the format, and its depth stays as it is unless another is asked for.

    Parameters
    ----------
    path : path, or "-" for the standard output (PNG, or EXR for floats)
    picture : Plane, Synthesis or array
    depth : 8, 16, "half" or "float", optional
        Convert to this depth, rounding to the nearest value.
    recipe : str, optional
        JSON to embed; it lies beside as ``OUT.recipe.json`` where the format holds no text.
    force : bool
        Replace a file that exists.

    Raises
    ------
    ParameterError
        where the format cannot hold the picture, or the file exists.
    InputError, ResourceError
        where the folder does not exist, cannot be written, or is full. An existing file is then untouched.
    """
    plane = as_plane(picture)
    if depth is not None:
        plane = convert(plane, depth)
    if os.fspath(path) == "-":
        data = encode(plane, "exr" if plane.is_float else "png", recipe)
        write_bytes("-", data)
        return
    target = format_of(path)
    check_depth(path, plane)
    check_writable(path, force)
    beside = recipe_path(path)
    inside = recipe is not None and holds_recipe(target, recipe)
    if recipe is not None and not inside:
        check_writable(beside, force)
    files: list[tuple[PathLike, bytes]] = [(path, encode(plane, target.name, recipe))]
    if recipe is not None and not inside:
        files.append((beside, recipe.encode()))
    _put(files, force)
    if force and (recipe is None or inside):
        with suppress(OSError):  # the recipe of what was here before
            os.unlink(beside)


def write_bytes(path: PathLike, data: bytes, force: bool = False) -> None:
    """Write a file whole or not at all; "-" is the standard output."""
    if os.fspath(path) == "-":
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()
        return
    _put([(path, data)], force)


def check_writable(path: PathLike, force: bool = False) -> None:
    """Refuse, before any work, a place where a file cannot be written."""
    name, text = shown(path), os.fspath(path)
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
            raise InputError(f"the folder {shown(folder)} does not exist; make it first, or name another.")
        if len(os.fsencode(os.path.basename(target))) > 255:
            raise InputError(f"{name} is too long a name; give at most 255 bytes.")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise ResourceError(f"the folder {shown(folder)} cannot be written; name another one.")
    except ValueError:  # a zero byte in the name
        raise InputError(f"{name} is no name of a file; choose another.") from None
    except OSError as e:
        raise _failed(path, e) from None


def check_depth(path: PathLike, picture: Any, depth: int | str | None = None) -> None:
    """Refuse, before any work, a picture that the format of a file cannot hold."""
    if os.fspath(path) == "-":
        return
    check_holds(format_of(path), as_plane(picture), None if depth is None else dtype_of(depth))


def as_plane(picture: Any) -> Plane:
    """Take a plane, anything that renders one, or an array."""
    if isinstance(picture, Plane):
        return picture
    if hasattr(picture, "render"):
        return as_plane(picture.render())
    array = np.asarray(picture)
    return Plane(array, Kind.LABEL if array.dtype.name in ("bool", "uint32") else Kind.COLOUR)


def _put(files: list[tuple[PathLike, bytes]], force: bool) -> None:
    """Write files under temporary names beside their targets; only when all are whole, they take their places."""
    temporary: dict[str, str] = {}
    path: PathLike = ""
    try:
        for path, data in files:
            check_writable(path, force)
            target = os.path.realpath(path)
            temporary[target] = _fill(target, data)
        for path, _ in files:
            check_writable(path, force)
            os.replace(temporary[os.path.realpath(path)], os.path.realpath(path))
    except OSError as e:
        raise _failed(path, e) from None
    finally:
        for name in filter(None, temporary.values()):
            with suppress(OSError):
                os.unlink(name)


def _fill(target: str, data: bytes) -> str:
    """Write a new file in the folder of `target`; return its name. It is gone again if that fails."""
    folder, suffix = os.path.dirname(target), os.path.splitext(target)[1][:16]
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    while True:
        name = os.path.join(folder, f".intarsia-{os.getpid()}-{next(_COUNTER)}{suffix}")
        try:
            number = os.open(name, flags, 0o666)
            break
        except FileExistsError:
            continue
    try:
        with os.fdopen(number, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        with suppress(OSError):
            os.chmod(name, os.stat(target).st_mode & 0o777)
    except BaseException:
        with suppress(OSError):
            os.unlink(name)
        raise
    return name


def _failed(path: PathLike, e: OSError) -> ResourceError:
    if e.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return ResourceError(f"there is no room for {shown(path)}; free some space, or name another folder.")
    return ResourceError(f"{shown(path)} cannot be written ({(e.strerror or str(e)).lower()}); name another place.")
