"""Courses that are kept for the windows beside: the same pixels, made once, in so many bytes."""

from __future__ import annotations

import pickle
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from regular.test_wall import CASES

from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.regular.wall import LRUCache, Wall

PLACES = [(0, 0), (0, 64), (64, 64), (-64, 64), (0, 0), (2**40, -(2**40)), (64, 0), (2**40, 64 - 2**40)]


@pytest.mark.parametrize("case", CASES)
def test_windows_one_after_another_are_those_made_alone(case: Any) -> None:
    pixels, lattice = case
    exemplar = Exemplar.of(pixels)
    one = Wall.of(lattice, None, exemplar, Canvas(10, 10), 5)
    for threads, (y, x) in enumerate(PLACES):
        alone = Wall.of(lattice, None, exemplar, Canvas(10, 10), 5).window(y, x, 64, 64)
        np.testing.assert_array_equal(one.window(y, x, 64, 64, Run(threads % 2 + 1)), alone)


def test_a_window_beside_lays_only_what_is_new(monkeypatch: pytest.MonkeyPatch) -> None:
    pixels, lattice = CASES[0]
    wall = Wall.of(lattice, None, Exemplar.of(pixels), Canvas(10, 10), 5)
    laid: list[Any] = []
    strip = Wall._make_strip
    monkeypatch.setattr(Wall, "_make_strip", lambda self, course: laid.append(course[:2]) or strip(self, course))
    for x, y in ((0, 0), (64, 0), (128, 0), (0, 64)):
        wall.window(y, x, 64, 64, Run(1))
    assert len(set(laid)) == len(laid)
    assert len(laid) < 2 * len({i for _, i in laid})


def test_what_was_used_longest_ago_gives_way() -> None:
    kept, made = LRUCache(1000), list[Any]()

    def make(keys: Any) -> Any:
        made.extend(keys)
        return [(np.full(50, key[1], np.int64),) for key in keys]

    for wanted in ([0, 1], [1, 2], [0, 3], [2]):
        found = kept.all([(7, n) for n in wanted], make)
        assert [int(one[0]) for (one,) in found] == wanted
    assert made == [(7, 0), (7, 1), (7, 2), (7, 0), (7, 3), (7, 2)]
    assert all(a != b for a, b in pairwise(made))
    assert pickle.loads(pickle.dumps(kept)).all([(7, 2)], make)[0][0][0] == 2
