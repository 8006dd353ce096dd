"""Making a texture again from its recipe, on the exemplars that it names; so a picture tells its map."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..blend import Blend
from ..disk.depth import converted
from ..draws import check_seed
from ..errors import InputError, MethodError, ParameterError, printable
from ..exemplar import Exemplar
from ..files import read_recipe
from ..geometry import Wrap
from ..image import Plane, Transfer
from ..methods.base import method_of
from ..run import Run, run_of
from ..sourcemap import SourceMap
from ..synthesis import Scene, Synthesis, canvas_of, check_between, filled
from .repair import repair
from .starts import Margins, extension
from .tileable import planned_to_tile, scene_to_tile, tiled

BESIDE = {
    "heal": "a mask of holes", "guide": "labels", "start": "a map to continue", "origin": "a loom",
    "advected": "a flow",
}  # fmt: skip
"""What was used beside exemplars, by where a recipe says so; of these it holds no more than hashes."""


def replayed(recipe: Mapping[str, Any], exemplars: Sequence[Exemplar], run: Run | None = None) -> Synthesis:
    """Make again what was grown, extended or tiled, from its recipe and its exemplars: the same map.

    Raises InputError where the recipe is damaged, where it is of other exemplars, and where more was used than
    exemplars: masks of holes, labels, maps to continue.
    """
    run = run_of(run)
    try:
        begun = "extend" in recipe or "tile" in recipe
        for word, what in BESIDE.items():
            if word in recipe and not (begun and word == "start"):
                raise InputError(f"it was made with {what}, which its recipe does not hold.")
        scene = _scene(recipe, tuple(exemplars))
        if [entry["sha256"] for entry in recipe["exemplars"]] != [e.digest for e in scene.exemplars]:
            raise InputError("its recipe is of another exemplar" + _cut(recipe) + ".")
        method = method_of(recipe["method"], dict(recipe["parameters"]))
        blend, seed = Blend.of(recipe["blend"]), check_seed(recipe["seed"])
        check_between(method, blend)
        if "tile" in recipe:
            made = tiled(replace(planned_to_tile(scene, method), blend=blend), seed, run)
        else:
            made = filled(scene, method, seed, blend, run)
        return repair(made, recipe["repair"], run=run) if "repair" in recipe else made
    except (ParameterError, MethodError) as e:
        raise InputError(f"its recipe cannot be followed: {e}") from None
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError("its recipe is damaged, or of an unknown version.") from None


def recipe_map(path: str | os.PathLike[str], output: Plane, exemplars: Sequence[Exemplar], run: Run) -> SourceMap:
    """Return the map of a picture that carries its recipe, made again, where that makes these very pixels.

    Raises InputError, which says why there is none.
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


def _scene(recipe: Mapping[str, Any], exemplars: tuple[Exemplar, ...]) -> Scene:
    """What the canvas began with: nothing, a picture amid margins, or one with a band along its borders."""
    width, height = recipe["size"]
    wrap, (first, *donors) = Wrap(recipe["wrap"]), exemplars
    if "extend" in recipe:
        return extension(first, Margins(*recipe["extend"]), donors, wrap)
    if "tile" in recipe:
        return scene_to_tile(first, donors, wrap, recipe["tile"]["band"], (height, width))
    return Scene(exemplars, canvas_of(exemplars, (height, width), wrap, None, None))


def _cut(recipe: Mapping[str, Any]) -> str:
    """How the exemplar was changed before it was used, as far as a recipe says."""
    said = recipe.get("inputs")
    return f"; it was made with --{', --'.join(map(str, said))}" if isinstance(said, dict) and said else ""


def _same(made: Plane, output: Plane) -> bool:
    """Whether a picture was written from these pixels, in whatever depth."""
    if made.samples.shape != output.samples.shape:
        return False
    linear = made.transfer is Transfer.LINEAR
    return np.array_equal(converted(made.samples, made.kind.value, linear, output.samples.dtype), output.samples)
