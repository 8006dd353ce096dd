"""Foundation of all packages: errors, limits, checks of arguments, parameters, geometry, threads and random numbers.

Errors that intarsia raises, with the exit code of the command line:

    IntarsiaError            1  the work failed
    |- ParameterError        2  a parameter or an option is out of its range, or does not fit the others
    |- InputError            3  a file or an array is missing, broken, of the wrong size or kind
    |- QualityError          4  a quality gate that was asked for is missed
    |- MissingExtraError     5  an optional package is not installed
    |- MethodError           1  the method cannot serve this exemplar
    |- ResourceError         1  disk full, memory, a folder that cannot be written
    `- CancelledError      130  the caller asked to stop

A message is one line: what was given, what is allowed, what to do.

Modules may be imported at first use, so that listings, help and usage errors stay quick. The command line reads the
parameters of every method; the files of the methods therefore import nothing heavy at the top. They write::

    if TYPE_CHECKING:
        import numpy as np
    else:
        np = lazy("numpy")
"""

from __future__ import annotations

import importlib
import operator
import os
import re
import unicodedata
from enum import Enum
from numbers import Real
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from scipy import ndimage as ndimage

Record = dict[str, Any]  # values by name, such as parameters, and what JSON holds

Pair = tuple[int, int]  # rows and columns, or the row and the column of a pixel

LONGEST = 100  # most letters of a given value that a message quotes
MOST_MARKS = 4
"""Most combining marks on one letter; more of them would cover the lines above."""


def legible(text: str) -> str:
    """Return a text as one line that is safe to print on a terminal; characters that cannot be printed become "?".

    Texts from files (names, recipes, maps, headers) may hold escape sequences, and marks that reverse or cover text.
    """
    if text.isascii() and text.isprintable():
        return text
    out, marks = [], 0
    for c in text:
        marks = marks + 1 if unicodedata.category(c) in ("Mn", "Me") else 0
        fine = c.isprintable() and marks <= MOST_MARKS
        out.append(c if fine else " " if c.isspace() else "?")
    return "".join(out)


def said(given: object) -> str:
    """Return a value as one line of a message, at most LONGEST letters; an exception with the name of its class."""
    try:
        text = f"{type(given).__name__}: {given}" if isinstance(given, Exception) else str(given)
    except Exception:
        text = type(given).__name__
    text = " ".join(legible(" ".join(text.split())).split())
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


class IntarsiaError(Exception):
    """The work failed; the message says in one line what to do, and is printable whatever it quotes."""

    exit_code = 1

    def __init__(self, *words: object) -> None:
        super().__init__(*(legible(w) if isinstance(w, str) else w for w in words))


class ParameterError(IntarsiaError):
    """A parameter is out of its range, or does not fit the others."""

    exit_code = 2


class InputError(IntarsiaError):
    """A file or an array is missing, broken, of the wrong size or kind."""

    exit_code = 3


class QualityError(IntarsiaError):
    """A quality gate that was asked for is missed."""

    exit_code = 4


class MissingExtraError(IntarsiaError):
    """An optional package is not installed."""

    exit_code = 5


class MethodError(IntarsiaError):
    """The method cannot serve this exemplar."""


class ResourceError(IntarsiaError):
    """The disk is full, memory is short, or a folder cannot be written."""


class CancelledError(IntarsiaError):
    """The caller asked to stop; nothing was written."""

    exit_code = 130


def printable(path: object) -> str:
    """Return a file name, or other foreign text, shortened and made printable for a one-line message."""
    text = os.fsdecode(path) if isinstance(path, bytes | os.PathLike) else str(path)
    text = legible(text)
    return text if len(text) <= 200 else text[:100] + "..." + text[-80:]


E = TypeVar("E", bound=Enum)

CHANNELS = "RGBA"
"""Names of the channels of a packed map."""

SCALARS = ("ao", "roughness", "metallic", "height", "opacity", "specular")
"""Maps with one number for each pixel, which may be a channel of a packed map."""

PHOTOS = ("brick", "grass", "gravel")  # photographs
PAINTED = ("tiles", "pebbles", "stones", "planks")  # procedural surfaces
MATERIALS = {"setts": ("albedo", "normal", "roughness", "height")}  # materials -> their planes
SAMPLES = tuple(sorted((*PHOTOS, *PAINTED, *MATERIALS)))
"""Built-in exemplars: photographs, procedural surfaces, and materials with their maps."""

MAX_PIXELS = 1 << 31
"""Most px of an output that is held in memory."""

FEATHER = 1024
"""Most px over which seams are feathered, and on either side of a seam over which tone is corrected."""

OVERLAYS = ("lattice", "segments")
"""Overlays that can be drawn over an exemplar."""

ALPHAS = ("auto", "channel", "mask")
"""How the opacity of an exemplar may be read."""

ENGINES = ("unreal", "unity", "godot", "blender", "gltf")
"""Engines for which materials are named and packed."""

STRENGTHS = 100
"""Largest factor of how steep proposed normals are; a limit of arithmetic."""

TIMES = 64
"""Largest magnification of the rendered picture relative to the map."""

