"""The lattice by goodness: the worked example, the count of a tile, and the cases that the source calls good."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lattice.test_lattice import apart, of

import intarsia as ia
from intarsia.published.lopez_recas2011.goodness import goodness_lattice
from intarsia.published.lopez_recas2011.goodness_kernels import hermite, tile_pixels


def tile_coverage(v1: tuple[int, int], v2: tuple[int, int], height: int, width: int) -> tuple[int, int]:
    """How many different pixels of a lattice's tile a rectangle shows, and how many the tile has."""
    a, b, c = hermite(*v1, *v2)
    return tile_pixels(a, b, c, height, width), a * c


def test_the_worked_example_of_the_source():
    """Overlaps of 3 x 8 and 5 x 7 px show 22 and 35 of the 38 px of the tile."""
    for v1, v2 in (((-3, 5), (7, 1)), ((3, 5), (-7, 1))):
        assert tile_coverage(v1, v2, 8, 3) == (22, 38)
        assert tile_coverage(v1, v2, 7, 5) == (35, 38)


@given(st.integers(0, 9999))
def test_tile_coverage_equals_counting(seed):
    rng = np.random.default_rng(seed)
    v = rng.integers(-14, 15, (2, 2))
    determinant = int(v[0, 0] * v[1, 1] - v[0, 1] * v[1, 0])
    if determinant == 0:
        return
    height, width, top, left = (int(n) for n in rng.integers(1, 25, 4))
    seen = set()
    for y in range(top, top + height):
        for x in range(left, left + width):
            a = (y * v[1, 1] - x * v[1, 0]) // determinant
            b = (x * v[0, 0] - y * v[0, 1]) // determinant
            seen.add((int(y - a * v[0, 0] - b * v[1, 0]), int(x - a * v[0, 1] - b * v[1, 1])))
    assert tile_coverage(tuple(v[0].tolist()), tuple(v[1].tolist()), height, width) == (len(seen), abs(determinant))


def test_the_plain_rule_on_the_cases_that_the_source_calls_good():
    """Coloured small pictures: the small tile must lose. Gray tiles of varying brightness: it must win."""
    rng = np.random.default_rng(1)
    y, x = np.mgrid[:128, :128]
    motif = 1 - np.hypot(y % 16 - 7.5, x % 16 - 7.5)[..., None] / 11
    colours = rng.uniform(0, 255, (2, 2, 3))[y // 16 % 2, x // 16 % 2]
    found = goodness_lattice(of((motif * colours).clip(0, 255).astype(np.uint8)))
    assert apart(found, np.array([(0.0, 32.0), (32.0, 0.0)])) == (1, 0)
    gray = np.where((y % 16 < 2) | (x % 16 < 2), 20, rng.uniform(110, 160, (9, 9))[y // 16, x // 16])
    found = goodness_lattice(of(gray.astype(np.uint8)))
    assert apart(found, np.array([(0.0, 16.0), (16.0, 0.0)])) == (1, 0)


@pytest.mark.parametrize("shape", [(1, 1), (1, 300), (15, 90), (16, 16), (40, 700), (33, 64)])
def test_odd_exemplars_have_an_answer(shape):
    """Noise has one, or none, inside the exemplar."""
    noise = np.random.default_rng(0).integers(0, 1023, (*shape, 3)).astype(np.int16)
    plain = goodness_lattice(noise[:, :90])
    assert plain is None or (np.abs(plain[0]) < (shape[0], 90)).all()


def test_gaps_are_filled_by_the_lattice_of_the_source_where_that_is_asked_for():
    """As published: coloured tiles repeat by the period of their colours, whose goodness is the best."""
    y, x = np.mgrid[:96, :96]
    tiles = np.where((y % 16 < 2) | (x % 16 < 2), 20, 90 + 60 * ((y // 16 + x // 16) % 2)).astype(np.uint8)
    method = ia.GapFilling(detector="goodness", block=20, border=4)
    made = ia.synthesize(tiles, 64, method, seed=1)
    found = goodness_lattice(of(tiles))
    assert made.method.lattice == tuple((x, y) for y, x in found.tolist())
    with pytest.raises(ia.MethodError, match="no peak of correlation"):
        ia.synthesize(np.full((40, 40), 9, np.uint8), 64, method)
