"""Even use of the exemplar: what showings cost, how they are counted, and that pictures use all they are given."""

from __future__ import annotations

from collections import Counter
from itertools import product

import numpy as np
import pytest
from seams.sewing import empty_of

import intarsia as ia
from intarsia.analysis.saliency import MAX_WEIGHT, MEDIAN
from intarsia.kernels.maxflow import ABSENT, FREE, NEW, OLD
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.seams import occurrence_kernels
from intarsia.seams import occurrences as pricing
from intarsia.seams.graphcut_moves import expand, fill
from intarsia.seams.graphcut_textures import Cut, GraphcutMap
from intarsia.seams.occurrence_kernels import SHARE, Usage
from intarsia.seams.occurrences import RIM, border_counts, repeat_costs
from intarsia.testing import texture

ONE = ia.Run(1)


def grown(exemplars: list[Exemplar], canvas: Canvas, **given: object) -> GraphcutMap:
    sewn = empty_of(exemplars, canvas, **given)
    fill(sewn, 3, 7, ONE)
    expand(sewn, ONE, 1)
    return sewn


@pytest.mark.parametrize("seed", range(12))
def test_every_pixel_costs_what_its_showings_cost(seed: int) -> None:
    dice = np.random.default_rng(seed)
    usage = Usage(
        dice.integers(0, 9, 40).astype(np.int32), dice.integers(0, 900, 9).astype(np.int32),
        dice.integers(1, 9, 9).astype(np.int32),
    )  # fmt: skip
    old, new = dice.integers(-1, 40, (2, 5, 6)).astype(np.int32)
    state, step = dice.integers(0, 4, (5, 6)).astype(np.uint8), int(dice.integers(1, 5))
    more = np.full((5, 6), 77, np.int64)
    sure = occurrence_kernels.price_usage(usage, step, old, new, state, more)
    told = 0
    for y, x in product(range(5), range(6)):
        cost = 0
        if state[y, x] in (FREE, NEW):
            k, was = usage.origin[new[y, x]], usage.origin[old[y, x]]
            cost += int(usage.rate[k]) * int(usage.shown[k]) if new[y, x] >= 0 else 0
            cost -= int(usage.rate[was]) * (int(usage.shown[was]) - 1) if old[y, x] >= 0 else 0
        assert more[y, x] == cost * step // SHARE
        told += int(more[y, x]) if state[y, x] == NEW or more[y, x] < 0 else 0
    assert sure == told
    assert {OLD, FREE, NEW, ABSENT} == {0, 1, 2, 3}


def test_what_strikes_is_dearer_up_to_a_limit() -> None:
    common = np.full(54, MEDIAN)
    strikes = [np.array([[MEDIAN, 2 * MEDIAN, 3 * MEDIAN], [16 * MEDIAN, 0, MEDIAN]]), common]
    assert repeat_costs(strikes, 4, 2)[:6].tolist() == [2 * SHARE * n for n in (1, 1, 5, MAX_WEIGHT, 0, 1)]
    assert repeat_costs(strikes, 4, 2, in_step=True)[:6].tolist() == [
        2 * SHARE * n for n in (0, 1, 5, MAX_WEIGHT, 0, 0)
    ]


def test_what_many_pixels_do_does_not_strike() -> None:
    """Letters on paper are all far from the median, and as common as the paper."""
    letters = np.full(20, 4 * MEDIAN)
    strikes = [np.concatenate([letters, np.full(79, MEDIAN), [8 * MEDIAN]])]
    found = repeat_costs(strikes, 4, 2)
    assert (found[:-1] == 2 * SHARE).all()
    assert found[-1] == 2 * SHARE * 17
    assert (repeat_costs(strikes, 4, 2, in_step=True) == 2 * SHARE * np.repeat([1, 0, 17], [20, 79, 1])).all()
    few = [np.concatenate([letters[:9], np.full(91, MEDIAN)])]
    assert (repeat_costs(few, 4, 2)[:9] == 2 * SHARE * 17).all()


@pytest.mark.parametrize("toroidal", [False, True])
def test_the_rim_counts_as_shown(toroidal: bool) -> None:
    """By how far the nearest px is that is none, of the exemplar and around it: as often as is due, less further in."""
    usable = np.ones((31, 37), bool)
    usable[12:14, 20:23] = usable[0, 0] = False
    want = np.zeros((31, 37), int)
    around = np.pad(usable, 10, mode="wrap" if toroidal else "constant")
    gone = np.argwhere(~around) - 10
    for y, x in np.argwhere(usable):
        far = np.abs(gone - (y, x)).max(axis=1).min()
        want[y, x] = np.rint(3.5 * max(RIM + 1 - far, 0) / RIM)
    np.testing.assert_array_equal(border_counts(usable, toroidal, 3.5), want)
    assert want.max() == 4
    assert border_counts(np.ones((31, 37), bool), True, 3.5).max() == 0


