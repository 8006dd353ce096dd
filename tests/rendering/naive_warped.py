"""The slow obvious truth of maps with frames: every pixel, reading by reading, tap by tap, in floats."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor, hypot, sqrt
from typing import Any

import numpy as np
from rendering.naive_votes import decode, encode

from intarsia.foundation.geometry import ISOMETRIES
from intarsia.model import Exemplar
from intarsia.model.image import Kind
from intarsia.model.sourcemap import HOLE, SourceMap
from intarsia.rendering import from_linear, to_linear

Frame = tuple[tuple[float, float], tuple[float, float]]
Place = tuple[float, float]
Tap = tuple[tuple[int, int], float, float]


def cubic(t: float) -> float:
    """Catmull-Rom: the weight of a pixel at a distance of t px."""
    t = abs(t)
    if t < 1:
        return 1.5 * t**3 - 2.5 * t**2 + 1
    return -0.5 * t**3 + 2.5 * t**2 - 4 * t + 2 if t < 2 else 0.0


def linear(t: float) -> float:
    """Return the weight of a pixel at a distance of t px, where reading is bilinear."""
    return max(0.0, 1.0 - abs(t))


def frame_of(smap: SourceMap, y: int, x: int) -> Frame:
    if smap.frame is None:
        return ISOMETRIES[0 if smap.pose is None else smap.pose[y, x]].j
    (a, b), (c, d) = smap.frame[y, x].astype(float)
    return (a, b), (c, d)


def times(j: Frame, d: Place) -> Place:
    return j[0][0] * d[0] + j[0][1] * d[1], j[1][0] * d[0] + j[1][1] * d[1]


def resolve(e: Exemplar, y: int, x: int) -> tuple[int, int]:
    """Return the pixel itself, the one that stands for it on the torus, or the nearest one inside."""
    if e.toroidal:
        return y % e.height, x % e.width
    return min(max(y, 0), e.height - 1), min(max(x, 0), e.width - 1)


def free(e: Exemplar, at: tuple[int, int]) -> bool:
    return e.usable is None or bool(e.usable[at])


def around(e: Exemplar, u: Place) -> list[Tap]:
    """List the pixels around a place, with their weights by Catmull-Rom and in a 2 x 2 alone."""
    y, x = floor(u[0]), floor(u[1])
    found = []
    for i in range(y - 1, y + 3):
        for k in range(x - 1, x + 3):
            weight = cubic(u[0] - i) * cubic(u[1] - k)
            if weight != 0:
                found.append((resolve(e, i, k), weight, linear(u[0] - i) * linear(u[1] - k)))
    return found


class NaiveWarped:
    """Draws planes of the map's own size."""

    def __init__(self, exemplars: Sequence[Exemplar], smap: SourceMap):
        self.exemplars, self.smap = exemplars, smap
        self.planes = [e.base for e in exemplars]
        self.plane = self.planes[0]
        self.plain = self.plane.kind is not Kind.COLOUR or self.plane.transfer == "linear"
        self.signed = any(p.is_float and bool((p.pixels < 0).any()) for p in self.planes)
        self.light = [(p.samples if self.plain else to_linear(p)).astype(np.float64) for p in self.planes]

    def render(self) -> np.ndarray:
        """Return the codes (H, W, C)."""
        out = np.zeros((self.smap.height, self.smap.width, self.plane.channels), self.plane.pixels.dtype)
        draw = {Kind.LABEL: self.label, Kind.NORMAL: self.normal}.get(self.plane.kind, self.colour)
        for y, x in np.ndindex(out.shape[:2]):
            out[y, x] = draw(*self.read_at(y, x))
        return out

    def read_at(self, y: int, x: int) -> tuple[int, Frame, Place, tuple[int, int]]:
        """Return exemplar, frame, place and own pixel of (y, x)."""
        smap, own = self.smap, (int(self.smap.yx[y, x, 0]), int(self.smap.yx[y, x, 1]))
        aside = (0.0, 0.0) if smap.sub is None else smap.sub[y, x].astype(float)
        w = 0 if smap.which is None else int(smap.which[y, x])
        return w, frame_of(smap, y, x), (own[0] + aside[0], own[1] + aside[1]), own

    def readings(self, j: Frame, u: Place) -> list[Place]:
        """Return the places that are averaged over the footprint of a pixel."""
        n, spread = [], []
        for axis in (0, 1):
            step = hypot(j[0][axis], j[1][axis])
            n.append(1 if step <= 1 + 1 / 64 else min(4, ceil(step - 1 / 64)))
            spread.append(0.0 if step <= 1 + 1 / 64 else min(1.0, 2 - 2 / step))
        out = []
        for i in range(n[0]):
            for k in range(n[1]):
                step = times(j, (((i + 0.5) / n[0] - 0.5) * spread[0], ((k + 0.5) / n[1] - 0.5) * spread[1]))
                out.append((u[0] + step[0], u[1] + step[1]))
        return out

    def nearest(self, w: int, u: Place, own: tuple[int, int]) -> tuple[int, int]:
        at = resolve(self.exemplars[w], floor(u[0] + 0.5), floor(u[1] + 0.5))
        return at if free(self.exemplars[w], at) else own

    def taps(self, w: int, r: Place, u: Place, own: tuple[int, int]) -> list[Tap]:
        """Return the pixels of one reading: 4 x 4, or what may be read of 2 x 2, or one."""
        e = self.exemplars[w]
        found = around(e, r)
        if all(free(e, at) for at, _, _ in found):
            return found
        square = [(at, flat) for at, _, flat in found if free(e, at) and flat > 0]
        total = sum(flat for _, flat in square)
        return [(at, f / total, f / total) for at, f in square] or [(self.nearest(w, u, own), 1.0, 1.0)]

    def colour(self, w: int, j: Frame, u: Place, own: tuple[int, int]) -> Any:
        """Return the mean of all readings; colours count by their opacity where there is any."""
        seen, plain, opaque, codes = 0.0, 0.0, 0.0, []
        places = self.readings(j, u)
        for r in places:
            taps, share = self.taps(w, r, u, own), 1 / len(places)
            codes += [self.planes[w].samples[at] for at, _, _ in taps]
            light = np.array([self.light[w][at] for at, _, _ in taps])
            smooth, flat = (np.array([tap[k] for tap in taps]) for k in (1, 2))
            mean = np.clip(smooth @ light, light.min(axis=0), light.max(axis=0))
            a = np.maximum(light[:, -1], 0)
            if self.plane.alpha and len(set(light[:, -1])) > 1:
                mean[:-1] = (flat @ light)[:-1]
                seen, opaque = seen + share * (flat * a) @ light, opaque + share * float(flat @ a)
            else:
                seen, opaque = seen + share * float(a[0]) * mean, opaque + share * float(a[0])
            plain = plain + share * mean
        if all((c == codes[0]).all() for c in codes):
            return codes[0]
        if self.plane.alpha and opaque > 0:
            plain[:-1] = (seen / opaque)[:-1]
        return self.coded(plain)

    def coded(self, light: Any) -> Any:
        """Code light; of integers the colours are cut off, as the steps of the curve round."""
        if self.plain:
            return light if self.plane.is_float else np.floor(light + 0.5)
        if not self.plane.is_float:
            colours = light.size - self.plane.alpha
            light[:colours] = np.floor(light[:colours])
        return from_linear(light.reshape(1, 1, -1), self.plane)[0, 0]

    def label(self, w: int, _: Frame, u: Place, own: tuple[int, int]) -> Any:
        """Return the label of the nearest pixel."""
        return self.planes[w].samples[self.nearest(w, u, own)]

    def normal(self, w: int, j: Frame, u: Place, own: tuple[int, int]) -> Any:
        """Return the mean of all readings, turned by the frame: slopes pull back by J transposed."""
        down, v = 1 if self.plane.meta.get("normals", "gl") == "dx" else -1, np.zeros(3)
        places = self.readings(j, u)
        for r in places:
            for at, weight, _ in self.taps(w, r, u, own):
                code = self.planes[w].samples[at]
                v += weight / len(places) * np.array([float(decode(self.plane, c, self.signed)) for c in code])
        n_y, n_x = down * v[1], v[0]
        turned = np.array([j[0][1] * n_y + j[1][1] * n_x, down * (j[0][0] * n_y + j[1][0] * n_x), v[2]])
        return np.array([encode(self.plane, c / sqrt(turned @ turned), self.signed) for c in turned])


