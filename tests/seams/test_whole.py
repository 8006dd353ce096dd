"""Damaged elements are covered by whole ones, and where there are none nothing happens."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

import intarsia as ia
from intarsia.canvas import Canvas
from intarsia.exemplar import Exemplar
from intarsia.geometry import Wrap, widened
from intarsia.patches.growth import Growth
from intarsia.seams import whole_kernels
from intarsia.seams.graphcut import GraphcutGrowth
from intarsia.seams.improve import fill
from intarsia.seams.sewing import STAGE, settings_of, stitch_of
from intarsia.seams.whole import Elements, Mending, make_whole
from intarsia.segments.wholes import JOINT, wholes
from intarsia.testing import texture

METHOD = ia.Graphcut(patch=48, overlap=16, refinements=6)
ONE = ia.Run(1)


@pytest.fixture(autouse=True)
def few_placements(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two for each window, so that some elements are damaged."""
    monkeypatch.setattr("intarsia.seams.graphcut.TRIES", 2)


def stones(height: int = 180, width: int = 180, seed: int = 2) -> np.ndarray:
    """Discs of many tones and sizes on dark ground, none of which touch."""
    draws, out = np.random.default_rng(seed), np.full((height, width, 3), 30, np.uint8)
    y, x = np.mgrid[:height, :width]
    for a, b in product(range(18, height, 36), range(18, width, 36)):
        radius, tone = draws.integers(14, 17), draws.integers(90, 250, 3)
        dy, dx = draws.integers(-1, 2, 2)
        out[(y - a - dy) ** 2 + (x - b - dx) ** 2 <= radius**2] = tone
    return out


EXEMPLAR = Exemplar.of(stones())


def grown(exemplar: Exemplar = EXEMPLAR, canvas: Canvas | None = None, seed: int = 1) -> GraphcutGrowth:
    canvas = canvas or Canvas(200, 190)
    method = METHOD.resolved([exemplar], canvas)
    growth = Growth(settings_of(method), [exemplar], canvas)
    sewn = GraphcutGrowth(growth, stitch_of(method))
    fill(sewn, seed, STAGE, ONE)
    return sewn


def mending(sewn: GraphcutGrowth) -> Mending:
    found = wholes(EXEMPLAR)
    assert found is not None
    return Mending(sewn, Elements(sewn.variants, [found]))


def shown_damage(work: Mending) -> float:
    """What elements that show in part add up to, told pixel by pixel."""
    work.number()
    total = 0.0
    for k in range(1, work.count):
        area, whole = int((work.joined == k).sum()), int(work.shown.whole[k])
        sure = float(work.elements.known[1][work.shown.element[k]])
        total += sure * max(min(2 * area, whole - area), 0) / max(whole, 1) ** 0.5
    return total


def test_discs_are_the_elements() -> None:
    found = wholes(EXEMPLAR)
    assert found is not None
    picture = stones().astype(int)
    bright = picture.sum(axis=2) > 90
    discs, count = ndimage.label(bright)
    for k in range(1, count + 1):  # each is one element, that holds nothing of another
        names = np.bincount(found.labels[discs == k])
        mine = found.labels == int(names.argmax())
        assert names.argmax() > 0
        assert names.max() > 0.9 * names.sum()
        assert (discs[mine & bright] == k).all()
    assert int(found.inside[found.inside < JOINT].max()) <= 64
    assert 0 <= found.sure.min() <= found.sure.max() <= 1


