"""What may be asked: commands, their options, methods and their parameters, read off the command line itself."""

from __future__ import annotations

from functools import cache
from typing import Any

import click

from ..arguments import SAMPLES
from ..cli import values
from ..cli.app import COMMANDS, cli
from ..cli.listing import entries
from ..cli.options import ParameterOption
from ..disk.limits import DEFAULT_PIXELS
from ..methods.base import METHODS, method_class
from ..params import OVER, Parameter, parameters
from ..version import VERSION

VERBS = ("grow", "paint", "extend", "heal", "tile", "weave", "render")
"""The commands that a job can be."""

IMAGES = (
    "masks", "usable", "holes", "labels", "target", "jitter_output", "jitter_exemplar", "feature", "angle", "zoom",
)  # fmt: skip
"""Options that read a picture of numbers: an image's id is given."""

PICTURES = ("donors",)
"""Options that read exemplars."""

OWN = (
    "files", "saved", "maps", "out", "force", "as_json", "progress", "quiet", "threads", "many", "dry_run",
    "max_pixels", "as_set", "several", "explain", "document", "executor", "dask",
)  # fmt: skip
"""What the server gives itself, or nobody needs here."""

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
    """The options of a verb by name: the flag without its dashes."""
    found = {}
    for p in _command(verb).params:
        if isinstance(p, click.Option) and (option := _option(p)) is not None:
            found[option["name"]] = option
    return found


@cache
def schema() -> dict[str, Any]:
    """All of it, as JSON."""
    verbs = {v: {"summary": COMMANDS[v], "options": [_told(o) for o in options(v).values()]} for v in VERBS}
    limits = {name: LIMITS[name] for name in LIMITS}
    return {"version": VERSION, "verbs": verbs, "methods": entries(), "samples": list(SAMPLES), "limits": limits}


def _told(option: Option) -> Option:
    return {key: value for key, value in option.items() if key != "field"}


def _command(verb: str) -> click.Command:
    found = cli.get_command(click.Context(cli), verb)
    assert found is not None
    return found


def fields(verb: str) -> set[str]:
    """All options that a command has, offered or not."""
    return {str(p.name) for p in _command(verb).params}


def metavar(verb: str, field: str) -> str | None:
    """What an option's help shows in place of a value."""
    found = {p.name: p for p in _command(verb).params}[field]
    return found.metavar


@cache
def _known() -> dict[str, tuple[Parameter, list[str]]]:
    """Every parameter by name, and the methods that have it."""
    found: dict[str, tuple[Parameter, list[str]]] = {}
    for slug in METHODS:
        for p in parameters(method_class(slug)):
            found.setdefault(p.name, (p, []))[1].append(slug)
    return found


def parameter(field: str) -> Parameter:
    """The parameter of methods that an option gives."""
    return _known()[field][0]


def _option(p: click.Option) -> Option | None:
    """What is told of an option; None of one that only the server gives, or that names a file to be written."""
    field = str(p.name)
    if field in OWN or p.hidden or field.startswith("help"):
        return None
    reads = field in IMAGES or field in PICTURES
    if not reads and _names_a_file(p) and not isinstance(p, ParameterOption):
        return None
    flag = max(p.opts, key=len)
    told: Option = {
        "name": flag.lstrip("-").replace("-", "_"), "field": field, "flag": flag, "kind": "text", "help": p.help or "",
        "default": None, "low": None, "high": None, "unit": "", "choices": [], "multiple": p.multiple,
        "required": p.required, "parameter": False,
    }  # fmt: skip
    if isinstance(p, ParameterOption):
        one, owners = _known()[field]
        default = one.as_dict()["default"]
        told |= {
            "kind": one.kind, "help": one.help, "default": default, "low": one.low, "high": one.high, "unit": one.unit,
            "choices": list(one.choices), "parameter": True, "methods": owners,
        }  # fmt: skip
        if one.kind == "extent" and isinstance(default, list):
            told["default"] = default[::-1]
        return told | {"image": one.kind in OVER}
    return told | _kind(p, field)


def _kind(p: click.Option, field: str) -> Option:
    """The kind of an option, and what it may be."""
    default = p.default if isinstance(p.default, str | int | float | bool) else None
    if field in PICTURES:
        return {"kind": "exemplar"}
    if field in IMAGES:
        return {"kind": "image", "choices": ["alpha"] if field == "holes" else []}
    if p.is_flag:
        return {"kind": "flag", "default": False}
    if isinstance(p.type, click.Choice):
        return {"kind": "choice", "choices": [str(c) for c in p.type.choices], "default": default}
    if isinstance(p.type, click.IntRange):
        return {"kind": "int", "low": p.type.min, "high": p.type.max, "default": default}
    if isinstance(p.type, click.FloatRange):
        return {"kind": "float", "low": p.type.min, "high": p.type.max, "default": default}
    if isinstance(p.type, values.EnlargedSize):
        return {"kind": "int", "low": 0, "high": p.type.most, "choices": ["auto"], "default": default}
    names = {
        values.Size: "size", values.Rectangle: "rectangle", values.Colour: "colour", values.Seed: "seed",
        values.Scale: "scale", values.NamedNumber: "named",
    }  # fmt: skip
    return {"kind": names.get(type(p.type), "text"), "default": default}


def _names_a_file(p: click.Option) -> bool:
    kinds = p.type.types if isinstance(p.type, click.Tuple) else [p.type]
    named = isinstance(p.type, values.NamedFile) or "FILE" in (p.metavar or "")
    return named or any(isinstance(k, click.Path | click.File) for k in kinds)
