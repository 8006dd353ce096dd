"""What will be made, checked in full before any work: sizes, methods, depths, names of files."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ..blend import Blend
from ..canvas import Canvas
from ..choosing.auto import Choice
from ..errors import ParameterError
from ..exemplar import Exemplar
from ..files import check_depth, format_of, recipe_path
from ..geometry import Wrap
from ..guide import Guide
from ..lazy import lazy
from ..methods.base import Method, measures_distances, recipe_settings, traits
from ..rendering.render import check_alike, check_drawable
from ..request.request import Request
from ..request.verbs import DONE
from ..sourcemap import SourceMap
from ..synthesis import Plan, Scene, as_exemplars, canvas_of, check_between, planned
from ..tasks.repair import check_repair
from ..tasks.starts import Margins, extension
from .exemplars import Set, Shelf, stem_of
from .outputs import (
    by_file,
    check_apart,
    check_place,
    filled_name,
    kept_files,
    layer_files,
    plane_files,
    usual_files,
    usual_name,
)

if TYPE_CHECKING:
    from ..tasks import completion, scoring, tileable
else:  # only gates, holes and tiling need them
    scoring, tileable = lazy("intarsia.tasks.scoring"), lazy("intarsia.tasks.tileable")
    completion = lazy("intarsia.tasks.completion")


@dataclass(frozen=True)
class Order:
    """One texture to grow, and the files that it goes to. ``lot`` numbers the exemplars on the shelf.

    Of its plan it keeps all but the scene, so that a long batch does not fill memory.
    """

    lot: int
    seed: int
    method: Method
    blend: Blend
    choice: Choice | None
    guide: Guide | None
    size: tuple[int, int]  # width, height
    cut_from: tuple[int, int] | None  # width, height of the picture of which less is tiled
    times: int  # larger than the map
    patches: int | None
    memory: int
    sets: tuple[Set, ...]
    pictures: dict[str, str]  # plane -> file
    save_map: str | None
    st_map: str | None
    distance_map: str | None
    page: str | None
    preview: str | None
    offset: str | None

    @property
    def files(self) -> list[tuple[str, str]]:
        """All files of the order, and what each holds."""
        more = (
            (self.save_map, "map"), (self.st_map, "st map"), (self.distance_map, "distances"),
            (self.page, "report"), (self.preview, "preview"), (self.offset, "offset"),
        )  # fmt: skip
        pictures = [(path, ", ".join(names)) for path, names in by_file(self.pictures).items()]
        return pictures + [(p, what) for p, what in more if p is not None]

    def plan(self, scene: Scene) -> Plan:
        """The plan again, on its scene."""
        return Plan(scene, self.method, self.blend, self.choice)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What speaks against the exemplar, where the method was chosen."""
        return () if self.choice is None else self.choice.warnings

    @property
    def line(self) -> str:
        """What a person wants to know of it."""
        return self.made_by(self.method.slug)

    def made_by(self, slug: str) -> str:
        """The same, once it is known which method led to the end."""
        (width, height), whole = self.size, self.cut_from
        cut = "" if whole is None else f" of {whole[0]}x{whole[1]} px"
        return f"{', '.join(path for path, _ in self.files)}: {width}x{height} px{cut}, {slug}, seed {self.seed}"


def small_of(size: tuple[int, int], times: int) -> tuple[int, int]:
    """Return the size that is grown where pictures are drawn so many times larger."""
    width, height = size
    if width % times or height % times:
        raise ParameterError(f"--size {width}x{height} is no multiple of --magnify {times}; give multiples of {times}.")
    return width // times, height // times


