"""Courses of unequal heights: found by their lines, stones laid whole, no pair twice nearby, and windows are crops."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise, product

import numpy as np
import pytest
from regular import naive_wall as naive
from scipy.ndimage import label

import intarsia as ia
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.regular.course_layout import StoneChoice
from intarsia.regular.course_rows import Rows, closing
from intarsia.regular.unequal_courses import Unequal, unequal_masonry
from intarsia.regular.wall import Wall
from intarsia.testing.cases import noise, texture

HEIGHTS = (44, 28, 36, 50, 30, 40)
UNEQUAL_HEIGHTS = ia.NearRegular(course_heights="unequal")
ONE = ia.Run(threads=1)


def rubble(heights=HEIGHTS, width: int = 300, joint: int = 6, seed: int = 2):
    """A wall of courses of several heights, each stone of one colour: pixels, and stones' numbers (0: mortar)."""
    drawn = noise(len(heights), 100, seed).astype(object)
    height = sum(heights)
    numbers = np.zeros((height, width), np.int64)
    y, x = np.mgrid[:height, :width]
    top, n = 0, 1
    for row, high in enumerate(heights):
        left, k = -int(drawn[row][99] % 40), 0
        while left < width:
            long = (34, 46, 58, 70)[int(drawn[row][k] % 4)]
            inside = (x >= left + joint / 2) & (x < left + long - joint / 2)
            numbers[inside & (y >= top + joint / 2) & (y < top + high - joint / 2)] = n
            left, k, n = left + long, k + 1, n + 1
        top += high
    colours = 100 + (noise(n, 3, seed + 1) % np.uint64(140)).astype(int)
    colours[0] = 25
    grain = (noise(height, width, seed + 2) % np.uint64(9)).astype(int)[:, :, None]
    return (colours[numbers] + grain).astype(np.uint8), numbers


def found_in(pixels: np.ndarray, **more):
    return unequal_masonry(Exemplar.of(pixels, **more))


def shown_by(made: ia.Synthesis, numbers: np.ndarray) -> np.ndarray:
    return numbers[made.map.yx[:, :, 0], made.map.yx[:, :, 1]]


