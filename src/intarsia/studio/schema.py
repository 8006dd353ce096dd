"""What may be asked: commands, their options, methods and their parameters, as the table of the request has them."""

from __future__ import annotations

from functools import cache
from typing import Any

from ..arguments import SAMPLES
from ..cli.app import COMMANDS
from ..cli.help import entries
from ..disk.limits import DEFAULT_PIXELS
from ..params import OVER, Parameter
from ..request.field import Field
from ..request.request import fields_of_verb, parameters_of_verb
from ..request.verbs import known_parameters
from ..version import VERSION

VERBS = ("grow", "paint", "extend", "heal", "tile", "weave", "render")
"""The commands that a job can be."""

LIMITS = {
    "pixels": DEFAULT_PIXELS,
    "upload": 512 << 20,
    "files": 24,
    "image": 64 << 20,
    "json": 1 << 20,
    "queue": 1000,
}
"""Most pixels of a picture; bytes of an upload, files in it, bytes of an image and of JSON; jobs that wait."""

Option = dict[str, Any]


@cache
def options(verb: str) -> dict[str, Option]:
    """The options of a verb by name: the fields of a job, and the parameters of methods."""
    fields = [f for f in fields_of_verb(verb) if not f.local and f.flags and f.kind.name != "written"]
    own = [_of_parameter(p, owners) for p, owners in parameters_of_verb(verb).values()]
    return {option["name"]: option for option in [*map(_of_field, fields), *own]}


@cache
def schema() -> dict[str, Any]:
    """All of it, as JSON."""
    verbs = {v: {"summary": COMMANDS[v], "options": list(options(v).values())} for v in VERBS}
    limits = {name: LIMITS[name] for name in LIMITS}
    return {"version": VERSION, "verbs": verbs, "methods": entries(), "samples": list(SAMPLES), "limits": limits}


def _of_field(f: Field) -> Option:
    """What is told of a field."""
    default = f.default if isinstance(f.default, str | int | float) else None
    if default is None and (f.kind.choices or f.default is not None) and not f.many and f.kind.name != "choice":
        default = f.kind.text(f.default)
    return {
        "name": f.key, "flag": f.flag, "kind": f.kind.name, "help": f.help, "default": default,
        "low": getattr(f.kind, "low", None), "high": getattr(f.kind, "high", None), "unit": "",
        "choices": list(f.kind.choices), "multiple": f.many, "required": f.required, "parameter": False,
    }  # fmt: skip


def _of_parameter(p: Parameter, owners: list[str]) -> Option:
    """What is told of a parameter, and of the methods that have it."""
    known, default = p.as_dict(), p.as_dict()["default"]
    turned = default[::-1] if p.kind == "extent" and isinstance(default, list) else default
    return {
        "name": p.name, "flag": "--" + p.name.replace("_", "-"), "kind": p.kind, "help": p.help, "default": turned,
        "low": p.low, "high": p.high, "unit": p.unit, "choices": known["choices"], "multiple": False,
        "required": False, "parameter": True, "methods": list(known_parameters()[p.name][1]), "image": p.kind in OVER,
    }  # fmt: skip
