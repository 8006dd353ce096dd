"""What was read against what a recipe says was there: exemplars, hole, labels, target and start map, by hashes."""

from __future__ import annotations

from typing import Any

from ..errors import InputError
from ..exemplar import Exemplar
from ..guide import Guide
from ..synthesis import Scene
from .request import Labels, Wish


def check_scene(recipe: dict[str, Any], scene: Scene, wish: Wish) -> None:
    """Refuse whatever is not what the recipe was made with, naming the file.

    The hole goes before the pictures: pixels in it count as unusable, so that a wrong hole changes them, too.
    """
    wanted, found = recipe["exemplars"], scene.exemplars
    if len(wanted) != len(found):
        raise InputError(f"the recipe has {len(wanted)} exemplars, {len(found)} are given; give the same files.")
    _check_start(recipe, scene, wish)
    for entry, exemplar in zip(wanted, found, strict=True):
        if entry["sha256"] != exemplar.digest:
            raise _another(entry, exemplar)
    if wish.labels is not None and scene.canvas.guide is not None:
        _check_guide(recipe["guide"], scene.canvas.guide, wish.labels)


def _check_start(recipe: dict[str, Any], scene: Scene, wish: Wish) -> None:
    start, begin = scene.canvas.start, wish.begin
    if start is None or start.digest == recipe.get("start"):
        return
    first, size = scene.exemplars[0], recipe["size"]
    if wish.start is not None:
        raise InputError(f"{wish.start[0]} is another map than the recipe was made with; give the same file.")
    if begin is None or not begin.holes or [first.width, first.height] != size or begin.holes[0] == "alpha":
        raise _another(recipe["exemplars"][0], first)
    raise InputError(f"{begin.holes[0]} marks another hole than the recipe was made with; give the same --mask.")


def _check_guide(wanted: dict[str, Any], guide: Guide, given: Labels) -> None:
    if wanted.get("sha256") == guide.digest:
        return
    known = [*wanted.get("labels", []), wanted.get("target")]
    options = [*("--labels" for _ in given.sources), "--target"]
    for path, option, digest, was in zip((*given.sources, given.target), options, guide.digests, known, strict=False):
        if digest != was:
            raise InputError(f"{path} holds other labels than the recipe was made with; give the same {option}.")
    raise InputError(f"{given.target} and the labels are not what the recipe was made with; give the same files.")


def _another(entry: dict[str, Any], exemplar: Exemplar) -> InputError:
    return InputError(
        f"{exemplar.name} is another exemplar (sha256 {exemplar.digest[:12]}) than that of the recipe "
        f"({str(entry['sha256'])[:12]}); give the same file, with the same --map and --mask."
    )
