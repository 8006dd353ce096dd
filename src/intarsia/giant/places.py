"""Where a folder may be written: what in one was woven is told by its names, and nothing else is ever taken away."""

from __future__ import annotations

import os
import re
from pathlib import Path

from ..disk import whole
from ..errors import InputError, ParameterError, ResourceError, printable

_N = "(0|[1-9][0-9]*)"
FILES = re.compile(rf"zarr\.json|c/{_N}/{_N}(/0)?|image\.dzi(\.recipe\.json)?|image_files/{_N}/{_N}_{_N}\.png")
FOLDERS = re.compile(rf"c(/{_N}){{0,2}}|image_files(/{_N})?")


def check_place(path: Path, woven: bool = False) -> None:
    """Refuse a place that cannot be written, or where anything lies but an empty folder.

    `woven`: what was woven there, and nothing else, is to be replaced.
    """
    try:
        folder = Path(os.path.realpath(path)).parent
        if len(os.fsencode(path.name)) > 240:
            raise InputError(f"{path} is too long a name; give at most 240 bytes.")
        if not folder.is_dir():
            raise InputError(f"the folder of {path} does not exist; make it first, or name another.")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise ResourceError(f"the folder of {path} cannot be written; name another one.")
    except ValueError:  # a zero byte in the name
        raise InputError(f"{str(path)!r} is no name of a file; choose another.") from None
    if woven:
        _check_woven(path)
    elif os.path.lexists(path) and not (path.is_dir() and all(whole.is_temporary(e.name) for e in path.iterdir())):
        raise ParameterError(f"{path} exists, and is no texture that was woven; name another place.")


def _check_woven(path: Path) -> None:
    """Refuse to replace a folder that holds anything which was not woven."""
    for at, below, here in os.walk(path):
        for entry in sorted(below + here):
            full = Path(at, entry)
            place, names = full.relative_to(path), FOLDERS if entry in below else FILES
            plain = (full.is_dir() or full.is_file()) and not full.is_symlink()
            if not ((plain and names.fullmatch(place.as_posix())) or whole.left_over(full)):
                raise ParameterError(
                    f"{path} holds {printable(place)}, which was not woven; move it elsewhere, or name another place."
                )
