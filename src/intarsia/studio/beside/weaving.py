"""In the process beside: windows of an endless texture, as tiles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...choosing.auto import AUTO_METHOD
from ...cli.pictures import value_of
from ...errors import ParameterError
from ...errors import said as named
from ...giant.texture import Weave, weave
from ...image import Plane
from ...methods.base import make, method_class
from ...params import parameters
from .looking import exemplar_of
from .pictures import png, seen
from .worker import Answer, Tell

SIDE = 256  # px of a tile

_held: dict[str, Weave] = {}


def begin(said: dict[str, Any], tell: Tell) -> Answer:
    """Decide how an endless texture is made; tell the method and its parameters."""
    texture = _texture(said)
    return {"method": texture.method.slug, "planes": list(texture.planes)}, b""


def tile(said: dict[str, Any], tell: Tell) -> Answer:
    """Draw a tile: its row and column count from the middle of nowhere."""
    texture = _texture(said)
    y, x = said["y"] * SIDE, said["x"] * SIDE
    pixels = texture[y : y + SIDE, x : x + SIDE]
    base = texture.exemplars[0].base
    return {}, png(seen(Plane(pixels, base.kind, base.transfer)))


def _texture(said: Mapping[str, Any]) -> Weave:
    name = said["id"]
    if name not in _held:
        while len(_held) > 3:
            _held.pop(next(iter(_held)))
        method = said["method"]
        chosen = method if method == AUTO_METHOD else make(method, _values(method, said["options"]))
        _held[name] = weave(exemplar_of(said["paths"]), chosen, said["seed"])
    return _held[name]


def _values(method: str, given: Mapping[str, str]) -> dict[str, Any]:
    known = {p.name: p for p in parameters(method_class(method))}
    for name in given:
        if name not in known:
            raise ParameterError(f"{method} has no parameter {named(name)}.")
    return {name: value_of(known[name], text) for name, text in given.items()}
