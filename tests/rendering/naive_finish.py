"""The slow obvious truth of levelling: steps at seams, one by one, and their potentials, added up pixel by pixel."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from math import floor
from typing import Any

import numpy as np

from intarsia.foundation.geometry import ISOMETRIES
from intarsia.model import Exemplar
from intarsia.model.image import Plane
from intarsia.model.sourcemap import SourceMap
from intarsia.rendering.seam_levelling import greens_function


def weight_of(plane: Plane, code: Any) -> int:
    """Opacity; of 16 bits, the upper 8 count, and floats count in as many steps."""
    if not plane.alpha:
        return 1
    if plane.is_float:
        return round(min(max(float(code[-1]), 0.0), 1.0) * 255)
    return int(code[-1]) >> (8 if plane.pixels.itemsize == 2 else 0)


def beyond(at: int, length: int, wrap: bool) -> int:
    """A row or column, beyond the border around the torus, or as in a mirror."""
    if wrap:
        return at % length
    at %= 2 * length
    return min(at, 2 * length - 1 - at)


class NaiveLeveller:
    """Levels a picture of the map's own size, already drawn."""

    def __init__(self, exemplars: Sequence[Exemplar], smap: SourceMap, codes: np.ndarray, radius: int):
        self.exemplars, self.smap, self.codes, self.radius = exemplars, smap, codes, radius
        self.plane = exemplars[0].base
        self.colours = self.plane.channels - self.plane.alpha
        self.theirs = [e.base.samples for e in exemplars]
        if self.plane.is_float:
            self.shift = 16 - int(np.frexp(max(abs(float(v)) for c in range(self.colours) for v in self.range(c)))[1])
        else:
            self.shift = 16 - 8 * self.plane.pixels.itemsize
        self.mean = cache(self._mean)
        self.variance = self._variance()

    def whole(self, w: int, u: int, v: int, c: int) -> int:
        """An exemplar pixel in whole numbers of 2**-shift."""
        return round(float(self.theirs[w][u, v, c]) * 2.0**self.shift)

    def _variance(self) -> float:
        """Of all that counts, or of all where nothing does; of all channels together."""
        places = [(w, u, v) for w, e in enumerate(self.exemplars) for u, v in np.ndindex(e.height, e.width)]
        used = [at for at in places if self.weight(*at)] or places
        total = 0
        for c in range(self.colours):
            values = [self.whole(*at, c) for at in used]
            total += len(used) * sum(a * a for a in values) - sum(values) ** 2
        return total / len(used) ** 2

    def weight(self, w: int, u: int, v: int) -> int:
        """How much an exemplar pixel counts."""
        e = self.exemplars[w]
        return 0 if e.usable is not None and not e.usable[u, v] else weight_of(self.plane, e.base.samples[u, v])

    def inside(self, w: int, u: int, v: int) -> tuple[int, int] | None:
        e = self.exemplars[w]
        if e.toroidal:
            return u % e.height, v % e.width
        return (u, v) if 0 <= u < e.height and 0 <= v < e.width else None

    def _mean(self, w: int, u: int, v: int, c: int) -> int:
        """The mean over 7 x 7 pixels, rounded down."""
        total = weight = 0
        for dy in range(-3, 4):
            for dx in range(-3, 4):
                at = self.inside(w, u + dy, v + dx)
                n = 0 if at is None else self.weight(w, *at)
                if at is not None and n:
                    total, weight = total + n * self.whole(w, *at, c), weight + n
        return total // weight if weight else 0

    def shown(self, y: int, x: int) -> tuple[int, np.ndarray, np.ndarray]:
        smap = self.smap
        pose = 0 if smap.pose is None else int(smap.pose[y, x])
        return 0 if smap.which is None else int(smap.which[y, x]), smap.yx[y, x], np.array(ISOMETRIES[pose].j)

    def seams(self) -> Iterator[tuple[tuple[int, int], tuple[int, int], tuple[int, int]]]:
        """All pixels, the next along an axis, and the way to it; around the canvas, too."""
        height, width = self.smap.height, self.smap.width
        for y, x in np.ndindex(height, width):
            for way in ((1, 0), (0, 1)):
                v, u = y + way[0], x + way[1]
                if (v < height or self.smap.wrap.y) and (u < width or self.smap.wrap.x):
                    yield (y, x), (v % height, u % width), way

    def step(self, one: tuple[int, int], other: tuple[int, int], way: tuple[int, int]) -> list[int] | None:
        """By how much the piece of `one` is lighter than that of `other`, as far as that can be trusted."""
        (w, a, j), (v, b, k) = self.shown(*one), self.shown(*other)
        b = b - k @ np.array(way)
        same = a - b
        if self.exemplars[w].toroidal:
            same = same % (self.exemplars[w].height, self.exemplars[w].width)
        if w == v and (j == k).all() and not same.any():
            return None
        apart: list[list[int]] = []
        here: list[int] | None = None
        for dy in (-8, -4, 0, 4, 8):
            for dx in (-8, -4, 0, 4, 8):
                p = self.inside(w, *(int(n) for n in a + j @ np.array([dy, dx])))
                q = self.inside(v, *(int(n) for n in b + k @ np.array([dy, dx])))
                if p is None or q is None or not self.weight(w, *p) or not self.weight(v, *q):
                    continue
                apart.append([self.mean(w, *p, c) - self.mean(v, *q, c) for c in range(self.colours)])
                if dy == dx == 0:
                    here = apart[-1]
        if len(apart) < 5:
            return None
        mean = [sum(column) / len(apart) for column in zip(*apart, strict=True)]
        steady, along = sum(m * m for m in mean), sum(m * h for m, h in zip(mean, here or mean, strict=True))
        if along <= 0:
            return None
        varies = max(sum(d * d for row in apart for d in row) / len(apart) - steady, 0.0)
        share = max(1.0 - varies / steady, 0.0)
        share *= min(along / steady, 1.0) * min(self.variance / steady, 1.0)
        return [floor(share * m + 0.5) for m in mean]

    def added(self) -> np.ndarray:
        """What is added to every pixel, in 2**-14 of 2**-shift."""
        height, width = self.smap.height, self.smap.width
        field = np.zeros((height, width, self.colours), dtype=object)
        for one, other, way in self.seams():
            step = self.step(one, other, way)
            if step is not None:
                field[one] += step
                field[other] -= step
        r, out, kernel = self.radius, np.zeros(field.shape, dtype=object), greens_function(self.radius)
        for y, x in np.ndindex(height, width):
            for dy in range(1 - r, r):
                for dx in range(1 - r, r):
                    v = beyond(y + dy, height, self.smap.wrap.y)
                    u = beyond(x + dx, width, self.smap.wrap.x)
                    out[y, x] += field[v, u] * int(kernel[r - 1 + dy, r - 1 + dx])
        return out

    def range(self, c: int) -> tuple[Any, Any]:
        """Least and greatest code of what may be used and is seen."""
        seen = [
            la[u, v, c]
            for w, (e, la) in enumerate(zip(self.exemplars, self.theirs, strict=True))
            for u in range(e.height)
            for v in range(e.width)
            if self.weight(w, u, v)
        ]
        return min(seen), max(seen)

    def levelled(self, strength: float) -> np.ndarray:
        """Return the codes (H, W, C)."""
        out, added = self.codes.copy(), self.added()
        for c in range(self.colours):
            low, high = (v.item() for v in self.range(c))
            for y, x in np.ndindex(out.shape[:2]):
                own = self.codes[y, x, c].item()
                wanted = own + float(added[y, x, c]) * (strength * 2.0 ** (-self.shift - 14))
                kept = min(max(wanted, min(low, own)), max(high, own))
                if kept != own:
                    out[y, x, c] = kept if self.plane.is_float else floor(kept + 0.5)
        return out
