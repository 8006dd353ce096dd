"""Outlines: joints are found, grain has none, and turning or mirroring a picture turns what is found."""

import numpy as np
import pytest

from intarsia.analysis.oriented_energy import REACH, SLANTED, STRAIGHT, _nearest, outline_distance, outlines_of
from intarsia.analysis.features import OUTLINES, RANGE, features, variance_of
from intarsia.model import Exemplar


def bricks(height=96, width=120):
    """A wall with dark joints every 24 px, in whole numbers 0 to 1000."""
    y, x = np.indices((height, width))
    joint = (y % 24 < 3) | ((x + 20 * (y // 24 % 2)) % 40 < 3)
    grain = np.random.default_rng(1).integers(0, 60, (height, width))
    return np.where(joint, 100, 800 + grain).astype(np.int16)[..., None]


def distance(picture, usable=None, toroidal=False):
    return outline_distance(outlines_of(picture, usable, toroidal), picture.shape, toroidal)


def naive_nearest(far, steps, toroidal):
    """What every pixel costs if a king walks: 5 for a straight step, 7 for a slanted one, never more than `steps`."""
    far = far.astype(np.int64)
    height, width = far.shape
    for _ in range(steps):
        out = far.copy()
        for y in range(height):
            for x in range(width):
                for dy in (-1, 0, 1):
                    for dx in (-1, 0, 1):
                        v, u = y + dy, x + dx
                        if toroidal:
                            v, u = v % height, u % width
                        if (dy or dx) and 0 <= v < height and 0 <= u < width:
                            out[y, x] = min(out[y, x], far[v, u] + (SLANTED if dy and dx else STRAIGHT))
        far = out
    return far


@pytest.mark.parametrize("toroidal", [False, True])
def test_distances_are_those_of_a_naive_walk(toroidal):
    far = np.random.default_rng(2).integers(0, 90, (9, 11))
    assert np.array_equal(_nearest(far, 5, toroidal), naive_nearest(far, 5, toroidal))


def test_joints_are_near_and_the_middles_of_bricks_far():
    far = distance(bricks())
    reach = round(REACH * 96)
    assert far.dtype == np.int32
    assert far.shape == (96, 120)
    assert far.min() == 0
    assert far.max() <= STRAIGHT * reach
    assert far[25, 20:100].mean() < STRAIGHT * reach / 4
    assert far[36, [10, 50, 90]].mean() > 2 * far[25, 20:100].mean()


def test_strength_is_the_most_less_the_mean_of_directions():
    """Noise answers to all directions alike, a line to one: the share that exceeds the mean is far more."""
    line = np.full((96, 96, 1), 500, np.int16)
    line[:, 46:49] = 100
    noise = np.random.default_rng(3).integers(0, 1000, (96, 96, 1)).astype(np.int16)
    assert outlines_of(line, None, False).share > 2 * outlines_of(noise, None, False).share
    assert outlines_of(np.full((40, 50, 1), 700, np.int16), None, False).share == 0


@pytest.mark.parametrize("turned", [lambda a: a[::-1], lambda a: a[:, ::-1], lambda a: np.swapaxes(a, 0, 1)])
def test_it_turns_with_the_picture(turned):
    picture = bricks(96, 96)
    far = distance(picture)
    assert np.abs(turned(far) - distance(np.ascontiguousarray(turned(picture)))).max() <= 1


def test_a_torus_knows_no_border():
    picture = bricks(96, 80)
    far = distance(picture, None, True)
    assert np.array_equal(np.roll(far, (13, 29), (0, 1)), distance(np.roll(picture, (13, 29), (0, 1)), None, True))


def test_the_edge_of_a_mask_is_no_outline():
    picture = np.full((96, 96, 1), 800, np.int16)
    usable = np.ones((96, 96), bool)
    usable[40:60, 40:60] = False
    picture[~usable] = 0
    far = distance(picture, usable)
    assert far[20:30, 20:30].min() > 0
    assert outlines_of(picture, None, False).excess[40, 50] > 0  # without the mask there is one


def test_large_exemplars_are_looked_at_reduced():
    picture = np.kron(bricks(160, 160), np.ones((4, 4, 1), np.int16))
    far = distance(picture)
    assert far.shape == (640, 640)
    assert far.max() <= 4 * STRAIGHT * round(REACH * 160)


def test_structure_appends_outlines_and_slow_colour_by_their_weights():
    exemplar = Exemplar.of(np.repeat((bricks() // 4).astype(np.uint8), 3, axis=2))
    plain, more = features([exemplar]), features([exemplar], structure=1.0)
    assert more.pictures[0].shape[2] == 7
    assert np.array_equal(more.pictures[0][..., :3], plain.pictures[0])
    colour, line = (variance_of([p[..., part].astype(np.int32)], [exemplar])
                    for p, part in ((plain.pictures[0], slice(3)), (more.pictures[0], slice(3, 4))))  # fmt: skip
    assert line == pytest.approx(OUTLINES**2 * colour, rel=0.02)
    slow = more.pictures[0][..., 4:].astype(int)
    assert 0 < np.abs(np.diff(slow, axis=0)).max() < RANGE // 8
    assert more.base == plain.base == 3
    assert len(more.black) == 7
    assert features([exemplar], structure=0.0) is plain
    half = features([exemplar], structure=0.5).pictures[0]
    assert np.abs(2 * half[..., 3:].astype(int) - more.pictures[0][..., 3:]).max() <= 2


