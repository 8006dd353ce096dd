"""Fields of a request, declared once for command line, help, page and recipe, and the kinds of their values.

A kind parses a value from text, and writes it as text and as JSON; x before y.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

from ..foundation import InputError, channels_of
from ..foundation.run import SEED_LIMIT

MAX_SEEDS = 10_000
LONGEST_NAME = 100  # characters of the name by which a file is called


class Kind:
    """Any text. `name` identifies the kind for pages, `shown` is the placeholder in help.

    `between` stands between the numbers of a list. What is said otherwise of one holds for it alone.
    """

    name, shown, between = "text", "", ","
    choices: tuple[str, ...] = ()

    def __init__(self, **own: Any) -> None:
        vars(self).update(own)

    def read(self, text: str) -> Any:
        """Parse a value; ValueError with what is wrong and what to give."""
        if self.choices and text not in self.choices:
            raise ValueError(f"{text!r} is not one of {', '.join(map(repr, self.choices))}.")
        return text

    def text(self, value: Any) -> str:
        """Return a value as text, as it is parsed."""
        return self.between.join(map(str, value)) if isinstance(value, tuple) else str(value)

    def json(self, value: Any) -> Any:
        """Return a value for a recipe: a number, a truth value, or text."""
        return value if isinstance(value, (bool, int, float)) else self.text(value)

    def of_json(self, value: Any) -> Any:
        """Parse a value of a recipe; ValueError or TypeError if it is damaged."""
        if self.name in ("int", "seed") and type(value) is not int:
            raise TypeError
        return self.read(self.between.join(map(str, value)) if isinstance(value, list) else str(value))


class File(Kind):
    """The name of a file, or - ; it is checked when it is opened.

    ``name`` says what a file is: an "exemplar" or an "image" of numbers that is read, or another that is "written".
    """

    name, shown = "written", "FILE"

    def read(self, text: str) -> Any:
        if "\0" in text:
            raise InputError(f"{text!r} is no name of a file; choose another.")
        return text


FLAG = Kind(name="flag", of_json=bool)
"""Yes or no."""



def one_of(*choices: str) -> Kind:
    """Return the kind of values that are one of some words."""
    return Kind(name="choice", choices=choices)


class Whole(Kind):
    """A whole number of a range; one of `choices`, if any, stands for None, which is decided later."""

    name, shown, low = "int", "N", 0
    high: int | None = None

    def read(self, text: str) -> Any:
        if text in self.choices:
            return None
        try:
            number = int(text)
        except ValueError:
            number = None
        if self.choices and (number is None or not self.low <= number <= (self.high or number)):
            raise ValueError(f"{text} is not allowed; give {self.low} to {self.high} px, or {self.choices[0]}.")
        if number is None:
            raise ValueError(f"{text!r} is not a valid integer range.")
        return _within(self, number)

    def text(self, value: Any) -> str:
        return self.choices[0] if value is None and self.choices else str(value)


class Number(Kind):
    """A number in a range; NaN is refused."""

    name, shown, low, high = "float", "F", 0, 0

    def read(self, text: str) -> Any:
        try:
            number = float(text)
        except ValueError:
            raise ValueError(f"{text!r} is not a valid float range.") from None
        if number != number:
            raise ValueError(f"{text} is no number; give {self.low:g} to {self.high:g}.")
        return _within(self, number)


def _within(kind: Whole | Number, number: float) -> float:
    """Return a number if it is in the range of a kind; else ValueError with the words of the command line."""
    if number < kind.low or (kind.high is not None and number > kind.high):
        span = f"x>={kind.low}" if kind.high is None else f"{kind.low}<=x<={kind.high}"
        raise ValueError(f"{number} is not in the range {span}.")
    return number


class Size(Kind):
    """WIDTHxHEIGHT, or one number for a square; gives (width, height)."""

    name, shown, between, most = "size", "WIDTHxHEIGHT", "x", 1 << 31

    def read(self, text: str) -> Any:
        parts = text.lower().split("x")
        if not 1 <= len(parts) <= 2 or not all(re.fullmatch(r"[0-9]{1,12}", p) for p in parts):
            raise ValueError(f"{text} is no size; give WIDTHxHEIGHT in px such as 1024x768, or one number.")
        width, height = int(parts[0]), int(parts[-1])
        if min(width, height) < 1 or width * height > self.most:
            power = self.most.bit_length() - 1
            raise ValueError(f"{text} is not allowed; give sides of at least 1 px, at most 2**{power} px in all.")
        return width, height


class Rectangle(Kind):
    """X,Y,WIDTH,HEIGHT in px; gives the four numbers."""

    name, shown = "rectangle", "X,Y,WIDTH,HEIGHT"

    def read(self, text: str) -> Any:
        parts = text.split(",")
        if len(parts) != 4 or not all(re.fullmatch(r"-?[0-9]{1,12}", p) for p in parts):
            raise ValueError(f"{text} is no rectangle; give X,Y,WIDTH,HEIGHT in px such as 0,0,256,256.")
        x, y, width, height = (int(p) for p in parts)
        if min(width, height) < 1:
            raise ValueError(f"{text} is empty; give a width and a height of at least 1 px.")
        return x, y, width, height

    def json(self, value: Any) -> Any:
        return list(value)


class Scale(Kind):
    """1/2, 1/3, 0.25, ...; gives the whole number n of 1/n."""

    name, shown = "scale", "1/N"

    def read(self, text: str) -> Any:
        try:
            times = 1 / Fraction(text)
        except (ValueError, ZeroDivisionError):
            times = Fraction(0)
        if times.denominator != 1 or not 1 <= times <= 1024:
            raise ValueError(f"{text} is not allowed; give 1/2, 1/3, ... (blocks of pixels are averaged).")
        return int(times)

    def text(self, value: Any) -> str:
        return f"1/{value}"

    def json(self, value: Any) -> Any:
        return self.text(value)


class Place(Kind):
    """A pixel of an endless plane as X,Y, a negative or huge one, too; gives (x, y)."""

    shown = "X,Y"

    def read(self, text: str) -> Any:
        if not re.fullmatch("-?[0-9]{1,13},-?[0-9]{1,13}", text):
            raise ValueError(f"{text} is no place; give column and row such as -4096,1000000.")
        x, y = text.split(",")
        return int(x), int(y)


class Colour(Kind):
    """#rrggbb; gives (red, green, blue)."""

    name, shown = "colour", "#RRGGBB"

    def read(self, text: str) -> Any:
        if not re.fullmatch(r"#[0-9a-fA-F]{6}", text):
            raise ValueError(f"{text} is no colour; give #rrggbb such as #ff00ff (quote it for the shell).")
        return tuple(bytes.fromhex(text[1:]))

    def text(self, value: Any) -> str:
        return "#" + bytes(value).hex()


