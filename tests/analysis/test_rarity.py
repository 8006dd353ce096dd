"""Rarity: what stands out is found, what is common or cannot be judged is 256, sums are exact."""

import math

import numpy as np
import pytest
from torture import TORTURE

from intarsia.analysis.features import features
from intarsia.analysis.saliency import MEDIAN, MOST_RARE, neighbour_distance, rarity
from intarsia.model import Exemplar


def of(name):
    return features([Exemplar.of(TORTURE[name]())]).pictures[0]


def over(grid, step, patch, y, x):
    """Rarity of all patches that contain the px (y, x)."""
    rows, columns = (np.arange(n) * step for n in grid.shape)
    inside = np.ix_((rows <= y) & (y < rows + patch), (columns <= x) & (x < columns + patch))
    return grid[inside]


def test_a_red_cluster_is_striking():
    for patch in (16, 24, 32):
        grid, step = rarity(of("red_cluster"), patch)
        assert np.median(grid) == MEDIAN
        assert np.median(over(grid, step, patch, 85, 85)) >= 2 * MEDIAN
        far = grid[: 40 // step, : 40 // step]
        assert far.max() < 2 * MEDIAN


def test_a_thing_beside_its_exact_copy_stays_striking():
    """One copy is no company: a repeat that stands in the exemplar already makes neither of the two common."""
    picture = np.random.default_rng(3).integers(0, 60, (128, 128, 3)).astype(np.int16)
    picture[20:30, 20:30] = (1000, 0, 0)
    picture[72:112, 80:120] = picture[4:44, 4:44]
    grid, step = rarity(picture, 24)
    assert 72 % step == 80 % step == 4 % step == 0
    for y, x in ((12, 12), (80, 88)):
        assert grid[y // step, x // step] >= 2 * MEDIAN


@pytest.mark.parametrize("shape", [(1, 1), (1, 90), (90, 1), (8, 8), (30, 40), (200, 150), (600, 700)])
def test_a_uniform_exemplar_is_common_everywhere(shape):
    grid, step = rarity(np.full((*shape, 3), 512, np.int16), 16)
    assert grid.dtype == np.int32
    assert (grid == MEDIAN).all()
    assert step >= 1


def test_differences_that_nobody_sees_do_not_count():
    faint = np.full((128, 128, 3), 512, np.int16)
    faint += np.random.default_rng(0).integers(0, 2, faint.shape).astype(np.int16)
    assert (rarity(faint, 32)[0] == MEDIAN).all()


@pytest.mark.parametrize("name", TORTURE)
@pytest.mark.parametrize("patch", [1, 3, 16, 70, 500])
def test_every_exemplar_has_an_answer(name, patch):
    picture = of(name)
    before = picture.copy()
    grid, step = rarity(picture, patch)
    used = min(patch, *picture.shape[:2])
    assert grid.shape == tuple(-(-(n - used + 1) // step) for n in picture.shape[:2])
    assert grid.min() >= 0
    assert grid.max() <= MOST_RARE
    assert np.array_equal(grid, rarity(picture, patch)[0])
    assert np.array_equal(picture, before)


@pytest.mark.parametrize(
    ("height", "width", "patch"), [(256, 256, 48), (300, 90, 20), (2048, 2048, 96), (700, 2000, 31)]
)
def test_the_grid_has_some_hundred_patches_inside_the_exemplar(height, width, patch):
    picture = np.random.default_rng(0).integers(0, 1023, (height, width, 1)).astype(np.int16)
    grid, step = rarity(picture, patch)
    assert 600 <= grid.size <= 1000
    assert (grid.shape[0] - 1) * step + patch <= height
    assert (grid.shape[1] - 1) * step + patch <= width


def test_few_patches_are_common():
    picture = np.random.default_rng(0).integers(0, 1023, (64, 64, 3)).astype(np.int16)
    assert (rarity(picture, 62)[0] == MEDIAN).all()
    assert rarity(picture, 62)[0].shape == (3, 3)
    assert (rarity(picture, 60)[0] == MEDIAN).all()  # 25 patches, all of which overlap


def test_distances_are_exact_at_the_extremes():
    rng = np.random.default_rng(5)
    looks = rng.integers(-16 * 32768, 16 * 32767, (40, 16 * 64))
    looks[0], looks[1] = 16 * 32767, -16 * 32768
    far = neighbour_distance(looks, np.argwhere(np.ones((40, 1))), np.arange(40), 1, (0, 0), 38)
    plain = ((looks[:, None] - looks[None]) ** 2).sum(axis=2).max(axis=1)
    assert far.tolist() == [math.isqrt(int(n)) for n in plain]


def test_one_plain_way_to_the_same_numbers():
    """The whole rule, written out for one channel and whole cells."""
    picture = np.random.default_rng(9).integers(0, 1023, (28, 30, 1)).astype(np.int16)
    patch = 12
    corners = [(y, x) for y in range(28 - patch + 1) for x in range(30 - patch + 1)]
    looks = []
    for y, x in corners:
        cells = picture[y : y + patch, x : x + patch, 0].astype(int).reshape(4, 3, 4, 3).sum(axis=(1, 3))
        looks.append(16 * cells.ravel() // 9)
    near = []
    for (y, x), a in zip(corners, looks, strict=True):
        others = [
            int(((a - b) ** 2).sum())
            for (v, u), b in zip(corners, looks, strict=True)
            if max(abs(y - v), abs(x - u)) >= patch / 2
        ]
        near.append(int(sorted(others)[2] ** 0.5))
    usual = sorted(near)[len(near) // 2]
    wanted = [min((256 * n + usual // 2) // usual, 1024) for n in near]
    assert rarity(picture, patch)[0].ravel().tolist() == wanted
