"""Striking things are shown so often at most, and apart; nothing else is harmed, and no thread changes a byte."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

import intarsia as ia
from intarsia.canvas import Canvas
from intarsia.exemplar import Exemplar
from intarsia.geometry import Wrap, apart
from intarsia.seams.covering import Laying
from intarsia.seams.striking import APART, LEAST, SEEN, Often, Show, Staying, Thinning, thinned
from intarsia.segments.wholes import things
from intarsia.sourcemap import HOLE, SourceMap
from intarsia.testing import texture

ONE = ia.Run(1)
GRAPHCUT = ia.Graphcut(patch=24, overlap=10, refinements=4, seam="difference", structure=0)


@pytest.fixture(autouse=True)
def few_placements(monkeypatch: pytest.MonkeyPatch) -> None:
    """One for each window: quicker, and more returns."""
    monkeypatch.setattr("intarsia.seams.graphcut.TRIES", 1)


def spotted(height: int = 96, width: int = 90, seed: int = 3) -> np.ndarray:
    """A grainy texture with one thing in it that strikes."""
    pixels = texture(height, width, 3, seed) // 4 + 60
    pixels[40:50, 30:42] = (230, 60, 20)
    return np.asarray(pixels, np.uint8)


def shows(smap: SourceMap, exemplars: list[Exemplar], wrap: str = "none") -> list[tuple[float, float]]:
    """Middles of the showings of the first exemplar's first thing: counted by hand, flooding without borders."""
    labels = things(exemplars[0]).labels
    mine = labels[smap.yx[..., 0], smap.yx[..., 1]] == 1
    if smap.which is not None:
        mine &= smap.which == 0
    out, left = [], {(int(y), int(x)) for y, x in zip(*np.nonzero(mine), strict=True)}
    least = max(int((labels == 1).sum()) * SEEN // 100, LEAST)
    while left:
        open_, part = [left.pop()], []
        while open_:
            y, x = open_.pop()
            part.append((y, x))
            near = {(y + i, x + j) for i in (-1, 0, 1) for j in (-1, 0, 1)} & left
            left -= near
            open_ += near
        if len(part) >= least:
            y, x = np.array(part).T
            out.append(((int(y.min()) + int(y.max()) + 1) / 2, (int(x.min()) + int(x.max()) + 1) / 2))
    return out


@pytest.mark.parametrize(("share", "most"), [(100.0, 900), (1.0, 9), (0.5, 5), (0.1, 1), (0.0, 0)])
def test_a_thing_is_shown_so_often_at_most(share: float, most: int) -> None:
    """9 times the exemplar: as often as area asks, times the share, once at least if it is not 0; a quarter apart."""
    made = ia.synthesize(spotted(), (288, 270), ia.RandomTiling(patch=40), seed=1, run=ONE)
    before = shows(made.map, made.exemplars)
    out = thinned(share, Laying(), made.exemplars, Canvas(288, 270), made.map, ONE)
    after = shows(out, made.exemplars)
    assert len(before) > 16, "more than lie a quarter apart, or nothing is tested"
    assert len(after) <= most
    assert after or not most, "what was shown is not lost"
    apart = min(288, 270) // APART
    assert all((a - c) ** 2 + (b - d) ** 2 >= apart**2 for k, (a, b) in enumerate(after) for c, d in after[:k])
    assert not out.holes.any()


def test_no_patch_may_show_a_thing() -> None:
    """In any pose, and over the border of a torus: what may not be taken is what shows a thing, pixel by pixel."""
    e = Exemplar.of(spotted(), toroidal=True)
    made = ia.synthesize(e, (96, 100), ia.ImageQuilting(patch=20, overlap=6, isometries="both"), seed=2, run=ONE)
    often = Often(0.5, [e], Canvas(96, 100), np.zeros((96, 100), bool))
    work = Thinning(often, Laying(isometries="both"), [e], Canvas(96, 100), made.map, 24)
    any_, picks = False, [(v, *at) for v in range(len(work.growth.variants)) for at in ((30, 20), (40, 80), (85, 30))]
    for pick in picks:
        yx = np.moveaxis(np.indices((24, 24), np.int32), 0, 2) + np.array(pick[1:], np.int32)
        yx = (yx % work.growth.variants.table[pick[0], 1:3]).astype(np.int32)
        at, _, _ = work.growth.variants.to_exemplars(yx, np.full((24, 24), pick[0], np.uint8))
        expected = often.labels[0][at[..., 0], at[..., 1]] > 0
        assert (work._barred((10, 20, 24, 24), pick) == expected).all()
        any_ |= bool(expected.any())
    assert any_, "or nothing is tested"


def test_what_does_not_strike_stays() -> None:
    """Without things the map itself comes back; with them nothing changes far from where one was too many."""
    made = ia.synthesize(np.full((64, 64, 3), 90, np.uint8), (128, 128), GRAPHCUT, run=ONE)
    assert thinned(0.5, Laying(), made.exemplars, Canvas(128, 128), made.map, ONE) is made.map
    made = ia.synthesize(spotted(), (288, 270), ia.RandomTiling(patch=40), seed=1, run=ONE)
    out = thinned(0.5, Laying(), made.exemplars, Canvas(288, 270), made.map, ONE)
    changed = (out.yx != made.map.yx).any(axis=2)
    assert 0 < changed.mean() < 0.5
    labels = things(made.exemplars[0]).labels
    near = ndimage.binary_dilation(labels[made.map.yx[..., 0], made.map.yx[..., 1]] > 0, np.ones((3, 3)), 60)
    assert not (changed & ~near).any()


def test_whole_things_stay_before_parts() -> None:
    """Of one that is whole and one that is cut, the whole one is kept."""
    e = Exemplar.of(spotted())
    yx = np.moveaxis(np.indices((96, 180)), 0, 2).astype(np.int32)
    yx[:, 90:, 1] -= 90
    yx[:, :36, 1] += 54  # the first copy of the thing is cut off in its middle
    smap = SourceMap(yx, None, None, (e.source,))
    often = Often(0.1, [e], Canvas(96, 180), np.zeros((96, 180), bool))
    assert [show.box[1] < 90 for show in often.surplus(often.things(smap))[1] if show.thing == 1] == [True]


def test_what_was_given_stays() -> None:
    """Law 7: of a start map every pixel that was kept is kept, things as well; they count as shown."""
    e = Exemplar.of(spotted())
    start = ia.synthesize(e, (190, 180), ia.RandomTiling(patch=40), seed=1, run=ONE).map
    which = np.zeros((190, 180), np.uint8)
    which[40:150, 30:] = HOLE
    begun = SourceMap(start.yx, which, None, start.sources)
    canvas = Canvas(190, 180, start=begun)
    out = thinned(0, Laying(), [e], canvas, start, ONE)
    stays = which == 0
    assert (out.yx != start.yx).any()
    whole = SourceMap(start.yx, None, None, start.sources)
    kept = thinned(0, Laying(), [e], Canvas(190, 180, start=whole), start, ONE)
    assert (kept.yx == start.yx).all()
    assert stays.any()


def test_a_guide_stays_in_force() -> None:
    """No pixel follows the guide less well."""
    labels = np.broadcast_to(np.arange(96)[:, None] > 60, (96, 90)).astype(np.uint8)
    target = np.broadcast_to(np.arange(190)[None] > 100, (190, 190)).astype(np.uint8)
    guide = ia.Guide(ia.Plane(labels, ia.Kind.LABEL), ia.Plane(target, ia.Kind.LABEL))
    e = Exemplar.of(spotted())
    made = ia.synthesize(e, (190, 190), GRAPHCUT, guide=guide, seed=3, run=ONE)
    out = thinned(0, Laying(), [e], Canvas(190, 190, guide=guide), made.map, ONE)
    wrong = [labels[m.yx[..., 0], m.yx[..., 1]] != target for m in (made.map, out)]
    assert not (wrong[1] & ~wrong[0]).any()


def test_a_lattice_is_kept() -> None:
    """What covers a thing lies whole steps beside what was there, so a regular texture stays in step."""
    rng = np.random.default_rng(3)
    pixels = np.tile(texture(12, 15, 3, 2) // 4, (9, 7, 1)) + rng.integers(0, 9, (108, 105, 3)).astype(np.uint8)
    pixels[40:49, 50:61] = (250, 90, 30)
    lattice = ((15.0, 0.0), (0.0, 12.0))
    made = ia.synthesize(pixels, (250, 240), ia.NearRegular(lattice=lattice, straighten="off"), seed=3, run=ONE)
    out = thinned(0.3, Laying(lattice=lattice), made.exemplars, Canvas(250, 240), made.map, ONE)
    assert (out.yx != made.map.yx).any()
    apart = (out.yx - made.map.yx) % (12, 15)
    off = np.minimum(apart, (12, 15) - apart).max(axis=2)
    assert (off <= 1).mean() > 0.99, "vectors may be fractions: a patch may leave the lattice by 1 px"
    assert off.max() <= 3  # a gap's block may have left the lattice so far


def test_progress_and_cancelling() -> None:
    """The pass is the second half of the work, told window size by window size, and stops between two."""
    event, seen = threading.Event(), list[float]()

    def step(done: int, total: int, draft: Any) -> None:
        seen.append(done / total)
        if done / total > 0.5:
            event.set()

    method = ia.Graphcut(patch=24, refinements=2, striking=0)
    with pytest.raises(ia.CancelledError):
        ia.synthesize(spotted(), (190, 180), method, run=ia.Run(1, step, event))
    assert seen == sorted(seen)
    assert 0.5 < seen[-1] < 1


def test_what_has_no_end_is_refused() -> None:
    """An endless plane is never finished; pins and turned pieces would not stay."""
    e = Exemplar.of(texture(64, 64, 3))
    for method in (ia.NearRegular(lattice=((16.0, 0.0), (0.0, 16.0)), striking=1), ia.ParallelControllable(striking=0)):
        with pytest.raises(ia.ParameterError, match="striking goes over a finished picture"):
            method.window([e], ia.Box(0, 0, 40, 40), 1, ONE)
        with pytest.raises(ia.ParameterError, match="striking goes over a finished picture"):
            method.resolved([e], Canvas(100, 100, endless=True))
    for name, value in (("angle", 10.0), ("zoom", 2.0), ("pin", ((3, 3, 9, 9, 4),))):
        with pytest.raises(ia.ParameterError, match="striking lays whole pixels"):
            ia.ParallelControllable(striking=0.5, **{name: value})


def plain_stay(staying: Staying, shows: list[Show], fixed: set[int]) -> list[Show]:
    """Those that stay, by asking each of the others how far it is from all that stay, each time."""

    def far(a: Show, b: Show) -> int:
        total = 0
        for axis, (length, wrap) in enumerate(zip(staying.size, staying.wraps, strict=True)):
            one, two = (2 * show.box[axis] + show.box[2 + axis] for show in (a, b))
            total += apart(one, two, 2 * length, wrap) ** 2
        return total

    near = 4 * (min(staying.size) // 4) ** 2
    stay = [show for show in shows if show.part in fixed]
    for least in (80, 0):
        others = [show for show in shows if show.percent >= least and show not in stay]
        while others and len(stay) < staying.most:
            away = [min((far(show, other) for other in stay), default=near) for show in others]
            if max(away) < near:
                break
            stay.append(others.pop(away.index(max(away))))
    return stay


@pytest.mark.parametrize("seed", range(12))
def test_those_that_stay_are_those_of_the_plain_twin(seed: int) -> None:
    """What may not go, then whole ones, each the farthest of all, then parts."""
    rng = np.random.default_rng(seed)
    size = tuple(int(n) for n in rng.integers(60, 400, 2))
    staying = Staying(int(rng.integers(0, 9)), size, (bool(seed & 1), bool(seed & 2)))
    shows = [
        Show(1, (*(int(rng.integers(n)) for n in size), *(int(n) for n in rng.integers(1, 30, 2))), k, percent)
        for k, percent in enumerate(rng.integers(30, 120, int(rng.integers(1, 40))).tolist(), 1)
    ]
    fixed = {k for k in range(1, len(shows) + 1) if rng.random() < 0.1}
    assert staying.of(shows, fixed) == plain_stay(staying, shows, fixed)


def test_what_may_not_go_is_the_one_that_stays() -> None:
    """Of three showings in a row, of which one may stay, the one in the middle is locked: the others are too many."""
    thing, locked = np.zeros((90, 300), np.int32), np.zeros((90, 300), bool)
    for left in (40, 140, 240):
        thing[40:50, left : left + 12] = 1
    locked[:, 130:160] = True
    often = Often(0.01, [Exemplar.of(spotted())], Canvas(90, 300), locked)
    assert [show.box[1] for show in often.surplus(thing)[1]] == [40, 240]


@pytest.mark.parametrize("wrap", list(Wrap))
def test_a_wave_takes_each_that_is_far_from_those_before(wrap: Wrap) -> None:
    """In their order, as if each were compared with all that are taken, over borders that wrap, too."""
    e = Exemplar.of(spotted())
    canvas = Canvas(180, 330, wrap)
    smap = ia.synthesize(spotted(), (180, 330), GRAPHCUT, wrap=wrap, run=ONE).map
    often = Often(0.5, [e], canvas, np.zeros((180, 330), bool))
    work, rng = Thinning(often, Laying(), [e], canvas, smap, 32), np.random.default_rng(1)
    every = [Show(1, (int(rng.integers(172)), int(rng.integers(318)), 8, 12), k, 100) for k in range(1, 120)]
    wave, others = work._apart(every)
    assert {job.show.part for job in wave} | {show.part for show in others} == set(range(1, 120))
    assert others
    taken = list[tuple[int, ...]]()
    for show in every:
        job = next((job for job in wave if job.show is show), None)
        alone = work._apart([show])[0][0].box
        gaps = (map(apart, alone, other, (180, 330), work.sewing.wraps) for other in taken)
        free = all(max(some) >= 32 + work.around for some in gaps)
        assert free == (job is not None)
        if job is not None:
            assert job.box == alone
            taken.append(job.box)
