"""Engine of segment-based synthesis: sizes from segments, candidates from histograms of segments in the boundary zone.

Source: the fragments (docs/sources-003.md), algorithm SegmentBased, lines 1 and 7 to 10, and SelectFeature. A histogram
does not see how segments are arranged, so it only selects the patches to compare: these are then measured pixel by
pixel. All decisions are made on whole numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...analysis import factor_for, reduced, running_sums
from ...analysis.features import contrast, features
from ...foundation.arrays import Array, Int64, Mask, Pair
from ...foundation.params import AUTO, extent
from ...foundation.run import Run, below, draw_many
from ...kernels.maps import PartialMap
from ...model import Exemplar, Exemplars
from ...model.canvas import Canvas
from ...model.sourcemap import HOLE, SourceMap
from ...patches import Pick
from ...patches.patch_synthesis import PatchSettings, PatchSynthesis
from ...search import Candidates, PosedExemplars, Prices, check_patch, fourier_kernels, nearest, patch_with_supply
from ...search.fourier_kernels import FAR
from ...segments import Segments, candidates_at, fallback, of_group, scales, segments
from ...segments.feature_group import DISC, FINE, Group
from ...segments.felzenszwalb import even_colours
from .segment_based import SegmentBased

STAGE = 2008  # keeps this method's draws apart from those of others
POINTS = 1 << 20  # draws of points are apart from those of the choice
LEVELS = 24  # steps of the root of a share; of 8 groups at most, 25 to the power of 8 fits into 64 bits
USUAL = 50  # one in so many of those compared is nearer than usual; 20: seams cost 3 to 16 % more, 100: fewer draws
PATCHES = 1 << 18  # of a larger exemplar only every second, third, ... row and column is indexed
Sides = tuple[bool, ...]  # top, left, bottom, right


def resolved(method: SegmentBased, exemplars: Exemplars, canvas: Canvas) -> SegmentBased:
    """Return the method with patch and overlap derived from the segments of the exemplar."""
    patch, overlap = method.patch, method.overlap
    if patch is AUTO:
        found = _found(method, exemplars[0])
        patch = patch_with_supply(exemplars, found.patch)
        if overlap is AUTO:  # a mask may leave less than the zone
            overlap = min(found.zone, patch - 1)
    elif overlap is AUTO:
        rows, columns = extent(patch)
        overlap = (rows // 4, columns // 4) if rows != columns else rows // 4
    check_patch(patch, exemplars)
    return replace(method, patch=patch, overlap=overlap)


def synthesize(method: SegmentBased, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Build the map window by window, from patches with similar segments in the boundary zone."""
    groups, zone = _found(method, exemplars[0]).group_map, extent(method.overlap or 0)
    its = PatchSettings(
        patch=method.footprint, overlap=zone, hangs=method.hangs,
        finder=lambda _, variants, patch, listed: SegmentSearch(
            variants, patch, groups, zone, method.hits, method.points, seed, STAGE + POINTS
        ),
        usage=method.repeat_penalty,
    )  # fmt: skip
    growth = PatchSynthesis(its, exemplars, canvas)
    limit = None if method.threshold is AUTO else method.threshold * contrast(growth.features, exemplars)

    def chosen(window: Pair, found: Candidates, bits: int) -> Pick:
        prices = growth.repetition.prices(*window, found)
        return choose(found, prices, found.usual if limit is None else limit * int((found.known > 0).sum()), bits)

    growth.fill(seed, STAGE, run, choose=chosen, join=growth.cutting())
    return growth.map(method.blend)


def _found(method: SegmentBased, exemplar: Exemplar) -> Segments:
    if method.energy == "vote":
        return segments(exemplar)
    known = ("published segments", method.energy)
    return exemplar.memo(known, lambda: published_segments(exemplar, method.energy))


def choose(found: Candidates, prices: Array, limit: float, bits: int) -> Pick:
    """Draw one of the patches whose squared difference, with the price of a repeat, is below `limit`, or the best."""
    near = np.flatnonzero(prices < limit)
    v, y, x = found.rows[near[below(len(near), bits)] if len(near) else int(np.argmin(prices)), 1:].tolist()
    return v, y, x


