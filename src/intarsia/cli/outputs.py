"""Output files: names from templates, checks before the work, and a staging area that commits atomically."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from os.path import basename, dirname, exists, isdir, join, lexists, realpath, splitext
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import files
from ..disk import atomic, reason_of
from ..foundation import ParameterError, ResourceError, printable
from ..foundation.arrays import Pair
from ..model import Exemplar
from ..model.image import Kind, Plane
from ..request import Request
from . import Report, unbroken
from .exemplars import Inputs, PlaneFiles, sets_of, stem_of

if TYPE_CHECKING:
    from ..tasks.scoring import Outcome

FIELDS = ("stem", "seed", "method", "w", "h")


def filled_name(template: str, values: Mapping[str, object]) -> str:
    """Fill {stem}, {seed}, {method}, {w} and {h} of a file name; with nothing if there is no value."""

    def value(match: re.Match[str]) -> str:
        if match[1] not in FIELDS:
            raise ParameterError(f"{template}: {match[0]} is unknown; use {', '.join('{' + f + '}' for f in FIELDS)}.")
        return str(values.get(match[1], ""))

    return re.sub(r"\{([^{}]*)\}", value, template)


def plane_files(out: str, planes: PlaneFiles) -> PlaneFiles:
    """Return the file of each plane: `out` for the base, OUT_NAME in the format of the input for the others.

    Names that say DirectX, or proposed, do so again.
    """
    names = [name for name in planes if name != "mask"]
    if out == "-":
        if len(names) > 1:
            raise ParameterError(f"-o - holds one picture, here are {len(names)} planes; name a file.")
        return {names[0]: out}
    stem, own = splitext(out)
    words = {name: name + files.material_sets.marks_of(planes[name]) for name in names}
    return {name: f"{stem}_{words[name]}{_ending(planes[name]) or own}" if n else out for n, name in enumerate(names)}


def _ending(path: str) -> str:
    """Return the ending of an input file, if files of that format are written; else "", as for built-in samples."""
    ending = "" if path.startswith("sample:") else splitext(files.formats.split_layer(path)[0])[1]
    return ending if ending.lower() in files.formats.SUFFIXES else ""


def usual_name(sets: Sequence[PlaneFiles], done: str, seed: int | None = None) -> str:
    """Return the default name of an output, without ending: stones_grown.

    It has the names of all exemplars, or of the first of more than three; the standard input has none. `seed` is added
    if there are several.
    """
    stems = [stem_of(found) for found in sets if next(iter(found.values())) != "-"]
    if len(stems) > 3:
        stems[1:] = [f"{len(stems) - 1}_more"]
    return "_".join([*stems, done, *([] if seed is None else [str(seed)])])


def usual_ending(path: str, plane: Plane, times: float, depth: str | None) -> str:
    """Return the ending of the input if its format is lossless and holds the result, `times` longer; else another."""
    for ending in (_ending(path).lower(), ".png", ".exr"):
        kept = files.formats.SUFFIXES.get(ending)
        if kept is not None and kept.lossless and max(plane.height, plane.width) * times <= kept.side:
            with suppress(ParameterError):
                files.check_depth("x" + ending, plane, depth)
                return ending
    return ".tif"


def check_depths(pictures: PlaneFiles, exemplar: Exemplar, size: Pair, request: Request) -> None:
    """Raise ParameterError for depths, channels and sides that files cannot hold; `size`: width, height of the base."""
    for name, path in pictures.items():
        plane = exemplar.picture(name)
        assert plane is not None
        width, height = (side * plane.width // (exemplar.width * request.magnify) for side in size)
        files.check_depth(path, plane, request.depth, (width, height))


def _twice(path: str) -> ParameterError:
    return ParameterError(
        f"{path} would be written twice; put {{stem}} or {{seed}} into the name, or choose different names."
    )


def check_all(paths: Iterable[str], force: bool, seen: set[str], making: bool = False) -> None:
    """Raise an error if a file cannot be written, or would be written twice; `seen` collects the places.

    `making`: missing folders will be made.
    """
    for path in paths:
        place = realpath(path)
        if path != "-" and place in seen:
            raise _twice(path)
        seen.add(place)
        check_place(path, force, making)


def check_place(path: str, force: bool, making: bool) -> None:
    """Raise an error if a file cannot be written; with `making` its folder may be missing if it can be made."""
    folder = dirname(realpath(path))
    if not making or lexists(folder):
        files.check_writable(path, force)
        return
    while not lexists(folder):
        folder = dirname(folder)
    if not isdir(folder):
        raise ParameterError(f"{printable(folder)} is no folder; name another place.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ResourceError(f"the folder {printable(folder)} cannot be written; name another one.")


class Staging:
    """Files written to hidden folders beside their places, and moved there together by :meth:`commit`."""

    def __init__(self, force: bool, making: bool = False) -> None:
        self._force, self._making = force, making
        self._made: list[str] = []
        self._folders: PlaneFiles = {}
        self._moves: list[tuple[str, str]] = []

    def __enter__(self) -> Staging:
        return self

    def __exit__(self, *error: object) -> None:
        with unbroken():
            for folder in self._folders.values():
                atomic.remove_temporary(folder)
            for staged, _ in self._moves:
                atomic.forget_name(staged)
            for folder in reversed(self._made):
                with suppress(OSError):
                    os.rmdir(folder)  # only where nothing lies in it

    def place(self, path: str) -> str:
        """Return the path at which to write the file `path`; the standard output (-) is written at once."""
        if path == "-":
            return path
        target = realpath(path)
        folder = dirname(target)
        if folder not in self._folders:
            if self._making:
                self._make(folder)
            atomic.sweep(folder)
            name = self._folders[folder] = atomic.temporary_name(folder)
            try:
                os.mkdir(name, 0o700)
            except OSError as e:
                del self._folders[folder]
                raise ResourceError(f"{folder} cannot be written ({reason_of(e)}); name another folder.") from None
        staged = join(self._folders[folder], basename(target))
        self._moves.append((staged, target))
        atomic.displayed_name(staged, path)
        return staged

    def _make(self, folder: str) -> None:
        """Make a folder and its missing parents; they are removed again if nothing is written there."""
        if isdir(folder):
            return
        self._make(dirname(folder))
        self._made.append(folder)
        try:
            os.mkdir(folder)
        except FileExistsError:  # another run was quicker
            self._made.pop()
        except OSError as e:
            raise ResourceError(f"{printable(folder)} cannot be made ({reason_of(e)}); name another folder.") from None

    def commit(self) -> None:
        """Move all files to their places; if one cannot be moved, remove the others again."""
        moves = [(f"{s}{own}", f"{target}{own}") for s, target in self._moves for own in ("", files.RECIPE)]
        for staged, target in moves:
            if exists(staged):
                files.check_writable(target, self._force)
        done: list[str] = []
        with unbroken():
            try:
                for staged, target in moves:
                    if not exists(staged):  # no recipe lies beside the new file: that of the old is wrong
                        if self._force:
                            with suppress(OSError):
                                os.unlink(target)
                        continue
                    with suppress(OSError):
                        shutil.copymode(target, staged)
                    new = not lexists(target)
                    os.replace(staged, target)
                    done += [target] * new
            except OSError as e:
                for target in done:
                    with suppress(OSError):
                        os.unlink(target)
                raise ResourceError(f"{target} cannot be written ({reason_of(e)}); name another place.") from None


def write_page(staging: Staging, path: str, found: Outcome) -> None:
    """Write the report on an output."""
    from ..tasks.report import page_of

    files.write_bytes(staging.place(path), page_of(found).encode("utf-8", "replace"))


def files_of(stem: str, exemplar: Exemplar) -> dict[str, Plane]:
    """Return the files of an exemplar whose names begin with `stem`: one of each plane, and its mask."""
    planes = dict(exemplar.planes)
    if exemplar.usable is not None:
        planes["mask"] = Plane(exemplar.usable.astype(np.uint8) * np.uint8(255), Kind.LABEL)
    more, word = len(planes) > 1, files.material_sets.word_of
    return {stem + f"_{word(n, p)}" * more + usual_ending("x.png", p, 1, None): p for n, p in planes.items()}


def write_sets(request: Request, report: Report, made: Callable[[Exemplar, PlaneFiles], Any]) -> None:
    """Write all that is made of the sets of a request, or nothing.

    `made` returns pictures and texts by path, and lines to tell.
    """
    written, told = set[str](), list[str]()
    with Staging(request.force, making=True) as staging:
        for found in sets_of(request, report):
            pictures, lines = made(Inputs([found], request, report).exemplars[0], found)
            check_all(pictures, request.force, written, making=True)
            for path, held in pictures.items():
                if isinstance(held, str):
                    files.write_bytes(staging.place(path), held.encode())
                else:
                    files.write(staging.place(path), held)
            told += lines
        staging.commit()
    for line in [", ".join(sorted(written)), *told]:
        report.note(line)
    report.result({"files": sorted(written), "told": told})
