"""What grows under a guide: regions where they were painted, whatever the sizes, labels and exemplars."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from search.test_guide import BOTH, agreement, disc, got, labels, painted, regions

import intarsia as ia
from intarsia.methods import engine_of
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas, Guide
from intarsia.model.image import Plane
from intarsia.model.sourcemap import HOLE, identity
from intarsia.patches.patch_synthesis import PatchSettings, PatchSynthesis
from intarsia.published.multrus2003 import engine
from intarsia.published.multrus2003.engine import place_patch, settings_of
from intarsia.tasks.completion import with_hole
from intarsia.testing.cases import texture


def painting(method: Any, marks: Any, target: Any, *more: Any, **given: Any) -> Any:
    """What grows from a texture of some labels where a target wants them; `more`: weight and reach of the guide."""
    exemplar = given.pop("exemplar", None) or painted(marks)
    return ia.synthesize(exemplar, None, method, guide=Guide(labels(marks), labels(target), *more), **given)


class TestUses:
    def test_uses_are_judged_within_each_label(self) -> None:
        """A label that alone is painted is not dear for its uses; without a guide it is, and one spot always is."""
        marks = np.zeros((60, 60), np.uint8)
        marks[:, :20] = 1
        guide = Guide(labels(marks), labels(np.ones((300, 300), np.uint8)))
        dear = []
        for given, down, across in ((guide, 48, 8), (None, 48, 8), (guide, 1, 1)):
            settings = PatchSettings((12, 12), (4, 4), usage=0.05)
            growth = PatchSynthesis(settings, [painted(marks)], Canvas(300, 300, guide=given))
            rows, columns = growth.layout.shape
            for n in range(rows * columns):
                growth.repetition.add(n // columns, n % columns, (0, n * 7 % down, n * 5 % across))  # label 1
            before = growth.repetition._flat.copy()
            growth.repetition.account()
            counts = growth.repetition.search_prices.counts[0].ravel()
            dear.append((counts - before).reshape(growth.finder.valid[0].shape))
        label = slice(0, 8 // growth.finder.factor)
        assert not dear[0][:, label].any()
        assert (dear[1][:, label] > 0).any()
        assert (dear[2][:, label] > 0).any()


class TestPainting:
    @BOTH
    @pytest.mark.parametrize("boundary_patch", [0, None])
    def test_inside_of_regions_every_pixel_has_its_label(self, method: Any, boundary_patch: int | None) -> None:
        marks, target = regions(90, 90), disc(90)
        method = replace(method, boundary_patch=boundary_patch)
        found = got(painting(method, marks, target, seed=3).map, marks)
        canvas = Canvas(90, 90, guide=Guide(labels(marks), labels(target)))
        growth = PatchSynthesis(engine_of(method).settings_of(method), [painted(marks)], canvas)
        only_pure = np.ones((90, 90), bool)
        h, w = growth.layout.patch
        for r, y in enumerate(growth.layout.rows):
            for c, x in enumerate(growth.layout.columns):
                if growth.at_boundary((r, c)):
                    only_pure[max(y, 0) : y + h, max(x, 0) : x + w] = False
        assert only_pure.sum() > 500
        assert (found == target)[only_pure].all()
        assert (found == target).mean() > 0.95

    @pytest.mark.parametrize("few", [1, 2])
    def test_on_boundaries_fewer_may_be_chosen_than_inside(self, few: int) -> None:
        """Multrus 2003, 5.3.2: any of the n best inside, of the n' best (by default 1) at boundaries."""
        method = ia.PatchSampling(
            patch=8, overlap=3, candidates=5, boundary_candidates=few, repetition="none", isometries=(0,),
            boundary_isometries=(0,),
        )  # fmt: skip
        assert ia.PatchSampling().boundary_candidates == 1
        marks, target = regions(70, 70), disc(70)
        canvas = Canvas(70, 70, guide=Guide(labels(marks), labels(target)))
        growth = PatchSynthesis(settings_of(method), [painted(marks)], canvas)
        seen = {True: 0, False: 0}

        def choose(window: Any, found: Any, bits: int) -> Any:
            at_boundary = growth.at_boundary(window)
            most = few if at_boundary else 5
            picks = {engine.choose(method, growth, window, found, k << 32, []) for k in range(0, 1 << 32, 1 << 26)}
            assert picks == {tuple(row) for row in found.rows[:most, 1:].tolist()}
            seen[at_boundary] += 1
            return engine.choose(method, growth, window, found, bits, [])

        growth.fill(
            1, 2003, ia.Run(1), choose=choose, join=lambda at, pick, found: place_patch(method, growth, at, pick, found)
        )
        assert min(seen.values()) > 5

    @BOTH
    def test_three_labels_and_all_sizes(self, method: Any) -> None:
        marks, target = regions(96, 72, 3), regions(50, 131, 3)[::-1]
        for wrap in ("none", "both"):
            out = painting(method, marks, target, wrap=wrap)
            assert out.map.yx.shape[:2] == (50, 131)
            assert agreement(out.map, target, marks) > (0.9 if wrap == "none" else 0.85)

    @BOTH
    def test_several_exemplars_of_one_label_each(self, method: Any) -> None:
        sand, moss = np.full((40, 44), 3, np.uint8), np.full((36, 50), 9, np.uint8)
        target = disc(70, 3, 9)
        exemplars = [painted(sand // 3, 1), painted(moss // 9 * 3, 2)]
        out = ia.synthesize(exemplars, None, method, guide=Guide([labels(sand), labels(moss)], labels(target)))
        assert agreement(out.map, target, sand, moss) > 0.9
        assert set(np.unique(out.map.numbers).tolist()) == {0, 1}

    @BOTH
    def test_weight_0_still_keeps_regions_apart(self, method: Any) -> None:
        marks, target = regions(90, 90), disc(90)
        loose, close = (agreement(painting(method, marks, target, w).map, target, marks) for w in (0.0, 2.0))
        assert 0.8 < loose <= close

    @BOTH
    def test_turned_patches_follow_boundaries_that_the_exemplar_lacks(self, method: Any) -> None:
        marks, target = regions(90, 90), regions(90, 90).T  # the exemplar's boundary lies across, the target's upright
        methods = [replace(method, isometries="none", boundary_isometries=i) for i in ("none", "both")]
        plain, turned = (agreement(painting(m, marks, target, seed=1).map, target, marks) for m in methods)
        assert turned > max(plain, 0.97)


    @BOTH
    def test_a_start_map_is_kept(self, method: Any) -> None:
        marks, across = regions(70, 70), np.arange(70) * np.ones((70, 1), int)
        e, target = painted(marks), np.where(across >= 50, 1, marks)
        start = with_hole(identity([e.source], 0), across >= 35)
        out = painting(method, marks, target, exemplar=e, start=start)
        assert np.array_equal(out.map.yx[:, :25], start.yx[:, :25])
        assert agreement(out.map, target, marks) > 0.93

    @BOTH
    def test_windows_far_from_the_first_count_uses_near_them(self, method: Any) -> None:
        """Beside a start, uses are looked up by place, however many windows come before."""
        marks = regions(60, 60)
        e, target = painted(marks), np.zeros((24, 600), np.uint8)
        start = with_hole(identity([e.source], 0), np.zeros((60, 60), bool))
        which = np.full(target.shape, HOLE, np.uint8)
        which[:, :20] = 0
        start = replace(start, yx=np.resize(start.yx[:24, :20], (24, 600, 2)), which=which)
        out = painting(method, marks, target, exemplar=e, seed=3, start=start)
        assert (got(out.map, marks) == 0)[:, 30:].all()

    @BOTH
    def test_a_reach_is_followed(self, method: Any) -> None:
        marks, target = regions(90, 90), disc(90)
        assert agreement(painting(method, marks, target, 2.0, 6).map, target, marks) > 0.95

    @BOTH
    def test_a_target_picture_may_have_colours(self, method: Any) -> None:
        """Only labels have regions that must hold a patch; automatic sizes, too."""
        e = Exemplar.of(texture(90, 90, 3, 4))
        y, x = np.mgrid[:60, :80]
        wanted = np.stack([60 + 2 * x, 60 + 2 * y, np.full_like(x, 120)], axis=2).astype(np.uint8)
        for m in (method, type(method)()):
            gaps = []
            for weight in (0.0, 4.0):
                out = ia.synthesize(e, None, m, guide=Guide(e.base, Plane(wanted), weight)).render()
                gaps.append(np.abs(np.asarray(out.pixels, float) - wanted).mean())
            assert gaps[1] < gaps[0]

    @BOTH
    def test_labels_that_never_meet_are_cut_at_the_boundary(self, method: Any) -> None:
        marks, target = regions(90, 90, 3), disc(90, 2, 0)
        assert np.array_equal(got(painting(method, marks, target).map, marks), target)

    @BOTH
    def test_less_slack_more_agreement(self, method: Any) -> None:
        marks, target = regions(90, 90), (np.indices((90, 90)).sum(axis=0) // 20 % 2).astype(np.uint8)
        ways = [replace(method, boundary_tolerance=s, boundary_isometries="none") for s in (90, 3, 0)]
        near = [agreement(painting(m, marks, target).map, target, marks) for m in ways]
        assert near[0] < near[1] <= near[2] == 1.0
