"""Whole elements of an exemplar: stones, fruit, plates, whatever has an outline all round and is quiet inside.

The picture is flooded into basins between its edges, or its dark or bright joints; the basins merge, the weakest border
first. Of all nodes of that tree those are elements that look most like whole bodies: a strong outline that is closed,
nothing as strong inside, filled like an ellipse, and neither far smaller nor far larger than the elements that the
autocorrelation tells of. No two share a pixel. Sand, bark and cloth have none.

Source: our own, after the watershed and its hierarchies (Beucher and Meyer 1993; Najman and Schmitt 1996).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..analysis.features import features
from ..analysis.popout import USUAL, popout
from ..arrays import Array, Floats, Int32, Int64, Pair, UInt8
from ..exemplar import Exemplar
from ..kernels.pieces_of_maps import boxes_of_parts, parts
from ..lazy import ndimage
from ..search import sizes
from . import basins_kernels
from .feature_group import edge_pixels
from .felzenszwalb import even_colours, smoothed

Labels = Int32


class Bounds(NamedTuple):
    """What makes a thing: set by eye on ten photographs, where leaves, tufts, dark pebbles and chips were found."""

    sure: int = 5 * USUAL // 2  # a thing strikes so much somewhere,
    edges: tuple[int, ...] = (512, 768, 1024, 1536, 2048, 3072, 4096)  # and the first of these at which it is compact,
    steep: Pair = (2, 4)  # but for the first, its most is so many times that: a line is no row of things
    least: int = 20  # px: smaller ones are grain
    widest: int = 4  # it is no longer than the exemplar's shorter side through this
    share: int = 10  # %: so much of an exemplar at most is things, those that strike most


BOUNDS = Bounds()


class Things(NamedTuple):
    """What strikes in an exemplar.

    Attributes
    ----------
    labels : int32 array, shape (H, W)
        The number of the thing that a pixel belongs to, from 1, those that strike most first; 0: none.
    areas : int64 array, shape (n,)
        Pixels of each, in their order.
    peaks : int64 array, shape (n,)
        How much each strikes where it strikes most, in 1/256; at least 640.
    strikes : int32 array, shape (H, W)
        How much every pixel strikes, in 1/256 of what is usual.
    """

    labels: Labels
    areas: Int64
    peaks: Int64
    strikes: Int32


class Strength(NamedTuple):
    """A thing among others: less what it strikes in all, its number so far, pixels, and what it strikes at most."""

    less: int
    number: int
    area: int
    peak: int


def things(exemplar: Exemplar) -> Things:
    """Find the things of an exemplar that strike, by how far their look is from that of all others (see `popout`)."""
    return exemplar.memo("things", lambda: _things(exemplar))


def _things(exemplar: Exemplar) -> Things:
    if exemplar.usable is not None and not exemplar.usable.any():
        nothing = np.zeros((exemplar.height, exemplar.width), np.int32)
        return Things(nothing, np.zeros(0, np.int64), np.zeros(0, np.int64), nothing)
    made = features([exemplar])
    strikes = popout(made.pictures[0][:, :, : made.base], exemplar.usable, exemplar.toroidal)
    out, strength = np.zeros(strikes.shape, np.int32), list[Strength]()
    for edge in BOUNDS.edges:
        _add(np.where(out == 0, strikes, 0), edge, exemplar, out, strength)
    names, known, room = np.zeros(len(strength) + 1, np.int32), list[Strength](), out.size * BOUNDS.share // 100
    for one in sorted(strength):
        if one.area <= room:
            room -= one.area
            known.append(one)
            names[one.number] = len(known)
    areas, peaks = ([one[k] for one in known] for k in (2, 3))
    return Things(names[out], np.array(areas, np.int64), np.array(peaks, np.int64), strikes)


def _add(strikes: Array, edge: int, exemplar: Exemplar, out: Labels, strength: list[Strength]) -> None:
    """Number the things that strike so much everywhere, after those that are known."""
    part, wrap = np.empty(strikes.shape, np.int32), (exemplar.toroidal, exemplar.toroidal)
    box = np.empty((parts((strikes >= edge).astype(np.int32), wrap, part), 5), np.int64)
    boxes_of_parts(part, wrap, box)
    mine, strong, top = part[part > 0], strikes[part > 0], np.zeros(len(box) + 1, np.int64)
    np.maximum.at(top, mine, strong)
    total = np.bincount(mine, np.maximum(strong - BOUNDS.edges[0], 0), len(box) + 1).astype(np.int64)
    least = BOUNDS.sure if edge == BOUNDS.edges[0] else BOUNDS.steep[0] * edge
    fits = (top[1:] >= least) & (top[1:] <= BOUNDS.steep[1] * edge) & (box[:, 4] >= BOUNDS.least)
    fits &= BOUNDS.widest * box[:, 2:4].max(axis=1, initial=0) <= min(strikes.shape)
    names = np.zeros(len(box) + 1, np.int32)
    for k in np.flatnonzero(fits).tolist():
        strength.append(Strength(-int(total[k + 1]), len(strength) + 1, int(box[k, 4]), int(top[k + 1])))
        names[k + 1] = len(strength)
    np.maximum(out, names[part], out=out)


UNIT, JOINT = 64, 128  # as the kernels of seams read them: depth 0..64, and from JOINT on how sure a joint is


class Shape(NamedTuple):
    """What counts as an element: chosen by eye on 20 textures, none halved and doubled yet."""

    blurs: tuple[float, ...] = (0.02, 0.05)  # of an element: sigma
    strong: float = 0.4  # of the strongest edges: an outline is where at least so much is
    thin: float = 0.13  # of an element: joints are no wider than twice this
    small: float = 0.22  # of an element, at least the root of the area
    large: float = 2.2  # at most
    least: float = 0.06  # score of an element
    level: float = 0.125  # score of the picture: below, there are no elements
    pixels: int = 500  # of the usual element; at 400 scales of 21 px get hairlines, at 200 pebbles gain nothing
    usual: float = 0.34  # of an element: root of the area of the usual one
    sure: float = 0.3  # from this score on an element is sure
    rest: float = 0.5  # how sure what no element holds is
    deep: float = 0.35  # of the root of the usual area: as deep as it gets


SHAPE = Shape()


@dataclass(frozen=True, eq=False)
class Wholes:
    """The elements of an exemplar.

    Attributes
    ----------
    labels : int32 array, shape (H, W)
        Element of every pixel, 1, 2, ...; 0 where there is none.
    sure : float array, shape (n + 1,)
        How sure each is, 0..1.
    inside : uint8 array, shape (H, W)
        How deep inside an element a pixel lies, 0..64; in joints 128 and how sure they are, 0..64.
    """

    labels: Int32
    sure: Floats
    inside: UInt8


class Tree(NamedTuple):
    """Basins and what they merge to; the nodes' sums are those of `basins_kernels`."""

    labels: Array
    kids: Array
    facts: Array
    outline: Array
    inner: Array


