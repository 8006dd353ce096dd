"""Correlation of a picture with itself, in part or whole: equal to brute force for all sizes, masks and channels."""

import numpy as np
import pytest
from analysis import naive_correlation as naive_gncc
from hypothesis import given
from hypothesis import strategies as st

from intarsia.analysis.elements import autocorrelation


def picture(rng, height, width, channels):
    return rng.integers(-900, 1023, (height, width, channels)).astype(np.int16)


@given(st.integers(1, 10), st.integers(1, 10), st.integers(1, 3), st.integers(0, 999), st.booleans())
def test_autocorrelation_is_the_correlation_with_itself(height, width, channels, seed, masked):
    rng = np.random.default_rng(seed)
    f = picture(rng, height, width, channels)
    usable = rng.random((height, width)) < 0.8 if masked else None
    correlation, pairs = autocorrelation(f, usable)
    assert np.abs(correlation - naive_gncc.gncc(f, f, usable, usable)).max() < 1e-6
    assert np.array_equal(correlation, correlation[::-1, ::-1])
    wanted = [len(a) for _, _, a, _ in naive_gncc.overlaps(f, f, usable, usable)]
    assert pairs.ravel().tolist() == wanted


def test_one_is_the_most_and_lies_in_the_middle():
    rng = np.random.default_rng(5)
    correlation, _ = autocorrelation(picture(rng, 20, 33, 3))
    assert correlation[19, 32] == pytest.approx(1.0, abs=1e-12)
    assert np.abs(correlation).max() <= 1.0


@pytest.mark.parametrize("masked", [False, True])
def test_a_short_reach_is_the_middle_of_the_whole(masked):
    f, usable = picture(np.random.default_rng(6), 24, 31, 2), np.ones((24, 31), bool) if masked else None
    if masked:
        usable[3:9, 4:20] = False
    whole, pairs = autocorrelation(f, usable)
    part, some = autocorrelation(f, usable, (9, 40))
    assert part.shape == (19, 61)
    assert np.allclose(part, whole[14:33], atol=1e-12)
    assert np.array_equal(some, pairs[14:33])


def test_gain_and_offset_do_not_matter():
    f = picture(np.random.default_rng(7), 12, 15, 1).astype(float)
    assert np.allclose(autocorrelation(f)[0], autocorrelation(0.01 * f - 5)[0], atol=1e-9)


def test_constant_channels_count_nothing():
    f = picture(np.random.default_rng(9), 10, 12, 2)
    f[..., 1] = 77
    assert np.allclose(autocorrelation(f)[0], autocorrelation(f[..., :1])[0], atol=1e-12)
    assert not autocorrelation(np.full((30, 30, 3), 0.1))[0].any()
