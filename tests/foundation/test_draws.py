"""Draws: a hash of the place, the same everywhere, with no pattern that a texture could show."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from intarsia.foundation import ParameterError
from intarsia.foundation.run import MASK, below, check_seed, draw, draw_many

WORD = st.integers(-(2**63), 2**63 - 1)


def test_draws_are_what_they_have_always_been() -> None:
    """Golden values: a change here changes every map ever made."""
    assert draw(0, 0) == 0xEF7216490FFFC2BC
    assert draw(7, 2002, 0, 3, 4) == 0xC50B1C19A3899850
    assert draw(2**64 - 1, 1, 2, -1, -(2**40)) == 0xAA20B29902ED49C9


@given(st.integers(0, MASK), WORD, WORD, st.lists(st.tuples(WORD, WORD), max_size=5))
def test_many_draws_at_once_are_those_one_by_one(seed: int, stage: int, level: int, at: list[tuple[int, int]]) -> None:
    many = draw_many(seed, stage, level, at)
    assert many == [draw(seed, stage, level, y, x) for y, x in at]
    assert all(0 <= value <= MASK for value in many)


@given(st.integers(0, MASK), WORD, WORD)
def test_neighbouring_places_draw_differently(seed: int, y: int, x: int) -> None:
    near = {draw(seed, 1, 0, y + a, x + b) for a in range(-2, 3) for b in range(-2, 3)}
    assert len(near) == 25


def test_every_argument_matters_and_places_do_not_stand_for_one_another() -> None:
    seen = {draw(*(5 if k == i else 1 for k in range(5))) for i in range(1, 5)}
    assert len(seen) == 4
    assert len({draw(s, 2, 0, 3, 4) for s in range(99)}) == 99
    assert draw(1, 2, 0, 3, 4) != draw(1, 2, 0, 4, 3)
    assert draw(5, 1, 0, 3, 4) != draw(1, 5, 0, 3, 4)  # nor does a stage for a seed


def test_bits_are_even_and_free_of_rows_and_columns() -> None:
    """Each bit is set half of the time; neighbours do not go together."""
    bits = np.array([[draw(3, 9, 0, y, x) for x in range(64)] for y in range(64)], np.uint64)
    for k in range(64):
        layer = ((bits >> np.uint64(k)) & np.uint64(1)).astype(int)
        assert abs(layer.mean() - 0.5) < 0.04
        assert abs((layer[1:] == layer[:-1]).mean() - 0.5) < 0.04
        assert abs((layer[:, 1:] == layer[:, :-1]).mean() - 0.5) < 0.04


@given(st.integers(1, 2**32), st.integers(0, MASK))
def test_below_stays_below(n: int, bits: int) -> None:
    assert 0 <= below(n, bits) < n


def test_below_is_even() -> None:
    counts = np.bincount([below(7, draw(1, 1, 0, 0, k)) for k in range(7000)], minlength=7)
    assert counts.min() > 850
    assert below(5, 0) == 0
    assert below(5, MASK) == 4


def test_seeds_are_whole_numbers_of_64_bits() -> None:
    assert check_seed(2**64 - 1) == 2**64 - 1
    assert check_seed(np.int64(7)) == 7
    for bad in (-1, 2**64, 1.5, True, "7", None):
        with pytest.raises(ParameterError, match="seed=") as caught:
            check_seed(bad)
        assert "\n" not in str(caught.value)
