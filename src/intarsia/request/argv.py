"""A request as the words of a command: what is not as the verb has it anyway, in the order of the table."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..methods.base import Method, keeps_lattice
from ..params import KINDS, parameters
from .field import FLAG, Field, Pair
from .fields import known_parameters, parameters_of, usual_parameters
from .request import FIELDS, Request, fields_of_verb


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
