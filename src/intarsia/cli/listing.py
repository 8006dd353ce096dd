"""What is told of the methods, as JSON. Imports nothing heavy."""

from __future__ import annotations

from typing import Any

from ..methods.base import METHODS, method_class
from ..params import Parameter, parameters


def entries(*slugs: str) -> list[dict[str, Any]]:
    """What ``intarsia methods --json`` prints of these methods, or of all."""
    return [_entry(method_class(slug)) for slug in slugs or METHODS]


def _entry(cls: type[Any]) -> dict[str, Any]:
    return {
        "slug": cls.slug,
        "paper": cls.paper,
        "summary": cls.summary,
        "supports": sorted(ability.value for ability in cls.supports),
        "parameters": [_xy(p) for p in parameters(cls)],
    }


def _xy(p: Parameter) -> dict[str, Any]:
    entry = p.as_dict()
    if p.kind == "extent" and isinstance(p.default, tuple):
        entry["default"] = list(reversed(p.default))
    return entry
