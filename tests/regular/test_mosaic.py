"""Mosaics show every period of the exemplar, also those that its border cuts; lines of a mosaic meet at its cuts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torture
from long import but_some

import intarsia as ia
from intarsia.foundation.geometry import UNIT, Box
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.regular.block_grid import BlockGrid
from intarsia.regular.mosaic import Mosaic
from intarsia.testing.cases import noise


def tiles(down: int, across: int, rows: int, columns: int, moved: tuple[int, int] = (0, 0)) -> np.ndarray:
    """Tiles of `rows` x `columns` px, each of its own grey, joints of 3 px; cut `moved` px beside the joints."""
    y, x = np.mgrid[: down * rows, : across * columns]
    y, x = (y + moved[0]) % (down * rows), (x + moved[1]) % (across * columns)
    grey = 120 + (noise(64, 64, 5)[y // rows, x // columns] % np.uint64(100)).astype(int)
    grain = (noise(down * rows, across * columns, 7) % np.uint64(9)).astype(int)
    return np.where((y % rows < 3) | (x % columns < 3), 20, grey + grain).astype(np.uint8)


def shares(used: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """How often each period of an exemplar is shown, relative to the mean; periods from its first pixel on."""
    down, across = used.shape[0] // rows, used.shape[1] // columns
    each = used[: down * rows, : across * columns].reshape(down, rows, across, columns).mean(axis=(1, 3))
    return each / each.mean()


@pytest.mark.parametrize("moved", [(0, 0), (1, 2), (3, 1), (19, 2), (2, 23)])
def test_every_period_is_shown(moved: tuple[int, int]) -> None:
    """Wherever the joints lie in an exemplar that was cut to whole periods."""
    e = tiles(4, 4, 20, 24, moved)
    method = ia.NearRegular(lattice=((24, 0), (0, 20)), block=20, border=8)
    used = ia.synthesize(e, (1200, 1440), method, seed=3).map.usage()[0]
    each = shares(used, 20, 24)
    assert each.min() > 0.25, each.round(2)


def test_every_tile_of_the_sample_is_shown() -> None:
    """Its lattice leans and is no whole number of px; a row of its tiles, cut by its edges, is completed."""
    used = sum(ia.synthesize("sample:tiles", 2048, ia.NearRegular(), seed=seed).map.usage()[0] for seed in (1, 2))
    each = shares(np.asarray(used), 64, 64)
    assert each.min() > 0.25, each.round(2)


def ground(pixels: np.ndarray, rows: int, columns: int, phase: tuple[int, int], costs: float = 200.0) -> Any:
    """A gray exemplar continued past its edges."""
    from intarsia.regular.continuation import continued

    picture = (pixels[:, :, None].astype(np.int16) * 4).copy()
    rows_, columns_ = (rows * UNIT, 0), (0, columns * UNIT)
    grid = BlockGrid(rows_, columns_, (phase[0] * UNIT, phase[1] * UNIT), (columns_, rows_))
    return continued(picture, np.ones(pixels.shape, bool), grid, (float(rows), float(columns)), (costs, costs), 8)


@pytest.mark.parametrize(("phase", "before", "size"), [
    ((15, 0), (7, 0), (87, 96)),  # 15 of 20 rows above are known: 5 are missing, and 2 to spare
    ((5, 0), (0, 0), (87, 96)),  # 5 rows: the period below, of which 15 are known, is completed in its place
    ((0, 20), (0, 6), (80, 102)),
    ((0, 0), (0, 0), (80, 96)),
])  # fmt: skip
def test_cut_periods_are_completed_at_the_end_where_more_is_known(
    phase: tuple[int, int], before: tuple[int, int], size: tuple[int, int]
) -> None:
    """What is added is what a longer exemplar would have there, and its pixels are the exemplar's."""
    y, x = np.mgrid[-40:160, -48:192]
    endless = (37 * (y % 20) + 11 * (x % 24)) % 251
    pixels = endless[40:120, 48:144].astype(np.uint8)
    found = ground(pixels, 20, 24, phase)
    assert (found.before, found.usable.shape) == (before, size)
    assert found.usable.all()
    top, left = 40 - before[0], 48 - before[1]
    np.testing.assert_array_equal(found.picture[..., 0], 4 * endless[top : top + size[0], left : left + size[1]])
    shown = pixels[found.source[..., 0], found.source[..., 1]].astype(int)
    np.testing.assert_array_equal(4 * shown, found.picture[..., 0])


