"""Slow, obvious versions of the methods that grow pixel by pixel, written from their descriptions alone.

Nothing here is shared with the kernels but the features and the draws; distances are sums of Python integers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from naive import Posed, posed
from numpy.typing import NDArray

from intarsia.foundation.geometry import Wrap
from intarsia.foundation.run import below, draw
from intarsia.model import Exemplar

Pixel = tuple[int, int, int]  # variant, row, column of a posed exemplar
Tap = tuple[int, int]


@dataclass
class Ground:
    """A posed exemplar at some level: what is compared, and what may be used."""

    own: NDArray[np.int64]
    usable: NDArray[np.bool_]
    toroidal: bool
    coarse: NDArray[np.int64] | None = None  # the coarser level, repeated

    def holds(self, y: int, x: int, box: tuple[int, int, int, int]) -> bool:
        """Whether all pixels up to (up, left, down, right) px around (y, x) exist and may be used."""
        height, width = self.usable.shape
        for a in range(y - box[0], y + box[2] + 1):
            for b in range(x - box[1], x + box[3] + 1):
                if not self.toroidal and not (0 <= a < height and 0 <= b < width):
                    return False
                if not self.usable[a % height, b % width]:
                    return False
        return True

    def at(self, y: int, x: int, coarse: bool = False) -> list[int]:
        picture = self.coarse if coarse else self.own
        assert picture is not None
        return [int(v) for v in picture[y % picture.shape[0], x % picture.shape[1]]]

    def places(self, v: int, box: tuple[int, int, int, int]) -> list[Pixel]:
        """All pixels that such a neighbourhood fits, by the first pixel of its box."""
        height, width = self.usable.shape
        inside = range(height), range(width)
        found = [
            ((y - box[0]) % height if self.toroidal else y, (x - box[1]) % width if self.toroidal else x, y, x)
            for y in inside[0]
            for x in inside[1]
            if self.holds(y, x, box)
        ]
        return [(v, y, x) for _, _, y, x in sorted(found)]


def squared(a: Sequence[int], b: Sequence[int]) -> int:
    return sum((p - q) ** 2 for p, q in zip(a, b, strict=True))


def of_posed(variants: Sequence[Posed]) -> list[Ground]:
    return [Ground(p.picture.astype(np.int64), p.usable, p.toroidal) for p in variants]


@dataclass
class NaiveEfrosLeung:
    """Layer by layer: the pixels with most known ones in their windows first, each drawn among similar places."""

    exemplars: Sequence[Exemplar]
    size: tuple[int, int]
    window: tuple[int, int]
    seed: int
    wrap: Wrap = Wrap.NONE
    isometries: Sequence[int] = (0,)
    tolerance: float = 0.1
    stage: int = 1999
    shown: dict[tuple[int, int], Pixel] = field(default_factory=dict)

    def run(self) -> dict[tuple[int, int], Pixel]:
        self.variants = posed(self.exemplars, self.isometries)
        self.grounds = of_posed(self.variants)
        up, side = self.window[0] // 2, self.window[1] // 2
        box = (up, side, up, side)
        self.every = [p for v, g in enumerate(self.grounds) for p in g.places(v, box)]
        self.taps = [(y, x) for y in range(-up, up + 1) for x in range(-side, side + 1) if (y, x) != (0, 0)]
        self.near = [(y, x) for y in (-1, 0, 1) for x in (-1, 0, 1)]
        if not self.shown:
            v, y, x = self.every[below(len(self.every), draw(self.seed, self.stage, 2))]
            for dy, dx in self.near:
                at = self.size[0] // 2 + dy, self.size[1] // 2 + dx
                if 0 <= at[0] < self.size[0] and 0 <= at[1] < self.size[1]:
                    self.shown[at] = v, y + dy, x + dx
        while len(self.shown) < self.size[0] * self.size[1]:
            layer = []
            for y in range(self.size[0]):
                for x in range(self.size[1]):
                    if (y, x) not in self.shown and any(self.known(y, x, t) for t in self.near):
                        count = sum(self.known(y, x, t) is not None for t in self.taps)
                        layer.append((-count, draw(self.seed, self.stage, 1, y, x), y, x))
            for _, _, y, x in sorted(layer):
                self.shown[y, x] = self.choose(y, x)
        return self.shown

    def known(self, y: int, x: int, tap: Tap) -> Pixel | None:
        y, x = y + tap[0], x + tap[1]
        if self.wrap.y:
            y %= self.size[0]
        if self.wrap.x:
            x %= self.size[1]
        return self.shown.get((y, x))

    def choose(self, y: int, x: int) -> Pixel:
        distances = []
        tall, wide = (2 * (n / 6.4) ** 2 for n in self.window)
        for v, a, b in self.every:
            total = 0
            for dy, dx in self.taps:
                there = self.known(y, x, (dy, dx))
                if there is not None:
                    weight = round(4096 * math.exp(-(dy * dy / tall + dx * dx / wide)))
                    shown = self.grounds[there[0]].at(there[1], there[2])
                    total += weight * squared(shown, self.grounds[v].at(a + dy, b + dx))
            distances.append(total)
        best = min(distances)
        limit = best + best * round(self.tolerance * 65536) // 65536
        good = [p for p, d in zip(self.every, distances, strict=True) if d <= limit]
        return good[below(len(good), draw(self.seed, self.stage, 0, y, x))]


@dataclass
class NaiveScan:
    """Row by row over a torus, level by level; `coherent` for Ashikhmin's candidates, else all places."""

    exemplars: Sequence[Exemplar]
    size: tuple[int, int]
    window: tuple[int, int]
    seed: int
    stage: int
    wrap: Wrap = Wrap.NONE
    levels: int = 1
    coherent: bool = False
    start: dict[tuple[int, int], Pixel] = field(default_factory=dict)

    def run(self) -> dict[tuple[int, int], Pixel]:
        up, side = self.window[0] - 1, self.window[1] // 2
        down = 2 * ((up + 1) // 2) if self.levels > 1 else 0
        wide = max(side, 2 * ((side + 1) // 2)) if self.levels > 1 else side
        scale = 2 ** (self.levels - 1)
        margin = (0 if self.wrap.y else max(up, down) * scale, 0 if self.wrap.x else wide * scale)
        torus = self.size[0] + margin[0], self.size[1] + margin[1]
        pyramid = [of_posed(posed(self.exemplars, (0,)))]
        for _ in range(self.levels - 1):
            pyramid.append([halved(g) for g in pyramid[-1]])
        self.shown: dict[tuple[int, int], Pixel] = {}
        for level in reversed(range(self.levels)):
            size = -(-torus[0] // 2**level), -(-torus[1] // 2**level)
            step = 2**level
            known = {
                (y, x): (v, a // step, b // step)
                for y in range(size[0])
                for x in range(size[1])
                for v, a, b in [self.start.get((y * step - margin[0], x * step - margin[1]), (-1, 0, 0))]
                if v >= 0
            }
            above = None if level == self.levels - 1 else pyramid[level + 1]
            self.level(level, size, pyramid[level], above, known)
        top, left = margin
        return {(y, x): self.shown[y + top, x + left] for y in range(self.size[0]) for x in range(self.size[1])}

    def level(
        self, level: int, size: tuple[int, int], grounds: list[Ground], above: list[Ground] | None,
        known: dict[tuple[int, int], Pixel],
    ) -> None:  # fmt: skip
        """Fill one level of the torus."""
        up, side = self.window[0] - 1, self.window[1] // 2
        before = [(y, x) for y in range(-up, 1) for x in range(-side, side + 1) if (y, x) < (0, 0)]
        after = [(-y, -x) for y, x in before]
        half, whole = (up, side, 0, side if up else 0), (up, side, up, side)
        coarse_taps: list[Tap] = []
        parents: dict[tuple[int, int], list[int]] = {}
        if above is not None:
            high, wide = (up + 1) // 2, (side + 1) // 2
            coarse_taps = [(2 * y, 2 * x) for y in range(-high, high + 1) for x in range(-wide, wide + 1)]
            half = (max(up, 2 * high), max(side, 2 * wide), 2 * high, max(side, 2 * wide))
            whole = (half[0], half[1], max(up, 2 * high), half[3])
            for y in range(size[0]):
                for x in range(size[1]):
                    v, a, b = self.shown[y // 2, x // 2]
                    parents[y, x] = above[v].at(a, b)
            grounds = [with_coarse(g, c) for g, c in zip(grounds, above, strict=True)]
        places = [p for v, g in enumerate(grounds) for p in g.places(v, half)]
        places_whole = [p for v, g in enumerate(grounds) for p in g.places(v, whole)]
        now: dict[tuple[int, int], Pixel] = {}
        for y in range(size[0]):
            for x in range(size[1]):
                if above is None:
                    now[y, x] = places[below(len(places), draw(self.seed, self.stage, 64 + level, y, x))]
                else:
                    v, a, b = self.shown[y // 2, x // 2]
                    height, width = grounds[v].usable.shape
                    now[y, x] = v, min(2 * a + y % 2, height - 1), min(2 * b + x % 2, width - 1)
        now |= known
        done = set(known)
        order = sorted([(t[0] ** 2 + t[1] ** 2, kind, t) for kind, ts in ((0, before), (1, after)) for t in ts])
        every = [(y, x) for y in range(size[0]) for x in range(size[1]) if (y, x) not in known]
        again = [
            (y, x) for y, x in every if (self.wrap.y and y < up) or (self.wrap.x and x < side)
        ]  # they saw noise; at the end they see what came in its place
        for y, x in every + again:
            taps, full = [], False
            for _, kind, t in order:
                at = (y + t[0]) % size[0], (x + t[1]) % size[1]
                if at == (y, x) or (kind == 1 and not (places_whole and at in done)):
                    continue
                below_it, beside = y + t[0] >= size[0], not 0 <= x + t[1] < size[1]
                if kind == 1 and ((below_it and not self.wrap.y) or (beside and not self.wrap.x)):
                    continue
                full = full or kind == 1
                taps.append((t, at))
            templates = [(t, False, grounds[now[at][0]].at(*now[at][1:])) for t, at in taps]
            for t in coarse_taps:
                templates.append((t, True, parents[(y + t[0]) % size[0], (x + t[1]) % size[1]]))
            fitting = places_whole if full else places
            if self.coherent:
                candidates = self.continuing(y, x, taps, order, now, places, fitting, grounds)
            else:
                candidates = fitting if templates else []
            if not candidates:
                candidates = [places[below(len(places), draw(self.seed, self.stage, level, y, x))]]
            costs = [
                sum(squared(value, grounds[v].at(a + t[0], b + t[1], c)) for t, c, value in templates)
                for v, a, b in candidates
            ]
            now[y, x] = candidates[costs.index(min(costs))]
            done.add((y, x))
        self.shown = now

    def continuing(
        self, y: int, x: int, taps: list[tuple[Tap, tuple[int, int]]], order: list[tuple[int, int, Tap]],
        now: dict[tuple[int, int], Pixel], places: list[Pixel], fitting: list[Pixel], grounds: list[Ground],
    ) -> list[Pixel]:  # fmt: skip
        """The pixels that continue the neighbours; where the exemplar ends, one drawn in its place."""
        numbers = {t: k for k, (_, _, t) in enumerate(order)}
        allowed = set(fitting)
        out = []
        for t, at in taps:
            v, a, b = now[at]
            a, b = a - t[0], b - t[1]
            if grounds[v].toroidal:
                a, b = a % grounds[v].usable.shape[0], b % grounds[v].usable.shape[1]
            found = v, a, b
            if found not in allowed:
                found = places[below(len(places), draw(self.seed, self.stage, 8 + numbers[t], y, x))]
            if found in allowed:
                out.append(found)
        return out


def halved(g: Ground) -> Ground:
    """Every two by two pixels become one: they and those around them, weighted 1 3 3 1 along both axes."""
    height, width, channels = g.own.shape
    rows, columns = height + height % 2, width + width % 2  # an odd one is completed with its last row or column

    def read(y: int, x: int) -> tuple[NDArray[np.int64], bool]:
        if g.toroidal:
            y, x = y % rows, x % columns
        y, x = min(max(y, 0), height - 1), min(max(x, 0), width - 1)
        return g.own[y, x], bool(g.usable[y, x])

    own = np.zeros((rows // 2, columns // 2, channels), np.int64)
    usable = np.ones((rows // 2, columns // 2), bool)
    for y in range(rows // 2):
        for x in range(columns // 2):
            for i, wy in enumerate((1, 3, 3, 1)):
                for j, wx in enumerate((1, 3, 3, 1)):
                    value, ok = read(2 * y - 1 + i, 2 * x - 1 + j)
                    own[y, x] += wy * wx * value
                    usable[y, x] &= ok
    return Ground((own + 32) // 64, usable, g.toroidal)


def with_coarse(g: Ground, above: Ground) -> Ground:
    """Lay the coarser level, every pixel repeated, under a level."""
    height, width = g.usable.shape
    index = np.ix_(np.arange(height) // 2, np.arange(width) // 2)
    return Ground(g.own, g.usable & above.usable[index], g.toroidal, above.own[index])
