"""Isometries form their group, and patches cover their line exactly."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from naive import lay_down, shown_pixel

from intarsia.analysis.features import transformed
from intarsia.foundation.geometry import ISOMETRIES, ISOMETRY_SETS, Box, Wrap, apart, spread
from intarsia.search import isometry_ids


@pytest.mark.parametrize("iso", ISOMETRIES, ids=lambda i: i.name)
def test_matrices_say_the_same_as_the_table_of_the_source(iso) -> None:
    """Multrus 2003, 4.1.1: start + J (i, j) is the pixel of the table, for squares and rectangles."""
    for height, width in ((5, 5), (4, 7)):
        block = np.arange(height * width).reshape(height, width)
        laid = lay_down(block, iso.id)
        y0, x0 = iso.start(height, width)
        for i, j in np.ndindex(laid.shape):
            y, x = np.array((y0, x0)) + np.array(iso.j) @ (i, j)
            assert (y, x) == shown_pixel(iso.id, height, width, i, j)
        np.testing.assert_array_equal(transformed(block, iso.id), laid)
        assert iso.swaps == (laid.shape != block.shape if height != width else iso.id in (3, 4, 5, 7))


def test_isometry_5_is_rot90_and_7_is_its_inverse() -> None:
    """Multrus 2003, 4.1.1: the misprint of isometry 7 is put right."""
    block = np.arange(25).reshape(5, 5)
    np.testing.assert_array_equal(transformed(block, 5), np.rot90(block))
    np.testing.assert_array_equal(transformed(transformed(block, 5), 7), block)
    np.testing.assert_array_equal(transformed(block, 7), np.rot90(block, 3))
    np.testing.assert_array_equal(transformed(block, 6), np.rot90(block, 2))


def test_the_eight_are_a_group_and_all_differ() -> None:
    """Multrus 2003, 4.1.1: closed under composition, all distinct on a generic block; matrices multiply along."""
    block = np.arange(16).reshape(4, 4)
    looks = [transformed(block, k).tobytes() for k in range(8)]
    assert len(set(looks)) == 8
    for a, b in product(range(8), repeat=2):
        both = looks.index(np.ascontiguousarray(transformed(transformed(block, a), b)).tobytes())
        product_of = np.array(ISOMETRIES[a].j) @ np.array(ISOMETRIES[b].j)
        np.testing.assert_array_equal(product_of, ISOMETRIES[both].j)


def test_categories_are_those_of_the_source() -> None:
    """Multrus 2003, 4.1.1: none, category 1, category 2, both."""
    assert isometry_ids("none") == (0,)
    assert set(isometry_ids("180")) == {0, 1, 2, 6}
    assert set(isometry_ids("90")) == {0, 3, 4, 5, 7}
    assert isometry_ids("both") == tuple(range(8))
    assert isometry_ids((2, 3)) == (2, 3)
    assert all(not ISOMETRIES[k].swaps for k in ISOMETRY_SETS["180"])
    assert [i.id for i in ISOMETRIES] == list(range(8))


@given(st.integers(1, 300), st.integers(1, 60), st.integers(0, 59), st.booleans())
def test_patches_cover_the_line_and_overlap_enough(length: int, patch: int, overlap: int, wrap: bool) -> None:
    """Robinson 2004: no gap, no pixel outside, overlaps at least as wide as asked and nearly even."""
    overlap %= patch
    starts, size = spread(length, patch, overlap, wrap)
    assert size == min(patch, length)
    assert starts == sorted(set(starts))
    assert starts[0] == 0
    covered = {(s + k) % length if wrap else s + k for s in starts for k in range(size)}
    assert covered == set(range(length))
    steps = np.diff([*starts, length] if wrap else starts)
    if len(steps) and length > patch:
        assert steps.max() <= patch - overlap
        assert steps.max() - steps.min() <= 1
        fewer = len(starts) - 1
        reach = fewer * (patch - overlap) if wrap else fewer * (patch - overlap) + overlap
        assert reach < length or (wrap and len(starts) == 2), "one patch less would not do"


def test_a_multiple_of_the_pitch_is_the_plain_raster() -> None:
    """Robinson 2004: the origins of patches are multiples of the pitch wherever the size allows it."""
    assert spread(4 + 5 * 8, 12, 4, False) == ([0, 8, 16, 24, 32], 12)
    assert spread(40, 12, 4, True) == ([0, 8, 16, 24, 32], 12)
    assert spread(30, 10, 0, False) == ([0, 10, 20], 10)
    assert spread(12, 12, 4, False) == ([0], 12)
    assert spread(12, 12, 4, True) == ([0, 6], 12)
    assert spread(1, 12, 4, True) == ([0], 1)
    assert spread(8, 12, 4, True) == ([0, 4], 8)  # around a torus two at least: none is joined to itself


def test_wraps_and_boxes() -> None:
    assert [(w.y, w.x) for w in Wrap] == [(False, False), (False, True), (True, False), (True, True)]
    assert Wrap("both") is Wrap.BOTH
    box = Box(-3, 2**40, 5, 2**40 + 7)
    assert (box.height, box.width) == (8, 7)


def test_apart_is_the_short_way_round() -> None:
    assert [apart(a, b, 10, True) for a, b in ((1, 9), (9, 1), (-9, 1), (4, 4), (0, 5))] == [2, 2, 0, 0, 5]
    assert apart(1, 9, 10, False) == 8
