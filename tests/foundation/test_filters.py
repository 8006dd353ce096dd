"""Filters against SciPy's, which takes longer to import than they do, and lengths against a naive search."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import fft, ndimage

from intarsia.foundation import filters

MODES = {"constant": "constant", "edge": "nearest", "symmetric": "reflect", "wrap": "wrap"}
SHAPES = ((1, 1), (1, 9), (13, 2), (12, 17), (9, 8, 3))


def picture(shape, seed=1):
    return np.random.default_rng(seed).integers(-300, 300, shape)


def test_a_fast_length_is_the_first_without_other_primes():
    def slow(n):
        return all(n % p for p in range(2, n + 1) if p not in (2, 3, 5) and all(p % q for q in range(2, p)))

    for least in range(1, 130):
        assert filters.fast_length(least) == next(n for n in range(least, 2 * least + 1) if slow(n))


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("shape", SHAPES)
def test_sums_and_extremes_are_those_of_scipy(mode, shape):
    values = picture(shape)
    for size in (1, 3, 5, 11):
        ones = np.ones(size)
        for axis in (0, 1):
            want = ndimage.convolve1d(values.astype(float), ones, axis, mode=MODES[mode])
            assert (filters.moving_sums(values, axis, size // 2, mode) == want).all()
        square = (size, size, 1)[: values.ndim]
        how = {"size": square, "mode": MODES[mode]}
        assert (filters.highest(values, size, mode) == ndimage.maximum_filter(values, **how)).all()
        assert (filters.lowest(values, size, mode) == ndimage.minimum_filter(values, **how)).all()


def test_averages_are_rounded_down_after_each_axis():
    values = picture((12, 17)) + 300
    want = values
    for axis in (0, 1):
        want = np.floor(ndimage.uniform_filter1d(want.astype(float), 5, axis, mode="reflect"))
    assert (filters.averages(values, 2) == want).all()


@pytest.mark.parametrize("sigma", [0.7, 1.5, 4.0])
@pytest.mark.parametrize("mode", MODES)
def test_narrow_gaussians_are_those_of_scipy(mode, sigma):
    values = picture((12, 17)).astype(float)
    want = ndimage.gaussian_filter(values, sigma, mode=MODES[mode])
    assert filters.blurred(values, sigma, mode) == pytest.approx(want, abs=1e-9)
    rows = ndimage.gaussian_filter1d(values, sigma, 0, mode=MODES[mode])
    assert filters.blurred(values, sigma, mode, (0,)) == pytest.approx(rows, abs=1e-9)


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (30, 41)])
def test_wide_gaussians_are_products_in_the_cosine_transform(shape):
    values = picture(shape).astype(float)
    down, right = (np.pi * np.arange(n) / n for n in shape)
    for sigma in (1.0, 5.0):
        decay = np.exp(-0.5 * sigma**2 * (down[:, None] ** 2 + right**2))
        want = fft.idctn(fft.dctn(values) * decay)
        assert filters.widely_blurred(values, sigma) == pytest.approx(want, abs=1e-9)
    assert filters.widely_blurred(values, 1e3) == pytest.approx(np.full(shape, values.mean()))
