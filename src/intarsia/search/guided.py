"""Searching patches under a guide: every window among the patches that it may take, by seam and guide together."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, Generic, Protocol, Self, TypeVar

import numpy as np

from ..arrays import Array
from ..exemplar import Exemplar
from . import guided_kernels
from .candidates import Candidates, Prices, Search
from .distance_map import full_scale
from .fourier import STEPS, PatchSearch, most_steps
from .fourier_kernels import Among
from .guide import ONE, WindowGuide
from .reduce_kernels import Listed

MOST = float(1 << 30)  # costs of the short-list stay below


class Divisible(Search, Protocol):
    """A search that can be narrowed to some patches."""

    def within(self, valid: Sequence[Array]) -> Self:
        """Return the same search among some patches only: of every variant, where they may begin."""


AnySearch = TypeVar("AnySearch", bound=Divisible)


class GuideSearch(PatchSearch):
    """The reduced pictures of a guide: every channel for itself, over its full range."""

    tails = 1.0

    def _reduction(self) -> tuple[Array, Array, float, int]:
        channels = self.variants.channels
        clip = min(STEPS, most_steps(self.patch, self.cells, channels))
        scale = 2.0 * clip / ONE
        axes = np.rint(np.eye(channels) * scale * (1 << 24)).astype(np.int64)
        return np.full(channels, ONE // 2, np.int64), axes, scale, clip


class Guided(ABC, Generic[AnySearch]):
    """Search patches for windows under a guide.

    `search` finds patches whose seams fit; `unit`: the squared difference of one pixel over the full range of the
    exemplars, what a seam distance of 1 is.
    """

    def __init__(self, search: AnySearch, guidance: WindowGuide, unit: int) -> None:
        self.guidance = guidance
        self.ratio = unit / guidance.unit
        self.allowed = {s: guidance.allowed(s) for s in np.unique(guidance.windows).tolist()}
        self.among: dict[int, AnySearch] = {s: search.within(valid) for s, valid in self.allowed.items()}

    def allowed_at(self, window: tuple[int, int]) -> list[Array]:
        """Return, for every variant, where patches begin that a window may take."""
        return self.allowed[int(self.guidance.windows[window])]

    def find(
        self, windows: list[tuple[int, int]], variant: Array, yx: Array, at: Array, prices: Prices
    ) -> list[Candidates]:
        """Return the candidates for `windows`, which begin at `at` (n, 2) of a growing map."""
        labels = [int(self.guidance.windows[w]) for w in windows]
        found: list[Any] = [None] * len(windows)
        for s in sorted(set(labels)):
            mine = np.array([k for k, own in enumerate(labels) if own == s])
            if self.guidance.guide.weight > 0 and not (s and s & (s - 1) == 0):
                some = self._weighed(self.among[s], variant, yx, at[mine], prices)
            else:  # inside the region of one label any patch of it will do: the seam alone counts
                some = self.among[s].find(variant, yx, at[mine], self.guidance.layout.wraps, prices)
            for k, candidates in zip(mine.tolist(), some, strict=True):
                found[k] = candidates
        return found

    @abstractmethod
    def _weighed(self, search: AnySearch, variant: Array, yx: Array, at: Array, prices: Prices) -> list[Candidates]:
        """Where patches differ in what the guide says, count that too: d + alpha g, squared (Multrus 2003, 5.3.1)."""

    def shares(self, known: Array, inside: Array) -> Array:
        """By what the root of the guide's squared difference is multiplied, window by window.

        With n known pixels of a window of A, both of them means: sqrt(seam / (n u)) + alpha sqrt(apart / (A g)),
        times sqrt(n u). Where nothing is known, n = A.
        """
        area = np.maximum(inside.sum(axis=(1, 2), dtype=np.int64), 1)
        count = known.sum(axis=(1, 2), dtype=np.int64)
        count = np.where(count > 0, count, area)
        return np.asarray(self.guidance.guide.weight * np.sqrt(count * self.ratio / area), np.float64)


class GuidedSearch(Guided[PatchSearch]):
    """The search by FFT under a guide: the short-list counts seams and guide together."""

    def __init__(self, search: PatchSearch, guidance: WindowGuide, unit: int) -> None:
        super().__init__(search, guidance, unit)
        self.guide = GuideSearch(guidance.pictures, guidance.layout.patch, 0, factor=search.factor)

    def _weighed(self, search: PatchSearch, variant: Array, yx: Array, at: Array, prices: Prices) -> list[Candidates]:
        n, guide = len(at), self.guide
        feats, known = search.windows(variant, yx, at, self.guidance.layout.wraps)
        wanted, inside = self.guidance.wanted(at)
        shares = self.shares(known, inside)
        coarse_shares = shares * (search.scale / guide.scale)
        pixels, over = search.reduce(feats, known), guide.reduce(wanted, inside)
        cells = search.cells[0] * search.cells[1]
        seam = 2.0 * search.clip * math.sqrt(cells * len(search.axes))
        apart = 2.0 * guide.clip * math.sqrt(cells * len(guide.axes))
        scales = np.minimum(MOST / (seam + coarse_shares * apart) ** 2, 1.0)
        best = np.empty((n, search.listed, 4), np.int64)
        counts, usual = np.zeros(n, np.int64), np.full(n, -1, np.int64)
        listed = Listed(best, counts, usual)
        for v, valid in enumerate(search.valid):
            if valid.size:
                mine = pixels.correlated(v, search.correlations(v, pixels), valid)
                labels = over.correlated(v, guide.correlations(v, over), valid)
                guided_kernels.guided_short_list(mine, labels, coarse_shares, scales, prices.of(v), listed)
        found = np.empty((n, search.listed, 4), np.int64)
        guided_kernels.guided_refine_all(
            feats, known, search.variants.posed, wanted, inside, guide.variants.posed, shares,
            Among(search.flat_valid, search.offsets), best, counts, search.factor, found,
        )  # fmt: skip
        return Candidates.of_all(found, counts, list(map(search.full, usual.tolist())), feats, known)


def seam_unit(exemplar: Exemplar, weights: tuple[float, ...] | None) -> int:
    """Return the squared difference of one pixel that differs by the full range in every channel of the base plane.

    Channels count as in the search; what other planes differ by comes on top.
    """
    return round(full_scale(exemplar, weights))
