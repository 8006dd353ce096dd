"""Lines between courses: found where there are some, wherever they run; in grain and wood there are none."""

import numpy as np
import pytest

from intarsia.analysis.features import course_lines, features
from intarsia.analysis.oriented_energy import surest_line
from intarsia.model import Exemplar

BEDS = (20, 52, 75, 117, 140)


def wall(height=160, width=176, beds=BEDS, lean=0.0, seed=1):
    """Stones in courses of unequal heights: dark joints 3 px wide, uneven stones, grain; `lean`: px down for a px."""
    rng = np.random.default_rng(seed)
    y, x = np.indices((height, width))
    level = y - np.rint(lean * x).astype(int)
    course = np.searchsorted(beds, level, side="right")
    joint = np.isin(level, [b + k for b in beds for k in (-1, 0, 1)])
    stone = np.zeros((height, width), int)
    for c in range(len(beds) + 1):
        ends = np.cumsum(rng.integers(24, 48, 16)) - 20
        stone = np.where(course == c, np.searchsorted(ends, x), stone)
        joint |= (course == c) & np.isin(x, [e + k for e in ends for k in (-1, 0, 1)])
    tone = rng.integers(120, 200, (len(beds) + 1, 32))[course, stone]
    return np.where(joint, 40, tone + rng.integers(0, 12, joint.shape)).astype(np.uint8)


def lines_in(picture, usable=None):
    e = Exemplar.of(picture, usable=usable)
    return course_lines(features([e]), e)


def naive_surest(sure, bend):
    """The most that any path adds up to: for each place at each column the best of three before it."""
    best = sure[:, 0].tolist()
    for x in range(1, sure.shape[1]):
        near = [[best[v] - bend * (v != y) for v in (y - 1, y, y + 1) if 0 <= v < len(best)] for y in range(len(best))]
        best = [max(options) + int(sure[y, x]) for y, options in enumerate(near)]
    return max(best)


@pytest.mark.parametrize("seed", range(6))
def test_no_path_is_surer(seed):
    """What is told is what the path that is drawn adds up to, and a naive search finds no more."""
    rng = np.random.default_rng(seed)
    sure, bend = rng.integers(-20, 256, (int(rng.integers(1, 9)), int(rng.integers(1, 12)))), int(rng.integers(0, 300))
    line, total = surest_line(sure, bend)
    steps = np.abs(np.diff(line))
    assert steps.max(initial=0) <= 1
    assert total == sure[line, np.arange(len(line))].sum() - bend * steps.sum() == naive_surest(sure, bend)


def test_joints_between_courses_are_found():
    found = lines_in(wall())
    assert found.axis == 0
    assert np.abs(found.at - np.array(BEDS)[:, None]).max() <= 3
    assert found.heights == pytest.approx(np.diff(BEDS), abs=2)
    assert len(found.at) == len(BEDS)


def test_lines_turn_and_are_mirrored_with_the_picture():
    picture = wall()
    for turned, axis, back in (
        (picture[:, ::-1], 0, lambda at: at[:, ::-1]),
        (picture[::-1], 0, lambda at: (159 - at)[::-1]),
        (np.rot90(picture), 1, lambda at: at[:, ::-1]),
        (picture.T, 1, lambda at: at),
    ):
        plain, found = lines_in(picture), lines_in(np.ascontiguousarray(turned))
        assert found.axis == axis
        assert found.at.shape == plain.at.shape
        assert np.abs(back(found.at) - plain.at).max() <= 3


def test_lines_may_lean():
    found = lines_in(wall(lean=0.06))
    assert np.abs(found.at - np.array(BEDS)[:, None] - 0.06 * np.arange(176)).max() <= 3


def test_large_exemplars_are_looked_at_reduced():
    picture = wall().repeat(4, axis=0).repeat(4, axis=1)
    found = lines_in(picture)
    assert found.at.shape == (len(BEDS), picture.shape[1])
    assert np.abs(found.at - 4 * np.array(BEDS)[:, None]).max() <= 12


def test_masked_pixels_have_no_lines():
    usable = np.ones((160, 176), bool)
    usable[60:80, 70:100] = False
    found = lines_in(wall(), usable)
    assert np.abs(found.at - np.array(BEDS)[:, None]).max() <= 20
    assert lines_in(wall(), np.arange(160 * 176).reshape(160, 176) < 60 * 176) is None


def test_without_courses_there_are_none():
    rng = np.random.default_rng(1)
    y, x = np.indices((160, 160))
    grain = rng.integers(0, 256, (160, 160))
    wood = np.rint(90 * np.sin(x / 3 + rng.normal(0, 0.6, (160, 160)).cumsum(axis=0) * 0.25)) + 128
    spots = 60 + 140 * (np.hypot((y + x // 40 * 13) % 40 - 20, x % 40 - 20) < 14)
    one = (np.abs(y - 80) > 2) * 160  # one joint parts nothing
    for picture in (grain, wood, spots, one, np.full((160, 160), 90)):
        assert lines_in(picture.astype(np.uint8)) is None


def test_lines_that_end_are_none():
    picture = wall()
    picture[:, 125:] = np.random.default_rng(2).integers(120, 200, (160, 51))
    assert lines_in(picture) is None
