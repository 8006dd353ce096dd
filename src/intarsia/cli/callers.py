"""What other programs are told, and how a run ends with them: the contract of docs/callers.md.

With ``--progress json`` stderr holds JSON objects alone, one a line. Imports nothing heavy.
"""

from __future__ import annotations

import os
import re
import signal
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from os.path import basename, splitext
from typing import Any

import click

from ..foundation import IntarsiaError, ParameterError, legible

PATIENCE = 0.7  # s for a run whose parent has ended to clean up


class _Caller:
    """Who has called this process: a person, or a program that reads JSON lines and whose user knows other names."""

    lines = False
    names: dict[str, str] = {}  # noqa: RUF012 - replaced, never changed


def begin(words: Sequence[str]) -> None:
    """Find out from the words of a command line, before they are parsed, whether the caller reads JSON lines."""
    _Caller.lines = "--progress\njson" in "\n".join(words) or "--progress=json" in words
    _Caller.names = {}


def reads_lines() -> bool:
    """Return whether the caller reads JSON lines."""
    return _Caller.lines


def call(names: Iterable[tuple[str, str]]) -> None:
    """Use these names, (file, name), in all lines; a file is known by its path, its name, and a stem with a digit.

    A stem without one, such as ``hole``, may be a word of the line.
    """
    _Caller.names = {}
    for path, name in names:
        stem = splitext(basename(path))[0]
        stems = [stem, re.sub(r"\W+", "_", stem)] if re.search(r"\d", stem) else []
        _Caller.names |= {form: name for form in (path, basename(path), *stems) if form}


def named(line: str) -> str:
    """Return a line with the names that the caller's user knows."""
    if not _Caller.names:
        return line
    forms = sorted(_Caller.names, key=len, reverse=True)
    found = "|".join(map(re.escape, forms))
    return re.sub(rf"(?<![\w/\\])(?:{found})(?!\w)", lambda match: _Caller.names[match[0]], line)


def tell(**facts: Any) -> None:
    """Write facts as one JSON line to stderr; a closed one is ignored."""
    import json

    with suppress(OSError, ValueError):
        click.echo(json.dumps(facts).replace("\x7f", "\\u007f"), err=True)


def say(line: str, kind: str = "note") -> None:
    """Write a line to stderr, for a person or as JSON of this kind; a closed one is ignored."""
    line = named(legible(line))
    if _Caller.lines:
        tell(**{kind: line})
    else:
        with suppress(OSError, ValueError):
            click.echo(line, err=True)


def say_error(message: str, kind: str, code: int) -> None:
    """Write how the command failed, as the last line."""
    if _Caller.lines:
        tell(error=named(message), kind=kind, exit_code=code)
    else:
        say(f"intarsia: {message}")


def kind_of(e: BaseException) -> str:
    """Return the kind of an error in a word: input, parameter, method, resource, ...; stopped; usage; internal."""
    if isinstance(e, IntarsiaError):
        words = re.findall("[A-Z][a-z]+", type(e).__name__.removesuffix("Error"))
        return "-".join(words).lower().replace("cancelled", "stopped")
    if isinstance(e, click.ClickException):
        return "usage"
    if isinstance(e, MemoryError | OSError):
        return "resource"
    return "internal" if isinstance(e, Exception) and not isinstance(e, click.Abort) else "stopped"


def end_with_parent(stop: Callable[[], object], files: Iterable[str]) -> None:
    """End this process within a second once its standard input is closed, as it is when its parent ends."""
    if "-" in files:
        raise ParameterError("--with-parent reads the standard input, so no picture can come from there; name a file.")

    def watch() -> None:
        with suppress(OSError, ValueError):
            while os.read(0, 1 << 12):
                pass
        stop()
        signal.raise_signal(signal.SIGTERM)
        time.sleep(PATIENCE)
        os._exit(130)  # deep in a kernel; what it leaves has a name that the next run removes

    threading.Thread(target=watch, daemon=True).start()
