"""A request as Python code that makes its picture again."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from ..foundation import IntarsiaError
from ..methods import make, method_class, parameters_of, recipe_settings
from . import Json, Request, to_argv, to_json

PLAIN = frozenset({"size", "seed", "wrap", "feather", "mixing", "even_tone", "method", "output"})
"""Options that the call below can express, besides parameters of the method."""


def to_python(request: Request, made: Mapping[str, Any]) -> str:
    """Return code that grows what was `made`: a call of the library, or, if it cannot express that, the command."""
    call = _call(request, made)
    if call is not None:
        return call
    return f"import subprocess\n\nsubprocess.run({['intarsia', *to_argv(request, joined=True)]!r}, check=True)\n"


def _call(request: Request, made: Mapping[str, Any]) -> str | None:
    """Return the call of the library; None if the request has options or files that it cannot express."""
    if request.verb != "grow" or "method" not in made or len(request.files) != 1 or "magnify" in made:
        return None
    slug, told = made["method"], made["parameters"]
    if set(to_json(request)) - PLAIN - set(told):
        return None
    usual, known = _settings(slug, {}), parameters_of(slug)
    given = {}
    for name, value in told.items():
        if value != usual.get(name):
            given[name] = _tuples(value[::-1] if known[name].kind == "extent" and isinstance(value, list) else value)
    try:
        if _settings(slug, given) != told:
            return None
    except IntarsiaError:  # it does not take what a recipe says of it
        return None
    method = f"ia.{method_class(slug).__name__}({', '.join(f'{name}={value!r}' for name, value in given.items())})"
    width, height = made["size"]
    line = shlex.split(made.get("auto", {}).get("command", f"--seed {made['seed']}"))
    seed = line[line.index("--seed") + 1]  # of the trial that was taken
    more = f", seed={seed}" * (seed != "0") + f", wrap={made['wrap']!r}" * (made["wrap"] != "none")
    blend = made["blend"]
    finish = "".join(f"ia.Levelling({one['radius']}), " for one in blend.get("finish", []))
    finish = f", finish=({finish.rstrip()})" if finish else ""
    lines = [
        "import intarsia as ia",
        "",
        f"blend = ia.Blend({blend['feather']}, {blend['mixing']!r}{finish})",
        f"made = ia.synthesize({request.files[0]!r}, ({height}, {width}), {method}{more}, blend=blend)",
        f"ia.write({PurePosixPath(made['files'][0]['path']).name!r}, made.render(), recipe=made.recipe_text)",
    ]
    return "\n".join(lines) + "\n"


def _settings(slug: str, given: Json) -> Json:
    """Return parameters as a recipe of JSON holds them."""
    told: Json = json.loads(json.dumps(recipe_settings(make(slug, given))))
    return told


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value
