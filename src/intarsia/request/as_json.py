"""A request as JSON: what the studio sends. Keys are the options' names; a value is a number, a text, or a list."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..choosing.auto import AUTO_METHOD
from ..errors import ParameterError
from ..params import KINDS
from .field import Field
from .fields import known_parameters, parameters_of
from .kinds import FLAG
from .pictures import value_of
from .request import Request, fields_of_verb, parameters_of_verb


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
    own = parameters_of(slug)
    return {
        name: value_of(own.get(name, p), text_of(p.kind, given[name]))
        for name, (p, _) in parameters_of_verb(verb).items() if given.get(name) is not None
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
