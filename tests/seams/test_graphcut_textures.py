"""Graph-cut textures, by the paper of Kwatra et al. 2003: costs, old seams, placement by FFT, and refinement."""

from __future__ import annotations

import math
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from seams.naive_recut import NaiveMap, Sources, energy, exhaustive_energy, naive_repeats, naive_total, scipy_energy
from seams.sewing import empty, empty_of

import intarsia as ia
from intarsia import search
from intarsia.foundation.geometry import Wrap
from intarsia.kernels.cuts import PLAIN, SeamPrice
from intarsia.kernels.maps import PartialMap
from intarsia.kernels.maxflow import MOST, least_cut
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import HOLE, identity
from intarsia.seams import cut_kernels, energy_kernels, graphcut_moves, graphcut_textures, placement_kernels
from intarsia.seams.cut_kernels import NEVER
from intarsia.seams.occurrence_kernels import Usage
from intarsia.seams.softmax_sampling import boltzmann_weights
from intarsia.testing import texture

PRICES = (PLAIN, SeamPrice(gradient=True), SeamPrice(threshold=11), SeamPrice(threshold=1))
WRAPS = ((False, False), (True, False), (False, True), (True, True))

NO_USAGE = Usage(*np.zeros((3, 0), np.int32))


class Scene:
    """A small random map of a few pieces, for the kernels and for their twin."""

    def __init__(self, seed: int, size: tuple[int, int] = (9, 10), price: SeamPrice = PLAIN) -> None:
        rng = np.random.default_rng(seed)
        shapes = [(int(h), int(w)) for h, w in rng.integers(4, 9, (2, 2))]
        self.wraps = WRAPS[int(rng.integers(4))]
        pictures = [rng.integers(0, 60, (h, w, 2)).astype(np.int16) for h, w in shapes]
        usable = [rng.random(s) < 0.9 for s in shapes]
        torus = [bool(t) for t in rng.integers(0, 2, 2)]
        visible = [rng.integers(64, 400, s).astype(np.int16) for s in shapes]
        self.naive = NaiveMap(pictures, usable, torus, size, self.wraps, price.gradient, price.threshold, visible)
        self.flat = np.concatenate([p.ravel() for p in pictures])
        begins = np.cumsum([0, pictures[0].size])
        self.table = np.array([(b, h, w, w) for b, (h, w) in zip(begins, shapes, strict=True)], np.int64)
        shown = np.concatenate([u.ravel() for u in usable]).astype(np.uint8)
        counts = np.concatenate([v.ravel() for v in visible])
        self.pieces = energy_kernels.Pieces(self.flat, self.table, shown, np.array(torus), 2, counts)
        self.variant = np.full(size, HOLE, np.uint8)
        self.yx = np.zeros((*size, 2), np.int32)
        self.locked = rng.random(size) < 0.05
        self.shown = PartialMap(self.variant, self.yx, self.wraps)
        for _ in range(6):
            v, y0, x0 = int(rng.integers(2)), int(rng.integers(-3, 8)), int(rng.integers(-3, 8))
            for y, x in product(range(y0, y0 + 6), range(x0, x0 + 5)):
                source = self.naive.grown(v, y - y0, x - x0)
                if source is not None and 0 <= y < size[0] and 0 <= x < size[1]:
                    self.variant[y, x], self.yx[y, x] = v, source[1:]
        self.price = price

    def sources(self) -> Sources:
        return {
            (int(y), int(x)): (int(self.variant[y, x]), int(self.yx[y, x, 0]), int(self.yx[y, x, 1]))
            for y, x in np.argwhere(self.variant != HOLE)
        }

    def prices(self) -> np.ndarray:
        out = np.zeros((*self.variant.shape, 2), np.int32)
        box = (0, 0, *self.variant.shape)
        energy_kernels.seam_prices(self.shown, self.pieces, box, self.price, out)
        return out


seeds = st.integers(0, 2**32 - 1)
NO_MORE = np.zeros((0, 0), np.int64)


