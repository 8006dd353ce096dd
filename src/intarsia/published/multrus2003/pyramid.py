"""Multiresolution patch search: all positions at a quarter of the resolution, then only around the best of them.

Multrus 2003, 4.3. The source follows a single position from level to level and goes astray on regular textures; here
the best few are kept. The source draws at every level: `draw` of PyramidSearch.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...foundation import ParameterError, ndimage
from ...foundation.arrays import Array, Int64, Mask, Pair
from ...kernels.maps import OrientedExemplars, PartialMap
from ...search import SHORT_LIST, Candidates, PosedExemplars, Prices, fourier_kernels, nearest
from ...search.fourier_kernels import FAR
from .guided_search import GuidedPatchSearch
from .pyramid_kernels import KNOWN, OUTSIDE, decimate
from .repetition import UseFactors

LEVELS = 2  # reductions by two
MARGIN = 1 << LEVELS  # what filters see around a window, px
BATCH = 16
MIN_SIDE = 4  # shortest patch and seam: the coarsest level keeps 1 px of them
FILTERS = {
    "mean": ((1, 1, 1), (1, 1, 1), (1, 1, 1)),
    "gaussian": ((1, 2, 1), (2, 4, 2), (1, 2, 1)),
    "none": ((0, 0, 0), (0, 1, 0), (0, 0, 0)),
}
"""Filters applied before decimation by two: as in the source, weighted to the middle, none."""

Stack = list[tuple[Array, Array]]
"""Features (n, h, w, C) of windows and which of their pixels are known (n, h, w), at all levels, from fine to coarse;
or those of one window."""


@dataclass(frozen=True, eq=False)
class PyramidLevel:
    """One level of the pyramid: posed exemplars at 1 / 2**level, and the windows' size there.

    ``posed``: features and table as in PosedExemplars; ``allowed``: for every variant the positions from which a valid
    patch can be reached; ``reach``: how far around a projected position is searched.
    """

    posed: OrientedExemplars
    allowed: list[Mask]
    window: Pair
    reach: Int64


class PyramidSearch:
    """Search patches of one size in a set of variants, from coarse to fine.

    `patch`, for which the variants are laid out: rows and columns of the windows, seams included; `seam`: rows and
    columns of these; `smoothing`: one of FILTERS; `kept`: positions followed from each level to the next finer one;
    `listed`: candidates returned. `draw`: as published (4.3.1), one place is drawn at every level, and only it is
    followed; the answer is one. Of costs, the lowest first, it returns the number of one, by the level, the window's
    first pixel, its features and known pixels there, and whether a guide counts, of which `kept` costs are given.
    """

    factor = 1

    def __init__(
        self, variants: PosedExemplars, patch: Pair, seam: Pair, smoothing: str = "mean",
        kept: int = 1, listed: int = SHORT_LIST, draw: Callable[..., int] | None = None,
    ) -> None:  # fmt: skip
        self.variants, self.patch, self.seam, self.kept, self.listed = variants, patch, seam, kept, listed
        self.cells, self.smoothing, self.draw = patch, smoothing, draw
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
                whole = [(p[None], np.full((1, *p.shape[:2]), KNOWN, np.uint8)) for p in pictures]
                pictures = [self._reduced(*one, np.array([True]))[0][0] for one in whole]
            high, wide = (level_size(p, s, level) for p, s in zip(self.patch, self.seam, strict=True))
            begins = np.cumsum([0] + [p.size for p in pictures])
            table = [(b, *p.shape[:2], p.shape[1]) for b, p in zip(begins.tolist(), pictures, strict=False)]
            flat = np.concatenate([p.ravel() for p in pictures]) if level else self.variants.flat
            reach = np.array((high, wide), np.int64) // 2 + 1  # a square of twice the side, and 1 px of slack
            out.append(PyramidLevel(OrientedExemplars(flat, np.array(table, np.int64)), [], (high, wide), reach))
        return out

    @staticmethod
    def _allowed(v: int, level: PyramidLevel, finer: PyramidLevel) -> Mask:
        """Return the positions from which the search at the finer level reaches an allowed one."""
        shape = level.posed.table[v, 1:3].tolist()
        rows, columns = (max(n - w + 1, 0) for n, w in zip(shape, level.window, strict=True))
        allowed = finer.allowed[v]
        if not allowed.size or not rows * columns or not allowed.any():
            return np.zeros((rows, columns), bool)
        size = (2 * finer.reach + 1).tolist()
        near = ndimage.maximum_filter(allowed.astype(np.uint8), size=size, mode="constant")
        y = np.minimum(2 * np.arange(rows), allowed.shape[0] - 1)
        x = np.minimum(2 * np.arange(columns), allowed.shape[1] - 1)
        return np.asarray(near[np.ix_(y, x)] > 0)

    def batch(self) -> int:
        """How many windows are best searched together."""
        return BATCH

    def find(self, grown: PartialMap, at: Array, prices: Prices) -> list[Candidates]:
        """Return the candidates for the windows that begin at `at` (n, 2) of a partial map, as PatchSearch does."""
        stack = self.stack(grown, at)
        return [self.search_window(window_stack(stack, k), place, prices) for k, place in enumerate(at.tolist())]

    def search_window(
        self, stack: Stack, at: list[int], prices: Prices, join: Callable[[int, Array], Array] | None = None
    ) -> Candidates:
        """Return the candidates for the window that begins at `at`, searched from the coarsest level down.

        `join`: under a guide, returns the costs of candidates (n, 4) at a level.
        """
        (feats, known), usual, rows = stack[0], -1, np.empty((0, 4), np.int64)
        if join is None and not known.any():
            return Candidates(rows, 0, feats, known)
        sums, drawing = [int(known.sum()) for _, known in stack], self.draw is not None and join is None
        total = max(sums[LEVELS], 1)
        for number in range(LEVELS, -1, -1):
            here = usual * sums[number] // total
            every = [self._near(number, v, rows, *stack[number]) for v in range(len(self.variants))]
            costs = []
            for mine, allowed in zip(every, self.levels[number].allowed, strict=True):
                if here < 0 and drawing:
                    here = low_quantile(np.concatenate(every)) // total * total
                elif here < 0:
                    step = max(1, int(np.sqrt(allowed.size / 500.0)))
                    here = low_quantile(mine[(mine[:, 2] % step == 0) & (mine[:, 3] % step == 0)])
                if join is not None:
                    mine[:, 0] = join(number, mine)
                costs.append(priced_distances(mine, prices, number, prices.weight * max(here, 0) >> 8))
            usual = here if number == LEVELS else usual
            rows, cost = np.concatenate(every), np.concatenate(costs)
            best = cheapest(cost, len(cost) if drawing else self.kept if number else self.listed)
            if self.draw is not None and len(best):
                best = best[[self.draw(cost[best], number, at, stack[number], not drawing)]]
            rows = rows[np.sort(best)]
        return Candidates(nearest(rows), max(usual * sums[0] // total, 0), feats, known)

    def _near(self, number: int, v: int, coarse: Array, feats: Array, known: Array) -> Array:
        """Return a variant's positions near `coarse` candidates (n, 4), measured; at the coarsest level all."""
        level = self.levels[number]
        near = allowed = level.allowed[v]
        if number < LEVELS:
            near = np.zeros_like(allowed)
            middles = np.minimum(2 * coarse[coarse[:, 1] == v, 2:], np.array(allowed.shape) - 1)
            for (top, left), (bottom, right) in zip(
                np.maximum(middles - level.reach, 0).tolist(), (middles + level.reach + 1).tolist(), strict=True
            ):
                near[top:bottom, left:right] = allowed[top:bottom, left:right]
        at = np.flatnonzero(near)
        rows = np.empty((len(at), 4), np.int64)
        rows[:, 0], rows[:, 1] = FAR, v
        np.divmod(at, near.shape[1] or 1, rows[:, 2], rows[:, 3])
        fourier_kernels.measure(feats, known, level.posed, rows)
        return rows

    def stack(self, grown: PartialMap, at: Array) -> Stack:
        """Return features and known pixels of the windows at all levels."""
        feats, state = self.variants.windows(grown, at - MARGIN, [side + 2 * MARGIN for side in self.patch])
        inner = tuple(slice(MARGIN, MARGIN + side) for side in self.patch)
        finest = feats[:, *inner].copy(), state[:, *inner].copy()
        for axis, (length, wraps) in enumerate(zip(grown.variant.shape, grown.wrap, strict=True)):
            line = at[:, axis, None] - MARGIN + np.arange(state.shape[1 + axis])
            beyond = np.expand_dims((line < 0) | (line >= length), 2 - axis) & (not wraps)
            state[np.broadcast_to(beyond, state.shape)] = OUTSIDE
        return [finest, *self._coarser(feats, state)]

    def guide_stack(self, pictures: Array, inside: Array) -> Stack:
        """Return windows (n, h, w, C) at all levels, known where they lie `inside` (n, h, w) the canvas."""
        around = [(0, 0), (MARGIN, MARGIN), (MARGIN, MARGIN)]
        state = np.pad(np.where(inside > 0, np.uint8(KNOWN), np.uint8(OUTSIDE)), around, constant_values=OUTSIDE)
        return [(pictures, inside), *self._coarser(np.pad(pictures, [*around, (0, 0)]), state)]

    def _coarser(self, feats: Array, state: Array) -> Stack:
        """Return the coarser levels of windows with margins; where nothing stays known, any known pixel is enough."""
        stack = []
        for number, level in enumerate(self.levels[1:], 1):
            inner = np.s_[:, *(slice(MARGIN >> number, (MARGIN >> number) + side) for side in level.window)]
            strict = self._reduced(feats, state, np.zeros(len(feats), np.bool_))
            bare = ~(strict[1][inner] == KNOWN).any(axis=(1, 2))
            feats, state = self._reduced(feats, state, bare) if bare.any() else strict
            stack.append((np.ascontiguousarray(feats[inner]), (state[inner] == KNOWN).astype(np.uint8)))
        return stack

    def _reduced(self, feats: Array, state: Array, loose: Array) -> tuple[Array, Array]:
        n, rows, columns, channels = feats.shape
        state_out = np.empty((n, rows // 2, columns // 2), np.uint8)
        out = np.empty((*state_out.shape, channels), np.int16)
        decimate(feats, state, self.weights, loose, out, state_out)
        return out, state_out


class GuidedPyramid(GuidedPatchSearch):
    """Search patches for windows under a guide, from coarse to fine."""

    def _beside(self, search: PyramidSearch) -> PyramidSearch:
        return PyramidSearch(self.guidance.pictures, search.patch, search.seam, search.smoothing)

    def _weighed(self, search: PyramidSearch, grown: PartialMap, at: Array, prices: Prices) -> list[Candidates]:
        stack, beside = search.stack(grown, at), self.guide.guide_stack(*self.guidance.wanted(at))
        shares = [self.shares(known, inside) for (_, known), (_, inside) in zip(stack, beside, strict=True)]

        def join(k: int, number: int, rows: Array) -> Array:
            apart = rows.copy()
            apart[:, 0] = FAR
            fourier_kernels.measure(*window_stack(beside, k)[number], self.guide.levels[number].posed, apart)
            return self.cost(rows[:, 0], apart[:, 0], shares[number][k])

        places = enumerate(at.tolist())
        return [search.search_window(window_stack(stack, k), place, prices, partial(join, k)) for k, place in places]


def window_stack(stack: Stack, k: int) -> Stack:
    """Return the levels of the k-th of the windows of a stack."""
    return [(feats[k], known[k]) for feats, known in stack]


def low_quantile(rows: Array) -> int:
    """Return the 5 % quantile of the distances of candidates (n, 4); -1 if there is none."""
    low = len(rows) // 20
    return int(np.partition(rows[:, 0], low)[low]) if len(rows) else -1


def priced_distances(rows: Array, prices: Prices, level: int, unit: int) -> Array:
    """Return the distances of one variant's candidates (n, 4) at a level with the price of repeats.

    The price is added, or multiplied for Factors. Repeats are counted at level 0, and every 2**level-th is read;
    `unit`: price of one, in 1/256.
    """
    d, v, *place = rows.T
    counts = prices.counts[v[0] if len(v) else 0]
    y, x = (np.minimum(p << level, n - 1) for p, n in zip(place, counts.shape, strict=True))
    count = counts[y, x].astype(np.int64)
    return np.asarray(d * (256 + count) ** 2 >> 16 if isinstance(prices, UseFactors) else d + (count * unit >> 16))


def cheapest(costs: Array, size: int) -> Array:
    """Return the indices of the `size` lowest costs, in ascending order; of equal ones the first comes first."""
    among = np.arange(len(costs))
    if size < len(costs):
        among = np.flatnonzero(costs <= np.partition(costs, size - 1)[size - 1])
    return among[np.argsort(costs[among], kind="stable")][:size]


def level_size(patch: int, seam: int, level: int) -> int:
    """Return the side of a window at a level: patch and seams are halved each for itself (Multrus 2003, 4.3.1)."""
    inner = max(patch - 2 * seam, 0)
    return max((inner >> level) + 2 * (seam >> level), 1)


def check_pyramid(patch: Pair, seam: Pair) -> None:
    """Raise ParameterError for patches or seams (rows, columns) that would vanish at the coarsest level."""
    if min(patch) < MIN_SIDE or min(seam) < MIN_SIDE:
        raise ParameterError(
            f"a pyramid needs at least {MIN_SIDE} px of patch without seams and of seam, not {min(patch)} and "
            f"{min(seam)}; choose larger ones, or pyramid=off."
        )