def wholes(exemplar: Exemplar) -> Wholes | None:
    """Return the elements of an exemplar, found once; None where it has none, or they are too small."""
    return exemplar.memo("wholes", lambda: _found(exemplar))


def _found(exemplar: Exemplar) -> Wholes | None:
    feats = features([exemplar])
    picture = feats.pictures[0][:, :, : feats.base]
    colours, shorter = even_colours(picture, exemplar.usable), min(picture.shape[:2])
    if colours is None or shorter < 32:
        return None
    size = min(float(sizes.elements(exemplar).size), 0.3 * shorter)
    best: tuple[float, Array, Array, Array] | None = None
    for blur in SHAPE.blurs:
        soft = smoothed(colours, max(1, round(2 * max(0.8, blur * size) ** 2)))
        for relief in reliefs(soft, size):
            tree = tree_of(relief, soft, size)
            total, labels, scores = _chosen(tree, _scores(tree, size))
            if best is None or total > best[0]:
                best = total, labels, scores, relief
    assert best is not None
    total, labels, scores, relief = best
    area = np.bincount(labels.ravel())[1:]
    if total < SHAPE.level or not len(area) or np.median(area) < max(SHAPE.pixels, (SHAPE.usual * size) ** 2):
        return None
    inside = _inside(labels, scores, relief, math.sqrt(float(np.median(area))))
    return Wholes(labels.astype(np.int32), np.minimum(scores / SHAPE.sure, 1.0), inside)


