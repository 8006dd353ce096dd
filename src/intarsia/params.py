"""A parameter is written once: range, unit and help beside the field; everything else reads it from there.

Validation, command line, ``methods --json`` and the docs all use :func:`parameters` and :func:`check`.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

from .arguments import whole
from .errors import InputError, ParameterError, said
from .field import Field
from .geometry import ISOMETRY_SETS

OVER = ("field", "picture")  # kinds that lie over the output or the exemplar
MOST_LEVELS = 20
AUTO = None  # a field left at AUTO is decided from the exemplar

Extent = int | tuple[int, int] | None  # one side, or rows and columns, px
Weights = tuple[float, ...] | None  # how much each channel counts
Poses = str | tuple[int, ...]  # isometries, by the name of a set of them or by their numbers
Steps = tuple[tuple[float, float], ...]  # by which a texture repeats: one vector or two, (x, y) px


@dataclass(frozen=True)
class Parameter:
    """What is known of one parameter of a method."""

    name: str
    kind: str
    default: Any
    low: float | None
    high: float | None
    unit: str
    choices: tuple[str, ...]
    help: str
    over: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Return the entry that ``methods --json`` prints; ``over`` only for fields."""
        entry = {key: list(value) if isinstance(value, tuple) else value for key, value in vars(self).items()}
        return entry if self.over else {key: value for key, value in entry.items() if key != "over"}

    def allowed(self) -> str:
        """Say in words what may be given."""
        if self.choices and self.kind not in OVER:
            return "one of " + ", ".join(self.choices)
        span = "any number"
        if self.low is not None and self.high is not None:
            span = f"{self.low:g} to {self.high:g}"
        elif self.low is not None:
            span = f"at least {self.low:g}"
        unit = f" {self.unit}" if self.unit else ""
        return {
            "extent": f"{span}{unit}, one number or WIDTHxHEIGHT",
            "weights": f"{span}, one for each channel",
            "levels": f"{span}, one number or one for each level, the finest first, such as 0,0,0.2",
            "price": f"{span}, or inf",
            "pins": "exemplar x,y -> output x,y and a radius, such as '40,30 -> 200,120 24', several after semicolons",
            "vectors": "one or two vectors x,y in px, such as 20.4,0 10.2,9.6",
            "field": ", ".join([*self.choices, span]) + f"{unit}, or a gray picture over the {self.over}",
            "picture": "".join(f"{c}, or " for c in self.choices) + f"a gray picture over the {self.over}",
            "isometries": "none, 180, 90, both, auto, or isometry numbers 0 to 7 such as 0,1,6",
        }.get(self.kind, span + unit)


def param(
    default: Any,
    kind: str,
    help: str,
    *,
    low: float | None = None,
    high: float | None = None,
    unit: str = "",
    choices: Sequence[str] = (),
    over: str = "",
) -> Any:
    """Declare a field of a method: its default, its kind, and all that can be said about it.

    Kinds: ``int``, ``float``, ``choice``, ``extent`` (one number, or a pair (rows, columns)), ``weights``
    (a tuple of numbers), ``levels`` (one number, or a tuple of them), ``price`` (a number or "inf"), ``pins``
    (tuples of five whole numbers), ``vectors`` (one or two pairs (x, y)), ``isometries`` (a name, or ids; ``auto`` is
    decided from the exemplar when a method settles), ``field`` (a number for every pixel ``over`` the "output" or the
    "exemplar": a number, a gray picture, a function, a Field, or one of the choices), ``picture`` (the same, but no
    plain number).
    """
    data = {"kind": kind, "low": low, "high": high, "unit": unit, "choices": tuple(choices), "help": help, "over": over}
    return dataclasses.field(default=default, metadata={"param": data})


def parameters(method: Any) -> list[Parameter]:
    """List the parameters of a method (an instance or its class) in the order of its fields."""
    return [
        Parameter(name=f.name, default=f.default, **f.metadata["param"])
        for f in dataclasses.fields(method)
        if "param" in f.metadata
    ]


def functions_of(method: Any) -> dict[str, Any]:
    """The functions among the parameters of a method, by name."""
    values = {p.name: getattr(method, p.name) for p in parameters(method)}
    return {name: value for name, value in values.items() if isinstance(value, Field) and value.is_function}


def check(method: Any) -> None:
    """Refuse, in one line, every parameter that is out of its range; put the given values into normal form."""
    for p in parameters(method):
        value = getattr(method, p.name)
        if value is AUTO and p.default is AUTO:
            continue
        if p.kind in OVER and not isinstance(value, (int, float, str)):
            value = _field(p, value)
        try:
            object.__setattr__(method, p.name, _normal(p, value))
        except (TypeError, ValueError, OverflowError):
            pair = p.kind == "extent" and isinstance(value, tuple)
            shown = said("x".join(map(str, reversed(value))) if pair else value)
            raise ParameterError(f"{p.name}={shown} is not allowed; give {p.allowed()}.") from None


