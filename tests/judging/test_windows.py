"""Windows against plain loops: the same numbers, the nearest of all, and no pixel in them that may not be used."""

from __future__ import annotations

import numpy as np
import pytest
from judging.naive_windows import all_windows, blobs, distance
from numpy.typing import NDArray

from intarsia.judging.windows import SIDE, Windows, nearest

FACTOR = 2


def windows(*pictures: NDArray[np.int16], usable: NDArray[np.bool_] | None = None) -> Windows:
    found = Windows.of(list(pictures), [usable, *[None] * (len(pictures) - 1)], FACTOR)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def exemplar() -> NDArray[np.int16]:
    return blobs(44, 52, 1)


def test_windows_are_those_of_plain_loops(exemplar: NDArray[np.int16]) -> None:
    found = windows(exemplar)
    plain = all_windows(exemplar, FACTOR, found.middle, found.shorten)
    assert len(plain) == len(found.waves)
    for number, (y, x) in enumerate(found.at):
        assert found.waves[number].tolist() == plain[y, x], (y, x)
        assert found.table[y, x] == number


def test_the_nearest_is_the_nearest_of_all(exemplar: NDArray[np.int16]) -> None:
    found = windows(exemplar)
    output = blobs(40, 40, 7)
    cut = found.cut(output, 8)
    far, number = found.nearest(cut.reshape(-1, cut.shape[2]))
    plain = all_windows(exemplar, FACTOR, found.middle, found.shorten)
    asked = all_windows(output, FACTOR, found.middle, found.shorten)
    for k, (i, j) in enumerate(np.ndindex(cut.shape[:2])):
        each = {at: distance(asked[4 * i, 4 * j], w) for at, w in plain.items()}
        assert far[k] == min(each.values())
        assert each[tuple(found.at[number[k]])] == far[k]


def test_nothing_near_counts_as_ones_own_like(exemplar: NDArray[np.int16]) -> None:
    found = windows(exemplar)
    some, own = found.own(40)
    plain = all_windows(exemplar, FACTOR, found.middle, found.shorten)
    for number, far in zip(some, own, strict=True):
        y, x = found.at[number]
        away = [w for (a, b), w in plain.items() if max(abs(a - y), abs(b - x)) > SIDE // 2]
        assert far == min(distance(plain[y, x], w) for w in away)


def test_windows_hold_usable_pixels_alone(exemplar: NDArray[np.int16]) -> None:
    usable = np.ones(exemplar.shape[:2], bool)
    usable[21, 30] = False
    found = windows(exemplar, usable=usable)
    begins = {tuple(at) for at in found.at}
    for y, x in np.ndindex(44 // 2 - SIDE + 1, 52 // 2 - SIDE + 1):
        covers = y <= 10 < y + SIDE and x <= 15 < x + SIDE
        assert ((y, x) in begins) == (not covers)


def test_windows_of_two_exemplars_never_go_on_in_one_another(exemplar: NDArray[np.int16]) -> None:
    other = blobs(36, 30, 9)
    found = windows(exemplar, other)
    rows = np.flatnonzero((found.table >= 0).any(axis=1))
    assert np.diff(rows).max() == SIDE + 1
    assert len(found.waves) == sum((h // 2 - SIDE + 1) * (w // 2 - SIDE + 1) for h, w in ((44, 52), (36, 30)))


@pytest.mark.parametrize("most", [1, 255, 1023])
def test_distances_are_exact_in_single_precision(most: int) -> None:
    """The longest vectors that can be: black and white squares. Adding in any order gives the same whole number."""
    y, x = np.mgrid[:64, :64]
    board = np.where((y // 16 + x // 16) % 2, most, 0)
    found = windows(np.stack([board, most - board, board], axis=2).astype(np.int16))
    squares = (found.waves.astype(np.int64) ** 2).sum(axis=1)
    assert (found.squares == squares).all()
    assert 4 * int(squares.max()) <= 2**24
    far, _ = nearest(found.waves, found.waves[::-1].copy(), found.squares[::-1].copy())
    assert (far == 0).all()