def test_a_period_whose_rest_does_not_fit_stays_cut() -> None:
    """Tiles that differ are not made from halves of two."""
    e = tiles(5, 4, 20, 24)[8:88]
    assert ground(e, 20, 24, (12, 0)).usable.shape == (80, 96)
    assert ground(e, 20, 24, (12, 0), costs=4000.0).usable.shape == (90, 96)


def test_what_is_masked_is_not_continued_and_does_not_continue() -> None:
    e = tiles(4, 4, 20, 24, (2, 2))
    usable = np.ones(e.shape, bool)
    usable[30:50, 40:60] = False
    method = ia.NearRegular(lattice=((24, 0), (0, 20)), block=20, border=8)
    used = ia.synthesize(Exemplar.of(e, usable=usable), (400, 480), method, seed=3).map.usage()[0]
    assert not used[~usable].any()


def test_a_window_of_a_continued_exemplar_is_a_crop() -> None:
    e = Exemplar.of(tiles(3, 4, 20, 24, (18, 21)))
    method = ia.NearRegular(lattice=((24, 0), (0, 20)), block=20, border=8)
    whole = ia.synthesize(e, (200, 300), method, seed=8).map.yx
    part = method.window([e], Box(50, 70, 120, 180), 8, ia.Run()).yx
    np.testing.assert_array_equal(part, whole[50:120, 70:180])


@pytest.mark.parametrize("name", but_some([
    "regular_azulejo_384", "regular_gingham-cloth_256", "near-regular_chainmail_256", "near-regular_wicker_192",
], "near-regular_wicker_192"))  # fmt: skip
def test_every_period_of_a_photograph_is_shown(name: str, textures: dict[str, Path]) -> None:
    """Those that lie whole in it, on the grid of the blocks."""
    e = ia.read(textures[name])
    method = ia.NearRegular().resolved([e], Canvas(9, 9))
    mosaic = Mosaic.of(method, e, 0)
    (a, b), second = mosaic.grid.vectors
    area = a * second[1] - b * second[0]
    y, x = np.mgrid[: e.height, : e.width] * UNIT + UNIT // 2
    y, x = y - mosaic.grid.phase[0], x - mosaic.grid.phase[1]
    rows, columns = (y * second[1] - x * second[0]) // area, (x * a - y * b) // area
    period = (rows - rows.min()) * 1000 + columns - columns.min()
    used = sum(ia.synthesize(e, 1536, method, seed=seed).map.usage()[0] for seed in (1, 2))
    whole = [n for n, px in zip(*np.unique(period, return_counts=True), strict=True) if px > 0.95 * abs(area) / UNIT**2]
    each = np.array([np.asarray(used)[period == n].mean() for n in whole])
    assert len(whole) >= 4
    assert each.min() > 0.25 * each.mean(), each / each.mean()


def misses(made: ia.Synthesis, y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """By how much lines miss each other at the cuts between blocks, px: beds across, joints along."""
    yx, found = made.map.yx.astype(int), []
    for before, after, step, place in (
        (yx[:-1], yx[1:], (1, 0), x), (yx[:, :-1], yx[:, 1:], (0, 1), y),
    ):  # fmt: skip
        cut = (after - before != step).any(axis=-1)
        gap = place[after[cut][:, 0], after[cut][:, 1]] - place[before[cut][:, 0], before[cut][:, 1]]
        found.append(np.abs((gap + 6) % 12 - 6))  # courses of 12 px, joints every 24 px, offset by half
    return np.concatenate(found)


def test_mortar_lines_of_a_warped_wall_meet() -> None:
    """Torture case 5, larger, warped by up to 2 px: the median miss is at most half a pixel."""
    found = []
    for seed in (5, 6, 7):
        rng = np.random.default_rng(seed)
        y, x = torture.grid(192) + np.clip([torture.smooth(rng, 192, 14), torture.smooth(rng, 192, 14)], -2, 2)
        picture = torture.byte(torture.wall(y, x, rng))
        made = ia.synthesize(picture, 360, ia.NearRegular(lattice=((12.0, 12.0), (24.0, 0.0))), seed=1)
        found.append(misses(made, y, x))
    assert np.median(np.concatenate(found)) <= 0.5