def parse(p: Parameter, text: str) -> Any:
    """Read a value as it is written on the command line (extents as WIDTHxHEIGHT, lists with commas)."""
    try:
        if p.kind == "int":
            return int(text)
        if p.kind == "float" or (p.kind in OVER and text not in p.choices):
            return float(text)
        if p.kind == "price":
            return text if text == "inf" else float(text)
        if p.kind == "pins":
            return tuple(tuple(int(part) for part in _pin_numbers(word)) for word in text.split(";"))
        if p.kind == "levels":
            numbers = tuple(float(part) for part in text.split(","))
            return numbers[0] if len(numbers) == 1 else numbers
        if p.kind == "extent":
            sides = [int(part) for part in text.lower().split("x")]
            return sides[0] if len(sides) == 1 else tuple(reversed(sides))
        if p.kind == "weights":
            return tuple(float(part) for part in text.split(","))
        if p.kind == "vectors":
            return tuple(tuple(float(part) for part in word.split(",")) for word in text.split())
        if p.kind == "isometries" and text not in ISOMETRY_SETS and text != "auto":
            return tuple(int(part) for part in text.split(","))
        return text
    except ValueError:
        raise ParameterError(f"{p.name}={text} is not allowed; give {p.allowed()}.") from None


def extent(value: int | tuple[int, int]) -> tuple[int, int]:
    """Return an extent as (rows, columns)."""
    return value if isinstance(value, tuple) else (value, value)


def words(value: int | tuple[int, int] | None) -> str:
    """Write an extent as the command line does: one number, or WIDTHxHEIGHT."""
    rows, columns = extent(value or 0)
    return f"{rows}" if rows == columns else f"{columns}x{rows}"


def _field(p: Parameter, value: Any) -> Any:
    """A number, where the field is one everywhere; else the field."""
    try:
        field = value if isinstance(value, Field) else Field(value)
        field = field.within(p.low, p.high)
    except InputError as e:
        raise InputError(f"{p.name}: {e}") from e.__cause__
    return field if field.number is None else field.number


def _normal(p: Parameter, value: Any) -> Any:
    if isinstance(value, bytes):  # which would be numbers of 0 to 255
        raise ValueError
    if p.kind == "choice" or (p.kind in OVER and isinstance(value, str)):
        if value not in p.choices:
            raise ValueError
        return str(value)
    if p.kind in OVER and not isinstance(value, (int, float)):
        return value
    if p.kind == "picture":
        raise ValueError
    if p.kind == "isometries":
        return _isometries(value)
    if p.kind == "vectors":
        return _vectors(p, value)
    if p.kind == "extent":
        if isinstance(value, (tuple, list)):
            rows, columns = (_whole(p, v) for v in value)
            return rows if rows == columns else (rows, columns)
        return _whole(p, value)
    if p.kind == "price" and value in ("inf", math.inf):
        return "inf"
    if p.kind == "pins":
        return _pins(p, value)
    if p.kind == "levels" and isinstance(value, (tuple, list)):
        return _levels(p, value)
    if p.kind == "weights":
        weights = tuple(_number(p, v) for v in value)
        if not weights or not any(weights):
            raise ValueError
        return weights
    return _whole(p, value) if p.kind == "int" else _number(p, value)


def _isometries(value: Any) -> str | tuple[int, ...]:
    if isinstance(value, str):
        if value not in ISOMETRY_SETS and value != "auto":
            raise ValueError
        return value
    ids = tuple(sorted({whole(v) for v in value}))
    if not ids or ids[0] < 0 or ids[-1] > 7:
        raise ValueError
    return ids


def _vectors(p: Parameter, value: Any) -> tuple[tuple[float, ...], ...]:
    vectors = tuple(tuple(_number(p, v) for v in vector) for vector in value)
    if len(vectors) not in (1, 2) or any(len(v) != 2 or not any(v) for v in vectors):
        raise ValueError
    return vectors


def _pin_numbers(word: str) -> list[str]:
    found = re.fullmatch(r"\s*(-?\d+)\s*,\s*(-?\d+)\s*->\s*(-?\d+)\s*,\s*(-?\d+)\s+(\d+)\s*", word)
    if found is None:
        raise ValueError
    return list(found.groups())


def _pins(p: Parameter, value: Any) -> tuple[tuple[int, ...], ...]:
    pins = tuple(tuple(_whole(p, v) for v in pin) for pin in value)
    if any(len(pin) != 5 or pin[4] < 1 for pin in pins):
        raise ValueError
    return pins


def _levels(p: Parameter, value: Any) -> float | tuple[float, ...]:
    numbers = tuple(_number(p, v) for v in value)
    if not 1 <= len(numbers) <= MOST_LEVELS:
        raise ValueError
    return numbers[0] if len(numbers) == 1 else numbers


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


def check_sizes(method: Any, exemplar: tuple[int, int], canvas: tuple[int, int] | None) -> None:
    """Refuse pictures of a method's parameters that do not lie on what they are for.

    ``exemplar`` and ``canvas`` are (height, width); a canvas without end (None) takes pictures of any size, which
    begin at pixel (0, 0).
    """
    for p in parameters(method):
        value = getattr(method, p.name)
        size = value.size if isinstance(value, Field) else None
        wanted = exemplar if p.over == "exemplar" else canvas
        if size is not None and wanted is not None and size != wanted:
            raise InputError(
                f"the picture {p.name} is {size[1]}x{size[0]} px, the {p.over} {wanted[1]}x{wanted[0]}; "
                "make them equal."
            )
