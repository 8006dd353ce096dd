"""Every way to find patches keeps the promises of a search."""

from __future__ import annotations

from typing import Any

import numpy as np
from search.search_contract import HEIGHT, WIDTH, Patch, SearchContract, SearchScene

from intarsia.foundation.geometry import Wrap
from intarsia.model.canvas import Guide
from intarsia.model.image import Kind, Plane
from intarsia.published.multrus2003.guided_search import GuidedPatchSearch
from intarsia.published.multrus2003.pyramid import GuidedPyramid, PyramidSearch
from intarsia.published.segments.engine import SegmentSearch
from intarsia.search import Candidates, WindowGrid
from intarsia.search.fourier import PatchSearch
from intarsia.search.guide import ONE, GuidedSearch, WindowGuide, seam_unit
from intarsia.testing import noise

SEAM = 4


class TestFourierSearch(SearchContract):
    nearness = 1.02

    def make(self, scene: SearchScene) -> PatchSearch:
        return PatchSearch(scene.variants, scene.patch, SEAM)


class TestExactSearch(SearchContract):
    def make(self, scene: SearchScene) -> PatchSearch:
        return PatchSearch(scene.variants, scene.patch, SEAM, exact=True)


class TestPyramidSearch(SearchContract):
    """As the source has it: one place is followed from level to level."""

    nearness, usual = 1.3, (0.15, 0.5)

    def make(self, scene: SearchScene) -> PyramidSearch:
        return PyramidSearch(scene.variants, scene.patch, (SEAM, SEAM))


class TestPyramidSearchOfManyPlaces(TestPyramidSearch):
    nearness = 1.05

    def make(self, scene: SearchScene) -> PyramidSearch:
        return PyramidSearch(scene.variants, scene.patch, (SEAM, SEAM), "gaussian", 12)


class TestSegmentSearch(SearchContract):
    """Drawn among all patches; a segment is no reason to leave one out here."""

    scenes = ("gray", "masked", "toroidal")
    priced, usual = False, (0.5, 1)  # of a fiftieth of what is drawn

    def make(self, scene: SearchScene) -> SegmentSearch:
        e = scene.exemplars[0]
        groups = (noise(e.height, e.width, 3) % np.uint64(3)).astype(np.int32)
        groups = groups if e.usable is None else np.where(e.usable, groups, -1)
        return SegmentSearch(scene.variants, scene.patch, groups, (SEAM, SEAM), 4096, 4096, 5, 7)


class UnderGuide:
    """A guided search as any other: its windows are named by their first pixels."""

    def __init__(self, kind: type[GuidedSearch], search: Any, scene: SearchScene, guide: Guide) -> None:
        self.variants, self.patch, self.valid = search.variants, search.patch, search.valid
        self.factor, self.cells, self.batch = search.factor, search.cells, search.batch
        ends = [range(-side, length) for side, length in zip(scene.patch, (HEIGHT, WIDTH), strict=True)]
        grid = WindowGrid(tuple(ends[0]), tuple(ends[1]), scene.patch, (HEIGHT, WIDTH), scene.wrap)
        wrap = {(False, False): "none", (True, False): "y", (False, True): "x", (True, True): "both"}[scene.wrap]
        self.guidance = WindowGuide(guide, scene.variants, grid, Wrap(wrap))
        self.unit = seam_unit(scene.exemplars[0], None)
        self.guided = kind(search, self.guidance, self.unit)

    def window(self, at: tuple[int, int]) -> tuple[int, int]:
        return at[0] + self.patch[0], at[1] + self.patch[1]

    def find(self, grown: Any, at: Any, prices: Any) -> list[Candidates]:
        windows = [self.window((y, x)) for y, x in at.tolist()]
        return self.guided.find(windows, grown, at, prices)


class GuidedContract(SearchContract):
    """A window takes patches of its labels, and pays for what differs: seam and alpha g, squares or roots."""

    scenes = ("gray", "masked", "toroidal", "turned")
    rounding = 1e-6
    weight = 0.0
    kind: type[GuidedSearch] = GuidedSearch

    def under(self, scene: SearchScene, search: Any) -> UnderGuide:
        e = scene.exemplars[0]
        sources, target = (
            Plane((noise(h // 9 + 1, w // 9 + 1, n) % np.uint64(2)).astype(np.uint8).repeat(9, 0).repeat(9, 1)[:h, :w],
                  Kind.LABEL)
            for n, (h, w) in enumerate([(e.height, e.width), (HEIGHT, WIDTH)])
        )  # fmt: skip
        return UnderGuide(self.kind, search, scene, Guide(sources, target, self.weight))

    def truth(self, search: Any, scene: SearchScene, at: tuple[int, int]) -> dict[Patch, float]:
        allowed = search.guided.allowed_at(search.window(at))
        (wanted,), (inside,) = search.guidance.wanted(np.array([at]))
        known = int(scene.shown(at)[1].sum())
        found: dict[Patch, float] = {}
        for (v, y, x), seam in scene.distances(at).items():
            if allowed[v][y, x]:
                h, w = scene.patch
                held = search.guidance.pictures.picture(v)[y : y + h, x : x + w].astype(float) - wanted
                apart = ((held / ONE) ** 2).sum(axis=2)[inside > 0].mean() * ONE * ONE / search.guidance.unit
                seam, apart = seam / (known * search.unit), self.weight**2 * apart
                cost = seam + apart if self.kind is GuidedSearch else (seam**0.5 + apart**0.5) ** 2
                found[v, y, x] = cost * known * search.unit
        return found


class TestGuidedSearch(GuidedContract):
    nearness = 1.05

    def make(self, scene: SearchScene) -> UnderGuide:
        return self.under(scene, PatchSearch(scene.variants, scene.patch, SEAM))


class TestGuidedSearchByWeight(TestGuidedSearch):
    guided, weight = True, 0.5


class TestGuidedPatchSearch(TestGuidedSearchByWeight):
    kind = GuidedPatchSearch


class TestGuidedPyramid(GuidedContract):
    nearness, usual = 1.1, (0.1, 0.5)
    guided, weight = True, 0.5
    kind = GuidedPyramid

    def make(self, scene: SearchScene) -> UnderGuide:
        return self.under(scene, PyramidSearch(scene.variants, scene.patch, (SEAM, SEAM), kept=12))


UNDER_GUIDES = {"GuidedSearch", "GuidedPatchSearch", "GuidedPyramid"}


def test_every_search_is_under_contract() -> None:
    from intarsia.published.multrus2003 import guided_search, pyramid
    from intarsia.published.segments import engine
    from intarsia.search import fourier, guide

    rooms = (fourier, engine, pyramid, guide, guided_search)
    every = {n: made for room in rooms for n, made in vars(room).items() if isinstance(made, type)}
    makers = {n for n, made in every.items() if {"find", "batch"} <= set(dir(made)) or issubclass(made, GuidedSearch)}
    within = {"Search", "GuideSearch"}  # promises; what guided searches are made of
    assert makers - within == {"PatchSearch", "PyramidSearch", "SegmentSearch", *UNDER_GUIDES}