class HistogramIndex:
    """Index of all patches of an exemplar by the histogram of groups in some sides of their boundary zone.

    `counts` (K, rows, columns): pixels of every group in the zone of the patch that begins there; `valid` (rows,
    columns): which patches may be used. ``histograms`` (n, K): the different ones, see :func:`histogram`, sorted by
    their last entry, then by the one before.
    """

    def __init__(self, counts: Array, valid: Mask) -> None:
        patches = np.flatnonzero(valid)
        values = histogram(counts.reshape(len(counts), -1)[:, patches].T)
        code = values @ ((LEVELS + 1) ** np.arange(values.shape[1], dtype=np.int64))
        _, first, number = np.unique(code, return_index=True, return_inverse=True)
        self.histograms = values[first]
        self._patches = patches[np.argsort(number, kind="stable")]
        self._begins = np.concatenate([[0], np.cumsum(np.bincount(number))]).tolist()
        from scipy.spatial import cKDTree  # it is slow to import

        self._tree = cKDTree(self.histograms)

    def members(self, number: int) -> Int64:
        """Return the patches of a histogram, as positions in the flattened (rows, columns), in order."""
        return np.asarray(self._patches[self._begins[number] : self._begins[number + 1]])

    def near(self, query: Int64, hits: int) -> Int64:
        """Return the numbers of the `hits` nearest histograms, nearest first, of equal ones the first."""
        k = min(hits, len(self.histograms))
        reach = float(np.max(self._tree.query(query, k=k)[0]))  # of the k-th
        inside = np.array(self._tree.query_ball_point(query, reach * (1 + 1e-9) + 1e-9, return_sorted=True), np.int64)
        return inside[np.argsort(((self.histograms[inside] - query) ** 2).sum(axis=1), kind="stable")[:k]]


