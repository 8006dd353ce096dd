"""Segment-based synthesis: the search by histograms against a slow one, the choice, and what it grows."""

from __future__ import annotations

import numpy as np
import pytest
from segments.naive_segments import naive_histogram, naive_zone_counts

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.kernels.maps import PartialMap
from intarsia.model import Exemplar
from intarsia.published.segments.engine import LEVELS, HistogramIndex, SegmentSearch, choose, histogram, spread_sample
from intarsia.search import Candidates, Prices, posed_exemplars
from intarsia.segments import segments
from intarsia.testing import texture
from intarsia.testing.cases import noise

SIDES = [(True, False, False, False), (True, True, False, False), (False, True, True, True), (True,) * 4]


def searching(toroidal=False, usable=None, patch=(6, 7), zone=(2, 3), hits=4, points=2, seed=5):
    exemplar = Exemplar.of(texture(19, 22, 3), toroidal=toroidal, usable=usable)
    groups = (noise(5, 6, 3) % np.uint64(3)).astype(np.int32).repeat(4, axis=0).repeat(4, axis=1)[:19, :22]
    laid = posed_exemplars([exemplar], features([exemplar]), (0,), patch)
    if usable is not None:
        groups = np.where(usable, groups, -1)
    return SegmentSearch(laid, patch, groups, zone, hits, points, seed, 7), groups


@pytest.mark.parametrize("toroidal", [False, True])
@pytest.mark.parametrize("sides", SIDES)
@pytest.mark.parametrize("masked", [False, True])
def test_the_index_holds_every_patch_under_its_histogram(masked, sides, toroidal):
    """All that may be used, each once."""
    usable = np.ones((19, 22), bool)
    usable[8, 9] = False
    search, groups = searching(toroidal, usable if masked else None)
    index = search.index(sides)
    assert search.index(sides) is index
    seen = held_under_their_histograms(search, groups, sides, index)
    assert sorted(seen) == np.flatnonzero(search.valid[0]).tolist()
    assert (len(seen) < search.valid[0].size) == masked


