"""In the process beside: windows of an endless texture, as tiles; and where a brush says how much it is jittered.

The number that strokes say of a place follows from its coordinates and the strokes alone. It is one of the 256 that a
gray picture of 8 bits can say, so that a command that is given such a picture draws the same bytes.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Mapping
from contextlib import chdir
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from ...arrays import Floats, Pair, UInt8
from ...cli.help import read_argv
from ...corrections.parallel_controllable import coarse
from ...errors import InputError, MethodError, ParameterError
from ...exemplar import Exemplar
from ...field import Field
from ...geometry import Box
from ...giant.texture import Weave, weave
from ...image import Plane
from ...methods.parallel_controllable import ParallelControllable
from ...params import parameters
from ...run import Run
from .looking import Pixels, exemplar_of, png, reduced, seen
from .worker import Answer, Tell

SIDE = 256  # px of a tile, and of a block of numbers that is kept
BRUSHED = "jitter_output"
"""The parameter that a brush paints."""

TEXTURES, TILES = 8, 400  # that are kept
SLICE = 0.1  # s that are drawn at a time: then whoever waits for something else has a turn
LARGEST = 8192  # px of a picture that says what was painted
KEPT = 96  # blocks, of 512 kB each
ROUNDED = 1024  # of them, of 64 kB each, as a tile is told of them
STEPS = 255

Numbers = Floats

_textures: OrderedDict[str, Weave] = OrderedDict()
_tiles: OrderedDict[tuple[Any, ...], Pixels] = OrderedDict()
_blocks: OrderedDict[tuple[Any, ...], Numbers] = OrderedDict()


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
    texture, box, painting = _texture(said), Box(*said["box"]), painting_of(said["jitter"])
    if not painting.strokes:
        return {}, b""
    tall, wide = (min(n + 1, LARGEST) for n in painting.reaches())
    if min(tall, wide) > 0:
        numbers = painting(np.arange(tall)[:, None], np.arange(wide)[None, :])
        picture = np.rint(numbers * STEPS).astype(np.uint8)
        field = Field(picture)  # beyond it its border goes on

        def beyond(y: Any, x: Any) -> Any:
            return field.at(np.ravel(y).astype(np.int64), np.ravel(x).astype(np.int64))

        if _asked(_brushed(texture, beyond), box) == _asked(texture, box):
            return {}, png(picture[:, :, None])
    raise InputError(
        "what was painted lies left of or above column 0 or row 0, or too far from them for a picture; no command "
        "says it. Paint farther right or down."
    )


def _tile(texture: Weave, said: Mapping[str, Any], level: int, y: int, x: int, until: float) -> Pixels:
    """The pixels of a tile, (256, 256, C) of 8 bits; each level is the one below it, averaged, or a method's own."""
    key = (_key(texture, said, level, y, x), level, y, x)
    found = _tiles.get(key)
    if found is None and level:
        found = _coarse(texture, level, y, x)
    if found is None:
        if level:
            parts = [[_tile(texture, said, level - 1, 2 * y + dy, 2 * x + dx, until) for dx in (0, 1)] for dy in (0, 1)]
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


def _texture(said: Mapping[str, Any]) -> Weave:
    """The endless texture that is meant; what is analysed for it is shared by all seeds and strokes."""
    name = said["id"]
    if name not in _textures:
        texture = replace(_analysed(said["folder"], *said["words"]), seed=said["seed"])
        _textures[name] = _brushed(texture, painting_of(said["jitter"])) if said["jitter"] is not None else texture
        while len(_textures) > TEXTURES:
            _textures.popitem(last=False)
    _textures.move_to_end(name)
    return _textures[name]


@lru_cache(maxsize=TEXTURES)
def _analysed(folder: str, *words: str) -> Weave:
    """The texture that the words of a command say, read in a folder."""
    asked = read_argv(list(words))
    with chdir(folder):
        return weave(exemplar_of(list(asked.files)), asked.chosen)


def _brushed(texture: Weave, function: Any) -> Weave:
    """The same texture, jittered as much as a function says."""
    method: Any = texture.method
    if BRUSHED not in {p.name for p in parameters(type(method))}:
        raise ParameterError(f"{method.slug} has no jitter that a brush could paint.")
    return replace(texture, method=replace(method, **{BRUSHED: Field(function)}))


