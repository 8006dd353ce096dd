"""Patch sampling with every pair of options at once: a covering array of whole runs.

Labels, pyramid and isometries meet in one run as well, as in figure 5.6 of Multrus 2003:
tests/patches/test_labelled.py.
"""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest

import intarsia as ia
from intarsia.model import Exemplar
from intarsia.model.image import Kind
from intarsia.model.sourcemap import HOLE
from intarsia.testing import noise

OPTIONS = {
    "isometries": ("none", "180", "both", "auto"),
    "repetition": ("prices", "counter", "marks", "none"),
    "search": ("fast", "exact"),
    "pyramid": ("off", "mean"),
    "bound": ("best", "epsilon", "relative"),
    "join": ("feather", "middle", "cut"),
    "avoid": (False, True),
    "wrap": ("none", "x", "both"),
    "start": (False, True),
    "labels": (False, True),
}
METHOD = ("isometries", "repetition", "search", "pyramid", "bound", "join")


def covering() -> list[dict]:
    """A small set of runs in which every two options meet in all their values: greedy, always the same."""
    names = list(OPTIONS)
    every = [dict(zip(names, values, strict=True)) for values in product(*OPTIONS.values())]
    missing = {
        ((a, x), (b, y)) for a, b in combinations(names, 2) for x, y in product(OPTIONS[a], OPTIONS[b])
    }  # fmt: skip
    out: list[dict] = []
    while missing:
        row: dict = {}
        for name in names:  # each value meets as many missing pairs as it can
            gains = []
            for value in OPTIONS[name]:
                pairs = [p for p in missing if (name, value) in p]
                met = sum(any(q != (name, value) and row.get(q[0]) == q[1] for q in p) for p in pairs)
                gains.append((met, len(pairs)))
            row[name] = OPTIONS[name][gains.index(max(gains))]
        new = {p for p in missing if all(row[k] == v for k, v in p)}
        if not new:
            (a, x), (b, y) = min(missing, key=repr)
            row |= {a: x, b: y}
            new = {p for p in missing if all(row[k] == v for k, v in p)}
        missing -= new
        out.append(row)
    assert all(row in every for row in out)
    return out


ROWS = covering()


def pixels(height: int, width: int) -> np.ndarray:
    layers = [noise(height, width, c) >> np.uint64(56) for c in range(3)]
    return np.stack(layers, axis=2).astype(np.uint8)


def halves(height: int, width: int) -> ia.Plane:
    """Two labels, one above the other."""
    rows = np.arange(height, dtype=np.uint8)[:, None] * 2 // height
    return ia.Plane(np.repeat(rows, width, axis=1), Kind.LABEL)


def test_the_array_is_small_and_covers_all_pairs() -> None:
    assert len(ROWS) <= 30
    for a, b in combinations(OPTIONS, 2):
        assert {(r[a], r[b]) for r in ROWS} == set(product(OPTIONS[a], OPTIONS[b]))


@pytest.mark.parametrize("number", range(len(ROWS)))
def test_every_pair_of_options_works(number: int) -> None:
    """No hole, only usable pixels in their true place, deep start pixels kept; two threads change nothing."""
    row = ROWS[number]
    usable = np.ones((44, 40), bool)
    if row["avoid"]:
        usable[30:33, 20:23] = False
    e = Exemplar.of(pixels(44, 40), usable=usable)
    size, start, guide = (52, 49), None, None
    if row["labels"]:
        guide = ia.Guide(halves(44, 40), halves(*size))
    if row["start"]:
        start = ia.synthesize(e, size, ia.RandomTiling(patch=14), seed=9, wrap=row["wrap"], run=ia.Run(1)).map
        which = np.zeros(size, np.uint8)
        which[:, 22:] = HOLE
        start = ia.SourceMap(start.yx, which, None, start.sources, start.wrap)
    method = ia.PatchSampling(patch=7, overlap=4, epsilon=0.3, **{k: row[k] for k in METHOD})
    outs = [
        ia.synthesize(e, size, method, seed=number, wrap=row["wrap"], start=start, guide=guide, run=ia.Run(n))
        for n in (1, 2)
    ]
    smap = outs[0].map
    assert smap.digest == outs[1].map.digest
    assert not smap.holes.any()
    assert usable[smap.yx[..., 0], smap.yx[..., 1]].all() or row["start"]
    shown = pixels(44, 40)[smap.yx[..., 0], smap.yx[..., 1]]
    np.testing.assert_array_equal(np.asarray(outs[0].render(feather=0).pixels), shown)
    assert np.asarray(outs[0].render().pixels).shape == (*size, 3)
    if guide is not None:
        (source,), target = guide.sources, guide.target
        got, grown = source.pixels[smap.yx[..., 0], smap.yx[..., 1]], np.s_[:, 22:] if start is not None else np.s_[:]
        assert (got == target.pixels)[grown].mean() > 0.9
    if start is not None:
        deep = slice(5, 17) if row["wrap"] != "none" else slice(0, 17)
        np.testing.assert_array_equal(smap.yx[:, deep], start.yx[:, deep])
