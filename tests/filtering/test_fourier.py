"""Transforms and filters: the same bytes as SciPy's, whether or not its packages are imported."""

import itertools
import subprocess
import sys

import numpy as np
import pytest
import scipy.fft
from scipy import ndimage

from intarsia.filtering import filters, fourier

CORES = {"compiled": fourier.compiled(), "package": fourier.ByPackage()}
REAL, WAVES = (np.float32, np.float64, np.uint8, np.bool_), (np.complex64, np.complex128, np.float64)
SHAPES = ((40, 53), (7, 90), (3, 4), (1, 9))


def equal(found, wanted):
    assert (found.dtype, found.shape) == (wanted.dtype, wanted.shape)
    assert found.tobytes() == wanted.tobytes()


def of(dtype, shape=(3, 14, 23)):
    values = np.random.default_rng(5).random((2, *shape)) * 9
    return (values[0] + 1j * values[1]).astype(dtype) if np.dtype(dtype).kind == "c" else values[0].astype(dtype)


@pytest.fixture(params=CORES)
def core(request, monkeypatch):
    monkeypatch.setattr(fourier, "_core", CORES[request.param])


@pytest.mark.usefixtures("core")
class TestTransforms:
    @pytest.mark.parametrize("dtype", REAL)
    def test_those_of_real_numbers_are_scipys(self, dtype):
        x = of(dtype)
        for size in (None, (14, 23), (20, 25), [9, 32]):
            equal(fourier.rfft2(x, size), scipy.fft.rfft2(x, size))
            equal(fourier.fft2(x, size), scipy.fft.fft2(x, size))
        for n, axis in itertools.product((None, 11, 30), range(3)):
            equal(fourier.rfft(x, n, axis=axis), scipy.fft.rfft(x, n, axis=axis))
            equal(fourier.fft(x, n, axis=axis), scipy.fft.fft(x, n, axis=axis))
        for axes in (None, (0, 1), (1, 2)):
            equal(fourier.dctn(x, axes), scipy.fft.dctn(x, axes=axes))
            equal(fourier.idctn(x, axes), scipy.fft.idctn(x, axes=axes))

    @pytest.mark.parametrize("dtype", WAVES)
    def test_those_back_are_scipys(self, dtype):
        x = of(dtype)
        for size in (None, (14, 45), (10, 20), [30, 64]):
            equal(fourier.irfft2(x, size), scipy.fft.irfft2(x, size))
        for n, axis in itertools.product((None, 11, 30), range(3)):
            equal(fourier.irfft(x, n, axis=axis), scipy.fft.irfft(x, n, axis=axis))
            for spare in (False, True):
                equal(fourier.ifft(x.copy(), n, axis, spare), scipy.fft.ifft(x, n, axis))

    def test_fast_lengths_are_scipys(self):
        fourier.next_fast_len.cache_clear()
        for n, real in itertools.product(range(1, 200), (False, True)):
            assert fourier.next_fast_len(n, real) == scipy.fft.next_fast_len(n, real)


def test_another_scipy_is_asked_by_its_package():
    assert isinstance(fourier.compiled("scipy.fft._pocketfft.other"), fourier.ByPackage)
    assert isinstance(fourier.compiled("scipy.ndimage._nd_image_"), fourier.ByPackage)


@pytest.mark.parametrize("shape", SHAPES)
class TestFilters:
    @pytest.mark.parametrize(("beyond", "mode"), [(filters.HELD, "nearest"), (filters.MIRRORED, "reflect")])
    def test_those_with_borders_are_scipys(self, shape, beyond, mode):
        x = of(np.float64, shape) * 1e5
        whole = x.astype(np.int64)
        for sigma in (0.7, 1.0, 1.5, 3.3):
            equal(filters.blurred(x, (sigma, sigma), beyond), ndimage.gaussian_filter(x, sigma, mode=mode))
            equal(filters.blurred(x[0], (sigma,), beyond), ndimage.gaussian_filter1d(x[0], sigma, mode=mode))
        for size in (1, 3, 5, 11, 27):
            equal(filters.highest(whole, size, beyond), ndimage.maximum_filter(whole, size, mode=mode))
            equal(filters.lowest(x, size, beyond), ndimage.minimum_filter(x, size, mode=mode))
            equal(filters.filled(whole, size, beyond), ndimage.grey_closing(whole, (size, size), mode=mode))
            equal(filters.worn(whole, size, beyond), ndimage.grey_opening(whole, (size, size), mode=mode))

    def test_means_are_scipys(self, shape):
        x = of(np.float64, shape) * 1e5
        for size in (1, 2, 3, 4, 7, 10):
            equal(filters.mean_around(x, (size, size)), ndimage.uniform_filter(x, size))
            whole = (x - 4e5).astype(np.int32)[..., None] + np.array([0, 7, 99], np.int32)
            equal(filters.mean_around(whole, (size, size, 1)), ndimage.uniform_filter(whole, (size, size, 1)))

    def test_grown_masks_are_scipys(self, shape):
        mask = of(np.float64, shape) < 1
        for steps in (1, 2, 5):
            equal(filters.grown(mask, steps), ndimage.binary_dilation(mask, iterations=steps))

    def test_depths_are_scipys_as_far_as_they_are_looked_for(self, shape):
        for often in (0.2, 1, 3, 9.5):
            inside = of(np.float64, shape) > often
            inside[-1, -1] = False
            for most in (1, 4, 7, 200):
                equal(filters.depths(inside, most), np.minimum(ndimage.distance_transform_edt(inside), most))


def test_a_texture_is_chosen_for_and_grown_without_what_is_slow_to_import():
    code = """
import sys
import intarsia as ia
for name in ("grass", "planks", "stones", "tiles"):
    ia.synthesize(f"sample:{name}", (160, 160), run=ia.Run(1)).render()
print([m for m in ("scipy.fft", "scipy.ndimage", "scipy.special", "scipy.spatial", "skimage") if m in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=300)
    assert done.stdout.strip() == "[]"
