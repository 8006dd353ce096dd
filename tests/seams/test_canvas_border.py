"""Where the canvas ends the exemplar's border is among what is tried, and is shown there."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from seams.sewing import empty_of as empty

import intarsia as ia
from intarsia.foundation.geometry import Wrap
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.seams import canvas_border, graphcut_moves, graphcut_textures
from intarsia.seams.graphcut_moves import Place, PlacementMove, fill
from intarsia.testing import texture

ONE = ia.Run(1)


@pytest.mark.parametrize(("wrap", "size"), [(Wrap.NONE, (90, 80)), (Wrap.X, (90, 80)), (Wrap.NONE, (90, 65))])
def test_ends_are_those_of_canvases_half_as_long_again(wrap: Wrap, size: tuple[int, int]) -> None:
    sewn = empty([Exemplar.of(texture(40, 44, 3, 1)), Exemplar.of(texture(60, 30, 3, 2))], Canvas(*size, wrap))
    seen = set()
    for y, x in product(range(size[0] - 15), range(size[1] - 15)):
        column = -1 if x == 0 else 1 if x == size[1] - 16 else 0
        want = -1 if y == 0 else 1 if y == 74 else 0, column if wrap is Wrap.NONE and size[1] >= 66 else 0
        assert canvas_border.sides_of(sewn, (y, x, 16, 16)) == want
        seen.add(want)
    assert len(seen) == (9 if wrap is Wrap.NONE and size[1] == 80 else 3)
    assert canvas_border.sides_of(sewn, (0, 20, 90, 16))[0] == 0  # all of it


@pytest.mark.parametrize("sides", list(product((-1, 0, 1), repeat=2)))
def test_what_ends_there_is_kept_and_nothing_of_a_torus(sides: tuple[int, int]) -> None:
    valid = [np.random.default_rng(n).random((9, 7)) < 0.7 for n in (1, 2)]
    kept, none = canvas_border.at_border(valid, np.array([False, True]), sides)
    for y, x in product(range(9), range(7)):
        axes = zip(sides, (y, x), (8, 6), strict=True)
        ends = all(side == 0 or at == (0 if side < 0 else last) for side, at, last in axes)
        assert kept[y, x] == (valid[0][y, x] and ends)
    assert not none.any()


def test_candidates_end_as_the_canvas_does() -> None:
    e = Exemplar.of(texture(48, 50, 3, 3))
    sewn, canvas = empty([e], Canvas(100, 110)), (100, 110)
    boxes = [(y, x, 16, 16) for y, x in product((0, 40, 84), (0, 50, 94))]
    assert canvas_border.border_candidates(sewn, boxes, ONE) == [None] * 9
    fill(sewn, 3, 7, ONE)
    for box, found in zip(boxes, canvas_border.border_candidates(sewn, boxes, ONE), strict=True):
        sides = canvas_border.sides_of(sewn, box)
        assert (found is None) <= (not any(sides) or all(sides))  # in a corner there is one, which may be barred
        if found is not None:
            assert any(sides)
            assert sewn.apart(box, found.rows).all()
            for k, side in enumerate(sides):
                if side:
                    assert (found.rows[:, 2 + k] == (0 if side < 0 else e.free.shape[k] - 16)).all()
                    assert box[k] == (0 if side < 0 else canvas[k] - 16)


def test_a_third_of_what_is_drawn_where_the_canvas_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    sewn, tried = empty([Exemplar.of(texture(48, 50, 3, 4))], Canvas(100, 110)), list[list[tuple[int, ...]]]()
    fill(sewn, 3, 7, ONE)
    monkeypatch.setattr(graphcut_textures, "RANDOMNESS", 1.0)
    monkeypatch.setattr(sewn, "best", lambda box, picks: tried.append(picks))
    work, places = PlacementMove(sewn), [Place((0, 50, 16, 16), 9), Place((40, 50, 16, 16), 9)]
    work.even = True
    for place, found in zip(places, work.found(places, ONE), strict=True):
        work.best(place, found)
    edge, inner = tried
    assert len(edge) == 12
    assert all(pick[1] == 0 for pick in edge[8:])
    assert sum(pick[1] == 0 for pick in edge[:8]) < 8
    assert sum(pick[1] == 0 for pick in inner) < 6


def test_only_where_use_costs_and_nothing_was_there() -> None:
    e, lattice = Exemplar.of(texture(48, 50, 3, 5)), ((14.0, 0.0), (0.0, 12.0))
    assert PlacementMove(empty([e], Canvas(100, 100))).even
    assert not PlacementMove(empty([e], Canvas(100, 100), evenness=0)).even
    assert not PlacementMove(empty([e], Canvas(100, 100), lattice=lattice)).even
    full = ia.synthesize(e, (100, 100), ia.Graphcut(patch=16), seed=1).map
    assert not PlacementMove(empty([e], Canvas(100, 100, start=full))).even


def test_the_exemplar_is_used_to_its_border(monkeypatch: pytest.MonkeyPatch) -> None:
    """At four times the area: without, half as much again is never shown, and the outermost px half as often."""
    never, outer = [], []
    for _ in range(2):
        counts = [ia.synthesize(ia.read(f"sample:{name}"), 512, seed=seed).map.usage()[0]
                  for name, seed in (("pebbles", 1), ("pebbles", 2))]  # fmt: skip
        never.append(np.mean([(c == 0).mean() for c in counts]))
        outer.append(np.mean([c[:8].mean() + c[-8:].mean() + c[:, :8].mean() + c[:, -8:].mean() for c in counts]))
        monkeypatch.setattr(graphcut_moves, "border_candidates", lambda sewn, boxes, run: [None] * len(boxes))
    assert never[0] < 0.09 < never[1], never
    assert outer[0] > 1.3 * outer[1], outer
