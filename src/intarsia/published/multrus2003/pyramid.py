"""The pyramid search: all positions at a quarter of the resolution, then only around the best of them.

Multrus 2003, 4.3. The source follows a single position from level to level and loses its way on regular textures; here
several are kept, always the best. The source draws at every level: `DrawnPyramid`.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...analysis.features import Features
from ...foundation import ParameterError, ndimage
from ...foundation.arrays import Array, Int16, Int64, Mask, Pair
from ...foundation.run import below, draw
from ...kernels.maps import Grown
from ...search import SHORT_LIST, Candidates, PosedExemplars, Prices, fourier_kernels, in_one_row
from ...search.fourier_kernels import Listed
from . import pyramid_kernels
from .guided import GuidedByRoots
from .pyramid_kernels import Rung
from .repeats import Factors

LEVELS = 2  # reductions by two
MARGIN = 1 << LEVELS  # what filters see around a window, px
BATCH = 16
LEAST = 4  # shortest patch and seam: the coarsest level keeps 1 px of them
FILTERS = {
    "mean": ((1, 1, 1), (1, 1, 1), (1, 1, 1)),
    "gaussian": ((1, 2, 1), (2, 4, 2), (1, 2, 1)),
    "none": ((0, 0, 0), (0, 1, 0), (0, 0, 0)),
}
"""What is averaged before every second pixel is dropped: as in the source, with more weight in the middle, nothing."""


@dataclass(frozen=True, eq=False)
class PyramidLevel:
    """One level of the pyramid: posed exemplars at 1 / 2**level, and the windows' size there.

    ``flat`` and ``table`` as in PosedExemplars; ``allowed``: for every variant the positions from which a valid patch
    can be reached; ``reach``: how far around a projected position is searched.
    """

    flat: Int16
    table: Int64
    allowed: list[Mask]
    window: Pair
    reach: Int64


class PyramidSearch:
    """Search patches of one size in a set of variants, from coarse to fine.

    `patch`, for which the variants are laid out: rows and columns of the windows, seams included; `seam`: rows and
    columns of these; `smoothing`: one of FILTERS; `kept`: positions followed from each level to the next finer one;
    `listed`: candidates returned.
    """

    factor = 1

    def __init__(
        self, variants: PosedExemplars, patch: Pair, seam: Pair, smoothing: str = "mean",
        kept: int = 1, listed: int = SHORT_LIST,
    ) -> None:  # fmt: skip
        self.variants, self.patch, self.seam, self.kept, self.listed = variants, patch, seam, kept, listed
        self.cells, self.smoothing = patch, smoothing
        self.weights = np.array(FILTERS[smoothing], np.int64)
        self.levels = self._levels()
        self._limit(variants.valid)

    def within(self, valid: Sequence[Array]) -> PyramidSearch:
        """Return the same search among some patches only: of every variant, where they may begin."""
        narrow = copy.copy(self)
        narrow._limit(valid)
        return narrow

    def _limit(self, valid: Sequence[Array]) -> None:
        """Search among these patches only, and at coarse levels where one of them can be reached."""
        self.valid = list(valid)
        self.flat_valid, self.offsets = in_one_row(self.valid)
        levels = [replace(self.levels[0], allowed=self.valid)]
        for level in self.levels[1:]:
            allowed = [self._allowed(v, level, levels[-1]) for v in range(len(self.variants))]
            levels.append(replace(level, allowed=allowed))
        self.levels = levels

    def _levels(self) -> list[PyramidLevel]:
        pictures = [self.variants.picture(v) for v in range(len(self.variants))]
        out: list[PyramidLevel] = []
        for level in range(LEVELS + 1):
            if level:
                pictures = [self._halved(p) for p in pictures]
            sides = tuple(level_size(p, s, level) for p, s in zip(self.patch, self.seam, strict=True))
            window = (sides[0], sides[1])
            begins = np.cumsum([0] + [p.size for p in pictures])
            table = [(b, *p.shape[:2], p.shape[1]) for b, p in zip(begins.tolist(), pictures, strict=False)]
            reach = np.array([n // 2 + 1 for n in window], np.int64)  # a square of twice the side, and 1 px of slack
            flat = np.concatenate([p.ravel() for p in pictures]) if level else self.variants.flat
            out.append(PyramidLevel(flat, np.array(table, np.int64), [], window, reach))
        return out

    def _halved(self, picture: Array) -> Array:
        rows, columns = picture.shape[0] // 2, picture.shape[1] // 2
        out, state = np.empty((rows, columns, picture.shape[2]), np.int16), np.empty((rows, columns), np.uint8)
        pyramid_kernels.halve(picture, np.ones(picture.shape[:2], np.uint8), self.weights, True, out, state)
        return out

    @staticmethod
    def _allowed(v: int, level: PyramidLevel, finer: PyramidLevel) -> Mask:
        """Positions from which the search at the finer level finds one that is allowed."""
        shape = level.table[v, 1:3].tolist()
        rows, columns = (max(n - w + 1, 0) for n, w in zip(shape, level.window, strict=True))
        allowed = finer.allowed[v]
        if not allowed.size or not rows * columns or not allowed.any():
            return np.zeros((rows, columns), bool)
        size = (2 * finer.reach + 1).tolist()
        near = ndimage.maximum_filter(allowed.astype(np.uint8), size=size, mode="constant")
        y = np.minimum(2 * np.arange(rows), allowed.shape[0] - 1)
        x = np.minimum(2 * np.arange(columns), allowed.shape[1] - 1)
        return np.asarray(near[np.ix_(y, x)] > 0)

    def followed(self, best: Array, found: Array, at: Array, number: int) -> None:
        """Leave of the `best` of a level what is followed to the next one: here all that was kept."""

    def batch(self) -> int:
        """How many windows are best searched together."""
        return BATCH

    def find(self, grown: Grown, at: Array, prices: Prices) -> list[Candidates]:
        """Return the candidates for the windows that begin at `at` (n, 2) of a growing map, as PatchSearch does."""
        stack = self.stack(grown, at)
        n = len(at)
        sums = np.array([[k.sum() for k in known] for _, known in stack], np.int64)  # (levels, n)
        usual = np.full(n, -1, np.int64)
        kept, many = np.empty((n, 0, 4), np.int64), np.full(n, -1, np.int64)
        for number in range(LEVELS, -1, -1):
            level, (feats, known) = self.levels[number], stack[number]
            size = self.kept if number else self.listed
            best, found = np.empty((n, size + 1, 4), np.int64), np.zeros(n, np.int64)
            here = usual if number == LEVELS else to_level(usual, sums, number)
            for v, allowed in enumerate(level.allowed):
                if allowed.any():
                    pyramid_kernels.search_level(
                        feats, known, Rung(level.flat, level.table[v], allowed, number, v), fee_of(prices, v),
                        Listed(best, found, here), kept, many, level.reach,
                    )  # fmt: skip
            kept, many = best, found
        feats, known = stack[0]
        rows = np.empty((n, self.listed, 4), np.int64)
        fourier_kernels.refine(
            feats, known, self.variants.posed, fourier_kernels.Among(self.flat_valid, self.offsets),
            np.ascontiguousarray(kept[:, : self.listed]), many, 1, rows,
        )  # fmt: skip
        return Candidates.of_all(rows, many, np.maximum(to_level(usual, sums, 0), 0).tolist(), feats, known)

    def stack(self, grown: Grown, at: Array) -> list[tuple[Array, Array]]:
        """Features and known pixels of the windows at all levels, from fine to coarse."""
        feats, state = self.variants.windows(grown, at - MARGIN, [side + 2 * MARGIN for side in self.patch])
        inner = tuple(slice(MARGIN, MARGIN + side) for side in self.patch)
        stack = [(feats[:, *inner].copy(), state[:, *inner].copy())]
        for k, (y, x) in enumerate((at - MARGIN).tolist()):
            pyramid_kernels.mark_outside(state[k], y, x, grown.variant.shape, grown.wrap)
        return stack + self._coarser(feats, state)

    def whole_stack(self, pictures: Array, inside: Array) -> list[tuple[Array, Array]]:
        """Windows (n, h, w, C) of which all is known that lies `inside` (n, h, w), at all levels."""
        around = [(0, 0), (MARGIN, MARGIN), (MARGIN, MARGIN)]
        feats = np.pad(pictures, [*around, (0, 0)])
        state = np.pad(np.where(inside > 0, pyramid_kernels.KNOWN, pyramid_kernels.OUTSIDE).astype(np.uint8), around,
                       constant_values=pyramid_kernels.OUTSIDE)  # fmt: skip
        return [(pictures, inside), *self._coarser(feats, state)]

    def _coarser(self, feats: Array, state: Array) -> list[tuple[Array, Array]]:
        """The coarser levels of windows; where little is known, any known pixel is enough."""
        stack = []
        for level in self.levels[1:]:
            strict = self._reduced(feats, state, np.zeros(len(feats), np.bool_))
            bare = ~(self._cut(strict[1], level) == pyramid_kernels.KNOWN).any(axis=(1, 2))
            feats, state = self._reduced(feats, state, bare) if bare.any() else strict
            known = (self._cut(state, level) == pyramid_kernels.KNOWN).astype(np.uint8)
            stack.append((np.ascontiguousarray(self._cut(feats, level)), known))
        return stack

    def _reduced(self, feats: Array, state: Array, loose: Array) -> tuple[Array, Array]:
        shape = (feats.shape[0], feats.shape[1] // 2, feats.shape[2] // 2)
        out, out_state = np.empty((*shape, feats.shape[3]), np.int16), np.empty(shape, np.uint8)
        pyramid_kernels.reduce_windows(feats, state, self.weights, loose, out, out_state)
        return out, out_state

    def _cut(self, array: Array, level: PyramidLevel) -> Array:
        """Take the window itself out of its reduced surroundings."""
        margin = MARGIN >> next(k for k, own in enumerate(self.levels) if own is level)
        return array[:, margin : margin + level.window[0], margin : margin + level.window[1]]


class GuidedPyramid(GuidedByRoots):
    """Search patches for windows under a guide, from coarse to fine."""

    def _beside(self, search: PyramidSearch) -> PyramidSearch:
        return PyramidSearch(self.guidance.pictures, search.patch, search.seam, search.smoothing)

    def _weighed(self, search: PyramidSearch, grown: Grown, at: Array, prices: Prices) -> list[Candidates]:
        n, guide = len(at), self.guide
        stack = search.stack(grown, at)
        beside = guide.whole_stack(*self.guidance.wanted(at))
        sums = np.array([known.sum(axis=(1, 2), dtype=np.int64) for _, known in stack])
        usual = np.full(n, -1, np.int64)
        best, found = np.empty((n, 0, 4), np.int64), np.full(n, -1, np.int64)
        for number in range(LEVELS, -1, -1):
            (feats, known), (wanted, inside) = stack[number], beside[number]
            level, labels = search.levels[number], guide.levels[number]
            shares = self.shares(known, inside)
            here = usual if number == LEVELS else to_level(usual, sums, number)
            kept, many = best, found
            best = np.empty((n, (search.kept if number else search.listed) + 1, 4), np.int64)
            found = np.zeros(n, np.int64)
            for v, allowed in enumerate(level.allowed):
                rung, near = Rung(level.flat, level.table[v], allowed, number, v), np.empty(allowed.shape, np.bool_)
                dist, apart = np.empty((2, *allowed.shape), np.int64)
                for k in range(n if allowed.any() else 0):
                    pyramid_kernels.mark_near(kept[k], many[k], v, level.reach, allowed, near)
                    pyramid_kernels.measure_all(feats[k].ravel(), known[k], rung.flat, rung.frame, near, dist)
                    pyramid_kernels.measure_all(wanted[k].ravel(), inside[k], labels.flat, labels.table[v], near, apart)
                    if here[k] < 0:
                        here[k] = pyramid_kernels.low_quantile(dist)
                    dist[near] = self.cost(dist[near], apart[near], shares[k])
                    unit = prices.weight * max(here[k], 0) >> 8
                    found[k] = pyramid_kernels.list_level(dist, rung, fee_of(prices, v), unit, best[k], found[k])
            search.followed(best, found, at, number)
        told = np.maximum(to_level(usual, sums, 0), 0).tolist()
        out = []
        for k in range(n):
            window = tuple(array[k] for array in (feats, known, wanted, inside))
            rows = self.measured(search, window, shares[k], best[k, : found[k]])
            out.append(Candidates(rows, told[k], feats[k], known[k]))
        return out


def fee_of(prices: Prices, v: int) -> pyramid_kernels.Fee:
    """What repeats cost at the positions of one variant: added to distances, or multiplied with them."""
    return pyramid_kernels.Fee(prices.counts[v], prices.weight, isinstance(prices, Factors))


def to_level(usual: Array, sums: Array, level: int) -> Array:
    """Return the usual distances of the coarsest level in units of another; `sums` (levels, n): known pixels."""
    return np.asarray(usual * sums[level] // np.maximum(sums[LEVELS], 1))


def level_size(patch: int, seam: int, level: int) -> int:
    """Return the side of a window at a level: patch and seams are halved each for itself (Multrus 2003, 4.3.1)."""
    inner = max(patch - 2 * seam, 0)
    return max((inner >> level) + 2 * (seam >> level), 1)


def check_pyramid(patch: Pair, seam: Pair) -> None:
    """Refuse patches and seams (rows, columns) of which nothing would be left at the coarsest level."""
    if min(patch) < LEAST or min(seam) < LEAST:
        raise ParameterError(
            f"a pyramid needs at least {LEAST} px of patch without seams and of seam, not {min(patch)} and "
            f"{min(seam)}; choose larger ones, or pyramid=off."
        )


@dataclass(frozen=True, eq=False)
class Drawn:
    """Who may be drawn: `admitted` of prices, the lowest first, at a brightness; `at_bounds` where labels meet."""

    seed: int
    stage: int
    admitted: Callable[[Array, int], int]
    at_bounds: int
    features: Features


class DrawnPyramid(PyramidSearch):
    """Search as published (4.3.1): at every level one place is drawn, and only it is followed; the answer is one."""

    def __init__(
        self, variants: PosedExemplars, patch: Pair, seam: Pair, smoothing: str, drawn: Drawn
    ) -> None:
        super().__init__(variants, patch, seam, smoothing, drawn.at_bounds, drawn.at_bounds)
        self.drawn = drawn

    def find(self, grown: Grown, at: Array, prices: Prices) -> list[Candidates]:
        """Return one candidate for each of the windows that begin at `at` (n, 2) of a growing map."""
        stack = self.stack(grown, at)
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
