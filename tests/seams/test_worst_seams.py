"""The worst places of a map: what windows cost, and which are left alone."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from intarsia.foundation.geometry import apart
from intarsia.seams.worst_seams import CELL, WorstSeams

WRAPS = ((False, False), (True, False), (False, True), (True, True))


@pytest.mark.parametrize("wraps", WRAPS)
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_windows_cost_what_lies_in_their_middles(wraps: tuple[bool, bool], seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = tuple(int(n) for n in rng.integers(20, 150, 2))
    prices = rng.integers(0, 9, (*size, 2)).astype(np.int32)
    patch = tuple(int(n) for n in rng.integers(8, 1 + np.array(size)))
    worst = WorstSeams(prices, (patch[0], patch[1]), wraps)
    cells = {
        (y, x): int(prices[y * CELL : (y + 1) * CELL, x * CELL : (x + 1) * CELL].sum())
        for y, x in product(*map(range, worst.shape))
    }
    radius = [min(n // (4 * CELL), m // 2) for n, m in zip(patch, worst.shape, strict=True)]
    scores = worst.scores()
    for y, x in cells:
        total = 0
        for dy, dx in product(*(range(-r, r + 1) for r in radius)):
            at = [y + dy, x + dx]
            at = [a % n if w else a for a, n, w in zip(at, worst.shape, wraps, strict=True)]
            total += cells.get((at[0], at[1]), 0)
        assert scores[y, x] == total


@pytest.mark.parametrize("wraps", WRAPS)
def test_what_is_given_up_returns_where_something_changes(wraps: tuple[bool, bool]) -> None:
    """All that lie within a quarter of a window of it are left; what a box touches is looked at again, and no more."""
    prices = np.ones((160, 200, 2), np.int32)
    worst, rows = WorstSeams(prices, (64, 64), wraps), 20
    worst.give_up((0, 5))
    left = {(y % rows, x) for y, x in product(range(-2 - wraps[0], 3 + wraps[0]), range(3 - wraps[1], 8 + wraps[1]))}
    left = left if wraps[0] else {(y, x) for y, x in product(range(3), range(3 - wraps[1], 8 + wraps[1]))}
    assert set(zip(*(n.tolist() for n in np.nonzero(worst._tired)), strict=True)) == left
    assert not left & set(worst.apart(0))
    worst.renew((12, 44, 1, 1))
    seen = {(y, x) for y, x in left if 1 - wraps[0] <= y <= 1 + wraps[0] and 5 - wraps[1] <= x <= 5 + wraps[1]}
    assert set(zip(*(n.tolist() for n in np.nonzero(worst._tired)), strict=True)) == left - seen
    assert seen


@pytest.mark.parametrize("wraps", WRAPS)
def test_windows_of_a_pass_lie_apart_worst_first(wraps: tuple[bool, bool]) -> None:
    """The dearest, of equals the first by rows, then the next that is far from all before; none without seams."""
    rng = np.random.default_rng(5)
    prices = (rng.random((150, 133, 2)) < 0.02).astype(np.int32)
    prices[:40, :60] = 0
    worst, taken = WorstSeams(prices, (24, 20), wraps), dict[tuple[int, ...], tuple[int, int]]()
    costs = worst.scores()
    for cell in sorted(np.ndindex(*worst.shape), key=lambda c: (-costs[c], c)):
        place = worst._first(0, cell[0]), worst._first(1, cell[1])
        gaps = (map(apart, place, other, (150, 133), wraps) for other in taken.values())
        if costs[cell] and all(any(g >= side + 9 for g, side in zip(gap, (24, 20), strict=True)) for gap in gaps):
            taken[cell] = place
    assert list(worst.apart(9).items()) == list(taken.items())
    assert len(taken) > 6
