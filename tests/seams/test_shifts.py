"""Pieces of a map: which it shows, how they grow, and that bad places are covered by them, too."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest

import intarsia as ia
from intarsia.foundation.geometry import Wrap
from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import HOLE
from intarsia.patches.patch_synthesis import PatchSettings, PatchSynthesis
from intarsia.seams import graphcut_textures, graphcut_moves
from intarsia.seams.graphcut_textures import NOTHING, Cut, Piece, pieces_in
from intarsia.seams.repair import Repair, SeamRefinement
from intarsia.testing import texture


def naive_pieces(variant: np.ndarray, yx: np.ndarray) -> list[Piece]:
    """Pixel by pixel: where each piece lies, and what it shows at the first pixel of the box around it."""
    seen = defaultdict[tuple[int, int, int], list[tuple[int, int]]](list)
    for y, x in np.argwhere(variant != HOLE).tolist():
        seen[int(variant[y, x]), y - int(yx[y, x, 0]), x - int(yx[y, x, 1])].append((y, x))
    out = []
    for v, down, right in sorted(seen, key=lambda piece: (-len(seen[piece]), piece)):
        (top, left), (bottom, end) = np.min(seen[v, down, right], axis=0), np.max(seen[v, down, right], axis=0)
        box = int(top), int(left), int(bottom - top) + 1, int(end - left) + 1
        out.append(Piece(box, (v, int(top) - down, int(left) - right)))
    return out


@pytest.mark.parametrize("seed", range(8))
def test_pieces_equal_their_plain_form(seed: int) -> None:
    """Of drawn maps with holes, the largest first, the first of equally large ones first; small ones left out."""
    rng = np.random.default_rng(seed)
    h, w = (int(n) for n in rng.integers(1, 9, 2))
    variant = rng.choice(np.array([0, 1, HOLE], np.uint8), (h, w), p=(0.5, 0.4, 0.1))
    yx = rng.integers(0, 4, (h, w, 2)).astype(np.int32)
    naive = naive_pieces(variant, yx)
    assert pieces_in(variant, yx) == naive
    count = [sum(variant[y, x] == v and (yx[y, x] == (y - t + r, x - left + c)).all() for y, x in np.ndindex(h, w))
             for (t, left, _, _), (v, r, c) in naive]  # fmt: skip
    assert pieces_in(variant, yx, 2) == [piece for piece, n in zip(naive, count, strict=True) if n > 1]


def test_holes_alone_hold_no_piece() -> None:
    assert pieces_in(np.full((3, 3), HOLE, np.uint8), np.zeros((3, 3, 2), np.int32)) == []


def sewing_of(wrap: Wrap, toroidal: bool = False) -> graphcut_textures.GraphcutMap:
    """Two pieces side by side, the right one out of step by four columns."""
    e = Exemplar.of(texture(60, 60, 1, 4), toroidal=toroidal)
    growth = PatchSynthesis(PatchSettings((16, 16), (6, 6)), [e], Canvas(48, 48, wrap))
    work = growth.growing
    work.variant[:] = 0
    work.yx[:] = np.moveaxis(np.indices((48, 48)), 0, 2)
    work.yx[:, 30:, 1] += 4
    return graphcut_textures.GraphcutMap(growth, graphcut_textures.GraphcutSettings(usage=0.0, margin=4))


@pytest.mark.parametrize("wrap", [Wrap.NONE, Wrap.BOTH])
def test_the_pieces_of_a_window_are_told_by_its_first_pixel(wrap: Wrap) -> None:
    """Both pieces of a map of two, wherever the window lies; over a border that wraps they are other pieces."""
    sewing = sewing_of(wrap)
    assert sewing.shown((10, 8, 16, 16)) == [(0, 10, 8)]
    assert set(sewing.shown((10, 22, 16, 16))) == {(0, 10, 22), (0, 10, 26)}
    at_the_end = set(sewing.shown((40 if wrap is Wrap.BOTH else 32, 10, 16, 16)))
    assert at_the_end == ({(0, 40, 10), (0, -8, 10)} if wrap is Wrap.BOTH else {(0, 32, 10)})


def test_a_piece_grows_over_its_neighbour() -> None:
    """One of two pieces takes what the other leaves, and never makes the map dearer."""
    sewing = sewing_of(Wrap.NONE)
    before = sewing.total
    saved = graphcut_moves.expand(sewing, Run(1), 1)
    assert saved
    assert min(saved) > 0
    assert sewing.total == before - sum(saved)


def test_a_piece_grows_two_thirds_as_far_as_it_is_long_up_to_two_patches() -> None:
    work = graphcut_moves.ExpansionMove(sewing_of(Wrap.NONE))
    reach = [work.reach(Piece((3, 3, *size), (0, 0, 0))) for size in ((5, 9), (31, 4), (48, 32), (70, 7))]
    assert reach == [6, 20, 32, 32]


def test_pieces_below_a_quarter_of_a_patch_do_not_grow(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two squares in the middle of a piece, of 63 and 64 px where a patch has 256."""
    sewing, grown = sewing_of(Wrap.NONE), list[tuple[int, int, int, int]]()
    sewing.yx[2:9, 2:11, 0] += 7
    sewing.yx[20:28, 2:10, 0] += 9
    monkeypatch.setattr(sewing, "cut", lambda box, *_, **__: grown.append(box) or Cut(0, box, (0, 0, 0), NOTHING))
    graphcut_moves.expand(sewing, Run(1), 1)
    assert sorted(grown) == [(0, 0, 48, 30), (0, 30, 48, 18), (20, 2, 8, 8)]


def test_a_third_of_the_placements_for_a_bad_place_lie_about_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """The largest pieces first, then as many of those found as there is room for."""
    e = Exemplar.of(texture(60, 60, 1, 4))
    smap = ia.synthesize(e, (48, 48), ia.Graphcut(patch=16, overlap=6), seed=1).map
    work, tried = SeamRefinement(Repair((16, 16), 1), [e], Canvas(48, 48), smap), list[tuple[int, int, int]]()
    monkeypatch.setattr(work.sewn, "best", lambda box, picks: tried.extend(picks))
    box = (10, 22, 16, 16)
    (found,) = work.found([box], Run(1))
    assert work.best(box, found) is None
    near = work.sewn.shown(box)
    assert len(near) == graphcut_textures.TRIES // 3
    assert tried[: len(near)] == near
    assert len(tried) == graphcut_textures.TRIES
