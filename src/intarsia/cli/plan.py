"""Orders: outputs planned and checked before any work: sizes, methods, depths, file names, memory."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from os.path import commonpath, dirname, isdir, join, realpath
from pathlib import Path

import numpy as np

from .. import files
from ..disk import peak_memory
from ..files import check_depth, format_of, recipe_path
from ..files.formats import LAYER, split_layer
from ..files.material_sets import Material, marks_of, name_of
from ..foundation import ParameterError, printable
from ..foundation.arrays import Pair
from ..foundation.blend import Blend
from ..methods import Method, recipe_settings, traits
from ..model import Exemplar
from ..model.canvas import Canvas
from ..model.image import Plane, dtype_of
from ..rendering.render import check_alike, check_drawable
from ..request import Json, Request
from ..request.fields import OUTPUT_SUFFIX
from ..synthesis import Scene
from ..tasks import small_of
from . import Report
from .exemplars import Inputs, PlaneFiles, check_each, grouped, sets_of, stem_of
from .outputs import (
    check_depths,
    check_place,
    filled_name,
    plane_files,
    usual_ending,
    usual_name,
)

LIBRARIES, EACH = 64 << 20, 80
"""Bytes that scoring an output and drawing its report take: in any case, and for each of its pixels."""

WORKING = 45 << 20
"""Bytes that the first kernels and the writer of files add to what planning took."""

LEAST = 200 << 20
"""Least bytes of Python and its libraries at work."""

MAP, FRAMES, FEATHER, LEVEL = 9, 161, 3, 10
"""Bytes: of a px of the map, of frames and fractions of a px, of feathering a px, of tone correction of a sample."""

ENCODED = 0.7
"""Size of an encoded picture of a grainy texture, as a share of its pixels."""

SEARCHED = {"repeat": 3, "random-tiling": 3, "parallel-controllable": 570}
"""Bytes that a method keeps for each px of the exemplars while it works; of other methods, and around a start:"""
SEARCHED_USUALLY, SEARCHED_AROUND = 30, 110

KEPT = {"save_map": "map", "page": "report", "preview": "preview"}
"""Fields of a request that name files beside the pictures, and what each holds."""

PREVIEWED = 3
"""How often a preview repeats the picture along an axis."""


@dataclass(frozen=True)
class Output:
    """One output: its exemplars, its seed, and its files."""

    shelf: Inputs
    seed: int
    pictures: PlaneFiles  # plane -> file
    beside: PlaneFiles  # what else is written, of `KEPT` -> file
    exported: tuple[str, ...] = ()  # files of an engine, in place of the pictures

    @property
    def files(self) -> list[tuple[str, str]]:
        """All files, and what each holds."""
        own = [(path, "export") for path in self.exported] or [(path, name) for name, path in self.pictures.items()]
        return own + [(path, what) for what, path in self.beside.items()]

    def for_engine(self, planes: Mapping[str, Plane]) -> tuple[dict[str, Plane], list[str]]:
        """Return what the engine reads of these planes, by file, and lines on it; it is called after the base."""
        from ..materials.engines import for_engine

        base = next(iter(self.pictures.values()))
        made, told = for_engine(Exemplar(planes, name=name_of(base)[0]), str(self.shelf.request.engine))
        return {join(dirname(base), name): plane for name, plane in made.items()}, told

    @property
    def cut_from(self) -> Pair | None:
        """Width and height of the picture, if only a part of it is tiled."""
        picture = self.shelf.scene.exemplars[0]
        whole = picture.width, picture.height
        return whole if self.shelf.request.verb == "tile" and whole != self.shelf.size else None

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about the exemplar, if the method was chosen."""
        choice = self.shelf.plan.choice
        return () if choice is None else choice.warnings

    @property
    def memory(self) -> int:
        """Estimated peak memory of this process in bytes, right within 25 % if kernels are compiled.

        What reading exemplars and resolving methods took is measured, not counted again.
        """
        request, (width, height), plan, drawn = self.shelf.request, self.shelf.size, self.shelf.plan, 0.0
        exemplars, canvas, method, blend = plan.scene.exemplars, plan.scene.canvas, plan.method, plan.joined
        area, own = canvas.height * canvas.width, sum(e.height * e.width for e in exemplars)
        searched = SEARCHED.get(method.slug, SEARCHED_USUALLY) if canvas.start is None else SEARCHED_AROUND
        each = MAP + (FEATHER if blend.feather else 0) + (0 if traits(method).exact else FRAMES)
        for plane in exemplars[0].planes.values():
            samples = plane.pixels.size * area / (exemplars[0].height * exemplars[0].width)
            held = plane.pixels.itemsize
            made = held if request.depth is None else np.dtype(dtype_of(request.depth)).itemsize
            swapped = made if made == 2 else 0  # bytes of 16 bits
            written = (made if made != held else 0) + ENCODED * made + swapped
            drawn = max(drawn, samples * (held + max(written, LEVEL if blend.finish else 0)))
        judged = LIBRARIES + EACH * width * height if request.page is not None else 0
        return int(max(LEAST, peak_memory() + WORKING) + own * searched + area * each + drawn) + judged

    def line(self, slug: str) -> str:
        """Return files, size, method `slug` and seed in one line."""
        (width, height), whole = self.shelf.size, self.cut_from
        cut = "" if whole is None else f" of {whole[0]}x{whole[1]} px"
        return f"{', '.join(path for path, _ in self.files)}: {width}x{height} px{cut}, {slug}, seed {self.seed}"


