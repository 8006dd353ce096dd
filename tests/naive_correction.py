"""The pipeline of corrections in plain words: every pixel asked for by its place, nothing computed in windows.

Written from the papers and the memo; shared with the package are the draws, the transformed exemplar and the jump sets.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from intarsia.draws import draw

Pixel = tuple[int, int]
DIAGONAL = [(-1, -1), (-1, 1), (1, -1), (1, 1)]


@dataclass
class NaiveLevel:
    """A level of the exemplar: pixels `h` apart; `jumps[y][x]` lists similar pixels of every `step`-th one."""

    h: int
    picture: Any  # (H, W, C)
    toroidal: bool
    open: Any  # (H, W)
    jumps: Any  # (rows, columns, k - 1, 2)
    step: int
    colours: Any = None  # 25 weights in 1 / 256, where colours are compared

    def at(self, y: int, x: int) -> list[int]:
        """The features of a pixel, beyond the border those of the torus, or of the mirror."""
        height, width = self.picture.shape[:2]
        if self.toroidal:
            y, x = y % height, x % width
        else:
            y, x = y % (2 * height), x % (2 * width)
            y, x = min(y, 2 * height - 1 - y), min(x, 2 * width - 1 - x)
        return [int(v) for v in self.picture[y, x]]

    def own(self, u: Pixel) -> list[int]:
        """N_E(u): three times the features of the four diagonal neighbours, or 5 x 5 colours."""
        if self.colours is None:
            return [3 * v for dy, dx in DIAGONAL for v in self.at(u[0] + self.h * dy, u[1] + self.h * dx)]
        taps = [self.at(u[0] + self.h * dy, u[1] + self.h * dx) for dy in range(-2, 3) for dx in range(-2, 3)]
        return [(v * int(w)) >> 8 for tap, w in zip(taps, self.colours, strict=True) for v in tap]

    def seen(self, p: Pixel, s: Callable[[int, int], Pixel]) -> list[int]:
        """N_S(p): what the map shows around p."""
        if self.colours is not None:
            taps = [self.at(*s(p[0] + dy, p[1] + dx)) for dy in range(-2, 3) for dx in range(-2, 3)]
            return [(v * int(w)) >> 8 for tap, w in zip(taps, self.colours, strict=True) for v in tap]
        out = []
        for dy, dx in DIAGONAL:
            total = [0] * self.picture.shape[2]
            for ey, ex in ((0, 0), (dy, 0), (0, dx)):
                u = s(p[0] + dy + ey, p[1] + dx + ex)
                total = [a + b for a, b in zip(total, self.at(u[0] - self.h * ey, u[1] - self.h * ex), strict=True)]
            out += total
        return out

    def inside(self, y: int, x: int) -> Pixel | None:
        """The pixel itself, across the border of a torus; None outside."""
        height, width = self.picture.shape[:2]
        if self.toroidal:
            return y % height, x % width
        return (y, x) if 0 <= y < height and 0 <= x < width else None

    def similar(self, u: Pixel) -> list[Pixel]:
        """C_2(u), ..., C_k(u)."""
        out = []
        for to in self.jumps[u[0] // self.step][u[1] // self.step]:
            if to[0] >= 0:
                moved = self.inside(int(to[0]) + u[0] % self.step, int(to[1]) + u[1] % self.step)
                out += [] if moved is None else [moved]
        return out

    def candidates(self, p: Pixel, s: Callable[[int, int], Pixel], rule: str) -> tuple[list[Pixel], list[Pixel]]:
        """The proximity set and the jump set of p."""
        reach = 2 if rule == "memo" else 1
        around = [(dy, dx) for dy in range(-reach, reach + 1) for dx in range(-reach, reach + 1)]
        near: list[Pixel] = [s(*p)]
        far: list[Pixel] = []
        for dy, dx in around:
            u = s(p[0] + dy, p[1] + dx)
            moved = self.inside(u[0] - self.h * dy, u[1] - self.h * dx)
            near += [] if moved is None else [moved]
            if rule == "published":
                tos = [self.inside(t[0] - self.h * dy, t[1] - self.h * dx) for t in self.similar(u)]
                far += [t for t in tos if t is not None]
        if rule != "published":
            for u in dict.fromkeys(near):
                far += self.similar(u)
        return near, far

    def corrected(self, p: Pixel, s: Callable[[int, int], Pixel], rule: str, factor: int) -> Pixel:
        """The candidate whose neighbourhood is most like that of p; a jump counts factor / 256 times as much."""
        near, far = self.candidates(p, s, rule)
        seen, best, kept = self.seen(p, s), None, s(*p)
        for u, price in [(u, 256) for u in near] + [(u, factor) for u in far if u not in near and factor >= 0]:
            if self.open[u]:
                d = price * sum((a - b) ** 2 for a, b in zip(seen, self.own(u), strict=True))
                if best is None or d < best:
                    best, kept = d, u
        return kept


@dataclass
class NaiveSynthesis:
    """An endless map; `levels` are those that are corrected, the finest first, of `count` in all."""

    size: Pixel
    levels: list[NaiveLevel]
    count: int
    jitter: Callable[[int], int]  # of a level, in 1 / 4096 px
    factor: int
    passes: int
    side: int
    rule: str
    seed: int
    stage: int
    drawn: int = 1  # places for each of the large pieces
    known: dict[tuple[int, int, int, int], Pixel] = field(default_factory=dict)

    def pixel(self, level: int, after: int, y: int, x: int) -> Pixel:
        """S(y, x) of a level after so many subpasses."""
        key = (level, after, y, x)
        if key not in self.known:
            self.known[key] = self._fresh(level, after, y, x) if after == 0 else self._next(level, after, y, x)
        return self.known[key]

    def final(self, y: int, x: int) -> Pixel:
        return self.pixel(0, self._subpasses(0), y, x)

    def _subpasses(self, level: int) -> int:
        return self.passes * self.side**2 if level < self._mended() else 0

    def _mended(self) -> int:
        """Corrected are the three finest levels, and all up to the coarsest on which pixels were moved."""
        moved = [level + 1 for level in range(len(self.levels)) if self.jitter(level)]
        return max([min(3, len(self.levels)), *moved])

    def _next(self, level: int, after: int, y: int, x: int) -> Pixel:
        turn = divmod((after - 1) % self.side**2, self.side)
        if (y % self.side, x % self.side) != turn:
            return self.pixel(level, after - 1, y, x)
        return self.levels[level].corrected(
            (y, x), lambda a, b: self.pixel(level, after - 1, a, b), self.rule, self.factor
        )

    def _fresh(self, level: int, after: int, y: int, x: int) -> Pixel:
        if level != self.count - 2 or level < self._mended() or not self.jitter(level):
            return self._moved(level, y, x, 0)
        places, around = [self._moved(level, y, x, n) for n in range(self.drawn)], []
        for dy in range(-2, 3):
            for dx in range(-2, 3):
                if 2 * ((y + dy) % 2) + (x + dx) % 2 < 2 * (y % 2) + x % 2:
                    around.append((dy, dx, self.pixel(level, 0, y + dy, x + dx)))
        return min(places, key=lambda u: sum(self._again(1 << level, u, *other) for other in around))

    def _again(self, h: int, u: Pixel, dy: int, dx: int, v: Pixel) -> int:
        """How much two pieces of h x h px, `dy`, `dx` pieces apart, show of the same, weighted by the nearness."""
        total = 0
        for a in ((v[0] - u[0]) % self.size[0] - n for n in (0, self.size[0])):
            for b in ((v[1] - u[1]) % self.size[1] - n for n in (0, self.size[1])):
                if abs(a) < h and abs(b) < h:
                    shared = ((h - abs(a)) * 1024 // h) * ((h - abs(b)) * 1024 // h)
                    away = ((dy * h - a) * 16 // h) ** 2 + ((dx * h - b) * 16 // h) ** 2
                    total += (shared << 16) // (away + 1)
        return total

    def _moved(self, level: int, y: int, x: int, number: int) -> Pixel:
        h = 1 << level
        if level == self.count - 1:
            u = [h * y + h // 2, h * x + h // 2]
        else:
            parent = self.pixel(level + 1, self._subpasses(level + 1), y // 2, x // 2)
            u = [s + (h * (2 * (c % 2) - 1)) // 2 for s, c in zip(parent, (y, x), strict=True)]
        bits, r = draw(self.seed, self.stage, level + number * self.count, y, x), self.jitter(level)
        for axis, word in enumerate((bits >> 32, bits & 0xFFFFFFFF)):  # floor(h r H + 1/2), H in [-1, 1)
            u[axis] += (2 * r * (word - (1 << 31)) + (4096 << 31)) // (2 * 4096 << 31)
            u[axis] %= self.size[axis]
        return u[0], u[1]
