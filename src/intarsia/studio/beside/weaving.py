"""In the process beside: windows of an endless texture, as tiles; and where a brush says how much it is jittered."""

from __future__ import annotations

import hashlib
import json
import time
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...choosing.auto import AUTO_METHOD
from ...corrections.parallel_controllable import coarse
from ...errors import InputError, MethodError, ParameterError
from ...errors import said as named
from ...exemplar import Exemplar
from ...field import Field
from ...geometry import Box
from ...giant.texture import Weave, weave
from ...image import Plane
from ...methods.base import make, method_class
from ...methods.parallel_controllable import ParallelControllable
from ...params import parameters
from ...request.pictures import value_of
from ...run import Run
from .looking import exemplar_of
from .pictures import Pixels, png, reduced, seen
from .strokes import STEPS, Painting, painting_of
from .worker import Answer, Tell

SIDE = 256  # px of a tile
BRUSHED = "jitter_output"
"""The parameter that a brush paints."""

TEXTURES, TILES = 4, 400  # that are kept
SLICE = 0.1  # s that are drawn at a time: then whoever waits for something else has a turn
LARGEST = 8192  # px of a picture that says what was painted

_textures: OrderedDict[str, Weave] = OrderedDict()
_tiles: OrderedDict[tuple[Any, ...], Pixels] = OrderedDict()


class MoreError(Exception):
    """There is more to draw than one turn has time for."""


def begin(said: dict[str, Any], tell: Tell) -> Answer:
    """Decide how an endless texture is made; tell the method, and whether a brush can say how much it is jittered."""
    try:
        texture = _texture(said)
    except MethodError as e:  # that is how the exemplar is, and no fault of the server
        raise InputError(str(e)) from e
    brush = any(p.name == BRUSHED for p in parameters(type(texture.method)))
    return {"method": texture.method.slug, "planes": list(texture.planes), "brush": brush}, b""


def tile(said: dict[str, Any], tell: Tell) -> Answer:
    """Draw a tile; its row and column count from the middle of nowhere, its side is 256 px times 2**level.

    Its `key` says what its pixels depend on: where it is `known`, nothing is drawn. `more`: it is begun, ask again.
    """
    texture, level, y, x = _texture(said), said["level"], said["y"], said["x"]
    key = _key(texture, said, level, y, x)
    if key == said["known"]:
        return {"key": key}, b""
    try:
        return {"key": key}, png(_tile(texture, said, level, y, x, time.perf_counter() + SLICE))
    except MoreError:
        return {"more": True}, b""


def painted(said: dict[str, Any], tell: Tell) -> Answer:
    """Return what was painted as a gray picture from (0, 0) on, if that says the same for a window; nothing if none."""
    texture, box = _texture(said), Box(*said["box"])
    painting = _painting(said)
    if painting is None or not painting.strokes:
        return {}, b""
    tall, wide = (min(n + 1, LARGEST) for n in painting.reaches()[2:])
    if min(tall, wide) > 0:
        numbers = painting(np.arange(tall)[:, None], np.arange(wide)[None, :])
        picture = np.rint(numbers * STEPS).astype(np.uint8)
        if _asked(_brushed(texture, _beyond(picture)), box) == _asked(texture, box):
            return {}, png(picture[:, :, None])
    raise InputError(
        "what was painted lies left of or above column 0 or row 0, or too far from them for a picture; no command "
        "says it. Paint farther right or down."
    )


def _beyond(picture: Pixels) -> Any:
    """What a field says by a picture, whose border goes on, as a function."""

    def numbers(y: Any, x: Any) -> Any:
        rows, cols = (np.asarray(a).ravel().astype(np.int64) for a in (y, x))
        inside = picture[np.clip(rows, 0, len(picture) - 1)][:, np.clip(cols, 0, picture.shape[1] - 1)]
        return inside.astype(np.float64) / STEPS

    return numbers


def _tile(texture: Weave, said: Mapping[str, Any], level: int, y: int, x: int, until: float) -> Pixels:
    """The pixels of a tile, (256, 256, C) of 8 bits; each level is the one below it, averaged, or a method's own."""
    key = (_key(texture, said, level, y, x), level, y, x)
    found = _tiles.get(key)
    if found is None and level:
        found = _coarse(texture, level, y, x)
    if found is None:
        if level:
            parts = [
                [_tile(texture, said, level - 1, 2 * y + dy, 2 * x + dx, until) for dx in (0, 1)] for dy in (0, 1)
            ]
            found = reduced(np.concatenate([np.concatenate(row, axis=1) for row in parts]), SIDE)
        else:
            if time.perf_counter() > until:
                raise MoreError
            like = texture.like
            pixels = texture[y * SIDE : (y + 1) * SIDE, x * SIDE : (x + 1) * SIDE]
            found = seen(Plane(pixels, like.kind, like.transfer))
    _tiles[key] = found
    _tiles.move_to_end(key)
    while len(_tiles) > TILES:
        _tiles.popitem(last=False)
    return found


