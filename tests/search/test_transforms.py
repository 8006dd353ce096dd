"""What the search adds up stays within its numbers: sums of squares in 32 bits, correlations in doubles."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from intarsia.analysis.features import features
from intarsia.model import Exemplar
from intarsia.model.image import Kind, Plane
from intarsia.search import PosedExemplars, fourier_kernels, posed_exemplars
from intarsia.search.fourier import PatchSearch
from intarsia.testing import texture

SIDE, PATCH = 620, 200


def measured(window: NDArray, picture: NDArray, known: NDArray, y: int, x: int) -> int:
    """What the kernel says that a window differs from the patch of a picture (H, W, C) at (y, x)."""
    spans = np.empty((len(known), 3), np.int64)
    fourier_kernels.row_spans(known, spans)
    stride = picture.shape[1] * picture.shape[2]
    start = y * stride + x * picture.shape[2]
    far = fourier_kernels.FAR
    return int(fourier_kernels.window_distance(window.ravel(), known, spans, picture.ravel(), start, stride, 1, far))


@pytest.mark.parametrize("channels", [1, 3, 6, 200])
@pytest.mark.parametrize("holes", [False, True])
@pytest.mark.parametrize("side", [9, 64, 125, 513])
def test_distances_of_the_farthest_features_are_exact(side: int, holes: bool, channels: int) -> None:
    """White against black in all channels and their surroundings: +-2046, over rows of any length."""
    if side * channels > 6000:
        side = 6000 // channels
    window, picture = (np.full((side, side, channels), v, np.int16) for v in (2046, -2046))
    known = np.ones((side, side), np.uint8)
    if holes:
        known[::2, side // 2] = 0
    assert measured(window, picture, known, 0, 0) == int(known.sum()) * channels * 4092**2


@pytest.mark.parametrize("structure", [0.0, 0.3, 4.0])
@pytest.mark.parametrize("weights", [None, (1.0, 0.0, 1000.0)])
def test_features_differ_by_no_more_than_the_distance_can_add_up(
    weights: tuple[float, ...] | None, structure: float
) -> None:
    pixels = texture(40, 44, 3, 1) // 255 * 255
    planes = {"albedo": pixels, "normal": np.where(texture(40, 44, 3, 2) > 128, 255, 0).astype(np.uint8)}
    planes["height"] = Plane((pixels[:, :, 0] * 1e6).astype(np.float32), Kind.DATA)
    picture = features([Exemplar.of(planes)], weights, structure).pictures[0].astype(int)
    assert picture.max() - picture.min() <= 4092
    assert 128 * 4092**2 < 1 << 31


def laid_out(picture: NDArray, patch: int) -> PosedExemplars:
    e = Exemplar.of(picture)
    return posed_exemplars([e], features([e]), (0,), (patch, patch))


def distances(search: PatchSearch, window: NDArray) -> tuple[NDArray, NDArray]:
    """At some positions, the short-list's squared distances and the exact ones of the reduced pictures."""
    h, w = search.patch
    reduced = search.reduce(window[None], np.ones((1, h, w), np.uint8))
    correlation = search.correlations(0, reduced)
    out = np.empty(search.valid[0].shape, np.int32)
    squares = reduced.squares[0][reduced.slots[0]]
    fourier_kernels.patch_distances(correlation[0], squares, reduced.energies[0], search.valid[0], out)
    whole, mine = reduced_pictures(search, window)
    exact = [
        [int(((whole[:, y : y + mine.shape[1], x : x + mine.shape[2]] - mine) ** 2).sum()) for x in (0, 7, 40)]
        for y in (0, 11, 40)
    ]
    return out[np.ix_((0, 11, 40), (0, 7, 40))].astype(np.int64), np.array(exact)


def reduced_pictures(search: PatchSearch, window: NDArray) -> tuple[NDArray, ...]:
    return tuple(search._reduced(p).astype(np.int64) for p in (search.variants.picture(0), window))


def test_the_exact_search_of_large_patches_stays_below_32_bits() -> None:
    """1600 px: a white window in a black exemplar, of which a tenth is white."""
    pixels = np.zeros((1640, 1640), np.uint8)
    pixels[:500, :500] = 255
    search = PatchSearch(laid_out(pixels, 1600), (1600, 1600), 500, True)
    found, exact = distances(search, np.full((1600, 1600, 1), 1023, np.int16))
    np.testing.assert_array_equal(found, exact)
    assert exact.max() > 1 << 26


def on_gray(name: str, side: int, patch: int) -> NDArray[np.uint8]:
    """Pictures whose parts are all of one phase, so that errors of a transform add up."""
    y, x = np.mgrid[:side, :side]
    low, high = side // 10, side - patch - 5
    signs = {
        "two plates": ((y >= low) & (y < low + patch) & (x >= low) & (x < low + patch)).astype(int)
        - ((y >= high) & (y < high + patch) & (x >= high) & (x < high + patch)),
        "a corner": ((y < patch) & (x < patch)).astype(int),
        "stripes": np.where(x % 32 < 16, 1, -1) * ((y < patch) & (x < patch)),
        "stripes all over": np.where(x % 16 < 8, 1, -1),
        "checks": np.where((x // 18 + y // 18) % 2, 1, -1),
        "halves": np.where(x < side // 2, 1, -1),
    }[name]
    return np.asarray(128 + 127 * signs, np.uint8)


WORST = ["two plates", "a corner", "stripes", "stripes all over", "checks", "halves"]


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("name", WORST)
def test_correlations_are_whole_numbers_in_the_worst_window(name: str, exact: bool) -> None:
    """620 px, patch 200: what is rounded is the exact correlation, at every position."""
    pixels = on_gray(name, SIDE, PATCH)
    search = PatchSearch(laid_out(pixels, PATCH), (PATCH, PATCH), 66, exact)
    picture = search.variants.picture(0)
    for top, left in ((0, 0), (SIDE // 10, SIDE // 10), (SIDE - PATCH - 5, SIDE - PATCH - 5)):
        window = np.ascontiguousarray(picture[top : top + PATCH, left : left + PATCH])
        reduced = search.reduce(window[None], np.ones((1, PATCH, PATCH), np.uint8))
        got = search.correlations(0, reduced)[0]
        got = got[:, : search.valid[0].shape[1]]
        whole, mine = reduced_pictures(search, window)
        np.testing.assert_array_equal(np.floor(got + 0.5), by_doubles(whole, mine))


def by_doubles(whole: NDArray, mine: NDArray) -> NDArray:
    """Correlate whole numbers in double precision, which is far from missing one, and round."""
    shape = whole.shape[1:]
    product = np.fft.rfft2(whole, shape) * np.conj(np.fft.rfft2(mine, shape))
    full = np.rint(np.fft.irfft2(product.sum(axis=0), shape))
    return full[: shape[0] - mine.shape[1] + 1, : shape[1] - mine.shape[2] + 1]