def recut(
    scene: Scene, window: tuple[int, ...], pick: tuple[int, ...], take: np.ndarray, limit: int = NEVER, step: int = 1
) -> int:
    """Cut one patch into a window: by how much seams become dearer, NEVER where it is by the limit or more."""
    windows, numbered, best = np.array([window]), np.array([(0, *pick)]), np.array([limit, -1])
    where = scene.shown, scene.locked, scene.pieces, windows, numbered
    cut_kernels.recut(*where, (scene.price, NO_USAGE), step, take, best)
    return NEVER if best[1] else int(best[0])


def drawn_window(rng: np.random.Generator) -> tuple[tuple[int, int, int, int], tuple[int, int, int]]:
    """A window of a scene, and what to cut in."""
    h, w = int(rng.integers(2, 6)), int(rng.integers(2, 6))
    box = int(rng.integers(0, 9 - h + 1)), int(rng.integers(0, 10 - w + 1)), h, w
    return box, (int(rng.integers(2)), int(rng.integers(-2, 5)), int(rng.integers(-2, 5)))


@settings(max_examples=60, deadline=None)
@given(seeds, st.sampled_from(PRICES))
def test_the_price_of_seams_is_that_of_the_map(seed: int, price: SeamPrice) -> None:
    """The prices of all pairs follow from the map alone, masks, borders and wraps included."""
    scene = Scene(seed, price=price)
    prices, sources = scene.prices(), scene.sources()
    assert int(prices.sum()) == scene.naive.total(sources)
    for p, q, dy, dx in scene.naive.neighbours():
        want = scene.naive.pair(sources[p], sources[q], dy, dx) if p in sources and q in sources else 0
        assert prices[(*p, dy)] == want


@settings(max_examples=150, deadline=None)
@given(seeds, st.sampled_from(PRICES))
def test_a_recut_changes_the_total_by_what_it_says(seed: int, price: SeamPrice) -> None:
    """Old seams covered, old seams kept and new seams: their sum is the difference of the two maps' totals."""
    scene = Scene(seed, price=price)
    rng = np.random.default_rng(seed)
    (y, x, h, w), pick = drawn_window(rng)
    take, edge = np.empty((h, w), np.uint8), np.ones((h, w), bool)
    edge[1:-1, 1:-1] = False
    if (scene.variant[y : y + h, x : x + w][edge] == HOLE).any():
        return  # what fills holes at the edge of a window has seams with the outside, too
    before = scene.naive.total(scene.sources())
    change = recut(scene, (y, x, h, w, 0, 0, h, w), pick, take)
    kept = scene.variant.copy(), scene.yx.copy()
    usage = Usage(np.zeros(scene.pieces.usable.size, np.int32), NO_USAGE.rate, np.zeros(1, np.int32))
    cut_kernels.write_cut(scene.shown, scene.pieces, usage, (y, x, h, w), pick, take)
    for i, j in np.argwhere(take == 1).tolist():
        assert scene.naive.grown(pick[0], pick[1] + i, pick[2] + j) == scene.sources()[y + i, x + j]
    assert not (take.astype(bool) & scene.locked[y : y + h, x : x + w] & (kept[0][y : y + h, x : x + w] != HOLE)).any()
    assert scene.naive.total(scene.sources()) - before == change
    if not (kept[0] == HOLE).any() and price == PLAIN:
        assert change <= 0, "where all is known, all may stay"
    assert (kept[1][scene.variant == HOLE] == scene.yx[scene.variant == HOLE]).all()


