"""Tests of the potential of a point: what defines it, how it looks from afar, and where it ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intarsia.rendering.seam_levelling import FINE, greens_function


@pytest.mark.parametrize("radius", [12, 40, 96])
def test_its_differences_add_up_to_one_at_the_point_and_to_nothing_near_it(radius: int) -> None:
    values = greens_function(radius) / (1 << FINE)
    sums = values[:-2, 1:-1] + values[2:, 1:-1] + values[1:-1, :-2] + values[1:-1, 2:] - 4 * values[1:-1, 1:-1]
    middle = radius - 2
    assert abs(sums[middle, middle] - 1) < 4 / radius
    sums[middle, middle] = 0
    assert np.abs(sums[middle - 4 : middle + 5, middle - 4 : middle + 5]).max() < 8 / radius**2 + 4 / (1 << FINE)


def test_near_the_point_it_is_that_of_the_grid() -> None:
    """As known of a grid without end: 1/4 to the neighbour, 1/pi across the corner, 1 - 2/pi to the next but one."""
    values, middle = greens_function(1000) / (1 << FINE), 999
    want = {(0, 1): 0.25, (1, 1): 1 / math.pi, (0, 2): 1 - 2 / math.pi, (1, 2): 2 / math.pi - 0.25}
    for (y, x), value in want.items():
        assert abs(values[middle + y, middle + x] - values[middle, middle] - value) < 2 / (1 << FINE)


@pytest.mark.parametrize("radius", [1, 2, 7, 33])
def test_it_ends_within_the_radius_and_is_the_same_on_all_sides(radius: int) -> None:
    values = greens_function(radius)
    assert values.shape == (2 * radius - 1, 2 * radius - 1)
    assert (values == values.T).all()
    assert (values == values[::-1]).all()
    y, x = np.mgrid[1 - radius : radius, 1 - radius : radius]
    assert not values[y * y + x * x >= radius * radius].any()
    assert (values <= 0).all()


@pytest.mark.parametrize("radius", [8, 24, 96])
def test_along_a_straight_seam_the_step_is_taken_and_fades_to_both_sides(radius: int) -> None:
    """A pair of points on either side of every pixel of a long seam gives a step of 1 there."""
    column = (greens_function(radius) / (1 << FINE)).sum(axis=0)
    profile = np.append(0.0, column) - np.append(column, 0.0)  # a point, and the next the other way
    assert profile[radius - 1] - profile[radius] == pytest.approx(1, abs=0.02)
    assert (np.diff(profile[radius:]) > -6e-3).all()
    assert 0.4 < -profile[radius + radius // 4] < 0.5
    assert abs(profile[-1]) < 0.02
