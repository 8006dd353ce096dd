"""What is grown is not the exemplar over and over, though nothing costs less where its borders meet."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import intarsia as ia
from intarsia.foundation.geometry import Wrap
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import HOLE
from intarsia.patches.patch_synthesis import PatchSettings, PatchSynthesis
from intarsia.seams import placement_kernels
from intarsia.seams.graphcut_textures import TORUS_TOLERANCE, GraphcutMap, GraphcutSettings
from intarsia.search import Candidates
from intarsia.testing import texture

SIDE = 48


def meeting(seed: int) -> np.ndarray:
    """Blobs that go on around all four borders, (SIDE, SIDE) of 0 to 255."""
    dice = np.random.default_rng(seed)
    waves = np.fft.rfft2(dice.normal(size=(SIDE, SIDE)))
    y, x = np.fft.fftfreq(SIDE)[:, None], np.fft.rfftfreq(SIDE)
    blobs = np.fft.irfft2(waves * np.exp(-((y**2 + x**2) / (2 * 0.08**2))), (SIDE, SIDE))
    return np.clip(128 + 45 * blobs / blobs.std(), 0, 255).astype(np.uint8)


def sewing_of(toroidal: bool, wrap: Wrap = Wrap.NONE, size: tuple[int, int] = (110, 130)) -> GraphcutMap:
    """An empty map of two exemplars, one of them turned, too."""
    exemplars = [Exemplar.of(meeting(1), toroidal=toroidal), Exemplar.of(meeting(2)[:30], toroidal=toroidal)]
    growth = PatchSynthesis(PatchSettings((14, 17), (4, 4), isometries=(0, 4)), exemplars, Canvas(*size, wrap))
    return GraphcutMap(growth, GraphcutSettings(margin=5))


def again(sewing: GraphcutMap, box: tuple[int, int, int, int], row: tuple[int, ...]) -> int:
    """Whether in any place of nine, and in any way around it, an exemplar away the same is shown."""
    (top, left, h, w), (_, v, u, s), found = box, row, False
    size = sewing.variants.table[v, 1:3].tolist()
    for a, b, p, q in product((-1, 0, 1), repeat=4):
        i, j = h // 2 + a * (h // 3), w // 2 + b * (w // 3)
        at = [top + i + p * size[0], left + j + q * size[1]]
        inside = all(wrap or 0 <= n < m for n, m, wrap in zip(at, sewing.variant.shape, sewing.wraps, strict=True))
        y, x = (n % m for n, m in zip(at, sewing.variant.shape, strict=True))
        moved = [abs((n + m // 2) % m - m // 2) if wrap else abs(n)
                 for n, m, wrap in zip((p * size[0], q * size[1]), sewing.variant.shape, sewing.wraps, strict=True)]
        if not inside or sewing.variant[y, x] != v or (moved[0] < h and moved[1] < w):  # it goes on there
            continue
        gaps = [abs(int(n) - m) for n, m in zip(sewing.yx[y, x], (u + i, s + j), strict=True)]
        if sewing.variants.toroidal[v]:
            gaps = [min(g % n, -g % n) for g, n in zip(gaps, size, strict=True)]
        found |= max(gaps) <= TORUS_TOLERANCE
    return int(found)


@pytest.mark.parametrize("wrap", [Wrap.NONE, Wrap.X, Wrap.BOTH])
@pytest.mark.parametrize("toroidal", [False, True])
@pytest.mark.parametrize("size", [96, 50])
def test_what_is_shown_an_exemplar_away_is_found_as_by_the_twin(toroidal: bool, wrap: Wrap, size: int) -> None:
    sewing, dice = sewing_of(toroidal, wrap, (size, 96)), np.random.default_rng(3)
    sewing.variant[:] = dice.integers(0, 2, (8, 1, 8, 1)).repeat(12, 1).repeat(12, 3).reshape(96, 96)[:size]
    offsets = dice.integers(-2, 3, (8, 1, 8, 1, 2)).repeat(12, 1).repeat(12, 3).reshape(96, 96, 2)[:size]
    plain = np.moveaxis(np.indices((size, 96)), 0, 2)
    sewing.yx[:] = (plain + offsets) % sewing.variants.table[sewing.variant, 1:3]
    sewing.variant[dice.random((size, 96)) < 0.1] = HOLE
    counts = []
    for box in ((0, 0, 14, 17), (30, 60, 14, 17), (20, 40, 20, 12)):
        rows = np.array([(0, v, (box[0] + a) % SIDE, (box[1] + b) % SIDE)
                         for v in (0, 1) for a in (-4, 0, 3) for b in (-3, 1, 4)], np.int64)  # fmt: skip
        out = np.empty(len(rows), np.int64)
        placement_kernels.repeats_whole_exemplar(sewing.grown, sewing.pieces, box, rows, TORUS_TOLERANCE, out)
        assert out.tolist() == [again(sewing, box, tuple(row)) for row in rows.tolist()]
        counts += out.tolist()
    assert min(counts) == 0 < max(counts)


def shown_again(smap: ia.SourceMap) -> float:
    """What share of pixels shows what is shown one exemplar below, or beside."""
    return float(max((smap.yx[SIDE:] == smap.yx[:-SIDE]).all(axis=2).mean(),
                     (smap.yx[:, SIDE:] == smap.yx[:, :-SIDE]).all(axis=2).mean()))  # fmt: skip


@pytest.mark.parametrize("seed", range(3))
def test_a_torus_is_not_laid_side_by_side(seed: int) -> None:
    """Where it meets itself nothing would cost less than to go on for ever."""
    e = Exemplar.of(meeting(seed), toroidal=True)
    smap = ia.synthesize(e, 3 * SIDE, ia.Graphcut(patch=16), seed=seed).map
    assert shown_again(smap) < 0.2


def test_a_window_is_filled_where_nothing_else_is_there() -> None:
    sewing, box = sewing_of(True), (SIDE, SIDE, 14, 17)
    sewing.variant[:SIDE, :SIDE], sewing.yx[:SIDE, :SIDE] = 0, np.moveaxis(np.indices((SIDE, SIDE)), 0, 2)
    found = Candidates(np.array([(0, 0, 0, 0)], np.int64), 100, np.empty(0), np.ones((14, 17), bool))
    assert not sewing.apart(box, found.rows)[0]
    assert sewing.placements(box, found, 7, 12) == [(0, 0, 0)]


@pytest.mark.parametrize("n", [10, 40, 60])
def test_a_window_of_a_torus_grows_to_the_whole_of_it_at_most(n: int) -> None:
    """Or stays as large as it is."""
    sewing = sewing_of(True)
    (windows,), (patch,) = sewing.windows((40, 40, n, n), [(0, 5, 7)], 40)
    y, x, h, w, up, left, *target = windows.tolist()
    assert (h, w) == (max(n, SIDE), max(n, SIDE))
    assert (y + up, x + left, *target) == (40, 40, n, n)
    assert patch.tolist() == [0, 5 - up, 7 - left]


@pytest.mark.parametrize("size", [(94, 94), (98, 98), (96, 200)])
def test_around_a_canvas_as_large_as_the_exemplar_pieces_go_on(size: tuple[int, int]) -> None:
    """What lies one exemplar away lies beside itself there: seams may cost a tenth more than on one 10 px larger."""
    e, cost = Exemplar.of(texture(96, 96, 3, 4)), []
    for more in (0, 10):
        made = ia.synthesize(e, (size[0] + more, size[1] + more), ia.Graphcut(patch=24), seed=2, wrap="both")
        cost.append(made.energy)
    assert cost[0] < 1.1 * cost[1]


def test_with_nothing_else_left_what_is_no_mirror_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    sewing, box = sewing_of(True), (SIDE, SIDE, 14, 17)
    sewing.variant[:SIDE, :SIDE], sewing.yx[:SIDE, :SIDE] = 0, np.moveaxis(np.indices((SIDE, SIDE)), 0, 2)
    monkeypatch.setattr(sewing, "_unmirrored", lambda box, rows: rows[:, 1] == 0)
    found = Candidates(np.array([(0, 1, 5, 5), (5, 0, 0, 0)], np.int64), 100, np.empty(0), np.ones((14, 17), bool))
    assert not sewing.apart(box, found.rows).any()
    assert sewing.placements(box, found, 7, 12) == [(0, 0, 0)]
