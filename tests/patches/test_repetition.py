"""Repetition control: repeats have a price, and what strikes the eye returns least."""

from __future__ import annotations

import numpy as np
import pytest
from naive import shares
from quilts import grow
from torture import TORTURE

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.foundation.geometry import spread
from intarsia.methods import engine_of
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import SourceMap
from intarsia.patches.patch_synthesis import PatchSynthesis
from intarsia.patches.repetition import Repetition, patch_saliency
from intarsia.search import Candidates, WindowGrid, posed_exemplars
from intarsia.search.fourier import PatchSearch
from intarsia.testing import texture


def flat_spot() -> Exemplar:
    """A texture of which a fifth is flat: a spot that fits to itself without any difference."""
    picture = texture(64, 64, 1, 4)
    picture[36:, 36:] = 128
    return Exemplar.of(picture)


def flat_share(smap: SourceMap) -> float:
    return float((smap.yx >= 36).all(axis=2).mean())


def test_a_price_on_repetition_uses_more_of_the_exemplar() -> None:
    e = flat_spot()
    free, dear = ([grow(e, (128, 128), k, patch=16, overlap=6, repeat_penalty=u) for k in range(4)] for u in (0, 2))
    assert np.mean([shares(m, [e]) for m in dear]) > 1.3 * np.mean([shares(m, [e]) for m in free])
    assert max(flat_share(m) for m in dear) < 0.5 < min(flat_share(m) for m in free)
    plain = Exemplar.of(texture(64, 64, 3, 9))
    free, usual = (
        [grow(plain, (128, 128), k, patch=16, overlap=6, repeat_penalty=u) for k in range(4)] for u in (0, 0.05)
    )
    assert np.mean([shares(m, [plain]) for m in usual]) > np.mean([shares(m, [plain]) for m in free])


def test_a_flat_spot_does_not_feed_itself() -> None:
    """A perfect repeat has a price, too, so that a flat fifth of an exemplar does not fill the output."""
    pixels = texture(64, 64, 1, 4).copy()
    pixels[18:46, 18:46] = 128
    inside = Exemplar.of(pixels)
    grown = [grow(inside, (128, 128), k, patch=16, overlap=6) for k in range(4)]
    assert np.mean([(inside.base.pixels[m.yx[:, :, 0], m.yx[:, :, 1]] == 128).mean() for m in grown]) < 0.5


def test_a_flat_corner_is_left_at_a_price() -> None:
    """From a flat spot in the last corner no patch leads out for nothing: there a higher price is needed."""
    grown = [grow(flat_spot(), (128, 128), k, patch=16, overlap=6, repeat_penalty=0.5) for k in range(4)]
    assert np.mean([flat_share(m) for m in grown]) < 0.5





@pytest.mark.parametrize("method", [ia.ImageQuilting(patch=24, overlap=8), ia.PatchSampling(patch=18, overlap=3)])
def test_repeats_of_striking_patches_cost_more_where_a_method_grows(method) -> None:
    """The prices that methods lay by weigh the cluster's patches more than those of the ground."""
    pixels = TORTURE["red_cluster"](size=96)
    e, red = Exemplar.of(pixels), (pixels[:, :, 0] > 150) & (pixels[:, :, 1] < 90)
    growth = PatchSynthesis(engine_of(method).settings_of(method), [e], Canvas(200, 200))
    y, x = (int(v.mean()) for v in np.nonzero(red))
    at = tuple(min(max(v - 12, 0), 96 - 24) for v in (y, x))

    def repeated(u: int, s: int) -> int:
        other = PatchSynthesis(engine_of(method).settings_of(method), [e], Canvas(200, 200))
        other.repetition.add(3, 3, (0, u, s))
        return price_of(other.repetition, (3, 4), 0, u, s)

    ground = [repeated(u, s) for u, s in ((4, 4), (4, 40), (40, 4))]
    assert repeated(*at) > 1.5 * max(ground) > 0
    assert max(int(s.max()) for s in growth.repetition.striking) > 1.5 * 256