def held_under_their_histograms(search, groups, sides, index):
    """The patches of an index, each under the histogram of its zone."""
    columns, seen = -(-search.valid[0].shape[1] // search.step), []
    for number, wanted in enumerate(index.histograms.tolist()):
        for patch in index.members(number).tolist():
            y, x = (search.step * n for n in divmod(patch, columns))
            assert naive_histogram(naive_zone_counts(groups, 3, (6, 7), (2, 3), sides, y, x), LEVELS) == tuple(wanted)
            seen.append(patch)
    return seen


def test_of_large_exemplars_every_second_row_and_column_is_indexed(monkeypatch):
    whole, _ = searching()
    monkeypatch.setattr("intarsia.published.segments.engine.PATCHES", 100)
    search, groups = searching()
    assert (whole.step, search.step) == (1, 2)
    held_under_their_histograms(search, groups, SIDES[1], search.index(SIDES[1]))
    shown = np.full((6, 7), -1)
    shown[:2] = groups[4:6, 6:13]
    rows = search.drawn(shown, shown >= 0, (0, 0))
    assert (rows[:, 2:] % 2 == 0).all()


@pytest.mark.parametrize("seed", range(6))
def test_near_histograms_are_the_nearest_and_ties_go_to_the_first(seed):
    counts = (noise(3, 90, seed) % np.uint64(5)).astype(np.int64).reshape(3, 9, 10)
    index = HistogramIndex(counts, np.ones((9, 10), bool))
    query = histogram((noise(1, 3, seed + 30) % np.uint64(9)).astype(np.int64))[0]
    distance = ((index.histograms - query) ** 2).sum(axis=1)
    for hits in (1, 2, 5, 1000):
        wanted = sorted(range(len(distance)), key=lambda k: (distance[k], k))[:hits]
        assert index.near(query, hits).tolist() == wanted


def test_histograms_are_roots_of_shares():
    """The scale does not matter, and an empty one is zero."""
    assert histogram(np.array([[1, 0, 3], [100, 0, 300], [0, 0, 0]])).tolist() == [
        [LEVELS // 2, 0, round(LEVELS * 0.75**0.5)]] * 2 + [[0, 0, 0]]  # fmt: skip


def test_members_are_drawn_once_each():
    members = np.arange(100, 117)
    for bits in (0, 1 << 40, (1 << 64) - 1, 0x123456789ABCDEF):
        drawn = spread_sample(members, 5, bits)
        assert len(set(drawn.tolist())) == 5
        assert set(drawn.tolist()) <= set(members.tolist())
    np.testing.assert_array_equal(spread_sample(members, 17, 9), members)
    assert len({tuple(spread_sample(members, 5, b << 58).tolist()) for b in range(64)}) > 10


def test_candidates_are_measured_exactly_and_sorted():
    """The arrangement decides, pixel by pixel."""
    search, groups = searching()
    height, width = 12, 15
    variant, yx = np.full((height, width), 255, np.uint8), np.zeros((height, width, 2), np.int32)
    variant[:8, :5] = 0
    yx[:8, :5] = np.stack(np.mgrid[3:11, 4:9], axis=-1)
    counts = np.zeros(search.valid[0].shape, np.int32)
    free, found = search.find(PartialMap(variant, yx, (False, False)), np.array([[4, 8], [4, 2]]), Prices([counts], 0))
    assert len(free.rows) == 0
    picture = features([Exemplar.of(texture(19, 22, 3))]).pictures[0].astype(np.int64)
    known = found.known > 0
    assert known.sum() == 4 * 3
    for d, v, y, x in found.rows.tolist():
        step = picture[y : y + 6, x : x + 7] - found.feats
        assert v == 0
        assert d == int((step * step)[known].sum())
    assert found.rows[:, 0].tolist() == sorted(found.rows[:, 0].tolist())
    sides = search.known_sides(found.known)
    assert sides == (False, True, False, False)  # 4 of 6 rows of the left strip, all of its columns
    weight = search.weights(sides) * known
    shown = np.where(known, groups[np.ix_(range(7, 13), range(6, 13))], -1)
    query = naive_histogram([int(weight[shown == g].sum()) for g in range(3)], LEVELS)
    index = search.index(sides)
    held = {m for k in index.near(np.array(query), 4) for m in index.members(int(k)).tolist()}
    assert {y * 16 + x for _, _, y, x in found.rows.tolist()} <= held
    assert 1 <= len(found.rows) <= 4 * 2


@pytest.mark.parametrize(("limit", "wanted"), [(0, {1}), (100, {1, 2}), (50, {1}), (900, {1, 2, 3})])
def test_one_below_the_threshold_is_drawn_or_else_the_best(limit, wanted):
    """Lines 12 to 20 of the algorithm SegmentBased in the fragments."""
    rows = np.array([[20, 0, 1, 1], [50, 0, 2, 2], [500, 0, 3, 3]])
    found = Candidates(rows, 0, np.zeros((10, 10, 1), np.int16), np.ones((10, 10), np.uint8))
    assert {choose(found, rows[:, 0], limit, bits << 58)[1] for bits in range(64)} == wanted
    dear = np.array([800, 700, 500])  # of repeats: the last one is the best now
    assert {choose(found, dear, 0, bits << 58)[1] for bits in range(64)} == {3}
    assert {choose(found, dear, 750, bits << 58)[1] for bits in range(64)} == {2, 3}


def tiled(height=120, width=132):
    y, x = np.mgrid[:height, :width]
    joint = (y % 20 < 4) | (x % 22 < 4)
    grain = (noise(height, width, 2) % np.uint64(40)).astype(int)
    return np.where(joint, 30 + grain // 4, 150 + grain).astype(np.uint8)


def test_patch_and_zone_follow_from_the_segments():
    exemplar = Exemplar.of(tiled())
    found = segments(exemplar)
    resolved = ia.synthesize(exemplar, 40, "segment-based").method
    assert 18 <= found.patch <= 25
    assert (resolved.patch, resolved.overlap) == (found.patch, found.zone)
    assert ia.synthesize(exemplar, 40, ia.SegmentBased(patch=30)).method.overlap == 7


def test_the_threshold_lets_some_windows_draw_and_repeats_cost(monkeypatch):
    """Automatic: below what a fiftieth of the patches lie; a fair share of the windows has several, dear ones fewer."""
    seen = []

    def spy(found, prices, limit, bits):
        assert limit == found.usual == found.rows[len(found.rows) // 50, 0]
        seen.append(int((prices < limit).sum()))
        return choose(found, prices, limit, bits)

    monkeypatch.setattr("intarsia.published.segments.engine.choose", spy)
    shares, most = [], []
    for usage in (0.0, 0.2):
        seen.clear()
        made = ia.synthesize(tiled(), 240, ia.SegmentBased(repeat_penalty=usage), seed=1)
        shares.append(np.mean(np.array(seen) > 1))
        most.append(made.map.usage()[0].max())
    assert shares[0] > 0.9
    assert 0.1 < shares[1] < shares[0]
    assert most[1] < most[0]


def test_the_first_patch_is_drawn():
    """As in the source, from anywhere in the exemplar."""
    corners = {tuple(ia.synthesize(tiled(), 40, ia.SegmentBased(patch=20), seed=s).map.yx[0, 0]) for s in range(8)}
    assert len(corners) > 5


@pytest.mark.parametrize("left", [1, 2, 3])
def test_where_a_mask_leaves_little_the_automatic_sizes_fit_into_it(left):
    """Nobody gave a patch or an overlap: so none is refused that was found."""
    pixels, usable = texture(24, 30, 3, 4), np.zeros((24, 30), bool)
    usable[5 : 5 + left, 7 : 7 + left] = True
    made = ia.synthesize(Exemplar.of(pixels, usable=usable), 20, ia.SegmentBased())
    assert (made.method.patch, made.method.overlap) == (left, left - 1)
    known = {tuple(p) for p in pixels[usable].tolist()}
    assert {tuple(p) for p in np.asarray(made).reshape(-1, 3).tolist()} <= known


def test_overlaps_hold_the_cuts():
    method = ia.SegmentBased(patch=24, overlap=8)
    yx = ia.synthesize(tiled(), (104, 104), method, seed=2).map.yx
    inside = np.s_[8:16, 8:16]
    assert (np.diff(yx[inside][..., 0], axis=0) == 1).all()


def test_what_cannot_work_is_refused_before_any_work():
    with pytest.raises(ia.ParameterError, match="overlap=9 is not below patch=9 px"):
        ia.SegmentBased(patch=9, overlap=9)
    with pytest.raises(ia.ParameterError, match="patch=200 is larger than the exemplar"):
        ia.synthesize(tiled(), 40, ia.SegmentBased(patch=200))