@pytest.mark.parametrize("joint", [4, 6, 10])
def test_courses_and_stones_are_found_as_they_are(joint: int) -> None:
    """All inner courses and their whole stones, each within 4 px; a wide bed is one, though it has two outlines."""
    pixels, numbers = rubble(joint=joint)
    found = found_in(pixels)
    inner = HEIGHTS[1:-1]
    assert (found.upright, found_in(pixels.swapaxes(0, 1).copy()).upright) == (False, True)
    assert found.sure
    for high in inner:
        assert min(abs(high - one) for one in found.heights) <= 3
    assert len(found.heights) <= len(HEIGHTS)
    for (k, a, b, _, _), own in zip(found.bricks.table, found.own, strict=True):
        middle = int(found.work.beds[k : k + 2, (a + b) // 2].mean())
        stones = set(np.unique(numbers[middle, a + joint : b - joint])) - {0}
        assert len(stones) == 1
        rows = np.argwhere(numbers == stones.pop())[:, 0]
        assert abs(own - (np.ptp(rows) + 1 + joint)) <= 4


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_stones_stay_whole_and_courses_straight(seed: int) -> None:
    """Connected faces show one stone, nearly all of it; along the beds there is mortar."""
    pixels, numbers = rubble()
    made = ia.synthesize(pixels, (300, 420), UNEQUAL_HEIGHTS, seed=seed, run=ONE)
    shown, area = shown_by(made, numbers), np.bincount(numbers.ravel())
    parts, n = label(shown > 0)
    border = set(np.concatenate([parts[0], parts[-1], parts[:, 0], parts[:, -1]]))
    pure = cut = 0
    for k in set(range(1, n + 1)) - border:
        counts = np.bincount(shown[parts == k])
        pure += counts.sum() - counts.max() <= 0.05 * counts.sum()
        cut += counts.max() < 0.8 * area[counts.argmax()]
    inner = n - len(border - {0})
    assert pure >= 0.95 * inner
    assert cut <= 0.05 * inner
    wall = Wall.of(None, None, Exemplar.of(pixels), Canvas(300, 420), seed)
    for i in range(wall.rows.course_at(6, 0) + 1, wall.rows.course_at(293, 0)):
        bed = wall.rows.row(2 * i, 0)
        assert (shown[bed - 3 : bed + 3] == 0).any(axis=0).mean() > 0.95


def test_stones_lie_in_courses_about_as_high_as_they_are() -> None:
    """Of those that are near enough; an oracle counts them one by one."""
    pixels, _ = rubble()
    wall = Wall.of(None, None, Exemplar.of(pixels), Canvas(10, 10), 1)
    found = found_in(pixels)
    for height, cards in zip(found.heights, wall.layout.cards, strict=True):
        assert cards == naive.stones_about(found.own.tolist(), height, StoneChoice, Unequal.like)
    for i in range(-8, 9):
        height = found.heights[wall.rows.kind(i)]
        for piece in wall.layout.pieces(i, 0, 700):
            assert abs(found.own[piece.brick] - height) <= Unequal.like * height


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(("heights", "width", "most"), [(HEIGHTS, 300, 2), ((40, 41, 39, 40, 42), 160, 12)])
def test_no_pair_returns_in_its_course_or_the_next_two(
    heights: tuple[int, ...], width: int, most: int, seed: int
) -> None:
    """Of about 95 pairs of 25 stones two at most, of 90 of eight 12; laid without that rule 4 to 8, and 24 to 36."""
    wall = Wall.of(None, None, Exemplar.of(rubble(heights, width)[0]), Canvas(10, 10), seed)
    chains = [wall.layout.pieces(i, 0, 420) for i in range(12)]
    pairs = [Counter((a.brick, b.brick) for a, b in pairwise(chain)) for chain in chains]
    again = sum(n - 1 for own in pairs for n in own.values())
    near = sum((pairs[i] & pairs[i + d]).total() for i in range(10) for d in (1, 2))
    assert again + near <= most
    assert sum(own.total() for own in pairs) > 80
    for chain in chains:
        assert all(a.brick != b.brick for a, b in pairwise(chain))


@pytest.mark.parametrize("height", [97, 130, 211, 299])
def test_heights_close_as_nearly_as_any_sum(height: int) -> None:
    """Once each but for the last two rounds; then by trying all, each up to three times."""
    heights = (23, 31, 47)
    order = closing(heights, height, 3)
    rounds = max(0, height // sum(heights) - 1)
    assert all(order.count(k) >= rounds for k in range(3))
    sums = (sum(n * high for n, high in zip(some, heights, strict=True)) for some in product(range(4), repeat=3))
    rest = height - rounds * sum(heights)
    assert abs(sum(heights[k] for k in order) - height) == min(abs(one - rest) for one in sums)


@pytest.mark.parametrize("wrap", [ia.Wrap.NONE, ia.Wrap.Y])
def test_courses_lie_where_their_heights_add_up_to(wrap: ia.Wrap) -> None:
    """Row by row, the course that covers a row is the one between its beds; each is as often laid as others."""
    heights = (23, 31, 47, 28)
    rows = Rows.stacked(heights, Canvas(258, 100, wrap), False, 7)
    high, of = rows.pitch
    tops = [rows.row(2 * i, 0) for i in range(-30, 31)]
    for i, (a, b) in enumerate(pairwise(tops)):
        own = heights[rows.kind(i - 30)]
        assert abs((b - a) - own * high / of) <= 1
        assert all(rows.course_at(y, 5) == i - 30 for y in range(a, b))
    if wrap is ia.Wrap.NONE:
        kinds = [rows.kind(i) for i in range(-12, 12)]
        assert Counter(kinds) == Counter(dict.fromkeys(range(4), 6))
    else:
        assert tops[30 + rows.around] - tops[30] == 258


UPRIGHT = rubble()[0].swapaxes(0, 1).copy()
CASES = [rubble()[0], UPRIGHT, rubble(seed=4, joint=4)[0]]


@pytest.mark.parametrize(("case", "along"), [(0, 290), (1, 700), (2, 37)])
def test_a_wrapped_canvas_continues_in_itself(case: int, along: int) -> None:
    """The window one canvas further on shows the same."""
    height, width = (along, 260) if case == 1 else (260, along)
    wall = Wall.of(None, None, Exemplar.of(CASES[case]), Canvas(height, width, ia.Wrap.BOTH), 3)
    here = wall.window(0, 0, height, width)
    np.testing.assert_array_equal(wall.window(height, -width, height, width), here)
    np.testing.assert_array_equal(wall.window(-100, 200, height, width), np.roll(here, (100, -200), (0, 1)))


def test_threads_change_nothing_and_seeds_much() -> None:
    digests = {ia.synthesize(CASES[0], 300, UNEQUAL_HEIGHTS, seed=9, run=ia.Run(n)).map.digest for n in (1, 3)}
    assert len(digests) == 1
    other = ia.synthesize(CASES[0], 300, UNEQUAL_HEIGHTS, seed=10, run=ONE)
    assert other.map.digest not in digests


def test_masked_pixels_are_never_shown() -> None:
    usable = np.ones(CASES[0].shape[:2], bool)
    usable[40:75, 100:160] = False
    made = ia.synthesize(Exemplar.of(CASES[0], usable=usable), 260, UNEQUAL_HEIGHTS, seed=1, run=ONE)
    assert usable[made.map.yx[:, :, 0], made.map.yx[:, :, 1]].all()


def test_a_canvas_that_no_sum_of_heights_closes_is_refused() -> None:
    with pytest.raises(ia.ParameterError, match=r"^wrap: height=16 px is no sum of heights of courses \(.*\); choose"):
        ia.synthesize(CASES[0], (16, 200), UNEQUAL_HEIGHTS, wrap="y")
    with pytest.raises(ia.ParameterError, match=r"^wrap: width=16 px is no sum"):
        ia.synthesize(UPRIGHT, (200, 16), UNEQUAL_HEIGHTS, wrap="x")


def test_what_has_no_place_is_refused() -> None:
    for given in ({"straighten": "on"}, {"lattice": ((0, 40),)}):
        with pytest.raises(ia.ParameterError, match=rf"^course_heights=unequal .* leave {next(iter(given))} out\.$"):
            ia.synthesize(CASES[0], 200, ia.NearRegular(course_heights="unequal", **given))
    with pytest.raises(ia.MethodError, match="no lines run across"):
        ia.synthesize(texture(60, 60), 100, UNEQUAL_HEIGHTS)


def test_what_is_decided_is_decided_again() -> None:
    """The method that a recipe holds makes the same picture; its lattice is the mean pitch."""
    made = ia.synthesize(CASES[0], 200, UNEQUAL_HEIGHTS, seed=2, run=ONE)
    assert made.method.lattice == (found_in(CASES[0]).pitch,)
    assert made.method.resolved(made.exemplars, Canvas(200, 200)) == made.method
    again = ia.synthesize(CASES[0], 200, made.method, seed=2, run=ONE)
    assert again.map.digest == made.map.digest


class TestChoice:
    """Who is led here."""

    def test_walls_of_several_heights_are(self) -> None:
        made = ia.synthesize(CASES[0], 200, seed=1, run=ONE)
        found = made.choice.rule, made.method.slug, made.method.course_heights
        assert found == ("courses", "near-regular", "unequal")
        assert any("laid whole" in why for why in made.choice.why)
        assert "course_heights" in made.choice.decided

    def test_a_canvas_that_cannot_close_is_grown_by_patches(self) -> None:
        made = ia.synthesize(CASES[0], (16, 200), seed=1, wrap="y", run=ONE)
        assert made.method.slug != "near-regular"

    def test_few_stones_and_joints_that_hardly_show_are_not(self) -> None:
        found = found_in(rubble(heights=(40, 52, 36, 44), width=110)[0])
        assert len(found.own) < Unequal.enough
        assert not found.sure
        found = found_in(CASES[0])
        assert not found._replace(faces=Unequal.joints + 1).sure
        assert not found._replace(own=found.own // 3).sure
