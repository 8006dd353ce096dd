"""Tasks beyond plain synthesis: hole filling, extension, tiling, repair, advection, analysis.

This module turns a request and its exemplars into scene, plan and synthesis.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ..foundation import ParameterError, lazy
from ..foundation.arrays import Pair
from ..foundation.geometry import Wrap
from ..foundation.run import Run
from ..model import Exemplars
from ..model.canvas import Guide
from ..model.sourcemap import SourceMap
from ..request import Request
from ..synthesis import Plan, Scene, Synthesis, as_exemplars, canvas_of, carry_out, check_between, planned

if TYPE_CHECKING:
    from . import completion, repair, tileable
else:  # rarely needed
    completion, repair = lazy("intarsia.tasks.completion"), lazy("intarsia.tasks.repair")
    tileable = lazy("intarsia.tasks.tileable")


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
