"""What may be written behind an option: sizes, boxes, colours, seeds; x before y. Imports nothing heavy."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import click

from ..arguments import MAX_PIXELS, PLANE_WEIGHTS, channels_of
from ..draws import SEED_LIMIT
from ..errors import InputError

if TYPE_CHECKING:
    ParamType = click.ParamType[Any]
else:  # older versions of click do not take the bracket
    ParamType = click.ParamType

MAX_SEEDS = 10_000


class FileName(click.Path):
    """The name of a file, or - ; whoever opens it says what is wrong with it."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        if "\0" in str(value):
            raise InputError(f"{str(value)!r} is no name of a file; choose another.")
        return str(value)


class Size(ParamType):
    """WIDTHxHEIGHT, or one number for a square; gives (width, height)."""

    name = "WIDTHxHEIGHT"

    def __init__(self, most: int = MAX_PIXELS) -> None:
        self.most = most

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        parts = str(value).lower().split("x")
        if not 1 <= len(parts) <= 2 or not all(re.fullmatch(r"[0-9]{1,12}", p) for p in parts):
            self.fail(f"{value} is no size; give WIDTHxHEIGHT in px such as 1024x768, or one number.", param, ctx)
        width, height = int(parts[0]), int(parts[-1])
        if min(width, height) < 1 or width * height > self.most:
            power = self.most.bit_length() - 1
            self.fail(f"{value} is not allowed; give sides of at least 1 px, at most 2**{power} px in all.", param, ctx)
        return width, height


class Rectangle(ParamType):
    """X,Y,WIDTH,HEIGHT in px; gives the four numbers."""

    name = "X,Y,WIDTH,HEIGHT"

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        parts = str(value).split(",")
        if len(parts) != 4 or not all(re.fullmatch(r"-?[0-9]{1,12}", p) for p in parts):
            self.fail(f"{value} is no rectangle; give X,Y,WIDTH,HEIGHT in px such as 0,0,256,256.", param, ctx)
        x, y, width, height = (int(p) for p in parts)
        if min(width, height) < 1:
            self.fail(f"{value} is empty; give a width and a height of at least 1 px.", param, ctx)
        return x, y, width, height


class Scale(ParamType):
    """1/2, 1/3, 0.25, ...; gives the whole number n of 1/n."""

    name = "1/N"

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        if isinstance(value, int):
            return value
        try:
            times = 1 / Fraction(str(value))
        except (ValueError, ZeroDivisionError):
            times = Fraction(0)
        if times.denominator != 1 or not 1 <= times <= 1024:
            self.fail(f"{value} is not allowed; give 1/2, 1/3, ... (blocks of pixels are averaged).", param, ctx)
        return int(times)


class Number(click.FloatRange):
    """A number in a range, which NaN is not."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        found = super().convert(value, param, ctx)
        if found != found:
            self.fail(f"{value} is no number; give {self.min:g} to {self.max:g}.", param, ctx)
        return found


class Place(ParamType):
    """A pixel as X,Y, of an endless plane a negative or huge one, too; gives (x, y)."""

    name = "X,Y"
    one, such_as = "[0-9]{1,10}", "the pixel's column and row such as 120,80"

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        if isinstance(value, tuple):
            return value
        if not re.fullmatch(f"{self.one},{self.one}", str(value)):
            self.fail(f"{value} is no place; give {self.such_as}.", param, ctx)
        x, y = str(value).split(",")
        return int(x), int(y)


class Position(Place):
    """A pixel of an endless plane."""

    one, such_as = "-?[0-9]{1,13}", "column and row such as -4096,1000000"


class Colour(ParamType):
    """#rrggbb; gives (red, green, blue)."""

    name = "#RRGGBB"

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        if not re.fullmatch(r"#[0-9a-fA-F]{6}", str(value)):
            self.fail(f"{value} is no colour; give #rrggbb such as #ff00ff (quote it for the shell).", param, ctx)
        return tuple(bytes.fromhex(value[1:]))


class Seed(ParamType):
    """A whole number, or `random`, which draws one."""

    name = "N|random"

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        if value == "random":
            import secrets

            return secrets.randbits(32)
        if not re.fullmatch(r"[0-9]{1,20}", str(value)) or int(value) >= SEED_LIMIT:
            self.fail(f"{value} is no seed; give a whole number from 0 to 2**64 - 1, or random.", param, ctx)
        return int(value)


class EnlargedSize(ParamType):
    """A whole number of px, or `auto`, which is -1: None would be no value at all."""

    name = "N|auto"

    def __init__(self, most: int) -> None:
        self.most = most

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        if value in ("auto", -1):
            return -1
        try:
            px = int(value)
        except ValueError:
            px = -1
        if not 0 <= px <= self.most:
            self.fail(f"{value} is not allowed; give 0 to {self.most} px, or auto.", param, ctx)
        return px


class Seeds(ParamType):
    """Ranges and numbers, as 1..9 or 1,4,7; gives a tuple of seeds."""

    name = "A..B|A,B,C"

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        seeds: list[int] = []
        for part in str(value).split(","):
            ends = part.split("..")
            if not 1 <= len(ends) <= 2 or not all(re.fullmatch(r"[0-9]{1,20}", e) for e in ends):
                self.fail(f"{value} is no list of seeds; give 1..9, or 1,4,7.", param, ctx)
            first, last = int(ends[0]), int(ends[-1])
            if last < first or last >= SEED_LIMIT or last - first + len(seeds) >= MAX_SEEDS:
                self.fail(f"{value}: give rising ranges, at most {MAX_SEEDS} seeds below 2**64.", param, ctx)
            seeds.extend(range(first, last + 1))
        return tuple(dict.fromkeys(seeds))


class NamedFile(ParamType):
    """NAME=FILE; gives the pair."""

    name = "NAME=FILE"

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        name, equals, path = str(value).partition("=")
        if not equals or not path or not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,63}", name):
            self.fail(f"{value} is not NAME=FILE; give a plane and its file, such as normal=brick_n.png.", param, ctx)
        return name, path


class Channels(ParamType):
    """R=NAME,G=NAME,...; gives the text."""

    name = "C=NAME,..."

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        channels_of(value)
        return str(value).replace(" ", "")


class NamedNumber(ParamType):
    """NAME=NUMBER, from 0 to `most`; gives the pair. `remedy` says what is to be given instead of anything else."""

    def __init__(self, name: str, most: float, remedy: str) -> None:
        self.name, self.most, self.remedy = name, most, remedy

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        if isinstance(value, tuple):
            return value
        name, _, text = str(value).partition("=")
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not name or not 0 <= number <= self.most:
            self.fail(f"{value} is not {self.name}; give {self.remedy}.", param, ctx)
        return name, number


PLANE_WEIGHT = NamedNumber("NAME=F", PLANE_WEIGHTS, f"a plane and 0 to {PLANE_WEIGHTS}, such as height=0.5")
GATE = NamedNumber("PART=VALUE", 100, "a part and its least worth, such as joins=0.5")
