"""Element size: known sizes are found, odd exemplars have an answer, photographs agree with the eye."""

from pathlib import Path

import numpy as np
import pytest
from torture import TORTURE

from intarsia.analysis.elements import ElementSize, element_size
from intarsia.analysis.features import features
from intarsia.model import Exemplar

SEEN = {  # size, px: FINDINGS-elements, section 1; potato-rows whole, the others their upper left 256 px
    "near-regular_cobble-moss_320": 102,
    "near-regular_tile-floor-broken_320": 102,
    "near-regular_stone-blocks_416": 86,
    "irregular_drystone-wall_384": 92,
    "irregular_flagstone_320": 62,
    "irregular_red-peppers_256": 56,
    "near-regular_potato-rows_448": 174,
    "irregular_pebbles_256": 46,
    "irregular_autumn-leaves_256": 96,
    "near-stochastic_rust-paint_256": 95,
    "near-stochastic_water-caustics_300": 93,
    "near-stochastic_wood-knots_256": 59,
}


def measure(picture, usable=None):
    return element_size(features([Exemplar.of(picture)]).pictures[0], usable)


def waves(height, width, py, px):
    y, x = np.mgrid[:height, :width]
    value = 127 + 60 * np.cos(2 * np.pi * y / py) + 60 * np.cos(2 * np.pi * x / px)
    return np.repeat(value.astype(np.uint8)[..., None], 3, axis=2)


def test_dips_along_the_axes_are_half_a_period():
    stripes = np.repeat((127 + 100 * np.cos(np.arange(200) * 2 * np.pi / 20)).astype(np.uint8)[None], 200, axis=0)
    found = measure(stripes)
    assert found.directions[0] == 10
    assert found.directions[6] == 0  # along the stripes nothing changes
    assert found.width in (20, 21)
    assert 60 <= found.height <= 80  # 2 x 39 beside the axis, half the side on it, cut to 0.4 of the side
    assert 0 < found.found < 12


def test_balls_have_about_their_own_size():
    assert 12 <= measure(TORTURE["normals"]()).size <= 32
    assert 12 <= measure(TORTURE["grapes"]()).size <= 36
    assert 12 <= measure(TORTURE["pebbles_black"]()).size <= 28


@pytest.mark.parametrize(
    ("shape", "size"), [((1, 1), 1), ((1, 300), 1), ((5, 40), 1), ((7, 7), 1), ((64, 64), 16), ((96, 200), 24)]
)
def test_constant_and_tiny_exemplars_answer_a_quarter_of_the_side(shape, size):
    for value in (0, 700, -1023):
        constant = np.full((*shape, 3), value, np.int16)
        assert element_size(constant) == ElementSize(size, size, size, (0,) * 12, 0)
    noise = np.random.default_rng(1).integers(0, 1023, (*shape, 3)).astype(np.int16)
    one = np.zeros((*shape, 1), np.int16)
    one[shape[0] // 3, shape[1] // 2] = 1
    for picture in (noise, one):
        assert 1 <= element_size(picture).size <= max(1, 0.4 * min(shape))


@pytest.mark.parametrize("name", TORTURE)
def test_every_exemplar_has_an_answer(name):
    picture = TORTURE[name]()
    found = measure(picture)
    limit = max(1, 0.4 * min(picture.shape[:2]))
    assert all(1 <= n <= limit for n in (found.size, found.height, found.width))
    assert len(found.directions) == 12
    assert found.found == sum(lag > 0 for lag in found.directions)
    assert all(isinstance(n, int) for n in (found.size, found.height, found.width, *found.directions))


@pytest.mark.parametrize(("shape", "reduction"), [((513, 600), 2), ((1100, 1100), 3), ((40, 3000), 1), ((8, 9000), 1)])
def test_large_exemplars_are_reduced_and_scaled_back(shape, reduction):
    picture = waves(*shape, 60, 60)
    found = measure(picture)
    assert found.reduction == reduction
    assert all(lag % reduction == 0 for lag in found.directions)
    if min(shape) > 500:
        assert abs(found.directions[0] - 30) <= reduction
        assert abs(found.directions[6] - 30) <= reduction
        assert 50 <= found.size <= 90


def test_a_mask_hides_pixels():
    picture, usable = waves(200, 200, 30, 30).astype(np.int16) * 4, np.ones((200, 200), bool)
    assert element_size(picture, usable) == element_size(picture)
    usable[60:110, 40:120] = False
    found = [element_size(np.where(usable[..., None], picture, hidden), usable) for hidden in (1020, -7)]
    assert found[0] == found[1]
    assert abs(found[0].size - element_size(picture).size) <= 4


def test_a_mask_that_leaves_one_corner_counts_as_that_corner():
    picture = (waves(200, 200, 30, 30).astype(np.int16)) * 4
    usable = np.zeros((200, 200), bool)
    usable[10:90, 20:110] = True
    assert element_size(picture, usable) == element_size(picture[10:90, 20:110])


@pytest.mark.parametrize("side", [64, 1200])
def test_a_mask_of_next_to_nothing(side):
    picture = np.random.default_rng(0).integers(0, 1023, (side, side, 3)).astype(np.int16)
    usable = np.zeros((side, side), bool)
    assert element_size(picture, usable).size == 1
    usable[3, 4] = usable[side - 5, side - 9] = usable[side // 2, 7] = True
    assert 1 <= element_size(picture, usable).size <= 0.4 * side


def test_the_weights_of_the_channels_do_not_matter():
    picture = TORTURE["pebbles_black"]().astype(np.int16)
    wanted = element_size(picture * 8)
    weighted = picture * np.array([4, 8, 2], np.int16)
    assert abs(element_size(weighted).size - wanted.size) <= 2


def test_photographs_agree_with_the_eye(textures: dict[str, Path]):
    from PIL import Image

    off = {}
    for name, wanted in SEEN.items():
        with Image.open(textures[name]) as file:
            picture = np.array(file.convert("RGB"))
        size = measure(picture if "potato" in name else picture[:256, :256]).size
        if abs(size - wanted) > 0.25 * wanted:
            off[name] = (size, wanted)
    assert len(off) <= 2, off