@settings(max_examples=100, deadline=None)
@given(seeds, st.sampled_from(PRICES), st.integers(2, 4))
def test_a_rough_cut_is_the_cut_of_a_smaller_scene(seed: int, price: SeamPrice, step: int) -> None:
    """Every px of a small scene magnified to `step` x `step`: a cut on every so many-th px is that of the small one."""
    scene = Scene(seed, price=price)
    rng = np.random.default_rng(seed)
    (y, x, h, w), pick = drawn_window(rng)
    small, rough = np.empty((h, w), np.uint8), np.empty((h, w), np.uint8)
    window = (y, x, h, w, 1, 0, h - 1, w)
    change = recut(scene, window, pick, small)

    def larger(a: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(a.repeat(step, axis=0).repeat(step, axis=1))

    flat, table, usable, torus, channels, visible = scene.pieces
    rows = [(int(b) // channels, int(m), int(n)) for b, m, n, _ in table]
    parts = [larger(flat.reshape(-1, channels)[b : b + m * n].reshape(m, n, channels)) for b, m, n in rows]
    shown, seen = ([larger(of[b : b + m * n].reshape(m, n)).ravel() for b, m, n in rows] for of in (usable, visible))
    begins = np.cumsum([0, parts[0].size])
    places = np.array([(b, *p.shape[:2], p.shape[1]) for b, p in zip(begins, parts, strict=True)], np.int64)
    pieces = energy_kernels.Pieces(
        np.concatenate([p.ravel() for p in parts]), places, np.concatenate(shown), torus, channels, np.concatenate(seen)
    )
    scene.shown = PartialMap(larger(scene.variant), larger(scene.yx) * step, scene.wraps)
    scene.pieces, scene.locked = pieces, larger(scene.locked)
    where = tuple(n * step for n in window)
    got = recut(scene, where, (pick[0], pick[1] * step, pick[2] * step), rough, step=step)
    assert got == change
    assert np.array_equal(rough, small)


def random_terms(rng: np.random.Generator, state: np.ndarray, most: int) -> np.ndarray:
    """Terms that obey the triangle inequality, as distances do; without an old seam a is 0 and b is c.

    Beside pixels that are left out they are 0.
    """
    shape = state.shape
    a, b, c = rng.integers(0, most + 1, (3, *shape, 2))
    seam = rng.random((*shape, 2)) < 0.4
    b, c = np.where(seam, np.maximum(b, abs(a - c)), b), np.where(seam, c, b)
    a = np.where(seam, np.clip(a, abs(b - c), b + c), 0)
    terms = np.stack([a, b, c], axis=3).astype(np.int32)
    terms[state == 3] = 0
    terms[:, :-1, 0][state[:, 1:] == 3] = 0
    terms[:-1, :, 1][state[1:] == 3] = 0
    return terms


def planes(terms: np.ndarray) -> np.ndarray:
    """The terms as the kernels take them: (3, 2, h, w), 0 where there is no neighbour."""
    out = np.ascontiguousarray(terms.transpose(3, 2, 0, 1))
    out[:, 0, :, -1] = out[:, 1, -1] = 0
    return out


@settings(max_examples=80, deadline=None)
@given(seeds, st.sampled_from(PRICES))
def test_placements_that_are_compared_are_those_cut_in_one_by_one(seed: int, price: SeamPrice) -> None:
    """The cheapest, of equal ones the first, each in a window of its own or in that of the one before.

    A cut is given up only where it costs as much as the limit.
    """
    scene, rng = Scene(seed, price=price), np.random.default_rng(seed)
    windows = []
    for _ in range(2):
        h, w = int(rng.integers(3, 8)), int(rng.integers(3, 8))
        windows.append((int(rng.integers(0, 9 - h + 1)), int(rng.integers(0, 10 - w + 1)), h, w, 0, 0, h, w))
    picks = [tuple(int(n) for n in rng.integers((0, -2, -2), (2, 4, 4))) for _ in range(6)] * 2
    wide = [windows[k] for k in rng.integers(0, 2, len(picks)).tolist()]

    def cut(k: int, limit: int) -> tuple[int, np.ndarray]:
        take = np.empty(wide[k][2:4], np.uint8)
        return recut(scene, wide[k], picks[k], take, limit), take

    changes = []
    for k in range(len(picks)):
        change, take = cut(k, NEVER)
        changes.append(change)
        again, same = cut(k, change + 1)
        assert again == change
        assert np.array_equal(take, same)
        assert cut(k, change - int(rng.integers(3)))[0] == NEVER
    best, order = np.array([NEVER, len(picks)], np.int64), rng.permutation(len(picks))
    for part in np.split(order, 3):
        numbered = np.array([(k, *picks[k]) for k in part.tolist()], np.int64)
        where = scene.shown, scene.locked, scene.pieces, np.array([wide[k] for k in part.tolist()]), numbered
        cut_kernels.recut(*where, (price, NO_USAGE), 1, np.empty((0, 0), np.uint8), best)
    assert best.tolist() == [min(changes), changes.index(min(changes))]


@settings(max_examples=120, deadline=None)
@given(seeds, st.integers(1, 4), st.integers(1, 4), st.sampled_from([1, 3, 1000]))
def test_tiny_windows_reach_the_exhaustive_minimum(seed: int, height: int, width: int, most: int) -> None:
    """No choice between old and new costs less, whatever is forced and wherever old seams run."""
    rng = np.random.default_rng(seed)
    state = rng.choice(4, (height, width), p=[0.2, 0.6, 0.1, 0.1]).astype(np.uint8)
    for y, x in np.argwhere(state == 1)[9:]:
        state[y, x] = 0
    terms = random_terms(rng, state, most)
    out = np.full((height, width), 7, np.uint8)
    more = rng.integers(-most, most + 1, state.shape) if seed % 3 else NO_MORE
    assert least_cut(state, planes(terms), more, out, MOST)
    free = state == 1
    signed = np.where(free, more, 0) if more.size else np.zeros(state.shape, np.int64)
    stays = -np.minimum(signed, 0)
    goes = np.maximum(signed, 0)
    if (state == 0).any():  # else all becomes new
        paid = energy(out, state, terms) + stays[out == 0].sum() + goes[out == 1].sum()
        assert paid == exhaustive_energy(state, terms, stays - goes) + goes.sum()
    assert (out[state == 2] == 1).all()
    assert (out[(state == 0) | (state == 3)] == 0).all()
    none = np.zeros_like(out)
    want = energy(out, state, terms) - energy(none, state, terms)
    assert cut_kernels.cut_change(planes(terms), out) == want


@settings(max_examples=60, deadline=None)
@given(seeds, st.integers(3, 14), st.integers(3, 14))
def test_windows_reach_the_flow_through_the_graph_of_the_paper(seed: int, height: int, width: int) -> None:
    """With a node for every old seam, scipy's maximum flow carries what our cut on the bare grid costs."""
    rng = np.random.default_rng(seed)
    state = rng.choice(4, (height, width), p=[0.15, 0.75, 0.05, 0.05]).astype(np.uint8)
    state[0, 0] = 0
    terms = random_terms(rng, state, int(rng.choice([1, 20, 5000])))
    out = np.empty((height, width), np.uint8)
    least_cut(state, planes(terms), NO_MORE, out, MOST)
    least = energy(out, state, terms)
    assert least == scipy_energy(state, terms)
    assert least_cut(state, planes(terms), NO_MORE, out, least + 1)
    assert energy(out, state, terms) == least
    given_up = not least_cut(state, planes(terms), NO_MORE, out, max(least, 1))
    assert given_up or not least


@settings(max_examples=40, deadline=None)
@given(seeds)
def test_repeats_are_counted(seed: int) -> None:
    """What of a candidate is shown near by counts more there; a continuation is none, wherever it was counted."""
    scene = Scene(seed)
    rng = np.random.default_rng(seed)
    box = (int(rng.integers(0, 4)), int(rng.integers(0, 4)), 4, 5)
    rows = np.array([(0, *(int(n) for n in rng.integers(0, (2, 4, 4)))) for _ in range(4)], np.int64)
    high, wide = scene.naive.size
    parts = (0, 0, high, wide), (0, 0, high, wide), (1, 2, high - 1, wide - 2), (high - 3, 0, 3, 4)
    for part, step in zip(parts, (1, 2, 1, 2), strict=True):
        out, look = np.empty(4, np.int64), placement_kernels.Look(*part, step)
        turns = np.zeros((2, 2, 7), np.int64)  # two exemplars
        placement_kernels.repeats(scene.shown, scene.pieces, turns, look, box, rows, 50 * step, out)
        of = scene.naive, scene.sources(), box
        assert out.tolist() == [naive_repeats(*of, tuple(row[1:].tolist()), look, 50 * step) for row in rows]


@pytest.mark.parametrize("wrap", list(Wrap))
def test_what_lies_about_a_window_is_looked_at(wrap: Wrap) -> None:
    """All within one and a half windows of its middle, each row and column once, and nothing beyond the canvas."""
    e = Exemplar.of(texture(40, 40))
    for size in ((50, 512), (64, 200), (111, 33)):
        sewing = empty([e], Canvas(*size, wrap), patch=(16, 20))
        for at in ((0, 0), (size[0] - 16, size[1] - 20), (size[0] // 2, 7)):
            look = sewing.look((*at, 16, 20))
            for axis, (first, long) in enumerate(zip(look[:2], look[2:4], strict=True)):
                length, middle = size[axis], at[axis] + (8, 10)[axis]
                seen = sorted((first + k) % length for k in range(long))
                about = range(middle - 31, middle + 32)
                if (wrap.y, wrap.x)[axis]:
                    assert seen == sorted({n % length for n in about})
                else:
                    assert seen == [n for n in about if 0 <= n < length]


def test_chances_fall_off_as_published() -> None:
    """A place is drawn with a chance of exp(-C / (k sigma^2)), in whole numbers that are the same everywhere."""
    x = np.arange(0, 1400)
    got = boltzmann_weights(x)
    assert got[0] == 1 << 30
    for n in range(0, 600, 7):  # k squarings of rounded numbers: 0.4 % at worst
        assert got[n] == pytest.approx(2**30 * math.exp(-n / 64), rel=5e-3)
    assert (got[1280:] == 0).all()
    assert all(a >= b for a, b in pairwise(got.tolist()))


@pytest.mark.parametrize("seam", ["difference", "gradient", "sharp"])
def test_the_books_are_kept(seam: str) -> None:
    """What a stitching notes of its seams is what the finished map costs; what patches saved is what is missing."""
    e = Exemplar.of(texture(40, 40, 1, 7))
    sewing = empty_of([e], Canvas(50, 44), patch=12, overlap=4, seam=seam, evenness=0)
    graphcut_moves.fill(sewing, 1, 2, ia.Run(1))
    before = sewing.total
    assert before == naive_total([e], sewing.growth.map(ia.Blend(0)), sewing.price)
    saved = graphcut_moves.expand(sewing, ia.Run(1), 2)
    assert min(saved, default=0) > 0
    assert sewing.total == before - sum(saved) == naive_total([e], sewing.growth.map(ia.Blend(0)), sewing.price)


def with_one_patch(margin: int | None = None) -> graphcut_textures.GraphcutMap:
    """A map with a patch of 16 px in its first corner."""
    settings = (
        graphcut_textures.GraphcutSettings() if margin is None else graphcut_textures.GraphcutSettings(margin=margin)
    )
    sewing, box = empty([Exemplar.of(texture(40, 40, 3, 9))], Canvas(30, 30), settings), (0, 0, 16, 16)
    first = sewing.best(box, sewing.placements(box, sewing.found([box], ia.Run(1))[0], 1, 6))
    sewing.write(first)
    sewing.note(first)
    return sewing


def test_the_placement_that_promises_the_cheapest_seams_is_cut_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the placements drawn, compared on every second px of a window of 16; fewer tries draw the first of them."""
    monkeypatch.setattr(graphcut_textures, "RANDOMNESS", 1.0)
    sewing, box = with_one_patch(2), (0, 10, 16, 16)
    picks = sewing.placements(box, sewing.found([box], ia.Run(1))[0], 2, 6)
    assert len(set(picks)) == len(picks) == 6
    rough = []
    for pick in picks:
        (where, patch), cost = sewing.windows(box, [pick], 2), np.array([graphcut_textures.NEVER, 1])
        one = np.array([(0, *patch[0])])
        cut_kernels.recut(*sewing._map, where, one, sewing._prices, 2, graphcut_textures.NOTHING, cost)
        rough.append(int(cost[0]))
    assert len(set(rough)) > 1
    best = sewing.cut(box, picks[rough.index(min(rough))], 2)
    found = sewing.best(box, picks)
    assert (found.pick, found.change) == (best.pick, best.change)
    fewer = graphcut_textures.GraphcutMap(sewing.growth, graphcut_textures.GraphcutSettings())
    assert fewer.placements(box, fewer.found([box], ia.Run(1))[0], 2, 2) == picks[:2]


def test_cheap_placements_are_the_likely_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hardly anything random: of all candidates for a window one of the cheapest is drawn, whatever the bits."""
    monkeypatch.setattr(graphcut_textures, "RANDOMNESS", 0.0)
    sewing, box = with_one_patch(), (0, 10, 16, 16)
    found = sewing.found([box], ia.Run(1))[0]
    prices = dict(zip(map(tuple, found.rows[:, 1:].tolist()), sewing.priced(box, found).tolist(), strict=True))
    cheap = min(prices.values())
    assert max(prices.values()) > 1.5 * cheap > 0
    for bits in range(1, 20):
        (pick,) = sewing.placements(box, found, bits, 1)
        assert prices[pick] <= cheap + 20


def test_what_is_not_seen_makes_no_seam() -> None:
    """Channels of structure find what fits; seams are priced by what is shown, as without them."""
    e = Exemplar.of(texture(40, 48, 3, 9))
    sharp = graphcut_textures.GraphcutSettings(seam="sharp")
    plain, more = (empty([e], Canvas(30, 30), sharp, structure=s) for s in (0, 1))
    assert more.growth.variants.channels == 7
    assert more.pieces.channels == plain.pieces.channels == 3
    assert np.array_equal(more.pieces.flat, plain.pieces.flat)
    assert np.array_equal(more.pieces.table, plain.pieces.table)
    assert more.price == plain.price


def test_a_guide_is_honoured() -> None:
    """Multrus 2003, 5.3.1: inside the regions of a target every pixel comes from its own label."""
    left = np.arange(64)[None, :] < 32
    labels = np.broadcast_to(left, (64, 64)).astype(np.uint8)
    pixels = texture(64, 64, 3, 1) // 3 + labels[:, :, None] * np.uint8(150)
    target = (np.arange(80)[:, None] < 36).astype(np.uint8) * np.ones((1, 70), np.uint8)
    guide = ia.Guide(ia.Plane(labels, ia.Kind.LABEL), ia.Plane(target, ia.Kind.LABEL))
    out = ia.synthesize(pixels, (80, 70), ia.Graphcut(patch=16, overlap=5), guide=guide, run=ia.Run(1)).map
    shown = labels[out.yx[:, :, 0], out.yx[:, :, 1]]
    assert (shown[:24] == 1).all()
    assert (shown[48:] == 0).all()


def test_defaults_follow_from_the_texture() -> None:
    """0.7 of 1.5 elements, of at most 0.4 of the side, all of it in step; a third overlaps, and is in reach."""
    e = Exemplar.of(texture(192, 160, 3))
    resolved = ia.Graphcut().resolved([e], Canvas(300, 300))
    plain = search.default_patch([e])
    large = max(plain, min(3 * plain // 2, 64))
    assert resolved.patch == large * 7 // 10
    assert ia.Graphcut(lattice=((20, 0), (0, 20))).resolved([e], Canvas(300, 300)).patch == large
    begun = Canvas(192, 160, start=identity([e.source], 0))
    assert ia.Graphcut().resolved([e], begun).patch == large
    assert resolved.overlap == resolved.patch // 3
    assert resolved.overreach == resolved.patch // 3
    with pytest.raises(ia.ParameterError, match="overlap=20 is not below patch=20"):
        ia.Graphcut(patch=20, overlap=20)
