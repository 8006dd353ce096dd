"""Worker process: windows of an endless texture, as tiles."""

from __future__ import annotations

import time
from contextlib import chdir
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter

from ...cli.verbs import read_argv
from ...corrections.parallel_controllable import coarse
from ...foundation import InputError, MethodError
from ...foundation.geometry import Box
from ...foundation.run import Run
from ...giant import Weave, weave
from ...methods.parallel_controllable import ParallelControllable
from ...model import Exemplar
from ...model.image import Plane
from .decoding import Pixels, exemplar_of, png, reduced, seen
from .worker import Answer, Json, Tell

SIDE = 256  # px of a tile
TEXTURES, TILES = 8, 400  # that are cached
SLICE = 0.1  # s of drawing at a time, after which other requests have a turn

_tiles: dict[tuple[Any, ...], Pixels] = {}


class MoreError(Exception):
    """There is more to draw than one turn has time for."""


def begin(said: Json, tell: Tell) -> Answer:
    """Prepare an endless texture; InputError if it cannot be made."""
    try:
        _texture(said["folder"], said["seed"], *said["words"])
    except MethodError as e:  # a fault of the input, not of the server
        raise InputError(str(e)) from e
    return {}, b""


def tile(said: Json, tell: Tell) -> Answer:
    """Return a tile (level, row, column), counted from the origin: PNG; empty if its time is up: ask again.

    Its side is 256 px times 2**level.
    """
    texture, (level, y, x) = _texture(said["folder"], said["seed"], *said["words"]), said["place"]
    try:
        return {}, png(_tile(texture, level, y, x, time.perf_counter() + SLICE))
    except MoreError:
        return {}, b""


def _tile(texture: Weave, level: int, y: int, x: int, until: float) -> Pixels:
    """Return a tile, (256, 256, C) of 8 bits; each level is the one below it, averaged, or a method's own."""
    key = (texture, level, y, x)
    found = _tiles.get(key)
    if found is None and level:
        found = _coarse(texture, level, y, x)
    if found is None and level:
        parts = [[_tile(texture, level - 1, 2 * y + dy, 2 * x + dx, until) for dx in (0, 1)] for dy in (0, 1)]
        found = reduced(np.concatenate([np.concatenate(row, axis=1) for row in parts]), SIDE)
    if found is None:
        if time.perf_counter() > until:
            raise MoreError
        pixels = texture[y * SIDE : (y + 1) * SIDE, x * SIDE : (x + 1) * SIDE]
        found = seen(Plane(pixels, texture.like.kind, texture.like.transfer))
    _tiles[key] = found
    if len(_tiles) > TILES:
        del _tiles[next(iter(_tiles))]
    return found


def _coarse(texture: Weave, level: int, y: int, x: int) -> Pixels | None:
    """Return a tile of the coarse levels of a method, or None; each pixel is averaged over its square."""
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
    """Return a plane as displayed, each pixel averaged over a square of so many px around it."""
    mode: Any = "wrap" if exemplar.toroidal else "reflect"
    return np.rint(uniform_filter(seen(like).astype(float), (side, side, 1), mode=mode)).astype(np.uint8)


@lru_cache(maxsize=TEXTURES)
def _texture(folder: str, seed: int, *words: str) -> Weave:
    """Return the endless texture of the words of a command; its analysis is shared by all seeds."""
    return replace(_analysed(folder, *words), seed=seed)


@lru_cache(maxsize=TEXTURES)
def _analysed(folder: str, *words: str) -> Weave:
    """Return the same without a seed, read in a folder."""
    asked = read_argv(list(words))
    with chdir(folder):
        return weave(exemplar_of(list(asked.files)), asked.chosen)
