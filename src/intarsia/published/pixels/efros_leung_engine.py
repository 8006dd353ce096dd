"""Engine of Efros-Leung synthesis: layer by layer, pixels drawn among those with the most similar neighbourhoods."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ...analysis.features import features
from ...foundation.arrays import Array, Pair
from ...foundation.filters import moving_sums
from ...foundation.params import extent
from ...foundation.run import Run, below, draw, draw_many
from ...model import Exemplars
from ...model.canvas import Canvas
from ...model.sourcemap import HOLE, SourceMap
from ...patches import MapBuilder
from ...search import isometry_ids, posed_exemplars, resolved_isometries
from .efros_leung import EfrosLeung
from .efros_leung_kernels import fill, ranks
from .neighbourhoods import choices, exemplar_planes, layers, with_window

STAGE = 1999  # keeps this method's draws apart from those of others
WINDOW_PER_SIGMA = 6.4  # as in the authors' own program
UNIT = 4096  # weight of the pixel in the middle, were it known
WIDTHS = 5, 23  # least and most of automatic windows
AT_ONCE = 128  # pixels filled between two progress reports
WORTH_SHARING = 8  # pixels that a second thread is worth its start for
FIRST = 0.7  # share of the weight by which most candidates are ruled out


def resolved(method: EfrosLeung, exemplars: Exemplars, canvas: Canvas) -> EfrosLeung:
    """Return the method with its window derived from the size of elements, and the isometries that keep the look."""
    found: EfrosLeung = with_window(method, exemplars, WIDTHS, True, _reach)
    return replace(found, isometries=resolved_isometries(method.isometries, exemplars, extent(found.window or 1)))


def synthesize(method: EfrosLeung, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Fill layer by layer; pixels outside of one another's windows are filled in parallel."""
    grown = _Outward(method, exemplars, canvas, seed)
    total = grown.unknown
    with run.pool() as each:
        while grown.unknown:
            for batch in grown.batches():
                run.tick(total - grown.unknown, total, grown.map)
                grown.fill(batch, each, run.workers)
    run.tick(total, total, grown.map)
    return grown.map()


class _Outward:
    """A partial map and the state needed to extend it."""

    def __init__(self, method: EfrosLeung, exemplars: Exemplars, canvas: Canvas, seed: int) -> None:
        self.method, self.exemplars, self.canvas, self.seed = method, exemplars, canvas, seed
        feats = features(exemplars)
        begun = () if canvas.start is None else canvas.start.poses
        variants = posed_exemplars(exemplars, feats, isometry_ids(method.isometries), (1, 1), begun)
        window = extent(method.window or 1)
        self.window = np.array(window, np.int64)
        self.taps = np.array(_taps(window), np.int64)
        self.ground = exemplar_planes(layers(variants, exemplars), _reach(window), _reach(window))
        self.growing = MapBuilder.begin(variants, canvas, 0)
        self.grown = self.growing.grown
        heavy = np.cumsum(self.taps[:, 2]) <= FIRST * self.taps[:, 2].sum() / 2  # about half of them are known
        self.first = max(int(heavy.sum()), 4) * variants.channels
        if not (self.growing.variant != HOLE).any():
            self._copy_seed()
        self.unknown = int((self.growing.variant == HOLE).sum())

    def _copy_seed(self) -> None:
        """Copy 3 x 3 px of the exemplar to the middle of the canvas."""
        found = choices(self.ground, 1)
        v, position = found[below(len(found), draw(self.seed, STAGE, 2))]
        _, height, width, stride = self.ground.table[v, :4]
        middle = self.canvas.height // 2, self.canvas.width // 2
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                y, x = middle[0] + dy, middle[1] + dx
                if 0 <= y < self.canvas.height and 0 <= x < self.canvas.width:
                    self.growing.variant[y, x] = v
                    self.growing.yx[y, x] = (position // stride + dy) % height, (position % stride + dx) % width

    def _layer(self) -> Array:
        """Return the unknown pixels that touch known ones (n, 2), most known neighbours first, ties drawn."""
        known = (self.grown.variant != HOLE).astype(np.int64)

        def around(window: Any) -> Any:
            counts = known
            for axis, wraps in enumerate(self.grown.wrap):
                counts = moving_sums(counts, axis, int(window[axis]) // 2, "wrap" if wraps else "constant")
            return counts

        pixels = np.argwhere((known == 0) & (around((3, 3)) > 0))
        bits = np.array(draw_many(self.seed, STAGE, 1, pixels), np.uint64)
        return np.asarray(pixels[np.lexsort((bits, -around(self.window)[*pixels.T]))])

    def batches(self) -> list[list[Any]]:
        """Return the next layer in batches of groups; no pixel of a group lies in the window of another."""
        pixels = self._layer()
        rank = ranks(pixels, self.grown, self.window)
        order = np.argsort(rank, kind="stable")
        groups = np.split(pixels[order], np.flatnonzero(np.diff(rank[order])) + 1)
        groups = [g[k : k + AT_ONCE] for g in groups for k in range(0, len(g), AT_ONCE)]
        full = np.cumsum([len(g) for g in groups]) // AT_ONCE
        return [[g for g, f in zip(groups, full, strict=True) if f == n] for n in np.unique(full)]

    def fill(self, batch: list[Any], each: Any, workers: int) -> None:
        """Fill the pixels of a batch: serially, or each group in parallel."""

        def part(pixels: Any) -> None:
            fill(
                self.grown, pixels, self.taps, self.growing.variants.channels, self.ground,
                round(self.method.tolerance * 65536), self.first, np.uint64(self.seed), STAGE,
            )  # fmt: skip

        if workers == 1:
            part(np.concatenate(batch))
        else:
            for group in batch:
                each(part, np.array_split(group, min(workers, max(len(group) // WORTH_SHARING, 1))))
        self.unknown -= sum(len(group) for group in batch)

    def map(self) -> SourceMap:
        """Return the map as far as it is filled."""
        return self.growing.map(self.exemplars, self.canvas, self.method.blend)


def _taps(window: Pair) -> list[tuple[int, int, int]]:
    """Return (row, column, weight) of all pixels of a window but the middle, the heaviest first."""
    up, side = window[0] // 2, window[1] // 2
    tall, wide = (2 * (n / WINDOW_PER_SIGMA) ** 2 for n in window)
    weighed = [
        (y, x, round(UNIT * math.exp(-(y * y / tall + x * x / wide))))
        for y in range(-up, up + 1)
        for x in range(-side, side + 1)
        if y or x
    ]
    return sorted((t for t in weighed if t[2]), key=lambda t: (-t[2], t[0] ** 2 + t[1] ** 2, t))


def _reach(window: Pair) -> tuple[int, int, int, int]:
    return window[0] // 2, window[1] // 2, window[0] // 2, window[1] // 2