WEIGHT, WEIGHTS = 2.0, 100
"""Weight of a guide against the seams: default and maximum."""

PLANE_WEIGHTS = 100
"""Largest weight of a plane in matching; 1 is usual."""

REACHES = 256
"""Largest distance from a label boundary, px, within which pixels may count as partly of both labels."""

MARGIN = 100
"""Px by which a picture is extended to the right if no side is given (Multrus 2003, A.1)."""

AUTO_METHOD = "auto"
"""Name that stands for choosing the method from measurements of the exemplar."""

MOST_TRIALS = 64
"""Most variants of which the automatic choice keeps the best; each is a complete synthesis."""

PASSES, MOST_PASSES = 4, 1000
"""Passes of a repair over the worst seams: default and maximum."""


def whole(value: Any) -> int:
    """Return a whole number of any numeric type, such as 24, 24.0 or np.int64(24), as an int.

    Raises ValueError for anything else: truth values, text, fractions, NaN and infinity.
    """
    if isinstance(value, bool):
        raise ValueError(value)
    real = isinstance(value, Real)
    try:
        number = int(value) if real else operator.index(value)
    except (TypeError, ValueError, OverflowError):  # the last two: NaN and infinity
        raise ValueError(value) from None
    if number != value:
        raise ValueError(value)
    return number


def whole_within(name: str, value: Any, low: int, high: int | None = None, unit: str = "px") -> int:
    """Return a whole number from `low` to `high`; ParameterError, naming the argument `name`, for anything else."""
    span = f"at least {low} {unit}" if high is None else f"{low} to {high} {unit}"
    try:
        number = whole(value)
    except ValueError:
        raise ParameterError(f"{name}={called(value)} is not allowed; give {span}, a whole number.") from None
    if number < low or (high is not None and number > high):
        raise ParameterError(f"{name}={called(number)} is not allowed; give {span}.")
    return number


def pair(value: Any) -> Pair:
    """Return (rows, columns) of a size; one whole number is a square. ValueError for anything else."""
    if isinstance(value, (tuple, list)) or getattr(value, "shape", None) == (2,):
        rows, columns = (whole(n) for n in value)
        return rows, columns
    side = whole(value)
    return side, side


def size_of(value: Any, name: str = "size") -> Pair:
    """Return (height, width) of a size argument, one number for a square; ParameterError for anything else."""
    try:
        return pair(value)
    except ValueError:
        raise ParameterError(
            f"{name}={called(value)} is not allowed; give (height, width) in whole px, or one number for a square."
        ) from None


def channels_of(text: Any) -> tuple[str, ...]:
    """Parse the contents of packed channels, as in R=ao,G=roughness,B=metallic; ``""`` for channels not named."""
    held: dict[str, str] = {}
    for part in str(text).split(","):
        match = re.fullmatch(r"\s*([RGBA])\s*=\s*([a-z]+)\s*", part)
        if match is None or match[2] not in SCALARS or match[1] in held or match[2] in held.values():
            raise ParameterError(
                f"packed={called(text)} is not allowed; give each of {', '.join(SCALARS)} at most one of R, G, B and "
                "A, as in R=ao,G=roughness,B=metallic."
            )
        held[match[1]] = match[2]
    last = max(CHANNELS.index(letter) for letter in held)
    return tuple(held.get(letter, "") for letter in CHANNELS[: last + 1])


def chosen(kind: type[E], name: str, value: Any) -> E:
    """Return the enum member of a value; ParameterError, naming the argument `name`, if there is none."""
    try:
        return kind(value)
    except (TypeError, ValueError):
        words = ", ".join(str(one.value) for one in kind)
        raise ParameterError(f"{name}={called(value)} is not allowed; choose one of {words}.") from None


def expect(
    value: Any, kinds: type[Any] | tuple[type[Any], ...], name: str, remedy: str,
    error: type[IntarsiaError] = ParameterError,
) -> None:  # fmt: skip
    """Raise `error` if an argument is no instance of `kinds`; the message says what to give."""
    if not isinstance(value, kinds):
        raise error(f"{name} is {called(value)}; give {remedy}.")


def expect_path(value: Any) -> None:
    """Raise InputError if a value is no path."""
    if not isinstance(value, str) and not hasattr(type(value), "__fspath__"):
        raise InputError(f"{called(value)} names no file; give a path.")


def called(value: Any) -> str:
    """Return a short description of a value: numbers and text as they are written, other things by their type."""
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if value is None or isinstance(value, (bool, str, bytes, Real)):
        if isinstance(value, int) and value.bit_length() > 128:  # Python refuses to write out the longest ones
            return said(f"a number of {value.bit_length()} bits")
        return said(repr(value) if isinstance(value, (str, bytes)) else value)
    if isinstance(value, (tuple, list)) and all(isinstance(n, (str, Real)) for n in value):
        return said(value)
    return f"of type {type(value).__name__}"


class lazy:
    """A proxy of the module `name`, which is imported at the first access to an attribute."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        value = getattr(importlib.import_module(self._name), attribute)
        self.__dict__[attribute] = value
        return value


if not TYPE_CHECKING:  # many modules use it, but few commands reach that code
    ndimage = lazy("scipy.ndimage")
