"""The exemplar on all pyramid levels: neighbourhoods to compare, open candidates, and jump sets (k-coherence).

Jump sets hold similar exemplar pixels (Lefebvre and Hoppe 2005: candidates by k-coherence; named so by the memorandum
of 2008, docs/sources-004.md). On coarse levels they are searched for every (h / 2)-th pixel only, in large exemplars
for about 512 x 512 of them; pixels between take the continuations of a neighbour's jumps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..analysis import nearest, principal_axes, scaled_variances
from ..analysis.features import features
from ..foundation import ndimage
from ..foundation.arrays import Array, Int16, Int32, Int64, UInt8
from ..kernels import kd_tree
from ..model import Exemplar
from ..search import elements
from .appearance import (
    AXES,
    SAMPLE,
    WEIGHTS,
    Outlines,
    bordered,
    packed,
    stack_of,
    transformed,
    unpacked_words,
    whole_products,
    without_gaps,
)
from .appearance_kernels import Similar, jump_sets
from .correction_kernels import MIDDLE

UInt64 = NDArray[np.uint64]
CLOUDS = 16  # px: structures wider than this are clouds; by eye: 8 of 80 textures are cloudy, halved: 35, doubled: 2
CLOUDY = 3, 10  # least share of clouds in the variance of a cloudy picture, 3 / 10; halved: 29 of 80, doubled: 1
SEARCHED = 1 << 18  # pixels of a level for which similar ones are searched, about: bounds the time
KEPT = 1 << 28  # bytes of tables that are cached; if they are larger, they are computed for every window
APART = 0.05  # of the longer side: least jump (S4-26); halved: 0.4 % of px differ, doubled: 29 %, 6 of 24 repeat more
LEAVES = 4  # leaves of the kd-tree searched per query: bounds the time; doubled: 2 % nearer, 1.25 times as long
ASKED = 8  # candidates per jump from the tree, ranked exactly: bounds the time; doubled: less than 0.5 % nearer


class StackLevel(NamedTuple):
    """A level of the exemplar, as the correction kernel reads it.

    The exemplar has a border on all sides; a pixel is named by its *position*, row * stride + column, border included.
    Of ``packed`` and ``values`` one is empty, which decides what is compared.
    """

    h: int  # px from one pixel to the next
    border: int  # px on each side
    stride: int  # positions per row
    packed: UInt64  # (positions, 2): eight 16-bit appearance values of each pixel, all at least 0
    values: Int16  # (positions, C): colours
    roots: Int64  # (25,): of the weights that squared differences of the 5 x 5 colours have, 256 = 1
    inner: Int32  # (positions,): the position in the exemplar itself; in the border of a torus that opposite, else -1
    open: UInt8  # (positions,): 1 for candidates
    table: Int16 = np.zeros(0, np.int16)  # (positions * n,): the neighbourhood of each exemplar pixel
    jumps: Int32 = np.zeros((0, 0), np.int32)  # (positions, k - 1): similar pixels, -1 where there is none
    shown: Int32 = np.zeros(0, np.int32)  # (positions * G,): the guide of the exemplar, scaled
    asked: Int32 = np.zeros(0, np.int32)  # (H * W * G,): the target of each pixel of the map, scaled

    def positions(self, coords: Array) -> Int32:
        """Return the positions (H, W) of exemplar pixels (H, W, 2)."""
        return np.asarray((coords[..., 0] + self.border) * self.stride + coords[..., 1] + self.border, np.int32)

    def pixels(self, positions: Int32) -> Int32:
        """Return the exemplar pixels (H, W, 2) of positions (H, W)."""
        return np.stack(np.divmod(positions, np.int32(self.stride)), axis=2) - np.int32(self.border)

    def ready(self) -> StackLevel:
        """Return the level with its table, which is computed here if it was too large to be cached."""
        return self if len(self.table) else self._replace(table=table_of(self))


def table_of(level: StackLevel) -> Int16:
    """Return the neighbourhood of each exemplar pixel, as corrections compare it: (positions * n,)."""
    edge, taps, roots = level.border, range(-2, 3), level.roots
    if len(level.packed):  # four diagonal points, each predicted three times
        shown, taps, roots = unpacked_words(level.packed, level.stride), range(-1, 2, 2), np.full(4, 3 * 256)
    else:
        shown = level.values.reshape(-1, level.stride, level.values.shape[1])
    height, width, channels = shown.shape
    table = np.zeros((height, width, len(roots), channels), np.int16)
    inside = table[edge : height - edge, edge : width - edge]
    for k, (down, across) in enumerate(product(taps, taps)):
        y, x = edge + level.h * down, edge + level.h * across
        part = shown[y : y + inside.shape[0], x : x + inside.shape[1]].astype(np.int32)
        inside[:, :, k] = (part * roots[k]) >> 8
    return table.ravel()


@dataclass(frozen=True)
class ExemplarStack:
    """The levels of an exemplar, of spacing 1, 2, 4, ... px; `count` of them, the coarsest one a single pixel.

    ``levels``: those that can be corrected, finest first; 5 x 5 neighbourhoods of coarser ones exceed the exemplar.
    ``home``: for each pixel the nearest usable one, or empty if all are usable.
    """

    exemplar: Exemplar
    count: int
    levels: tuple[StackLevel, ...]
    home: Int32


@dataclass(frozen=True)
class ComparisonSettings:
    """Features and neighbourhoods of an exemplar that are compared.

    ``neighbourhood``: "appearance", or "colour" for plain 5 x 5 neighbourhoods, whose squared differences
    ``neighbourhood_mask`` weighs (25 numbers of 0 to 1, or None: a Gaussian, 1/4 at 2 px); ``k`` - 1 jumps for each
    pixel; with ``outlines`` the distance to them is compared as well.
    """

    channel_weights: tuple[float, ...] | None = None
    neighbourhood: str = "appearance"
    neighbourhood_mask: tuple[float, ...] | None = None
    k: int = 2
    outlines: Outlines | None = None

    @classmethod
    def of(cls, method: Any) -> ComparisonSettings:
        """Return the settings given by the fields of a method."""
        own = {name: getattr(method, name) for name in cls.__dataclass_fields__ if hasattr(method, name)}
        return cls(outlines=Outlines.of(method), **own)


def exemplar_stack(exemplar: Exemplar, look: ComparisonSettings, reach: int = 2) -> ExemplarStack:
    """Return the levels of an exemplar, computed once for all seeds and sizes, the same on every machine.

    ``reach``: how far beyond the exemplar corrections read, in units of a level's spacing.
    """
    known = look if look.outlines is None else replace(look, outlines=look.outlines.over(exemplar))
    return exemplar.memo(("sites", known, reach), partial(_stack, exemplar, known, reach))


def _stack(exemplar: Exemplar, look: ComparisonSettings, reach: int) -> ExemplarStack:
    picture = without_gaps(features([exemplar], look.channel_weights).pictures[0], exemplar)
    if look.outlines is not None:
        picture = np.concatenate([picture, look.outlines.channel(exemplar, picture)], axis=2)
    height, width, torus = exemplar.height, exemplar.width, exemplar.toroidal
    count = (max(height, width) - 1).bit_length() + 1
    corrected = sum(4 * (1 << n) + 1 <= min(height, width) for n in range(count))
    far, levels, cloudy = border_distances(exemplar), [], is_cloudy(exemplar)
    for number, blurred in enumerate(stack_of(picture, corrected, (torus, torus))):
        h = 1 << number
        closed = far <= border_left_out(h, far, cloudy)
        level = _compared(blurred, h, torus, look, closed, reach).ready()
        search = partial(jump_sets_of_grid, level, closed, torus, look.k - 1)
        jumps = jumps_of_all(exemplar.memo(("jumps", look, h), search), level)
        keep = level.table if corrected * level.table.nbytes <= KEPT else level.table[:0]
        levels.append(level._replace(table=keep, jumps=jumps))
    home = nearest(exemplar.free)
    flat = np.zeros(0, np.int32) if home is None else np.asarray(home[0] * width + home[1], np.int32).ravel()
    return ExemplarStack(exemplar, count, tuple(levels), flat)


def _compared(blurred: Array, h: int, torus: bool, look: ComparisonSettings, closed: Array, reach: int) -> StackLevel:
    """Return a level without its jumps and table."""
    (height, width, _), border = blurred.shape, reach * h
    packing: UInt64 = np.zeros((0, 2), np.uint64)
    values: Int16 = np.zeros((0, 1), np.int16)
    if look.neighbourhood == "appearance":
        packing = packed(bordered(transformed(blurred, h, torus), border, torus) + np.int16(MIDDLE))
    else:
        values = np.ascontiguousarray(bordered(((blurred + 8) >> 4).astype(np.int16), border, torus))
        values = values.reshape(-1, values.shape[2])
    stride, mask = width + 2 * border, look.neighbourhood_mask
    own = np.arange(border, border + height)[:, None] * stride + np.arange(border, border + width)
    inner = bordered(own, border, True) if torus else np.pad(own, border, constant_values=-1)
    roots = WEIGHTS if mask is None else np.rint(np.sqrt(mask) * 256).astype(np.int64)
    open_ = np.pad(~closed, border).astype(np.uint8).ravel()
    return StackLevel(h, border, stride, packing, values, roots, inner.astype(np.int32).ravel(), open_)


def levels_within(exemplar: Exemplar) -> int:
    """Return the number of levels whose spacing is at most a quarter of an element."""
    return (elements(exemplar).size // 4).bit_length()


def is_cloudy(exemplar: Exemplar) -> bool:
    """Return whether structures wider than 16 px make up 3/10 of the variance: clouds, stains, shades.

    Such textures need corrections on coarse levels.
    """
    return exemplar.memo("cloudy", partial(_cloudy, exemplar))


def _cloudy(exemplar: Exemplar) -> bool:
    if min(exemplar.height, exemplar.width) < 4 * CLOUDS:
        return False
    picture = without_gaps(features([exemplar], None).pictures[0], exemplar)
    first, *_, last = stack_of(picture, CLOUDS.bit_length(), (exemplar.toroidal, exemplar.toroidal))
    fine, coarse = (sum(scaled_variances(level.reshape(-1, picture.shape[2]))) for level in (first, last))
    return CLOUDY[1] * coarse >= CLOUDY[0] * fine > 0


def border_left_out(h: int, far: Array, cloudy: bool) -> int:
    """Return the width in px of the exemplar's border whose pixels are no candidates on a level of spacing `h`.

    Their neighbourhoods include mirrored pixels. `far`: from :func:`border_distances`. It is h, 2 at least; 2 h, which
    avoids all mirrored pixels, if the texture is cloudy; never more than a quarter of the largest distance. With 2 h
    the middle is used twice as often as on average, and the border hardly ever: 13 of 24 textures repeat a tenth more.
    With h / 4 the exemplar's straight border was visible as an edge in rock; with h it was not, and nearly as much of
    the exemplar is used. A least width of 1 or 4 px changes none (docs/design/012).
    """
    return min(2 * h if cloudy else max(2, h), int(far.max()) // 4)


def border_distances(exemplar: Exemplar) -> Array:
    """Return the chessboard distance of each pixel to what is unusable or outside: (H, W); 0 where unusable."""
    size, usable = (exemplar.height, exemplar.width), exemplar.free
    if exemplar.toroidal and usable.all():
        return np.full(size, 1 << 30)
    down, across = size if exemplar.toroidal else (1, 1)
    mode: Any = "wrap" if exemplar.toroidal else "constant"
    around = np.pad(usable, [(down, down), (across, across)], mode=mode)
    far = ndimage.distance_transform_cdt(around, metric="chessboard")
    return np.asarray(far[down : down + size[0], across : across + size[1]], np.int64)


def jump_spacing(h: int, height: int, width: int) -> int:
    """Return the spacing in px at which similar pixels are searched on a level of spacing `h`.

    At most 2 h + 1, so that continuations of jumps lie within the border, and at least h / 2.
    """
    least = math.isqrt(max(height * width - 1, 0) // SEARCHED) + 1
    return max(min(least, 2 * h + 1), h // 2)


def jumps_of_all(cells: Array, level: StackLevel) -> Int32:
    """Return the jumps of all pixels, as positions (positions, k - 1), from those of a grid (rows, columns, k - 1, 2).

    A pixel between grid pixels takes the continuation of their jump; -1 if that is outside.
    """
    edge, inner = level.border, level.inner.reshape(-1, level.stride)
    height, width = (n - 2 * edge for n in inner.shape)
    y, x, step = np.arange(height), np.arange(width), jump_spacing(level.h, height, width)
    to, jumps = cells[y // step][:, x // step], np.full((*inner.shape, cells.shape[2]), -1, np.int32)
    found = inner[to[..., 0] + (y % step + edge)[:, None, None], to[..., 1] + (x % step + edge)[:, None]]
    jumps[edge : edge + height, edge : edge + width] = np.where(to[..., 0] < 0, -1, found)
    return jumps.reshape(inner.size, -1)


def jump_sets_of_grid(level: StackLevel, closed: Array, toroidal: bool, count: int) -> Int32:
    """Return the `count` most similar pixels of each pixel of a grid: (rows, columns, count, 2) (y, x), or -1.

    ``closed`` (H, W): pixels that are no targets. Targets are at least 5 % of the exemplar, and h, from the pixel and
    from one another.
    """
    height, width = closed.shape
    step = jump_spacing(level.h, height, width)
    ys, xs = np.arange(0, height, step), np.arange(0, width, step)
    out = np.full((len(ys), len(xs), count), -1, np.int32)
    places = np.stack(np.meshgrid(ys, xs, indexing="ij"), axis=2).reshape(-1, 2).astype(np.int64)
    free = ~closed[places[:, 0], places[:, 1]]
    if count and free.any():
        at = (places[:, 0] + level.border) * level.stride + places[:, 1] + level.border
        vectors = level.table.reshape(len(level.inner), -1)[at]
        points = _points(vectors)
        order, own = np.arange(int(free.sum())), points[free]
        axis, cut = np.zeros((2, 4 * (len(order) // kd_tree.LEAF + 1)), np.int64)
        kd_tree.build(own, order, axis, cut)
        none = np.zeros((1, 1), np.int64)
        tree = kd_tree.Tree(own, order, axis, cut, none[0], none)
        limits = height, width, int(toroidal), max(2, round(APART * max(height, width)), level.h), LEAVES
        known = Similar(vectors.ravel(), np.uint64(vectors.shape[1]), places, free, limits)
        jump_sets(tree, points, known, ASKED * count, out)
    return np.where(out[..., None] < 0, np.int32(-1), places.astype(np.int32)[out])


def _points(vectors: Array) -> Array:
    """Return neighbourhoods (N, n) projected on their principal axes: (N, D) int32."""
    some = vectors[:: max(1, len(vectors) // SAMPLE)].astype(np.float64)
    axes = principal_axes(whole_products(some) / len(some), min(AXES, some.shape[1]))[1]
    return np.asarray(np.floor(vectors @ (np.rint(axes * 4096) / 4096).T), np.int32)  # sums in 1 / 4096, exact
