"""A request as JSON: what the studio sends, and what a recipe holds; a recipe names no paths.

Keys of a job are the options' names; a value is a number, a text, or a list.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..arguments import whole
from ..blend import Blend
from ..choosing.auto import AUTO_METHOD
from ..errors import InputError, ParameterError
from ..lazy import lazy
from ..methods.base import method_of
from ..params import KINDS
from .argv import settings_of
from .field import FLAG, Field
from .fields import BEGUN, known_parameters, parameters_of
from .pictures import value_of
from .request import FIELDS, Request, fields_of_verb, parameters_of_verb

if TYPE_CHECKING:
    from .. import canvas
else:  # only recipes need it
    canvas = lazy("intarsia.canvas")

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
        found = _filled(recipe, given)
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


def _filled(recipe: Mapping[str, Any], given: Request) -> Request:
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
        canvas.Canvas(height, width)
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


def from_json(verb: str, given: Mapping[str, Any], **more: Any) -> Request:
    """Return the request that a verb and its options say; `more` are fields that are no options of a job.

    ParameterError where a value is none, said of the option by the name that it has here.
    """
    values = dict(more)
    for field in fields_of_verb(verb):
        if field.flags and field.name not in more:
            if (value := given.get(field.key)) is not None:
                values[field.name] = _read(field, value)
            elif field.required:
                raise ParameterError(f"Missing option {_called(field)}.")
    return Request(verb, **values, parameters=parameter_values(verb, values.get("method", AUTO_METHOD), given))


def parameter_values(verb: str, slug: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Read the parameters of methods among the options that are given, as the method `slug` has them."""
    own, fields = parameters_of(slug), {f.name for f in fields_of_verb(verb)}
    others = any(value is not None for name, value in given.items() if name not in fields and name not in own)
    return {
        name: value_of(own.get(name, p), text_of(p.kind, given[name]))
        for name, (p, _) in parameters_of_verb(verb, None if others else slug).items() if given.get(name) is not None
    }  # fmt: skip


def to_json(request: Request) -> dict[str, Any]:
    """Return the options of a job that says a request: what is not as the verb has it anyway."""
    told = {
        f.key: [f.kind.json(one) for one in value] if f.many else f.kind.json(value)
        for f in fields_of_verb(request.verb) if f.flags and (value := getattr(request, f.name)) != f.default
    }  # fmt: skip
    known, drawn = known_parameters(), request.drawn
    asked = {n: drawn.get(n) or KINDS[known[n][0].kind].text(v) for n, v in request.parameters.items()}
    return told | asked


def text_of(kind: str, value: Any) -> str:
    """Write a value of JSON as an option reads it."""
    if isinstance(value, list):
        return ("x" if kind in ("size", "extent") else ",").join(map(str, value))
    return str(value)


def _read(field: Field, value: Any) -> Any:
    if field.kind is FLAG:
        if not isinstance(value, bool):
            raise ParameterError(f"{field.key} is yes or no; give true or false.")
        return value
    values = value if field.many and isinstance(value, list) else [value]
    try:
        read = [field.kind.read(text_of(field.kind.name, one)) for one in values]
    except ValueError as e:
        raise ParameterError(f"{field.key}: {e}") from None
    return tuple(read) if field.many else read[0]


def _called(field: Field) -> str:
    return " / ".join(f"'{flag}'" for flag in field.flags)
