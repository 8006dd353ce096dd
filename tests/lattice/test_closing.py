"""Lengths around which a lattice closes, against all of its points."""

from __future__ import annotations

import math

import pytest

from intarsia.lattice import allowed_misfit, closing_length, closing_vector, misfit

UNIT = 256
LATTICES = {
    "upright": ((0, 20 * UNIT), (32 * UNIT, 0)),
    "a bond": ((0, 40 * UNIT), (16 * UNIT, 20 * UNIT)),
    "slanted": ((200, 5130), (8200, -310)),
    "finer than a px": ((0, 5000), (7777, 0)),
}


def naive_misfit(vectors: tuple[tuple[int, int], ...], length: int, axis: int) -> float:
    """All points of the lattice within reach, one by one."""
    goal = (length, 0) if axis == 0 else (0, length)
    (a, b), (c, d) = ((y / UNIT, x / UNIT) for y, x in vectors)
    reach = range(-40, 41)
    points = [(s * a + t * c, s * b + t * d) for s in reach for t in reach if (s, t) != (0, 0)]
    return min(math.dist(point, goal) for point in points)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("name", LATTICES)
def test_the_misfit_is_that_of_the_nearest_point(name: str, axis: int) -> None:
    vectors = LATTICES[name]
    for length in range(16, 200, 7):
        assert misfit(vectors, length, axis) == pytest.approx(naive_misfit(vectors, length, axis), abs=1e-9)


def test_a_canvas_of_less_than_half_a_period_closes_around_one() -> None:
    """Not around none: what is shown there would not go on at all."""
    assert closing_vector(LATTICES["upright"], 9, 0) == (32 * UNIT, 0)
    assert closing_vector(LATTICES["upright"], 6, 1) == (0, 20 * UNIT)


def test_of_rows_their_pitch_must_close() -> None:
    rows = ((0, 24 * UNIT),)
    assert [misfit(rows, n, 1) for n in (240, 243, 252)] == [0, 3, 12]
    slanted = ((48 * UNIT, 2 * UNIT),)
    pitch = math.hypot(48, 2)
    assert misfit(slanted, 480, 0) == pytest.approx(abs(480 * 48 / pitch - 10 * pitch))


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("name", LATTICES)
def test_the_largest_length_that_closes_is_found(name: str, axis: int) -> None:
    vectors = LATTICES[name]
    for length in (150, 173, 199):
        fits = [n for n in range(length, length // 2, -1) if naive_misfit(vectors, n, axis) <= allowed_misfit(vectors)]
        found = closing_length(vectors, length, axis)
        if not fits:
            assert found is None
            continue
        assert found is not None
        assert fits[0] - found <= 2 * allowed_misfit(vectors)
        assert naive_misfit(vectors, found, axis) <= naive_misfit(vectors, fits[0], axis)


def test_a_length_that_closes_stays_and_the_unit_is_kept() -> None:
    vectors = LATTICES["upright"]
    assert closing_length(vectors, 160, 1) == 160
    assert closing_length(vectors, 171, 1) == 160
    assert closing_length(vectors, 170, 1, unit=8) == 160
    assert closing_length(vectors, 190, 1, unit=16) == 160
    assert closing_length(vectors, 29, 0) is None


def test_nothing_closes_along_rows() -> None:
    assert closing_length(((52 * UNIT, UNIT // 2),), 256, 1) == 256
    assert closing_length(((52 * UNIT, UNIT // 2),), 256, 0) == 208
