"""The verbs that work on exemplars, the methods that each offers, and what is known of all their parameters."""

from __future__ import annotations

from functools import cache
from typing import Any

from ..methods.base import METHODS, Ability, method_class
from ..params import Parameter, parameters

BEGUN = frozenset({"extend", "heal", "tile"})
"""Verbs that begin with a picture."""

PLANNED = BEGUN | {"grow", "paint"}
"""Verbs that make one picture, or many, in memory."""

EVERY = PLANNED | {"weave", "render", "replay", "analyze", "score"}
DRAWN = PLANNED | {"render", "replay"}
MADE = PLANNED | {"weave"}

ABILITIES = {
    "paint": {Ability.GUIDE}, "heal": {Ability.START, Ability.MASK}, "tile": {Ability.START, Ability.MASK},
    "weave": {Ability.WINDOW},
}  # fmt: skip
"""What a method must be able to, so that a verb offers it."""

DONE = {"grow": "grown", "paint": "painted", "extend": "extended", "heal": "healed", "tile": "tiled", "weave": "woven"}
"""What is added to the name of an exemplar where a result is given no name."""


def able(verb: str) -> tuple[str, ...]:
    """The methods that a verb offers."""
    return tuple(slug for slug in METHODS if ABILITIES.get(verb, set()) <= method_class(slug).supports)


def parameters_of(slug: Any) -> dict[str, Parameter]:
    """The parameters of a method by name; none of the choice among methods, and of what is no method."""
    known = isinstance(slug, str) and slug in METHODS
    return {p.name: p for p in parameters(method_class(slug))} if known else {}


@cache
def known_parameters() -> dict[str, tuple[Parameter, list[str]]]:
    """Every parameter of a method by name, and the methods that have it."""
    found: dict[str, tuple[Parameter, list[str]]] = {}
    for slug in METHODS:
        for name, p in parameters_of(slug).items():
            found.setdefault(name, (p, []))[1].append(slug)
    return found


def usual_parameters(verb: str, slug: str) -> dict[str, Any]:
    """What a verb gives a method that is named if nothing else is said: around a hole the best patch is taken."""
    return {"tolerance": 0.0} if verb in ("heal", "tile") and "tolerance" in parameters_of(slug) else {}
