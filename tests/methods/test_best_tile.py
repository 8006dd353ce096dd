"""The best tile repeated: exact by whole lattices, right to half a px by real ones, and closed around what wraps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from regular.naive_tiles import naive_shown

import intarsia as ia
from intarsia.model.canvas import Canvas
from intarsia.regular.tile_search import STRAIN, TileLayout, Tiling, periods_along, read_offsets
from intarsia.testing import texture
from intarsia.testing.cases import noise

WHOLE = (((24, 0), (0, 20)), ((30, 0), (15, 16)), ((21, 5), (-4, 18)), ((17, -9), (3, 22)))
REAL = (((24.3, 0.1), (-0.2, 19.7)), ((21.5, 5.25), (-4.1, 18.6)), ((30.2, 0.3), (15.2, 16.1)))


def units(lattice: tuple) -> tuple:
    return tuple((round(256 * y), round(256 * x)) for x, y in lattice)


@settings(max_examples=40, deadline=None)
@given(
    st.sampled_from(WHOLE + REAL), st.sampled_from(list(ia.Wrap)), st.integers(-(2**41), 2**41), st.integers(-300, 300)
)
def test_a_layout_equals_its_plain_form(lattice: tuple, wrap: ia.Wrap, y: int, x: int) -> None:
    height = periods_along(units(lattice), 0, 4000)[-1][2]
    width = periods_along(units(lattice), 1, 4000)[-1][2]
    layout = TileLayout.of((7, 5), units(lattice), Canvas(height, width, wrap))
    window = layout.window(y, x, 5, 7)
    for i in range(5):
        for j in range(7):
            assert tuple(window[i, j]) == naive_shown(layout, y + i, x + j)


@pytest.mark.parametrize("lattice", WHOLE)
def test_whole_vectors_repeat_exactly(lattice: tuple) -> None:
    """Lopez Recas 2011, 4.1: output(x) = output(x + v1) = output(x + v2), and every px of one period is shown."""
    made = ia.synthesize(texture(100, 110, 3, 2), (130, 140), ia.BestTile(lattice=lattice))
    yx = made.map.yx
    for dx, dy in lattice:
        here = yx[max(0, -dy) : 130 - max(0, dy), max(0, -dx) : 140 - max(0, dx)]
        there = yx[max(0, dy) : 130 + min(0, dy), max(0, dx) : 140 + min(0, dx)]
        np.testing.assert_array_equal(here, there)
    (a, b), (c, d) = lattice
    assert len(np.unique(yx.reshape(-1, 2), axis=0)) == abs(a * d - b * c)


@pytest.mark.parametrize("vectors", [units(v) for v in WHOLE + REAL] + [((256 * 9, -130), (700, 256 * 7))])
def test_offsets_hold_all_that_is_read(vectors: tuple) -> None:
    """Of whole vectors exactly that; of real ones nothing is read beside them."""
    inside, (above, before) = read_offsets(vectors)
    layout = TileLayout.of((0, 0), vectors, Canvas(1, 1))
    found = np.unique(layout.window(-400, -500, 800, 900).reshape(-1, 2), axis=0)
    assert inside[found[:, 0] + above, found[:, 1] + before].all()
    if all(n % 256 == 0 for v in vectors for n in v):
        assert inside.sum() == len(found)
    else:
        assert inside.sum() <= len(found) + 0.1 * inside.sum() + 8


@pytest.mark.parametrize("lattice", WHOLE + REAL)
def test_periods_along_an_axis_are_all_that_there_are(lattice: tuple) -> None:
    """Against every pair of small numbers of both vectors."""
    vectors = units(lattice)
    for axis in (0, 1):
        found = {px for *_, px in periods_along(vectors, axis, 500)}
        for a in range(-40, 41):
            for b in range(-40, 41):
                forward, aside = (a * vectors[0][k] + b * vectors[1][k] for k in (axis, 1 - axis))
                px = (forward + 128) // 256
                if 0 < px <= 500 and np.hypot(forward - 256 * px, aside) <= STRAIN * 256 * px:
                    assert px in found


def test_the_tile_is_the_best_and_comes_from_the_undamaged_part() -> None:
    """A regular exemplar with a stain: the tile is one of those without."""
    y, x = np.mgrid[:120, :120]
    pixels = np.where((y % 20 < 3) | (x % 24 < 3), 30, 170) + (noise(120, 120, 1) % np.uint64(5)).astype(int)
    pixels[:70, :60] += (noise(70, 60, 2) % np.uint64(70)).astype(int)
    tiling = Tiling.of(((24, 0), (0, 20)), None, 8, ia.Exemplar.of(pixels.astype(np.uint8)))
    assert tiling.tile.anchor[0] >= 60 or tiling.tile.anchor[1] >= 50
    assert tiling.band == 8


def test_a_narrow_exemplar_gets_a_narrower_border() -> None:
    tiling = Tiling.of(((24, 0), (0, 20)), None, 8, ia.Exemplar.of(texture(22, 26, 1, 1)))
    assert 1 <= tiling.band < 8
    with pytest.raises(ia.MethodError, match=r"no tile of one period \(24.0,0.0 px and 0.0,20.0 px\) and its border"):
        ia.synthesize(texture(20, 24, 1, 1), 60, ia.BestTile(lattice=((24, 0), (0, 20))))


def test_one_vector_is_enough() -> None:
    """Rows keep their pitch; along them the exemplar is cut off where that shows least."""
    y, _ = np.mgrid[:120, :140]
    e = np.where(y % 15 < 3, 10, 120 + (noise(120, 140, 3) % np.uint64(60)).astype(int)).astype(np.uint8)
    made = ia.synthesize(e, (200, 300), ia.BestTile(lattice=((0, 15),)))
    np.testing.assert_array_equal(made.map.yx[15:], made.map.yx[:-15])
    dark = (made.render().pixels < 60).mean(axis=1)
    assert set(np.flatnonzero(dark > 0.9) % 15) == set(np.flatnonzero(dark > 0.5) % 15)
    assert len(np.unique(made.map.yx[..., 1])) >= 35


@pytest.mark.parametrize(
    ("size", "wrap", "told"),
    [
        ((187, 240), "both", "height=187 px is no whole number .* choose 180 or 200 px"),
        ((180, 9), "x", "width=9 px .* choose 24 px"), ((11, 240), "y", "height=11 px .* drop wrap"),
    ],
)  # fmt: skip
def test_sizes_that_strain_the_lattice_are_refused(size: tuple, wrap: str, told: str) -> None:
    lattice = ((17.3, 7.1), (-6.4, 19.9)) if wrap == "y" else WHOLE[0]
    with pytest.raises(ia.ParameterError, match=rf"^wrap: {told}"):
        ia.synthesize(texture(100, 110, 1, 2), size, ia.BestTile(lattice=lattice), wrap=wrap)


def test_vectors_of_the_largest_exemplars_do_not_overflow() -> None:
    """Sides of 60000 px and their fractions: still right to half a px, far out."""
    vectors, (y, x) = units(((60000.3, 20.7), (-31.9, 50000.1))), (2**40 + 17, -(2**39))
    layout, wrapped = (TileLayout.of((11, 12), vectors, c) for c in (Canvas(1, 1), Canvas(100_032, 2_000, ia.Wrap.Y)))
    assert tuple(layout.window(y, x, 1, 1)[0, 0]) == naive_shown(layout, y, x)
    np.testing.assert_array_equal(wrapped.window(100_032 * 5 + 3, 999, 2, 3), wrapped.window(3, 999, 2, 3))
