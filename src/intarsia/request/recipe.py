"""What a recipe says of a request: all that bears on the picture, but no path; and the request again that it tells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ..arguments import whole
from ..blend import Blend
from ..canvas import Canvas
from ..errors import InputError, ParameterError
from ..methods.base import method_of
from .argv import settings_of
from .fields import BEGUN
from .request import FIELDS, Request

MOVED = {"rule": "near", "neighbourhood": "appearance", "neighbourhood_mask": None, "k": 2, "subpasses": 4}
"""Parameters that parallel-controllable had before they were those of correction-2008, and what it does instead."""

VERBS = {"extend": "extend", "tile": "tile", "heal": "heal", "guide": "paint"}
"""What a recipe holds -> the verb that it is of; `grow`, where it holds none of them."""


def inputs_of(request: Request) -> dict[str, Any]:
    """Return what a recipe says of the exemplars: all in which they are not used as they are."""
    told = {}
    for field in FIELDS:
        value = getattr(request, field.name)
        if field.of_exemplars and value != field.default:
            told[field.name] = dict(value) if field.many else field.kind.json(value)
    return told


def from_recipe(recipe: Mapping[str, Any], given: Request, called: str) -> Request:
    """Return the request that made what carries a recipe; its files are those that are given.

    What is `given` otherwise goes before what the recipe says. InputError where the recipe is damaged: it is `called`
    so then. ParameterError where files are given that it does not ask for.
    """
    try:
        found = _read(recipe, given)
    except ParameterError as e:
        raise InputError(f"{called} cannot be followed: {e}") from None
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(f"{called} is damaged, or of an unknown version; grow it again.") from None
    for option, needed, files in (
        ("--labels", "guide" in recipe, given.labels), ("--target", "guide" in recipe, given.target),
        ("--start", "start" in recipe and not found.begun, given.start),
        ("--from", found.begun and len(recipe["exemplars"]) > 1, given.donors),
        ("--mask", found.holes != ("alpha",), given.masks),
    ):  # fmt: skip
        if files and not needed:
            raise ParameterError(f"{given.picture} was made without {option}; drop it.")
    return found


def _read(recipe: Mapping[str, Any], given: Request) -> Request:
    verb = next((verb for word, verb in VERBS.items() if word in recipe), "grow")
    slug, settings = recipe["method"], {**recipe["parameters"]}
    for name, was in MOVED.items() if slug == "parallel-controllable" else ():
        if settings.pop(name, was) != was:
            raise ParameterError(f"{name} of {slug} is one of correction-2008 now; grow it again with that method.")
    method, joined = method_of(slug, settings), Blend.of(recipe["blend"])
    told, names = _fields(recipe, given), [(str(e["sha256"]), e.get("name", ""))[1] for e in recipe["exemplars"]]
    (width, height), times = recipe["size"], told.get("magnify", given.magnify)
    if not names:
        raise ValueError
    told |= {"method": method.slug, "parameters": settings_of(method), "finish": joined.finish, "usable": ()}
    told |= {"files": given.files or tuple(names), "said": {k: recipe[k] for k in ("auto",) if k in recipe}}
    told["masks"] = given.usable + (() if verb == "heal" else given.masks)
    if verb == "extend":
        left, right, top, bottom = map(whole, recipe["extend"])
        told |= {"left": left, "right": right, "top": top, "bottom": bottom}
    if verb == "heal":
        told["holes"] = ("alpha",) if recipe["heal"].get("mask") == "alpha" else given.masks
    if verb == "tile":
        told["axes"] = told["wrap"]
    if verb not in BEGUN:
        Canvas(height, width)
        told["size"] = width * times, height * times
        if "start" in recipe and "rim" in recipe:
            told["rim"] = whole(recipe["rim"])
    return replace(given, verb=verb, picture=None, **told)


def _fields(recipe: Mapping[str, Any], given: Request) -> dict[str, Any]:
    """Read the fields that the table says a recipe holds, but for those that are given."""
    told = {}
    for field in FIELDS:
        root, _, leaf = field.recipe.partition(".")
        if root in recipe and getattr(given, field.name) == field.default:
            value = recipe[root]
            if field.of_exemplars and leaf not in value:
                continue
            if leaf:
                value = value[leaf]
            told[field.name] = field.of_json(value)
    if not {"seed", "wrap", "size"} <= set(told):
        raise KeyError
    return told
