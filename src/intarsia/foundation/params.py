"""Declaration of method parameters: range, unit and help are given once, with the dataclass field.

Validation, the command line, ``methods --json`` and the docs read them by :func:`parameters` and :func:`check`.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any, NamedTuple

from . import InputError, Pair, ParameterError, Record, lazy, said, whole
from .geometry import ISOMETRY_SETS

if TYPE_CHECKING:
    from . import field
else:  # where a number differs from pixel to pixel
    field = lazy("intarsia.foundation.field")

OVER = ("field", "picture")  # kinds that vary over the output or the exemplar
MOST_LEVELS = 20  # most numbers of a parameter of the kind "levels"
NAMED_POSES = (*ISOMETRY_SETS, "auto")  # names that a parameter of the kind "isometries" takes
AUTO = None  # a field left at AUTO is decided from the exemplar

Extent = int | Pair | None  # one side, or rows and columns, px
Weights = tuple[float, ...] | None  # how much each channel counts
Poses = str | tuple[int, ...]  # isometries, by the name of a set of them or by their numbers
Steps = tuple[tuple[float, float], ...]  # by which a texture repeats: one vector or two, (x, y) px


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of a method: name, kind, default, range, unit, choices and help."""

    name: str
    kind: str
    default: Any
    low: float | None = None
    high: float | None = None
    unit: str = ""
    choices: tuple[str, ...] = ()
    help: str
    over: str = ""

    def as_dict(self) -> Record:
        """Return the entry for ``methods --json``; ``over`` only for fields."""
        told = {key: value for key, value in vars(self).items() if key != "over" or value}
        return {key: list(value) if isinstance(value, tuple) else value for key, value in told.items()}

    def allowed(self) -> str:
        """Return in words which values are allowed."""
        span = "any number"
        if self.low is not None and self.high is not None:
            span = f"{self.low:g} to {self.high:g}"
        elif self.low is not None:
            span = f"at least {self.low:g}"
        span += f" {self.unit}" * bool(self.unit)
        said = KINDS[self.kind].allowed.format(span=span, choices=", ".join(self.choices), over=self.over)
        between = ", or " if self.kind == "picture" else ", "
        return between.join((*self.choices, said)) if self.kind in OVER else said


def param(default: Any, kind: str, help: str, **facts: Any) -> Any:
    """Declare a parameter as a dataclass field, with its default, kind, help and range.

    Kinds (:data:`KINDS`): ``int``, ``float``, ``choice``, ``extent`` (one number, or a pair (rows, columns)),
    ``weights`` (a tuple of numbers), ``levels`` (one number, or a tuple of them), ``price`` (a number or "inf"),
    ``pins`` (tuples of five whole numbers), ``vectors`` (one or two pairs (x, y)), ``isometries`` (a name, or ids;
    ``auto`` is decided from the exemplar by `Method.resolved`), ``field`` (a number for every pixel ``over`` the
    "output" or the "exemplar": a number, a gray picture, a function, a Field, or one of the choices), ``picture`` (the
    same, but no plain number). `facts` are ``low``, ``high``, ``unit``, ``choices`` and ``over`` of :class:`Parameter`.
    """
    return dataclasses.field(default=default, metadata={"param": {"kind": kind, "help": help, **facts}})


def parameters(method: Any) -> list[Parameter]:
    """Return the parameters of a method (an instance or its class) in the order of its fields."""
    return [
        Parameter(name=f.name, default=f.default, **f.metadata["param"])
        for f in dataclasses.fields(method)
        if "param" in f.metadata
    ]


def values_of(method: Any) -> Record:
    """Return the values of the parameters of a method, by name."""
    return {p.name: getattr(method, p.name) for p in parameters(method)}


def functions_of(method: Any) -> Record:
    """Return the parameters of a method that are functions, by name."""
    return {k: v for k, v in values_of(method).items() if isinstance(v, field.Field) and v.is_function}