def materials_of(request: Request, report: Report) -> list[Material]:
    """Return the materials of the folders and files of a request; ParameterError for options of single pictures."""
    out, masks = request.out or "", "--usable" if request.holes else "--mask"
    filled_name(out, {})  # refuses unknown fields
    for option, given in (("--map", request.maps), (masks, request.masks)):
        if given:
            raise ParameterError(f"{option} names a file of one material; with -o FOLDER/ put it beside its planes.")
    if request.as_set:
        raise ParameterError("--set does not go with -o FOLDER/; the names of files and folders tell what is a set.")
    if len(request.holes) > 1:
        raise ParameterError("--mask: one hole can be given for a folder, which then goes for all of its pictures.")
    if "-" in request.read:
        raise ParameterError("the standard input (-) can be read once; name files where -o is a folder.")
    check_folder(out, request.files)
    folders = [path for path in request.files if isdir(path)]
    found = [m for path in folders for m in files.materials(path, request.how)]
    for one in grouped(tuple(path for path in request.files if path not in folders), request.how):
        whole = {_file_of(path) for path in one.values()}
        found.append(Material(stem_of(one), "", [*(whole if len(whole) == 1 else one.values())]))
    report.note(f"{len(found)} material{'s' * (len(found) > 1)}: {', '.join(m.name for m in found)}")
    used = {os.fspath(path) for material in found for path in material.files}
    every = [os.fspath(f) for p in folders for m in files.materials(p, "several") for f in m.files]
    if left := [printable(path) for path in every if path not in used]:
        report.note(f"left out, as other files there say which plane they are: {', '.join(left)}")
    return found


def _file_of(path: str) -> str:
    """Return the file of a plane, or the built-in set, without the layer that it is in."""
    return path.partition(LAYER)[0] if path.startswith("sample:") else os.fspath(split_layer(path)[0])


def check_folder(out: str, sources: tuple[str, ...]) -> None:
    """Raise ParameterError if a folder cannot be made, or lies in one that is read, where results would be inputs."""
    inner = realpath(out)
    if dirname(inner) == inner:
        raise ParameterError(f"-o {printable(out)} is the root of all folders; name a folder in it.")
    for folder in filter(isdir, sources):
        if commonpath([inner, outer := realpath(folder)]) == outer:
            raise ParameterError(f"-o {printable(out)} lies in {printable(folder)}, which is read; name another place.")
    if "{" not in out:
        check_place(join(out, "o"), True, True)


def shelves_of(request: Request, report: Report) -> list[Inputs]:
    """Return a shelf for each output, or one for the outputs of all seeds; nothing is read yet."""
    sets, donors, holes, labels = sets_of(request, report), grouped(request.donors), request.holes, request.labels
    each = "{stem}" in (request.out or "") or (not request.out and request.begun)
    if request.begun and len(sets) > 1 and not each:
        raise ParameterError(
            f"{len(sets)} pictures are given for one output; put {{stem}} into -o to work on each, "
            "or name further sources with --from."
        )
    if holes and len(holes) not in (1, len(sets)):
        raise ParameterError(
            f"--mask: {len(holes)} given for {len(sets)} picture{'s' * (len(sets) > 1)}; "
            "give one for all, or one for each, in the same order."
        )
    if not each:
        return [Inputs([*sets, *donors], request, report)]
    if request.verb == "paint":
        check_each("--labels", len(labels), len(sets))
    shelves = []
    for n, found in enumerate(sets):
        mine = replace(request, holes=holes[n:][:1] if len(holes) > 1 else holes, labels=labels[n:][:1])
        shelves.append(Inputs([found, *donors], mine, report))
    return shelves