def scene_of(shelf: Shelf, lot: int, guide: Guide | None = None) -> Scene:
    """Return the exemplars of a lot, and the canvas with what is on it; the guide is read if it was not yet."""
    request = shelf.request
    exemplars, size, wrap = as_exemplars(list(shelf.get(lot))), request.size, Wrap(request.closing)
    if not request.begun:
        if guide is None and request.verb == "paint":
            guide = shelf.guide(lot)
        small = None if size is None or guide is not None else small_of(size, exemplars[0].times)[::-1]
        start = None if request.start is None else SourceMap.load(request.start)
        return Scene(exemplars, canvas_of(exemplars, small, wrap, start, guide, request.rim))
    picture, donors = exemplars[0], exemplars[1:]
    if request.verb == "extend":
        return extension(picture, Margins(*request.margins), donors, wrap)
    if request.verb == "tile":
        return tileable.scene_to_tile(picture, donors, wrap, request.band, None if size is None else size[::-1])
    scene = completion.healed_scene(picture, shelf.hole(lot, picture.base, picture.name), donors, wrap, request.grow)
    if "alpha" not in request.holes:
        return scene
    return replace(scene, recipe={"heal": scene.recipe["heal"] | {"mask": "alpha"}})


def check_begin(request: Request, lots: list[list[Set]], sets: list[Set]) -> None:
    """Refuse several pictures for one output, and holes that do not fit the number of pictures."""
    if not request.begun:
        return
    if len(lots[0]) > 1:
        raise ParameterError(
            f"{len(sets)} pictures are given for one output; put {{stem}} into -o to work on each, "
            "or name further sources with --from."
        )
    if request.holes and len(request.holes) not in (1, len(sets)):
        raise ParameterError(
            f"--mask: {len(request.holes)} given for {len(sets)} picture{'s' * (len(sets) > 1)}; "
            "give one for all, or one for each, in the same order."
        )


def with_joins(plan: Plan, request: Request) -> Plan:
    """Return the plan with its pieces joined as the method means it, but for what is asked otherwise."""
    blend = plan.joined.but(feather=request.feather, mixing=request.mixing, finish=request.finishing)
    check_between(plan.method, blend)
    return replace(plan, blend=blend)


def orders_of(shelf: Shelf, lot: int, check: Callable[[Scene], None] | None = None) -> list[Order]:
    """Return the orders of one lot of exemplars, one for each seed, or refuse what cannot work.

    `check` may refuse what was read.
    """
    request, sets = shelf.request, shelf.lots[lot]
    if request.size is not None and not request.begun:
        width, height = small_of(request.size, request.magnify)
        Canvas(height, width)
    fields: dict[str, Any] = {"stem": stem_of(sets[0]), "method": request.chosen.slug, "seed": 0, "w": 0, "h": 0}
    if request.out and not request.layers:
        plane_files(filled_name(request.out, fields), sets[0])  # refused before anything is read
    scene = scene_of(shelf, lot)
    if check is not None:
        check(scene)
    plan = plan_of(request, scene)
    exemplars, canvas, method = scene.exemplars, scene.canvas, plan.method
    times = exemplars[0].times
    size = (canvas.width * times, canvas.height * times)
    whole = (exemplars[0].width, exemplars[0].height)
    cut_from = whole if request.verb == "tile" and whole != size else None
    fields |= {"w": size[0], "h": size[1], "method": method.slug}
    memory = plan.memory(request.depth)
    kept = (method, plan.joined, plan.choice, canvas.guide, size, cut_from, times, plan.patches, memory, tuple(sets))
    orders = []
    for seed in request.seeds:
        fields["seed"] = seed
        pictures = named(sets[:1] if request.begun else sets, exemplars[0], request, fields)
        if not request.layers:
            check_apart(pictures)
        asked = (
            request.save_map, request.st_map, request.distance_map and request.distance_map[1],
            request.page, request.preview, request.offset,
        )  # fmt: skip
        maps = (None if t is None else filled_name(t, fields) for t in asked)
        orders.append(Order(lot, seed, *kept, pictures, *maps))
    if orders:
        check_formats(orders[0], exemplars, request)
        check_alike(exemplars)
        check_drawable(exemplars, canvas.height, canvas.width, plan.joined.feather)
        check_distance_map(orders[0], request)
        if request.gates:
            scoring.check_gates(request.gates)
        check_tiled(orders[0], exemplars[0], request)
    return orders


