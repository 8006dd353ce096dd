"""Pieces about a window: which shifts a map shows, and that bad places are covered by them, too."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from intarsia.foundation.geometry import Wrap
from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import HOLE
from intarsia.patches.growth import Growth, PatchSettings
from intarsia.seams import graphcut, improve
from intarsia.seams.graphcut import shifts_around
from intarsia.testing import texture

SIZES = ((7, 9), (5, 6))  # of two exemplars, the second continues in itself


def naive_shifts(variant: np.ndarray, yx: np.ndarray, places: tuple, at: tuple[int, int]) -> list[tuple]:
    """Pixel by pixel: what the piece of each shows at a place."""
    seen: Counter[tuple] = Counter()
    for i, y in enumerate(places[0].tolist()):
        for j, x in enumerate(places[1].tolist()):
            v = int(variant[i, j])
            if v == HOLE:
                continue
            first = [int(yx[i, j, k]) - (y, x)[k] + at[k] for k in (0, 1)]
            if v == 1:
                first = [f % n for f, n in zip(first, SIZES[1], strict=True)]
            seen[(v, *first)] += 1
    return sorted(seen, key=lambda piece: (-seen[piece], piece))


@pytest.mark.parametrize("seed", range(8))
def test_pieces_about_a_window_equal_their_plain_form(seed: int) -> None:
    """Of drawn maps with holes, seen at every px and at every third, the first of equally large pieces first."""
    rng = np.random.default_rng(seed)
    h, w, step = (int(n) for n in rng.integers(1, 9, 3))
    variant = rng.choice(np.array([0, 1, HOLE], np.uint8), (h, w), p=(0.5, 0.4, 0.1))
    yx = rng.integers(0, 4, (h, w, 2)).astype(np.int32)
    places = tuple(int(rng.integers(-5, 5)) + step * np.arange(n) for n in (h, w))
    table = np.array([[0, *SIZES[0], 9], [0, *SIZES[1], 6]], np.int64)
    at = (int(rng.integers(-3, 9)), int(rng.integers(-3, 9)))
    found = shifts_around(variant, yx, places, at, table, np.array([False, True]))
    assert found == naive_shifts(variant, yx, places, at)


def test_holes_alone_hold_no_piece() -> None:
    nothing = np.full((3, 3), HOLE, np.uint8)
    table, places = np.array([[0, 4, 4, 4]], np.int64), (np.arange(3), np.arange(3))
    assert shifts_around(nothing, np.zeros((3, 3, 2), np.int32), places, (0, 0), table, np.zeros(1, bool)) == []


def sewing_of(wrap: Wrap, toroidal: bool = False) -> graphcut.GraphcutGrowth:
    """Two pieces side by side, the right one out of step by four columns."""
    e = Exemplar.of(texture(60, 60, 1, 4), toroidal=toroidal)
    growth = Growth(PatchSettings((16, 16), (6, 6)), [e], Canvas(48, 48, wrap))
    work = growth.growing
    work.variant[:] = 0
    work.yx[:] = np.moveaxis(np.indices((48, 48)), 0, 2)
    work.yx[:, 30:, 1] += 4
    return graphcut.GraphcutGrowth(growth, graphcut.GraphcutSettings(usage=0.0, margin=4))


@pytest.mark.parametrize("wrap", [Wrap.NONE, Wrap.BOTH])
def test_the_pieces_of_a_window_are_told_by_its_first_pixel(wrap: Wrap) -> None:
    """Both pieces of a map of two, wherever the window lies; over a border that wraps they are other pieces."""
    sewing = sewing_of(wrap)
    assert sewing.shown((10, 8, 16, 16)) == [(0, 10, 8)]
    assert set(sewing.shown((10, 22, 16, 16))) == {(0, 10, 22), (0, 10, 26)}
    at_the_end = set(sewing.shown((40 if wrap is Wrap.BOTH else 32, 10, 16, 16)))
    assert at_the_end == ({(0, 40, 10), (0, -8, 10)} if wrap is Wrap.BOTH else {(0, 32, 10)})


def test_a_piece_grows_over_its_neighbour_where_nothing_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without any candidate of the search one of two pieces takes what the other leaves, and never makes it dearer."""
    falls = {}
    for tries in (2, 6):
        sewing = sewing_of(Wrap.NONE)
        monkeypatch.setattr(graphcut, "TRIES", tries)
        monkeypatch.setattr(sewing, "placements", lambda *_: [])
        before = sewing.total
        saved = improve.refine(sewing, 1, 2, Run(1), 40)
        assert sewing.total == before - sum(saved)
        falls[tries] = len(saved)
    assert falls[2] == 0  # a third of two placements is none
    assert falls[6] > 0


def test_a_third_of_the_placements_for_a_bad_place_lie_about_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """The largest pieces first, then as many drawn ones as there is room for; empty windows take drawn ones alone."""
    monkeypatch.setattr(graphcut, "TRIES", 6)
    sewing, tried = sewing_of(Wrap.NONE), list[tuple[int, int, int]]()
    drawn = [(0, k, k) for k in range(6)]
    monkeypatch.setattr(sewing, "placements", lambda *_: drawn)
    monkeypatch.setattr(sewing, "best", lambda box, picks, limit: tried.extend(picks))
    box = (10, 22, 16, 16)
    sewing.cheapest(box, sewing.found([box], Run(1))[0], 1, filling=False)
    assert tried == [*sewing.shown(box), *drawn[:4]]
    tried.clear()
    sewing.cheapest(box, sewing.found([box], Run(1))[0], 1, filling=True)
    assert tried == drawn
