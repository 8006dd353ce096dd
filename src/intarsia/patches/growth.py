"""Growing a map patch by patch: the loop shared by all methods that lay patches in raster order.

A method gives what distinguishes it: how one of the candidates is chosen, and how the chosen patch is joined to the
patches that were laid before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import features
from ..analysis.sums import variance
from ..blend import Blend
from ..canvas import Canvas
from ..draws import draw_many
from ..errors import MethodError
from ..exemplar import Exemplar
from ..kernels.cuts import SeamPrice
from ..run import Run
from ..search.candidates import Candidates, Search
from ..search.distance_map import best_of_poses, distance_maps, full_scale
from ..search.fourier import PatchSearch
from ..search.guide import WindowGuide
from ..search.guided import Guided, GuidedSearch, seam_unit
from ..search.posed import isometry_ids, posed_exemplars
from ..sourcemap import HOLE, SourceMap
from .growing_map import GrowingMap, Window, random_patch, waves
from .hole_edge_kernels import weigh_edge
from .repetition import striking
from .settings import PatchSettings

Pick = tuple[int, int, int]
Choose = Callable[[Window, Candidates, int], Pick | None]
Join = Callable[[tuple[int, int], Pick, Candidates], None]

AROUND_HOLES = 64  # candidates kept where a patch must fit a hole,
AMONG_COURSES = 64  # or keep courses: few of those that do fit their stones, too
# Of the spread of colours. Halved: pebbles have 1.8 strong steps for 1.2 in 1000 px; doubled: a pebble road 5.6 for 4.
KNEE = 3, 8
SURROUNDINGS = 10  # the context of a pixel reaches about a tenth of a patch


def knee_of(spread: int) -> int:
    """Return the cost from which on a seam of the price `sharp` counts more than it differs, by the variance seen."""
    return max(math.isqrt(spread) * KNEE[0] // KNEE[1], 1)


class Turn(NamedTuple):
    """Which growth of a map this is: what it adds to the stage of its draws, its number from 0, and of how many."""

    stage: int = 0
    number: int = 0
    passes: int = 1


ONLY = Turn()


class Growth:
    """A map that grows, and all that is needed to grow it.

    Windows may be left out: with `inside_only` those that hold a boundary of labels; with `wanted`, a mask of the
    canvas, those that hold none of its pixels. `own`: the canvas's start map may be used up.
    """

    def __init__(
        self, settings: PatchSettings, exemplars: Sequence[Exemplar], canvas: Canvas, inside_only: bool = False,
        wanted: NDArray[np.bool_] | None = None, turn: Turn = ONLY, own: bool = False,
    ) -> None:  # fmt: skip
        self.settings, self.exemplars, self.canvas, self.turn = settings, exemplars, canvas, turn
        self.layout = settings.layout(canvas)
        around = (settings.context, max(min(settings.patch) // SURROUNDINGS, 1)) if settings.context else (0.0, 0)
        self.features = features(exemplars, settings.weights, around, settings.structure, settings.courses)
        begun = () if canvas.start is None else canvas.start.poses
        poses = settings.poses(canvas.guide)
        self.variants = posed_exemplars(exemplars, self.features, poses, self.layout.patch, begun)
        rim = settings.rim if canvas.rim is None else canvas.rim
        listed = settings.listed if self.layout.places is None or rim else max(settings.listed, AROUND_HOLES)
        self.finder = self._finder(listed if self.features.courses is None else max(listed, AMONG_COURSES))
        rule, usage, distance = settings.repeats
        prices = striking(self.features, self.finder) if usage else None
        self.repetition = rule(self.finder, self.layout, usage, distance, prices)
        self.growing = GrowingMap.begin(self.variants, canvas, rim, own)
        windows = self.growing.open_windows(self.layout, wanted)
        self.guided = self._guided()
        if self.guided is not None and self.guided.guidance.guide.is_labels:
            self.repetition.apart(self.guided.guidance.groups(self.finder))
        if inside_only and self.guided is not None:
            windows &= ~self.guided.guidance.boundaries
        self.waves = waves(self.layout, windows)
        if rule.in_turn:
            self.waves = [[window] for window in sorted(w for wave in self.waves for w in wave)]
        if canvas.start is not None:
            self.repetition.note_start(self.growing.variant, self.growing.yx)

    def _finder(self, listed: int) -> Search:
        settings, patch = self.settings, self.layout.patch
        if settings.finder is not None:
            return settings.finder(settings, self.variants, patch, listed)
        return PatchSearch(self.variants, patch, min(settings.overlap), settings.search == "exact", listed)

    def _guided(self) -> Guided[Any] | None:
        """The search under the canvas's guide, where it has one."""
        guide = self.canvas.guide
        if guide is None:
            return None
        what = WindowGuide(
            guide, self.variants, self.layout, self.canvas.wrap, isometry_ids(self.settings.isometries)
        )
        unit = seam_unit(self.exemplars[0], self.settings.weights)
        if self.settings.guided is not None:
            return self.settings.guided(self.finder, what, unit)
        assert isinstance(self.finder, PatchSearch), "methods with a search of their own say how it follows a guide"
        return GuidedSearch(self.finder, what, unit)

    def at_boundary(self, window: Window) -> bool:
        """True where a window holds a boundary between labels of the guide."""
        return self.guided is not None and bool(self.guided.guidance.boundaries[window])

    def fill(self, seed: int, stage: int, run: Run, join: Join, choose: Choose | float) -> None:
        """Fill all windows, in waves: those of a wave do not touch, so they are worked on at the same time.

        `choose` picks among the candidates of a window, in a fixed order; a number stands for the choice by
        price within this tolerance. `join` lays the patch into the window.
        """
        self._check = run.check
        before, total = self.turn.number * len(self.waves), self.turn.passes * len(self.waves)
        with run.pool() as each:
            for number, wave in enumerate(self.waves):
                run.tick(before + number, total, self.draft)
                self.repetition.account()
                found = self._search(wave, each, run.workers)
                self._answer(run, wave, found)
                bits = draw_many(seed, stage + self.turn.stage, 0, wave)
                picks = self._picks(wave, found, bits, choose)
                self._join(list(zip(wave, picks, found, strict=True)), join, each, run.workers)
        run.tick(before + len(self.waves), total, self.draft)

    def cutting(self, seam: str = "difference") -> Join:
        """What joins patches along the seam that is cheapest by the price of this name."""
        price = self.seam_price(seam)
        return lambda at, pick, found: self.growing.cut_in(at, pick, found, self.layout, price)

    def seam_price(self, seam: str) -> SeamPrice:
        """What seams cost by one of the names that the parameter `seam` of methods knows."""
        return SeamPrice(seam == "gradient", knee_of(self.variance(seen=True)) if seam == "sharp" else 0)

    def variance(self, seen: bool = False) -> int:
        """Sum of the channels' variances over the usable pixels, of the exemplar that varies most; those seen only."""
        n = self.variants.channels - (self.features.structure if seen else 0)
        return max(variance(p[..., :n], e.usable) for p, e in zip(self.features.pictures, self.exemplars, strict=True))

    def map(self, blend: Blend) -> SourceMap:
        """The map, once all is filled."""
        return self.growing.map(self.exemplars, self.canvas, blend)

    def draft(self) -> SourceMap:
        """The map as far as it has grown: a copy."""
        now = self.map(Blend())
        return replace(now, yx=now.yx.copy())

    def at(self, window: Window) -> tuple[int, int]:
        """First pixel of a window on the canvas."""
        return self.layout.at(*window)

    def _answer(self, run: Run, wave: list[Window], found: list[Candidates]) -> None:
        """Answer the run's probe where its pixel is about to be filled."""
        probe = run.probe
        if probe is None or probe.maps is not None or self.growing.variant[probe.y, probe.x] != HOLE:
            return
        for window, candidates in zip(wave, found, strict=True):
            y, x = self.at(window)
            dy, dx = probe.y - y, probe.x - x
            dy = dy % self.canvas.height if self.canvas.wrap.y else dy
            dx = dx % self.canvas.width if self.canvas.wrap.x else dx
            if 0 <= dy < self.layout.patch[0] and 0 <= dx < self.layout.patch[1]:
                scale = full_scale(self.exemplars[0], self.settings.weights)
                every = distance_maps(candidates, self.variants, scale)
                probe.maps = best_of_poses(every, self.variants, self.layout.patch)
                if candidates.free:
                    run.notes.append(f"nothing was known around {probe.x},{probe.y} yet: every patch fits alike there.")
                return

    def window(self, at: Window) -> Window:
        """The window that begins at a pixel of the canvas."""
        return self.layout.rows.index(at[0]), self.layout.columns.index(at[1])

    def _search(self, wave: list[Window], each: Any, workers: int) -> list[Candidates]:
        found: list[Any] = [None] * len(wave)
        parts = max(workers if len(wave) >= workers else 1, -(-len(wave) // self.finder.batch()))
        size = -(-len(wave) // parts)
        at: NDArray[np.int64] = np.array([self.at(w) for w in wave], np.int64)

        def part(begin: int) -> None:
            self._check()
            stop, prices = min(begin + size, len(wave)), self.repetition.search_prices
            where = (self.growing.variant, self.growing.yx, at[begin:stop], self.layout.wraps)
            if self.guided is not None:
                found[begin:stop] = self.guided.find(wave[begin:stop], *where[:3], prices)
            elif self.settings.repeats.distance and isinstance(self.finder, PatchSearch):
                found[begin:stop] = self.finder.search(
                    *self.finder.windows(*where), prices,
                    lambda k, rows: self.repetition.left(*wave[begin + k], rows, self._check),
                )  # fmt: skip
            else:
                found[begin:stop] = self.finder.find(*where, prices)

        each(part, range(0, len(wave), size))
        return [self.weighed(at[k], f) for k, f in enumerate(found)]

    def weighed(self, at: NDArray[np.int64], found: Candidates) -> Candidates:
        """What must stay in a start map must be continued well: its edge counts as much as all the rest."""
        if self.layout.places is None:
            return found
        rows = found.rows.copy()
        weigh_edge(
            self.growing.locked, at, self.layout.wraps, found.feats, found.known, self.variants.flat,
            self.variants.table, rows,
        )  # fmt: skip
        return replace(found, rows=rows)

    def _picks(
        self, wave: list[Window], found: list[Candidates], bits: list[int], choose: Choose | float
    ) -> list[Pick]:
        """Choose for the windows of a wave, in their order."""
        if callable(choose):
            return [self._choose(*each_of, choose) for each_of in zip(wave, found, bits, strict=True)]

        def priced(window: Window, found: Candidates, bits: int) -> Pick | None:
            return self.repetition.pick(*window, found, choose, bits)

        if self.layout.places is not None or len(self.repetition.started):  # not on the grid that a kernel goes by
            return [self._choose(*each_of, priced) for each_of in zip(wave, found, bits, strict=True)]
        special: dict[int, Pick] = {}
        for stop, picks in self.repetition.pick_all(wave, found, choose, bits):
            if stop == len(wave):
                return [special.get(k, pick) for k, pick in enumerate(picks)]
            special[stop] = self._choose(wave[stop], found[stop], bits[stop], priced)
        raise AssertionError("a wave ends with its last window")

    def _choose(self, window: Window, found: Candidates, bits: int, choose: Choose) -> Pick:
        pick: Pick | None
        valid = self.variants.valid if self.guided is None else self.guided.allowed_at(window)
        bare = self.guided is not None and not len(found.rows) and not found.known.any()
        if (found.free or bare) and not self.settings.repeats.distance:  # nothing is known here yet: any patch will do
            pick = random_patch(valid, bits)
        else:
            pick = choose(window, found, bits) if len(found.rows) else None
            loose = replace(found, free=True) if bare else found
            pick = pick or choose(window, self.repetition.allowed(*window, loose, valid, self._check), bits)
        if pick is None:
            raise MethodError(
                f"min_repeat_distance={self.settings.repeats.distance} px leaves no patch for some place; "
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
