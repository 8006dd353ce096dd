"""The slow obvious truth of levelling: both boxes, pixel by pixel, in fractions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import floor
from typing import Any

import numpy as np

from intarsia.exemplar import Exemplar
from intarsia.geometry import ISOMETRIES
from intarsia.image import Plane
from intarsia.sourcemap import SourceMap


def weight_of(plane: Plane, code: Any) -> Fraction:
    """Opacity; of 16 bits, the upper 8 count, and floats count in as many steps."""
    if not plane.alpha:
        return Fraction(1)
    if plane.is_float:
        return Fraction(round(min(max(float(code[-1]), 0.0), 1.0) * 255))
    return Fraction(int(code[-1]) >> (8 if plane.pixels.itemsize == 2 else 0))


class NaiveLeveller:
    """Levels a picture of the map's own size, already drawn."""

    def __init__(self, exemplars: Sequence[Exemplar], smap: SourceMap, codes: np.ndarray, radius: int):
        self.exemplars, self.smap, self.codes = exemplars, smap, codes
        self.plane = exemplars[0].base
        self.shift = 30 if self.plane.is_float else 36 - 8 * self.plane.alpha - 8 * self.plane.pixels.itemsize
        self.theirs = [e.base.samples for e in exemplars]
        self.radii = [radius]
        while self.radii[-1] // 4 >= 2:
            self.radii.append(self.radii[-1] // 4)
        self.smooth: list[list[dict[tuple[int, int, int], int]]] = [[{} for _ in exemplars]]
        for radius in self.radii[:-1]:
            self.smooth.append([self.smoother(w, radius) for w in range(len(exemplars))])

    def value(self, band: int, w: int, u: int, v: int, c: int) -> Fraction:
        """An exemplar pixel, in fractions of 2**-shift, without what wider radii have seen to."""
        whole = Fraction(self.theirs[w][u, v, c].item()) * 2**self.shift
        return whole - self.smooth[band][w].get((u, v, c), 0)

    def smoother(self, w: int, radius: int) -> dict[tuple[int, int, int], int]:
        """What the last band sees to is the mean around every pixel of an exemplar, rounded down."""
        e, band, found = self.exemplars[w], len(self.smooth) - 1, {}
        for y, x, c in np.ndindex(e.height, e.width, self.plane.channels - self.plane.alpha):
            seen = []
            for dy in range(-radius, radius + 1):
                for dx in range(-radius, radius + 1):
                    u, v = (y + dy) % e.height, (x + dx) % e.width
                    inside = e.toroidal or (u, v) == (y + dy, x + dx)
                    if inside and (e.usable is None or e.usable[u, v]):
                        seen.append((weight_of(self.plane, e.base.samples[u, v]), self.value(band, w, u, v, c)))
            weight = sum(n for n, _ in seen)
            mean = floor(sum(n * a for n, a in seen) / weight) if weight else 0
            found[y, x, c] = self.smooth[band][w].get((y, x, c), 0) + mean
        return found

    def offsets(self, y: int, x: int, radius: int) -> list[tuple[int, int, int, int]]:
        """The box of the picture: (dy, dx, row, column), as far as there is a canvas."""
        height, width, wrap, found = self.smap.height, self.smap.width, self.smap.wrap, []
        for dy in range(-radius, radius + 1):
            for dx in range(-radius, radius + 1):
                row, column = y + dy, x + dx
                row, column = (row % height if wrap.y else row), (column % width if wrap.x else column)
                if 0 <= row < height and 0 <= column < width:
                    found.append((dy, dx, row, column))
        return found

    def step(self, y: int, x: int, c: int) -> Fraction:
        """The steps of all bands."""
        return sum(self.step_of(band, y, x, c) for band in range(len(self.radii))) / Fraction(2**self.shift)

    def shown(self, band: int, y: int, x: int, c: int) -> Fraction:
        """A pixel of the picture, without what wider radii have seen to."""
        w = 0 if self.smap.which is None else int(self.smap.which[y, x])
        u, v = (int(n) for n in self.smap.yx[y, x])
        return Fraction(self.codes[y, x, c].item()) * 2**self.shift - self.smooth[band][w].get((u, v, c), 0)

    def step_of(self, band: int, y: int, x: int, c: int) -> Fraction:
        """Mean of the picture around (y, x), less the mean of the exemplar around the pixel shown there."""
        w = 0 if self.smap.which is None else int(self.smap.which[y, x])
        pose = 0 if self.smap.pose is None else int(self.smap.pose[y, x])
        (a, b), (p, q) = ISOMETRIES[pose].j
        e, own, other = self.exemplars[w], [], []
        for dy, dx, row, column in self.offsets(y, x, self.radii[band]):
            own.append((weight_of(self.plane, self.codes[row, column]), self.shown(band, row, column, c)))
            u = int(self.smap.yx[y, x, 0]) + a * dy + b * dx
            v = int(self.smap.yx[y, x, 1]) + p * dy + q * dx
            if e.toroidal:
                u, v = u % e.height, v % e.width
            if 0 <= u < e.height and 0 <= v < e.width and (e.usable is None or e.usable[u, v]):
                other.append((weight_of(self.plane, e.base.samples[u, v]), self.value(band, w, u, v, c)))
        if not sum(n for n, _ in own) or not sum(n for n, _ in other):
            return Fraction(0)
        return sum(n * v for n, v in own) / sum(n for n, _ in own) - sum(n * v for n, v in other) / sum(
            n for n, _ in other
        )

    def range(self, c: int) -> tuple[Any, Any]:
        """Least and greatest code of what may be used and is seen."""
        seen = [
            la[u, v, c]
            for e, la in zip(self.exemplars, self.theirs, strict=True)
            for u in range(e.height)
            for v in range(e.width)
            if (e.usable is None or e.usable[u, v]) and weight_of(self.plane, e.base.samples[u, v])
        ]
        return min(seen), max(seen)

    def levelled(self, strength: float) -> np.ndarray:
        """Return the codes (H, W, C)."""
        out = self.codes.copy()
        for c in range(self.plane.channels - self.plane.alpha):
            low, high = (Fraction(v.item()) for v in self.range(c))
            for y, x in np.ndindex(out.shape[:2]):
                own = Fraction(self.codes[y, x, c].item())
                wanted = own + Fraction(strength) * self.step(y, x, c)
                kept = min(max(wanted, min(low, own)), max(high, own))
                if kept != own:
                    out[y, x, c] = self.coded(kept)
        return out

    def coded(self, value: Fraction) -> Any:
        return float(value) if self.plane.is_float else floor(value + Fraction(1, 2))
