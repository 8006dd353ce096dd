"""Where results go: names from templates, checks before the work, and all files of a result at once or none."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from .. import files
from ..errors import ParameterError, ResourceError
from .exits import unbroken

FIELDS = ("stem", "seed", "method", "w", "h")


def filled(template: str, values: Mapping[str, object]) -> str:
    """Put values into {stem}, {seed}, {method}, {w} and {h} of a file name."""

    def value(match: re.Match[str]) -> str:
        if match[1] not in FIELDS:
            raise ParameterError(f"{template}: {match[0]} is unknown; use {', '.join('{' + f + '}' for f in FIELDS)}.")
        return str(values[match[1]])

    return re.sub(r"\{([^{}]*)\}", value, template)


def plane_files(out: str, planes: Mapping[str, str]) -> dict[str, str]:
    """Name the file of each plane: the base is `out`, the others lie beside it, in the format they came in."""
    names = [name for name in planes if name != "mask"]
    if out == "-":
        if len(names) > 1:
            raise ParameterError(f"-o - holds one picture, here are {len(names)} planes; name a file.")
        return {names[0]: out}
    stem, own = os.path.splitext(out)
    return {name: f"{stem}_{name}{_ending(planes[name], own)}" if n else out for n, name in enumerate(names)}


def _ending(path: str, otherwise: str) -> str:
    ending = "" if path.startswith("sample:") else os.path.splitext(path)[1]
    try:
        files.format_of("x" + ending)
    except ParameterError:  # a format that is read but not written
        return otherwise
    return ending


def check_all(paths: Iterable[str], force: bool, seen: set[str]) -> None:
    """Refuse files that cannot be written, and any that would be written twice; `seen` remembers the places."""
    for path in paths:
        place = os.path.realpath(path)
        if path != "-" and place in seen:
            raise ParameterError(
                f"{path} would be written twice; put {{stem}} or {{seed}} into the name, or choose different names."
            )
        seen.add(place)
        files.check_writable(path, force)


class Staging:
    """Files under way: written beside their places under a hidden folder, then moved there all at once."""

    def __init__(self, force: bool) -> None:
        self._force = force
        self._folders: dict[str, str] = {}
        self._moves: list[tuple[str, str]] = []

    def __enter__(self) -> Staging:
        return self

    def __exit__(self, kind: type[BaseException] | None, e: BaseException | None, trace: TracebackType | None) -> None:
        with unbroken():
            for folder in self._folders.values():
                shutil.rmtree(folder, ignore_errors=True)

    def place(self, path: str) -> str:
        """Return where to write the file that will be `path`."""
        target = os.path.realpath(path)
        folder = os.path.dirname(target)
        if folder not in self._folders:
            try:
                with unbroken():
                    self._folders[folder] = tempfile.mkdtemp(prefix=".intarsia-", dir=folder)
            except OSError as e:
                reason = (e.strerror or str(e)).lower()
                raise ResourceError(f"{folder} cannot be written ({reason}); name another folder.") from None
        staged = os.path.join(self._folders[folder], os.path.basename(target))
        self._moves.append((staged, target))
        return staged

    def commit(self) -> None:
        """Move all files to their places; if one cannot be moved, take the others away again."""
        moves = [m for staged, target in self._moves for m in _with_recipe(staged, target)]
        for staged, target in moves:
            if os.path.exists(staged):
                files.check_writable(target, self._force)
        done: list[str] = []
        with unbroken():
            try:
                for staged, target in moves:
                    if not os.path.exists(staged):  # no recipe lies beside the new file: that of the old is wrong
                        if self._force:
                            with suppress(OSError):
                                os.unlink(target)
                        continue
                    with suppress(OSError):
                        shutil.copymode(target, staged)
                    new = not os.path.lexists(target)
                    os.replace(staged, target)
                    done += [target] * new
            except OSError as e:
                for target in done:
                    with suppress(OSError):
                        os.unlink(target)
                reason = (e.strerror or str(e)).lower()
                raise ResourceError(f"{target} cannot be written ({reason}); name another place.") from None


def _with_recipe(staged: str, target: str) -> list[tuple[str, str]]:
    pairs = [(staged, target)]
    if not Path(target).name.endswith((".npz", ".json")):
        pairs.append((str(files.recipe_path(staged)), str(files.recipe_path(target))))
    return pairs
