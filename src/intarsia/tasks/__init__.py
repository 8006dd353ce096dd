"""Tasks beyond plain synthesis: hole filling, extension, tiling, repair, advection, analysis; and replay of recipes.

This module turns a request and its exemplars into scene, plan and synthesis, and recomputes a map from a recipe.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..disk.atomic import PathLike
from ..files import read_recipe
from ..foundation import InputError, MethodError, ParameterError, lazy, printable
from ..foundation.arrays import Pair
from ..foundation.geometry import Wrap
from ..foundation.run import Run, run_of
from ..model import Exemplars
from ..model.canvas import Guide
from ..model.image import Plane, Transfer, converted
from ..model.sourcemap import SourceMap
from ..request import Request, from_recipe
from ..synthesis import Plan, Scene, Synthesis, as_exemplars, canvas_of, carry_out, check_between, planned

if TYPE_CHECKING:
    from . import completion, repair, tileable
else:  # rarely needed
    completion, repair = lazy("intarsia.tasks.completion"), lazy("intarsia.tasks.repair")
    tileable = lazy("intarsia.tasks.tileable")

BESIDE = {
    "heal": "a mask of holes", "guide": "labels", "start": "a map to continue", "origin": "a loom",
    "advected": "a flow",
}  # fmt: skip
"""Key in a recipe -> the input besides the exemplars that it names, of which the recipe holds only a hash."""


def small_of(size: Pair, times: int) -> Pair:
    """Return (width, height) of the map of a picture of `size` that is magnified `times`.

    Raises ParameterError if a side is no multiple of `times`.
    """
    width, height = size
    if width % times or height % times:
        raise ParameterError(f"--size {width}x{height} is no multiple of --magnify {times}; give multiples of {times}.")
    return width // times, height // times


def scene_of(
    request: Request, exemplars: Exemplars, hole: ArrayLike | None = None, guide: Guide | None = None
) -> Scene:
    """Return the scene of a request: its exemplars, and the canvas with start map and guide.

    `hole` (H, W): the pixels to replace, for the command heal only.
    """
    exemplars, size, wrap = as_exemplars(list(exemplars)), request.size, Wrap(request.wrap_axes)
    if not request.begun:
        small = None if size is None or guide is not None else small_of(size, exemplars[0].times)[::-1]
        start = None if request.start is None else SourceMap.load(request.start)
        return Scene(exemplars, canvas_of(exemplars, small, wrap, start, guide, request.rim))
    picture, donors = exemplars[0], exemplars[1:]
    if request.verb == "extend":
        return completion.extension(picture, completion.Margins(*request.margins), donors, wrap)
    if request.verb == "tile":
        return tileable.scene_to_tile(picture, donors, wrap, request.band, None if size is None else size[::-1])
    assert hole is not None
    scene = completion.healed_scene(picture, hole, donors, wrap, request.grow)
    if "alpha" not in request.holes:
        return scene
    return replace(scene, recipe={"heal": scene.recipe["heal"] | {"mask": "alpha"}})


def plan_of(request: Request, scene: Scene) -> Plan:
    """Return the plan of a request: method and blend."""
    if request.verb == "tile":
        plan = tileable.planned_to_tile(scene, request.chosen)
    elif request.verb == "heal":
        plan = completion.planned_for_holes(scene, request.chosen, request.edge)
    else:
        plan = planned(scene, request.chosen, run=Run(request.threads))
    if plan.choice is None and request.repair:
        repair.check_repair(plan.method, request.repair)
    return with_joins(plan, request)


def with_joins(plan: Plan, request: Request) -> Plan:
    """Return the plan with the blend of its method, modified by the options of the request."""
    blend = plan.joined.but(feather=request.feather, mixing=request.mixing, finish=request.corrections)
    check_between(plan.method, blend)
    return replace(plan, blend=blend)


def made_of(request: Request, plan: Plan, seed: int, run: Run) -> Synthesis:
    """Carry out the plan of a request; `run` gives threads, progress and cancelling."""
    if request.verb == "tile":
        return tileable.tiled(plan, seed, run)
    if request.verb == "heal":
        return completion.fill_holes(plan, seed, run, request.edge)
    return carry_out(plan, seed, run)


def replayed(recipe: Mapping[str, Any], exemplars: Exemplars, run: Run | None = None) -> Synthesis:
    """Recompute a synthesis, extension or tiling from its recipe and its exemplars; the map is the same.

    Raises InputError if the recipe is damaged or of other exemplars, or if it needs an input that it does not hold
    (BESIDE): a mask of holes, labels or a target, a start map, the origin of a window, a flow.
    """
    run, begun = run_of(run), "extend" in recipe or "tile" in recipe
    for word, what in BESIDE.items():
        if word in recipe and not (begun and word == "start"):
            raise InputError(f"it was made with {what}, which its recipe does not hold.")
    request = from_recipe(recipe, Request("replay", magnify=exemplars[0].times), "its recipe")
    try:
        scene = scene_of(request, exemplars)
        if [entry["sha256"] for entry in recipe["exemplars"]] != [e.digest for e in scene.exemplars]:
            said = f"; it was made with --{', --'.join(recipe['inputs'])}" if recipe.get("inputs") else ""
            raise InputError(f"its recipe is of another exemplar{said}.")
        made = made_of(request, plan_of(request, scene), request.seeds[0], run)
        return repair.repair(made, request.repair, run=run) if "repair" in recipe else made
    except (ParameterError, MethodError) as e:
        raise InputError(f"its recipe cannot be followed: {e}") from None


def recipe_map(path: PathLike, output: Plane, exemplars: Exemplars, run: Run) -> SourceMap:
    """Return the map of a picture, recomputed from the recipe in its file, if that gives exactly these pixels.

    Raises InputError with the reason if it cannot be recomputed.
    """
    try:
        recipe = read_recipe(path)
        if recipe is None:
            raise InputError("it carries no recipe.")
        if recipe.get("size") != [output.width, output.height]:
            raise InputError("its recipe is of another size.")
        made = replayed(recipe, exemplars, run)
        if not _same(made.render(run=run), output):
            raise InputError("its recipe, made again, gives other pixels.")
    except InputError as e:
        raise InputError(f"{printable(path)}: no map can be made again: {e}") from None
    return made.map


def _same(made: Plane, output: Plane) -> bool:
    """Whether a picture equals these pixels, converted to its depth."""
    if made.samples.shape != output.samples.shape:
        return False
    linear = made.transfer is Transfer.LINEAR
    return np.array_equal(converted(made.samples, made.kind.value, linear, output.samples.dtype), output.samples)