@pytest.mark.parametrize("pixels", [texture(96, 90, 3, 4), np.full((64, 64, 3), 90, np.uint8), stones(24, 24)])
def test_without_elements_nothing_changes(pixels: np.ndarray) -> None:
    exemplar = Exemplar.of(pixels)
    assert wholes(exemplar) is None
    patch = min(32, *(n // 2 for n in pixels.shape[:2]))
    small = ia.Graphcut(patch=patch, overlap=patch // 3, refinements=3)
    plain, more = (ia.synthesize(exemplar, (80, 90), m, seed=1).map for m in (small, ia.Graphcut(
        patch=patch, overlap=patch // 3, refinements=3, whole=3)))  # fmt: skip
    np.testing.assert_array_equal(plain.yx, more.yx)


def test_damage_falls_and_is_told_as_counted() -> None:
    sewn = grown()
    before = shown_damage(mending(sewn))
    assert before > 0
    assert make_whole(sewn, [EXEMPLAR], 2, ONE) > 0
    assert shown_damage(mending(sewn)) < 0.8 * before


def test_numbers_kept_are_those_counted_again() -> None:
    work = mending(grown(seed=3))  # no cut of it splits what it covers, which the numbers do not tell
    work.number()
    laid = 0
    for body, box in work._damaged():
        mine = work.shown.body[work.joined[work.sewn.index(box)]] == body
        if not mine.any():  # covered since
            continue
        for candidate in work._candidates(body, box, mine):
            cut = work._cut(candidate, 1)
            assert cut.box == candidate.box
            before = told_again(work)
            hurt = work._price(candidate._replace(element=0), cut, 1) - cut.change
            work._lay(candidate, cut)
            assert np.isclose(told_again(work) - before, hurt / (3.0 * work.knee), atol=1e-6)
            laid += 1
            break
    assert laid > 3
    np.testing.assert_array_equal(
        np.bincount(work.joined.ravel(), minlength=work.count)[1 : work.count], work.shown.area[1 : work.count]
    )


def told_again(work: Mending) -> float:
    return sum(
        whole_kernels._damage(int(work.shown.area[k]), int(work.shown.whole[k]), float(work.elements.known[1][e]))
        for k, e in enumerate(work.shown.element[: work.count].tolist()) if k
    )  # fmt: skip


@pytest.mark.parametrize("wrap", ["none", "x", "both"])
def test_threads_wraps_and_poses(wrap: str) -> None:
    method = ia.Graphcut(patch=48, overlap=16, refinements=4, whole=2, isometries="both")
    maps = [ia.synthesize(EXEMPLAR, (150, 140), method, seed=5, wrap=wrap, run=ia.Run(n)).map for n in (1, 3)]
    np.testing.assert_array_equal(maps[0].yx, maps[1].yx)
    assert maps[0].yx.min() >= 0
    assert (maps[0].yx < (EXEMPLAR.height, EXEMPLAR.width)).all()


def test_masked_pixels_are_never_shown() -> None:
    usable = np.ones((180, 180), bool)
    usable[60:90, 40:80] = False
    made = ia.synthesize(Exemplar.of(stones(), usable=usable), (150, 140), ia.Graphcut(patch=48, whole=2), seed=5)
    y, x = made.map.yx[..., 0], made.map.yx[..., 1]
    assert usable[y, x].all()


def test_what_the_canvas_starts_with_stays() -> None:
    start: Any = ia.synthesize(EXEMPLAR, (150, 140), METHOD, seed=5).map
    sewn = grown(canvas=Canvas(150, 140), seed=7)
    sewn.variant[:], sewn.yx[:] = 0, start.yx
    sewn.locked[:70] = True
    sewn.note((0, 0, 150, 140))
    make_whole(sewn, [EXEMPLAR], 2, ONE)
    np.testing.assert_array_equal(sewn.yx[:70], start.yx[:70])


@pytest.mark.parametrize(("wrap", "by"), [("both", (90, 70)), ("both", (31, 190)), ("x", (0, 95)), ("y", (101, 0))])
def test_over_borders_that_wrap_elements_are_mended_as_inside(wrap: str, by: tuple[int, int]) -> None:
    """A canvas that wraps has no border: rolled, then mended, it is what is mended, then rolled."""
    canvas = Canvas(200, 190, wrap=Wrap(wrap))
    sewn, rolled = grown(canvas=canvas, seed=3), grown(canvas=canvas, seed=3)
    for mine in (rolled.variant, rolled.yx):
        mine[:] = np.roll(mine, by, (0, 1))
    rolled.note((0, 0, 200, 190))
    one, two = mending(sewn), mending(rolled)
    one.number()
    two.number()
    told = [sorted((prices, one_or_two.size[k]) for prices, k in damaged(one_or_two)) for one_or_two in (one, two)]
    assert told[0] == told[1], "the same are counted"
    over = [box for _, box in two._damaged() if box[0] + box[2] > 200 or box[1] + box[3] > 190]
    assert over, "some lie over a border"
    assert make_whole(sewn, [EXEMPLAR], 2, ONE) == make_whole(rolled, [EXEMPLAR], 2, ONE) > 0
    np.testing.assert_array_equal(np.roll(sewn.yx, by, (0, 1)), rolled.yx)


def damaged(work: Mending) -> list[tuple[int, int]]:
    """What seams about damaged bodies cost, and which they are."""
    around = [(widened(box, 2, (200, 190), work.sewn.wraps), k) for k, box in work._damaged()]
    return [(int(work.sewn.prices[work.sewn.index(box)].sum()), k) for box, k in around]