def check(method: Any) -> None:
    """Raise ParameterError for a parameter out of its range; bring the given values into normal form."""
    for p in parameters(method):
        value = getattr(method, p.name)
        if value is AUTO and p.default is AUTO:
            continue
        try:
            if isinstance(value, bytes) and p.kind not in OVER:  # which would be numbers of 0 to 255
                raise ValueError
            object.__setattr__(method, p.name, KINDS[p.kind].normal(p, value))
        except (TypeError, ValueError, OverflowError):
            pair = p.kind == "extent" and isinstance(value, tuple)
            shown = said("x".join(map(str, reversed(value))) if pair else value)
            raise ParameterError(f"{p.name}={shown} is not allowed; give {p.allowed()}.") from None


def parse(p: Parameter, text: str) -> Any:
    """Parse a value from the command line (extents as WIDTHxHEIGHT, lists with commas)."""
    try:
        return text if text in p.choices else KINDS[p.kind].read(text)
    except ValueError:
        raise ParameterError(f"{p.name}={text} is not allowed; give {p.allowed()}.") from None


def extent(value: int | Pair) -> Pair:
    """Return an extent as (rows, columns)."""
    return value if isinstance(value, tuple) else (value, value)


def words(value: Extent) -> str:
    """Format an extent as on the command line: one number, or WIDTHxHEIGHT."""
    rows, columns = extent(value or 0)
    return f"{rows}" if rows == columns else f"{columns}x{rows}"


def written(value: Any) -> str:
    """Format a value for people: lists with commas, vectors separated by spaces."""
    if isinstance(value, (list, tuple)):
        if value and isinstance(value[0], (list, tuple)):
            return " ".join(",".join(f"{n:.6g}" for n in v) for v in value)
        return ",".join(map(str, value))
    return str(value)


def _whole(p: Parameter, value: Any) -> int:
    return int(_number(p, whole(value)))


def _number(p: Parameter, value: Any) -> float:
    if not isinstance(value, Real) or isinstance(value, bool):
        raise ValueError
    number = float(value)
    if not math.isfinite(number):
        raise ValueError
    if (p.low is not None and number < p.low) or (p.high is not None and number > p.high):
        raise ValueError
    return number


def _numbers(p: Parameter, value: Any) -> tuple[float, ...]:
    return tuple(_number(p, v) for v in value)


def _choice(p: Parameter, value: Any) -> str:
    if value not in p.choices:
        raise ValueError
    return str(value)


def _extent(p: Parameter, value: Any) -> Extent:
    if not isinstance(value, (tuple, list)):
        return _whole(p, value)
    rows, columns = (_whole(p, v) for v in value)
    return rows if rows == columns else (rows, columns)


def _weights(p: Parameter, value: Any) -> tuple[float, ...]:
    weights = _numbers(p, value)
    if not any(weights):
        raise ValueError
    return weights


def _levels(p: Parameter, value: Any) -> Any:
    numbers = _numbers(p, value if isinstance(value, (tuple, list)) else (value,))
    if not 1 <= len(numbers) <= MOST_LEVELS:
        raise ValueError
    return _alone(numbers)


def _price(p: Parameter, value: Any) -> float | str:
    return "inf" if value in ("inf", math.inf) else _number(p, value)


def _pins(p: Parameter, value: Any) -> tuple[tuple[int, ...], ...]:
    pins = tuple(tuple(_whole(p, v) for v in pin) for pin in value)
    if any(len(pin) != 5 or pin[4] < 1 for pin in pins):
        raise ValueError
    return pins


def _vectors(p: Parameter, value: Any) -> tuple[tuple[float, ...], ...]:
    vectors = tuple(_numbers(p, vector) for vector in value)
    if len(vectors) not in (1, 2) or any(len(v) != 2 or not any(v) for v in vectors):
        raise ValueError
    return vectors


def _isometries(p: Parameter, value: Any) -> Poses:
    if isinstance(value, str):
        if value not in NAMED_POSES:
            raise ValueError
        return value
    ids = tuple(sorted({whole(v) for v in value}))
    if not ids or ids[0] < 0 or ids[-1] > 7:
        raise ValueError
    return ids


