"""What every room stands on: what is refused, boxes, arrays, parameters, and how work runs.

Everything that intarsia refuses, and with which exit code:

    IntarsiaError            1  the work failed
    |- ParameterError        2  a parameter or an option is out of its range, or does not fit the others
    |- InputError            3  a file or an array is missing, broken, of the wrong size or kind
    |- QualityError          4  a quality gate that was asked for is missed
    |- MissingExtraError     5  an optional package is not installed
    |- MethodError           1  the method cannot serve this exemplar
    |- ResourceError         1  disk full, memory, a folder that cannot be written
    `- CancelledError      130  the caller asked to stop

A message is one line: what was given, what is allowed, what to do. Arguments as callers give them are read and checked
here, too, by the limits and usual values that help texts tell.

Modules may be imported at their first use, so that listings, help and usage errors stay quick. The command line reads
the parameters of every method; the files of the methods therefore import nothing heavy at the top. They write::

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

Pair = tuple[int, int]  # rows and columns, or the row and the column of a pixel

LONGEST = 100  # letters of something that was given, in a message
MOST_MARKS = 4
"""So many accents and the like may stand on one letter; more of them climb over the lines above."""


def legible(text: str) -> str:
    """Return a text as it may stand on a terminal, in one line: what cannot be printed becomes "?".

    Texts of files (names, recipes, maps, headers) may hold escape sequences, and marks that turn or cover what is said.
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
    """Return what was given in one line of a message, not too long; an exception with its kind."""
    try:
        text = f"{type(given).__name__}: {given}" if isinstance(given, Exception) else str(given)
    except Exception:
        text = type(given).__name__
    text = " ".join(legible(" ".join(text.split())).split())
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


class IntarsiaError(Exception):
    """The work failed; the message says in one line what to do, and is legible whatever it quotes."""

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
    """Return a file name, or another text that somebody else wrote, fit for a one-line message."""
    text = os.fsdecode(path) if isinstance(path, bytes | os.PathLike) else str(path)
    text = legible(text)
    return text if len(text) <= 200 else text[:100] + "..." + text[-80:]


E = TypeVar("E", bound=Enum)

CHANNELS = "RGBA"
"""What the channels of a packed map are called."""

SCALARS = ("ao", "roughness", "metallic", "height", "opacity", "specular")
"""Maps of one number for each pixel, which may lie in a channel of a packed map."""

PHOTOS = ("brick", "grass", "gravel")
PAINTED = ("tiles", "pebbles", "stones", "planks")
MATERIALS = {"setts": ("albedo", "normal", "roughness", "height")}
SAMPLES = tuple(sorted((*PHOTOS, *PAINTED, *MATERIALS)))
"""The built-in exemplars: photographs, surfaces painted by formula, and materials with the maps that they have."""

MAX_PIXELS = 1 << 31
"""Of an output that is held in memory."""

FEATHER = 1024
"""Px over which seams may be softened, or steps at them evened out, at most."""

OVERLAYS = ("lattice", "segments")
"""What can be drawn over an exemplar."""

ALPHAS = ("auto", "channel", "mask")
"""What the opacity of an exemplar may count as."""

TIMES = 64
"""How many times larger than they are grown pictures are drawn at most."""

WEIGHT, WEIGHTS = 2.0, 100
"""How much a guide counts against the seams: usually, and at most."""

PLANE_WEIGHTS = 100
"""How many times more than usually a plane may count in matching."""

REACHES = 256
"""Px around the boundaries of labels that count as partly of both, at most."""

MARGIN = 100
"""Px by which a picture is extended to the right if no side is named (Multrus 2003, A.1)."""

AUTO_METHOD = "auto"
"""The method that is chosen by what the exemplar is like."""

MOST_TRIALS = 64
"""How many variants are made at most, of which the best is kept: each is a whole picture."""

PASSES, MOST_PASSES = 4, 1000
"""How often a repair looks for the worst seams: usually, and at most."""


def whole(value: Any) -> int:
    """Return a whole number of any numeric type, such as 24, 24.0 or np.int64(24), as an int.

    ValueError for all else: truth values, text, fractions, NaN and infinity.
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
    """Return a whole number of at least `low` and at most `high`, or refuse it as the argument `name`."""
    span = f"at least {low} {unit}" if high is None else f"{low} to {high} {unit}"
    try:
        number = whole(value)
    except ValueError:
        raise ParameterError(f"{name}={called(value)} is not allowed; give {span}, a whole number.") from None
    if number < low or (high is not None and number > high):
        raise ParameterError(f"{name}={called(number)} is not allowed; give {span}.")
    return number


def pair(value: Any) -> Pair:
    """Return (rows, columns) of a size: one whole number is a square; ValueError for all else."""
    if isinstance(value, (tuple, list)) or getattr(value, "shape", None) == (2,):
        rows, columns = (whole(n) for n in value)
        return rows, columns
    side = whole(value)
    return side, side


def size_of(value: Any) -> Pair:
    """Return (height, width) as callers give it, one number for a square; ParameterError for all else."""
    try:
        return pair(value)
    except ValueError:
        raise ParameterError(
            f"size={called(value)} is not allowed; give (height, width) in whole px, or one number for a square."
        ) from None


def channels_of(text: Any) -> tuple[str, ...]:
    """Read what the channels of a packed map hold, as in R=ao,G=roughness,B=metallic; ``""`` for those not named."""
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
    """Return what a word stands for, or refuse it as the argument `name`."""
    try:
        return kind(value)
    except (TypeError, ValueError):
        words = ", ".join(str(one.value) for one in kind)
        raise ParameterError(f"{name}={called(value)} is not allowed; choose one of {words}.") from None


def expect(
    value: Any, kinds: type[Any] | tuple[type[Any], ...], name: str, remedy: str,
    error: type[IntarsiaError] = ParameterError,
) -> None:  # fmt: skip
    """Refuse an argument that is of another kind than those meant, and say what to give."""
    if not isinstance(value, kinds):
        raise error(f"{name} is {called(value)}; give {remedy}.")


def expect_path(value: Any) -> None:
    """Refuse what names no file."""
    if not isinstance(value, str) and not hasattr(type(value), "__fspath__"):
        raise InputError(f"{called(value)} names no file; give a path.")


def called(value: Any) -> str:
    """Return what was given in a few words: numbers and text as they are written, other things by their kind."""
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
    """Stand for the module `name`; the first attribute asked of it imports it."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        value = getattr(importlib.import_module(self._name), attribute)
        self.__dict__[attribute] = value
        return value


if not TYPE_CHECKING:  # what many files ask for, and few commands
    ndimage = lazy("scipy.ndimage")
