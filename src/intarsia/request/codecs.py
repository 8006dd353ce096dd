"""A request as JSON, what the studio sends and a recipe holds, and as the words of a command.

A recipe names no paths. Keys of a job are the options' names; a value is a number, a text, or a list. Of the words none
says what is as the verb has it anyway; they stand in the order of the table.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..arguments import whole
from ..blend import Blend
from ..choosing.auto import AUTO_METHOD
from ..errors import InputError, ParameterError
from ..lazy import lazy
from ..methods import Method, keeps_lattice, method_of
from ..params import KINDS, parameters
from . import FIELDS, Request, fields_of_verb, parameters_of_verb
from .field import FLAG, Field, Pair
from .fields import BEGUN, known_parameters, parameters_of, usual_parameters
from .pictures import value_of


def to_argv(request: Request, joined: bool = False) -> list[str]:
    """Return the words after ``intarsia`` that say a request; `joined`: an option and its value are one word."""
    arguments: list[str] = []
    options: list[str] = []
    for field in fields_of_verb(request.verb):
        value = getattr(request, field.name)
        if value != field.default:
            said = options if field.flags else arguments
            said += _said(field, value, joined)
    return [request.verb, *arguments, *options, *parameter_words(request, joined)]


def to_line(request: Request, joined: bool = False) -> str:
    """Return the line for a shell that says a request."""
    return shlex.join(["intarsia", *to_argv(request, joined)])


def once_more(request: Request, sets: Sequence[Mapping[str, str]], method: Method, seed: int, **more: Any) -> Request:
    """Return the request for the same picture with method and seed named, from the planes and masks of `sets`.

    What bears on nothing in the picture is left out; `more` are fields that are another.
    """
    further = [plane for found in sets for plane in list(found.items())[1:]]
    finish = request.finishing
    named: dict[str, Any] = {
        "files": tuple(next(iter(found.values())) for found in sets),
        "maps": tuple(plane for plane in further if plane[0] != "mask"),
        "masks": tuple(path for name, path in further if name == "mask"),
        "method": method.slug,
        "parameters": settings_of(method),
        "pictures": tuple(request.drawn.items()),
        "seed": seed,
        "level": None if finish is None else finish[0].radius if finish else 0,
        "finish": None,
        "repair": 0 if keeps_lattice(method) else request.repair,  # it was not repaired
    }
    passing = {field.name: field.default for field in FIELDS if field.passing}
    return replace(request, **passing | named | more)


def _said(field: Field, value: Any, joined: bool) -> list[str]:
    texts = [field.kind.text(one) for one in value] if field.many else [field.kind.text(value)]
    if not field.flags or field.kind is FLAG:
        return [field.flag] if field.flags else texts
    if isinstance(field.kind, Pair):
        texts = [kind.text(one) for kind, one in zip(field.kind.kinds, value, strict=True)]
        return [field.flag, *texts]
    short = field.flags[0]
    return [word for text in texts for word in _option(short if len(short) == 2 else field.flag, text, joined)]


def _option(flag: str, text: str, joined: bool) -> list[str]:
    return [f"{flag}={text}"] if joined and flag.startswith("--") else [flag, text]


def parameter_words(request: Request, joined: bool = False) -> list[str]:
    """Return the options that give the method its parameters, but for those that are as the verb has them."""
    own, drawn, said = parameters_of(request.method), request.drawn, list[str]()
    usual = {name: p.default for name, p in own.items()} | usual_parameters(request.verb, request.method)
    for name, value in request.parameters.items():
        if name not in usual or value != usual[name]:
            p = own.get(name) or known_parameters()[name][0]
            text = drawn.get(name) or KINDS[p.kind].text(value)
            said += _option("--" + name.replace("_", "-"), text, joined)
    return said


def settings_of(method: Method) -> dict[str, Any]:
    """Return the parameters of a method by name."""
    return {p.name: getattr(method, p.name) for p in parameters(method)}


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
