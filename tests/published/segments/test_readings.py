"""The fragments' own choice of a group: at one scale, in every reading of its energy."""

from __future__ import annotations

import numpy as np
import pytest
from segments.test_segments import dots
from torture import TORTURE

import intarsia as ia
from intarsia.model import Exemplar
from intarsia.published.segments.engine import ENERGIES, published_segments
from intarsia.segments import SizeRule
from intarsia.segments.feature_group import DISC, Group


def test_energies_are_those_that_are_printed():
    rng = np.random.default_rng(3)
    found = Group(rng.integers(3, 30, (7, 2)), rng.integers(0, 400, (7, 2)), rng.integers(12, 90, 7),
                  rng.integers(5, 12, 7), 7, 5000)  # fmt: skip
    d, (h, w) = np.floor(np.hypot(*found.offsets.T)) / 16, found.sizes.T
    q = (found.edges**2).sum() / found.areas.sum()
    side = (h + w) / 2
    a, b = d.var() / max(np.ptp(d), 1), side.var() / max(np.ptp(side), 1)
    assert ENERGIES["sum"](found) == pytest.approx(a + b + q / DISC)
    assert ENERGIES["product"](found) == pytest.approx(a * b + q / DISC)
    dy, dx = found.offsets.T / 16
    assert ENERGIES["variances"](found) == pytest.approx(dy.var() + dx.var() + h.var() + w.var())


@pytest.mark.parametrize("form", list(ENERGIES))
def test_the_published_choice_finds_clean_dots(form):
    """SelectFeature at one scale, without a vote: patches of a dot and its gap; where no group will do it says so."""
    found = published_segments(Exemplar.of(dots(24, 7)), form)
    assert found.rule is SizeRule.SEGMENTS
    assert abs(found.patch - 24) <= 2
    assert found.chosen is not None
    assert published_segments(Exemplar.of(TORTURE["gradient"]()), form).rule is SizeRule.AUTOCORRELATION


def test_the_method_lays_what_a_reading_finds():
    e = Exemplar.of(dots(24, 7))
    found = published_segments(e, "sum")
    made = ia.synthesize(e, 150, ia.SegmentBased(energy="sum"), seed=1)
    assert (made.method.patch, made.method.overlap) == (found.patch, found.zone)