def orders_of(shelf: Inputs, check: Callable[[Scene], None] | None) -> list[Output]:
    """Return the orders of a shelf, one for each seed; an error if something cannot work.

    `check` may refuse what was read.
    """
    request, sets = shelf.request, shelf.sets
    if request.size is not None and not request.begun:
        width, height = small_of(request.size, request.magnify)
        Canvas(height, width)
    fields: Json = {"stem": stem_of(sets[0]), "method": request.chosen.slug}
    if request.out:
        plane_files(filled_name(request.out, fields), sets[0])  # refused before anything is read
    if check is not None:
        check(shelf.scene)
    plan, orders = shelf.plan, list[Output]()
    exemplars, canvas = shelf.scene.exemplars, shelf.scene.canvas
    fields |= {"method": plan.method.slug} | dict(zip("wh", shelf.size, strict=True))
    asked = {what: getattr(request, name) for name, what in KEPT.items()}
    for seed in request.seeds:
        fields["seed"] = seed
        pictures = named(sets[:1] if request.begun else sets, exemplars[0], request, fields)
        beside = {what: filled_name(path, fields) for what, path in asked.items() if path is not None}
        order = Output(shelf, seed, pictures, beside)
        if request.engine is not None:
            if request.out == "-":
                raise ParameterError("-o - holds one picture, and --for writes several; name a folder.")
            planes = {name: plane for name in pictures if (plane := exemplars[0].picture(name)) is not None}
            order = replace(order, exported=tuple(order.for_engine(planes)[0]))
        orders.append(order)
    check_formats(orders[0])
    check_alike(exemplars)
    check_drawable(exemplars, canvas.height, canvas.width, plan.joined.feather)
    return orders


def named(sets: Sequence[PlaneFiles], exemplar: Exemplar, request: Request, fields: Json) -> PlaneFiles:
    """Return the file of each plane: as -o names it, or by the exemplars, and by the seed if there are several."""
    usual = usual_name(sets, OUTPUT_SUFFIX[request.verb], fields["seed"] if len(request.seeds) > 1 else None)
    if request.out:
        return plane_files(filled_name(request.out, fields), sets[0])
    found, longer = sets[0], max(fields["w"], fields["h"]) / (max(exemplar.width, exemplar.height) * exemplar.times)

    def called(plane: str) -> str:
        """Return the name of a plane: that of its own file in a folder, else of the exemplar and what was done."""
        if not request.folder:
            return usual if plane == next(iter(found)) else f"{usual}_{plane}{marks_of(found[plane])}"
        file = _file_of(found[plane])
        alone = sum(exemplar.picture(name) is not None for name in found) == 1
        layer = f"_{plane}" * (file != found[plane])
        own = stem_of(found) if alone else Path(file).stem.removeprefix("sample:") + layer
        return join(filled_name(request.folder, fields), own)

    return {
        name: called(name) + usual_ending(path, plane, longer, request.depth)
        for name, path in found.items() if (plane := exemplar.picture(name)) is not None
    }  # fmt: skip


def method_as_json(method: Method, blend: Blend) -> Json:
    """Return a method and its blending as JSON, x before y."""
    return {"method": method.slug, "parameters": recipe_settings(method), "blend": blend.as_recipe}


def check_formats(order: Output) -> None:
    """Raise ParameterError for what formats of files cannot hold."""
    request, beside, first, size = order.shelf.request, order.beside, order.shelf.scene.exemplars[0], order.shelf.size
    check_depths(order.pictures, first, size, request)
    for path in order.pictures.values():
        if path != "-" and not format_of(path).text:
            check_place(str(recipe_path(path)), request.force, bool(request.folder))
    if "map" in beside and Path(beside["map"]).suffix.lower() != ".npz":
        raise ParameterError(f"--save-map {beside['map']}: a map is saved as .npz; end the name in it.")
    if "preview" in beside:
        large = size[0] * PREVIEWED, size[1] * PREVIEWED
        check_depth(beside["preview"], first.planes[first.drawn[0]], request.depth, large)