def reliefs(soft: Array, size: float) -> list[Array]:
    """Return what may be outlines, 0 to about 330: edges, dark joints, bright joints; of even colours (H, W, C)."""
    p = np.pad(soft, ((1, 1), (1, 1), (0, 0)), "edge").astype(np.int64)
    down, right = p[2:, 1:-1] - p[:-2, 1:-1], p[1:-1, 2:] - p[1:-1, :-2]
    edges = _shares(np.sqrt((down * down + right * right).sum(axis=2).astype(np.float64)))
    light = soft.sum(axis=2)
    side = 2 * int(min(max(round(size * SHAPE.thin), 2), 13)) + 1
    dark = _shares(ndimage.grey_closing(light, (side, side), mode="nearest") - light)
    bright = _shares(light - ndimage.grey_opening(light, (side, side), mode="nearest"))
    mixed = (0.35 * edges + 0.65 * joints for joints in (dark, bright))
    return [np.rint(relief * 256).astype(np.int64) for relief in (edges, *mixed)]


def _shares(values: Array) -> Array:
    """Parts of what 95 % of all are at most, 1.3 at most."""
    ranked = np.sort(values, axis=None)[int(0.95 * (values.size - 1))]
    return np.asarray(np.minimum(values.astype(np.float64) / max(float(ranked), 1e-9), 1.3))


def basins(relief: Array) -> Int64:
    """Number (H, W) the basins of a relief: every px flows to its lowest neighbour; of equals the first is lowest."""
    number = np.arange(relief.size).reshape(relief.shape)
    lowest = ndimage.minimum_filter(relief * np.int64(relief.size) + number, 3, mode="nearest")
    to = lowest.ravel() % relief.size
    while (to != to[to]).any():
        to = to[to]
    return np.asarray((np.cumsum(to == number.ravel()) - 1)[to].reshape(relief.shape), np.int64)


def borders(relief: Array, labels: Int64) -> tuple[Int64, Int64]:
    """Pairs of basins that touch, (n, 2), and of each border: strength, length, length where strong, (n, 3)."""
    count, keys, power = int(labels.max()) + 1, [], []
    for one, two in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        a, b = labels[one], labels[two]
        keys.append((np.minimum(a, b) * count + np.maximum(a, b))[a != b])
        power.append(np.maximum(relief[one], relief[two])[a != b])
    strengths = np.concatenate(power)
    pairs, border = np.unique(np.concatenate(keys), return_inverse=True)
    parts = (strengths, np.ones_like(strengths), strengths > round(SHAPE.strong * 256))
    values = np.stack([np.bincount(border, part) for part in parts], axis=1).astype(np.int64)
    return np.stack(np.divmod(pairs, count), axis=1), values


