"""Files of a command line as exemplars: grouped into sets of planes, read once, cropped, reduced and evenly lit."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from .. import files
from ..foundation import InputError, ParameterError
from ..foundation.arrays import Mask, Pair
from ..foundation.geometry import Wrap
from ..model import Exemplar
from ..model.canvas import Guide, numbered
from ..model.image import Kind, Plane
from ..rendering.blending import off_unit
from ..request import Request, inputs_of
from ..synthesis import Plan, Scene
from ..tasks import plan_of, scene_of
from . import Report

Warn = Callable[[str], None]

MUCH = 0.01  # of the pixels


def adapted(exemplar: Exemplar, asked: Request, warn: Warn) -> Exemplar:
    """Return the exemplar as a request uses it: without the avoided colour, cropped, reduced, evenly lit, magnified."""
    exemplar = replace(exemplar, toroidal=asked.toroidal)
    if asked.avoid is not None:
        exemplar = avoiding(exemplar, asked.avoid, warn)
    if asked.crop is not None:
        exemplar = cropped(exemplar, asked.crop)
    if asked.scale != 1:
        from ..rendering.magnification import reduced

        said = f"--scale 1/{asked.scale}", "scale less", "drop --toroidal, or scale otherwise"
        exemplar = reduced(exemplar, asked.scale, *said)
    if asked.flatten:
        from ..analysis.illumination import clipped, flattened

        lit, exemplar = exemplar, flattened(exemplar)
        share = clipped(lit.base, exemplar.base)
        if share > MUCH:
            warn(
                f"--flatten: {100 * share:.0f} % of {exemplar.name} became brighter than white and was cut off there; "
                "an exemplar of floats (.exr) keeps it."
            )
    n = asked.magnify
    if n == 1:
        return exemplar
    from ..rendering.magnification import magnified

    made = magnified(exemplar, n)
    width, height = made.width * n, made.height * n
    if (width, height) != (exemplar.width, exemplar.height):
        warn(f"--magnify {n}: {_named(exemplar)} was cut to {width}x{height} px, which {n} divides.")
    return made


def avoiding(exemplar: Exemplar, colour: tuple[int, int, int], warn: Warn) -> Exemplar:
    """Return the exemplar with the pixels of exactly this colour unusable."""
    base = exemplar.base
    if base.is_float:
        raise ParameterError(f"--avoid: {exemplar.name} has float pixels; mark what to avoid in a --mask instead.")
    wide = 257 if base.pixels.dtype == np.uint16 else 1
    written = "#" + bytes(colour).hex()
    colours = base.samples[:, :, :-1] if base.alpha else base.samples
    if colours.shape[2] not in (1, 3):
        raise ParameterError(f"--avoid: {exemplar.name} has {colours.shape[2]} channels; it needs 1 or 3.")
    found = (colours == np.array(colour, np.int64) * wide).all(axis=2)
    if not found.any():
        warn(f"{exemplar.name} has no pixel of the colour {written}; nothing is avoided.")
        return exemplar
    usable = ~found if exemplar.usable is None else exemplar.usable & ~found
    if not usable.any():
        raise InputError(f"{exemplar.name} has no pixel left to use without the colour {written}; choose another.")
    return replace(exemplar, usable=usable)


def cropped(exemplar: Exemplar, crop: tuple[int, int, int, int]) -> Exemplar:
    """Return the part at x, y, width, height of an exemplar, in px of the base plane."""
    x, y, width, height = crop
    if min(x, y) < 0 or x + width > exemplar.width or y + height > exemplar.height:
        raise ParameterError(
            f"--crop {','.join(map(str, crop))} does not lie in {_named(exemplar)}; give X,Y,WIDTH,HEIGHT inside it."
        )
    for name, plane in exemplar.planes.items():
        if any(v * plane.width % exemplar.width for v in crop):
            raise ParameterError(f"--crop cuts pixels of the smaller plane {name}; use multiples of its pixels.")
    from ..rendering.magnification import cut_out

    return cut_out(exemplar, x, y, width, height)


def _named(exemplar: Exemplar) -> str:
    return f"{exemplar.name} ({exemplar.width}x{exemplar.height} px)"


NO_NORMALS = 0.15
"""Mean deviation of vectors from length 1 that normal maps stay below, even reduced or strongly compressed."""

PlaneFiles = dict[str, str]
"""The files of one exemplar or output: plane -> path, the base first; ``mask`` says which pixels are usable."""


def sets_of(request: Request, report: Report) -> list[PlaneFiles]:
    """Group the files of a request into exemplars, add those of --map and --mask, and report the groups."""
    sets = grouped(request.files, request.how)
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
        for line in files.describe(sets).splitlines():
            report.note(line)
    return sets


def check_each(option: str, given: int, several: int) -> None:
    """Raise ParameterError if an option is not given once for each exemplar."""
    if given != several:
        number = f"{given} given for {several} exemplar{'s' * (several > 1)}"
        raise ParameterError(f"{option}: {number}; give it once for each, in the same order.")


def grouped(paths: tuple[str, ...], how: str = "auto") -> list[PlaneFiles]:
    """Group files into exemplars."""
    return [{name: os.fspath(path) for name, path in found.items()} for found in files.group(paths, how)]


def stem_of(found: PlaneFiles) -> str:
    """Return the value of {stem}: the stem of the file, or of the set, or the name of the folder."""
    pictures = [path for name, path in found.items() if name != "mask"]
    first = pictures[0]
    if first == "-":
        return "stdin"
    if first.startswith("sample:"):
        return first.removeprefix("sample:").partition(files.formats.LAYER)[0]
    file = Path(files.formats.split_layer(first)[0])
    return file.stem if len(pictures) == 1 else files.material_sets.name_of(first)[0] or file.parent.name or file.stem


@dataclass
class ExemplarCache:
    """An LRU cache of exemplars, with what was measured of them, for several commands in one process.

    It holds `most` exemplars of `pixels` px together; one is read anew after so many `uses`, as its memory grows, and
    when one of its files has changed.
    """

    most: int = 4
    pixels: int = 1 << 23
    uses: int = 64
    known: dict[object, tuple[Exemplar, list[str], int]] = field(default_factory=dict)

    def get(self, key: object, read: Callable[[Warn], Exemplar], warn: Warn) -> Exemplar:
        """Return the exemplar of a key, or read it; its warnings are repeated either way."""
        exemplar, told, uses = self.known.pop(key, (None, list[str](), 0))
        if exemplar is None or uses >= self.uses:
            told, uses = [], 0
            exemplar = read(told.append)
        self.known[key] = exemplar, told, uses + 1
        while len(self.known) > self.most or sum(e.height * e.width for e, _, _ in self.known.values()) > self.pixels:
            del self.known[next(iter(self.known))]
        for line in told:
            warn(line)
        return exemplar


_held: ExemplarCache | None = None


def set_cache(held: ExemplarCache | None) -> None:
    """Set the cache of exemplars of this process; None: each command reads its own."""
    global _held
    _held = held


def _signs(found: PlaneFiles) -> tuple[Any, ...] | None:
    """Return a key that changes with the files of an exemplar; None if there is none."""
    try:
        states = [os.stat(path) for path in found.values() if not path.startswith("sample:")]
    except OSError:  # the standard input, a layer of a file
        return None
    return tuple((s.st_dev, s.st_ino, s.st_size, s.st_mtime_ns) for s in states)


class Inputs:
    """The exemplars, scene and plan of a request, made when needed and kept until :meth:`forget`.

    ``sets`` are the files of exemplars, those of donors last.
    """

    def __init__(self, sets: Sequence[PlaneFiles], request: Request, report: Report) -> None:
        self.sets, self.request, self._report = sets, request, report

    def forget(self) -> None:
        """Drop what was read and planned, so that a long batch does not fill memory."""
        for name in ("exemplars", "scene", "plan"):
            self.__dict__.pop(name, None)

    @cached_property
    def exemplars(self) -> tuple[Exemplar, ...]:
        """The exemplars as the request uses them."""
        return tuple(self._read(found, n) for n, found in enumerate(self.sets))

    @cached_property
    def scene(self) -> Scene:
        """The exemplars and the canvas."""
        hole = self.hole(self.exemplars[0].base, self.exemplars[0].name) if self.request.verb == "heal" else None
        return scene_of(self.request, self.exemplars, hole, self.guide() if self.request.verb == "paint" else None)

    @cached_property
    def plan(self) -> Plan:
        """The method that fills the scene, with its parameters."""
        return plan_of(self.request, self.scene)

    @property
    def size(self) -> Pair:
        """Width and height of the output."""
        canvas, times = self.scene.canvas, self.request.magnify
        return canvas.width * times, canvas.height * times

    def hole(self, base: Plane, name: str) -> Mask:
        """Return which pixels (H, W) of the picture `name`, with the base plane `base`, are to be healed."""
        mask, files_of = self.request.holes[0], self.sets[0]
        if mask == "alpha":
            first = next(n for n in files_of if n != "mask")
            opaque = files.read_set({first: files_of[first]}, alpha="mask").usable
            return np.zeros((base.height, base.width), bool) if opaque is None else ~opaque
        hole = files.read_mask(mask, base, name)
        if not hole.any() or hole.all():
            what, remedy = ("covers all", "leave some of it") if hole.all() else ("marks nothing", "mark what is to go")
            size = f"{base.width}x{base.height} px"
            raise InputError(f"the hole {mask} {what} of {name} ({size}); {remedy}: white is healed.")
        return hole

    def guide(self) -> Guide:
        """Read the labels of the exemplars, which are cropped and reduced like them, and the target."""
        labels, target_path = self.request.labels, self.request.target
        assert target_path is not None
        check_each("--labels", len(labels), len(self.sets))
        paths = (*labels, target_path)
        planes = [files.read_plane(path, Kind.LABEL) for path in paths]
        for path, plane, found, e in zip(labels, planes, self.sets, self.exemplars, strict=False):
            first, whole = next(iter(found.values())), self.request.crop is None and self.request.scale == 1
            size = e.base if whole else files.read_plane(first)
            if (plane.width, plane.height) != (size.width, size.height):
                said = f"{plane.width}x{plane.height} px, {first} is {size.width}x{size.height}"
                raise InputError(f"the labels {path} are {said}; make them equal.")
        *beside, target = numbered(list(zip(paths, planes, strict=True)), self._report.warn)
        asked = replace(self.request, avoid=None, toroidal=False)
        alone = [Exemplar.of({"labels": plane}, name=path) for path, plane in zip(labels, beside, strict=True)]
        cut = [adapted(e, asked, lambda line: None).base for e in alone]
        return Guide(cut, target, self.request.weight, self.request.reach)

    def _read(self, found: PlaneFiles, n: int) -> Exemplar:
        def unused(base: Plane, name: str) -> Mask:
            """Return the pixels of a picture that are filled anew, and may hold anything."""
            from ..tasks.completion import dilated_hole

            return dilated_hole(self.hole(base, name), self.request.grow or 0, Wrap(self.request.wrap_axes))

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

        signs = None if _held is None or healed else _signs(found)
        if _held is None or signs is None:
            return read(self._report.warn)
        return _held.get((repr(inputs_of(self.request)), repr(found), signs), read, self._report.warn)