@dataclass(frozen=True)
class Stroke:
    """A round brush that went from point to point: full within half its radius (px), then less and less.

    `strength`: the number that it leads to, 0 to 1; None: back to what is where nothing was painted.
    """

    radius: float
    strength: float | None
    points: tuple[tuple[float, float], ...]  # x, y

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.radius, self.strength, self.points))

    @cached_property
    def blocks(self) -> frozenset[Pair]:
        """The blocks, row and column, that it may touch."""
        found = set()
        for (ax, ay), (bx, by) in self.legs:
            (top, below), (left, right) = (self._span(*ends) for ends in ((ay, by), (ax, bx)))
            found |= {(y, x) for y in range(top, below + 1) for x in range(left, right + 1)}
        return frozenset(found)

    @property
    def legs(self) -> list[tuple[tuple[float, float], tuple[float, float]]]:
        """From which point to which it went; a dab goes from its point to itself."""
        return list(zip(self.points, self.points[1:] or self.points, strict=False))

    def _span(self, a: float, b: float) -> Pair:
        return int((min(a, b) - self.radius) // SIDE), int((max(a, b) + self.radius) // SIDE)

    def over(self, below: Numbers, ground: float, block: Pair) -> Numbers:
        """Paint over the numbers of a block."""
        top, left = (n * SIDE for n in block)
        apart = np.full(below.shape, self.radius * self.radius)
        for (ax, ay), (bx, by) in self.legs:
            rows, cols = (
                slice(max(0, int(min(a, b) - self.radius - first)), max(0, int(max(a, b) + self.radius - first) + 2))
                for a, b, first in ((ay, by, top), (ax, bx, left))
            )
            part = apart[rows, cols]
            if part.size:
                y = np.arange(SIDE, dtype=np.float64)[rows, None] + (top - ay)
                x = np.arange(SIDE, dtype=np.float64)[None, cols] + (left - ax)
                dy, dx = by - ay, bx - ax
                share = np.clip((y * dy + x * dx) / max(dy * dy + dx * dx, 1e-9), 0.0, 1.0)
                y, x = y - share * dy, x - share * dx
                np.minimum(part, y * y + x * x, out=part)
        soft = np.clip(2.0 * (1.0 - np.sqrt(apart) / self.radius), 0.0, 1.0)
        weight = soft * soft * (3.0 - 2.0 * soft)
        aim = ground if self.strength is None else self.strength
        return np.asarray(below + (aim - below) * weight)


@dataclass(frozen=True)
class Painting:
    """What part of the jitter holds where, 0 to 1: `ground`, and strokes over it, the last one on top."""

    ground: float
    strokes: tuple[Stroke, ...]

    def __call__(self, y: Any, x: Any) -> Numbers:
        """Return the numbers at rows (n, 1) and columns (1, m), px."""
        rows, cols = (np.asarray(a, np.float64).ravel().astype(np.int64) for a in (y, x))
        out = np.full((len(rows), len(cols)), np.rint(self.ground * STEPS), np.uint8)
        across: dict[int, Any] = {}
        for block_row, touched in self._touched.items():
            down = np.flatnonzero(rows // SIDE == block_row)
            for block_column in touched if len(down) else ():
                if block_column not in across:
                    across[block_column] = np.flatnonzero(cols // SIDE == block_column)
                along = across[block_column]
                if len(along):
                    numbers = _rounded(self, block_row, block_column)
                    out[np.ix_(down, along)] = numbers[np.ix_(rows[down] % SIDE, cols[along] % SIDE)]
        return out / float(STEPS)

    def reaches(self) -> Pair:
        """The row and the column behind the last that strokes may touch, px."""
        return (max(self._touched) + 1) * SIDE, (max(max(row) for row in self._touched.values()) + 1) * SIDE

    @cached_property
    def _touched(self) -> dict[int, dict[int, tuple[Stroke, ...]]]:
        """The strokes that may touch a block, by its row and its column."""
        found: dict[int, dict[int, tuple[Stroke, ...]]] = {}
        for stroke in self.strokes:
            for row, column in stroke.blocks:
                there = found.setdefault(row, {})
                there[column] = (*there.get(column, ()), stroke)
        return found

    def blended(self, row: int, column: int) -> Numbers:
        """The numbers of a block before they are rounded; a further stroke begins with what is kept."""
        strokes = self._touched[row][column]
        done = len(strokes)
        while done and (self.ground, row, column, strokes[:done]) not in _blocks:
            done -= 1
        if done:
            numbers = _blocks[self.ground, row, column, strokes[:done]]
            _blocks.move_to_end((self.ground, row, column, strokes[:done]))
        else:
            numbers = np.full((SIDE, SIDE), self.ground)
        if done == len(strokes):
            return numbers
        for stroke in strokes[done:]:
            numbers = stroke.over(numbers, self.ground, (row, column))
        _blocks[self.ground, row, column, strokes] = numbers
        while len(_blocks) > KEPT:
            _blocks.popitem(last=False)
        return numbers


def painting_of(given: Any) -> Painting:
    """Return what JSON tells of strokes."""
    strokes = tuple(
        Stroke(float(one["radius"]), one["strength"], tuple((float(x), float(y)) for x, y in one["points"]))
        for one in given["strokes"]
    )
    return Painting(float(given["ground"]), strokes)


@lru_cache(maxsize=ROUNDED)
def _rounded(painting: Painting, row: int, column: int) -> UInt8:
    """What a block of a painting says, in 1 / 255."""
    return np.rint(painting.blended(row, column) * STEPS).astype(np.uint8)
