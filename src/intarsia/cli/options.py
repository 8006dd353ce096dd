"""The options of a command, made of the table of what may be asked for; and the request that they say."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from ..choosing.auto import AUTO_METHOD
from ..errors import ParameterError
from ..methods.base import METHODS, method_class, preset
from ..params import Parameter, parameters
from ..request.field import Field
from ..request.kinds import FLAG, File, Kind, Number, Pair, Whole
from ..request.pictures import value_of
from ..request.request import Request, fields_of_verb, parameters_of_verb
from ..request.verbs import able

if TYPE_CHECKING:
    ParamType = click.ParamType[Any]
else:  # older versions of click do not take the bracket
    ParamType = click.ParamType


class ParameterOption(click.Option):
    """The option of a parameter that some methods have."""


class FileName(click.Path):
    """The name of a file, or - ; whoever opens it says what is wrong with it."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        return File().read(str(value))


FILE = FileName()


class InRange(click.FloatRange):
    """A number in a range, which NaN is not."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        found = super().convert(value, param, ctx)
        if found != found:
            self.fail(f"{value} is no number; give {self.min:g} to {self.max:g}.", param, ctx)
        return found


class Typed(ParamType):
    """A kind of value, as click asks for it."""

    def __init__(self, kind: Kind) -> None:
        self.kind, self.name = kind, kind.shown

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        if not isinstance(value, str):
            return value
        try:
            return self.kind.read(value)
        except ValueError as e:
            self.fail(str(e), param, ctx)


def type_of(kind: Kind) -> Any:
    """What click reads a kind of value with; its own types where it has one, as their messages are known."""
    if isinstance(kind, File):
        return FILE
    if isinstance(kind, Pair):
        return tuple(map(type_of, kind.kinds))
    if isinstance(kind, Number):
        return InRange(kind.low, kind.high)
    if isinstance(kind, Whole) and not kind.choices:
        return click.IntRange(kind.low, kind.high)
    if kind.name == "choice":
        return click.Choice(kind.choices)
    return str if type(kind) is Kind else Typed(kind)


def option_of(field: Field) -> click.Parameter:
    """Make the option of a field, or its argument."""
    facts: dict[str, Any] = {"required": field.required}
    if field.kind is FLAG:
        facts |= {"is_flag": True}
    else:
        facts |= {"type": type_of(field.kind), "metavar": field.shown or field.kind.shown or None}
    if not field.flags:
        return click.Argument([field.name], nargs=-1 if field.many else 1, **facts)
    if field.alone is not None:
        facts |= {"is_flag": False, "flag_value": field.alone}
    if field.default is not None and not field.many and field.kind is not FLAG:
        facts |= {"default": field.default}
    names = [field.name, *field.flags]
    return click.Option(names, help=field.help, multiple=field.many, show_default=field.tells_default, **facts)


METAVARS = {
    "extent": "PX|WxH",
    "int": "N",
    "float": "F",
    "weights": "W,W,...",
    "levels": "F|F,F,...",
    "price": "F|inf",
    "pins": "'X,Y -> X,Y R'",
    "vectors": "'X,Y X,Y'",
    "isometries": "none|180|90|both|auto|IDS",
    "field": "F|FILE",
    "picture": "FILE",
}


def method_option(p: Parameter, owners: list[str], every: bool) -> ParameterOption:
    """Make the option of a method's parameter, as text that the method's own rules read later."""
    default = "" if p.default is None else f" Default: {_default(p)}."
    only = "" if every else f" ({', '.join(owners)})"
    metavar = "|".join((*p.choices, *([METAVARS[p.kind]] if p.kind in METAVARS else [])))
    text = f"{p.help[:1].upper()}{p.help[1:]}.{default}{only}"
    names = [p.name, "--" + p.name.replace("_", "-")]
    return ParameterOption(names, metavar=metavar or p.kind.upper(), help=text)


def _default(p: Parameter) -> str:
    value = p.default
    if isinstance(value, tuple):
        return ("x" if p.kind == "extent" else ",").join(map(str, reversed(value) if p.kind == "extent" else value))
    return f"{value} {p.unit}".strip() if p.kind in ("int", "extent") else str(value)


def parameters_of(verb: str) -> list[click.Parameter]:
    """Make all that a command takes: arguments first, as what misses one says so."""
    fields, number = fields_of_verb(verb), len(able(verb))
    own = [method_option(p, owners, len(owners) == number) for p, owners in parameters_of_verb(verb).values()]
    debug = click.Option(["--debug"], is_flag=True, expose_value=False, hidden=True)
    return [*map(option_of, sorted(fields, key=lambda f: bool(f.flags))), *own, debug]


def request_of(verb: str, given: dict[str, Any]) -> Request:
    """Understand the values of all options of a verb."""
    if given.get("document") is not None:
        given = as_published(given["document"], given)
    slug = given.get("method", AUTO_METHOD)
    own = {p.name: p for p in parameters(method_class(slug))} if slug in METHODS else {}
    values = {}
    for name, (p, _) in parameters_of_verb(verb).items():
        if (text := given.pop(name)) is not None:
            values[name] = value_of(own.get(name, p), text)
    return Request(verb, **given, parameters=values)


def as_published(document: str, given: dict[str, Any]) -> dict[str, Any]:
    """Return the values of options with those that a document sets where nothing else is given."""
    settings = preset(document)
    if given["method"] not in (AUTO_METHOD, settings["method"]):
        raise ParameterError(f"--as {document} sets --method {settings['method']}; drop one of them.")
    usual = {"method": AUTO_METHOD}
    return given | {name: text for name, text in settings.items() if given[name] == usual.get(name)}
