"""parallel-controllable against its plain twin, and what Lefebvre and Hoppe and the memo promise (S4, D4)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from corrections.naive_correction import NaiveLevel, NaiveSynthesis

import intarsia as ia
from intarsia.corrections import stack as stack_of_levels
from intarsia.corrections.appearance import WEIGHTS, bordered, stack_of, transformed, unpacked_words, whole_products
from intarsia.corrections.coordinate_pyramid import PLACES_DRAWN, STAGE, CorrectionParameters, PyramidSynthesis
from intarsia.corrections.span import Span
from intarsia.corrections.stack import (
    SEARCHED,
    ComparisonSettings,
    border_distances,
    border_left_out,
    exemplar_stack,
    is_cloudy,
    jump_sets_of_grid,
    jump_spacing,
)
from intarsia.foundation.geometry import Box, Wrap
from intarsia.foundation.params import parameters, parse
from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas, Guide
from intarsia.model.image import Kind, Plane
from intarsia.testing.cases import noise, texture

ONE = Run(threads=1)
JOINED = 20  # px within which two copies are joined
UNSEEN, MOST, AGAIN = 0.1, 2.6, 0.11  # found: 0.07, 2.2, 0.08; before pieces were spread 0.22, 3.5, 0.16


def toy(height: int = 21, width: int = 18, *, toroidal: bool = False, channels: int = 3) -> Exemplar:
    return Exemplar.of(texture(height, width, channels, 5), toroidal=toroidal)


def test_of_large_exemplars_similar_places_are_looked_for_of_so_many_px() -> None:
    """Up to 512 x 512 of them on every level; what is smaller is looked at px by px where its levels are."""
    for height, width in ((512, 512), (513, 512), (640, 900), (1024, 1024), (1030, 1024), (64, 9000)):
        for h in (1, 2, 4, 8, 16):
            step = jump_spacing(h, height, width)
            assert step >= max(1, h // 2)
            assert height * width <= step * step * SEARCHED
            assert step == max(1, h // 2) or height * width > (step - 1) ** 2 * SEARCHED
    assert [jump_spacing(h, 4096, 4096) for h in (1, 2, 4, 16)] == [3, 5, 8, 8]  # the border of a level is 2 h px wide


def test_pixels_between_take_what_lies_beside_the_jump_of_a_neighbour(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if 20 x 20 px were many: every second px has places of its own, and all of them lie inside the exemplar."""
    e = Exemplar.of(texture(36, 40, 3, 8))
    monkeypatch.setattr(stack_of_levels, "SEARCHED", 400)
    level = exemplar_stack(e, ComparisonSettings()).levels[0]
    inner = level.inner.reshape(-1, level.stride)
    at = {int(n): (y, x) for y, row in enumerate(inner) for x, n in enumerate(row) if n >= 0}
    for y in range(36):
        for x in range(40):
            pair = (y, x), (y - y % 2, x - x % 2)
            here, first = ((b + level.border) * level.stride + a + level.border for b, a in pair)
            jump, of_first = int(level.jumps[here, 0]), int(level.jumps[first, 0])
            to = at[of_first][0] + y % 2, at[of_first][1] + x % 2
            inside = level.border <= to[0] < level.border + 36 and level.border <= to[1] < level.border + 40
            assert jump == (to[0] * level.stride + to[1] if inside else -1)


