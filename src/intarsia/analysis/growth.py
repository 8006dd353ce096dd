"""Growing a map patch by patch: the loop that all methods share that lay patches in raster order.

What distinguishes them is given: how a candidate is chosen, and how the chosen patch joins what is there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..canvas import Canvas
from ..draws import draw
from ..errors import MethodError
from ..exemplar import Exemplar
from ..geometry import hang, spread
from ..guide import Guide
from ..run import Run
from ..sourcemap import Blend, SourceMap
from .features import features
from .guidance import Guidance
from .guided_search import GuidedSearch, seam_unit
from .patchwork import Patchwork, Window, random_patch, waves
from .repetition import Layout, Repetition, Rule, striking
from .search import Candidates, PatchSearch
from .variants import isometry_ids, variants

Pick = tuple[int, int, int]
Choose = Callable[[Window, Candidates, int], Pick | None]
Join = Callable[[tuple[int, int], Pick, Candidates], None]

BLIND = 64  # random patches tried where nothing is known and repeats are forbidden
SURROUNDINGS = 10  # the context of a pixel reaches about a tenth of a patch


@dataclass(frozen=True)
class Laying:
    """How patches are laid: their size, where, from what, and at which price.

    Attributes
    ----------
    patch, overlap : (rows, columns)
        Of a window, px; neighbours share `overlap`.
    hangs : bool
        Windows keep their pitch and may hang over the border (source 000), or are spread to end at it.
    weights, context, isometries, exact
        As the parameters of the methods: channel weights, weight of the surroundings, poses, search.
    listed : int
        Candidates kept of every search.
    repeats, usage, distance
        The rule of repetition control, its price of a repeat, and the least distance of two.
    rim : int
        How deep start pixels may be replaced, px.
    boundary : int
        Side of the patches along the boundaries of a guide's labels, px; 0: as large as the others.
    boundary_isometries
        The poses that may be used there besides.
    slack : int, optional
        How far one label's pixels may lie in another's region, px, before they are replaced; None: any distance.
    """

    patch: tuple[int, int]
    overlap: tuple[int, int]
    hangs: bool = False
    weights: tuple[float, ...] | None = None
    context: float = 0.0
    isometries: str | tuple[int, ...] = "none"
    exact: bool = False
    listed: int = 16
    repeats: Rule = Rule.PRICES
    usage: float = 0.0
    distance: int = 0
    rim: int = 0
    boundary: int = 0
    boundary_isometries: str | tuple[int, ...] = "none"
    slack: int | None = None

    def poses(self, guide: Guide | None) -> tuple[int, ...]:
        """The isometries in which patches are taken, those for boundaries of labels included."""
        own = isometry_ids(self.isometries)
        if guide is None or not guide.is_labels:
            return own
        return tuple(sorted({*own, *isometry_ids(self.boundary_isometries)}))

    def layout(self, canvas: Canvas) -> Layout:
        """The windows on a canvas."""
        axes = []
        for length, patch, overlap, wrap in zip(
            (canvas.height, canvas.width), self.patch, self.overlap, (canvas.wrap.y, canvas.wrap.x), strict=True
        ):
            hanging = self.hangs and not wrap
            axes.append(hang(length, patch, overlap) if hanging else spread(length, patch, overlap, wrap))
        (rows, height), (columns, width) = axes
        return Layout(
            tuple(rows), tuple(columns), (height, width), canvas.height, canvas.width, canvas.wrap.y, canvas.wrap.x
        )


class Growth:
    """A map that grows, and all that is needed to grow it.

    Windows may be left out: with `inside_only` those that hold a boundary of labels; with `wanted`, a mask of the
    canvas, those that hold none of its pixels.
    """

    def __init__(
        self, laying: Laying, exemplars: Sequence[Exemplar], canvas: Canvas, inside_only: bool = False,
        wanted: NDArray[np.bool_] | None = None,
    ) -> None:  # fmt: skip
        self.laying, self.exemplars, self.canvas = laying, exemplars, canvas
        self.layout = laying.layout(canvas)
        around = (laying.context, max(min(laying.patch) // SURROUNDINGS, 1)) if laying.context else (0.0, 0)
        self.features = features(exemplars, laying.weights, around)
        shown = () if canvas.start is None else canvas.start.poses
        self.variants = variants(
            exemplars, self.features, laying.poses(canvas.guide), self.layout.patch, shown
        )
        self.finder = PatchSearch(self.variants, self.layout.patch, min(laying.overlap), laying.exact, laying.listed)
        priced = laying.usage and laying.repeats is Rule.PRICES
        prices = striking(self.features, self.finder) if priced else None
        self.repetition = Repetition(
            self.finder, self.layout, laying.usage, laying.distance, prices, laying.repeats
        )
        rim = laying.rim if canvas.rim is None else canvas.rim
        self.patchwork = Patchwork.begin(self.variants, canvas, rim)
        windows = self.patchwork.open_windows(self.layout, wanted)
        self.guided = self._guided()
        if inside_only and self.guided is not None:
            windows &= ~self.guided.guidance.boundaries
        self.waves = waves(self.layout, windows)

    def _guided(self) -> GuidedSearch | None:
        """The search under the canvas's guide, where it has one."""
        guide = self.canvas.guide
        if guide is None:
            return None
        guidance = Guidance(
            guide, self.variants, self.layout, self.canvas.wrap, isometry_ids(self.laying.isometries)
        )
        return GuidedSearch(self.finder, guidance, seam_unit(self.exemplars[0], self.laying.weights))

    def at_boundary(self, window: Window) -> bool:
        """True where a window holds a boundary between labels of the guide."""
        return self.guided is not None and bool(self.guided.guidance.boundaries[window])

    def fill(
        self, seed: int, stage: int, run: Run, choose: Choose, join: Join, part: tuple[int, int] = (0, 1)
    ) -> None:
        """Fill all windows, in waves: those of a wave do not touch, so they are worked on at the same time.

        `choose` picks among the candidates of a window, in a fixed order; `join` lays the patch into it. `part`:
        which pass this is, from 0, and of how many.
        """
        before, total = part[0] * len(self.waves), part[1] * len(self.waves)
        with run.pool() as each:
            for number, wave in enumerate(self.waves):
                run.tick(before + number, total, self.draft)
                found = self._search(wave, each, run.workers)
                picks = [self._choose(w, f, seed, stage, choose) for w, f in zip(wave, found, strict=True)]
                self._join(list(zip(wave, picks, found, strict=True)), join, each, run.workers)
        run.tick(before + len(self.waves), total, self.draft)

    def map(self, blend: Blend) -> SourceMap:
        """The map, once all is filled."""
        return self.patchwork.map(self.exemplars, self.canvas, blend)

    def draft(self) -> SourceMap:
        """The map as far as it has grown: a copy."""
        now = self.map(Blend())
        return replace(now, yx=now.yx.copy())

    def brightness(self, found: Candidates) -> int:
        """Sum of the squared features of a window, counted from black: what epsilon is relative to in source 000."""
        n = self.features.base
        above = (found.feats[:, :, :n].astype(np.int64) - self.features.black[:n]) * found.known[:, :, None]
        return int((above * above).sum())

    def at(self, window: Window) -> tuple[int, int]:
        """First pixel of a window on the canvas."""
        return self.layout.rows[window[0]], self.layout.columns[window[1]]

    def window(self, at: Window) -> Window:
        """The window that begins at a pixel of the canvas."""
        return self.layout.rows.index(at[0]), self.layout.columns.index(at[1])

    def _search(self, wave: list[Window], each: Any, workers: int) -> list[Candidates]:
        found: list[Any] = [None] * len(wave)
        parts = max(workers if len(wave) >= workers else 1, -(-len(wave) // self.finder.batch()))
        size = -(-len(wave) // parts)
        at: NDArray[np.int64] = np.array([self.at(w) for w in wave], np.int64)

        def part(begin: int) -> None:
            stop = min(begin + size, len(wave))
            told = self.repetition.told
            if self.guided is not None:
                found[begin:stop] = self.guided.find(
                    wave[begin:stop], self.patchwork.variant, self.patchwork.yx, at[begin:stop], told
                )
                return
            found[begin:stop] = self.finder.find(
                self.patchwork.variant, self.patchwork.yx, at[begin:stop], self.layout.wraps, told
            )

        each(part, range(0, len(wave), size))
        return found

    def _choose(self, window: Window, found: Candidates, seed: int, stage: int, choose: Choose) -> Pick:
        pick: Pick | None
        if found.free or (self.guided is not None and not len(found.rows)):  # nothing is known: any patch will do
            valid = self.variants.valid if self.guided is None else self.guided.allowed_at(window)
            tries = (random_patch(valid, draw(seed, stage, n, *window)) for n in range(BLIND))
            pick = next((p for p in tries if self.repetition.allows(*window, p)), None)
        else:
            pick = choose(window, found, draw(seed, stage, 0, *window))
        if pick is None:
            raise MethodError(
                f"min_repeat_distance={self.laying.distance} px leaves no patch for some place; "
                "choose a smaller distance, a smaller patch, or a larger exemplar."
            )
        self.repetition.add(*window, pick)
        return pick

    def _join(self, chosen: list[tuple[Window, Pick, Candidates]], join: Join, each: Any, workers: int) -> None:
        def part(items: list[tuple[Window, Pick, Candidates]]) -> None:
            for window, pick, found in items:
                join(self.at(window), pick, found)

        size = -(-len(chosen) // workers)
        each(part, [chosen[k : k + size] for k in range(0, len(chosen), size)])
