"""The worst places of a map: what is kept up to date where it changed is what reading all of it anew finds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from intarsia.seams.worst import Highest, WorstSeams

WRAPS = ((False, False), (True, False), (False, True), (True, True))


@pytest.mark.parametrize("wraps", WRAPS)
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_what_is_kept_up_to_date_is_what_reading_all_finds(wraps: tuple[bool, bool], seed: int) -> None:
    """After boxes changed, places were given up and named: scores, places and waves are those of a fresh look."""
    rng = np.random.default_rng(seed)
    size = tuple(int(n) for n in rng.integers(20, 150, 2))
    prices = (rng.integers(0, 9, (*size, 2)) * (rng.random((*size, 1)) < 0.3)).astype(np.int32)
    patch = tuple(int(n) for n in rng.integers(8, 1 + np.array(size)))
    worst = WorstSeams(prices, (patch[0], patch[1]), wraps)
    for _ in range(12):
        if rng.random() < 0.5:
            at = [int(rng.integers(n)) for n in size]
            long = [int(rng.integers(1, 1 + (n if w else n - a))) for a, n, w in zip(at, size, wraps, strict=True)]
            box = at[0], at[1], long[0], long[1]
            where = np.ix_(*((a + np.arange(n)) % m for a, n, m in zip(at, long, size, strict=True)))
            prices[where] = rng.integers(0, 20, prices[where].shape)
            worst.renew(box)
        elif first := worst.apart(0, most=1):
            worst.give_up(*first)
        fresh = WorstSeams(prices, (patch[0], patch[1]), wraps)
        fresh._tired[:] = worst._tired
        fresh.read()
        assert (fresh._scores == worst._scores).all()
        assert (fresh._cells == worst._cells).all()
        assert fresh.apart(5, 40) == worst.apart(5, 40)
        assert list(worst.apart(5).items())[:3] == list(worst.apart(5, most=3).items())


def test_only_what_changed_is_read_again() -> None:
    """To renew a box of a large canvas costs as much as of a small one: what lies elsewhere is not looked at."""
    prices = np.zeros((800, 900, 2), np.int32)
    worst = WorstSeams(prices, (32, 32), (False, False))
    prices[:] = 1
    worst.renew((400, 300, 40, 50))
    rows, columns = np.nonzero(worst._cells)
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (49, 55, 37, 43)
    assert not worst._scores[:48].any()
    assert not worst._scores[:, 45:].any()


def test_the_first_of_equals_is_the_highest() -> None:
    """Row by row; what is 0 or less is none."""
    grid = Highest(np.array([[0, 3, 1], [5, 2, 5], [5, 0, 0]]))
    assert grid.first() == (1, 0)
    grid.put(np.array([1]), np.array([0, 2]), 0)
    assert grid.first() == (2, 0)
    grid.put(np.arange(3), np.arange(3), np.array([[-1, 0, 0]] * 3))
    assert grid.first() is None
