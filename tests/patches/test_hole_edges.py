"""The edge of holes: the kernels weigh what the plain version weighs, and rough is not continued by smooth."""

from __future__ import annotations

import numpy as np
import pytest
from naive import edge_difference, edge_pixels, posed
from numpy.typing import NDArray

from intarsia.analysis.features import features
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import identity
from intarsia.patches import index_of
from intarsia.patches.patch_synthesis import PatchSettings, PatchSynthesis
from intarsia.patches.repetition_kernels import CELL, edge_cells, weigh_edge
from intarsia.search import posed_exemplars
from intarsia.tasks.completion import with_hole
from intarsia.testing import noise, texture

SIDE = 13


def holed(seed: int, share: int) -> NDArray[np.bool_]:
    """A window's holes: a block, or speckles, or both."""
    hole = noise(SIDE, SIDE, seed) % np.uint64(100) < share
    hole[4 : 4 + seed % 6, 3:9] = True
    return np.asarray(hole)


@pytest.mark.parametrize("wrap", [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize(("seed", "share"), [(0, 0), (1, 4), (2, 30), (3, 100), (5, 0)])
def test_the_edge_is_that_of_the_plain_version(seed: int, share: int, wrap: tuple[bool, bool]) -> None:
    locked = np.asarray(noise(30, 34, seed + 9) % np.uint64(4) > 0)
    known = (~holed(seed, share)).astype(np.uint8)
    for at in [(5, 6), (0, 21), *([(24, 9)] if wrap[0] else []), *([(25, 28)] if all(wrap) else [])]:
        spots, ends = edge_cells(locked[index_of(*at, (SIDE, SIDE), (30, 34))], known)
        assert sorted(map(tuple, spots.tolist())) == edge_pixels(locked, at, wrap, known)
        cells = [set(map(tuple, (part // CELL).tolist())) for part in np.split(spots, ends)]
        assert all(len(cell) == 1 for cell in cells[:-1])
        assert not cells[-1]


@pytest.mark.parametrize("isometries", [(0,), (0, 3, 5, 6)])
@pytest.mark.parametrize("channels", [1, 3])
def test_candidates_are_weighed_and_ordered_as_by_the_plain_version(channels: int, isometries: tuple[int, ...]) -> None:
    exemplars = [Exemplar.of(texture(30, 30, channels, 3))]
    feats = features(exemplars)
    laid = posed_exemplars(exemplars, feats, isometries, (SIDE, SIDE))
    wrap = (False, False)
    for seed in range(1, 5):
        locked = np.asarray(noise(40, 40, seed + 5) % np.uint64(5) > 0)
        known = (~holed(seed, 3 * seed)).astype(np.uint8)
        old = feats.pictures[0][2 : 2 + SIDE, 3 : 3 + SIDE] + np.int16(17 * seed)
        every = [(v, u, s) for v in range(len(laid)) for u in range(0, 17, 4) for s in range(0, 17, 5)]
        rows = np.array([(1000 * (n % 7), *pick) for n, pick in enumerate(every)], np.int64)
        before, edge = rows.copy(), edge_pixels(locked, (7, 8), wrap, known)
        weigh_edge(old, int(known.sum()), *edge_cells(locked[7 : 7 + SIDE, 8 : 8 + SIDE], known), laid.posed, rows)
        wanted = []
        for d, v, u, s in before.tolist():
            new = posed(exemplars, isometries, feats)[v].picture[u : u + SIDE, s : s + SIDE]
            there = edge_difference(old, new, edge)
            wanted.append(((d + there // len(edge) * int(known.sum())) // 2, v, u, s))
        assert rows.tolist() == [list(row) for row in wanted]


def test_without_an_edge_nothing_changes() -> None:
    e = Exemplar.of(texture(30, 30, 1, 3))
    hole = np.zeros((30, 30), bool)
    hole[8:14, 9:20] = True
    for rim, weighed in ((40, False), (0, True)):
        canvas = Canvas(30, 30, start=with_hole(identity([e.source], 0), hole), rim=rim)
        growth = PatchSynthesis(PatchSettings((SIDE, SIDE), (4, 4)), [e], canvas)
        at, prices = np.array([growth.at((0, 0))]), growth.repetition.search_prices
        (found,) = growth.finder.find(growth.growing.grown, at, prices)
        assert (growth.weighed((0, 0), found).rows.tolist() != found.rows.tolist()) == weighed