def _field(p: Parameter, value: Any) -> Any:
    """Return a choice, a number if the field is constant, or the field."""
    if isinstance(value, str):
        return _choice(p, value)
    if not isinstance(value, (int, float)):
        try:
            numbers = (value if isinstance(value, field.Field) else field.Field(value)).within(p.low, p.high)
        except InputError as e:
            raise InputError(f"{p.name}: {e}") from e.__cause__
        if numbers.number is None:
            return numbers
        value = numbers.number
    if p.kind == "picture":
        raise ValueError
    return _number(p, value)


def _alone(numbers: tuple[Any, ...]) -> Any:
    return numbers[0] if len(numbers) == 1 else numbers


def _floats(text: str) -> tuple[float, ...]:
    return tuple(map(float, text.split(",")))


def _pin(word: str) -> tuple[int, ...]:
    found = re.fullmatch(r"\s*(-?\d+)\s*,\s*(-?\d+)\s*->\s*(-?\d+)\s*,\s*(-?\d+)\s+(\d+)\s*", word)
    if found is None:
        raise ValueError
    return tuple(map(int, found.groups()))


class Kind(NamedTuple):
    """A kind of parameter: its metavar in help, and functions that parse, normalise (or refuse) and format a value.

    ``allowed`` describes the allowed values, with the range and the unit of the parameter.
    """

    shown: str
    read: Callable[[str], Any]
    normal: Callable[[Parameter, Any], Any]
    allowed: str = "{span}"
    text: Callable[[Any], str] = written


KINDS = {
    "int": Kind("N", int, _whole),
    "float": Kind("F", float, _number),
    "choice": Kind("", str, _choice, "one of {choices}"),
    "extent": Kind(
        "PX|WxH", lambda text: _alone(tuple(map(int, text.lower().split("x")))[::-1]), _extent,
        "{span}, one number or WIDTHxHEIGHT", words,
    ),
    "weights": Kind("W,W,...", _floats, _weights, "{span}, one for each channel"),
    "levels": Kind(
        "F|F,F,...", lambda text: _alone(_floats(text)), _levels,
        "{span}, one number or one for each level, the finest first, such as 0,0,0.2",
    ),
    "price": Kind("F|inf", lambda text: text if text == "inf" else float(text), _price, "{span}, or inf"),
    "pins": Kind(
        "'X,Y -> X,Y R'", lambda text: tuple(map(_pin, text.split(";"))), _pins,
        "exemplar x,y -> output x,y and a radius, such as '40,30 -> 200,120 24', several after semicolons",
        lambda pins: "; ".join("{},{} -> {},{} {}".format(*pin) for pin in pins),
    ),
    "vectors": Kind(
        "'X,Y X,Y'", lambda text: tuple(map(_floats, text.split())), _vectors,
        "one or two vectors x,y in px, such as 20.4,0 10.2,9.6",
        lambda vectors: " ".join(",".join(repr(float(n)) for n in v) for v in vectors),
    ),
    "isometries": Kind(
        "none|180|90|both|auto|IDS",
        lambda text: text if text in NAMED_POSES else tuple(map(int, text.split(","))), _isometries,
        "none, 180, 90, both, auto, or isometry numbers 0 to 7 such as 0,1,6",
    ),
    "field": Kind("F|FILE", float, _field, "{span}, or a gray picture over the {over}"),
    "picture": Kind("FILE", float, _field, "a gray picture over the {over}"),
}  # fmt: skip
"""The kinds of parameters by name."""


def check_sizes(method: Any, exemplar: Pair, canvas: Pair | None) -> None:
    """Raise InputError for pictures among the parameters whose size is not that of the exemplar or the canvas.

    ``exemplar`` and ``canvas`` are (height, width); an endless canvas (None) takes pictures of any size, which begin
    at pixel (0, 0).
    """
    for p in parameters(method):
        value = getattr(method, p.name)
        size = value.size if p.kind in OVER and isinstance(value, field.Field) else None
        wanted = exemplar if p.over == "exemplar" else canvas
        if size is not None and wanted is not None and size != wanted:
            raise InputError(
                f"the picture {p.name} is {size[1]}x{size[0]} px, the {p.over} {wanted[1]}x{wanted[0]}; "
                "make them equal."
            )
