"""The pyramid search as published: at every level one place is drawn, and only it is followed (Multrus 2003, 4.3.1)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...analysis.features import Features
from ...arrays import Array
from ...draws import below, draw
from ...search.candidates import Candidates, Prices
from ...search.posed import PosedExemplars
from . import pyramid_kernels
from .pyramid import LEVELS, PyramidSearch
from .repeats import Factors


@dataclass(frozen=True, eq=False)
class Drawn:
    """Who may be drawn: `admitted` of prices, the lowest first, at a brightness; `at_bounds` where labels meet."""

    seed: int
    stage: int
    admitted: Callable[[Array, int], int]
    at_bounds: int
    features: Features


class DrawnPyramid(PyramidSearch):
    """Search from coarse to fine, with a draw at every level; the answer is one candidate."""

    def __init__(
        self, variants: PosedExemplars, patch: tuple[int, int], seam: tuple[int, int], smoothing: str, drawn: Drawn
    ) -> None:
        super().__init__(variants, patch, seam, smoothing, drawn.at_bounds, drawn.at_bounds)
        self.drawn = drawn

    def find(self, variant: Array, yx: Array, at: Array, wrap: tuple[bool, bool], prices: Prices) -> list[Candidates]:
        """Return one candidate for each of the windows that begin at `at` (n, 2) of a growing map."""
        stack = self.stack(variant, yx, at, wrap)
        return [self._drawn([(f[k], known[k]) for f, known in stack], at[k].tolist(), prices) for k in range(len(at))]

    def _drawn(self, stack: list[tuple[Array, Array]], at: list[int], prices: Prices) -> Candidates:
        chosen, usual = np.empty((0, 4), np.int64), 0
        if not stack[0][1].any():
            return Candidates(chosen, usual, *stack[0], free=True)
        for number in range(LEVELS, -1, -1):
            feats, known = stack[number]
            rows = self._near(number, chosen, feats, known)
            if number == LEVELS:  # as the other searches tell it, for prices that are added
                usual = int(np.partition(rows[:, 0], len(rows) // 20)[len(rows) // 20]) // int(known.sum())
            unit = prices.weight * usual * int(known.sum()) >> 8
            costs = np.empty(len(rows), np.int64)
            for v, counts in enumerate(prices.counts):
                mine = rows[:, 1] == v
                y, x = (np.minimum(rows[mine, 2 + a] << number, counts.shape[a] - 1) for a in (0, 1))
                d, count = rows[mine, 0], counts[y, x].astype(np.int64)
                costs[mine] = d * (256 + count) ** 2 >> 16 if isinstance(prices, Factors) else d + (count * unit >> 16)
            order = np.argsort(costs, kind="stable")
            many = self.drawn.admitted(costs[order], self.drawn.features.brightness(feats, known)) or 1
            chosen = rows[order[self._number(many, number, at)]][None]
        return Candidates(chosen, usual * int(stack[0][1].sum()), *stack[0])

    def _near(self, number: int, chosen: Array, feats: Array, known: Array) -> Array:
        """All places of a level, measured, or those near the one that was chosen before: (n, 4) as candidates."""
        level, out = self.levels[number], []
        for v, allowed in enumerate(level.allowed):
            near, squared = np.zeros(allowed.shape, np.bool_), np.empty(allowed.shape, np.int64)
            if allowed.any():
                many = -1 if number == LEVELS else 1
                pyramid_kernels.mark_near(chosen, many, v, level.reach, allowed, near)
                pyramid_kernels.measure_all(feats.ravel(), known, level.flat, level.table[v], near, squared)
            y, x = np.nonzero(near)
            out.append(np.stack([squared[near], np.full(len(y), v), y, x], axis=1))
        return np.concatenate(out)

    def followed(self, best: Array, found: Array, at: Array, number: int) -> None:
        """Draw one of the best (n, K, 4) of each window, of which `found` (n,) count, and leave it alone."""
        for k in np.flatnonzero(found > 1).tolist():
            best[k, 0] = best[k, self._number(int(found[k]), number, at[k].tolist())]
            found[k] = 1

    def _number(self, many: int, number: int, at: list[int]) -> int:
        return below(many, draw(self.drawn.seed, self.drawn.stage, 1 + number, *at))
