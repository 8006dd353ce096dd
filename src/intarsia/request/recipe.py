"""What a recipe says of a request: all that bears on the picture, but no path; and the request again that it tells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ..arguments import MOST_PASSES
from ..blend import Blend
from ..canvas import Canvas
from ..draws import check_seed
from ..errors import InputError, ParameterError
from ..geometry import Wrap
from ..methods.base import method_of
from .argv import settings_of
from .field import Field
from .fields import DEPTHS, MOST_EDGE, MOST_GROWN
from .pictures import with_pictures
from .request import FIELDS, Request


def inputs_of(request: Request) -> dict[str, Any]:
    """Return what a recipe says of the exemplars: all in which they are not used as they are."""
    told = {}
    for field in FIELDS:
        value = getattr(request, field.name)
        if field.recipe and value != field.default:
            told[field.name] = dict(value) if field.many else field.kind.json(value)
    return told


def begun_as(recipe: Mapping[str, Any]) -> str:
    """The verb that a recipe is of."""
    verbs = {"extend": "extend", "tile": "tile", "heal": "heal", "guide": "paint"}
    return next((verb for word, verb in verbs.items() if word in recipe), "grow")


def from_recipe(recipe: dict[str, Any], given: Request, name: str) -> Request:
    """Return the request that made what is called `name` and carries a recipe; its files are those that are given.

    What is `given` otherwise goes before what the recipe says. Raises InputError where the recipe is damaged, and
    ParameterError where files are given that it does not ask for.
    """
    recipe = with_pictures(recipe, dict(given.pictures), name)
    try:
        told = _work(recipe) | _begun(recipe, given)
    except ParameterError as e:
        raise InputError(f"the recipe of {name} cannot be followed: {e}") from None
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(f"the recipe of {name} is damaged, or of an unknown version; grow it again.") from None
    verb = begun_as(recipe)
    _check_given(recipe, verb, given, name)
    request = _with_inputs(recipe, given, name)
    if given.depth is None and "depth" in recipe:
        if recipe["depth"] not in DEPTHS:
            raise InputError(f"the depth in the recipe of {name} is damaged; grow it again.")
        told["depth"] = recipe["depth"]
    if "size" in told and verb != "tile":
        told["size"] = tuple(side * request.magnify for side in told["size"])
    masks = given.usable + (() if verb == "heal" else given.masks)
    said = {"auto": recipe["auto"]} if "auto" in recipe else {}
    try:
        return replace(request, verb=verb, masks=masks, usable=(), picture=None, said=said, **told)
    except ParameterError as e:
        raise InputError(f"the recipe of {name} cannot be followed: {e}") from None


def _work(recipe: dict[str, Any]) -> dict[str, Any]:
    """Read method, seed, wrap, joins and repair."""
    method, blend = method_of(recipe["method"], {**recipe["parameters"]}), recipe["blend"]
    if not isinstance(recipe["exemplars"], list) or not recipe["exemplars"]:
        raise ValueError
    for entry in recipe["exemplars"]:
        str(entry["sha256"])
    _whole(blend["feather"])
    joined = Blend.of(blend)
    return {
        "method": method.slug, "parameters": settings_of(method), "seed": check_seed(_whole(recipe["seed"])),
        "wrap": Wrap(recipe["wrap"]).value, "feather": joined.feather, "mixing": blend["mixing"],
        "finish": joined.finish, "repair": _whole(recipe.get("repair", 0), 0, MOST_PASSES),
    }  # fmt: skip


def _begun(recipe: dict[str, Any], given: Request) -> dict[str, Any]:
    """Read what the canvas begins with: margins, a band, holes, labels, a map, or nothing, and how large it is."""
    verb, (width, height) = begun_as(recipe), (_whole(n) for n in recipe["size"])
    if verb == "extend":
        sides = (_whole(n) for n in recipe["extend"])
        return dict(zip(("left", "right", "top", "bottom"), sides, strict=True))
    if verb == "tile":
        band, size = _whole(recipe["tile"]["band"], 1), (_whole(width, 1), _whole(height, 1))
        return {"axes": Wrap(recipe["wrap"]).value, "band": band, "size": size}
    if verb == "heal":
        healed = recipe["heal"]
        return {
            "holes": ("alpha",) if healed.get("mask") == "alpha" else given.masks,
            "grow": _whole(healed["grow"], 0, MOST_GROWN), "edge": _whole(recipe.get("edge", 0), 0, MOST_EDGE),
        }  # fmt: skip
    Canvas(height, width)
    told: dict[str, Any] = {"size": (width, height)}
    if verb == "paint":
        told |= {"weight": float(recipe["guide"]["weight"]), "reach": _whole(recipe["guide"]["reach"])}
    if "start" in recipe and "rim" in recipe:
        told["rim"] = _whole(recipe["rim"], 0)
    return told


def _check_given(recipe: dict[str, Any], verb: str, given: Request, name: str) -> None:
    """Refuse files that the recipe does not ask for."""
    painted, begun = "guide" in recipe, verb in ("extend", "heal", "tile")
    for option, needed, files in (
        ("--labels", painted, given.labels), ("--target", painted, given.target),
        ("--start", "start" in recipe and not begun, given.start),
        ("--from", begun and len(recipe["exemplars"]) > 1, given.donors),
        ("--mask", verb != "heal" or recipe["heal"].get("mask") != "alpha", given.masks),
    ):  # fmt: skip
        if files and not needed:
            raise ParameterError(f"{name} was made without {option}; drop it.")


def _with_inputs(recipe: dict[str, Any], given: Request, name: str) -> Request:
    """Return the request with exemplars used as the recipe had them; what is given now goes first."""
    try:
        said = recipe.get("inputs", {})
        told: dict[str, Any] = {
            f.name: _read(f, said[f.name])
            for f in FIELDS if f.recipe and f.name in said and getattr(given, f.name) == f.default
        }  # fmt: skip
        return replace(
            given, files=given.files or tuple(entry.get("name", "") for entry in recipe["exemplars"]), **told
        )
    except (ParameterError, TypeError, ValueError, AttributeError):
        raise InputError(f"the inputs in the recipe of {name} are damaged; grow it again.") from None


def _read(field: Field, value: Any) -> Any:
    """Read a field as a recipe holds it."""
    if field.many:
        return tuple(field.kind.read(f"{name}={one}") for name, one in value.items())
    return field.kind.of_json(value)


def _whole(value: Any, low: int | None = None, high: int | None = None) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError
    if (low is not None and value < low) or (high is not None and value > high):
        raise ValueError
    return value
