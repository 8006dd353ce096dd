"""The laws of the package for every method, with parameters that suit small exemplars."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy
from laws import PackageLaws

import intarsia as ia
from intarsia.foundation.geometry import Wrap
from intarsia.methods import METHODS, Ability, Method
from intarsia.model import Exemplar
from intarsia.regular.rectify import rectified_for
from intarsia.testing import MethodContract, as_depth, texture
from intarsia.testing.cases import Case


def chosen(method: Method, *, least: int = 20) -> st.SearchStrategy[Case]:
    """Four requests that hold among them all that a method claims to serve: the richest is the simplest to draw."""
    supports, rows = method.supports, []
    for dtype, channels, sides, size, wrap, count, masked in (
        ("uint16", 3, (9, 4), (24, 33), Wrap.BOTH, 1, True),
        ("float32", 5, (0, 7), (30, 19), Wrap.X, 2, True),
        ("uint8", 1, (6, 2), (35, 31), Wrap.NONE, 1, False),
        ("uint8", 4, (3, 8), (1, 17), Wrap.Y, 1, True),
    ):
        several = []
        for n in range(count if Ability.SEVERAL in supports else 1):
            height, width = least + sides[n], least + sides[1 - n]
            usable = np.ones((height, width), bool)
            usable[:1], usable[:, width - 2 :] = False, False
            pixels = as_depth(texture(height, width, channels, 7 * channels + n), dtype)
            mask = usable if masked and n == 0 and Ability.MASK in supports else None
            several.append(Exemplar.of(pixels, usable=mask, toroidal=wrap is not Wrap.NONE and n == 0))
        rows.append(Case(tuple(several), size, 2**61 + channels, wrap if Ability.WRAP in supports else Wrap.NONE))
    return st.sampled_from(rows)


@pytest.fixture(autouse=True)
def requests(thorough: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of the chosen requests, the first on all, and a few steps; in the long run what hypothesis draws."""
    if not thorough:
        monkeypatch.setattr(MethodContract, "cases", lambda self: chosen(self.method, least=self.least))
        monkeypatch.setattr(MethodContract, "many", lambda self, examples: max(examples, 10) // 5)
        monkeypatch.setattr(MethodContract, "steps", lambda self, n: {1, n // 2 + 1, n} & {*range(1, n + 1)})


def fan(e: Exemplar) -> Exemplar:
    """The exemplar, side by side, with dark joints between bricks in courses of 12 px that converge and slant."""
    again = [-(-96 // n) for n in (e.height, e.width)]
    y, x = np.mgrid[: again[0] * e.height, : again[1] * e.width]
    u = 2 * x / x.shape[1] - 1
    down = (y - len(y) / 2) * (1 + 0.15 * u) - 0.03 * x
    joints = (down % 12 < 2) | ((x + 11 * (down // 12)) % 28 < 2)
    samples = np.tile(e.base.samples, (*again, 1))
    pixels = np.where(joints[..., None], 0, samples / 4 + samples.max() / 2)
    usable = np.ones(y.shape, bool)
    usable[: e.height, : e.width] = e.free
    return Exemplar.of(e.base.like(pixels.astype(e.base.pixels.dtype)), usable=usable)


class WholePeriods(PackageLaws):
    """Laws of a method whose wrapped sizes are multiples of `period` px, (rows, columns)."""

    period = 1, 1

    def cases(self) -> SearchStrategy[Case]:
        def whole(case: Case) -> Case:
            wraps = case.wrap.y, case.wrap.x
            rounded = (-(-n // p) * p if w else n for n, p, w in zip(case.size, self.period, wraps, strict=True))
            return replace(case, size=tuple(rounded))

        return super().cases().map(whole)


class TestImageQuilting(PackageLaws):
    """All isometries, all positions searched, gradient seams, no repetition nearby."""

    method = ia.ImageQuilting(
        patch=10, overlap=3, isometries="both", search="exact", seam="gradient", repeat_penalty=0.3, tolerance=0.3
    )
    examples = 8


class TestPatchSampling(PackageLaws):
    """All isometries, all positions searched, cut seams, and the source's counter of repeats."""

    method = ia.PatchSampling(patch=5, overlap=2, isometries="both", search="exact", join="cut", repetition="counter")
    examples = 8


class TestSegmentBased(PackageLaws):
    method = ia.SegmentBased(patch=(9, 14), overlap=(2, 5), hits=3, points=1, threshold=0)
    examples = 8


class TestGraphcut(PackageLaws):
    method = ia.Graphcut(patch=(12, 10), overlap=4)


class TestGraphcutInAllPoses(PackageLaws):
    """What is shown often is dear, in all poses."""

    method = ia.Graphcut(patch=10, overlap=3, isometries="both", refinements=1, evenness=2)
    examples = 8


class TestNearRegular(PackageLaws):
    """Blocks of 9 x 6 px, which close around no canvas."""

    method = ia.NearRegular(lattice=((9, 0), (0, 6)), block=4, border=4, lattice_tolerance=1)
    examples = 6
    least = 30

    def cases(self) -> SearchStrategy[Case]:
        return super().cases().map(lambda case: replace(case, wrap=ia.Wrap.NONE))

    def test_the_wrapped_border_is_no_worse_than_the_inside(self) -> None:
        with pytest.raises(ia.ParameterError, match="closes courses"):
            ia.synthesize(texture(36, 32, 1, 0), (48, 54), self.method, wrap="both")


class TestGapFilling(PackageLaws):
    method = ia.GapFilling(lattice=((9, 0), (0, 6)), block=8, border=4, lattice_tolerance=1)
    examples = 6
    least = 30


class TestBestTile(WholePeriods):
    """Vectors of fractions of a px, which a wrap strains; wrapped sizes are whole numbers of periods."""

    period = 6, 9
    method = ia.BestTile(lattice=((9.1, 0.05), (-0.07, 5.93)), band=3)
    examples = 8
    least = 24


class TestNearRegularOfOneVector(WholePeriods):
    """Wrapped sizes are a whole number of courses, here of 8 px; along them any width closes."""

    method, period = ia.NearRegular(lattice=((0, 8),)), (8, 1)
    examples = 6
    least = 30


class TestStraightenedNearRegular(TestNearRegularOfOneVector):
    """Courses of 12 px that converge by a third and slant, laid straight first."""

    method, period = ia.NearRegular(lattice=((0, 12),), straighten="on"), (12, 1)
    least = 40

    def cases(self) -> SearchStrategy[Case]:
        return super().cases().map(lambda case: replace(case, exemplars=tuple(fan(e) for e in case.exemplars)))

    def test_the_exemplars_are_laid_straight(self) -> None:
        def law(case: Case) -> None:
            straight = rectified_for(case.exemplars[0], self.method.slug, self.method.lattice, "on").straight
            assert straight is not None
            assert straight.off > 1

        self.for_all(law)


class TestRandomTiling(PackageLaws):
    method = ia.RandomTiling(patch=11, isometries="both")
    examples = 8


class TestRepeat(PackageLaws):
    method = ia.Repeat()
    examples = 8


class TestEfrosLeung(PackageLaws):
    method = ia.EfrosLeung(window=(3, 7), isometries="180", tolerance=0.5)
    examples = 4


class TestRasterQuilting(PackageLaws):
    method = ia.RasterQuilting(patch=(9, 11), overlap=(3, 2))


class TestWeiLevoy(PackageLaws):
    method = ia.WeiLevoy(window=(2, 3), levels=2)
    examples = 5


class TestAshikhmin(PackageLaws):
    method = ia.Ashikhmin(window=(2, 7))
    examples = 4


class TestParallelControllable(PackageLaws):
    method = ia.ParallelControllable(jitter=(0.2, 0.4))
    examples = 8


class TestCorrection2008(PackageLaws):
    """5 x 5 colours and candidates, jumps at no extra price."""

    method = ia.Correction2008(jitter=0.5, kappa=1, k=3, passes=1)
    examples = 5


def test_every_method_is_under_contract() -> None:
    classes = [*PackageLaws.__subclasses__(), *WholePeriods.__subclasses__()]
    assert {c.method.slug for c in classes if hasattr(c, "method")} == set(METHODS)


def test_a_law_that_a_method_does_not_claim_has_no_test() -> None:
    """It comes back where a class below tests a method that does."""
    law = "test_a_computed_window_is_a_crop"
    assert not callable(getattr(TestImageQuilting, law))
    assert callable(getattr(TestRepeat, law))
    below = type("TestBelow", (TestImageQuilting,), {"method": ia.Repeat()})
    assert callable(getattr(below, law))
