"""Patch-based sampling line by line: source 000, sections 3 and 4 (ids S0-10 .. S0-54)."""

from __future__ import annotations

import numpy as np
import pytest
from naive import lay_down
from naive_patch_sampling import NaivePatchSampling
from torture import TORTURE

import intarsia as ia
from intarsia.analysis import Growth, waves
from intarsia.canvas import Canvas
from intarsia.errors import ParameterError
from intarsia.exemplar import Exemplar
from intarsia.geometry import ISOMETRIES, ISOMETRY_SETS, hang
from intarsia.render import render
from intarsia.run import Probe
from intarsia.sourcemap import SourceMap
from intarsia.testing import noise

PLAIN = {"repetition": "none", "search": "exact"}


def bytes_of(height: int, width: int, channels: int = 1, seed: int = 0) -> np.ndarray:
    layers = [noise(height, width, 7 * seed + c) >> np.uint64(56) for c in range(channels)]
    return np.stack(layers, axis=2).astype(np.uint8)


def grow(exemplar, size, seed=0, run=None, **parameters) -> ia.Synthesis:
    return ia.synthesize(exemplar, size, ia.PatchSampling(**parameters), seed=seed, run=run or ia.Run(1))


def grown(exemplar, size, **parameters) -> Growth:
    """A growth as it is after the method has filled it."""
    method = ia.PatchSampling(**parameters)
    e, canvas = Exemplar.of(exemplar), Canvas(*size)
    growth = Growth(method.settled([e], canvas).laying, [e], canvas)
    growth.fill(
        0, 2003, ia.Run(1),
        choose=lambda w, f, bits: method.choose(growth, w, f, bits, []),
        join=lambda at, pick, f: method.join_in(growth, at, pick, f),
    )  # fmt: skip
    return growth


# ---- the whole method, against a slow twin -----------------------------------------------------------------------


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("isometries", ["none", "180", "90", "both"])
@pytest.mark.parametrize("n", [1, 5])
def test_it_is_the_method_of_the_source(channels: int, isometries: str, n: int) -> None:
    """S0-10 .. S0-17, S0-20, S0-32: raster order, upper and left seams, the n best of all blocks, equals by place."""
    picture = np.asarray(TORTURE["brick_colours"](size=40))[:21, :19] if channels == 3 else bytes_of(18, 17)
    e = Exemplar.of(picture)
    for seed in range(3):
        out = grow(e, (23, 27), seed, patch=4, overlap=3, candidates=n, isometries=isometries, **PLAIN).map
        truth = NaivePatchSampling([e], (23, 27), 4, 3, n, seed, ISOMETRY_SETS[isometries]).run()
        np.testing.assert_array_equal(out.yx, truth[:, :, 2:])
        np.testing.assert_array_equal(np.zeros((23, 27)) if out.pose is None else out.pose, truth[:, :, 1])


@pytest.mark.parametrize("we", [0, 1, 2, 3, 5])
def test_seams_of_all_widths_and_two_exemplars(we: int) -> None:
    """S0-12, S0-14, S0-20: any seam, odd or even, two exemplars, blocks cropped at right and bottom."""
    both = [Exemplar.of(bytes_of(19, 18)), Exemplar.of(bytes_of(16, 23, seed=1))]
    for wb in (3, 6):
        out = grow(both, (25, 21), 4, patch=wb, overlap=we, candidates=2, **PLAIN).map
        if we:
            truth = NaivePatchSampling(both, (25, 21), wb, we, 2, 4).run()
            np.testing.assert_array_equal(out.yx, truth[:, :, 2:])
            np.testing.assert_array_equal(out.which, truth[:, :, 0])


def test_the_counter_of_repetitions_is_the_source_s() -> None:
    """S0-40, S0-41: after a block every block that touches it counts one more; d becomes (1 + c) d.

    Decided otherwise: uses are counted in the order in which windows are filled, diagonal by diagonal, not row by
    row, so that windows which do not touch can be filled at the same time.
    """
    e = Exemplar.of(bytes_of(24, 26))
    for seed in range(3):
        out = grow(e, (30, 28), seed, patch=4, overlap=3, candidates=1, repetition="counter", search="exact").map
        layout = ia.PatchSampling(patch=4, overlap=3).laying.layout(Canvas(30, 28))
        order = waves(layout, np.ones((len(layout.rows), len(layout.columns)), bool))
        truth = NaivePatchSampling([e], (30, 28), 4, 3, 1, seed, counter=True).run(order)
        np.testing.assert_array_equal(out.yx, truth[:, :, 2:])