def test_what_was_asked_before_changes_nothing() -> None:
    """What is remembered of an exemplar belongs to the features that it was measured on."""
    pixels = TORTURE["red_cluster"](size=64)
    request = {"patch": 16, "overlap": 6, "repeat_penalty": 1}
    fresh = grow(Exemplar.of(pixels), (80, 80), 4, **request).digest
    e, other = Exemplar.of(pixels), Exemplar.of(texture(40, 40, 3) // 4)
    grow(e, (80, 80), 4, channel_weights=(0, 0, 1), **request)
    grow([e, other], (80, 80), 4, **request)
    grow(e, (80, 80), 4, isometries="both", search="exact", **request)
    assert grow(e, (80, 80), 4, **request).digest == fresh


def control(e: Exemplar, patch: int, size: tuple[int, int], strength: float, isometries=(0,), wrap=False) -> Repetition:
    """Repetition control over a canvas of patches side by side."""
    rows, columns = (tuple(spread(n, patch, 0, wrap)[0]) for n in size)
    search = PatchSearch(posed_exemplars([e], features([e]), isometries, (patch, patch)), (patch, patch), 4)
    return Repetition(search, WindowGrid(rows, columns, (patch, patch), size, (wrap, wrap)), strength)


def price_of(control: Repetition, window: tuple[int, int], v: int, u: int, s: int, usual: int = 100_000) -> int:
    """What a patch of distance 0 costs in a window."""

    rows = np.array([[0, v, u, s]], np.int64)
    empty = np.empty((0, 0, 0), np.int16), np.empty((0, 0), np.uint8)
    return int(control.prices(*window, Candidates(rows, usual, *empty))[0])


def test_a_perfect_repeat_has_a_price_and_a_fresh_patch_has_none() -> None:
    """The price is added to the distance, so that a distance of 0 does not stay 0."""
    c = control(Exemplar.of(texture(60, 60)), 10, (80, 80), 0.1)
    c.add(3, 3, (0, 20, 20))
    assert price_of(c, (3, 4), 0, 20, 20) > 0
    assert price_of(c, (3, 4), 0, 45, 45) == 0
    assert price_of(control(Exemplar.of(texture(60, 60)), 10, (80, 80), 0), (3, 4), 0, 20, 20) == 0


def test_of_a_perfect_match_and_one_nearly_so_either_is_drawn() -> None:
    """The tolerance applies to a quarter of the usual distance where the best is nearer: by one, or many."""
    c = control(Exemplar.of(texture(60, 60)), 10, (80, 80), 0)
    usual, empty = 100_000, (np.empty((0, 0, 0), np.int16), np.empty((0, 0), np.uint8))
    rows = np.array([[0, 0, 5, 5], [2_400, 0, 20, 20], [2_600, 0, 40, 40]], np.int64)
    found, bits = Candidates(rows, usual, *empty), [k << 32 for k in range(0, 1 << 32, 1 << 28)]
    assert {c.pick(2, 2, found, 0.1, b) for b in bits} == {(0, 5, 5), (0, 20, 20)}
    many = {c.pick_all([(2, 2)], [found], 0.1, [b])[0] for b in bits}
    assert many == {(0, 5, 5), (0, 20, 20)}


def test_a_near_repeat_is_dearer_than_a_far_one_in_every_direction() -> None:
    """What counts is where in the output the repeat lands; rows and columns alike, before and behind."""
    for wrap in (False, True):
        c = control(Exemplar.of(texture(60, 60)), 10, (80, 80), 0.1, wrap=wrap)
        c.add(4, 4, (0, 20, 20))
        near = [price_of(c, w, 0, 20, 20) for w in ((3, 4), (5, 4), (4, 3), (4, 5))]
        far = [price_of(c, w, 0, 20, 20) for w in ((1, 4), (7, 4), (4, 1), (4, 7))]
        assert len(set(near)) == 1
        assert len(set(far)) == 1
        assert near[0] > far[0] > 0
        c.add(0, 0, (0, 40, 40))
        across, inside = price_of(c, (0, 7), 0, 40, 40), price_of(c, (0, 1), 0, 40, 40)
        assert across == inside if wrap else across < inside


def test_a_repeat_has_a_price_however_far_away() -> None:
    """So that all of the exemplar is shown; beyond four windows it is the same everywhere."""
    c = control(Exemplar.of(texture(60, 60)), 10, (200, 200), 0.1)
    c.add(0, 0, (0, 20, 20))
    c.account()
    far = {price_of(c, w, 0, 20, 20) for w in ((9, 9), (15, 3), (19, 19))}
    assert len(far) == 1
    assert 0 < far.pop() < price_of(c, (0, 1), 0, 20, 20)


@pytest.mark.parametrize("size", [(20, 20), (30, 20), (20, 50), (80, 80)])
def test_every_placed_neighbour_counts_on_canvases_of_any_size(size: tuple[int, int]) -> None:
    """On a canvas of few windows, too, those to the right and below are looked at, each once."""
    for wrap in (False, True):
        prices, (last, end) = set(), (n // 10 - 1 for n in size)
        for at, window in (((0, end), (0, end - 1)), ((0, 0), (0, 1)), ((last, 0), (last - 1, 0))):
            c = control(Exemplar.of(texture(60, 60)), 10, size, 0.1, wrap=wrap)
            assert (len(c.layout.rows), len(c.layout.columns)) == (last + 1, end + 1)
            c.add(*at, (0, 20, 20))
            prices.add(price_of(c, window, 0, 20, 20))
        assert [p > 0 for p in prices] == [True]


def test_an_overlap_of_half_a_patch_costs_half() -> None:
    """Multrus 2003, 4.2.1: prices fall with the part of the exemplar that two patches share."""
    c = control(Exemplar.of(texture(60, 60)), 16, (96, 96), 0.1)
    c.add(2, 2, (0, 20, 20))
    whole, half, none = (price_of(c, (2, 3), 0, 20, s) for s in (20, 28, 36))
    assert half == pytest.approx(whole / 2, rel=0.15)
    assert none == 0


def test_mirrored_patches_of_one_spot_count_as_repeats() -> None:
    c = control(Exemplar.of(texture(60, 50)), 10, (80, 80), 0.1, isometries=tuple(range(8)))
    c.add(3, 3, (0, 20, 12))
    spots = ((0, 20, 12), (1, 20, 50 - 10 - 12), (6, 60 - 10 - 20, 50 - 10 - 12), (3, 12, 20))
    assert len({price_of(c, (3, 4), *spot) for spot in spots}) == 1


def test_striking_spots_weigh_more() -> None:
    """Where the exemplar holds its only red cluster, repeats cost more than on the common ground."""
    e = Exemplar.of(TORTURE["red_cluster"](size=96))
    feats = features([e])
    search = PatchSearch(posed_exemplars([e], feats, (0, 5), (24, 24)), (24, 24), 8)
    upright, turned = patch_saliency(feats, search)
    f = search.factor
    assert upright[70 // f, 70 // f] > 1.5 * np.median(upright)
    assert upright.shape == turned.shape
    np.testing.assert_allclose(np.median(turned), np.median(upright), rtol=0.2)
    assert turned.argmax() != upright.argmax()
