"""Patches in step: where they may lie, and that they lie nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

import intarsia as ia
from intarsia import lattice
from intarsia.foundation.geometry import Wrap
from intarsia.methods import keeps_lattice
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import HOLE, SourceMap
from intarsia.patches.patch_synthesis import PatchSynthesis
from intarsia.seams import graphcut_textures, lattice_alignment
from intarsia.seams.graphcut_textures import Piece
from intarsia.seams.graphcut_synthesis import settings_of, stitch_of
from intarsia.seams.graphcut_moves import ExpansionMove, fill
from intarsia.testing import texture

from .naive_steps import in_step

LATTICE = ((31.25, 1.5), (-2.0, 35.75))
VECTORS = ((384, 3392), (4544, -512))


def off(smap: SourceMap, first: tuple[int, int] | None = None, stretch: np.ndarray | None = None) -> np.ndarray:
    """How far, px, every pixel lies off the steps from the first, or from where the canvas's first one would be.

    `stretch`: where a px of the canvas, down and across, leads in the exemplar, by rows.
    """
    away = smap.yx - np.moveaxis(np.indices(smap.yx.shape[:2]), 0, 2) @ (np.eye(2) if stretch is None else stretch)
    away -= away[0, 0].copy() if first is None else first
    steps_of = np.array([(y, x) for x, y in LATTICE])
    least = np.full(away.shape[:2], np.inf)
    nearest = np.rint(away @ np.linalg.inv(steps_of))
    for m in (-1, 0, 1):
        for n in (-1, 0, 1):
            least = np.minimum(least, np.abs(away - (nearest + np.array((m, n))) @ steps_of).max(axis=2))
    return least


@pytest.mark.parametrize("seed", range(12))
def test_places_in_step_are_those_of_the_plain_twin(seed: int) -> None:
    dice = np.random.default_rng(seed)
    vectors = [(int(dice.integers(256, 6000)), int(dice.integers(-900, 900))),
               (int(dice.integers(-900, 900)), int(dice.integers(1024, 6000)))]  # fmt: skip
    valid = dice.random((int(dice.integers(1, 40)), int(dice.integers(1, 40)))) < 0.8
    place = int(dice.integers(-90, 90)), int(dice.integers(-90, 90))
    slack = int(dice.integers(0, 4))
    first, second = vectors[:: 1 if seed % 2 else -1]
    found = lattice_alignment.aligned(valid, (first, second), place, slack)
    assert (found == in_step(valid, (first, second), place, slack)).all()
    assert found.any() == valid.any()
    assert not (found & ~valid).any()


def test_a_place_is_in_step_with_itself_and_with_nothing_between() -> None:
    valid = np.ones((40, 40), bool)
    found = lattice_alignment.aligned(valid, VECTORS, (20, 20), 0)
    assert found[20, 20]
    assert abs(found.sum() - 40 * 40 * 65536 / (4544 * 3392 + 384 * 512)) < 4


def test_where_nothing_is_in_step_the_slack_grows() -> None:
    found = lattice_alignment.aligned(np.ones((2, 2), bool), VECTORS, (9, 8), 1)
    assert found.any()


@pytest.mark.parametrize("seed", [1, 2])
def test_all_of_a_picture_is_in_step_with_its_first_pixel(seed: int) -> None:
    exemplar = Exemplar.of(texture(72, 80))
    made = ia.synthesize(exemplar, (150, 130), ia.Graphcut(patch=30, lattice=LATTICE), seed=seed)
    assert off(made.map).max() <= 2 * lattice_alignment.SLACK + 1  # the first patch, too, may be off by its rounding
    away = made.map.yx - np.moveaxis(np.indices((150, 130)), 0, 2)
    assert len(np.unique(away.reshape(-1, 2), axis=0)) > 5
    free = ia.synthesize(exemplar, (150, 130), ia.Graphcut(patch=30), seed=seed)
    assert off(free.map).max() > 2 * lattice_alignment.SLACK + 1


@pytest.mark.parametrize("pitch", [(0.0, 13.25), (17.5, -2.0)])
def test_patches_of_rows_lie_whole_pitches_apart_and_anywhere_along(pitch: tuple[float, float]) -> None:
    method = ia.Graphcut(patch=30, lattice=(pitch,), refinements=0)  # all pieces that are laid
    made = ia.synthesize(Exemplar.of(texture(72, 80)), (150, 130), method, seed=4)
    away = made.map.yx - np.moveaxis(np.indices((150, 130)), 0, 2)
    away -= away[0, 0].copy()
    (x, y), length = pitch, np.hypot(*pitch)
    across, along = (away @ np.array(v) / length for v in ((y, x), (-x, y)))
    assert np.abs(across - np.rint(across / length) * length).max() <= 2 * lattice_alignment.STRAIGHT + 2
    assert len(np.unique(np.rint(along) % 28)) > 12  # by steps of 28 px, give or take 3, it would be nine at most


@pytest.mark.parametrize("second", [False, True])
def test_across_rows_of_one_vector_patches_give_way_less(second: bool) -> None:
    """That a gap between boards jogs by 3 px is seen; threads that cross have nowhere else to go."""
    lattice, slack = (
        (((0.0, 20.0),), lattice_alignment.STRAIGHT)
        if not second
        else (((0.0, 20.0), (20.0, 0.0)), lattice_alignment.SLACK)
    )
    method = ia.Graphcut(patch=30, overlap=10, overreach=10, lattice=lattice)
    growth = PatchSynthesis(settings_of(method), [Exemplar.of(texture(72, 80))], Canvas(90, 90))
    sewing = graphcut_textures.GraphcutMap(growth, stitch_of(method))
    sewing.first = (10, 12), (0, 0)
    (allowed,) = sewing._allowed((0, 0))
    down, across = ((np.argwhere(allowed) - (10, 12) + 10) % 20 - 10).T.tolist()
    assert set(down) == set(range(-slack, slack + 1))
    assert set(across) == (set(range(-slack, slack + 1)) if second else set(range(-10, 10)))


@pytest.mark.parametrize("seed", range(8))
def test_every_px_of_the_canvas_leads_as_far_as_every_other(seed: int) -> None:
    dice = np.random.default_rng(seed)
    around, shape = dice.integers(-9000, 60000, (2, 2)).tolist(), dice.integers(40, 300, 2).tolist()
    first = tuple(map(tuple, dice.integers(0, 40, (2, 2)).tolist()))
    for at in dice.integers(0, 400, (20, 2)).tolist():
        exact = np.array(first[0]) + ((np.array(at) - first[1]) / shape) @ np.array(around) / 256
        assert np.abs(lattice_alignment.aligned_place(around, first, at, shape) - exact).max() <= 1
    for axis, n in enumerate(shape):
        once = lattice_alignment.aligned_place(around, ((0, 0), (0, 0)), (n * (1 - axis), n * axis), shape)
        assert np.abs(once - np.array(around[axis]) / 256).max() <= 0.5


@pytest.mark.parametrize("wrap", ["x", "y", "both"])
def test_on_a_canvas_that_wraps_all_is_in_step_with_a_lattice_that_closes(wrap: str) -> None:
    exemplar, shape, stretch = Exemplar.of(texture(120, 130)), (150, 130), np.eye(2)
    method = ia.Graphcut(  # steps alone, at no other price, of patches that reach little further than their windows
        patch=30, overlap=15, overreach=5, lattice=LATTICE, evenness=0.0
    )
    vectors = tuple((round(256 * y), round(256 * x)) for x, y in LATTICE)
    made = [ia.synthesize(exemplar, shape, method, seed=seed, wrap=wrap).map for seed in (6, 7, 8)]
    for axis, known in enumerate((wrap != "x", wrap != "y")):
        if known:
            stretch[axis] = np.array(lattice.closing_vector(vectors, shape[axis], axis)) / (256 * shape[axis])
    within = np.abs(stretch - np.eye(2)).max() * 35  # what a patch, which is not stretched, is off where it ends
    most = 2 * lattice_alignment.SLACK + 1.5 + within  # what shows the first pixel may be off, too
    stretched, plain = np.stack([[off(one, stretch=stretch), off(one)] for one in made], axis=1)
    assert stretched.max() <= most
    assert stretched.mean() < 0.9 * plain.mean()


def test_on_a_canvas_that_wraps_no_piece_goes_on_by_itself() -> None:
    """As it lies in the exemplar, not stretched, but by a third of a patch; on others it keeps to the lattice."""
    exemplar, found = Exemplar.of(texture(120, 130)), []
    for wrap in ("none", "both"):
        canvas = Canvas(150, 130, wrap=Wrap(wrap))
        method = ia.Graphcut(patch=30, lattice=LATTICE).resolved([exemplar], canvas)
        sewn = graphcut_textures.GraphcutMap(PatchSynthesis(settings_of(method), [exemplar], canvas), stitch_of(method))
        fill(sewn, 3, 7, ia.Run(1))
        piece = Piece((60, 50, 80, 70), (0, 0, 0))
        found.append((len(sewn.shown((60, 50, 30, 30))), ExpansionMove(sewn).reach(piece)))
    assert found[0][0] > 1
    assert [reach for _, reach in found] == [53, 10]
    assert found[1][0] == 0


def test_what_is_there_is_gone_on_with_in_step() -> None:
    exemplar = Exemplar.of(texture(72, 80))
    yx, which = np.zeros((60, 110, 2), np.int32), np.full((60, 110), HOLE, np.uint8)
    there = np.s_[2:8, 2:8]  # the last corner of the exemplar: no patch goes on with it as it does itself
    yx[there], which[there] = np.moveaxis(np.indices((6, 6)), 0, 2) + np.array((66, 74)), 0
    start = SourceMap(yx, which, None, (exemplar.source,))
    made = ia.synthesize(exemplar, method=ia.Graphcut(patch=30, lattice=LATTICE), seed=1, start=start)
    assert off(made.map, (64, 72)).max() <= lattice_alignment.SLACK + 1


@pytest.mark.parametrize(
    ("given", "canvas", "said"),
    [
        ({"isometries": "180"}, Canvas(90, 90), "isometries=180"),
        ({"lattice": ((0.0, 13.0), (70.0, 0.0))}, Canvas(90, 90), "no patch of 16 px"),
    ],
)
def test_what_does_not_go_with_steps_is_refused(given: dict[str, object], canvas: Canvas, said: str) -> None:
    exemplar = Exemplar.of(texture(72, 80))
    with pytest.raises(ia.ParameterError, match=said):
        ia.Graphcut(**{"lattice": LATTICE, **given}).resolved([exemplar], canvas)  # type: ignore[arg-type]


def test_several_exemplars_have_no_steps_together() -> None:
    exemplars = [Exemplar.of(texture(72, 80, s)) for s in (1, 2)]
    with pytest.raises(ia.ParameterError, match="several exemplars"):
        ia.Graphcut(lattice=LATTICE).resolved(exemplars, Canvas(90, 90))


def test_windows_leave_room_for_a_period() -> None:
    exemplar = Exemplar.of(texture(72, 80))
    assert ia.Graphcut(lattice=((40.0, 0.0), (3.0, 50.0))).resolved([exemplar], Canvas(90, 90)).patch <= 22


def test_a_lattice_is_kept_only_where_it_is_given() -> None:
    assert keeps_lattice(ia.Graphcut(lattice=LATTICE))
    assert not keeps_lattice(ia.Graphcut())