# ---- blocks, placement, distance -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("height", "width"), [(35, 35), (40, 36), (60, 51)])
def test_the_number_of_valid_blocks(height: int, width: int) -> None:
    """S0-10, S0-11: patch w_b, seam w_e on all sides, (W - w_b - 2 w_e + 1)(H - w_b - 2 w_e + 1) blocks."""
    e = Exemplar.of(bytes_of(height, width))
    growth = Growth(ia.PatchSampling(patch=25, overlap=5).laying, [e], Canvas(50, 50))
    assert growth.layout.patch == (35, 35)
    assert growth.variants.valid[0].sum() == (width - 34) * (height - 34)


def test_an_exemplar_smaller_than_a_block_is_refused_in_one_line() -> None:
    """S0-11: what the source calls BAD_RANGE."""
    with pytest.raises(ParameterError, match="larger than the exemplar"):
        grow(bytes_of(34, 40), 50, patch=25, overlap=5)


@pytest.mark.parametrize("length", [1, 29, 30, 31, 60, 100])
def test_patches_lie_at_multiples_of_patch_and_seam(length: int) -> None:
    """S0-12: patch origins are multiples of w_b + w_e; the first touches the border, its seam is dropped."""
    starts, block = hang(length, 35, 5)
    assert [s + 5 for s in starts] == list(range(0, length, 30))
    assert block == 35


def test_what_a_window_knows_is_its_upper_and_left_seam() -> None:
    """S0-13, S0-14, S0-16: 2 w_e (w_b + 2 w_e) - w_e**2 px inside; one seam in the first row and column."""
    seen: dict[tuple[int, int], int] = {}
    method = ia.PatchSampling(patch=6, overlap=3, **PLAIN)
    e = Exemplar.of(bytes_of(30, 30))
    growth = Growth(method.laying, [e], Canvas(36, 36))
    growth.fill(
        0, 2003, ia.Run(1),
        choose=lambda w, f, bits: (seen.__setitem__(w, int(f.known.sum())), method.choose(growth, w, f, bits, []))[1],
        join=lambda at, pick, f: method.join_in(growth, at, pick, f),
    )  # fmt: skip
    block = 12
    assert seen[1, 1] == seen[2, 2] == 2 * 3 * block - 9
    assert seen[0, 1] == 3 * (block - 3)  # the seam above lies outside
    assert seen[1, 0] == 3 * (block - 3)
    assert seen[3, 3] == 2 * 3 * (36 - 24) - 9 + 0 * block
    assert len(seen) == 15


def test_distances_are_root_mean_squares_over_known_pixels_and_colours() -> None:
    """S0-15: d = sqrt((d_R**2 + d_G**2 + d_B**2) / 3) of the pixels themselves, on the 0..1 scale, equal weights."""
    picture = bytes_of(26, 24, 3)
    picture[0, 0], picture[0, 1] = 0, 255  # the whole range: features are 1023/255 of the values
    probe = Probe(15, 14)
    drafts = []
    run = ia.Run(1, step=lambda done, total, draft: drafts.append(draft()), probe=probe)
    grow(picture, (18, 18), 3, run, patch=6, overlap=3, channel_weights=(1, 1, 1), **PLAIN)
    last = drafts[3]  # the output just before the fourth window is searched
    known = ~last.holes[6:18, 6:18]
    old = picture[last.yx[6:18, 6:18, 0], last.yx[6:18, 6:18, 1]].astype(float) / 255
    assert probe.maps is not None
    assert probe.maps[0].shape == (15, 13)
    for (u, s), d in np.ndenumerate(probe.maps[0]):
        diff = (old - picture[u : u + 12, s : s + 12].astype(float) / 255)[known]
        by_colour = np.sqrt((diff**2).mean(axis=0))
        assert d == pytest.approx(np.sqrt((by_colour**2).sum() / 3), abs=3e-3)
    flat = Probe(14, 15)
    grow(np.full((20, 20), 7, np.uint8), (30, 30), 3, ia.Run(1, probe=flat), patch=4, overlap=3)
    assert flat.maps is not None
    assert (flat.maps[0] == 0).all()


