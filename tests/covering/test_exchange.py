"""Striking elements that are too many show the inside of others; outlines, and all else, stay as they are."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

import intarsia as ia
from intarsia.canvas import Canvas
from intarsia.covering import exchange
from intarsia.covering.covering import Covering, Laying
from intarsia.exemplar import Exemplar
from intarsia.geometry import Wrap
from intarsia.seams.whole import Elements
from intarsia.segments.wholes import wholes
from intarsia.sourcemap import SourceMap

ONE = ia.Run(1)
ODD = (3, 2)  # row and column of the stone that strikes
SIDE = 36


def stones() -> np.ndarray:
    """Gray stones in dark joints: what is nearest to points that lie about a triangular lattice. One is red."""
    draws, n = np.random.default_rng(4), 6
    y, x = np.mgrid[: n * SIDE, : n * SIDE]
    shift = draws.integers(-6, 7, (n + 2, n + 2, 2))
    away = [
        (y - a * SIDE - SIDE // 2 - dy) ** 2 + (x - b * SIDE - a % 2 * SIDE // 2 - dx) ** 2
        for (a, b), (dy, dx) in zip(product(range(-1, n + 1), repeat=2), shift.reshape(-1, 2).tolist(), strict=True)
    ]
    far = np.sqrt(np.sort(away, axis=0)[:2])
    near, inside = np.argmin(away, axis=0), far[1] - far[0] > 5
    tones = draws.integers(110, 171, len(away))[near]
    out = np.where(inside[..., None], np.stack([tones, tones, tones - 10], axis=2), 30)
    out[inside & (near == (ODD[0] + 1) * (n + 2) + ODD[1] + 1)] = (240, 30, 20)
    return np.clip(out + draws.integers(-14, 15, out.shape), 0, 255).astype(np.uint8)


EXEMPLAR = Exemplar.of(stones())


def repeated(rows: int = 2, columns: int = 3, by: tuple[int, int] = (0, 0)) -> SourceMap:
    """The exemplar again and again, shifted: discs stay whole but at the borders."""
    y, x = np.indices((rows * EXEMPLAR.height, columns * EXEMPLAR.width))
    yx = np.stack([(y + by[0]) % EXEMPLAR.height, (x + by[1]) % EXEMPLAR.width], axis=2).astype(np.int32)
    return SourceMap(yx, None, None, (EXEMPLAR.source,))


def red(smap: SourceMap) -> Any:
    return stones()[smap.yx[..., 0], smap.yx[..., 1]].astype(int) @ (1, -1, 0) > 80


def count(smap: SourceMap) -> int:
    """Red stones that are shown, parts of at least 40 px."""
    label, n = ndimage.label(ndimage.binary_opening(red(smap)))
    return int((np.bincount(label.ravel(), minlength=n + 1)[1:] > 40).sum())


def less(share: float, smap: SourceMap, **more: Any) -> SourceMap:
    canvas = Canvas(smap.height, smap.width, **more)
    return exchange.exchanged(share, Laying(), [EXEMPLAR], canvas, smap, ONE)


def striking_px(smap: SourceMap) -> Any:
    """Pixels of the canvas that show an element that strikes."""
    found = wholes(EXEMPLAR)
    assert found is not None
    strikes = np.concatenate([[0], exchange.striking(EXEMPLAR)])
    return strikes[found.labels[smap.yx[..., 0], smap.yx[..., 1]]] > 0


def test_the_red_stone_strikes_most() -> None:
    strikes, found = exchange.striking(EXEMPLAR), wholes(EXEMPLAR)
    assert found is not None
    at = red(repeated(1, 1))
    assert int(strikes.argmax()) == int(np.bincount(found.labels[at]).argmax()) - 1
    assert 0 < np.count_nonzero(strikes) < len(strikes) // 2
    assert (found.sure[1:][strikes > 0] >= exchange.SCALE.sure).all()


@pytest.mark.parametrize(("share", "most"), [(0.0, 0), (0.1, 1), (0.5, 3)])
def test_it_is_shown_so_often_at_most(share: float, most: int) -> None:
    """6 times the exemplar; outlines, and all else, stay."""
    smap = repeated()
    out = less(share, smap)
    assert count(smap) == 6
    assert count(out) == most
    changed = (out.yx != smap.yx).any(axis=2)
    near = ndimage.binary_dilation(striking_px(smap), iterations=exchange.SCALE.outside)
    assert not (changed & ~near).any()
    gone = red(smap) & ~red(out)
    found = wholes(EXEMPLAR)
    assert found is not None
    inside = found.labels[out.yx[gone][:, 0], out.yx[gone][:, 1]] > 0
    assert inside.mean() > 0.8, "what fills it is the inside of another"


def test_each_time_another_element_fills() -> None:
    out = less(0, repeated())
    found = wholes(EXEMPLAR)
    assert found is not None
    gone = red(repeated()) & ~red(out)
    names, parts = np.zeros(int(found.labels.max()) + 1, int), ndimage.label(gone)
    for k in range(1, parts[1] + 1):
        at = out.yx[parts[0] == k]
        if len(at) > 100:
            names[np.bincount(found.labels[at[:, 0], at[:, 1]]).argmax()] += 1
    assert names.sum() == 6
    assert names.max() < 5


def test_those_that_stay_are_apart() -> None:
    shown = red(less(0.3, repeated()))
    label, n = ndimage.label(ndimage.binary_opening(shown))
    middles = ndimage.center_of_mass(shown, label, range(1, n + 1))
    assert n == 2
    assert all(np.hypot(a - c, b - d) > 250 for k, (a, b) in enumerate(middles) for c, d in middles[:k])


@pytest.mark.parametrize("wrap", [Wrap.X, Wrap.Y, Wrap.BOTH])
def test_over_borders_that_wrap(wrap: Wrap) -> None:
    """A stone that borders cut goes, its halves as well; where both wrap it is filled by one element."""
    y, x = (int(a.mean()) for a in np.nonzero(red(repeated(1, 1))))
    out = less(0, repeated(2, 2, (y, x)), wrap=wrap)
    assert red(repeated(2, 2, (y, x)))[0, 0]
    assert count(out) == 0
    if wrap is Wrap.BOTH:
        at = np.roll(out.yx, (20, 20), (0, 1))[8:32, 8:32]
        steps = (np.diff(at[..., 0], axis=0) == 1).mean(), (np.diff(at[..., 1], axis=1) == 1).mean()
        assert min(steps) > 0.9, "one piece"


def test_what_was_given_stays() -> None:
    """Of a start map all stays that was kept, and counts as shown."""
    smap = repeated()
    which = np.zeros((smap.height, smap.width), np.uint8)
    which[: EXEMPLAR.height] = 0
    which[EXEMPLAR.height :] = 255
    begun = SourceMap(smap.yx, which, None, smap.sources)
    out = less(0.5, smap, start=begun)
    np.testing.assert_array_equal(out.yx[: EXEMPLAR.height], smap.yx[: EXEMPLAR.height])
    assert count(out) == 3
    assert less(0, smap, start=smap) is smap


def test_without_striking_elements_the_map_comes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    smap = repeated()
    monkeypatch.setattr(exchange, "striking", lambda e: np.zeros(99, np.int64))
    assert less(0, smap) is smap


def test_places_are_those_counted_one_by_one() -> None:
    draws = np.random.default_rng(1)
    mask, mine = draws.random((9, 7)) > 0.4, draws.random((5, 6)) > 0.5
    out = exchange.covered(mask, mine)
    assert out.shape == (13, 12)
    for y, x in product(range(13), range(12)):
        told = sum(
            int(mask[y - 4 + i, x - 5 + j]) for i, j in np.argwhere(mine) if 0 <= y - 4 + i < 9 and 0 <= x - 5 + j < 7
        )
        assert out[y, x] == told


def test_what_fills_does_not_strike_and_is_sure() -> None:
    work = Covering(Laying(), Laying().settings([EXEMPLAR], 32, 1), [EXEMPLAR], Canvas(216, 216), repeated(1, 1))
    found = wholes(EXEMPLAR)
    assert found is not None
    elements = Elements(work.growth.variants, [found])
    strikes = exchange.striking(EXEMPLAR)
    fillers = exchange.Exchange(work, elements, strikes[elements.kin - 1]).fillers
    assert fillers
    assert not strikes[np.array(fillers) - 1].any()
    assert (found.sure[fillers] >= exchange.SCALE.sure).all()


def test_graphcut_exchanges_where_it_makes_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """With `whole` and elements outlines stay; the same map as by hand, for any number of threads."""
    monkeypatch.setattr("intarsia.seams.graphcut.TRIES", 1)
    plain = ia.Graphcut(patch=64, overlap=24, refinements=4, whole=1)
    few = ia.Graphcut(patch=64, overlap=24, refinements=4, whole=1, striking=0)
    made = ia.synthesize(EXEMPLAR, (300, 290), plain, seed=2, run=ONE)
    out = exchange.exchanged(0, Laying(plain.channel_weights), [EXEMPLAR], Canvas(300, 290), made.map, ONE)
    for n in (1, 3):
        again = ia.synthesize(EXEMPLAR, (300, 290), few, seed=2, run=ia.Run(n)).map
        np.testing.assert_array_equal(again.yx, out.yx)
    assert count(out) < count(made.map)