def named(sets: Sequence[Set], exemplar: Exemplar, request: Request, fields: dict[str, Any]) -> dict[str, str]:
    """Name the file of each plane as -o says, or after the exemplars, and after the seed where there are many."""
    usual = usual_name(sets, DONE[request.verb], fields["seed"] if len(request.seeds) > 1 else None)
    if request.layers:
        if request.folder:
            out = os.path.join(filled_name(request.folder, fields), stem_of(sets[0]) + ".exr")
        else:
            out = filled_name(request.out, fields) if request.out else usual + ".exr"
        return layer_files(out, exemplar, request.depth)
    if request.out:
        return plane_files(filled_name(request.out, fields), sets[0])
    longer = max(fields["w"], fields["h"]) / (max(exemplar.width, exemplar.height) * exemplar.times)
    if request.folder:
        return kept_files(filled_name(request.folder, fields), sets[0], exemplar, longer, request.depth)
    return usual_files(usual, sets[0], exemplar, longer, request.depth)


def plan_of(request: Request, scene: Scene) -> Plan:
    """Decide by which method a scene is filled."""
    if request.verb == "tile":
        plan = tileable.planned_to_tile(scene, request.chosen)
    elif request.verb == "heal":
        plan = completion.planned_for_holes(scene, request.chosen, request.edge)
    else:
        plan = planned(scene, request.chosen)
    if plan.choice is None:
        check_repair(plan.method, request.repair)
    return with_joins(plan, request)


def method_as_json(method: Method, blend: Blend) -> dict[str, Any]:
    """What JSON says of a method, x before y, and of how it joins its pieces."""
    its = {"method": method.slug, "parameters": recipe_settings(method)}
    return its | traits(method).spans | {"blend": blend.as_recipe}


def check_formats(order: Order, exemplars: tuple[Exemplar, ...], request: Request) -> None:
    """Refuse depths, channels and sizes that the formats of the files cannot hold."""
    for name, path in order.pictures.items():
        plane = exemplars[0].picture(name)
        assert plane is not None
        width, height = (side * plane.width // (exemplars[0].width * order.times) for side in order.size)
        check_depth(path, plane, request.depth, (width, height))
        if path != "-" and not format_of(path).text:
            check_place(str(recipe_path(path)), request.force, bool(request.folder))
    if order.save_map is not None and os.path.splitext(order.save_map)[1].lower() != ".npz":
        raise ParameterError(f"--save-map {order.save_map}: a map is saved as .npz; end the name in it.")
    if order.st_map is not None:
        if os.path.splitext(order.st_map)[1].lower() != ".exr":
            raise ParameterError(f"--st-map {order.st_map}: an ST map is saved as .exr; end the name in it.")
        if len(exemplars) > 1:
            raise ParameterError(f"--st-map shows one exemplar, here are {len(exemplars)}; use --save-map.")


def check_tiled(order: Order, exemplar: Exemplar, request: Request) -> None:
    """Refuse depths and sizes that the formats of a preview and of the half-shifted picture cannot hold."""
    for path, times in ((order.preview, request.tiles), (order.offset, 1)):
        if path is not None:
            width, height = (side * times for side in order.size)
            check_depth(path, exemplar.planes[exemplar.drawn[0]], request.depth, (width, height))


def check_distance_map(order: Order, request: Request) -> None:
    """Refuse places outside the output, formats without distances, and methods that measure none."""
    if request.distance_map is None or order.distance_map is None:
        return
    (x, y), path = request.distance_map[0], order.distance_map
    if not (x < order.size[0] and y < order.size[1]):
        width, height = order.size
        raise ParameterError(f"--distance-map {x},{y} lies outside the output of {width}x{height} px.")
    if os.path.splitext(path)[1].lower() not in (".exr", ".tif", ".tiff", ".png"):
        raise ParameterError(f"--distance-map {path}: distances are saved as .exr, .tif or .png; end the name so.")
    if not measures_distances(order.method):
        raise ParameterError(f"--distance-map: {order.method.slug} measures no distances; use patch-sampling.")
