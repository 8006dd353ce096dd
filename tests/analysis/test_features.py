"""Features: what is compared does not depend on depth, on what is hidden, or on the machine."""

from __future__ import annotations

import numpy as np
import pytest
from naive import lay_down

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.model import Exemplar
from intarsia.model.image import Kind, Plane, Transfer
from intarsia.testing import as_depth, texture


def of(pixels, **more) -> np.ndarray:
    return features([Exemplar.of(pixels, **more)]).pictures[0]


@pytest.mark.parametrize("channels", [1, 2, 3, 4, 5])
def test_depth_changes_no_feature(channels: int) -> None:
    """Law 13: 8 bits, times 257 in 16 bits, over 255 in single and double floats."""
    pixels = texture(20, 24, channels, 3)
    first = of(pixels)
    assert first.dtype == np.int16
    for dtype in ("uint16", "float32", "float64"):
        np.testing.assert_array_equal(of(as_depth(pixels, dtype)), first)


def test_sixteen_bits_are_seen() -> None:
    """Torture 26: a texture of one 16-bit step is stretched to the whole range."""
    pixels = (20000 + np.arange(16).reshape(4, 4) % 2).astype(np.uint16)
    assert set(np.unique(of(pixels)).tolist()) == {0, 1023}


def test_a_uniform_exemplar_has_no_features() -> None:
    for value in (0, 7, 255):
        assert not of(np.full((5, 6, 3), value, np.uint8)).any()


@pytest.mark.parametrize("dtype", ["uint8", "float32"])
def test_what_is_masked_is_not_seen(dtype: str) -> None:
    """Whatever lies under the mask, NaN too, neither stretches the range nor shows."""
    usable = np.ones((12, 12), bool)
    usable[2:5, 3:9] = False
    pixels = as_depth(texture(12, 12, 3, 2) // 2 + np.uint8(20), dtype)
    hidden = pixels.copy()
    hidden[~usable] = 255 if dtype == "uint8" else np.nan
    np.testing.assert_array_equal(of(pixels, usable=usable), of(hidden, usable=usable))


def test_colour_under_no_opacity_is_not_seen() -> None:
    pixels = texture(12, 12, 4, 2)
    pixels[:, :, 3] = np.where(np.arange(12) < 6, 0, 255)
    garbage = pixels.copy()
    garbage[:, :6, :3] = texture(12, 6, 3, 9)
    np.testing.assert_array_equal(of(pixels), of(garbage))


def test_labels_are_names_and_not_numbers() -> None:
    """Every name has its own channel; renaming by another order permutes channels only."""
    names = (texture(12, 12, 1, 4)[:, :, 0] // 64).astype(np.uint8)
    renamed = np.array([9, 200, 3, 77], np.uint8)[names]
    one, two = (of(Plane(p, Kind.LABEL)) for p in (names, renamed))
    assert one.shape == two.shape == (12, 12, 4)
    assert sorted(one.sum(axis=(0, 1)).tolist()) == sorted(two.sum(axis=(0, 1)).tolist())
    y, x = np.nonzero(names == names[0, 0])
    assert (one[y, x] == one[0, 0]).all()


def test_further_planes_count_at_most_half() -> None:
    """A height map joins in; its variance is limited to half of the colour's."""
    albedo, height = texture(20, 20, 3, 1), (texture(20, 20, 1, 2)[:, :, 0]).astype(np.uint16) * 257
    both = of({"albedo": albedo, "height": height}).astype(float)
    assert both.shape == (20, 20, 4)
    np.testing.assert_array_equal(both[:, :, :3], of(albedo))
    share = both[:, :, 3].var() / both[:, :, :3].var(axis=(0, 1)).sum()
    assert 0.3 < share <= 0.51


def test_planes_of_other_sizes_are_brought_to_the_base() -> None:
    albedo = texture(12, 16, 3, 1)
    half = texture(6, 8, 1, 2)[:, :, 0]
    double = np.repeat(np.repeat(texture(12, 16, 1, 3)[:, :, 0], 2, 0), 2, 1)
    picture = of({"albedo": albedo, "height": half, "roughness": double})
    assert picture.shape == (12, 16, 5)
    np.testing.assert_array_equal(picture[::2, ::2, 3], picture[1::2, 1::2, 3])
    np.testing.assert_array_equal(picture[:, :, 4], of({"albedo": albedo, "roughness": double[::2, ::2]})[:, :, 3])


@pytest.mark.parametrize("pose", range(8))
def test_colours_are_laid_down_as_they_are(pose: int) -> None:
    feats = features([Exemplar.of(texture(9, 13, 3, 1))])
    np.testing.assert_array_equal(feats.posed(0, pose), lay_down(feats.pictures[0], pose))


@pytest.mark.parametrize("pose", range(8))
def test_normals_turn_with_their_piece(pose: int) -> None:
    """A bump looks the same in every pose: the features of its turned map are its turned features."""
    y, x = np.mgrid[-8:9, -8:9] / 12.0
    vectors = np.dstack([x, -y, np.sqrt(np.maximum(1 - x**2 - y**2, 0.1))])  # a ball: x to the right, y up
    codes = np.rint(127.5 + 127.5 * vectors / np.linalg.norm(vectors, axis=2, keepdims=True)).astype(np.uint8)
    feats = features([Exemplar.of({"normal": codes})])
    plain, posed = feats.posed(0, 0).astype(int), feats.posed(0, pose).astype(int)
    assert feats.normals == (0,)
    assert np.abs(plain - posed).max() <= 4 * 1023 / 255


def test_exemplars_of_another_make_up_are_refused() -> None:
    rgb, gray = Exemplar.of(texture(10, 10, 3)), Exemplar.of(texture(10, 10, 1))
    with pytest.raises(ia.InputError, match="differ in planes, channels, kind or weights"):
        features([rgb, gray])
    with pytest.raises(ia.InputError, match="differ in planes"):
        features([rgb, Exemplar.of({"albedo": texture(10, 10, 3), "height": texture(10, 10, 1)[:, :, 0]})])


def test_light_without_bounds_is_compared_on_a_curve() -> None:
    """Scene-linear floats beyond white stay ordered, and one lamp does not flatten all else."""
    light = np.array([[0.0, 0.1, 0.5, 1.0, 4.0, 1000.0]], np.float32)
    picture = of(Plane(light, Kind.COLOUR, Transfer.LINEAR))[0, :, 0]
    assert (np.diff(picture) > 0).all()
    assert picture[3] - picture[0] > 50


def test_features_are_made_once() -> None:
    e = Exemplar.of(texture(10, 10, 3))
    assert features([e]) is features([e])
    assert features([e]) is not features([e], (1, 1, 1))