def tree_of(relief: Array, soft: Array, size: float) -> Tree:
    """Flood a relief (H, W), and merge its basins by borders and colours (H, W, C)."""
    h, w = relief.shape
    labels = basins(smoothed(relief[..., None].astype(np.int32) * 16, 1)[..., 0])
    n = int(labels.max()) + 1
    flat = labels.ravel()
    y, x = (a.ravel() for a in np.mgrid[:h, :w])
    rim = np.zeros((h, w), np.int64)
    for axis in (0, 1):
        np.moveaxis(rim, axis, 0)[[0, -1]] += 1
    facts = np.zeros((2 * n - 1, basins_kernels.FACTS), np.int64)
    for k, values in enumerate((np.ones_like(y), y, x, y * y, x * x, x * y, rim.ravel())):
        facts[:n, k] = np.bincount(flat, values, n)
    colours = np.zeros((2 * n - 1, soft.shape[2]), np.float64)
    for k in range(soft.shape[2]):
        colours[:n, k] = np.bincount(flat, soft[..., k].ravel(), n)
    pairs, values = borders(relief, labels)
    kids, outline = np.full((2 * n - 1, 2), -1, np.int64), np.zeros((2 * n - 1, 3), np.int64)
    inner = np.zeros(2 * n - 1)
    c = soft.reshape(-1, soft.shape[2]).astype(np.int64)
    spread = int((len(c) * (c * c).sum(axis=0) - c.sum(axis=0) ** 2).sum())
    nodes = basins_kernels.Nodes(facts, colours, kids, outline, inner)
    basins_kernels.merge(pairs, values, nodes, math.sqrt(spread) / len(c), (0.3 * size) ** 2)
    return Tree(labels, kids, facts, outline, inner / 256)


def _scores(tree: Tree, size: float) -> Array:
    """How much each node looks like a whole body, 0..1."""
    area, y, x, high, wide, slant, rim = tree.facts.T.astype(np.float64)
    y, x = y / area, x / area
    high, wide, slant = high / area - y * y + 1 / 12, wide / area - x * x + 1 / 12, slant / area - x * y
    ellipse = area / (4 * math.pi * np.sqrt(np.maximum(high * wide - slant * slant, 1e-9)))
    length = np.maximum(tree.outline[:, 1], 1)
    strength, closed = 0.85 * tree.outline[:, 0] / length / 256, tree.outline[:, 2] / length
    inner = 0.75 * tree.inner
    quiet = np.clip((strength - inner) / (strength + inner + 1e-9), 0, 1)
    full, tall = np.clip((ellipse - 0.70) / 0.2, 0, 1), np.clip(np.sqrt(area) / (0.5 * size), 0, 1)
    fits = (area >= (SHAPE.small * size) ** 2) & (area <= (SHAPE.large * size) ** 2)
    fits &= (rim < tree.outline[:, 1]) & (tree.outline[:, 1] >= 6)
    return np.where(fits, closed * closed * full * quiet * tall, 0)


def _chosen(tree: Tree, score: Array) -> tuple[float, Array, Array]:
    """Of all sets of nodes that share no pixel that with most score by area: score in all, labels, scores."""
    name, scores = np.empty(len(score), np.int64), np.empty(len(score) + 1)
    area = tree.facts[:, basins_kernels.AREA].copy()
    total, count = basins_kernels.choose(tree.kids, area, score, SHAPE.least, name, scores)
    return float(total) / tree.labels.size, np.maximum(name, 0)[tree.labels], scores[:count]


def _inside(labels: Array, scores: Array, relief: Array, side: float) -> UInt8:
    edge = edge_pixels(labels) | ((labels == 0) & (relief > SHAPE.strong * 256 * 1.25))
    deep = max(SHAPE.deep * side, 4.0)
    depth = ndimage.distance_transform_edt(~edge) if edge.any() else np.full(edge.shape, np.inf)
    sure = np.clip(scores / 0.35, 0, 1)[labels]
    sure[labels == 0] = SHAPE.rest
    inside = np.rint(UNIT * np.clip((depth - 1) / deep, 0, 1) * sure)
    joint = np.clip((ndimage.maximum_filter(relief, 3) / 256 - SHAPE.strong) / SHAPE.strong, 0, 1)
    between = (labels == 0) & (depth < 5)
    joint = np.rint(UNIT * np.where(between, np.maximum(joint, 0.7), joint * (depth <= 1)))
    return np.where((joint > 0) & (joint > inside), JOINT + joint, inside).astype(np.uint8)