def test_a_distance_map_is_exact_and_changes_no_pixel() -> None:
    """S0-23: measured again pixel by pixel from what the search saw; masked blocks are marked."""
    usable = np.ones((24, 22), bool)
    usable[10, 11] = False
    e = Exemplar.of(bytes_of(24, 22), usable=usable)
    method = ia.PatchSampling(patch=4, overlap=3, isometries="180", **PLAIN)
    growth = Growth(method.laying, [e], Canvas(25, 25))
    windows = {}
    probe = Probe(12, 20)
    growth.fill(
        1, 2003, ia.Run(1, probe=probe),
        choose=lambda w, f, bits: (windows.__setitem__(w, f), method.choose(growth, w, f, bits, []))[1],
        join=lambda at, pick, f: method.join_in(growth, at, pick, f),
    )  # fmt: skip
    found = windows[1, 2]
    assert probe.maps is not None
    assert len(probe.maps) == 4
    known = found.known.astype(bool)
    for v, table in enumerate(probe.maps):
        picture = growth.variants.picture(v).astype(np.int64)
        for (y, x), d in np.ndenumerate(table):
            if not growth.variants.valid[v][y, x]:
                assert d == -1
                continue
            squares = ((picture[y : y + 10, x : x + 10] - found.feats)[known] ** 2).sum()
            assert d == np.float32(np.sqrt(squares / (known.sum() * 1023**2)))
    plain = grow(e, 25, 1, patch=4, overlap=3, isometries="180", **PLAIN).map
    np.testing.assert_array_equal(growth.map(method.blend).yx, plain.yx)


# ---- who may be chosen --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 5, 20])
def test_any_of_the_n_best_is_chosen_and_no_other(n: int) -> None:
    """S0-17: uniformly among the n smallest distances, equal ones by place; never empty."""
    method = ia.PatchSampling(patch=4, overlap=3, candidates=n, **PLAIN)
    growth = grown(bytes_of(25, 25), (20, 20), patch=4, overlap=3, **PLAIN)
    at = np.array([growth.at((1, 1))], np.int64)
    work = growth.patchwork
    found = growth.finder.find(work.variant, work.yx, at, (False, False), growth.repetition.told)
    picks = [method.choose(growth, (1, 1), found[0], k << 32, []) for k in range(0, 1 << 32, 1 << 25)]
    assert set(picks) == {tuple(row[1:]) for row in found[0].rows[:n].tolist()}
    counts = [picks.count(p) for p in set(picks)]
    assert max(counts) - min(counts) <= 1


def test_the_epsilon_bound_is_the_source_s_and_says_when_nobody_passes() -> None:
    """S0-18: d < sqrt(mean of (eps R)**2); if none passes the best is taken, and the run notes it."""
    run = ia.Run(1)
    strict = grow(bytes_of(30, 30), 40, 2, run, patch=6, overlap=3, bound="epsilon", epsilon=0.0, **PLAIN)
    assert len(run.notes) == 1
    assert "no candidate within epsilon" in run.notes[0]
    best = grow(bytes_of(30, 30), 40, 2, patch=6, overlap=3, candidates=1, **PLAIN)
    np.testing.assert_array_equal(strict.map.yx, best.map.yx)
    run = ia.Run(1)
    grow(bytes_of(30, 30), 40, 2, run, patch=6, overlap=3, bound="epsilon", epsilon=100.0, **PLAIN)
    assert run.notes == []


