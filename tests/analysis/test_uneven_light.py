"""Flattening: light is found and taken off, the mean stays, and nothing is lost."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from intarsia.analysis import illumination as of_light
from intarsia.analysis.illumination import FittedIllumination


def lit(size=(96, 120), seed=1):
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: size[0], : size[1]] / max(size)
    light = np.exp(0.7 * x - 0.4 * y - 0.8 * (x - 0.4) ** 2)
    return rng.uniform(0.3, 0.6, (*size, 3)), light


def uneven_light(picture, usable=None) -> FittedIllumination:
    """The light on a picture (H, W) or (H, W, C) of any depth."""
    seen = np.ones(picture.shape[:2], bool) if usable is None else usable
    colours = picture.reshape(*picture.shape[:2], -1)[..., : 3 if picture.ndim == 3 else 1].astype(np.float64)
    return of_light.fit_illumination(np.where(seen[..., None], colours, 0.0), seen)


def test_light_is_found_and_taken_off():
    surface, light = lit()
    found = uneven_light(surface * light[..., None])
    assert np.corrcoef(found.gain.ravel(), light.ravel())[0, 1] > 0.99
    ratio = light / found.gain
    assert ratio.std() / ratio.mean() < 0.05
    assert found.strength > 0.3
    assert found.gain.mean() == pytest.approx(1, abs=1e-5)


@given(st.sampled_from(["uint8", "uint16", "uint32", "float16", "float32"]), st.integers(0, 999))
def test_nothing_is_lost(dtype, seed):
    surface, light = lit((17, 23), seed)
    scale = np.iinfo(dtype).max if np.issubdtype(dtype, np.integer) else 1
    given = (np.clip(surface * light[..., None], 0, 1) * scale).astype(dtype)
    given[3, 4] = 0
    before = given.copy()
    found = uneven_light(given)
    gain = found.gain[..., None]
    lit_again = given.astype(np.float64) / gain * gain
    assert np.array_equal((np.rint(lit_again) if scale > 1 else lit_again).astype(dtype), given)
    assert np.array_equal(given, before)
    assert np.allclose(lit_again, given.astype(np.float64), rtol=1e-15, atol=0)


def test_parts_see_light_that_dark_joints_hide():
    """Joints that stay as dark as they were would hold back a fit to every px, which is off by far more."""
    surface, light = lit((120, 150))
    picture = surface * light[..., None]
    picture[::4], picture[:, ::4] = 0.01, 0.01
    assert np.abs(np.log(uneven_light(picture).gain / (light / light.mean()))).max() < 0.12


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (7, 1, 3), (2, 2, 3)])
def test_tiny_black_and_constant_pictures(shape):
    for value in (0, 90):
        found = uneven_light(np.full(shape, value, np.uint8))
        assert found.strength == 0
        assert (found.gain == 1).all()
    uneven_light(np.random.default_rng(0).uniform(0, 1, shape))
    assert uneven_light(np.ones((5, 5)), np.zeros((5, 5), bool)).strength == 0
