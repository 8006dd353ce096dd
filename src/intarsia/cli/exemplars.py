"""From files on the command line to exemplars: which belong together, what they are called, reading them once."""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import files
from ..errors import InputError, ParameterError
from ..exemplar import Exemplar
from ..geometry import Wrap
from ..guide import Guide, numbered
from ..image import Kind, Plane
from ..rendering.mixing import off_unit
from ..request.recipe import inputs_of
from ..request.request import Request
from ..tasks.starts import grown_hole
from .adapt import Warn, adapted
from .report import Report

NO_NORMALS = 0.15
"""Vectors of normal maps are less off length 1 on average, even if they were reduced or strongly compressed."""

Set = dict[str, str]
"""The files of one exemplar: plane -> path, the base first; ``mask`` says which pixels are usable."""


def sets_of(request: Request, report: Report) -> list[Set]:
    """Sort the files into exemplars, add what --map and --mask name, and tell how they were read."""
    sets = _grouped(request.files, request.how)
    by_name: dict[str, list[str]] = {}
    for name, path in [*request.maps, *(("mask", path) for path in request.masks)]:
        by_name.setdefault(name, []).append(path)
    for name, paths in by_name.items():
        option = "--mask" if name == "mask" else f"--map {name}="
        check_each(option, len(paths), len(sets))
        for found, path in zip(sets, paths, strict=True):
            if name in found:
                raise ParameterError(f"{option}: {found[name]} already is the plane {name}; drop one of the two.")
            found[name] = path
    if len(request.files) > 1 or os.path.isdir(request.files[0]):
        for line in files.describe([{**found} for found in sets]).splitlines():
            report.note(line)
    return sets


def check_each(option: str, given: int, several: int) -> None:
    """Refuse an option that is not given once for each exemplar."""
    if given != several:
        number = f"{given} given for {several} exemplar{'s' * (several > 1)}"
        raise ParameterError(f"{option}: {number}; give it once for each, in the same order.")


def donors_of(request: Request) -> list[Set]:
    """Sort the files of --from into exemplars."""
    return _grouped(request.donors, "auto")


def _grouped(paths: tuple[str, ...], how: str) -> list[Set]:
    return [{name: os.fspath(path) for name, path in found.items()} for found in files.group(paths, how)]


def stem_of(found: Set) -> str:
    """Return what {stem} stands for: the file name, or what the files of a set share, be it only their folder."""
    pictures = [path for name, path in found.items() if name != "mask"]
    first = pictures[0]
    if first == "-":
        return "stdin"
    if first.startswith("sample:"):
        return first.removeprefix("sample:").partition(files.formats.LAYER)[0]
    if len(pictures) == 1:
        return Path(files.formats.split_layer(first)[0]).stem
    first_file = Path(files.formats.split_layer(first)[0])
    return files.sets.name_of(first)[0] or first_file.parent.name or first_file.stem


class Held:
    """Exemplars that the commands of one process share: what was found in one is not looked for again.

    They are a few, of so many pixels together, each for so many commands, as what is known of it grows by them. One is
    read anew when a file of it has changed.
    """

    def __init__(self, most: int = 4, pixels: int = 1 << 23, uses: int = 64) -> None:
        self._most, self._pixels, self._uses = most, pixels, uses
        self._known: OrderedDict[tuple[Any, ...], tuple[Exemplar, list[str], int]] = OrderedDict()

    def get(self, key: tuple[Any, ...], read: Callable[[Warn], Exemplar], warn: Warn) -> Exemplar:
        """Return the exemplar that is known by a key, or read it; what it warns of is told either way."""
        exemplar, told, uses = self._known.pop(key, (None, list[str](), 0))
        if exemplar is None or uses >= self._uses:
            told, uses = [], 0
            exemplar = read(told.append)
        self._known[key] = exemplar, told, uses + 1
        while len(self._known) > self._most or (self._known and self._sum() > self._pixels):
            self._known.popitem(last=False)
        for line in told:
            warn(line)
        return exemplar

    def _sum(self) -> int:
        return sum(e.height * e.width for e, _, _ in self._known.values())


_held: Held | None = None


def hold(held: Held | None) -> None:
    """Have the commands of this process share exemplars from now on; None: each reads its own."""
    global _held
    _held = held


def _signs(found: Set) -> tuple[Any, ...] | None:
    """What tells whether the files of an exemplar are still the same; None where that cannot be told."""
    signs = []
    for path in found.values():
        if path.startswith("sample:"):
            continue
        try:
            stat = os.stat(path)
        except OSError:  # the standard input, a layer of a file
            return None
        signs.append((stat.st_dev, stat.st_ino, stat.st_size, stat.st_mtime_ns))
    return tuple(signs)


