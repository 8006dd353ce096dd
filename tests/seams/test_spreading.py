"""What strikes returns less after the pass, nothing else is harmed by it, and no thread changes a byte."""

from __future__ import annotations

import threading
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from seams.naive_copies import NaiveCopies, distances

import intarsia as ia
from intarsia.canvas import Canvas
from intarsia.exemplar import Exemplar
from intarsia.geometry import ISOMETRIES
from intarsia.patches.growth import Growth, PatchSettings
from intarsia.seams import copies_kernels
from intarsia.seams.copies_kernels import FINE, Copies
from intarsia.seams.covering import Laying, in_step
from intarsia.seams.spreading import Spreading, no_copies, spread_out, wave_sides
from intarsia.sourcemap import HOLE, SourceMap
from intarsia.synthesis import Synthesis
from intarsia.testing import texture

ONE = ia.Run(1)
GRAPHCUT = ia.Graphcut(patch=24, overlap=10, refinements=4, seam="difference", structure=0)


@pytest.fixture(autouse=True)
def few_placements(monkeypatch: pytest.MonkeyPatch) -> None:
    """One for each window: quicker, and more returns."""
    monkeypatch.setattr("intarsia.seams.graphcut.TRIES", 1)


def spotted(height: int = 96, width: int = 90, seed: int = 3) -> np.ndarray:
    """A grainy texture with one thing in it that strikes."""
    pixels = texture(height, width, 3, seed) // 2 + 40
    pixels[40:52, 30:44] = (230, 60, 20)
    return np.asarray(pixels, np.uint8)


def work_of(made: Synthesis, price: float = 8.0, **more: Any) -> Spreading:
    canvas = made.canvas or Canvas(made.map.height, made.map.width, made.map.wrap)
    return Spreading(price, Laying(**more), made.exemplars, canvas, made.map, 32)


def shown_spots(smap: SourceMap) -> int:
    """How many pixels show the thing that strikes."""
    y, x = smap.yx[..., 0], smap.yx[..., 1]
    return int(((y >= 40) & (y < 52) & (x >= 30) & (x < 44)).sum())


