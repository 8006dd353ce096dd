"""Everything that intarsia refuses, and with which exit code.

    IntarsiaError            1  the work failed
    |- ParameterError        2  a parameter or an option is out of its range, or does not fit the others
    |- InputError            3  a file or an array is missing, broken, of the wrong size or kind
    |- QualityError          4  a quality gate that was asked for is missed
    |- MissingExtraError     5  an optional package is not installed
    |- MethodError           1  the method cannot serve this exemplar
    |- ResourceError         1  disk full, memory, a folder that cannot be written
    `- CancelledError      130  the caller asked to stop

A message is one line: what was given, what is allowed, what to do.
"""

from __future__ import annotations

import os
import unicodedata

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
