"""The exact search in single precision: its error stays within what is proven, its lists are those of doubles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from search.test_transforms import WORST, by_doubles, laid_out, on_gray

from intarsia.search import fourier_kernels, near, reduce_kernels
from intarsia.search.candidates import Prices
from intarsia.search.fourier import PatchSearch
from intarsia.search.transforms import Correlator, passes
from intarsia.testing import texture

SIDE, PATCH = 150, 40


@pytest.mark.parametrize("name", WORST)
def test_single_precision_errs_less_than_is_proven(name: str) -> None:
    worst = 0.0
    for side in (49, 60, 91, 128, 187, 256, 309):
        for patch in (side // 10, side // 3, side * 9 // 10):
            picture = (on_gray(name, side, patch).astype(int) - 128) * 63 // 127
            correlator = Correlator([picture[None].astype(np.float32)], (patch, patch))
            for at in {0, min(side // 10, side - patch), side - patch}:
                window = picture[at : at + patch, at : at + patch].copy()
                window[patch // 3 :, patch // 3 :] = 0
                norm = np.sqrt((window.astype(float) ** 2).sum())
                spectra = correlator.spectra(window[None, None].astype(np.float32))
                got, wrong = correlator.near(0, spectra, side - patch + 1, np.array([norm]))
                error = np.abs(got[0, :, : side - patch + 1] - by_doubles(picture[None], window[None])).max()
                worst = max(worst, error / wrong[0] if norm else 0.0)
    assert 0 < worst < 1


def test_a_transform_is_wrong_by_less_than_its_passes() -> None:
    """Of complex noise and of ones, for lengths of every factor that a transform is made of."""
    import scipy.fft

    rng = np.random.default_rng(0)
    for length in (2, 3, 4, 5, 7, 8, 11, 30, 77, 121, 256, 343, 625, 1024, 2187):
        for values in (rng.normal(size=(8, length)) + 1j * rng.normal(size=(8, length)), np.ones((1, length)) * 0.7):
            single = values.astype(np.complex64)
            got, truth = scipy.fft.fft(single), scipy.fft.fft(single.astype(np.complex128))
            assert np.linalg.norm(got - truth) <= passes(length) * 2.0**-24 * np.linalg.norm(truth)


def pictures() -> dict[str, NDArray[np.uint8]]:
    some = {name: on_gray(name, SIDE, PATCH) for name in WORST}
    return some | {"a texture": texture(SIDE, SIDE, 3, 1), "flat": np.full((SIDE, SIDE), 90, np.uint8)}


def listed(search: PatchSearch, feats: NDArray, known: NDArray, prices: Prices) -> list[list[NDArray]]:
    """The short-lists and usual distances as the exact search has them, and by doubles as they always were."""
    n = len(feats)
    outs = [(np.zeros((n, 16, 4), np.int64), np.zeros(n, np.int64), np.full(n, -1), np.zeros((n, 16, 4), np.int64))]
    outs.append(tuple(o.copy() for o in outs[0]))  # type: ignore[arg-type]
    reduced = search.reduce(feats, known, True)
    near.rank(search, feats, known, reduced, near.correlate_near(search, reduced), prices, outs[0])
    reduced = replace(reduced, spectra=search.correlator.spectra(reduced.templates.astype(np.float64)))
    for v, valid in enumerate(search.valid):
        mine = reduced.correlated(v, search.correlations(v, reduced), valid)
        fourier_kernels.short_list(mine, prices.of(v), reduce_kernels.Listed(*outs[1][:3]))
    return [[best, usual] for best, _, usual, _ in outs]


@pytest.mark.parametrize("name", [*WORST, "a texture", "flat"])
def test_the_lists_are_those_of_doubles(name: str) -> None:
    picture = pictures()[name]
    search = PatchSearch(laid_out(picture, PATCH), (PATCH, PATCH), 10, True)
    rng = np.random.default_rng(3)
    own = search.variants.picture(0)
    at = rng.integers(0, SIDE - PATCH, (6, 2))
    feats = np.stack([own[y : y + PATCH, x : x + PATCH] for y, x in at]).astype(np.int16)
    feats[3:] = np.clip(feats[3:] + rng.integers(-60, 61, feats[3:].shape), 0, 1023)
    known = np.ones(feats.shape[:3], np.uint8)
    known[1::2, 10:, 10:] = 0
    feats[known == 0] = 0
    counts = [rng.integers(0, 700, v.shape).astype(np.int32) * (rng.random(v.shape) < 0.3) for v in search.valid]
    for prices in (search.unpriced, Prices([c.astype(np.int32) for c in counts], 30000)):
        (best, usual), (truth, as_usual) = listed(search, feats, known, prices)
        np.testing.assert_array_equal(usual, as_usual)
        np.testing.assert_array_equal(best, truth)


def test_windows_in_doubt_everywhere_are_done_in_doubles() -> None:
    search = PatchSearch(laid_out(on_gray("stripes all over", SIDE, PATCH), PATCH), (PATCH, PATCH), 10, True)
    known = np.ones((1, PATCH, PATCH), np.uint8)
    window = np.ascontiguousarray(search.variants.picture(0)[:PATCH, :PATCH][None])
    reduced = search.reduce(window, known, True)
    out = (np.zeros((1, 16, 4), np.int64), np.zeros(1, np.int64), np.full(1, -1), np.zeros((1, 16, 4), np.int64))
    correlations = near.correlate_near(search, reduced)
    assert correlations[0].slacks[0] > 0
    assert near._rank(search, window, known, reduced, correlations, search.unpriced, out, 16).tolist() == [1]
    near.rank(search, window, known, reduced, correlations, search.unpriced, out)
    assert out[3][0, 0].tolist()[0] == 0