def naive(method: ia.ParallelControllable, e: Exemplar, seed: int) -> NaiveSynthesis:
    """The plain twin on the exemplar's own features and jump sets."""
    look, rules, levels = ComparisonSettings.of(method), CorrectionParameters.of(method), []
    stack = exemplar_stack(e, look)
    far = border_distances(e)
    for level in stack.levels:
        inner = slice(level.border, level.border + e.height), slice(level.border, level.border + e.width)
        if look.neighbourhood == "appearance":
            picture = unpacked_words(level.packed, level.stride)[inner]
        else:
            picture = level.values.reshape(-1, level.stride, level.values.shape[1])[inner]
        closed = far <= border_left_out(level.h, far, is_cloudy(e))
        cells = jump_sets_of_grid(level, closed, e.toroidal, look.k - 1)
        colours = _weights(look) if look.neighbourhood == "colour" else None
        levels.append(NaiveLevel(level.h, picture, e.toroidal, ~closed, cells, max(1, level.h // 2), colours))
    side = round(rules.subpasses**0.5)
    return NaiveSynthesis(
        (e.height, e.width), levels, stack.count, rules.spread, rules.factor, method.passes, side, rules.rule,
        seed, STAGE, PLACES_DRAWN,
    )  # fmt: skip


def _weights(look: ComparisonSettings) -> list[float]:
    """Of squared differences, as the memo has them: those that are given, or a Gaussian, a quarter in 2 px."""
    taps = [(dy, dx) for dy in (-2, -1, 0, 1, 2) for dx in (-2, -1, 0, 1, 2)]
    return list(look.neighbourhood_mask or (4.0 ** (-(dy * dy + dx * dx) / 4) for dy, dx in taps))


BASE = ia.ParallelControllable(jitter=(0.3, 0.2, 0.5), passes=1)
MEMO = ia.Correction2008(jitter=(0.3, 0.2, 0.5), passes=1)
SET = replace(MEMO, neighbourhood="appearance", rule="near")  # as BASE, and all that a memorandum sets can be set
VARIANTS = [
    BASE,
    replace(SET, rule="published", k=3),
    MEMO,
    replace(BASE, kappa="inf"),
    replace(SET, kappa=1, k=3),
    replace(SET, passes=2, subpasses=1),
    replace(SET, subpasses=9, k=1),
    replace(MEMO, rule="near", neighbourhood_mask=(0.5, 1, 0, 1, 0.3, 1, 0.25, 0.125, 1)),
    replace(BASE, jitter=(0.3, 0, 0, 0, 1)),
]


@pytest.mark.parametrize("toroidal", [False, True])
@pytest.mark.parametrize("method", VARIANTS, ids=str)
def test_the_kernels_do_what_the_plain_twin_does(method: ia.ParallelControllable, toroidal: bool) -> None:
    """Hash, descent, subpasses, candidates, ties and prices."""
    e = toy(toroidal=toroidal)
    box = Box(-3, 1 << 33, 2, (1 << 33) + 6)
    got = method.window([e], box, 11, ONE).yx
    twin = naive(method, e, 11)
    expected = [[twin.final(y, x) for x in range(box.x0, box.x1)] for y in range(box.y0, box.y1)]
    assert got.tolist() == [[list(u) for u in row] for row in expected]


def test_a_mask_weighs_pixels() -> None:
    """Colours are multiplied by the roots of the weights; a Gaussian unless others are given; 3 x 3 lie in 5 x 5."""
    e, colour = toy(), replace(MEMO, rule="near")
    mask = exemplar_stack(e, ComparisonSettings.of(colour)).levels[0].roots.reshape(5, 5)
    assert mask[2].tolist() == [128, 215, 256, 215, 128]
    nine = replace(colour, neighbourhood_mask=(0.5, 1, 0, 1, 0.3, 1, 0.25, 0.125, 1))
    mask = exemplar_stack(e, ComparisonSettings.of(nine)).levels[0].roots.reshape(5, 5)
    assert mask[1:4, 1:4].tolist() == [[181, 256, 0], [256, 140, 256], [128, 91, 256]]
    assert not mask[[0, 4]].any()
    assert not mask[:, [0, 4]].any()
    maps = {ia.synthesize(e, 90, m, run=ONE).map.digest for m in (colour, nine)}
    assert len(maps) == 2


def test_without_jitter_a_torus_is_tiled_exactly() -> None:
    """Also of a size that is no power of two, with any candidates, on coordinates below 0."""
    e = toy(37, 50, toroidal=True)
    for m in (ia.ParallelControllable(jitter=0), ia.Correction2008(jitter=0, rule="near", kappa=1)):
        got = m.window([e], Box(-70, -60, 90, 80), 3, ONE).yx
        y, x = np.mgrid[-70:90, -60:80]
        assert (got == np.stack([y % 37, x % 50], axis=2)).all()


def test_without_jitter_an_exemplar_is_copied_and_joined_at_its_borders_only() -> None:
    """Copies side by side; beyond JOINED px from where they meet each pixel is their own."""
    e = Exemplar.of(texture(200, 137, 3, 5))
    got = ia.ParallelControllable(jitter=0).window([e], Box(-200, 0, 200, 274), 3, ONE).yx
    y, x = np.mgrid[-200:200, :274]
    own = (got == np.stack([y % 200, x % 137], axis=2)).all(axis=2)
    away = np.minimum(np.minimum(y % 200, 199 - y % 200), np.minimum(x % 137, 136 - x % 137))
    assert own[away >= JOINED].all()
    assert not own[away < 2].any()
    on = (got[:, 1:] == got[:, :-1] + (0, 1)).all(axis=2)
    assert on.mean() > 0.9
    border = np.minimum(np.minimum(got[..., 0], 199 - got[..., 0]), np.minimum(got[..., 1], 136 - got[..., 1]))
    assert border.min() >= 2, "nothing is compared with what lies beyond the border"


def test_large_pieces_keep_away_from_what_they_show_already() -> None:
    """No pixel of the exemplar is shown far more often than others, and few again within a quarter of the exemplar."""
    e = Exemplar.of(texture(128, 128, 3, 5))
    uneven, again = [], []
    for seed in range(4):
        out = ia.synthesize(e, 512, ia.ParallelControllable(), seed=seed, run=ONE).map
        used = np.sort(out.usage()[0].ravel() / 16)
        uneven.append(((used == 0).mean(), used[-164:].mean()))
        cells = out.yx[::8, ::8] // 6
        named = cells[..., 0] * 1000 + cells[..., 1]
        near = [(dy, dx) for dy in range(-6, 7) for dx in range(-6, 7) if 9 <= dy * dy + dx * dx <= 36]
        inner = named[6:-6, 6:-6]
        found = [inner == named[6 + dy : len(named) - 6 + dy, 6 + dx : len(named) - 6 + dx] for dy, dx in near]
        again.append(np.any(found, axis=0).mean())
    assert np.mean(uneven, axis=0)[0] < UNSEEN
    assert np.mean(uneven, axis=0)[1] < MOST
    assert np.mean(again) < AGAIN


@pytest.mark.parametrize("method", [ia.ParallelControllable(), VARIANTS[2], VARIANTS[6]], ids=str)
def test_windows_are_crops(method: ia.ParallelControllable) -> None:
    """Windows across 0 and +-2**31, of 200 x 137 px that are no torus."""
    e = Exemplar.of(texture(137, 200, 3, 8))
    for y, x in ((-20, -31), (2**31 - 33, -(2**31) - 17), (-(2**31) - 5, 2**31 - 40), (2**40 - 90, -(2**40))):
        whole = method.window([e], Box(y, x, y + 90, x + 70), 5, ONE)
        for part in (Box(11, 13, 75, 70), Box(0, 40, 33, 41), Box(89, 0, 90, 70)):
            alone = method.window([e], Box(y + part.y0, x + part.x0, y + part.y1, x + part.x1), 5, ONE)
            assert alone.digest == whole.window(part).digest


def test_threads_change_nothing() -> None:
    e = Exemplar.of(texture(64, 64, 3, 8))
    digests = {ia.synthesize(e, (300, 260), ia.ParallelControllable(), run=Run(n)).map.digest for n in (1, 2, 4)}
    assert len(digests) == 1


def test_infinite_and_equal_prices() -> None:
    """With inf no jump is made, whatever k is; 1 and a little more differ; the price is squared."""
    e = Exemplar.of(texture(48, 48, 3, 8))
    m = ia.ParallelControllable(kappa="inf", jitter=0.5)
    maps = {ia.synthesize(e, 120, replace(SET, kappa="inf", k=k)).map.digest for k in (1, 2, 4)}
    assert len(maps) == 1
    assert ia.ParallelControllable(kappa=float("inf")) == ia.ParallelControllable(kappa="inf")
    prices = {ia.synthesize(e, 120, replace(m, kappa=price)).map.digest for price in (1, 1.5, "inf")}
    assert len(prices) == 3
    assert CorrectionParameters.of(replace(m, kappa=1.5)).factor == 576


def test_without_jumps_both_rules_are_one() -> None:
    """Near and published have the same proximity sets."""
    e = Exemplar.of(texture(48, 48, 3, 8))
    m = ia.Correction2008(kappa="inf", jitter=0.5, neighbourhood="appearance")
    first, second = (ia.synthesize(e, 120, replace(m, rule=c)).map.digest for c in ("near", "published"))
    assert first == second


@pytest.mark.parametrize("toroidal", [False, True])
@pytest.mark.parametrize("h", [1, 2, 8])
def test_jumps_lead_elsewhere(h: int, toroidal: bool, thorough: bool) -> None:
    """Never to the pixel itself or what lies beside it, and nowhere that is closed; of every pixel, or every fifth."""
    e = Exemplar.of(texture(60, 44, 3, 8), toroidal=toroidal)
    level = exemplar_stack(e, ComparisonSettings(k=4)).levels[h.bit_length() - 1]
    closed = np.zeros((60, 44), bool)
    closed[:5] = True
    table = level.table.reshape(-1, 32)
    cells = jump_sets_of_grid(level, closed, toroidal, 3)
    step, apart = max(1, h // 2), max(3, h)
    found, least = 0, 0
    for i in range(cells.shape[0]):
        for j in range(i % 5, cells.shape[1], 1 if thorough or h > 2 else 5):
            u = (i * step, j * step)
            known = [u] + [tuple(c) for c in cells[i, j].tolist() if c[0] >= 0]
            assert len(known) == 4
            for n, a in enumerate(known):
                for b in known[:n]:
                    gaps = [abs(p - q) for p, q in zip(a, b, strict=True)]
                    if toroidal:
                        gaps = [min(g, s - g) for g, s in zip(gaps, (60, 44), strict=True)]
                    assert max(gaps) >= apart
                assert n == 0 or not closed[a]
            distances = to_all(table, level, (60, 44), closed, u, step, apart, toroidal)
            found, least = found + distances[known[1]], least + min(distances.values())
    assert least <= found < 1.3 * least, "the tree looks into a few leaves only"


@pytest.mark.parametrize("toroidal", [False, True])
@pytest.mark.parametrize("k", [2, 3])
def test_similar_places_go_on_beside_a_pixel(k: int, toroidal: bool) -> None:
    """What lies beside the places of the pixel to the right and below is never nearer than a pixel's own nearest.

    On average these are hardly further than the nearest of all, which are looked for one by one.
    """
    e = Exemplar.of(texture(61, 45, 3, 8), toroidal=toroidal)
    level = exemplar_stack(e, ComparisonSettings(k=k)).levels[0]
    closed = np.zeros((61, 45), bool)
    closed[:5] = True
    table = level.table.reshape(-1, 32)
    cells = jump_sets_of_grid(level, closed, toroidal, k - 1)
    own, least = [], []
    for y in range(cells.shape[0] - 1):
        for x in range((3 * y) % 4, cells.shape[1] - 1, 4):
            distances = to_all(table, level, (61, 45), closed, (y, x), 1, 3, toroidal)
            own.append(distances[tuple(cells[y, x, 0].tolist())])
            least.append(min(distances.values()))
            for dy, dx in ((1, 0), (0, 1)):
                to = cells[y + dy, x + dx, 0] - (dy, dx)
                if toroidal:
                    to %= (61, 45)
                assert own[-1] <= distances.get(tuple(to.tolist()), own[-1]), "those after a pixel are told last"
    assert sum(own) < 1.06 * sum(least)


def to_all(table, level, size, closed, u, step, apart, toroidal):  # type: ignore[no-untyped-def]
    """Squared distances to all pixels that may be jumped to, by brute force."""
    y, x = (c.ravel() for c in np.mgrid[: size[0] : step, : size[1] : step])
    dy, dx = abs(y - u[0]), abs(x - u[1])
    if toroidal:
        dy, dx = np.minimum(dy, size[0] - dy), np.minimum(dx, size[1] - dx)
    rows = table[(y + level.border) * level.stride + x + level.border].astype(np.int64)
    own = table[(u[0] + level.border) * level.stride + u[1] + level.border].astype(np.int64)
    d = ((rows - own) ** 2).sum(axis=1)
    fit = (np.maximum(dy, dx) >= apart) & ~closed[y, x]
    return {(int(y[k]), int(x[k])): int(d[k]) for k in np.flatnonzero(fit)}


def test_the_stack_is_blurred_more_and_more() -> None:
    """Any size, full size on every level; a torus is shifted with its picture."""
    picture = texture(23, 30, 2, 1).astype(np.int16)
    stack = list(stack_of(picture, 4, (True, True)))
    assert [s.shape for s in stack] == [(23, 30, 2)] * 4
    spreads = [s.astype(float).var() for s in stack]
    assert spreads == sorted(spreads, reverse=True)
    moved = list(stack_of(np.roll(picture, (5, 7), (0, 1)), 4, (True, True)))
    assert all((np.roll(a, (5, 7), (0, 1)) == b).all() for a, b in zip(stack, moved, strict=True))
    flat = list(stack_of(np.full((9, 11, 1), 700, np.int16), 3, (False, False)))
    assert all((s == 700 << 4).all() for s in flat)


def test_appearance_vectors_are_projections() -> None:
    """Whole projections of weighted 5 x 5 neighbourhoods, in plain numpy, with most of the energy."""
    _, picture = stack_of(texture(24, 20, 3, 1).astype(np.int16) * 4, 2, (False, False))
    got = transformed(picture, 2, False)
    assert got.dtype == np.int16
    assert np.abs(got).max() <= 1023
    around = bordered((picture + 4) >> 3, 4, False).astype(float)
    taps = [around[dy : dy + 24, dx : dx + 20] for dy in range(0, 9, 2) for dx in range(0, 9, 2)]
    vectors = np.concatenate([t * w / 256 for t, w in zip(taps, WEIGHTS, strict=True)], axis=2).reshape(480, -1)
    vectors -= vectors.mean(axis=0)
    energy = np.linalg.svd(vectors, compute_uv=False) ** 2
    kept = got.reshape(480, -1).astype(float)
    spread = (kept - kept.mean(axis=0)).var(axis=0)
    share = spread / spread.sum()
    assert np.allclose(share, energy[:8] / energy[:8].sum(), atol=0.01)
    assert energy[:8].sum() > 0.8 * energy.sum()


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (3, 2), (70, 9), (33, 64)])
@pytest.mark.parametrize("toroidal", [False, True])
def test_any_shape_will_do(shape: tuple[int, int], toroidal: bool) -> None:
    """Where the exemplar is smaller than a neighbourhood nothing is corrected."""
    e = Exemplar.of(texture(*shape, 3, 2), toroidal=toroidal)
    out = ia.synthesize(e, (40, 50), ia.ParallelControllable(jitter=0.5), wrap="both", run=ONE)
    assert not out.map.holes.any()
    assert len(exemplar_stack(e, ComparisonSettings(k=2)).levels) == sum(4 * (1 << n) < min(shape) for n in range(7))


def test_large_exemplars_keep_their_coordinates() -> None:
    """Beyond what 8 or 16 bits hold."""
    e = Exemplar.of(texture(6, 70000, 1, 2))
    got = ia.ParallelControllable(jitter=0.001).window([e], Box(0, 66000, 6, 66200), 1, ONE).yx
    assert got[..., 1].max() > 65535


def test_a_torus_closes_on_any_size() -> None:
    """Wrapped sizes that are no powers of two: neighbours across the border go on about as often as inside."""
    e, border, inside = Exemplar.of(texture(64, 64, 3, 8)), [], []
    for seed in range(8):
        yx = ia.synthesize(e, (131, 77), ia.ParallelControllable(), wrap="both", seed=seed).map.yx.astype(int)
        for axis, step in ((0, (1, 0)), (1, (0, 1))):
            on = (np.roll(yx, -1, axis) == yx + step).all(axis=2).mean(axis=1 - axis)
            border.append(on[-1])
            inside.append(on[:-1].mean())
    assert np.mean(border) > 0.9 * np.mean(inside)


@pytest.mark.parametrize("toroidal", [False, True])
def test_snapped_jitter_keeps_to_the_lattice(toroidal: bool) -> None:
    """However far away, and across the exemplar's border, pixels stay in step with a lattice of fractions."""
    vectors = ((9.5, 0.0), (4.75, 7.25))
    e = Exemplar.of(texture(58, 76, 3, 1), toroidal=toroidal)
    m = ia.ParallelControllable(jitter=(0, 0, 0.5), keep_lattice="on", lattice=vectors, passes=0)
    for y0, x0 in ((0, 0), (-(2**40), 2**39)):
        yx = m.window([e], Box(y0, x0, y0 + 70, x0 + 90), 3, ONE).yx.astype(object)
        moved = np.stack([yx[..., 0] - np.arange(y0, y0 + 70)[:, None], yx[..., 1] - np.arange(x0, x0 + 90)], axis=2)
        rows = moved[..., 0] * 4 / 29
        assert (abs(rows - np.vectorize(round)(rows)) < 0.3).all(), "courses of 7.25 px"
        down = np.vectorize(round)(rows)
        along = (moved[..., 1] * 4 - 19 * down) / 38
        assert (abs(along - np.vectorize(round)(along)) < 0.25).all()
        assert len({(a, b) for a, b in moved.reshape(-1, 2).tolist()}) > 8
    free = replace(m, snap="off", lattice=None).window([e], Box(0, 0, 70, 90), 3, ONE).yx
    off = (free[..., 0] - np.arange(70)[:, None]) * 4 / 29
    assert (abs(off - off.round()) > 0.3).any()


def test_a_lattice_is_found_where_it_is_asked_for() -> None:
    found = ia.synthesize("sample:tiles", 64, ia.ParallelControllable(keep_lattice="on"), run=ONE).method
    assert isinstance(found, ia.ParallelControllable)
    assert found.lattice is not None
    with pytest.raises(ia.MethodError, match="parallel-controllable finds no lattice"):
        ia.synthesize(Exemplar.of(np.zeros((40, 40, 3), np.uint8)), 64, ia.ParallelControllable(keep_lattice="on"))
    with pytest.raises(ia.ParameterError, match="snap=off moves pixels by no lattice"):
        ia.ParallelControllable(lattice=((9.5, 0.0),), keep_lattice="off")


def test_pixels_snap_where_there_is_a_lattice() -> None:
    """Automatically, on all levels; not under a guide, which may be painted over several textures."""
    canvas, tiles = Canvas(64, 64), ia.read("sample:tiles")
    resolved = ia.ParallelControllable().resolved([tiles], canvas)
    assert (resolved.snap, len(resolved.lattice or ())) == ("on", 2)
    assert resolved == ia.ParallelControllable(keep_lattice="on").resolved([tiles], canvas)
    assert resolved.jitter == (0, 0, 0.1, *[0.2] * 4, 1, 1)
    assert ia.ParallelControllable(lattice=((9.5, 0.0),)).resolved([tiles], canvas).lattice == ((9.5, 0),)
    assert ia.ParallelControllable().resolved([toy()], canvas).snap == "off"
    labels = Plane(np.zeros((tiles.height, tiles.width), np.uint8), Kind.LABEL)
    guide = Guide(labels, Plane(np.zeros((64, 64), np.uint8), Kind.LABEL))
    assert ia.ParallelControllable().resolved([tiles], Canvas(64, 64, guide=guide)).snap == "off"


def test_subpasses_settle_what_swings() -> None:
    """Corrected all at once, more pixels still move from the sixth pass to the seventh."""
    e, n = Exemplar.of(texture(64, 64, 3, 8)), 256
    stack = exemplar_stack(e, ComparisonSettings(k=2))
    start = ia.ParallelControllable(jitter=(1, 1, 0.5), passes=0).window([e], Box(0, 0, n, n), 3, ONE).yx
    moving = []
    for subpasses in (1, 4):
        maps = []
        for passes in (6, 7):
            rules = CorrectionParameters((0,), 1024, passes, subpasses, "near")
            done = PyramidSynthesis(stack, rules, 0)._corrected(start, 0, [(Span(0, n, 0), Span(0, n, 0))], ONE)
            edge = 60 - rules.margin
            maps.append(done[edge : len(done) - edge, edge : len(done) - edge])
        moving.append((maps[0] != maps[1]).any(axis=2).mean())
    assert moving[1] < 0.5 * moving[0]


@pytest.mark.parametrize(("share", "cloudy"), [(0.1, False), (0.22, False), (0.4, True)])
def test_clouds_are_three_tenths_of_what_is_seen(share: float, cloudy: bool) -> None:
    """What is wider than 16 px makes up so much of the variance."""
    y, x = np.mgrid[:256, :256]
    slow = np.sin(2 * np.pi * x / 128) + np.sin(2 * np.pi * y / 128)
    fine = (noise(256, 256, 3) % np.uint64(1000)).astype(float) / 1000
    field = slow / slow.std() * share**0.5 + (fine - fine.mean()) / fine.std() * (1 - share) ** 0.5
    assert is_cloudy(Exemplar.of((128 + 30 * field).clip(0, 255).astype(np.uint8))) == cloudy


def test_appearance_does_not_depend_on_the_order_of_sums() -> None:
    """What is summed in doubles is whole and below 2**53, so that any order gives the same."""
    vectors = np.floor(np.random.default_rng(0).integers(-16384, 16384, (8192, 75))).astype(float)
    products = whole_products(vectors)
    assert (products == np.floor(products)).all()
    assert products.max() < 2**53
    assert (whole_products(vectors[::-1].copy()) == products).all()
    centred = [int(v) for v in vectors[:, 3] - np.floor(vectors[:, 3].sum() / 8192)]
    assert products[3, 3] == sum(v * v for v in centred)


def test_masked_pixels_are_never_shown_nor_compared() -> None:
    """What lies under the mask does not matter, and is nowhere shown."""
    pixels, usable = texture(60, 70, 3, 4), np.ones((60, 70), bool)
    usable[20:30, 40:52] = False
    other = pixels.copy()
    other[~usable] = 255 - other[~usable]
    maps = [ia.synthesize(Exemplar.of(p, usable=usable), 128, ia.ParallelControllable()).map for p in (pixels, other)]
    assert (maps[0].yx == maps[1].yx).all()
    assert usable[maps[0].yx[..., 0], maps[0].yx[..., 1]].all()


def test_what_cannot_work_is_refused() -> None:
    for values, told in (
        ({"subpasses": 5}, "subpasses=5 is not allowed; choose 1, 4, 9 or 16"),
        ({"kappa": 0.5}, "kappa=0.5 is not allowed; give 1 to 1000, or inf"),
        ({"jitter": (0.1, 2)}, "jitter=.* is not allowed; give 0 to 1, one number or one for each level"),
        ({"jitter": ()}, "jitter=.* is not allowed"),
        ({"neighbourhood": "appearance", "neighbourhood_mask": (1.0,) * 9}, "mask needs neighbourhood=colour"),
        ({"neighbourhood_mask": (1.0,) * 7}, "of 7 numbers is not allowed; give 25"),
    ):
        with pytest.raises(ia.ParameterError, match=told):
            ia.Correction2008(**values)
    with pytest.raises(ia.ParameterError, match="within 2\\*\\*48 px"):
        ia.ParallelControllable().window([toy()], Box(0, 0, 1, (1 << 48) + 1), 0, ONE)


def test_margins_are_those_that_are_needed() -> None:
    """They stay bounded from level to level."""
    e = toy(100, 100)
    descent = PyramidSynthesis(
        exemplar_stack(e, ComparisonSettings(k=2)), CorrectionParameters.of(replace(BASE, passes=2)), 0
    )
    spans = descent._spans(Span(0, 1, 0), Span(0, 1, 0))
    assert [s[0].stop - s[0].start for s in spans][:4] == [33, 49, 57, 61]
    assert max(s[0].stop - s[0].start for s in spans) <= 1 + 2 * 34
    assert Canvas(1, 1).wrap is Wrap.NONE


def test_a_pin_shows_what_was_dragged_there() -> None:
    """The middle of the disc is the feature itself, in windows and across a wrapped border, too."""
    e = Exemplar.of(texture(96, 80, 3, 5))
    m = ia.ParallelControllable(pin=((40, 50, 10, 70, 24),))
    whole = m.window([e], Box(0, -40, 130, 90), 3, ONE)
    y, x = np.mgrid[62:79, 2:19]
    shown = (whole.yx[62:79, 42:59] == np.stack([y - 70 + 50, x - 10 + 40], axis=2)).all(axis=2)
    assert shown.mean() > 0.95
    free = replace(m, pin=None).window([e], Box(0, -40, 130, 90), 3, ONE)
    assert not (free.yx[62:79, 42:59] == whole.yx[62:79, 42:59]).all()
    far = Box(-2000, -40, -1940, 60)
    assert m.window([e], far, 3, ONE).digest == replace(m, pin=None).window([e], far, 3, ONE).digest
    assert m.window([e], Box(55, -5, 90, 20), 3, ONE).digest == whole.window(Box(55, 35, 90, 60)).digest
    torus = ia.synthesize(e, (131, 150), replace(m, pin=((40, 50, 149, 0, 24),)), wrap="both", run=ONE).map.yx
    assert (torus[0, 0] == (50, 41)).all()
    assert (torus[130, 149] == (49, 40)).all()


def test_pins_are_read_as_they_are_written() -> None:
    (p,) = (p for p in parameters(ia.ParallelControllable) if p.name == "pin")
    assert parse(p, "40,30 -> 200,120 24; 1,2->-3,4 5") == ((40, 30, 200, 120, 24), (1, 2, -3, 4, 5))
    for text in ("40,30 200,120 24", "40,30 -> 200,120", ""):
        with pytest.raises(ia.ParameterError, match="give exemplar x,y -> output x,y and a radius"):
            parse(p, text)
    with pytest.raises(ia.ParameterError, match=r"pin=.* is not allowed"):
        ia.ParallelControllable(pin=((1, 2, 3, 4, 0),))
