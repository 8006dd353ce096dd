"""``intarsia replay``: a picture again, from the recipe that it carries. Imports nothing heavy before the work."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import click

from ...arguments import MOST_PASSES, TIMES
from ...errors import InputError, ParameterError
from ...geometry import Wrap
from ...methods.base import method_of
from ...version import VERSION
from ..help import HelpfulCommand
from ..options import (
    ALPHA,
    DEPTHS,
    DONORS,
    FILE,
    KNOWN,
    common,
    gathered,
    grown_target_options,
    input_options,
    opt,
    report_options,
)
from ..pictures import asked_pictures, with_pictures
from ..report import Report
from ..request import Begin, Border, Inputs, Labels, Targets, Wish
from ..values import PLANE_WEIGHT, Channels, Colour, NamedFile, Rectangle, Scale
from .grow import check_stdout
from .heal import MOST_EDGE, MOST_GROWN, USABLE

if TYPE_CHECKING:
    from ...exemplar import Exemplar
    from ...guide import Guide
    from ...synthesis import Scene

PICTURES = (
    KNOWN,
    opt(
        "masks", "--mask", multiple=True, type=FILE, metavar="FILE",
        help="The mask that was given. That is the hole that was healed, elsewhere the exemplar pixels that could be "
        "used.",
    ),
    DONORS.but(help="What new pixels were taken from. By default the picture itself."),
)


@dataclass(frozen=True)
class Beside:
    """Files that were used beside the exemplars, none of which a recipe holds: it knows them by their hashes."""

    usable: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()
    target: str | None = None
    start: str | None = None
    pictures: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        if self.start == "-":
            raise ParameterError("a map is read from a file; give --start the name of a .npz.")


BESIDE = (
    replace(USABLE, field="usable"),
    opt("labels", "--labels", "-l", multiple=True, type=FILE, metavar="FILE", help="What paint was given as --labels."),
    opt("target", "--target", "-t", type=FILE, metavar="FILE", help="What paint was given as --target."),
    opt("start", "--start", type=FILE, metavar="MAP.npz", help="The map that was continued."),
    opt(
        "pictures", "--picture", multiple=True, type=NamedFile(), metavar="PARAMETER=FILE",
        help="A picture that was given as a parameter, such as jitter_output=calm.png; once for each.",
    ),
)


@click.command(name="replay", cls=HelpfulCommand)
@click.argument("picture", type=FILE, metavar="FILE")
@grown_target_options
@gathered(*BESIDE, into="beside", make=Beside)
@input_options(*PICTURES, without=("masks",))
@common
@report_options
def command(
    picture: str, inputs: Inputs, targets: Targets, beside: Beside, report: Report, threads: int | None
) -> None:
    """Make a picture again from the recipe in FILE (or in FILE.recipe.json), pixel for pixel.

    \b
    intarsia replay floor.png -o again.png --exemplar planks.png
    intarsia replay clean.png -o again.png --exemplar wall.png --mask graffiti.png
    intarsia replay island.png -o again.png --exemplar coast.png --labels coast_labels.png --target map.png

    Give the files again that were used, --map, --mask, --from, --labels and --target too, and pictures of parameters
    as --picture: they are checked against the recipe. Of planks_grown.png planks.png is found beside it, and so are
    mask.png, labels.png, target.png and PARAMETER.png. Everything else is in it, such as --crop, --flatten, --avoid and
    --depth, and a hole that was the picture's own alpha. Built-in exemplars (sample:...) need no --exemplar.
    """
    check_stdout(targets, report)
    from ... import files
    from ..batch import Batch

    recipe = files.read_recipe(picture)
    if recipe is None:
        raise InputError(f"{picture} carries no recipe; give a picture that intarsia wrote, or its .recipe.json.")
    if "origin" in recipe:
        raise InputError(f"{picture} was woven; make it again with intarsia weave, from the same exemplar and options.")
    if "advected" in recipe:
        raise InputError(f"{picture} was moved by a flow that no recipe holds; run again the program that moved it.")
    inputs, beside = found_beside(picture, recipe, inputs, beside, report)
    recipe = with_pictures(recipe, dict(beside.pictures), picture)
    wish, seed = wish_of(recipe, picture)
    if recipe.get("intarsia") != VERSION:
        report.warn(
            f"{picture} was made by intarsia {recipe.get('intarsia', 'of unknown version')}, this is {VERSION}; "
            "the picture may differ."
        )
    wish = with_files(replace(wish, pictures=dict(beside.pictures)), recipe, inputs, beside, picture)
    if "auto" in recipe:
        wish = replace(wish, said={"auto": recipe["auto"]})
    inputs = inputs_of(recipe, inputs, beside, picture)
    if targets.depth is None and "depth" in recipe:
        if recipe["depth"] not in DEPTHS:
            raise InputError(f"the depth in the recipe of {picture} is damaged; grow it again.")
        targets = replace(targets, depth=recipe["depth"])
    if wish.size is not None:
        wish = replace(wish, size=(wish.size[0] * inputs.magnify, wish.size[1] * inputs.magnify))
    batch = Batch.plan(inputs, targets, wish, (seed,), report, lambda scene: check_scene(recipe, scene, wish))
    batch.carry_out(threads)


def found_beside(
    picture: str, recipe: dict[str, Any], inputs: Inputs, beside: Beside, report: Report
) -> tuple[Inputs, Beside]:
    """Add what is not named and lies beside the picture; ParameterError that tells of all that is still missing."""
    from ..beside import Neighbours

    try:
        near = Neighbours(picture)
        names = [str(entry.get("name", "")) for entry in recipe["exemplars"]]
        mine = not all(name.startswith("sample:") for name in names)
        healed, painted = "heal" in recipe and recipe["heal"].get("mask") != "alpha", "guide" in recipe
        begun = healed or "extend" in recipe or "tile" in recipe
        asked = [key for key, was in asked_pictures(recipe).items() if "function" not in was]
        exemplar = inputs.files or (near.exemplar(recipe) if mine else ())
    except (KeyError, TypeError, AttributeError):
        return inputs, beside  # a damaged recipe is told of by what reads all of it

    def one(needed: bool, given: tuple[str, ...], word: str) -> tuple[str, ...]:
        found = near.called(word) if needed and not given else None
        return given if found is None else (found,)

    masks, labels = one(healed, inputs.masks, "mask"), one(painted, beside.labels, "labels")
    target = next(iter(one(painted, () if beside.target is None else (beside.target,), "target")), None)
    drawn = dict(beside.pictures)
    drawn |= {key: path for key in asked if key not in drawn and (path := near.called(key)) is not None}
    missing = [
        ("--exemplar FILE", mine and not exemplar), ("--mask FILE", healed and not masks),
        ("--labels FILE", painted and not labels), ("--target FILE", painted and target is None),
        ("--from FILE", begun and len(names) > 1 and not inputs.donors),
        ("--start FILE", "start" in recipe and not begun and "heal" not in recipe and beside.start is None),
        *((f"--picture {key}=FILE", key not in drawn) for key in asked),
    ]  # fmt: skip
    if lacking := [option for option, lacks in missing if lacks]:
        raise ParameterError(
            f"{picture} was made with {', '.join(lacking)}: its recipe holds their hashes alone; name the files."
        )
    now = {*exemplar, *masks, *labels, *([] if target is None else [target]), *drawn.values()}
    before = {*inputs.files, *inputs.masks, *beside.labels, beside.target, *dict(beside.pictures).values()}
    if added := sorted(now - before):
        report.note(f"taken from beside it: {', '.join(added)}")
    inputs = replace(inputs, files=exemplar, masks=masks)
    return inputs, replace(beside, labels=labels, target=target, pictures=tuple(drawn.items()))


def wish_of(recipe: dict[str, Any], name: str) -> tuple[Wish, int]:
    """Read method, size, wrap, blend, seed, and what the canvas began with."""
    from ...canvas import Canvas
    from ...draws import check_seed
    from ...sourcemap import Blend

    try:
        method = method_of(recipe["method"], {**recipe["parameters"]})
        width, height = (_whole(n) for n in recipe["size"])
        blend = recipe["blend"]
        if not isinstance(recipe["exemplars"], list) or not recipe["exemplars"]:
            raise ValueError
        for entry in recipe["exemplars"]:
            str(entry["sha256"])
        begin = _begin(recipe)
        size = (width, height) if begin is None else None
        _whole(blend["feather"])
        joined = Blend.of(blend)
        if size is not None:
            Canvas(height, width)
        wish = Wish(
            method, size, Wrap(recipe["wrap"]).value, joined.feather, blend["mixing"], begin, finish=joined.finish,
            repair=_whole(recipe.get("repair", 0), 0, MOST_PASSES),
        )  # fmt: skip
        return wish, check_seed(_whole(recipe["seed"]))
    except ParameterError as e:
        raise InputError(f"the recipe of {name} cannot be followed: {e}") from None
    except (KeyError, TypeError, ValueError, AttributeError):
        raise _damaged(name) from None


def with_files(wish: Wish, recipe: dict[str, Any], inputs: Inputs, beside: Beside, name: str) -> Wish:
    """Add to a wish what the recipe knows only by its hash: hole, labels and target, start map."""
    begin = wish.begin
    healed, painted = "heal" in recipe, "guide" in recipe
    continued = "start" in recipe and begin is None
    asked: tuple[tuple[str, bool, object], ...] = (
        ("--labels", painted, beside.labels), ("--target", painted, beside.target),
        ("--start", continued, beside.start),
        ("--from", begin is not None and len(recipe["exemplars"]) > 1, inputs.donors),
        ("--mask", healed and not (begin and begin.holes), inputs.masks),
    )  # fmt: skip
    for option, needed, given in asked:
        if given and not needed and (healed or option != "--mask"):
            raise ParameterError(f"{name} was made without {option}; drop it.")
    try:
        if begin is not None and healed:
            wish = replace(wish, begin=replace(begin, holes=begin.holes or inputs.masks))
        if painted and beside.target is not None:
            guide = recipe["guide"]
            wish = replace(
                wish, labels=Labels(beside.labels, beside.target, float(guide["weight"]), _whole(guide["reach"]))
            )
        if continued and beside.start is not None:
            wish = replace(wish, start=(beside.start, None if "rim" not in recipe else _whole(recipe["rim"], 0)))
    except (KeyError, TypeError, ValueError):
        raise _damaged(name) from None
    return wish


def inputs_of(recipe: dict[str, Any], given: Inputs, beside: Beside, name: str) -> Inputs:
    """Return the inputs as the recipe had them; what is given now goes first."""
    named = [entry.get("name", "") for entry in recipe["exemplars"]]
    said = recipe.get("inputs", {})
    try:
        return replace(
            given,
            files=given.files or tuple(named),
            masks=beside.usable + (() if "heal" in recipe else given.masks),
            alpha=ALPHA.convert(said.get("alpha", "auto"), None, None) if given.alpha == "auto" else given.alpha,
            avoid=given.avoid or (Colour()(said["avoid"]) if "avoid" in said else None),
            toroidal=given.toroidal or bool(said.get("toroidal", False)),
            crop=given.crop or (Rectangle()(",".join(map(str, said["crop"]))) if "crop" in said else None),
            flatten=given.flatten or bool(said.get("flatten", False)),
            scale=given.scale if given.scale != 1 else Scale()(str(said.get("scale", "1/1"))),
            weights=given.weights or tuple(PLANE_WEIGHT(f"{n}={w}") for n, w in said.get("weights", {}).items()),
            packed=given.packed or (Channels()(said["packed"]) if "packed" in said else None),
            magnify=_whole(said.get("magnify", 1), 1, TIMES),
        )
    except (click.UsageError, ParameterError, TypeError, ValueError, AttributeError):
        raise InputError(f"the inputs in the recipe of {name} are damaged; grow it again.") from None


def check_scene(recipe: dict[str, Any], scene: Scene, wish: Wish) -> None:
    """Refuse whatever is not what the recipe was made with, naming the file.

    The hole goes before the pictures: pixels in it count as unusable, so that a wrong hole changes them, too.
    """
    expected, found = recipe["exemplars"], scene.exemplars
    if len(expected) != len(found):
        raise InputError(f"the recipe has {len(expected)} exemplars, {len(found)} are given; give the same files.")
    _check_begun(recipe, scene, wish)
    for entry, exemplar in zip(expected, found, strict=True):
        if entry["sha256"] != exemplar.digest:
            raise _another(entry, exemplar)
    if wish.labels is not None and scene.canvas.guide is not None:
        _check_guide(recipe["guide"], scene.canvas.guide, wish.labels)


def _check_begun(recipe: dict[str, Any], scene: Scene, wish: Wish) -> None:
    start, begin = scene.canvas.start, wish.begin
    if start is None or start.digest == recipe.get("start"):
        return
    first, size = scene.exemplars[0], recipe["size"]
    if wish.start is not None:
        raise InputError(f"{wish.start[0]} is another map than the recipe was made with; give the same file.")
    if begin is None or not begin.holes or [first.width, first.height] != size or begin.holes[0] == "alpha":
        raise _another(recipe["exemplars"][0], first)
    raise InputError(f"{begin.holes[0]} marks another hole than the recipe was made with; give the same --mask.")


def _check_guide(recorded: dict[str, Any], guide: Guide, given: Labels) -> None:
    if recorded.get("sha256") == guide.digest:
        return
    known = [*recorded.get("labels", []), recorded.get("target")]
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


def _begin(recipe: dict[str, Any]) -> Begin | None:
    """What the canvas began with: margins, or holes; those of the picture's own alpha need no file."""
    if "extend" in recipe:
        left, right, top, bottom = (_whole(n) for n in recipe["extend"])
        return Begin((left, right, top, bottom))
    if "tile" in recipe:
        width, height = (_whole(n, 1) for n in recipe["size"])
        return Begin(border=Border(Wrap(recipe["wrap"]).value, _whole(recipe["tile"]["band"], 1), (width, height)))
    if "heal" in recipe:
        healed = recipe["heal"]
        holes = ("alpha",) if healed.get("mask") == "alpha" else ()
        return Begin(None, holes, _whole(healed["grow"], 0, MOST_GROWN), _whole(recipe.get("edge", 0), 0, MOST_EDGE))
    return None


def _damaged(name: str) -> InputError:
    return InputError(f"the recipe of {name} is damaged, or of an unknown version; grow it again.")


def _whole(value: Any, low: int | None = None, high: int | None = None) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError
    if (low is not None and value < low) or (high is not None and value > high):
        raise ValueError
    return value
