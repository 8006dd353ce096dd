"""The best tile: its cost is the plain sum, no other anchor is better, and its layout repeats exactly."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torture import TORTURE

from intarsia.analysis.features import features
from intarsia.foundation import MethodError, ParameterError
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.regular.tile_search import Tile, TileLayout, best_tile


def px(*vectors):
    return tuple((round(256 * y), round(256 * x)) for y, x in vectors)


def layout_of(tile: Tile, height: int, width: int) -> np.ndarray:
    """Lay out a tile by its whole sides: moved by either of them the layout is the same."""
    return TileLayout.of(tile.anchor, px(*tile.vectors), Canvas(1, 1)).window(0, 0, height, width)


def naive_cost(picture, usable, anchor, v1, v2, band):
    """Lopez Recas 2011, 4.1.1, px by px: -1 where something is missing."""
    height, width = picture.shape[:2]
    total = 0
    for step, side in ((v1, v2), (v2, v1)):
        steep = abs(side[0]) >= abs(side[1])
        long, across = side if steep else side[::-1]
        for i in range(abs(long)):
            shift = (2 * i * across + abs(long)) // (2 * abs(long)) - band // 2
            for k in range(band):
                y, x = (i if long > 0 else -i), shift + k
                y, x = (anchor[0] + y, anchor[1] + x) if steep else (anchor[0] + x, anchor[1] + y)
                far = y + step[0], x + step[1]
                for at in ((y, x), far):
                    if not (0 <= at[0] < height and 0 <= at[1] < width and usable[at]):
                        return -1
                total += int(((picture[y, x].astype(int) - picture[far]) ** 2).sum())
    return total


@given(st.integers(0, 9999))
def test_costs_equal_their_plain_form(seed):
    rng = np.random.default_rng(seed)
    picture = rng.integers(0, 1023, (26, 30, 2)).astype(np.int16)
    v1, v2 = (tuple(int(n) for n in rng.integers(-9, 10, 2)) for _ in range(2))
    band = int(rng.integers(1, 5))
    if abs(v1[0] * v2[1] - v1[1] * v2[0]) < 4:
        return
    usable = np.ones((26, 30), bool)
    usable[rng.integers(26), rng.integers(30)] = False
    found = best_tile(picture, px(v1, v2), usable, band)
    for y in range(0, 26, 3):
        for x in range(0, 30, 4):
            if found.costs[y, x] >= 0:
                assert found.costs[y, x] == naive_cost(picture, usable, (y, x), v1, v2, band)


def test_no_other_anchor_is_better_and_the_layout_repeats():
    picture = features([Exemplar.of(TORTURE["brick_colours"]())]).pictures[0]
    found = best_tile(picture, px((12, 12), (0, 24)))
    assert found.cost == found.costs[found.anchor] == found.costs[found.costs >= 0].min()
    layout = layout_of(found, 90, 110)
    for dy, dx in found.vectors:
        assert np.array_equal(layout[dy:, dx:] if dx else layout[dy:], layout[: 90 - dy, : 110 - dx])
    assert len(np.unique(layout.reshape(-1, 2), axis=0)) == 12 * 24
    y, x = found.anchor
    inside = layout_of(found, y + 1, x + 1)
    assert tuple(inside[y, x]) == (y, x)
    assert layout.min() >= 0
    assert (layout.reshape(-1, 2).max(axis=0) < picture.shape[:2]).all()


def test_the_tile_avoids_what_cannot_be_used():
    picture = features([Exemplar.of(TORTURE["hexagons"]())]).pictures[0]
    usable = np.ones(picture.shape[:2], bool)
    usable[40:60, 30:70] = False
    for vectors in (((0, 24), (21, 12)), ((21, 12), (21, -12)), ((-21, 12), (0, 24))):
        found = best_tile(picture, px(*vectors), usable, 4)
        layout = layout_of(found, 100, 100).reshape(-1, 2)
        assert usable[layout[:, 0], layout[:, 1]].all()
        ys, xs = np.nonzero(found.costs >= 0)
        for k in range(0, len(ys), 97):  # every anchor with a cost, not only the best
            y, x = int(ys[k]), int(xs[k])
            parts = [np.array((y, x)) + a / 8 * np.array(vectors[0]) + b / 8 * np.array(vectors[1])
                     for a in range(8) for b in range(8)]  # fmt: skip
            assert all(0 <= p[0] < 144 and 0 <= p[1] < 144 for p in parts)


def test_what_does_not_fit_is_refused():
    picture = np.zeros((40, 40, 1), np.int16)
    with pytest.raises(ParameterError):
        best_tile(picture, px((5, 5), (10, 10)))
    with pytest.raises(ParameterError):
        best_tile(picture, px((5, 0), (0, 10)), band=0)
    with pytest.raises(MethodError, match="px"):
        best_tile(picture, px((39, 0), (0, 39)))
    with pytest.raises(MethodError):
        best_tile(picture, px((9, 0), (0, 9)), np.zeros((40, 40), bool))
