"""``intarsia replay``: a picture made again from its recipe. Imports nothing heavy before the work."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...foundation import InputError, IntarsiaError, ParameterError
from ...request import Json, Request, asked_pictures, with_pictures
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
    as --picture: they are checked against the recipe. Of planks_grown.png planks.png is found beside it, and so are
    mask.png, labels.png, target.png and PARAMETER.png; an exemplar of another name is known there by its contents.
    Everything else is in it, such as --crop, --flatten, --avoid and --depth, and a hole that was the picture's own
    alpha. Built-in exemplars (sample:...) need no --exemplar.
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
    found = found_beside(recipe, request, report)
    recipe = with_pictures(recipe, dict(found.pictures), picture)
    again = from_recipe(recipe, found, f"the recipe of {picture}")
    if recipe.get("intarsia") != VERSION:
        report.warn(
            f"{picture} was made by intarsia {recipe.get('intarsia', 'of unknown version')}, this is {VERSION}; "
            "the picture may differ."
        )
    Batch.plan(again, report, lambda scene: check_scene(recipe, scene, again)).carry_out()


def found_beside(recipe: Json, request: Request, report: Report) -> Request:
    """Return the request with files found beside the picture; ParameterError that lists all that are missing."""
    picture = request.picture or ""
    try:
        near = Neighbours(picture)
        names = [str(entry.get("name", "")) for entry in recipe["exemplars"]]
        mine = not all(name.startswith("sample:") for name in names)
        healed, painted = "heal" in recipe and recipe["heal"].get("mask") != "alpha", "guide" in recipe
        begun = healed or "extend" in recipe or "tile" in recipe
        asked = [key for key, was in asked_pictures(recipe).items() if "function" not in was]
        exemplar = request.files or (near.exemplar(recipe) if mine else ())
    except (KeyError, TypeError, AttributeError):
        return request  # a damaged recipe is told of by what reads all of it

    def one(needed: bool, given: tuple[str, ...], word: str) -> tuple[str, ...]:
        found = near.called(word) if needed and not given else None
        return given if found is None else (found,)

    masks, labels = one(healed, request.masks, "mask"), one(painted, request.labels, "labels")
    target = request.target or (near.called("target") if painted else None)
    drawn = dict(request.pictures)
    drawn |= {key: path for key in asked if key not in drawn and (path := near.called(key)) is not None}
    missing = [
        ("--exemplar FILE", mine and not exemplar), ("--mask FILE", healed and not masks),
        ("--labels FILE", painted and not labels), ("--target FILE", painted and target is None),
        ("--from FILE", begun and len(names) > 1 and not request.donors),
        ("--start FILE", "start" in recipe and not begun and "heal" not in recipe and request.start is None),
        *((f"--picture {key}=FILE", key not in drawn) for key in asked),
    ]  # fmt: skip
    lacking = [option for option, lacks in missing if lacks]
    found = replace(request, files=exemplar, masks=masks, labels=labels, target=target, pictures=tuple(drawn.items()))
    if lacking == ["--exemplar FILE"] and (exemplar := near.alike(with_pictures(recipe, drawn, picture), found)):
        found = replace(found, files=exemplar)
    elif lacking:
        raise ParameterError(
            f"{picture} was made with {', '.join(lacking)}: its recipe holds their hashes alone; name the files."
        )
    if added := sorted({*found.read} - {*request.read}):
        report.note(f"taken from beside it: {', '.join(added)}")
    return found


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


DONE = re.compile(r"_(grown|extended|healed|painted|tiled)(_[0-9]+)?$")
"""End of the default name of an output, after the name of its exemplar."""


MOST = 50
"""Most pictures that are read to find one by its contents."""


class Neighbours:
    """The pictures in the folder of a picture, without links: `floor.png` beside `floor_grown.png`."""

    def __init__(self, picture: str) -> None:
        from ...files.material_sets import READABLE

        folder, name = os.path.split(picture)
        here = list[str]()
        with suppress(OSError), os.scandir(folder or os.curdir) as found:
            here += [e.name for e in found if e.is_file(follow_symlinks=False) and e.name != name]
        readable = (n for n in sorted(here) if os.path.splitext(n)[1].lower() in READABLE)
        self._paths = [os.path.join(folder, n) for n in readable]
        stem = Path(name.removesuffix(".recipe.json")).stem
        self._exemplar = DONE.sub("", stem) if DONE.search(stem) else None

    def exemplar(self, recipe: Json) -> tuple[str, ...]:
        """Return the picture, or the planes of a set, that the name of the output begins with; () if several."""
        from ...files.material_sets import name_of

        if self._exemplar is None or len(recipe["exemplars"]) != 1:
            return ()
        alone, planes = [p for p in self._paths if Path(p).stem == self._exemplar], list[str]()
        for path in self._paths:
            own, word = name_of(path)
            if own == self._exemplar and word not in (None, "mask"):
                planes.append(path)
        return tuple(alone[:1] or planes)

    def alike(self, recipe: Json, request: Request) -> tuple[str, ...]:
        """Return the first picture that is the exemplar of a recipe if it is read and used as that says."""
        from ...request import from_recipe
        from ..exemplars import Inputs, sets_of

        report = Report(quiet=True)
        for path in self._paths[:MOST]:
            with suppress(IntarsiaError):
                again = from_recipe(recipe, replace(request, files=(path,)), path)
                check_scene(recipe, Inputs(sets_of(again, report), again, report).scene, again)
                return (path,)
        return ()

    def called(self, word: str) -> str | None:
        """Return the file `floor_word.png`, after the name of the exemplar, or `word.png`, in any format."""
        stems = f"{self._exemplar}_{word}", word
        return next((path for stem in stems for path in self._paths if Path(path).stem == stem), None)


command = HelpfulCommand("replay", replay)