class Shelf:
    """Reads exemplars when they are asked for and keeps the last, so that a long batch does not fill memory."""

    def __init__(self, lots: list[list[Set]], request: Request, report: Report) -> None:
        self.lots, self.request, self._report = lots, request, report
        self._held: tuple[int, tuple[Exemplar, ...]] | None = None

    def get(self, number: int) -> tuple[Exemplar, ...]:
        """Return the exemplars of a lot, cropped and reduced as asked."""
        if self._held is None or self._held[0] != number:
            self._held = None
            self._held = (number, tuple(self._read(found, number, n) for n, found in enumerate(self.lots[number])))
        return self._held[1]

    def hole(self, number: int, base: Plane, name: str) -> NDArray[np.bool_]:
        """Read the hole of the picture of a lot, whose base plane is `base`."""
        holes = self.request.holes
        return hole_of(holes[number if len(holes) > 1 else 0], self.lots[number][0], base, name)

    def guide(self, lot: int) -> Guide:
        """Read the label pictures of a lot and the target; those are as large as the exemplars, and cut as they are."""
        labels, target_path = self.request.labels, self.request.target
        assert target_path is not None
        check_each("--labels", len(labels), sum(map(len, self.lots)))
        sources = labels if len(self.lots) == 1 else labels[lot : lot + 1]
        paths = (*sources, target_path)
        planes = [files.read_plane(path, Kind.LABEL) for path in paths]
        for path, plane, found, e in zip(sources, planes, self.lots[lot], self.get(lot), strict=False):
            first, whole = next(iter(found.values())), self.request.crop is None and self.request.scale == 1
            size = e.base if whole else files.read_plane(first)
            if (plane.width, plane.height) != (size.width, size.height):
                said = f"{plane.width}x{plane.height} px, {first} is {size.width}x{size.height}"
                raise InputError(f"the labels {path} are {said}; make them equal.")
        *beside, target = numbered(list(zip(paths, planes, strict=True)), self.warn)
        asked = replace(self.request, avoid=None, toroidal=False)
        alone = [Exemplar.of({"labels": plane}, name=path) for path, plane in zip(sources, beside, strict=True)]
        cut = [adapted(e, asked, lambda line: None).base for e in alone]
        return Guide(cut, target, self.request.weight, self.request.reach)

    def warn(self, *lines: str) -> None:
        """Tell of what may be wrong, once."""
        for line in lines:
            if line not in self._report.warnings:
                self._report.warn(line)

    def _read(self, found: Set, number: int, n: int) -> Exemplar:
        def unused(base: Plane, name: str) -> NDArray[np.bool_]:
            """What of a picture is filled anew, so that it does not matter what is there."""
            return grown_hole(self.hole(number, base, name), self.request.grow or 0, Wrap(self.request.closing))

        healed = self.request.holes and not n

        def read(warn: Warn) -> Exemplar:
            exemplar = files.read_set(
                found, alpha=self.request.alpha, unused=unused if healed else None, channels=self.request.packed,
                weights=dict(self.request.weights),
            )  # fmt: skip
            for name, path in found.items():
                plane = exemplar.planes.get(name)
                if plane is not None and plane.kind is Kind.NORMAL and (off := off_unit(plane)) > NO_NORMALS:
                    warn(f"{path} is no normal map, as it seems: its vectors are {off:.2f} off length 1 on average.")
            return adapted(exemplar, self.request, warn)

        signs, before = None if _held is None or healed else _signs(found), list(self._report.warnings)

        def tell(line: str) -> None:
            if line not in before:
                self._report.warn(line)

        if _held is None or signs is None:
            return read(tell)
        return _held.get((repr(inputs_of(self.request)), repr(found), signs), read, tell)


def hole_of(mask: str, found: dict[str, str], base: Plane, name: str) -> NDArray[np.bool_]:
    """Read which pixels (H, W) of the set `found` are to be healed; `mask` is a file, or ``alpha``."""
    if mask != "alpha":
        hole = files.read_mask(mask, base, name)
        if not hole.any() or hole.all():
            what, remedy = ("covers all", "leave some of it") if hole.all() else ("marks nothing", "mark what is to go")
            size = f"{base.width}x{base.height} px"
            raise InputError(f"the hole {mask} {what} of {name} ({size}); {remedy}: white is healed.")
        return hole
    first = next(n for n in found if n != "mask")
    opaque = files.read_set({first: found[first]}, alpha="mask").usable
    return np.zeros((base.height, base.width), bool) if opaque is None else ~opaque
