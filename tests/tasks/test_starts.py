"""Start maps, and where windows lie around them: outward from what is known, nothing forgotten, nothing thin."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

import intarsia as ia
from intarsia.foundation.geometry import Wrap
from intarsia.patches import batch_numbers, fill_order, neighbour_query, window_batches
from intarsia.search import WindowGrid
from intarsia.tasks.completion import Margins, dilated_hole, extension, scene_to_heal
from intarsia.testing.cases import noise, texture

WRAPS = [(False, False), (True, False), (False, True), (True, True)]
Mask = NDArray[np.bool_]


def window(y: int, x: int, patch: tuple[int, int], size: tuple[int, ...]) -> tuple[NDArray[np.int64], ...]:
    return np.ix_((np.arange(patch[0]) + y) % size[0], (np.arange(patch[1]) + x) % size[1])


def holes_of(height: int, width: int) -> dict[str, Mask]:
    y, x = np.mgrid[:height, :width]
    return {
        "left": x < width // 3,
        "frame": (np.minimum(y, height - 1 - y) < 9) | (np.minimum(x, width - 1 - x) < 13),
        "corner": (y < 20) & (x > width - 17),
        "disc": (y - height // 2) ** 2 + (x - width // 3) ** 2 < 300,
        "ring": abs((y - height // 2) ** 2 + (x - width // 2) ** 2 - 400) < 100,
        "two": ((abs(y - 12) < 5) & (abs(x - 14) < 6)) | ((abs(y - 40) < 9) & (abs(x - 50) < 3)),
        "scattered": noise(height, width, 3) % np.uint64(23) == 0,
        "all but one": (y != 7) | (x != 9),
        "across the border": (np.minimum(x, width - 1 - x) < 4) & (y > 10),
    }


HOLES = holes_of(60, 70)


@pytest.mark.parametrize("wraps", WRAPS)
@pytest.mark.parametrize("kind", HOLES)
@pytest.mark.parametrize(("patch", "overlap"), [((16, 16), (5, 5)), ((9, 14), (0, 6)), ((60, 70), (20, 20))])
def test_windows_fill_everything_outward(
    kind: str, wraps: tuple[bool, bool], patch: tuple[int, int], overlap: tuple[int, int]
) -> None:
    known = ~HOLES[kind]
    found = fill_order(known, patch, overlap, wraps)
    now = known.copy()
    for y, x in found:
        if not wraps[0]:
            assert 0 <= y <= 60 - patch[0]
        if not wraps[1]:
            assert 0 <= x <= 70 - patch[1]
        index = window(y, x, patch, now.shape)
        assert not now[index].all(), "a window that has nothing to fill"
        assert now[index].any() or overlap == (0, 6), "a window far from all that is known"
        now[index] = True
    assert now.all()
    assert found == fill_order(known.copy(), patch, overlap, wraps)


@pytest.mark.parametrize("wraps", WRAPS)
@pytest.mark.parametrize("kind", HOLES)
def test_waves_hold_no_windows_that_touch_and_keep_the_order(kind: str, wraps: tuple[bool, bool]) -> None:
    patch, size = (12, 15), (60, 70)
    found = tuple(fill_order(~HOLES[kind], patch, (4, 5), wraps))
    layout = WindowGrid((), (), patch, size, wraps, found)
    wave_of = {}
    for number, wave in enumerate(window_batches(layout, np.ones(layout.shape, bool))):
        for row, column in wave:
            wave_of[row] = number
            assert column == 0
            assert layout.at(row, column) == found[row]
    assert sorted(wave_of) == list(range(len(found)))

    def gap(axis: int, a: int, b: int) -> int:
        d = abs(a - b)
        return min(d, size[axis] - d) if wraps[axis] else d

    for a, b in itertools.combinations(range(len(found)), 2):
        if all(gap(axis, found[a][axis], found[b][axis]) <= patch[axis] for axis in (0, 1)):
            assert wave_of[a] < wave_of[b]
    assert [wave_of[k] for k in range(len(found))] == batch_numbers(neighbour_query(found, patch, size, wraps)(found))


@pytest.mark.parametrize("side", range(4))
def test_all_sides_are_treated_alike(side: int) -> None:
    """Extending to the left is extending to the right of the mirrored picture."""
    turned = np.rot90(np.pad(np.ones((48, 48), bool), ((0, 0), (0, 31))), side)
    found = fill_order(turned, (18, 18), (6, 6), (False, False))
    counts = []
    now = turned.copy()
    for y, x in found:
        index = window(y, x, (18, 18), now.shape)
        counts.append(int(now[index].sum()))
        now[index] = True
    first = counts[0]
    assert first >= 6 * 18, "the first window shares a whole seam with what is known"
    assert min(counts) >= 6 * 18


def test_a_small_hole_lies_in_the_middle_of_one_window() -> None:
    known = np.ones((64, 64), bool)
    known[20:28, 30:38] = False
    assert fill_order(known, (24, 24), (8, 8), (False, False)) == [(12, 22)]
    known[:] = True
    known[:4, 60:] = False
    assert fill_order(known, (24, 24), (8, 8), (False, False)) == [(0, 40)]
    assert fill_order(known, (24, 24), (8, 8), (True, True)) == [(54, 50)]


def test_a_hole_grows_on_all_sides_and_around_the_border() -> None:
    hole = np.zeros((9, 9), bool)
    hole[0, 4] = True
    assert np.argwhere(dilated_hole(hole, 1)).tolist() == [[0, 3], [0, 4], [0, 5], [1, 3], [1, 4], [1, 5]]
    assert int(dilated_hole(hole, 1, Wrap.Y).sum()) == 9
    assert (dilated_hole(hole, 0) == hole).all()


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda e: Margins(left=-1), ia.ParameterError, "left=-1 is not allowed"),
        (lambda e: Margins(), ia.ParameterError, "no side is extended"),
        (lambda e: extension(e, Margins(right=1 << 30)), ia.ParameterError, "size="),
        (lambda e: dilated_hole(np.ones((3, 3)), -1), ia.ParameterError, "grow=-1 is not allowed"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(make: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error) as caught:
        make(ia.Exemplar.of(texture(20, 30, 3)))  # type: ignore[operator]
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


def test_nothing_usable_is_refused() -> None:
    usable = np.zeros((20, 30), bool)
    usable[:10] = True
    with pytest.raises(ia.InputError, match="nothing of exemplar may be used"):
        scene_to_heal(ia.Exemplar.of(texture(20, 30, 3), usable=usable), usable)
