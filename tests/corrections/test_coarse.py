"""Coarse levels of an endless map: quick, each part alone, and what the finest one becomes."""

from __future__ import annotations

import numpy as np
import pytest

import intarsia as ia
from intarsia.corrections.parallel_controllable import coarse
from intarsia.foundation.geometry import Box
from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.testing import texture

EXEMPLAR = Exemplar.of(texture(40, 44, 3))
PLACES = [(0, 0), (-96, 1 << 40)]


@pytest.mark.parametrize("place", PLACES)
def test_the_finest_level_is_the_window(place: tuple[int, int]) -> None:
    (y, x), method = place, ia.ParallelControllable()
    box = Box(y, x, y + 24, x + 32)
    found = coarse(method, [EXEMPLAR], box, 0, 7, Run(1))
    np.testing.assert_array_equal(found, method.window([EXEMPLAR], box, 7, Run(1)).yx)


@pytest.mark.parametrize("level", [1, 2, 3])
@pytest.mark.parametrize("place", PLACES)
def test_any_part_of_a_level_can_be_made_alone(place: tuple[int, int], level: int) -> None:
    (y, x), method, one = place, ia.ParallelControllable(), 1 << level
    whole = coarse(method, [EXEMPLAR], Box(y, x, y + 12 * one, x + 16 * one), level, 7, Run(1))
    part = coarse(method, [EXEMPLAR], Box(y + 3 * one, x + 5 * one, y + 9 * one, x + 6 * one), level, 7, Run(1))
    assert whole is not None
    assert whole.shape == (12, 16, 2)
    np.testing.assert_array_equal(part, whole[3:9, 5:6])


def test_without_jitter_each_square_shows_its_middle() -> None:
    method = ia.ParallelControllable(jitter=0, passes=0, keep_lattice="off")
    for level in (1, 2, 3):
        one = 1 << level
        found = coarse(method, [EXEMPLAR], Box(0, 0, 5 * one, 5 * one), level, 7, Run(1))
        known = method.window([EXEMPLAR], Box(0, 0, 5 * one, 5 * one), 7, Run(1)).yx
        np.testing.assert_array_equal(found, known[one // 2 :: one, one // 2 :: one])


def test_what_is_turned_or_too_coarse_has_none() -> None:
    box = Box(0, 0, 64, 64)
    assert coarse(ia.ParallelControllable(angle=30), [EXEMPLAR], box, 2, 7, Run(1)) is None
    assert coarse(ia.ParallelControllable(), [EXEMPLAR], box, 20, 7, Run(1)) is None
