"""Patch-based sampling line by line; sections are those of Multrus 2003."""

from __future__ import annotations

import numpy as np
import pytest
from naive import lay_down
from published.multrus2003.naive_multrus import Multrus
from published.multrus2003.naive_patch_sampling import NaivePatchSampling
from quilts import bytes_of
from torture import TORTURE

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.foundation import ParameterError
from intarsia.foundation.geometry import ISOMETRIES, ISOMETRY_SETS
from intarsia.kernels.maps import PartialMap
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import SourceMap
from intarsia.patches.patch_synthesis import PatchSynthesis
from intarsia.published.multrus2003 import engine
from intarsia.published.multrus2003.engine import choose, place_patch, settings_of
from intarsia.rendering.render import render
from intarsia.search.guide import seam_unit
from intarsia.testing import texture

PLAIN = {"repetition": "none", "search": "exact"}
DRAWN = {"pyramid": "mean", "pyramid_draws": "every"}


def grow(exemplar, size, seed=0, run=None, **parameters) -> ia.Synthesis:
    return ia.synthesize(exemplar, size, ia.PatchSampling(**parameters), seed=seed, run=run or ia.Run(1))


def grown(exemplar, size, seed=0, run=None, seen=None, **parameters) -> PatchSynthesis:
    """A growth as it is after the method has filled it; `seen` takes what was found for each window."""
    method = ia.PatchSampling(**parameters)
    e, canvas, seen = Exemplar.of(exemplar), Canvas(*size), {} if seen is None else seen
    growth = PatchSynthesis(settings_of(method.resolved([e], canvas)), [e], canvas)
    growth.fill(
        seed, 2003, run or ia.Run(1),
        choose=lambda w, f, bits: (seen.__setitem__(w, f), choose(method, growth, w, f, bits, []))[1],
        join=lambda at, pick, f: place_patch(method, growth, at, pick, f),
    )  # fmt: skip
    return growth


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("isometries", ["none", "180", "90", "both"])
@pytest.mark.parametrize("n", [1, 5])
def test_it_is_the_method_of_the_source(channels: int, isometries: str, n: int, thorough: bool) -> None:
    """Sections 3.1, 3.3.4, 4.1.1 and B.1.4: raster order, upper and left seams, the n best, equals by place."""
    picture = np.asarray(TORTURE["brick_colours"](size=40))[:21, :19] if channels == 3 else bytes_of(18, 17)
    e = Exemplar.of(picture)
    for seed in range(3 if thorough else 1):
        out = grow(e, (23, 27), seed, patch=4, overlap=3, candidates=n, isometries=isometries, **PLAIN).map
        truth = NaivePatchSampling([e], (23, 27), 4, 3, n, seed, ISOMETRY_SETS[isometries]).run()
        np.testing.assert_array_equal(out.yx, truth[:, :, 2:])
        np.testing.assert_array_equal(np.zeros((23, 27)) if out.pose is None else out.pose, truth[:, :, 1])


