"""A result as a few lines of Python that make it again."""

from __future__ import annotations

import shlex
from pathlib import PurePosixPath
from typing import Any

from ..errors import IntarsiaError
from ..methods.base import Method, make, method_class
from ..params import parameters as parameters_of
from .store import Row
from .words import Words

PLAIN = ("size", "seed", "wrap", "feather", "mixing", "level", "method")
"""Options of grow that the call below says; a parameter of the method is another."""


def snippet(job: Row, words: Words, told: Row, command: str) -> str:
    """Return the call that grows this, or, where more was asked for, the command as a program runs it."""
    found = _call(job, words, told)
    if found is not None:
        return found
    name, *rest = shlex.split(command)
    return f"import subprocess\n\nsubprocess.run({[name, *rest]!r}, check=True)\n"


def _call(job: Row, words: Words, told: Row) -> str | None:
    """The call of the library; None where an option or a file is asked for that it says otherwise."""
    if job["verb"] != "grow" or "method" not in told or len(job["exemplars"]) != 1:
        return None
    slug, parameters = told["method"], told["parameters"]
    if set(job["options"]) - {*PLAIN, *parameters} or "magnify" in told:
        return None
    sources = [words.called.get(word, word) for word in words.said[1:] if not word.startswith("-")]
    if len(sources) != 1:
        return None
    usual, kinds = _settings(make(slug, {})), {p.name: p.kind for p in parameters_of(method_class(slug))}
    given = {}
    for name, value in parameters.items():
        if value != usual.get(name):
            given[name] = _tuples(value[::-1] if kinds[name] == "extent" and isinstance(value, list) else value)
    try:
        if _settings(make(slug, given)) != parameters:
            return None
    except IntarsiaError:  # it does not take what a recipe says of it
        return None
    method = f"ia.{method_class(slug).__name__}({', '.join(f'{name}={value!r}' for name, value in given.items())})"
    width, height = told["size"]
    line = shlex.split(told.get("auto", {}).get("command", f"--seed {told['seed']}"))
    seed = line[line.index("--seed") + 1]  # of the trial that was taken
    more = f", seed={seed}" * (seed != "0") + f", wrap={told['wrap']!r}" * (told["wrap"] != "none")
    lines = ["import intarsia as ia", "", *_blend(told["blend"])]
    lines += [
        f"made = ia.synthesize({sources[0]!r}, ({height}, {width}), {method}{more}, blend=blend)",
        f"ia.write({PurePosixPath(told['files'][0]['path']).name!r}, made.render(), recipe=made.recipe_text)",
    ]
    return "\n".join(lines) + "\n"


def _blend(blend: Row) -> list[str]:
    finish = "".join(f"ia.Levelling({one['radius']}), " for one in blend.get("finish", []))
    more = f", finish=({finish.rstrip()})" if finish else ""
    return [f"blend = ia.Blend({blend['feather']}, {blend['mixing']!r}{more})"]


def _settings(method: Method) -> dict[str, Any]:
    """Parameters as a recipe holds them, once it is JSON."""
    found = {}
    for p in parameters_of(method):
        value = getattr(method, p.name)
        found[p.name] = _lists(value[::-1] if p.kind == "extent" and isinstance(value, tuple) else value)
    return found


def _lists(value: Any) -> Any:
    return list(map(_lists, value)) if isinstance(value, tuple) else value


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value
