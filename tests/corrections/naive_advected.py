"""Moving a map with a flow in plain words, pixel by pixel.

Shared with the package are the draws, the features, the jump sets, and which usable pixel is nearest to a masked one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from corrections.naive_correction import NaiveLevel

from intarsia.corrections.advected import AROUND, SQUARE, STAGE
from intarsia.foundation.run import below, draw

Pixel = tuple[int, int]
Map = dict[Pixel, Pixel]
Rules = tuple[int, int, str, int]


class NaiveFlow:
    """A canvas of height x width px, closed along some axes, that shows an exemplar."""

    def __init__(self, canvas: Pixel, closed: tuple[bool, bool], exemplar: Any, home: Any) -> None:
        self.canvas, self.closed, self.exemplar, self.nearest = canvas, closed, exemplar, home
        self.size, self.torus = (exemplar.height, exemplar.width), exemplar.toroidal

    def pixels(self) -> list[Pixel]:
        return [(y, x) for y in range(self.canvas[0]) for x in range(self.canvas[1])]

    def on(self, p: Pixel) -> Pixel:
        """The pixel of the canvas in its place: around, or the nearest."""
        y, x = (c % n if around else min(max(c, 0), n - 1)
                for c, n, around in zip(p, self.canvas, self.closed, strict=True))  # fmt: skip
        return y, x

    def home(self, u: Pixel) -> Pixel:
        """The exemplar pixel to take: around, and the nearest usable one."""
        y, x = u[0] % self.size[0], u[1] % self.size[1]
        return divmod(int(self.nearest[y * self.size[1] + x]), self.size[1]) if len(self.nearest) else (y, x)

    def moved(self, s: Map, steps: Any, lot: tuple[int, int]) -> tuple[Map, set[Pixel]]:
        """Return the moved map, and which pixels are torn."""
        out, away = {}, {}
        for p in self.pixels():
            q = p[0] - int(steps[p][0]), p[1] - int(steps[p][1])
            around = [c % n if a else c for c, n, a in zip(q, self.canvas, self.closed, strict=True)]
            inside = self.on(q)
            away[p] = (around[0], around[1]) != inside
            u = [s[inside][k] + around[k] - inside[k] for k in (0, 1)]
            leaves = [not 0 <= v < n for v, n in zip(u, self.size, strict=True)]
            if not self.torus and any(leaves):
                bits = draw(lot[0], STAGE, lot[1], p[0] // SQUARE, p[1] // SQUARE)
                u = [v + (below(n, bits) if leaves[1 - k] else 0)
                     for k, (v, n) in enumerate(zip(u, self.size, strict=True))]  # fmt: skip
            out[p] = self.home((u[0], u[1]))
        torn = set()
        for p in self.pixels():
            for d in ((0, 1), (1, 0)):
                to = self.on((p[0] + d[0], p[1] + d[1]))
                beyond = any(p[k] + d[k] >= self.canvas[k] and not self.closed[k] for k in (0, 1))
                wanted = (out[p][0] + d[0], out[p][1] + d[1])
                if self.torus:
                    wanted = wanted[0] % self.size[0], wanted[1] % self.size[1]
                together = list(steps[p]) == list(steps[to]) and not away[p] and not away[to]
                if not beyond and out[to] != wanted and not together:
                    torn |= {p, to}
        return out, torn

    def mended(self, s: Map, torn: set[Pixel], top: int, levels: list[NaiveLevel], rules: Rules) -> Map:
        """Correct what is torn from level `top` on; `rules`: passes, side of the classes, rule, factor."""
        for level in range(min(top, len(levels) - 1), 0, -1):
            h = 1 << level
            even = [a and n % h == 0 for a, n in zip(self.closed, self.canvas, strict=True)]
            less = self.canvas[0] // h, self.canvas[1] // h
            small = NaiveFlow(less, (even[0], even[1]), self.exemplar, self.nearest)
            before = {(y, x): s[h * y + h // 2, h * x + h // 2] for y, x in small.pixels()}
            where = {(y // h, x // h) for y, x in torn} & set(before)
            after = small.corrected(before, where, levels[level], rules)
            s, torn = dict(s), set(torn)
            for y, x in small.pixels():
                if after[y, x] != before[y, x]:
                    for p in [(h * y + i, h * x + j) for i in range(h) for j in range(h)]:
                        u = after[y, x]
                        s[p] = self.home((u[0] + p[0] - h * y - h // 2, u[1] + p[1] - h * x - h // 2))
                        torn.add(p)
        near = range(-AROUND, AROUND + 1)
        wide = {self.on((y + i, x + j)) for y, x in torn for i in near for j in near}
        return self.corrected(s, wide, levels[0], rules)

    def corrected(self, s: Map, where: set[Pixel], level: NaiveLevel, rules: Rules) -> Map:
        """The passes of one level; what a subpass finds is known to the next."""
        passes, side, rule, factor = rules
        for turn in [(i, j) for i in range(side) for j in range(side)] * passes:
            own = [p for p in where if (p[0] % side, p[1] % side) == turn]
            s = s | {p: level.corrected(p, self.shown(s, level.h), rule, factor) for p in own}
        return s

    def shown(self, s: Map, h: int) -> Callable[[int, int], Pixel]:
        """The map beyond its borders, too: what continues them, h px a step, as far as the exemplar goes."""

        def at(y: int, x: int) -> Pixel:
            q = self.on((y, x))
            u = [s[q][k] + (0 if self.closed[k] else h * ((y, x)[k] - q[k])) for k in (0, 1)]
            if self.torus:
                return u[0] % self.size[0], u[1] % self.size[1]
            return min(max(u[0], 0), self.size[0] - 1), min(max(u[1], 0), self.size[1] - 1)

        return at