class Seed(Kind):
    """A whole number, or `random`, which draws one."""

    name, shown = "seed", "N|random"

    def read(self, text: str) -> Any:
        if text == "random":
            import secrets

            return secrets.randbits(32)
        if not re.fullmatch(r"[0-9]{1,20}", text) or int(text) >= SEED_LIMIT:
            raise ValueError(f"{text} is no seed; give a whole number from 0 to 2**64 - 1, or random.")
        return int(text)


class Seeds(Kind):
    """Ranges and numbers, as 1..9 or 1,4,7; gives a tuple of seeds."""

    shown = "1..9|1,4,7"

    def read(self, text: str) -> Any:
        seeds: list[int] = []
        for part in text.split(","):
            ends = part.split("..")
            if not 1 <= len(ends) <= 2 or not all(re.fullmatch(r"[0-9]{1,20}", e) for e in ends):
                raise ValueError(f"{text} is no list of seeds; give 1..9, or 1,4,7.")
            first, last = int(ends[0]), int(ends[-1])
            if last < first or last >= SEED_LIMIT or last - first + len(seeds) >= MAX_SEEDS:
                raise ValueError(f"{text}: give rising ranges, at most {MAX_SEEDS} seeds below 2**64.")
            seeds.extend(range(first, last + 1))
        return tuple(dict.fromkeys(seeds))


class NamedFile(Kind):
    """NAME=FILE; gives the pair."""

    name, shown, between = "written", "NAME=FILE", "="

    def read(self, text: str) -> Any:
        name, equals, path = text.partition("=")
        if not equals or not path or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,63}", name):
            raise ValueError(f"{text} is not NAME=FILE; give a plane and its file, such as normal=brick_n.png.")
        return name, path