def test_cuts_keep_away_from_the_exemplars_border(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of all px of cuts a fifth more ends a piece beside its border where the rim counts as shown by none."""
    shares = []
    for _ in range(2):
        near = total = 0
        for seed in range(1, 5):
            e = ia.read("sample:stones")
            yx = ia.synthesize(e, 400, ia.Graphcut(), seed=seed).map.yx.astype(int)
            for axis in (0, 1):
                here, there = (np.moveaxis(yx, axis, 0)[part] for part in (np.s_[:-1], np.s_[1:]))
                seam = (there - here != np.eye(2, dtype=int)[axis]).any(axis=-1)
                last = np.minimum(e.free.shape[axis] - 1 - here[..., axis], there[..., axis])[seam]
                near, total = near + int((last <= 2).sum()), total + last.size
        shares.append(near / total)
        monkeypatch.setattr(pricing, "border_counts", lambda usable, toroidal, due: np.zeros(usable.shape, np.int32))
    assert shares[1] > 1.2 * shares[0], shares


@pytest.mark.parametrize("poses", ["none", "both"])
def test_what_is_counted_is_what_the_map_shows(poses: str) -> None:
    exemplars = [Exemplar.of(texture(40, 44, 3, 1)), Exemplar.of(texture(30, 36, 3, 2), toroidal=True)]
    sewn = grown(exemplars, Canvas(90, 80, "x"), isometries=poses)
    made, seen = sewn.growth.map(ia.Blend(0)), Counter[tuple[int, int, int]]()
    for y, x in product(range(90), range(80)):
        seen[int(made.numbers[y, x]), *made.yx[y, x].tolist()] += 1
    begin = 0
    for number, e in enumerate(exemplars):
        shown = sewn.usage.shown[begin : begin + e.height * e.width].reshape(e.height, e.width)
        shown = shown - border_counts(e.free, e.toroidal, 90 * 80 / (40 * 44 + 30 * 36))
        assert all(shown[y, x] == seen[number, y, x] for y, x in product(range(e.height), range(e.width)))
        begin += e.height * e.width


def test_what_a_canvas_begins_with_counts() -> None:
    e = Exemplar.of(texture(40, 44, 3, 1))
    start = ia.synthesize(e, (60, 60), ia.Graphcut(patch=16, overlap=6), seed=1).map
    sewn = empty_of([e], Canvas(60, 60, start=start))
    shown = sewn.usage.shown.reshape(40, 44) - border_counts(e.free, False, 3600 / (40 * 44))
    assert shown.sum() == 3600
    np.testing.assert_array_equal(shown, start.usage()[0])


def test_an_accepted_cut_makes_seams_and_usage_together_cheaper(monkeypatch: pytest.MonkeyPatch) -> None:
    """The energy is the seams, and for every pixel its rate for each pair of its showings; seams alone may rise."""
    sewn, seams = grown([Exemplar.of(texture(60, 60, 3, 40))], Canvas(140, 140), evenness=4), list[int]()
    write = sewn.write

    def usage() -> float:
        shown = sewn.usage.shown.astype(int)
        return float((sewn.usage.rate * shown * (shown - 1) // 2).sum()) / SHARE

    def noted(cut: Cut) -> None:
        before = sewn.total
        write(cut)
        sewn.note(cut)
        seams.append(sewn.total - before)

    monkeypatch.setattr(sewn, "write", noted)
    before = sewn.total + usage()
    saved = expand(sewn, ONE, 3)
    assert min(saved) > 0
    assert sewn.total + usage() < before
    assert max(seams) > 0


def test_the_dearer_repeats_are_the_more_evenly_is_an_exemplar_used() -> None:
    """Of six exemplars together: of a single one the second share may be anything from 0.7 to 0.9."""
    methods = [ia.Graphcut(patch=24, evenness=price) for price in (0, 1, 4)]
    spread = [
        sum(ia.synthesize(texture(96, 96, 3, n), 192, m, seed=n).map.usage()[0].var() for n in range(1, 7))
        for m in methods
    ]
    assert spread[1] < 0.7 * spread[0]
    assert spread[2] < 0.85 * spread[1]


def test_in_step_only_what_clearly_strikes_costs() -> None:
    """And as much as elsewhere: all else returns by the lattice anyway."""
    pixels = np.random.default_rng(2).integers(60, 190, (72, 80, 3)).astype(np.uint8)
    pixels[30:38, 20:30] //= np.array((9, 9, 1), np.uint8)
    free, stepped = (
        empty_of([Exemplar.of(pixels)], Canvas(90, 90), patch=24, overlap=8, lattice=lattice, evenness=1).usage.rate
        for lattice in (None, ((20.0, 0.0), (0.0, 18.0)))
    )
    assert free.min() > 0
    clear = free > free.min()
    assert clear.any()
    np.testing.assert_array_equal(stepped[clear], free[clear])
    assert set(np.unique(stepped[~clear])) <= {0, free.min()}  # that which strikes just twice as much
    assert (stepped[~clear] == 0).mean() > 0.9


@pytest.mark.parametrize("toroidal", [False, True])
def test_bare_ground_costs_nothing(toroidal: bool) -> None:
    """What is shown again there is not seen; else scraps of what stands on it are strewn over it."""
    pixels = texture(90, 80, 3, 2)
    pixels[30:70] = 7
    e = Exemplar.of(pixels, toroidal=toroidal)
    rate = grown([e], Canvas(90, 90)).usage.rate.reshape(90, 80)
    assert (rate[33:67] == 0).all()
    assert (rate[:28] > 0).all()
    assert (rate[72:] > 0).all()


def test_where_nothing_is_paid_for_use_it_costs_nothing() -> None:
    sewn = grown([Exemplar.of(texture(40, 44, 3, 1))], Canvas(60, 60), evenness=0)
    assert (sewn.usage.rate.size, sewn.usage.shown.sum()) == (0, 3600)
