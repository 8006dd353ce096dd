"""The loop that lays patches: waves whose windows lie apart, and what is told meanwhile."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from seams.sewing import empty_of

import intarsia as ia
from intarsia.foundation.geometry import Wrap, apart
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import HOLE, SourceMap
from intarsia.patches import window_batches
from intarsia.seams import graphcut_moves
from intarsia.seams.graphcut_textures import Cut, GraphcutMap
from intarsia.testing import texture


def sewing_of(canvas: Canvas) -> GraphcutMap:
    return empty_of([Exemplar.of(texture(60, 64, 3, 5))], canvas, patch=24, overlap=10, refinements=2)


def begun() -> SourceMap:
    """Two islands on an empty canvas."""
    which = np.full((140, 150), HOLE, np.uint8)
    which[20:30, 20:34] = which[100:120, 110:124] = 0
    source = Exemplar.of(texture(60, 64, 3, 5)).source
    return SourceMap(np.moveaxis(np.indices((140, 150), np.int32), 0, 2) % 60, which, None, (source,))


@pytest.mark.parametrize("wrap", list(Wrap))
@pytest.mark.parametrize("start", [None, begun()])
def test_what_a_window_reads_no_other_of_its_wave_changes(wrap: Wrap, start: SourceMap | None) -> None:
    canvas = Canvas(140, 150, wrap, start)
    sewn = sewing_of(canvas)
    layout, seen = sewn.growth.layout, 0
    for wave in window_batches(layout, sewn.growth.windows, sewn.around):
        for one, other in combinations([sewn.growth.at(window) for window in wave], 2):
            gaps = map(apart, one, other, (140, 150), sewn.wraps)
            assert any(gap >= side + sewn.around for gap, side in zip(gaps, layout.patch, strict=True))
            seen += 1
    assert seen


class Watched:
    """Sites 0 to 9, of which the odd ones pay."""

    def __init__(self) -> None:
        self.left, self.laid, self.asked, self.told = list[int](), list[int](), list[list[int]](), list[int]()
        self.sewn = self

    def found(self, sites: list[int], run: ia.Run) -> list[int]:
        self.asked.append(sites)
        return [10 * site for site in sites]

    def best(self, site: int, found: int) -> Cut | None:
        assert found == 10 * site
        assert not self.laid, "all are cut before the first is laid"
        return Cut(-1, (site, 0, 1, 1), (0, 0, 0), np.ones((1, 1))) if site % 2 else None

    def write(self, cut: Cut) -> None:
        assert not self.told, "all are laid before the first is measured"
        self.laid.append(cut.box[0])

    def note(self, cut: Cut) -> None:
        self.told.append(cut.box[0])

    def give_up(self, key: str) -> None:
        self.left.append(int(key))


def test_what_is_cut_is_laid_in_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(graphcut_moves, "AT_ONCE", 4)
    work, told = Watched(), list[int]()
    laid = graphcut_moves.apply_moves(work, {str(k): k for k in range(10)}, ia.Run(3), told.append)
    assert [cut.box[0] for cut in laid] == work.laid == sorted(work.told) == [1, 3, 5, 7, 9]
    assert work.left == [0, 2, 4, 6, 8]
    assert work.asked == [[0, 1, 2, 3], [4, 5, 6, 7], [8, 9]]
    assert told == [0, 4, 8]


@pytest.mark.parametrize("wraps", [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize("seed", range(6))
def test_windows_share_the_first_wave_that_has_room(wraps: tuple[bool, bool], seed: int) -> None:
    """Pixel by pixel: no two of a wave have less than three px between them, and each is near one of every earlier."""
    dice, shape = np.random.default_rng(seed), (60, 70)
    windows = np.concatenate([dice.integers(0, 40, (20, 2)), dice.integers(1, 20, (20, 2))], axis=1)
    known = list[list[np.ndarray]]()
    found = graphcut_moves.batches(windows, shape, wraps)
    for k, window in enumerate(windows.tolist()):
        mine, wide = (np.zeros(shape, bool) for _ in range(2))
        for out, more in ((mine, 0), (wide, 3)):
            axes = [np.arange(window[a] - more, window[a] + window[2 + a] + more) for a in (0, 1)]
            axes = [n % m if w else n[(n >= 0) & (n < m)] for n, m, w in zip(axes, shape, wraps, strict=True)]
            out[np.ix_(*axes)] = True
        free = [n for n, wave in enumerate(known) if not any((wide & other).any() for other in wave)]
        if not free:
            known.append([])
        number = free[0] if free else len(known) - 1
        known[number].append(mine)
        assert k in found[number]
    assert sum(map(len, found)) == len(windows)
    assert max(map(len, found)) > 1
    assert graphcut_moves.batches(windows[:0], shape, wraps) == []


def test_pieces_grow_in_waves_of_their_own() -> None:
    sewn, told = sewing_of(Canvas(140, 150)), list[tuple[int, int]]()
    run, windows = ia.Run(1, lambda done, total, draft: told.append((done, total))), int(sewn.growth.windows.sum())
    graphcut_moves.fill(sewn, 1, 2, run, 2)
    assert graphcut_moves.expand(sewn, run, 2, windows, 1)
    assert told == sorted(told)
    assert told[-1] == (3 * windows, 3 * windows)
    assert len(set(told)) > 6