def _coarse(texture: Weave, level: int, y: int, x: int) -> Pixels | None:
    """A tile as the coarse levels of a method have it, where it has any: each pixel averaged over its square."""
    method, exemplar = texture.method, texture.exemplars[0]
    if not isinstance(method, ParallelControllable) or texture.scale != (1, 1):
        return None
    one, side = 1 << level, SIDE << level
    box = Box(y * side, x * side, (y + 1) * side, (x + 1) * side)
    found = coarse(method, texture.exemplars, box, level, texture.seed, Run(1))
    if found is None:
        return None
    means = exemplar.latest(f"means of {one} px", texture.name, lambda: _means(exemplar, texture.like, one))
    picked: Pixels = means[found[..., 0], found[..., 1]]
    return picked


def _means(exemplar: Exemplar, like: Plane, side: int) -> Pixels:
    """What can be seen of a plane, each pixel averaged over a square of so many px around it."""
    mode: Any = "wrap" if exemplar.toroidal else "symmetric"
    before, picture = side // 2, seen(like)
    around = np.pad(picture, ((before, side - before - 1),) * 2 + ((0, 0),), mode=mode)
    for axis in (0, 1):
        total = np.cumsum(around, axis=axis, dtype=np.float64)
        whole = np.insert(total, 0, 0, axis=axis)
        count = whole.shape[axis] - side
        around = (np.take(whole, range(side, side + count), axis) - np.take(whole, range(count), axis)) / side
    return np.asarray(np.rint(around), np.uint8)


def _key(texture: Weave, said: Mapping[str, Any], level: int, y: int, x: int) -> str:
    """What the pixels of a tile depend on; of what was painted only what is asked for it."""
    if said["jitter"] is None or level:
        return str(said["id"])
    box = Box(y * SIDE, x * SIDE, (y + 1) * SIDE, (x + 1) * SIDE)
    asked = _asked(texture, box)
    if said["jitter"]["ground"] == 1 and asked == _asked(_brushed(texture, Painting(1.0, ())), box):
        return str(said["base"])
    return f"{said['base']}-{asked[:16]}"


def _asked(texture: Weave, box: Box) -> str:
    """A hash of all that what was painted says for a box, and around it, where coarse levels begin."""
    found: str = texture.recipe_over(box)["parameters"][BRUSHED]["sha256"]
    return found


def _painting(said: Mapping[str, Any]) -> Painting | None:
    return None if said["jitter"] is None else painting_of(said["jitter"])


def _texture(said: Mapping[str, Any]) -> Weave:
    """The endless texture that is meant; what is analysed for it is shared by all seeds and strokes."""
    name = said["id"]
    if name not in _textures:
        method, own = said["method"], json.dumps([said["paths"], said["method"], said["options"]])
        shared = "base " + hashlib.sha256(own.encode()).hexdigest()
        if shared not in _textures:
            chosen = method if method == AUTO_METHOD else make(method, _values(method, said["options"]))
            _keep(shared, weave(exemplar_of(said["paths"]), chosen))
        _keep(shared, _textures[shared])
        texture, painting = replace(_textures[shared], seed=said["seed"]), _painting(said)
        if painting is not None:
            texture = _brushed(texture, painting)
        _keep(name, texture)
    _textures.move_to_end(name)
    return _textures[name]


def _brushed(texture: Weave, function: Any) -> Weave:
    """The same texture, jittered as much as a function says."""
    method: Any = texture.method
    if BRUSHED not in {p.name for p in parameters(type(method))}:
        raise ParameterError(f"{method.slug} has no jitter that a brush could paint.")
    return replace(texture, method=replace(method, **{BRUSHED: Field(function)}))


def _keep(name: str, texture: Weave) -> None:
    _textures[name] = texture
    _textures.move_to_end(name)
    while len(_textures) > 2 * TEXTURES:
        _textures.popitem(last=False)


def _values(method: str, given: Mapping[str, str]) -> dict[str, Any]:
    known = {p.name: p for p in parameters(method_class(method))}
    for name in given:
        if name not in known:
            raise ParameterError(f"{method} has no parameter {named(name)}.")
    return {name: value_of(known[name], text) for name, text in given.items()}
