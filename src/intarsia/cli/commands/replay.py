"""``intarsia replay``: a picture made again from its recipe. Imports nothing heavy before the work."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...foundation import InputError, ParameterError
from ...request import Json, Request, with_pictures
from ...version import VERSION
from .. import Report
from ..verbs import HelpfulCommand

if TYPE_CHECKING:
    from ...model import Exemplar
    from ...model.canvas import Guide
    from ...synthesis import Scene


def replay(request: Request, report: Report) -> None:
    """Make a picture again from the recipe in FILE (or in FILE.recipe.json), pixel for pixel.

    \b
    intarsia replay floor.png -o again.png --exemplar planks.png
    intarsia replay clean.png -o again.png --exemplar wall.png --mask graffiti.png
    intarsia replay island.png -o again.png --exemplar coast.png --labels coast_labels.png --target map.png

    Give the files again that were used, --map, --mask, --from, --labels and --target too, and pictures of parameters
    as --picture: they are checked against the recipe. Everything else is in it, such as --crop, --flatten, --avoid and
    --depth, and a hole that was the picture's own alpha. Built-in exemplars (sample:...) need no --exemplar.
    """
    from ... import files
    from ...request import from_recipe
    from ..batch import Batch

    picture = request.picture or ""
    recipe = files.read_recipe(picture)
    if recipe is None:
        raise InputError(f"{picture} carries no recipe; give a picture that intarsia wrote, or its .recipe.json.")
    if "origin" in recipe:
        raise InputError(f"{picture} was woven; make it again with intarsia weave, from the same exemplar and options.")
    if "advected" in recipe:
        raise InputError(f"{picture} was moved by a flow that no recipe holds; run again the program that moved it.")
    recipe = with_pictures(recipe, dict(request.pictures), picture)
    again = from_recipe(recipe, request, f"the recipe of {picture}")
    check_given(recipe, request, again)
    if recipe.get("intarsia") != VERSION:
        report.warn(
            f"{picture} was made by intarsia {recipe.get('intarsia', 'of unknown version')}, this is {VERSION}; "
            "the picture may differ."
        )
    Batch.plan(again, report, lambda scene: check_scene(recipe, scene, again)).carry_out()


def check_given(recipe: Json, given: Request, again: Request) -> None:
    """Raise ParameterError if files are not given that the recipe needs, with all of them, or one that it does not."""
    painted, several = "guide" in recipe, len(recipe["exemplars"]) > 1
    own = any(not str(entry.get("name", "")).startswith("sample:") for entry in recipe["exemplars"])
    asked = [
        ("--exemplar", own or None, given.files),
        ("--mask", again.holes != ("alpha",) if again.verb == "heal" else None, given.masks),
        ("--labels", painted, given.labels), ("--target", painted, given.target),
        ("--from", again.begun and several, given.donors),
        ("--start", "start" in recipe and not again.begun, given.start),
    ]  # fmt: skip
    missing = [f"{option} FILE" for option, needed, files in asked if needed and not files]
    if missing:
        said = f"{given.picture} was made with {', '.join(missing)}"
        raise ParameterError(f"{said}: its recipe holds their hashes alone; name the files.")
    for option, needed, files in asked:
        if files and needed is False:
            raise ParameterError(f"{given.picture} was made without {option}; drop it.")


def check_scene(recipe: Json, scene: Scene, request: Request) -> None:
    """Raise InputError, with the name of the file, if something is not what the recipe was made with.

    The hole is checked before the pictures: its pixels count as unusable, so a wrong hole changes them, too.
    """
    expected, found, start, guide = recipe["exemplars"], scene.exemplars, scene.canvas.start, scene.canvas.guide
    if len(expected) != len(found):
        raise InputError(f"the recipe has {len(expected)} exemplars, {len(found)} are given; give the same files.")
    if start is not None and start.digest != recipe.get("start"):
        first, holes = found[0], request.holes
        if request.start is not None:
            raise InputError(f"{request.start} is another map than the recipe was made with; give the same file.")
        if not holes or [first.width, first.height] != recipe["size"] or holes[0] == "alpha":
            raise _another(expected[0], first)
        raise InputError(f"{holes[0]} marks another hole than the recipe was made with; give the same --mask.")
    for entry, exemplar in zip(expected, found, strict=True):
        if entry["sha256"] != exemplar.digest:
            raise _another(entry, exemplar)
    if guide is not None:
        _check_guide(recipe["guide"], guide, request)


def _check_guide(recorded: Json, guide: Guide, given: Request) -> None:
    known = [*recorded.get("labels", []), recorded.get("target")]
    options = [*("--labels" for _ in given.labels), "--target"]
    paths = (*given.labels, given.target)
    for path, option, digest, was in zip(paths, options, guide.digests, known, strict=False):
        if digest != was:
            raise InputError(f"{path} holds other labels than the recipe was made with; give the same {option}.")
    if len(known) != len(guide.digests):
        raise InputError(f"the recipe has {len(known) - 1} label pictures; give the same --labels.")


def _another(entry: Json, exemplar: Exemplar) -> InputError:
    return InputError(
        f"{exemplar.name} is another exemplar (sha256 {exemplar.digest[:12]}) than that of the recipe "
        f"({str(entry['sha256'])[:12]}); give the same file, with the same --map and --mask."
    )


command = HelpfulCommand("replay", replay)
