"""Parts of a picture, beside a flood that fills them one by one."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from intarsia.kernels.pieces_of_maps import boxes_of_parts, parts

PICTURES = arrays(np.int32, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.integers(0, 2))


def flooded(values: np.ndarray, wrap: tuple[bool, bool]) -> np.ndarray:
    """Number parts by flooding each from its first pixel in rows."""
    out, count = np.zeros(values.shape, np.int32), 0
    h, w = values.shape
    for y, x in zip(*np.nonzero(values), strict=True):
        if out[y, x]:
            continue
        count += 1
        open_ = [(int(y), int(x))]
        while open_:
            b, a = open_.pop()
            if wrap[0]:
                b %= h
            if wrap[1]:
                a %= w
            if 0 <= b < h and 0 <= a < w and not out[b, a] and values[b, a] == values[y, x]:
                out[b, a] = count
                open_ += [(b + i, a + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return out


@given(PICTURES, st.booleans(), st.booleans())
def test_parts_are_those_of_a_flood(values: np.ndarray, rows: bool, columns: bool) -> None:
    out = np.empty(values.shape, np.int32)
    count = parts(values, (rows, columns), out)
    expected = flooded(values, (rows, columns))
    assert count == expected.max()
    assert (out == expected).all()


def test_boxes_reach_over_borders_that_wrap() -> None:
    values = np.zeros((12, 14), np.int32)
    values[[11, 0, 1], [3, 3, 4]] = 1  # over the upper border
    values[6:8, [13, 0]] = 1  # over the left one
    out = np.empty(values.shape, np.int32)
    boxes = np.empty((parts(values, (True, True), out), 5), np.int64)
    boxes_of_parts(out, (True, True), boxes)
    assert boxes.tolist() == [[11, 3, 3, 2, 3], [6, 13, 2, 2, 4]]
    boxes = np.empty((parts(values, (False, True), out), 5), np.int64)
    boxes_of_parts(out, (False, True), boxes)
    assert boxes.tolist() == [[0, 3, 2, 2, 2], [6, 13, 2, 2, 4], [11, 3, 1, 1, 1]]
