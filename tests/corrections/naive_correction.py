"""The pipeline of corrections in plain words: every pixel asked for by its place, nothing computed in windows.

Written from the papers and the memo; shared with the package are the draws, the transformed exemplar and the jump sets.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from intarsia.foundation.run import draw

Pixel = tuple[int, int]
Matrix = tuple[int, int, int, int]  # J in 1 / 4096: y from y, y from x, x from y, x from x
UPRIGHT = (4096, 0, 0, 4096)
DESCENDED = -1  # before the guide is looked at
DIAGONAL = [(-1, -1), (-1, 1), (1, -1), (1, 1)]


def stepped(j: Matrix, y: int, x: int) -> Pixel:
    """J (y, x), rounded to whole px."""
    return (j[0] * y + j[1] * x + 2048) // 4096, (j[2] * y + j[3] * x + 2048) // 4096


def toward(j: Matrix, y: int, x: int) -> Pixel:
    """The nearest of eight neighbours, or none, in the direction that J turns into (y, x): phi of 2006."""
    back = j[3] * y - j[1] * x, j[0] * x - j[2] * y
    length = math.hypot(*back)
    unit = [v / length if length else 0.0 for v in back]
    found = [0 if abs(v) < 0.5 - 1e-9 else 1 if v > 0 else -1 for v in unit]
    return found[0], found[1]


@dataclass
class NaiveLevel:
    """A level of the exemplar: pixels `h` apart; `jumps[y][x]` lists similar pixels of every `step`-th one."""

    h: int
    picture: Any  # (H, W, C)
    toroidal: bool
    open: Any  # (H, W)
    jumps: Any  # (rows, columns, k - 1, 2)
    step: int
    colours: Any = None  # 25 weights of squared differences, where colours are compared
    guide: NaiveGuide | None = None

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
        return self.weighed(taps)

    def seen(self, p: Pixel, s: Callable[[int, int], Pixel], j: Matrix) -> list[int]:
        """N_S(p): what the map shows around p; a neighbour o away foretells S[p + o] - J h o."""
        if self.colours is not None:
            taps = [self.at(*s(p[0] + dy, p[1] + dx)) for dy in range(-2, 3) for dx in range(-2, 3)]
            return self.weighed(taps)
        out = []
        for dy, dx in DIAGONAL:
            total = [0] * self.picture.shape[2]
            for aside in ((0, 0), (dy, 0), (0, dx)):
                oy, ox = (a + b for a, b in zip(toward(j, dy, dx), toward(j, *aside), strict=True))
                u, back = s(p[0] + oy, p[1] + ox), stepped(j, self.h * oy, self.h * ox)
                there = u[0] - back[0] + self.h * dy, u[1] - back[1] + self.h * dx
                total = [a + b for a, b in zip(total, self.at(*there), strict=True)]
            out += total
        return out

    def weighed(self, taps: list[list[int]]) -> list[int]:
        """Colours times the roots of their weights, in whole numbers: differences are squared later."""
        return [v * round(256 * math.sqrt(w)) // 256 for tap, w in zip(taps, self.colours, strict=True) for v in tap]

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

    def candidates(
        self, p: Pixel, s: Callable[[int, int], Pixel], rule: str, j: Matrix
    ) -> tuple[list[Pixel], list[Pixel]]:
        """The proximity set and the jump set of p; turned or scaled, jumps of what differs by rounding are left out."""
        reach = 2 if rule == "memo" else 1
        around = [(dy, dx) for dy in range(-reach, reach + 1) for dx in range(-reach, reach + 1)]
        near: list[Pixel] = [s(*p)]
        far: list[Pixel] = []
        for dy, dx in around:
            u = s(p[0] + dy, p[1] + dx)
            back = stepped(j, self.h * dy, self.h * dx)
            moved = self.inside(u[0] - back[0], u[1] - back[1])
            near += [] if moved is None else [moved]
            if rule == "published":
                tos = [self.inside(t[0] - self.h * dy, t[1] - self.h * dx) for t in self.similar(u)]
                far += [t for t in tos if t is not None]
        if rule != "published":
            every = list(dict.fromkeys(near))
            for n, u in enumerate(every):
                beside = any(max(abs(u[0] - v[0]), abs(u[1] - v[1])) <= 1 for v in every[:n])
                far += [] if j != UPRIGHT and beside else self.similar(u)
        return near, far

    def corrected(
        self, p: Pixel, s: Callable[[int, int], Pixel], rule: str, factor: int, j: Matrix = UPRIGHT
    ) -> Pixel:
        """The candidate whose neighbourhood is most like that of p; a jump counts factor / 256 times as much."""
        near, far = self.candidates(p, s, rule, j)
        seen, best, kept = self.seen(p, s, j), None, s(*p)
        wrong = self.guide.counted if self.guide else lambda *_: 0
        for u, price in [(u, 256) for u in near] + [(u, factor) for u in far if u not in near and factor >= 0]:
            if self.open[u]:
                d = price * sum((a - b) ** 2 for a, b in zip(seen, self.own(u), strict=True)) + 256 * wrong(u, p)
                if best is None or d < best:
                    best, kept = d, u
        return kept


@dataclass
class NaiveGuide:
    """A guide on one level: `beside` (H, W, C) of the exemplar, `over` (rows, columns, C) of the canvas."""

    h: int
    beside: Any
    over: Any
    scale: int  # what values count, 2**32 = 1
    enough: int  # up to which squared difference it is followed
    near: bool  # whether pixels around may offer a place first
    open: Any

    def asked(self, p: Pixel) -> list[int]:
        """What is wanted in the middle of the pixel's square; beyond the canvas what is wanted at its border."""
        y, x = (min(max(self.h * c + self.h // 2, 0), n - 1) for c, n in zip(p, self.over.shape[:2], strict=True))
        return [int(v) for v in self.over[y, x]]

    def counted(self, u: Pixel, p: Pixel) -> int:
        """What a candidate costs."""
        sides = [[(int(v) * self.scale + 2**31) // 2**32 for v in side] for side in (self.beside[u], self.asked(p))]
        return sum((a - b) ** 2 for a, b in zip(*sides, strict=True))

    def apart(self, u: Pixel, p: Pixel) -> int:
        return sum((int(a) - b) ** 2 for a, b in zip(self.beside[u], self.asked(p), strict=True))

    def group(self, p: Pixel) -> list[Pixel]:
        """The open places that show about what is wanted."""
        groups: dict[tuple[int, ...], list[Pixel]] = {}
        steps = 16 if self.beside.shape[2] < 3 else 8
        for y in range(self.beside.shape[0]):
            for x in range(self.beside.shape[1]):
                if self.open[y, x]:
                    key = tuple(int(v) * steps // (1020 * 16 + 1) for v in self.beside[y, x])
                    groups.setdefault(key, []).append((y, x))
        best: tuple[int, list[Pixel]] | None = None
        for key in sorted(groups):
            values = [[int(v) for v in self.beside[u]] for u in groups[key]]
            means = [sum(channel) // len(values) for channel in zip(*values, strict=True)]
            d = sum((a - b) ** 2 for a, b in zip(means, self.asked(p), strict=True))
            if best is None or d < best[0]:
                best = d, groups[key]
        return best[1]

    def placed_by_guide(
        self, p: Pixel, s: Callable[[int, int], Pixel], toroidal: bool, drawn: Callable[[int], int]
    ) -> Pixel:
        """Begin again at the best of eight places, where what is wanted is neither here nor offered around."""
        least, (height, width) = self.apart(s(*p), p), self.open.shape
        if least <= self.enough:
            return s(*p)
        for dy in (-1, 0, 1) if self.near else ():
            for dx in (-1, 0, 1):
                u = s(p[0] + dy, p[1] + dx)
                y, x = u[0] - self.h * dy, u[1] - self.h * dx
                if toroidal:
                    y, x = y % height, x % width
                if 0 <= y < height and 0 <= x < width and self.open[y, x] and self.apart((y, x), p) <= self.enough:
                    return s(*p)
        group, best, kept = self.group(p), (least + 1) // 2, s(*p)
        for n in range(8):
            u = group[((drawn(n) >> 32) * len(group)) >> 32]
            if self.apart(u, p) < best:
                best, kept = self.apart(u, p), u
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
    orientation: Callable[[int, int, int], Matrix] = lambda level, y, x: UPRIGHT
    share: Callable[[Pixel, Pixel], float] | None = None  # of the jitter, at an output place and an exemplar pixel
    guides: list[NaiveGuide] = field(default_factory=list)  # of all levels, or none
    known: dict[tuple[int, int, int, int], Pixel] = field(default_factory=dict)

    def pixel(self, level: int, after: int, y: int, x: int) -> Pixel:
        """S(y, x) of a level after so many subpasses."""
        key = (level, after, y, x)
        if key not in self.known:
            make = self._fresh if after == DESCENDED else self._begun if after == 0 else self._next
            self.known[key] = make(level, after, y, x)
        return self.known[key]

    def final(self, y: int, x: int) -> Pixel:
        return self.pixel(0, self._subpasses(0), y, x)

    def _subpasses(self, level: int) -> int:
        return self.passes * self.side**2 if level < self._corrected_levels() else 0

    def _corrected_levels(self) -> int:
        """Corrected are the three finest levels, and all up to the coarsest on which pixels were moved."""
        moved = [level + 1 for level in range(len(self.levels)) if self.jitter(level)]
        return max([min(3, len(self.levels)), *moved])

    def _next(self, level: int, after: int, y: int, x: int) -> Pixel:
        turn = divmod((after - 1) % self.side**2, self.side)
        if (y % self.side, x % self.side) != turn or self._without_jitter(level, y, x):
            return self.pixel(level, after - 1, y, x)
        return self.levels[level].corrected(
            (y, x),
            lambda a, b: self.pixel(level, after - 1, a, b),
            self.rule,
            self.factor,
            self.orientation(level, y, x),
        )

    def _without_jitter(self, level: int, y: int, x: int) -> bool:
        """What none of the jitter holds for is corrected on the three finest levels alone, as without jitter."""
        if self.share is None or level < 3:
            return False
        return self.share(self._middle(level, y, x), self.pixel(level, 0, y, x)) == 0

    def _middle(self, level: int, y: int, x: int) -> Pixel:
        h = 1 << level
        return h * y + h // 2, h * x + h // 2

    def _begun(self, level: int, after: int, y: int, x: int) -> Pixel:
        if not self.guides:
            return self.pixel(level, DESCENDED, y, x)

        def drawn(n: int) -> int:
            return draw(self.seed, self.stage + 1, 8 * level + n, y, x)

        toroidal = self.levels[0].toroidal
        return self.guides[level].placed_by_guide(
            (y, x), lambda a, b: self.pixel(level, DESCENDED, a, b), toroidal, drawn
        )

    def _fresh(self, level: int, after: int, y: int, x: int) -> Pixel:
        if level != self.count - 2 or level < self._corrected_levels() or not self.jitter(level):
            return self._moved(level, y, x, 0)
        places, around = [self._moved(level, y, x, n) for n in range(self.drawn)], []
        for dy in range(-2, 3):
            for dx in range(-2, 3):
                if 2 * ((y + dy) % 2) + (x + dx) % 2 < 2 * (y % 2) + x % 2:
                    around.append((dy, dx, self.pixel(level, DESCENDED, y + dy, x + dx)))
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
            u = list(stepped(self.orientation(level, y, x), h * y + h // 2, h * x + h // 2))
        else:
            parent = self.pixel(level + 1, self._subpasses(level + 1), y // 2, x // 2)
            step = stepped(self.orientation(level, y, x), *((h * (2 * (c % 2) - 1)) // 2 for c in (y, x)))
            u = [a + b for a, b in zip(parent, step, strict=True)]
        bits, r = draw(self.seed, self.stage, level + number * self.count, y, x), self.jitter(level)
        if self.share is not None:
            here = u[0] % self.size[0], u[1] % self.size[1]
            r = math.floor(r * self.share(self._middle(level, y, x), here) + 0.5)
        for axis, word in enumerate((bits >> 32, bits & 0xFFFFFFFF)):  # floor(h r H + 1/2), H in [-1, 1)
            u[axis] += (2 * r * (word - (1 << 31)) + (4096 << 31)) // (2 * 4096 << 31)
            u[axis] %= self.size[axis]
        return u[0], u[1]
