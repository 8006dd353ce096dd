"""``intarsia replay``: a picture again, from the recipe that it carries. Imports nothing heavy before the work."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import click

from .. import __version__
from ..errors import InputError, ParameterError
from ..methods.base import make, method_class
from ..params import parameters
from .grow import check_stdout
from .options import ALPHA, DEPTHS, FILE, common, grown_target_options, input_options, opt, report_options
from .report import Report
from .request import Begin, Inputs, Targets, Wish
from .values import Colour, Rectangle, Scale


@click.command(name="replay")
@click.argument("picture", type=FILE, metavar="FILE")
@grown_target_options
@input_options(
    opt("files", "--exemplar", "-e", multiple=True, type=FILE, metavar="FILE", help="The exemplar; once for each file.")
)
@common
@report_options
def command(picture: str, inputs: Inputs, targets: Targets, report: Report, threads: int | None) -> None:
    """Make a picture again from the recipe in FILE (or in FILE.recipe.json), pixel for pixel.

    The exemplars are checked against the recipe. Give --map and --mask again where they were used; --crop, --scale,
    --flatten, --alpha, --avoid, --toroidal and --depth are in the recipe. Built-in exemplars (sample:...) need no
    --exemplar.
    """
    check_stdout(targets, report)
    from .. import files
    from .batch import Batch

    recipe = files.read_recipe(picture)
    if recipe is None:
        raise InputError(f"{picture} carries no recipe; give a picture that intarsia wrote, or its .recipe.json.")
    wish, seed = wish_of(recipe, picture)
    if recipe.get("intarsia") != __version__:
        report.warn(
            f"{picture} was made by intarsia {recipe.get('intarsia', 'of unknown version')}, this is {__version__}; "
            "the picture may differ."
        )
    inputs = inputs_of(recipe, inputs, picture)
    if targets.depth is None and "depth" in recipe:
        if recipe["depth"] not in DEPTHS:
            raise InputError(f"the depth in the recipe of {picture} is damaged; grow it again.")
        targets = replace(targets, depth=recipe["depth"])
    batch = Batch.plan(inputs, targets, wish, (seed,), report)
    check_exemplars(recipe["exemplars"], batch.shelf.get(0))
    batch.carry_out(threads)


def wish_of(recipe: dict[str, Any], name: str) -> tuple[Wish, int]:
    """Read method, size, wrap, blend and seed of a recipe."""
    from ..canvas import Canvas
    from ..draws import check_seed
    from ..sourcemap import Blend

    if "start" in recipe and "extend" not in recipe:
        raise InputError(f"{name} continued another picture, which its recipe does not hold; grow it again.")
    if "guide" in recipe:
        raise InputError(f"{name} followed a target picture, which its recipe does not hold; paint it again.")
    try:
        kinds = {p.name: p.kind for p in parameters(method_class(recipe["method"]))}
        given = {k: _value(kinds.get(k, ""), v) for k, v in recipe["parameters"].items()}
        width, height = (_whole(n) for n in recipe["size"])
        blend = recipe["blend"]
        if blend["mixing"] not in ("mean", "variance", "source") or recipe["wrap"] not in ("none", "x", "y", "both"):
            raise ValueError
        if not isinstance(recipe["exemplars"], list) or not recipe["exemplars"]:
            raise ValueError
        for entry in recipe["exemplars"]:
            str(entry["sha256"])
        method = make(recipe["method"], given)
        begin = Begin(_margins(recipe["extend"])) if "extend" in recipe else None
        size = (width, height) if begin is None else None
        _whole(blend["feather"])
        joined = Blend.of(blend)
        if size is not None:
            Canvas(height, width)
        wish = Wish(method, size, recipe["wrap"], joined.feather, blend["mixing"], begin, finish=joined.finish)
        return wish, check_seed(_whole(recipe["seed"]))
    except ParameterError as e:
        raise InputError(f"the recipe of {name} cannot be followed: {e}") from None
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(f"the recipe of {name} is damaged, or of an unknown version; grow it again.") from None


def inputs_of(recipe: dict[str, Any], given: Inputs, name: str) -> Inputs:
    """Return the inputs as the recipe had them; what is given now goes first."""
    named = [entry.get("name", "") for entry in recipe["exemplars"]]
    sources = given.files
    if not sources:
        if not all(isinstance(n, str) and n.startswith("sample:") for n in named):
            raise ParameterError(f"{name} was grown from pictures of yours; name them with --exemplar FILE.")
        sources = tuple(named)
    said = recipe.get("inputs", {})
    try:
        return replace(
            given,
            files=sources,
            alpha=ALPHA.convert(said.get("alpha", "auto"), None, None) if given.alpha == "auto" else given.alpha,
            avoid=given.avoid or (Colour()(said["avoid"]) if "avoid" in said else None),
            toroidal=given.toroidal or bool(said.get("toroidal", False)),
            crop=given.crop or (Rectangle()(",".join(map(str, said["crop"]))) if "crop" in said else None),
            flatten=given.flatten or bool(said.get("flatten", False)),
            scale=given.scale if given.scale != 1 else Scale()(str(said.get("scale", "1/1"))),
        )
    except (click.UsageError, TypeError, ValueError, AttributeError):
        raise InputError(f"the inputs in the recipe of {name} are damaged; grow it again.") from None


def check_exemplars(wanted: list[dict[str, Any]], found: Any) -> None:
    """Refuse exemplars other than those of the recipe."""
    if len(wanted) != len(found):
        raise InputError(f"the recipe has {len(wanted)} exemplars, {len(found)} are given; give the same files.")
    for entry, exemplar in zip(wanted, found, strict=True):
        if entry["sha256"] != exemplar.digest:
            raise InputError(
                f"{exemplar.name} is another exemplar (sha256 {exemplar.digest[:12]}) than that of the recipe "
                f"({str(entry['sha256'])[:12]}); give the same file, with the same --map and --mask."
            )


def _value(kind: str, value: Any) -> Any:
    if isinstance(value, list):
        return tuple(reversed(value)) if kind == "extent" else tuple(value)
    return value


def _margins(value: Any) -> tuple[int, int, int, int]:
    left, right, top, bottom = (_whole(n) for n in value)
    return left, right, top, bottom


def _whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError
    return value