def test_the_epsilon_bound_counts_from_black_and_the_relative_one_from_the_best() -> None:
    """S0-18, D0-9: brighter by 100 the source's bound admits more; the relative bound does not change."""
    dark = (bytes_of(40, 40) // 3).astype(np.uint8)
    bright = dark + 100
    args = {"patch": 6, "overlap": 3, **PLAIN}
    notes = []
    for picture in (dark, bright):
        run = ia.Run(1)
        grow(picture, 60, 1, run, bound="epsilon", epsilon=0.25, **args)
        notes.append(int(run.notes[0].split()[0]) if run.notes else 0)
    assert notes[1] < notes[0]
    relative = [grow(p, 60, 1, bound="relative", epsilon=0.2, **args).map.yx for p in (dark, bright)]
    np.testing.assert_array_equal(*relative)


# ---- how patches meet ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("we", [2, 3, 5, 8])
def test_feathered_seams_are_linear_ramps(we: int) -> None:
    """S0-19: across a seam of w_e px the new patch counts 1/(w_e+1) .. w_e/(w_e+1), and in a corner their product."""
    wb = 12
    tall = np.zeros((200, 200), np.float32)
    out = grow(tall, (2 * wb + we, 2 * wb + we), patch=wb, overlap=we, **PLAIN)
    yx = np.array(out.map.yx)
    pieces = np.zeros(yx.shape[:2], int)
    cut = wb + (we + 1) // 2
    for k, (rows, columns) in enumerate(
        ((slice(0, cut), slice(0, cut)), (slice(0, cut), slice(cut, None)),
         (slice(cut, None), slice(0, cut)), (slice(cut, None), slice(cut, None)))
    ):  # fmt: skip
        pieces[rows, columns] = k
        y, x = np.mgrid[: yx.shape[0], : yx.shape[1]][:, rows, columns]
        yx[rows, columns] = np.stack([y + 20 + 30 * (k // 2), x + 20 + 30 * (k % 2)], axis=2)  # far from the border
    for mark in range(4):
        shares = _share(out, yx, pieces, mark)
        ramp = np.clip((np.arange(yx.shape[0]) - wb + 1) / (we + 1), 0, 1)
        down = ramp if mark // 2 else 1 - ramp
        right = ramp if mark % 2 else 1 - ramp
        np.testing.assert_allclose(shares, down[:, None] * right[None, :], atol=1e-6)


def _share(out, yx, pieces, mark) -> np.ndarray:
    """Render with four exemplars that differ in nothing but that one of them is white."""
    plates = [ia.Plane(np.full((200, 200), float(k == mark), np.float32), ia.Kind.DATA) for k in range(4)]
    exemplars = tuple(Exemplar.of(p) for p in plates)
    smap = SourceMap(yx, pieces.astype(np.uint8), None, tuple(e.source for e in exemplars))
    return np.asarray(render(exemplars, smap, None, out.blend, None, ia.Run(1)).pixels, float)


@pytest.mark.parametrize("we", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("join", ["middle", "feather"])
def test_straight_cuts_lie_in_the_middle_of_seams(we: int, join: str) -> None:
    """S0-20: of the old picture the outer half of the seam stays; the map is the same with and without feather."""
    wb = 7
    out = grow(bytes_of(40, 40), (40, 43), patch=wb, overlap=we, join=join, **PLAIN)
    assert out.blend.feather == (we if join == "feather" else 0)
    truth = NaivePatchSampling([Exemplar.of(bytes_of(40, 40))], (40, 43), wb, we, 5, 0).run()
    np.testing.assert_array_equal(out.map.yx, truth[:, :, 2:])
    pieces = out.map.pieces()
    lines = set((np.flatnonzero((pieces[:, 1:] != pieces[:, :-1]).any(axis=0)) + 1).tolist())
    assert lines <= {k * (wb + we) - we + (we + 1) // 2 for k in range(1, 9)}


# ---- isometries, repetition, cost ---------------------------------------------------------------------------------


def test_the_isometries_are_the_group_of_the_square() -> None:
    """S0-30, S0-31, S0-34, D0-1: the table, with 7 as (N-1-j, i); all distinct, closed, 5 of order four."""
    block = np.arange(25).reshape(5, 5)
    laid = [lay_down(block, k) for k in range(8)]
    assert len({a.tobytes() for a in laid}) == 8
    for k, iso in enumerate(ISOMETRIES):
        start, j = np.array(iso.start(5, 5)), np.array(iso.j)
        for i in range(5):
            for c in range(5):
                assert laid[k][i, c] == block[tuple(start + j @ (i, c))]
    every = {a.tobytes() for a in laid}
    assert all(lay_down(a, k).tobytes() in every for a in laid for k in range(8))
    turned = lay_down(lay_down(lay_down(block, 5), 5), 5)
    np.testing.assert_array_equal(turned, laid[7])
    np.testing.assert_array_equal(lay_down(laid[5], 7), block)
    np.testing.assert_array_equal(laid[5], np.rot90(block))
    names = ["identity", "mirror left-right", "mirror up-down", "transpose", "anti-transpose"]
    assert [iso.name for iso in ISOMETRIES] == [*names, "rotate 90", "rotate 180", "rotate 270"]


@pytest.mark.parametrize("name", ["none", "180", "90", "both"])
def test_categories_of_isometries_through_the_method(name: str) -> None:
    """S0-32, S0-33, S0-35: 1 + 3 + 4 variants; patches occur in their poses only, and all occur in a while."""
    assert {"none": (0,), "180": (0, 1, 2, 6), "90": (0, 3, 4, 5, 7), "both": tuple(range(8))} == ISOMETRY_SETS
    out = grow(bytes_of(30, 30), (160, 160), 1, patch=8, overlap=3, isometries=name, **PLAIN)
    assert out.map.poses == ISOMETRY_SETS[name]
    pixels = np.asarray(out.render(feather=0).pixels)
    np.testing.assert_array_equal(pixels, bytes_of(30, 30)[out.map.yx[..., 0], out.map.yx[..., 1]])
    with pytest.raises(ParameterError, match="not square"):
        grow(bytes_of(30, 30), 60, patch=(8, 6), overlap=3, isometries="90")


def test_the_counter_marks_all_blocks_that_touch_a_used_one() -> None:
    """S0-40: within w_b + 2 w_e - 1 px along each axis, each use counts one."""
    growth = grown(bytes_of(40, 44), (1, 1), patch=4, overlap=3, repetition="counter", search="exact")
    (_, u, s), counts = growth.repetition.grid[0, 0, :3].tolist(), growth.repetition.told.counts[0]
    y, x = np.mgrid[: counts.shape[0], : counts.shape[1]]
    near = (abs(y - u) <= 9) & (abs(x - s) <= 9)
    np.testing.assert_array_equal(counts, 256 * near)


def test_marks_weigh_a_block_by_the_marks_of_its_pixels() -> None:
    """S0-43: the alternative: 1 + the mean number of uses of the block's pixels, here for one use."""
    growth = grown(bytes_of(40, 44), (1, 1), patch=4, overlap=3, repetition="marks", search="exact")
    (_, u, s), counts = growth.repetition.grid[0, 0, :3].tolist(), growth.repetition.told.counts[0]
    used = np.zeros((40, 44))
    used[u : u + 10, s : s + 10] = 1
    for y in range(counts.shape[0]):
        for x in range(counts.shape[1]):
            assert counts[y, x] / 256 == pytest.approx(used[y : y + 10, x : x + 10].mean(), abs=0.03)


@pytest.mark.parametrize("rule", ["marks", "prices"])
def test_prevention_of_repetitions_spreads_the_use_of_the_exemplar(rule: str) -> None:
    """S0-43, D0-3: more of the exemplar is shown than without.

    The source's counter (S0-40) does not do so here: over five seeds it shows as much as no prevention (D0-3).
    """
    picture = TORTURE["pebbles_black"](size=96)
    shown = []
    for repetition in ("none", rule):
        yx = grow(picture, 256, 1, patch=12, overlap=4, candidates=1, repetition=repetition).map.yx
        shown.append(len(np.unique(yx.reshape(-1, 2), axis=0)))
    assert shown[1] >= shown[0]


def cost(side: int, wb: int, we: int) -> float:
    """S0-22: difference operations for each output pixel of a full search."""
    return (side - wb - 2 * we + 1) ** 2 * 2 * we * (wb + 2 * we) / (wb + 2 * we) ** 2


def cost_of_pyramid(side: int, wb: int, we: int) -> float:
    """S0-53: the same of the pyramid search: all of level 2, then a square of twice the block's side."""
    total = 0.0
    for level in (0, 1, 2):
        b, e = wb >> level, we >> level
        places = (side // 4 - b - 2 * e + 1) if level == 2 else (b + 2 * e + 1)
        total += places**2 * 2 * e * (b + 2 * e)
    return total / (wb + 2 * we) ** 2


def test_the_cost_laws_of_the_source() -> None:
    """S0-08, S0-22, S0-53: quadratic in the exemplar's side; the pyramid's is nearly flat."""
    assert [round(cost(s, 25, 5)) for s in (100, 200, 300, 500)] == [1245, 7873, 20216, 62045]
    assert [round(cost_of_pyramid(s, 25, 5)) for s in (100, 200, 300, 500)] == [390, 410, 446, 567]
    assert 19 <= cost(200, 25, 5) / cost_of_pyramid(200, 25, 5) <= 20


def test_defaults_and_the_source_s_own() -> None:
    """S0-21, S0-70: automatic sizes come from the element size; 25/5, n 5, epsilon 0.1 are accepted as they are."""
    m = ia.PatchSampling(patch=25, overlap=5)
    assert (m.candidates, m.epsilon, m.bound, m.isometries) == (5, 0.1, "best", "none")
    assert (m.pitch, m.footprint) == ((30, 30), (35, 35))
    for p, a in (("patch", 0), ("overlap", -1), ("candidates", 0), ("epsilon", -1)):
        with pytest.raises(ParameterError, match=p):
            ia.PatchSampling(**{p: a})
