"""What in a folder was woven, by its names; `--force` takes away just that, and only where nothing else is."""

from __future__ import annotations

import json
import os
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..disk.whole import is_file, is_temporary, left_over, open_again
from ..errors import ParameterError, printable

LEDGER, HEADER = "weave.ledger", "weave.header"

_N = "(0|[1-9][0-9]*)"
FILES = re.compile(rf"weave\.(ledger|header)|zarr\.json|c/{_N}/{_N}(/0)?|image\.dzi|image_files/{_N}/{_N}_{_N}\.png")
FOLDERS = re.compile(rf"c(/{_N}){{0,2}}|image_files(/{_N})?")


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
    if not path.is_dir() or any(not is_temporary(e.name) for e in path.iterdir()):
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
    if left_over(place):
        return True
    if not FILES.fullmatch(name) or place.is_symlink() or not place.is_file():
        return False
    return name != "zarr.json" or recipe_in_zarr(place) is not None


def recipe_in_zarr(place: Path) -> dict[str, Any] | None:
    """The description of a zarr array, {} where it is damaged; None where it is no texture."""
    try:
        is_file(place)
        with open_again(place, "rb") as file:
            found = json.loads(file.read(1 << 26))
    except (OSError, ValueError, RecursionError):
        return {}
    attributes = found.get("attributes") if isinstance(found, dict) else None
    return found if isinstance(attributes, dict) and "intarsia" in attributes else None
