"""Floats of any range: heights in metres, lamps, holes of -1e30 and planes of one value are seen as they are."""

from __future__ import annotations

import numpy as np
import pytest
from analysis.naive_ranges import stretched
from hypothesis import given, settings
from hypothesis import strategies as st

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.model import Exemplar
from intarsia.model.canvas import Guide
from intarsia.model.image import Kind, Plane, Transfer
from intarsia.testing import texture


def heights(low: float = 0.05, high: float = 0.95, seed: int = 3) -> np.ndarray:
    """Smooth heights of many levels from low to high."""
    fine = texture(40, 44, 1, seed)[:, :, 0] / 255 + texture(40, 44, 1, seed + 1)[:, :, 0] / 255 / 97
    return low + (high - low) * (fine - fine.min()) / (fine.max() - fine.min())


def of(pixels: np.ndarray, kind: Kind = Kind.DATA, **more) -> np.ndarray:
    return features([Exemplar.of(Plane(pixels, kind), **more)]).pictures[0][:, :, 0].astype(int)


@settings(max_examples=60, deadline=None, derandomize=True, database=None)
@given(
    power=st.floats(-30, 30), width=st.floats(0.02, 2), sign=st.sampled_from([-1, 1]),
    dtype=st.sampled_from(["float32", "float64"]), seed=st.integers(0, 99),
)  # fmt: skip
def test_data_of_any_range_are_stretched_to_it(power: float, width: float, sign: int, dtype: str, seed: int) -> None:
    """From 1e-30 to 1e30, above or below 0: the exact stretch, but where a value lies just between two features."""
    values = (10.0**power * heights(sign - width / 2, sign + width / 2, seed)).astype(dtype)
    exact, clear = stretched(values)
    found = of(values)
    assert clear.mean() > 0.5
    assert (found == exact)[clear].all()
    assert np.abs(found - exact).max() <= 1


@pytest.mark.parametrize("steps", [1, 2, 3, 100, 513, 65535])
def test_whole_codes_of_16_bits_as_floats_are_those_codes(steps: int) -> None:
    """Law 13 of data, at every width of range: single precision is wrong by less than a code can tell."""
    start = (65535 - steps) * 3 // 4
    codes = (start + np.random.default_rng(steps).integers(0, steps + 1, (40, 40))).astype(np.uint16)
    for dtype in ("float32", "float64"):
        np.testing.assert_array_equal(of((codes / 65535).astype(dtype)), of(codes))


@pytest.mark.parametrize("size", [(20, 22), (80, 88)])
def test_the_depth_of_planes_of_other_sizes_changes_no_feature(size: tuple[int, int]) -> None:
    """Law 13 where cells are averaged, and where colour is premultiplied, in whole codes."""
    albedo, height = texture(40, 44, 4, 1), texture(*size, 1, 2)[:, :, 0]
    one = features([Exemplar.of({"albedo": albedo, "height": Plane(height, Kind.DATA)})]).pictures[0]
    floats = Plane((height / 255).astype(np.float32), Kind.DATA)
    colours = Plane((albedo / 255).astype(np.float32), Kind.COLOUR, Transfer.SRGB)
    np.testing.assert_array_equal(features([Exemplar.of({"albedo": colours, "height": floats})]).pictures[0], one)


@pytest.mark.parametrize(("dtype", "top"), [("float32", 1e4), ("float16", 65280.0), ("float32", 1e-5)])
def test_coded_colours_beyond_white_are_told_apart(dtype: str, top: float) -> None:
    levels = len(np.unique(of(heights(0, 1).astype(dtype), Kind.COLOUR)))
    assert len(np.unique(of((heights(0, 1) * top).astype(dtype), Kind.COLOUR))) > 0.8 * levels > 200


@pytest.mark.parametrize("far", [-1e30, 1e30, 65504.0, 1000.0])
def test_a_few_numbers_far_off_do_not_flatten_the_rest(far: float) -> None:
    values = heights(0, 1).astype(np.float32)
    plain = of(values)
    values[20, 20] = far
    found = of(values)
    assert len(np.unique(found)) > 100
    rest = np.delete(found.ravel(), 20 * 44 + 20)
    assert np.corrcoef(rest, np.delete(plain.ravel(), 20 * 44 + 20))[0, 1] > 0.999
    assert found[20, 20] == (1023 if far > 0 else 0)


def test_no_8_bit_picture_is_cut() -> None:
    """Law 13 holds, since what 8 bits can hold keeps its whole range: stars on a dark sky stay bright."""
    sky = texture(40, 44, 1, 5)[:, :, 0] // 128
    sky[20, 20] = 255
    assert set(np.unique(of(sky)).tolist()) <= {0, 4, 1023}
    np.testing.assert_array_equal(of((sky / 255).astype(np.float32)), of(sky))


def test_exemplars_share_one_range() -> None:
    low, high = (Exemplar.of(Plane(heights(a, b).astype(np.float32), Kind.DATA)) for a, b in ((0, 900), (1000, 4000)))
    one, two = features([low, high]).pictures
    assert one.min() == 0
    assert one.max() < two.min()
    assert two.max() == 1023
    np.testing.assert_array_equal(one, features([low, high, low]).pictures[2])


@pytest.mark.parametrize("value", [200.0, -5.0, 1e30, -1e30, 1e-30, 65504.0])
def test_a_plane_of_one_value_grows(value: float) -> None:
    flat = np.full((24, 24), value, np.float32)
    sampling, quilting = ia.PatchSampling(patch=8, overlap=2, bound="epsilon"), ia.ImageQuilting(patch=8, overlap=2)
    for pixels, method in ((flat, sampling), ({"albedo": texture(24, 24, 3), "height": flat}, quilting)):
        out = ia.synthesize(pixels, 30, method, run=ia.Run(1))
        assert (out.render(None if pixels is flat else "height").pixels == np.float32(value)).all()


def test_black_is_where_0_would_be() -> None:
    """What epsilon of patch sampling is relative to: the distance from black, in steps of the exemplar's range."""
    for factor in (1.0, 1e-20, 1e20):
        values = (heights(2, 4) * factor).astype(np.float32)
        (black,) = features([Exemplar.of(Plane(values, Kind.DATA))]).black
        assert black == pytest.approx(-1023, abs=2)


def test_target_pictures_of_any_range_guide_alike() -> None:
    e = Exemplar.of(texture(40, 44, 3, 1))
    method, maps = ia.ImageQuilting(patch=12, overlap=4), set()
    for factor in (1.0, 4000.0, 1e-6):
        given = (texture(n, m, 1, seed)[:, :, 0] / 255 * factor for n, m, seed in ((40, 44, 2), (50, 50, 3)))
        guide = Guide(*(Plane(heights.astype(np.float32), Kind.DATA) for heights in given))
        maps.add(ia.synthesize(e, 50, method, guide=guide, run=ia.Run(1)).map.digest)
    assert len(maps) == 1