class SegmentSearch:
    """Search for patches whose boundary zone has the same histogram of groups as the known part of a window.

    `variants`: one exemplar, upright; `patch`: rows and columns of the windows; `groups` (H, W): group of every pixel
    of the exemplar, 0 to 7, -1 where it must not be used; `zone`: width of the boundary zone, (rows, columns) px;
    `hits`, `points`: how many histograms are looked at for a window, and how many patches are drawn of each.
    """

    factor = 1

    def __init__(
        self, variants: PosedExemplars, patch: Pair, groups: Array, zone: Pair, hits: int,
        points: int, seed: int, stage: int,
    ) -> None:  # fmt: skip
        self.variants, self.patch, self.groups = variants, patch, groups
        self.zone = min(max(zone[0], 1), patch[0]), min(max(zone[1], 1), patch[1])
        self.hits, self.points, self.seed, self.stage = hits, points, seed, stage
        self.cells, self.valid = patch, list(variants.valid)
        self.kinds = int(groups.max(initial=0)) + 1
        self.step = max(1, math.isqrt(max(self.valid[0].size - 1, 0) // PATCHES) + 1)
        if not self.valid[0][:: self.step, :: self.step].any():
            self.step = 1
        self._grid = self.valid[0][:: self.step, :: self.step]
        self._indices: dict[Sides, HistogramIndex] = {}

    def batch(self) -> int:
        """Return how many windows are searched together."""
        return 32

    def find(self, grown: PartialMap, at: Array, prices: Prices) -> list[Candidates]:
        """Return the patches drawn for the windows that begin at `at` (n, 2), best first; repeats are priced later."""
        (h, w), variant = self.patch, grown.variant
        feats, known = self.variants.windows(grown, at, self.patch)
        found = []
        for k, (y, x) in enumerate(at.tolist()):
            rows = np.zeros((0, 4), np.int64)
            if known[k].any():
                index = np.ix_(np.arange(y, y + h) % variant.shape[0], np.arange(x, x + w) % variant.shape[1])
                groups = np.where(variant[index] != HOLE, self.groups[*np.moveaxis(grown.yx[index], 2, 0)], -1)
                rows = self.drawn(groups, known[k], (y, x))
                rows[:, 0] = FAR
                fourier_kernels.measure(feats[k], known[k], self.variants.posed, rows)
                rows = nearest(rows)
            usual = int(rows[len(rows) // USUAL, 0]) if len(rows) else 0
            found.append(Candidates(rows, usual, feats[k], known[k]))
        return found

    def drawn(self, groups: Array, known: Array, at: Pair) -> Int64:
        """Draw the patches to compare with a window that holds `groups`: rows of (0, 0, y, x)."""
        sides = self.known_sides(known)
        weight = np.where(known > 0, self.weights(sides), 0)
        counts = np.bincount(groups.ravel() + 1, weight.ravel(), self.kinds + 1)[1:]
        index = self.index(sides)
        near = index.near(histogram(counts[None])[0], self.hits)
        bits = draw_many(self.seed, self.stage, 1 + at[0], [(at[1], i) for i in range(len(near))])
        picked = [spread_sample(index.members(k), self.points, b) for k, b in zip(near.tolist(), bits, strict=True)]
        patches = np.sort(np.concatenate(picked))
        rows = np.zeros((len(patches), 4), np.int64)
        rows[:, 2], rows[:, 3] = (n * self.step for n in np.divmod(patches, self._grid.shape[1]))
        return rows

    def known_sides(self, known: Array) -> Sides:
        """Return which sides of a window's zone are known by more than half; or else at all; or else all four."""
        shares = [np.count_nonzero(known[s]) / known[s].size for s in self._strips()]
        most, anything = (tuple(bool(share > least) for share in shares) for least in (0.5, 0.0))
        return most if any(most) else anything if any(anything) else (True,) * 4

    def weights(self, sides: Sides) -> Int64:
        """Return how often every pixel of a window counts: once for each of the sides that it lies in."""
        out = np.zeros(self.patch, np.int64)
        for strip, wanted in zip(self._strips(), sides, strict=True):
            out[strip] += wanted
        return out

    def index(self, sides: Sides) -> HistogramIndex:
        """Return the index of all patches by the groups in these sides of their zone; cached."""
        if sides not in self._indices:
            counts = np.stack([self._counts(g, sides) for g in range(self.kinds)])
            self._indices[sides] = HistogramIndex(counts, self._grid)
        return self._indices[sides]

    def _counts(self, group: int, sides: Sides) -> Int64:
        """Return the count of a group in the sides of every indexed patch, by a summed-area table."""
        height, width = self.variants.picture(0).shape[:2]
        pad = ((0, height - self.groups.shape[0]), (0, width - self.groups.shape[1]))
        mine = np.pad(self.groups == group, pad, mode="wrap")  # a toroidal exemplar goes on
        sums = running_sums(mine, np.int32)
        (rows, columns), step = self.valid[0].shape, self.step

        def corner(y: int, x: int) -> Array:
            return sums[y : y + rows : step, x : x + columns : step]

        out = np.zeros(self._grid.shape, np.int64)
        for (down, across), wanted in zip(self._strips(), sides, strict=True):
            if wanted:
                out += corner(down.stop, across.stop) - corner(down.start, across.stop)
                out -= corner(down.stop, across.start) - corner(down.start, across.start)
        return out

    def _strips(self) -> tuple[tuple[slice, slice], ...]:
        (h, w), (b, c) = self.patch, self.zone
        rows, columns = slice(0, h), slice(0, w)
        return (slice(0, b), columns), (rows, slice(0, c)), (slice(h - b, h), columns), (rows, slice(w - c, w))


def histogram(counts: Array) -> Int64:
    """Return quantised square roots of shares (n, K), whose Euclidean distance approximates Hellinger's."""
    total = np.maximum(counts.sum(axis=1, keepdims=True), 1)
    return np.asarray(np.floor(np.sqrt(counts / total) * LEVELS + 0.5), np.int64)


def spread_sample(members: Int64, most: int, bits: int) -> Int64:
    """Return at most `most` members, evenly spaced from a random first one: the source's RandomPoint."""
    n = len(members)
    if n <= most:
        return members
    return members[(below(n, bits) + np.arange(most) * n // most) % n]


def _parts(group: Group) -> list[float]:
    """Return variance / range of distances and of sizes: the fractions of the fragments."""
    return [float(v.var() / max(np.ptp(v), 1.0)) for v in (group.distances / FINE, group.sizes.mean(axis=1))]


ENERGIES: dict[str, Callable[[Group], float]] = {
    "sum": lambda group: sum(_parts(group)) + group.edge_score / DISC,
    "product": lambda group: math.prod(_parts(group)) + group.edge_score / DISC,
    "variances": lambda group: float((group.offsets / FINE).var(axis=0).sum() + group.sizes.var(axis=0).sum()),
}
"""The pseudo-code Var(D) / range(D) + Var(W) / range(W) + Q, as a sum or a product; and the short text."""


def published_segments(exemplar: Exemplar, form: str) -> Segments:
    """Return the segments at the middle scale, with the group of least energy; of equal ones the first."""
    feats = features([exemplar])
    picture, usable = feats.pictures[0][:, :, : feats.base], exemplar.usable
    factor = factor_for(picture.shape)
    small, mask = reduced(picture, usable, factor)
    colours = even_colours(small, mask)
    if colours is None:
        return fallback(picture, usable, None, "The exemplar is constant.")
    every = list(scales(colours, mask))
    scale, tree = every[len(every) // 2]
    pixels = small.shape[0] * small.shape[1] if mask is None else int(np.count_nonzero(mask))
    groups = [c for c in candidates_at(scale, tree, pixels) if c.node in tree.leaves]
    if not groups:
        return fallback(picture, usable, tree, "No group of segments passes the filters.")
    return of_group(min(groups, key=lambda c: ENERGIES[form](c.lists)), 1.0, factor, picture.shape[:2])
