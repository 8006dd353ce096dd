"""What pops out is what a looker sees first, at any scale; the twin says the same of every spot."""

import numpy as np
import pytest
from analysis import naive_popout
from hypothesis import given, settings
from hypothesis import strategies as st
from torture import TORTURE

from intarsia.analysis import saliency as module
from intarsia.analysis.features import features
from intarsia.analysis.saliency import MEDIAN, saliency_map
from intarsia.model import Exemplar
from intarsia.testing import texture


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 99), st.booleans(), st.booleans(), st.sampled_from([1, 2, 3]))
def test_spots_are_measured_as_by_the_twin(seed, masked, toroidal, radius):
    rng = np.random.default_rng(seed)
    picture = rng.integers(0, 900, (17, 21, 2)).astype(np.int64)
    usable = rng.random((17, 21)) < (0.7 if masked else 2)
    got, share = module.local_statistics(picture, usable, radius, toroidal)
    want, counts = naive_popout.looks(picture, usable, radius, toroidal)
    assert (got == want).all()
    assert (share == counts).all()
    at = np.argwhere(share >= 2048)[::2]
    spots = rng.integers(-200, 200, (len(at), 3))
    size = (17, 21) if toroidal else (0, 0)
    others = rng.permutation(len(at))[: 1 + seed]
    far = module._relative_distance(spots, at, others, 4, size, 3, 8)
    assert far.tolist() == naive_popout.relative(spots.tolist(), at.tolist(), others.tolist(), 4, size, 3, 8)


def test_spread_is_the_same_in_all_directions():
    """What was stretched and slanted is round again; what hardly varies is not blown up."""
    rng = np.random.default_rng(4)
    flat = rng.normal(size=(4000, 3)) * (3000, 2000, 1)
    spots = np.rint(flat @ np.array([[1, 0.8, 0.1], [0, 1, 0], [0, 0, 1]])).astype(np.int64)
    spread = np.cov((module._whitened(spots) / module.FIXED).T)
    assert np.allclose(np.diag(spread)[:2], [1, 1], atol=0.15)
    assert spread[2, 2] < 0.1
    assert np.abs(spread - np.diag(np.diag(spread))).max() < 0.15


@pytest.mark.parametrize("name", ["red_cluster", "wood_knot"])
def test_what_strikes_pops_out(name):
    picture = features([Exemplar.of(TORTURE[name]())]).pictures[0]
    found = saliency_map(picture)
    y, x = {"red_cluster": (85, 85), "wood_knot": (50, 85)}[name]
    assert found[y, x] > 2 * MEDIAN
    assert found[y - 12 : y + 13, x - 12 : x + 13].max() >= 0.9 * found.max()


def test_a_leaf_on_a_lawn_pops_out_though_its_blades_do_not():
    """Fine strong grain hides nothing that has another colour on the whole."""
    picture = np.random.default_rng(2).integers(0, 1000, (128, 128, 1)).astype(np.int16).repeat(3, axis=2)
    picture[60:72, 80:94] = picture[60:72, 80:94] // 2 + np.array([500, 200, 0], np.int16)
    found = saliency_map(picture)
    assert found[66, 87] == found.max() > 2 * MEDIAN
    assert np.median(found) < 1.5 * MEDIAN


def test_masked_pixels_are_not_seen():
    picture = features([Exemplar.of(texture(96, 96, 3, 2))]).pictures[0].copy()
    usable = np.ones((96, 96), bool)
    usable[40:60, 40:60] = False
    other = picture.copy()
    other[~usable] = 1023
    found = saliency_map(picture, usable)
    assert (found == saliency_map(other, usable)).all()
    assert (found[46:54, 46:54] <= found[usable].max()).all()


@pytest.mark.parametrize("shape", [(1, 1), (3, 90), (30, 40), (64, 64), (700, 500)])
def test_a_uniform_exemplar_pops_out_nowhere(shape):
    found = saliency_map(np.full((*shape, 3), 512, np.int16))
    assert found.shape == shape
    assert found.dtype == np.int32
    assert set(np.unique(found)) <= {0, MEDIAN}