def lists(copies: Copies) -> list[list[set[int]]]:
    """The samples of every list."""
    out = []
    for tile in copies.head.tolist():
        row = []
        for first in tile:
            found: set[int] = set()
            while first >= 0:
                assert first not in found
                found.add(first)
                first = int(copies.next[first])
            row.append(found)
        out.append(row)
    return out


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 99), st.sampled_from(["none", "x", "both"]), st.sampled_from(["none", "both"]), st.booleans())
def test_prices_are_those_of_the_twin(seed: int, wrap: str, isometries: str, masked: bool) -> None:
    """Of every pixel as it is, and as a patch would show it, after the map changed, too."""
    rng = np.random.default_rng(seed)
    usable = np.ones((70, 66), bool)
    usable[5:8, 40:] = not masked
    one = Exemplar.of(texture(70, 66, 3, seed), usable=usable if masked else None, toroidal=bool(seed % 2))
    two = Exemplar.of(texture(64, 72, 3, seed + 1))
    method = ia.ImageQuilting(patch=20, overlap=6, isometries=isometries)
    made = ia.synthesize([one, two], (88, 97), method, seed=seed, wrap=wrap, run=ONE)
    work = work_of(made, isometries=(0, 3) if isometries == "both" else "none")
    sewn, variants = work.sewing, work.growth.variants
    v = int(rng.integers(len(variants)))
    pick = (v, int(rng.integers(0, 12)), int(rng.integers(0, 12)))
    cut = sewn.cut((40, 60, 32, 32), pick, 5)
    sewn.paste(cut)
    work._list(cut.box)
    fresh = no_copies(sewn.variant.shape, 2 * 32 if 2 * 32 > 66 * 80 // 100 else 66 * 80 // 100, len(work.copies.shows))
    copies_kernels.list_box(sewn.grown, sewn.pieces, work.origins, fresh, (0, 0, *sewn.variant.shape))
    assert lists(fresh) == lists(work.copies)
    assert (fresh.shows == work.copies.shows).all()
    assert (fresh.shown == work.copies.shown).all()
    yx, which, pose = variants.to_exemplars(sewn.yx, sewn.variant)
    terms = {"unit": work.terms.unit, "spare": work.terms.spare, "near": work.terms.near, "reach": work.terms.reach,
             "around": int(work.terms.around[0, 0, 0, 0])}  # fmt: skip
    weights, begin = [], 0
    for e in (one, two):
        weights.append(work.origins.weight[begin : begin + e.height * e.width].reshape(e.height, e.width))
        begin += e.height * e.width
    js = {p: [*i.j[0], *i.j[1]] for p, i in enumerate(ISOMETRIES)}
    naive = NaiveCopies(
        np.dstack([which, yx[..., 0], yx[..., 1]]).astype(np.int64), pose, sewn.wraps,
        lambda e, y, x: (e, y // 4, x // 4), weights, js, work.copies.tiles.tolist(), terms,
    )  # fmt: skip
    e, (_, rows, columns, _) = (one, two)[int(variants.exemplar[v])], variants.table[v].tolist()

    def patched(i: int, j: int) -> tuple[int, int, int] | None:
        y, x = pick[1] + i, pick[2] + j
        if variants.toroidal[v]:
            y, x = y % rows, x % columns
        if not (0 <= y < rows and 0 <= x < columns):
            return None
        at = variants.to_exemplars(np.array([[[y, x]]], np.int32), np.array([[v]], np.uint8))[0][0, 0].tolist()
        return (int(variants.exemplar[v]), *at) if e.usable is None or e.usable[tuple(at)] else None

    box = ((60, 70, 32, 32) if wrap == "both" else (50, 61, 32, 32))
    now, new = work._priced(box), work._priced(box, pick)
    for i, j in product(range(0, 32, 12), range(0, 32, 12)):
        assert now[i, j] == naive.price(box, i, j)
        assert new[i, j] == naive.price(box, i, j, (int(variants.pose[v]), patched))
    assert now.any()


def test_what_strikes_returns_less() -> None:
    """A law that holds where nothing happens says little: here a red thing is shown far less, and seams stay good."""
    made = ia.synthesize(spotted(), (288, 270), ia.RandomTiling(patch=40), seed=1, run=ONE)
    out = spread_out(8.0, Laying(), made.exemplars, Canvas(288, 270), made.map, ONE)
    assert shown_spots(out) < 0.4 * shown_spots(made.map), "tiles show it 24 times"
    made = ia.synthesize(spotted(), (288, 270), GRAPHCUT, seed=2, run=ONE)
    out = spread_out(8.0, Laying(), made.exemplars, Canvas(288, 270), made.map, ONE)
    assert shown_spots(out) < 0.95 * shown_spots(made.map)
    assert not out.holes.any()
    work, now = work_of(made), work_of(Synthesis(**{**vars(made), "map": out}))
    assert now.field().sum() < work.field().sum()
    steps = [int((w.sewing.prices > 4 * work.sewing.price.knee).sum()) for w in (work, now)]
    assert steps[1] <= 1.4 * steps[0]


def test_every_patch_saves_more_than_it_costs() -> None:
    """By the map as it is when the patch is laid, and by the prices that are then."""
    made = ia.synthesize(spotted(), (200, 200), GRAPHCUT, seed=4, run=ONE)
    work, laid = work_of(made), 0
    lay = work.lay

    def total() -> int:
        work.sewing.note((0, 0, 200, 200))
        return work.sewing.total

    def watched(cut: Any) -> None:
        nonlocal laid
        old, new, take = work._priced(cut.box), work._priced(cut.box, cut.pick), cut.take > 0
        before = total()
        lay(cut)
        assert total() - before == cut.change
        assert int((old - new)[take].sum()) > FINE * max(cut.change, 0)
        laid += 1

    work.lay = watched  # type: ignore[method-assign]
    totals = [int(work.field().sum())]
    for _ in range(3):
        work.wave(ONE)
        totals.append(int(work.field().sum()))
    assert laid
    assert all(a >= b for a, b in pairwise(totals))


def test_what_was_given_stays() -> None:
    """Law 7: of a start map every pixel that was kept is kept."""
    e = Exemplar.of(spotted())
    start = ia.synthesize(e, (190, 180), GRAPHCUT, seed=1, run=ONE).map
    which = np.zeros((190, 180), np.uint8)
    which[40:150, 30:] = HOLE
    begun = SourceMap(start.yx, which, None, start.sources)
    plain = ia.synthesize(e, None, GRAPHCUT, start=begun, seed=3, run=ONE).map
    out = spread_out(8.0, Laying(), [e], Canvas(190, 180, start=begun), plain, ONE)
    stays = (which == 0) & (plain.yx == start.yx).all(axis=2)
    assert (out.yx != plain.yx).any()
    assert (out.yx[stays] == start.yx[stays]).all()


def test_a_guide_and_a_distance_stay_in_force() -> None:
    """No pixel follows the guide less well; no exemplar pixel is put nearer to its copy than before."""
    labels = np.broadcast_to(np.arange(96)[:, None] > 60, (96, 90)).astype(np.uint8)
    target = np.broadcast_to(np.arange(190)[None] > 100, (190, 190)).astype(np.uint8)
    guide = ia.Guide(ia.Plane(labels, ia.Kind.LABEL), ia.Plane(target, ia.Kind.LABEL))
    e = Exemplar.of(spotted())
    made = ia.synthesize(e, (190, 190), GRAPHCUT, guide=guide, seed=3, run=ONE)
    out = spread_out(8.0, Laying(), [e], Canvas(190, 190, guide=guide), made.map, ONE)
    wrong = [labels[m.yx[..., 0], m.yx[..., 1]] != target for m in (made.map, out)]
    assert (out.yx != made.map.yx).any()
    assert not (wrong[1] & ~wrong[0]).any()
    method = ia.ImageQuilting(patch=16, overlap=5, min_repeat_distance=20, spread=8)
    far = ia.synthesize(e, (200, 200), method, seed=3, run=ONE).map
    key = far.yx[..., 0] * 90 + far.yx[..., 1]
    for dy, dx in product(range(-12, 13, 4), range(0, 13, 4)):
        if (dy, dx) != (0, 0) and dy * dy + dx * dx < 400:
            a = key[max(dy, 0) : 200 + min(dy, 0), dx:]
            b = key[max(-dy, 0) : 200 + min(-dy, 0), : 200 - dx]
            assert not (a == b).any()


def test_a_lattice_is_kept() -> None:
    """Patches lie whole steps beside what was there, so a regular texture stays in step, and has no seam."""
    rng = np.random.default_rng(3)
    tile = texture(12, 15, 3, 2) // 2
    pixels = np.tile(tile, (9, 7, 1)) + rng.integers(0, 9, (108, 105, 3)).astype(np.uint8)
    pixels[40:48, 50:60] += 90
    lattice = ((15.0, 0.0), (0.0, 12.0))
    made = ia.synthesize(pixels, (250, 240), ia.NearRegular(lattice=lattice, straighten="off"), seed=3, run=ONE)
    out = spread_out(8.0, Laying(lattice=lattice), made.exemplars, Canvas(250, 240), made.map, ONE)
    assert (out.yx != made.map.yx).any()
    apart = (out.yx - made.map.yx) % (12, 15)
    off = np.minimum(apart, (12, 15) - apart).max(axis=2)
    assert (off == 0).mean() > 0.99
    assert off.max() <= 3  # a gap's block may have left the lattice so far


@pytest.mark.parametrize("pose", [0, 5])
def test_steps_of_a_lattice_are_those_of_the_exemplar(pose: int) -> None:
    """Turned pieces step by turned vectors; what fits is measured pixel by pixel, the best come first."""
    e = Exemplar.of(texture(60, 60, 3, 1))
    growth = Growth(PatchSettings((16, 16), (4, 4), isometries=(pose,), listed=12, rim=1), [e], Canvas(60, 60))
    growth.growing.variant[:], growth.growing.yx[:] = 0, np.moveaxis(np.indices((60, 60)), 0, 2)
    growth.growing.variant[24:32, 24:32] = HOLE
    found = in_step(growth, ((13.0, 2.0), (1.0, 17.0)), (20, 20), (0, 20, 20))
    assert found.rows[0].tolist() == [0, 0, 20, 20]
    assert (np.diff(found.rows[:, 0]) >= 0).all()
    a, b = (np.array(v[::-1]) @ np.array(ISOMETRIES[pose].j) for v in ((13, 2), (1, 17)))
    steps = {tuple((k * a + m * b).tolist()) for k, m in product(range(-9, 10), repeat=2)}
    for _, _, y, x in found.rows.tolist():
        assert any((y - 20 - i, x - 20 - j) in steps for i, j in product((-1, 0, 1), repeat=2))
    picture = growth.variants.picture(0)
    patches = [picture[y : y + 16, x : x + 16] for _, _, y, x in found.rows.tolist()]
    assert found.rows[:, 0].tolist() == distances(found.feats, found.known, patches)


def test_what_is_left_alone() -> None:
    """Canvases below one and a half exemplars, exemplars too small for a window, clouds: the same map, in silence."""
    method = ia.Graphcut(patch=12, overlap=4, refinements=0)
    for side, size in ((80, (90, 100)), (40, (99, 99))):
        made, run = ia.synthesize(texture(side, side, 3), size, method, run=ONE), ia.Run(1)
        assert spread_out(8.0, Laying(), made.exemplars, Canvas(*size), made.map, run) is made.map
        assert run.notes == []
    assert wave_sides([Exemplar.of(texture(40, 40, 3))], made.map) == []
    y, x = np.mgrid[0:96, 0:96] / 96
    cloud = np.uint8(120 + 60 * np.sin(5 * x) * np.cos(4 * y))
    made, run = ia.synthesize(cloud, (190, 190), GRAPHCUT, run=ONE), ia.Run(1)
    assert spread_out(8.0, Laying(), made.exemplars, Canvas(190, 190), made.map, run) is made.map
    assert run.notes == []


def test_progress_and_cancelling() -> None:
    """The pass is the second half of the work, told wave by wave, and stops between two waves."""
    event, seen = threading.Event(), list[float]()

    def step(done: int, total: int, draft: Any) -> None:
        seen.append(done / total)
        assert draft is None or draft().yx.shape == (190, 180, 2)
        if done / total > 0.7:
            event.set()

    with pytest.raises(ia.CancelledError):
        ia.synthesize(spotted(), (190, 180), ia.Graphcut(patch=24, refinements=2, spread=8), run=ia.Run(1, step, event))
    assert seen == sorted(seen)
    assert seen[-1] == 0.75


def test_what_has_no_end_is_refused() -> None:
    """An endless plane is never finished; pins and turned pieces would not stay."""
    e = Exemplar.of(texture(64, 64, 3))
    for method in (ia.NearRegular(lattice=((16.0, 0.0), (0.0, 16.0)), spread=4), ia.ParallelControllable(spread=4)):
        with pytest.raises(ia.ParameterError, match="finished picture"):
            method.window([e], ia.Box(0, 0, 40, 40), 1, ONE)
        with pytest.raises(ia.ParameterError, match="finished picture"):
            method.resolved([e], Canvas(100, 100, endless=True))
    for name, value in (("angle", 10.0), ("zoom", 2.0), ("pin", ((3, 3, 9, 9, 4),))):
        with pytest.raises(ia.ParameterError, match="spread lays whole pixels"):
            ia.ParallelControllable(spread=4, **{name: value})
