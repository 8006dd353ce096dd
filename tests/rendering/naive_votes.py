"""The slow obvious truth of rendering: every pixel, tap by tap, in whole numbers and fractions."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import floor, sqrt
from typing import Any

import numpy as np

from intarsia.foundation.blend import Mixing
from intarsia.foundation.geometry import ISOMETRIES
from intarsia.model import Exemplar
from intarsia.model.image import Kind, Plane
from intarsia.model.sourcemap import HOLE, SourceMap
from intarsia.rendering import from_linear, to_linear

Vote = tuple[int, int, int, int, int]  # exemplar, pose, row, column, weight


def clearance(exemplar: Exemplar, y: int, x: int, cap: int) -> int:
    """Measure the chessboard distance from a pixel to the nearest that must not be read, at most `cap`."""
    for d in range(cap):
        for yy in range(y - d, y + d + 1):
            for xx in range(x - d, x + d + 1):
                inside = 0 <= yy < exemplar.height and 0 <= xx < exemplar.width
                if not inside and not exemplar.toroidal:
                    return d
                if exemplar.usable is not None and not exemplar.usable[yy % exemplar.height, xx % exemplar.width]:
                    return d
    return cap


def votes(exemplars: Sequence[Exemplar], smap: SourceMap, f: int, y: int, x: int) -> Iterator[Vote]:
    """Yield the vote of every tap around (y, x)."""
    cap = -(-f // 2) + 1
    for ty in range(-(f // 2), -(-f // 2) + 1):
        for tx in range(-(f // 2), -(-f // 2) + 1):
            qy, qx = y + ty, x + tx
            my, mx = (qy % smap.height if smap.wrap.y else qy), (qx % smap.width if smap.wrap.x else qx)
            if not (0 <= my < smap.height and 0 <= mx < smap.width):
                continue
            w = 0 if smap.which is None else int(smap.which[my, mx])
            if w == HOLE:
                continue
            pose = 0 if smap.pose is None else int(smap.pose[my, mx])
            (a, b), (c, d) = ISOMETRIES[pose].j
            u = int(smap.yx[my, mx, 0]) - a * ty - b * tx
            v = int(smap.yx[my, mx, 1]) - c * ty - d * tx
            e = exemplars[w]
            if e.toroidal:
                u, v = u % e.height, v % e.width
            if 0 <= u < e.height and 0 <= v < e.width:
                t = clearance(e, u, v, cap)
                if t:
                    yield w, pose, u, v, t


def turn(plane: Plane, vector: Sequence[Any], pose: int) -> tuple[Any, Any, Any]:
    """Turn a vector (red, green, blue) with its piece: the slope of the height pulls back by J transposed."""
    down = 1 if plane.meta.get("normals", "gl") == "dx" else -1
    n_x, n_y = vector[0], down * vector[1]
    (a, b), (c, d) = ISOMETRIES[pose].j
    return b * n_y + d * n_x, down * (a * n_y + c * n_x), vector[2]


def decode(plane: Plane, code: Any, signed: bool = False) -> Fraction:
    """Return a stored normal component as a fraction of the unit."""
    if plane.is_float:
        return Fraction(float(code)) if signed else 2 * Fraction(float(code)) - 1
    return Fraction(2 * int(code), int(np.iinfo(plane.pixels.dtype).max)) - 1


def encode(plane: Plane, value: float, signed: bool = False) -> Any:
    """Store a normal component."""
    if plane.is_float:
        return plane.pixels.dtype.type(value if signed else (value + 1) / 2)
    return floor((value + 1) / 2 * np.iinfo(plane.pixels.dtype).max + 0.5)


def own_pixel(planes: Sequence[Plane], smap: SourceMap, y: int, x: int) -> Any:
    """Return the exemplar pixel of a map pixel, turned."""
    w = 0 if smap.which is None else int(smap.which[y, x])
    pose = 0 if smap.pose is None else int(smap.pose[y, x])
    code = planes[w].samples[tuple(smap.yx[y, x])]
    if planes[0].kind is not Kind.NORMAL:
        return code
    return np.array([encode(planes[0], float(v)) for v in turn(planes[0], [decode(planes[0], c) for c in code], pose)])


class NaiveRenderer:
    """Renders planes of the map's own size."""

    def __init__(self, exemplars: Sequence[Exemplar], smap: SourceMap, feather: int, mixing: Mixing = Mixing.MEAN):
        self.exemplars, self.smap, self.feather, self.mixing = exemplars, smap, feather, mixing
        self.planes = [e.base for e in exemplars]
        self.plane = self.planes[0]
        plain = mixing is Mixing.SOURCE or self.plane.kind is not Kind.COLOUR
        self.light = [p.samples if plain else to_linear(p) for p in self.planes]
        self.plain = plain or self.plane.transfer == "linear"

    def render(self) -> np.ndarray:
        """Return the codes (H, W, C)."""
        out = np.zeros((self.smap.height, self.smap.width, self.plane.channels), self.plane.pixels.dtype)
        for y in range(self.smap.height):
            for x in range(self.smap.width):
                out[y, x] = self.pixel(y, x)
        return out

    def pixel(self, y: int, x: int) -> Any:
        """Return the codes (C,) of a pixel."""
        heard: dict[tuple[int, int, int, int], int] = defaultdict(int)
        if self.feather:
            for w, pose, u, v, weight in votes(self.exemplars, self.smap, self.feather, y, x):
                heard[w, pose, u, v] += weight
        if not heard:
            return own_pixel(self.planes, self.smap, y, x)
        if self.plane.kind is Kind.LABEL:
            return self.label(heard)
        if self.plane.kind is Kind.NORMAL:
            return self.normal(heard, y, x)
        codes = [self.planes[w].samples[u, v] for w, _, u, v in heard]
        if all((c == codes[0]).all() for c in codes):
            return codes[0]
        light = [[Fraction(c.item()) for c in self.light[w][u, v]] for w, _, u, v in heard]
        weights = [Fraction(n) for n in heard.values()]
        if not self.plane.alpha:
            return self.coded(self.mean(light, weights))
        alpha = [max(c[-1], Fraction(0)) for c in light]
        shares = [w * a for w, a in zip(weights, alpha, strict=True)] if any(alpha) else weights
        opacity = sum(w * v[-1] for w, v in zip(weights, light, strict=True)) / sum(weights)
        return self.coded([*self.mean(light, shares)[:-1], opacity])

    def mean(self, light: list[list[Fraction]], weights: list[Fraction]) -> list[Any]:
        return [sum(w * v[c] for w, v in zip(weights, light, strict=True)) / sum(weights) for c in range(len(light[0]))]

    def coded(self, mean: list[Any]) -> Any:
        """Code a mean; integers in light are cut off, the steps of the curve round."""
        if self.plane.is_float:
            values = np.array([[[float(v) for v in mean]]])
            return (values if self.plain else from_linear(values, self.plane))[0, 0]
        n = len(mean) - self.plane.alpha
        halves = [floor(v) if not self.plain and i < n else floor(v + Fraction(1, 2)) for i, v in enumerate(mean)]
        return np.array(halves) if self.plain else from_linear(np.array([[halves]]), self.plane)[0, 0]

    def label(self, heard: dict[tuple[int, int, int, int], int]) -> Any:
        """Return the label with the largest weight, the smallest of equals."""
        counts: dict[tuple[Any, ...], int] = defaultdict(int)
        for (w, _, u, v), weight in heard.items():
            counts[tuple(self.planes[w].samples[u, v].tolist())] += weight
        return min(counts, key=lambda name: (-counts[name], name))

    def normal(self, heard: dict[tuple[int, int, int, int], int], y: int, x: int) -> Any:
        """Return the mean vector, made unit length again."""
        signed = any(p.is_float and bool((p.pixels < 0).any()) for p in self.planes)
        turned = [
            turn(self.plane, [decode(self.plane, c, signed) for c in self.planes[w].samples[u, v]], pose)
            for w, pose, u, v in heard
        ]
        if all(t == turned[0] for t in turned):
            return np.array([encode(self.plane, float(v), signed) for v in turned[0]])
        total = [sum(w * t[c] for w, t in zip(heard.values(), turned, strict=True)) for c in range(3)]
        length = sqrt(sum(float(v) ** 2 for v in total))
        if length == 0:
            return own_pixel(self.planes, self.smap, y, x)
        return np.array([encode(self.plane, float(v) / length, signed) for v in total])


def pieces(smap: SourceMap) -> np.ndarray:
    """Number the connected pieces by flooding from every pixel in turn."""
    which = np.zeros(smap.yx.shape[:2], int) if smap.which is None else smap.which.astype(int)
    pose = np.zeros(smap.yx.shape[:2], int) if smap.pose is None else smap.pose.astype(int)
    labels = np.full(which.shape, -1)
    count = 0
    for start in np.ndindex(which.shape):
        if labels[start] >= 0:
            continue
        labels[start] = count
        todo = [start]
        while todo:
            y, x = todo.pop()
            for ey, ex in ((0, 1), (1, 0), (0, -1), (-1, 0)):
                n = (y + ey, x + ex)
                if not (0 <= n[0] < which.shape[0] and 0 <= n[1] < which.shape[1]) or labels[n] >= 0:
                    continue
                (a, b), (c, d) = ISOMETRIES[pose[y, x]].j
                step = (a * ey + b * ex, c * ey + d * ex)
                goes_on = tuple(smap.yx[n] - smap.yx[y, x]) == step and pose[n] == pose[y, x]
                if which[n] == which[y, x] and (goes_on or which[n] == HOLE):
                    labels[n] = count
                    todo.append(n)
        count += 1
    return labels
