"""Tests of the sRGB tables and of the numbers that matching starts from."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from intarsia.model.image import Kind, Plane, Transfer
from intarsia.rendering import BITS, code_lookup, code_steps, code_values, from_linear, light_table, to_linear


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_every_code_survives_the_way_to_light_and_back(dtype: str) -> None:
    codes = np.arange(np.iinfo(dtype).max + 1).astype(dtype).reshape(-1, 16)
    plane = Plane(codes)
    light = to_linear(plane)
    assert light.dtype == np.int32
    assert (np.diff(light.reshape(-1)) > 0).all()
    assert light.min() == 0
    assert light.max() == 1 << BITS
    assert (from_linear(light, plane)[:, :, 0] == codes).all()


def test_8_bit_light_is_that_of_16_bit() -> None:
    assert (light_table(1) == light_table(2)[::257]).all()


@pytest.mark.parametrize("size", [1, 2])
def test_steps_and_shelf_agree_with_the_formula(size: int) -> None:
    top = 256**size - 1
    light = np.random.default_rng(size).integers(0, (1 << BITS) + 1, 20000)
    share = light / (1 << BITS)
    srgb = np.where(share <= 0.04045 / 12.92, share * 12.92, 1.055 * share ** (1 / 2.4) - 0.055)
    codes = np.searchsorted(code_steps(size), light, side="right")
    exact = srgb * top
    sure = np.abs(exact - np.floor(exact) - 0.5) > 1e-3  # far from where rounding turns
    assert (codes == np.floor(exact + 0.5))[sure].all()
    shelf, shift = code_lookup(size)
    assert (shelf[light >> shift] <= codes).all()
    assert shelf.max() <= top


def test_the_tables_are_rounded_up_exactly() -> None:
    # light <= r exactly when z**12 * 2**(5 BITS) <= r**5, on the curved part
    for code in range(11, 256):
        z = (Fraction(code, 255) + Fraction(55, 1000)) / Fraction(1055, 1000)
        r = int(light_table(1)[code])
        assert (r - 1) ** 5 < z**12 * (1 << 5 * BITS) <= r**5
    for code in range(11):
        exact = Fraction(code, 255) * Fraction(100, 1292) * (1 << BITS)
        assert 0 <= int(light_table(1)[code]) - exact < 1


def test_floats_follow_the_formula_beyond_white_and_below_black() -> None:
    values = np.array([[0.0, 0.02, 0.5, 1.0, 4.0, -0.5]])
    plane = Plane(values)
    light = to_linear(plane)[:, :, 0]
    np.testing.assert_allclose(light, [[0, 0.02 / 12.92, 0.21404114, 1, 25.0, -0.21404114]], rtol=0.1)
    assert light[0, 3] == 1.0
    assert light[0, 5] == -light[0, 2]
    np.testing.assert_allclose(from_linear(to_linear(plane), plane)[:, :, 0], values, rtol=1e-14)


def test_what_has_no_curve_passes_through() -> None:
    rng = np.random.default_rng(0)
    for dtype in ("uint8", "uint16", "float32"):
        pixels = (rng.random((4, 5, 4)) * 200).astype(dtype)
        for plane in (Plane(pixels, transfer=Transfer.LINEAR), Plane(pixels, Kind.DATA)):
            assert (to_linear(plane) == pixels).all()
            assert (from_linear(to_linear(plane), plane) == pixels).all()
        assert (to_linear(Plane(pixels))[..., 3] == pixels[..., 3]).all(), "opacity"


@pytest.mark.parametrize("transfer", list(Transfer))
@pytest.mark.parametrize("kind", [Kind.COLOUR, Kind.DATA])
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_code_values_do_not_depend_on_the_depth(transfer: Transfer, kind: Kind, channels: int) -> None:
    codes = np.random.default_rng(0).integers(0, 256, (64, 64, channels), dtype=np.uint8)
    same = [codes, codes.astype(np.uint16) * np.uint16(257), (codes / 255).astype(np.float32), codes / 255]
    values = [code_values(Plane(p, kind, transfer)) for p in same]
    assert values[0].dtype == np.int32
    assert all((v == values[0]).all() for v in values)


def test_code_values_of_integers_are_16_bit_codes() -> None:
    codes = np.arange(256, dtype=np.uint8).reshape(16, 16)
    assert (code_values(Plane(codes))[:, :, 0] == codes.astype(int) * 257).all()
    wide = np.arange(65536, dtype=np.uint16).reshape(256, 256)
    assert (code_values(Plane(wide))[:, :, 0] == wide).all()


def test_scene_light_goes_through_an_odd_rising_curve() -> None:
    v = np.sort(np.concatenate([np.linspace(-2, 2, 401), 10.0 ** np.arange(-4, 30), -(10.0 ** np.arange(-4, 30))]))
    values = code_values(Plane(v[None], transfer=Transfer.LINEAR))[0, :, 0]
    assert (np.diff(values) >= 0).all()
    assert (values == -values[::-1]).all()
    assert code_values(Plane(np.zeros((1, 1)), transfer=Transfer.LINEAR)).item() == 0
    assert abs(code_values(Plane(np.ones((1, 1)), transfer=Transfer.LINEAR)).item() - 65535) < 100
    assert values.max() < 1 << 24


def test_code_values_of_labels_and_of_what_is_not_finite() -> None:
    labels = np.array([[0, 7, 200]], np.uint8)
    assert (code_values(Plane(labels, Kind.LABEL))[:, :, 0] == labels).all()
    huge = np.array([[1, 2, (1 << 32) - 1]], np.uint32)
    assert len(np.unique(code_values(Plane(huge, Kind.LABEL)))) == 3
    for transfer in Transfer:
        odd = code_values(Plane(np.array([[np.nan, np.inf, -np.inf, 0.0]]), transfer=transfer))
        assert (odd == 0).all()
    far = code_values(Plane(np.array([[1e9, -1e9]]), Kind.DATA))[:, :, 0]
    assert (far == [[1 << 24, -(1 << 24)]]).all()