def sixteen(height: int, width: int, seed: int = 0) -> np.ndarray:
    """Numbers of 0 to 1023, both of which occur, smooth in places: they are compared as they are."""
    coarse = np.asarray(bytes_of(height // 3 + 1, width // 3 + 1, seed=seed))[:, :, 0].astype(np.int64)
    fine = np.asarray(bytes_of(height, width, seed=seed + 1))[:, :, 0].astype(np.int64)
    mixed = 3 * coarse.repeat(3, 0).repeat(3, 1)[:height, :width] + fine
    stretched = (mixed - mixed.min()) * 1023 // np.ptp(mixed)
    return stretched.astype(np.uint16)


# What the twin is told, beside what the program is asked for.
RULES = {
    "best": ({"n": 3}, {"candidates": 3, "repetition": "none"}),
    "more best blocks than any short-list": ({"n": 90}, {"candidates": 90, "repetition": "none"}),
    "all": ({"n": 99_999}, {"candidates": 99_999, "repetition": "none"}),
    "epsilon": ({"epsilon": 0.55}, {"bound": "epsilon", "epsilon": 0.55, "repetition": "none"}),
    "wide epsilon": ({"epsilon": 0.9}, {"bound": "epsilon", "epsilon": 0.9, "repetition": "none"}),
    "counter": ({"n": 1, "counter": True}, {"candidates": 1, "repetition": "counter"}),
    "counter, 3": ({"n": 3, "counter": True}, {"candidates": 3, "repetition": "counter"}),
    "counter, epsilon": ({"epsilon": 0.5, "counter": True},
                         {"bound": "epsilon", "epsilon": 0.5, "repetition": "counter"}),
}  # fmt: skip


@pytest.mark.parametrize(
    ("rule", "search"),
    [*((r, "exact") for r in RULES), *((r, "fast") for r in RULES if r != "best" and "counter" not in r)],
)
def test_all_blocks_of_the_exemplar_are_looked_at_as_in_the_source(rule: str, search: str, thorough: bool) -> None:
    """Sections 3.3.4 and 4.2.1: row by row, of more blocks than any short-list holds; d becomes (1 + c) d."""
    told, asked = RULES[rule]
    picture = sixteen(46, 52)
    for seed in range(3 if thorough else 1):
        out = grow(picture, (62, 55), seed, patch=7, overlap=4, search=search, join="middle", **asked)
        truth = Multrus(picture, (62, 55), (7, 4), seed=seed, **told)
        np.testing.assert_array_equal(out.map.yx, truth.run())
        if "epsilon" in told and rule != "counter, epsilon":
            assert max(truth.passed) > 48  # more than a list would hold
    assert len(truth.places) > 1000


@pytest.mark.parametrize("rule", ["best", "more best blocks than any short-list", "epsilon", "counter, 3"])
def test_a_place_is_drawn_at_every_level_of_the_published_pyramid(rule: str, thorough: bool) -> None:
    """Section 4.3.1: choose at level 2, project, choose again around it, down to level 0."""
    told, asked = RULES[rule]
    picture = sixteen(70, 66)
    for seed in range(3 if thorough else 1):
        out = grow(picture, (60, 52), seed, patch=9, overlap=5, join="middle", **DRAWN, **asked)
        truth = Multrus(picture, (60, 52), (9, 5), seed=seed, pyramid=True, **told).run()
        np.testing.assert_array_equal(out.map.yx, truth)
    two = ia.synthesize(
        picture, (60, 52), ia.PatchSampling(patch=9, overlap=5, join="middle", **DRAWN, **asked),
        seed=seed, run=ia.Run(2),
    )  # fmt: skip
    np.testing.assert_array_equal(two.map.yx, out.map.yx)


def test_where_labels_meet_one_of_a_few_is_drawn_at_every_level_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Section 5.3.1: n' blocks at the boundary, as n elsewhere; the source's own program has both with the pyramid."""
    picture, side = sixteen(60, 60), 48
    halves, disc = np.zeros((60, 60), np.uint8), np.zeros((side, side), np.uint8)
    halves[:, 30:] = disc[12:36, 12:36] = 1
    guide = ia.Guide(ia.Plane(halves, ia.Kind.LABEL), ia.Plane(disc, ia.Kind.LABEL))
    made, counts = {}, set()

    def seen(method, growth, window, found, bits, misses):
        counts.add(len(found.rows))
        return choose(method, growth, window, found, bits, misses)

    monkeypatch.setattr(engine, "choose", seen)
    for few in (1, 3):
        method = ia.PatchSampling(
            patch=6, overlap=4, repetition="none", boundary_candidates=few, boundary_patch=0,
            boundary_isometries="none", **DRAWN,
        )  # fmt: skip
        out = ia.synthesize(picture, side, method, guide=guide, seed=2, run=ia.Run(1))
        made[few] = out.map.yx
        inner = np.s_[20:28, 20:28]  # of windows inside the disc
        assert (halves[out.map.yx[..., 0], out.map.yx[..., 1]] == disc)[inner].all()
    assert (made[1] != made[3]).any()
    assert counts == {1}  # whatever is drawn was drawn on the way
    its, window = features([Exemplar.of(picture)]), (np.zeros((14, 14, 3), np.int16), np.ones((14, 14), np.uint8))
    for many in range(1, 6):
        costs = np.arange(many)
        drawn = {engine.draw_at_level(method, its, 3, costs, 1, [k, k], window, True) for k in range(200)}
        assert drawn == set(range(min(many, 3)))


@pytest.mark.parametrize(("height", "width"), [(35, 35), (40, 36), (60, 51)])
def test_the_number_of_valid_blocks(height: int, width: int) -> None:
    """Section 3.1: patch w_b, seam w_e on all sides, (W - w_b - 2 w_e + 1)(H - w_b - 2 w_e + 1) blocks."""
    e = Exemplar.of(bytes_of(height, width))
    growth = PatchSynthesis(settings_of(ia.PatchSampling(patch=25, overlap=5)), [e], Canvas(50, 50))
    assert growth.layout.patch == (35, 35)
    assert growth.variants.valid[0].sum() == (width - 34) * (height - 34)
    with pytest.raises(ParameterError, match="larger than the exemplar"):
        grow(bytes_of(34, width), 50, patch=25, overlap=5)


@pytest.mark.parametrize(("height", "width"), [(1, 24), (24, 1), (2, 24), (1, 1), (3, 24)])
def test_an_exemplar_that_is_too_narrow_for_seams_is_laid_without(height: int, width: int) -> None:
    """Nobody gave a patch or a seam: so none is refused that was found, neither here nor where a mask leaves rows."""
    made = ia.synthesize(ia.Exemplar.of(texture(height, width, 3, 4)), 12, "patch-sampling")
    assert made.method.overlap == (1 if min(height, width) > 2 else 0)  # type: ignore[attr-defined]
    rows = np.arange(24)[:, None] % 2 == np.zeros((1, 30))
    assert ia.synthesize(ia.Exemplar.of(texture(24, 30, 3, 4), usable=rows), 12, "patch-sampling").map.holes.sum() == 0


def test_distances_are_root_mean_squares_over_known_pixels_and_colours() -> None:
    """Section 3.3.3: d = sqrt((d_R**2 + d_G**2 + d_B**2) / 3) of the pixels themselves, on the 0..1 scale."""
    picture = bytes_of(26, 24, 3)
    picture[0, 0], picture[0, 1] = 0, 255  # the whole range: features are 1023/255 of the values
    drafts, windows = [], {}
    run = ia.Run(1, step=lambda done, total, draft: drafts.append(draft()))
    grown(picture, (18, 18), 3, run, windows, patch=6, overlap=3, channel_weights=(1, 1, 1), **PLAIN)
    last = drafts[3]  # the output just before the fourth window is searched
    known = ~last.holes[6:18, 6:18]
    old = picture[last.yx[6:18, 6:18, 0], last.yx[6:18, 6:18, 1]].astype(float) / 255
    unit = known.sum() * seam_unit(Exemplar.of(picture), (1, 1, 1))
    assert len(windows[1, 1].rows) == 32
    for squares, _, u, s in windows[1, 1].rows.tolist():
        diff = (old - picture[u : u + 12, s : s + 12].astype(float) / 255)[known]
        by_colour = np.sqrt((diff**2).mean(axis=0))
        assert np.sqrt(squares / unit) == pytest.approx(np.sqrt((by_colour**2).sum() / 3), abs=3e-3)


@pytest.mark.parametrize("n", [1, 2, 5, 20])
def test_any_of_the_n_best_is_chosen_and_no_other(n: int) -> None:
    """Section 3.3.4: uniformly among the n smallest distances, equal ones by place; never empty."""
    method = ia.PatchSampling(patch=4, overlap=3, candidates=n, **PLAIN)
    growth = grown(bytes_of(25, 25), (20, 20), patch=4, overlap=3, **PLAIN)
    at = np.array([growth.at((1, 1))], np.int64)
    work = growth.growing
    found = growth.finder.find(PartialMap(work.variant, work.yx, (False, False)), at, growth.repetition.search_prices)
    picks = [choose(method, growth, (1, 1), found[0], k << 32, []) for k in range(0, 1 << 32, 1 << 25)]
    assert set(picks) == {tuple(row[1:]) for row in found[0].rows[:n].tolist()}
    counts = [picks.count(p) for p in set(picks)]
    assert max(counts) - min(counts) <= 1


def test_the_epsilon_bound_is_the_source_s_and_says_when_nobody_passes() -> None:
    """Section 3.3.4: d < sqrt(mean of (eps R)**2); if none passes the best is taken, and the run notes it."""
    args, (strict, wide) = {"patch": 6, "overlap": 3, **PLAIN}, (ia.Run(1), ia.Run(1))
    out = grow(bytes_of(30, 30), 40, 2, strict, bound="epsilon", epsilon=0.0, **args)
    (note,) = strict.notes
    assert "no candidate within epsilon" in note
    np.testing.assert_array_equal(out.map.yx, grow(bytes_of(30, 30), 40, 2, candidates=1, **args).map.yx)
    grow(bytes_of(30, 30), 40, 2, wide, bound="epsilon", epsilon=100.0, **args)
    assert wide.notes == []


def test_the_epsilon_bound_counts_from_black() -> None:
    """Section 3.3.4: brighter by 100 the source's bound admits more."""
    dark, args = (bytes_of(40, 40) // 3).astype(np.uint8), {"patch": 6, "overlap": 3, **PLAIN}
    notes = []
    for picture in (dark, dark + 100):
        run = ia.Run(1)
        grow(picture, 60, 1, run, bound="epsilon", epsilon=0.25, **args)
        notes.append(int(run.notes[0].split()[0]) if run.notes else 0)
    assert notes[1] < notes[0]


def test_with_mixing_source_the_numbers_of_the_file_are_mixed() -> None:
    """Section 3.2.3: S = (1 - w) S_1 + w S_2 of brightness values; by default light is mixed, which is brighter."""
    exemplar = Exemplar.of(np.repeat([[40, 240]], 24, axis=1).repeat(48, axis=0).astype(np.uint8))
    yx = np.stack(np.mgrid[:12, :20], axis=2).astype(np.int32) + 12
    yx[:, 10:, 1] += 14  # the left half shows 40 for farther than the seam, the right half 240
    smap = SourceMap(yx, None, None, (exemplar.source,))
    ramp = [40 + round(200 * k / 5) for k in (1, 2, 3, 4)]
    rows = [np.asarray(render((exemplar,), smap, None, ia.Blend(4, m), None, ia.Run(1)).pixels)[6].ravel().tolist()
            for m in ("source", "mean")]  # fmt: skip
    assert rows[0][8:12] == ramp
    assert all(light > told for light, told in zip(rows[1][8:12], ramp, strict=True))


@pytest.mark.parametrize("we", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("join", ["middle", "feather"])
def test_straight_cuts_lie_in_the_middle_of_seams(we: int, join: str) -> None:
    """Sections 3.2.1, 3.2.3 and B.1.4: of the old picture the outer half of the seam stays, of two exemplars, too."""
    both = [Exemplar.of(bytes_of(19, 18)), Exemplar.of(bytes_of(16, 23, seed=1))]
    for wb in (3, 6):
        out = grow(both, (25, 21), 4, patch=wb, overlap=we, candidates=2, join=join, **PLAIN)
        assert out.blend.feather == (we if join == "feather" else 0)
        truth = NaivePatchSampling(both, (25, 21), wb, we, 2, 4).run()
        np.testing.assert_array_equal(out.map.yx, truth[:, :, 2:])
        np.testing.assert_array_equal(out.map.which, truth[:, :, 0])
        pieces = out.map.pieces()
        lines = set((np.flatnonzero((pieces[:, 1:] != pieces[:, :-1]).any(axis=0)) + 1).tolist())
        assert lines <= {k * (wb + we) - we + (we + 1) // 2 for k in range(1, 9)}


def test_the_isometries_are_the_group_of_the_square() -> None:
    """Sections 4.1.1 and B.1.5: the table, with 7 as (N-1-j, i); all distinct, closed, 5 of order four."""
    block = np.arange(25).reshape(5, 5)
    laid = [lay_down(block, k) for k in range(8)]
    for k, iso in enumerate(ISOMETRIES):
        start, j = np.array(iso.start(5, 5)), np.array(iso.j)
        assert all(laid[k][at] == block[tuple(start + j @ at)] for at in np.ndindex(5, 5))
    every = {a.tobytes() for a in laid}
    assert len(every) == 8
    assert all(lay_down(a, k).tobytes() in every for a in laid for k in range(8))
    np.testing.assert_array_equal(lay_down(lay_down(laid[5], 5), 5), laid[7])
    np.testing.assert_array_equal(laid[5], np.rot90(block))
    names = ["identity", "mirror left-right", "mirror up-down", "transpose", "anti-transpose"]
    assert [iso.name for iso in ISOMETRIES] == [*names, "rotate 90", "rotate 180", "rotate 270"]


@pytest.mark.parametrize("name", ["none", "180", "90", "both"])
def test_categories_of_isometries_through_the_method(name: str) -> None:
    """Sections 4.1.1 and 4.1.2: 1 + 3 + 4 variants; patches occur in their poses only, and all occur in a while."""
    assert {"none": (0,), "180": (0, 1, 2, 6), "90": (0, 3, 4, 5, 7), "both": tuple(range(8))} == ISOMETRY_SETS
    out = grow(bytes_of(30, 30), (160, 160), 1, patch=8, overlap=3, isometries=name, **PLAIN)
    assert out.map.poses == ISOMETRY_SETS[name]
    pixels = np.asarray(out.render(feather=0).pixels)
    np.testing.assert_array_equal(pixels, bytes_of(30, 30)[out.map.yx[..., 0], out.map.yx[..., 1]])
    with pytest.raises(ParameterError, match="not square"):
        grow(bytes_of(30, 30), 60, patch=(8, 6), overlap=3, isometries="90")


def test_marks_weigh_a_block_by_the_marks_of_its_pixels() -> None:
    """Section 4.2.1: the alternative: 1 + the mean number of uses of the block's pixels, here for one use."""
    growth = grown(bytes_of(40, 44), (1, 1), patch=4, overlap=3, repetition="marks", search="exact")
    (_, u, s), counts = growth.repetition.grid[0, 0, :3].tolist(), growth.repetition.search_prices.counts[0]
    used = np.zeros((40, 44))
    used[u : u + 10, s : s + 10] = 1
    for y in range(counts.shape[0]):
        for x in range(counts.shape[1]):
            assert counts[y, x] / 256 == pytest.approx(used[y : y + 10, x : x + 10].mean(), abs=0.03)


@pytest.mark.parametrize("rule", ["marks", "prices"])
def test_prevention_of_repetitions_spreads_the_use_of_the_exemplar(rule: str) -> None:
    """Section 4.2.1: more is shown than without; not so by the source's counter, by which a perfect repeat is free."""
    picture = TORTURE["pebbles_black"](size=96)
    maps = [grow(picture, 256, 1, patch=12, overlap=4, candidates=1, repetition=r).map.yx for r in ("none", rule)]
    shown = [len(np.unique(yx.reshape(-1, 2), axis=0)) for yx in maps]
    assert shown[1] >= shown[0]


def cost(side: int, wb: int, we: int) -> float:
    """Section 3.4: difference operations for each output pixel of a full search."""
    return (side - wb - 2 * we + 1) ** 2 * 2 * we * (wb + 2 * we) / (wb + 2 * we) ** 2


def cost_of_pyramid(side: int, wb: int, we: int) -> float:
    """Section 4.3.2: the same of the pyramid search: all of level 2, then a square of twice the block's side."""
    total = 0.0
    for level in (0, 1, 2):
        b, e = wb >> level, we >> level
        places = (side // 4 - b - 2 * e + 1) if level == 2 else (b + 2 * e + 1)
        total += places**2 * 2 * e * (b + 2 * e)
    return total / (wb + 2 * we) ** 2


@pytest.mark.parametrize("side", [100, 200])
def test_searches_look_at_as_many_places_as_the_laws_count(side: int) -> None:
    """Sections 3.4 and 4.3.2: the factors of the laws are those of the searches themselves.

    A full search measures every valid block on the known seam: the law counts the seam's corner twice. The pyramid
    measures all blocks of the coarsest level, then a square of twice the block's side, and 1 px of slack around it.
    """
    e, block = Exemplar.of(bytes_of(side, side)), 35
    growth = PatchSynthesis(settings_of(ia.PatchSampling(patch=25, overlap=5)), [e], Canvas(70, 70))
    known = np.zeros((block, block), bool)
    known[:5] = known[:, :5] = True
    places = growth.variants.valid[0].sum()
    assert (round(cost(side, 25, 5)), round(cost_of_pyramid(side, 25, 5))) == {100: (1245, 390), 200: (7873, 410)}[side]
    assert places * (known.sum() + 5 * 5) / block**2 == pytest.approx(cost(side, 25, 5))
    search = PatchSynthesis(
        settings_of(ia.PatchSampling(patch=25, overlap=5, pyramid="mean")), [e], Canvas(70, 70)
    ).finder
    total = 0.0
    for number, level in enumerate(search.levels):
        b, w = 25 >> number, 5 >> number
        assert level.window == (b + 2 * w,) * 2
        seen = level.allowed[0].size if number == 2 else np.prod(2 * level.reach + 1)
        within = seen if number == 2 else (2 * (level.reach[0] - 1) + 1) ** 2
        law = (side // 4 - b - 2 * w + 1) ** 2 if number == 2 else (b + 2 * w + 1) ** 2
        assert abs(within**0.5 - law**0.5) <= 1  # an odd side is halved to whole px
        total += seen * 2 * w * (b + 2 * w)
    assert 1 <= total / block**2 / cost_of_pyramid(side, 25, 5) < 1.2


def test_defaults_and_the_source_s_own() -> None:
    """Sections 3.3 and A.1: automatic sizes come from the elements; 25/5, n 5, epsilon 0.1 are accepted as they are."""
    m = ia.PatchSampling(patch=25, overlap=5)
    assert (m.candidates, m.epsilon, m.bound, m.isometries) == (5, 0.1, "best", "none")
    assert (m.pitch, m.footprint) == ((30, 30), (35, 35))
    for p, a in (("patch", 0), ("overlap", -1), ("candidates", 0), ("epsilon", -1)):
        with pytest.raises(ParameterError, match=p):
            ia.PatchSampling(**{p: a})