def flowing_pieces(smap: SourceMap) -> np.ndarray:
    """Number the pieces by flooding: neighbours within 1 px of where the mean of their frames leads."""
    which = np.zeros(smap.yx.shape[:2], int) if smap.which is None else smap.which.astype(int)
    labels, count = np.full(which.shape, -1), 0

    def goes_on(a: tuple[int, int], b: tuple[int, int]) -> bool:
        if which[a] != which[b] or which[a] == HOLE:
            return bool(which[a] == which[b])
        if smap.pose is not None and smap.pose[a] != smap.pose[b]:
            return False
        j = (np.array(frame_of(smap, *a)) + np.array(frame_of(smap, *b))) / 2
        at = [smap.yx[p] + (0 if smap.sub is None else smap.sub[p].astype(float)) for p in (a, b)]
        return bool((np.abs(at[1] - at[0] - j @ (np.array(b) - a)) <= 1).all())

    for start in np.ndindex(which.shape):
        if labels[start] >= 0:
            continue
        labels[start], todo = count, [start]
        while todo:
            y, x = todo.pop()
            for n in ((y, x + 1), (y + 1, x), (y, x - 1), (y - 1, x)):
                inside = 0 <= n[0] < which.shape[0] and 0 <= n[1] < which.shape[1]
                if inside and labels[n] < 0 and goes_on((y, x), n):
                    labels[n] = count
                    todo.append(n)
        count += 1
    return labels