class Called(Kind):
    """FILE=NAME; gives the pair. The name is what a person reads."""

    name, shown, between = "call", "FILE=NAME", "="

    def read(self, text: str) -> Any:
        path, _, name = text.partition("=")
        if not path or not name.strip() or not name.isprintable() or len(name) > LONGEST_NAME:
            raise ValueError(f"{text} is not FILE=NAME; give a file and up to {LONGEST_NAME} characters to call it by.")
        return path, name.strip()


class Channels(Kind):
    """R=NAME,G=NAME,...; gives the text."""

    shown = "C=NAME,..."

    def read(self, text: str) -> Any:
        channels_of(text)
        return text.replace(" ", "")


class NamedNumber(Kind):
    """NAME=NUMBER, from 0 to `most`; gives the pair. `remedy`: what error messages suggest."""

    name, shown, between, most, remedy = "named", "NAME=F", "=", 1, ""

    def read(self, text: str) -> Any:
        name, _, number = text.partition("=")
        try:
            value = float(number)
        except ValueError:
            value = math.nan
        if not name or not 0 <= value <= self.most:
            raise ValueError(f"{text} is not {self.shown}; give {self.remedy}.")
        return name, value


@dataclass(frozen=True)
class Field:
    """A field of the request: an option of some verbs, a key of a job, and a place in a recipe, if recipes hold it.

    Without ``flags`` it is an argument. ``heading``: where help lists it, only in full help if ``rare``; ``shown``: the
    placeholder in help; ``of_exemplars``: sets which part of the exemplars is used, and how; ``local``: set by the
    studio itself, or not needed there; ``without_effect``: on the picture. ``alone`` is the value of an option
    given without one. ``otherwise``: what differs for some verbs; a text alone is another help.
    """

    name: str
    kind: Kind
    flags: tuple[str, ...]
    help: str
    heading: str
    verbs: Collection[str]
    default: Any = None
    shown: str = ""
    many: bool = False
    required: bool = False
    rare: bool = False
    recipe: str = ""
    of_exemplars: bool = False
    local: bool = False
    without_effect: bool = False
    alone: str | None = None
    tells_default: bool = False
    otherwise: Mapping[str, str | Mapping[str, Any]] = field(default_factory=dict)

    @property
    def flag(self) -> str:
        """The longest name of the option."""
        return max(self.flags, key=len)

    @property
    def key(self) -> str:
        """The name of the field in a job."""
        return self.flag.lstrip("-").replace("-", "_")

    def of_json(self, value: Any) -> Any:
        """Parse the field as a recipe holds it; raises an exception if it is damaged."""
        if self.many:
            return tuple(self.kind.read(f"{name}={one}") for name, one in value.items())
        return self.kind.of_json(value)

    def of(self, verb: str) -> Field:
        """Return the field with what is special to a verb."""
        own = self.otherwise.get(verb, {})
        return replace(self, **({"help": own} if isinstance(own, str) else own))


def option(
    kind: Kind, flags: str, help: str, verbs: str | Collection[str], marks: str = "", default: Any = None, **facts: Any
) -> Any:  # fmt: skip
    """Declare a field of the request; `flags` are the names of its option, `facts` attributes of :class:`Field`.

    `marks` are the names of attributes that are true. A heading holds for the fields below, too, until the next.
    """
    facts |= dict.fromkeys(marks.split(), True)
    if default is None:
        default = () if "many" in facts else False if kind is FLAG else None
    verbs = verbs.split() if isinstance(verbs, str) else verbs
    facts |= {"kind": kind, "flags": tuple(flags.split()), "help": help, "verbs": verbs, "default": default}
    return dataclasses.field(default=default, metadata={"asked": facts})


def fields_of(request: Any) -> tuple[Field, ...]:
    """Return the fields of a request class, in their order."""
    found, heading = list[Field](), ""
    for f in dataclasses.fields(request):
        if "asked" in f.metadata:
            facts = {"heading": heading, **f.metadata["asked"]}
            heading = facts["heading"]
            if "of_exemplars" in facts:
                facts["recipe"] = f"inputs.{f.name}"
            found.append(Field(f.name, **facts))
    return tuple(found)
