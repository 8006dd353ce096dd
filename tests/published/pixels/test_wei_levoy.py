"""Wei-Levoy against a plain version of itself, and what else it promises."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from published.pixels.naive_pixels import NaiveScan

import intarsia as ia
from intarsia.foundation.run import below, draw
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import HOLE, identity
from intarsia.published.pixels import raster_kernels
from intarsia.published.pixels.raster_scan import Scan, tree_of

STAGE = ia.WeiLevoy.stage

RNG = np.random.default_rng(6)
GRAY = RNG.integers(0, 256, (14, 16), dtype=np.uint8)
COLOUR = RNG.integers(0, 256, (13, 12, 3), dtype=np.uint8)
TWO = RNG.integers(0, 2, (14, 15), dtype=np.uint8) * 255
USABLE = np.ones((14, 16), bool)
USABLE[3, 5] = USABLE[:, 15] = False

Shown = dict[tuple[int, int], tuple[int, int, int]]


def shown(out: ia.Synthesis) -> Shown:
    """Every pixel's (exemplar, row, column)."""
    which = np.zeros(out.map.yx.shape[:2], int) if out.map.which is None else out.map.which
    return {at: (int(which[at]), *map(int, out.map.yx[at])) for at in np.ndindex(which.shape)}  # type: ignore[misc]


def smooth(seed: int, height: int, width: int) -> NDArray[np.uint8]:
    y, x = np.mgrid[:height, :width]
    wave = 120 + 60 * np.sin(x / 2.5 + y / 7) + 50 * np.cos(y / 3)
    return (wave + np.random.default_rng(seed).integers(0, 20, (height, width))).astype(np.uint8)


CASES: dict[str, dict[str, Any]] = {
    "gray": {"exemplars": [Exemplar.of(GRAY)]},
    "wrapped": {"exemplars": [Exemplar.of(GRAY)], "wrap": "both"},
    "wrapped along x": {"exemplars": [Exemplar.of(GRAY)], "window": (2, 7), "wrap": "x"},
    "colour": {"exemplars": [Exemplar.of(COLOUR)], "window": (2, 3), "wrap": "y"},
    "one row": {"exemplars": [Exemplar.of(TWO)], "window": (1, 5), "wrap": "both"},
    "masked": {"exemplars": [Exemplar.of(GRAY, usable=USABLE)], "window": (2, 3), "wrap": "both"},
    "toroidal": {"exemplars": [Exemplar.of(GRAY, usable=USABLE, toroidal=True)]},
    "several": {"exemplars": [Exemplar.of(COLOUR), Exemplar.of(COLOUR[::-1].copy(), toroidal=True)], "wrap": "x"},
    "no room all around": {"exemplars": [Exemplar.of(GRAY[:4])], "wrap": "both"},
    "tiny": {"exemplars": [Exemplar.of(GRAY)], "wrap": "both", "size": (2, 3)},
    "one pixel": {"exemplars": [Exemplar.of(GRAY)], "size": (1, 1), "wrap": "both"},
    "two levels": {"exemplars": [Exemplar.of(smooth(1, 20, 23))], "levels": 2},
    "two levels, wrapped": {"exemplars": [Exemplar.of(smooth(2, 20, 18))], "levels": 2, "wrap": "both"},
    "two levels, toroidal": {"exemplars": [Exemplar.of(smooth(3, 13, 17), toroidal=True)], "levels": 2, "wrap": "y"},
}


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.long) if n == "two levels" else n for n in CASES])
def test_it_takes_what_the_plain_version_takes(name: str, thorough: bool) -> None:
    """Multrus 2003, 2.2.1: every pixel of the map is the same."""
    case = {"size": (9, 11), "window": (3, 5), "levels": 1, "wrap": "none"} | CASES[name]
    for seed in (0, 78) if thorough else (78,):
        method = ia.WeiLevoy(window=case["window"], levels=case["levels"], matching="exact")
        out = ia.synthesize(case["exemplars"], case["size"], method, seed=seed, wrap=case["wrap"])
        plain = NaiveScan(
            case["exemplars"], case["size"], case["window"], seed, STAGE, ia.Wrap(case["wrap"]), case["levels"]
        )
        assert shown(out) == plain.run()


LEGS = [(y, x) for y in (-2, -1) for x in range(-3, 4)] + [(0, x) for x in (-3, -2, -1)]


def of_the_text(height: int, width: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """An exemplar that is compared as it is, of 0 to 1023, and the L of 7x3 px of every neighbourhood inside it."""
    sample = smooth(6, height, width).astype(np.int64)
    sample = (sample - sample.min()) * 1023 // np.ptp(sample)
    y, x = np.mgrid[2:height, 3 : width - 3]
    return sample, np.stack([sample[y + a, x + b] for a, b in LEGS])


def test_on_a_canvas_that_ends_every_pixel_is_the_best_by_the_l_alone() -> None:
    """Multrus 2003, 2.2.1, from its text: the L of 7x3 px above and to the left, all neighbourhoods of the exemplar."""
    sample, others = of_the_text(34, 37)
    out = ia.synthesize(sample.astype(np.uint16), (26, 30), ia.WeiLevoy(window=(3, 7), matching="exact"), seed=1).map.yx
    image = sample[out[..., 0], out[..., 1]]
    for i in range(2, 26):
        for j in range(3, 27):
            own = np.array([image[i + a, j + b] for a, b in LEGS])
            far = ((others - own[:, None, None]) ** 2).sum(axis=0)
            u, s = out[i, j]
            assert far[u - 2, s - 3] == far.min()


def test_from_white_noise_it_is_the_method_of_the_source() -> None:
    """Multrus 2003, 2.2.1 and figure 2.3, from the text: noise, rows, an L of 7x3 px on a torus, the best of all."""
    sample, others = of_the_text(24, 27)
    method = ia.WeiLevoy(window=(3, 7), matching="exact", noise="white")
    out = ia.synthesize(sample.astype(np.uint16), (13, 15), method, seed=9, wrap="both").map.yx
    image = np.array([[below(1024, draw(9, STAGE, 64, i, j)) for j in range(15)] for i in range(13)])
    for i, j in np.ndindex(13, 15):
        own = np.array([image[(i + a) % 13, (j + b) % 15] for a, b in LEGS])
        far = ((others - own[:, None, None]) ** 2).sum(axis=0)
        best = np.unravel_index(far.argmin(), far.shape)
        assert tuple(out[i, j]) == (best[0] + 2, best[1] + 3)
        image[i, j] = sample[tuple(out[i, j])]


@pytest.mark.parametrize("matching", ["exact", "tree"])
def test_white_noise_is_gone_in_the_end(matching: str) -> None:
    """Whatever the canvas, levels, channels and start: every pixel is one of the exemplar, and starts stay."""
    e = Exemplar.of(np.stack([smooth(c, 20, 19) for c in range(3)], axis=-1))
    start, holes = with_hole(e)
    for levels, wrap in ((1, "none"), (2, "both"), (2, "x")):
        method = ia.WeiLevoy(window=(2, 5), levels=levels, matching=matching, noise="white")
        free = ia.synthesize([e, e], (30, 33), method, wrap=wrap).map
        assert set(np.unique(free.which).tolist()) <= {0, 1}
        begun = ia.synthesize(e, None, method, start=start, wrap=wrap).map
        assert begun.which is None
        assert (begun.yx[~holes] == start.yx[~holes]).all()


@pytest.mark.parametrize("levels", [1, 2])
def test_a_start_is_continued_as_the_plain_version_does(levels: int) -> None:
    e = Exemplar.of(smooth(4, 20, 19))
    start, holes = with_hole(e)
    method = ia.WeiLevoy(window=(2, 5), levels=levels, matching="exact")
    out = ia.synthesize(e, None, method, start=start, wrap="x", seed=3)
    known = {(int(y), int(x)): (0, int(y), int(x)) for y, x in np.argwhere(~holes)}
    plain = NaiveScan([e], (20, 19), (2, 5), 3, STAGE, ia.Wrap.X, levels, start=known)
    assert shown(out) == plain.run()
    assert (out.map.yx[~holes] == start.yx[~holes]).all()


def with_hole(e: Exemplar) -> tuple[ia.SourceMap, NDArray[np.bool_]]:
    full = identity([e.source], 0)
    holes = np.zeros((e.height, e.width), bool)
    holes[5:12, 4:13] = holes[17:, :] = True
    which = np.where(holes, HOLE, 0).astype(np.uint8)
    return ia.SourceMap(np.where(holes[:, :, None], 0, full.yx), which, sources=full.sources), holes


def in_row(y: int, width: int) -> NDArray[np.int64]:
    """All pixels of a row (n, 2)."""
    return np.array([(y, x) for x in range(width)], np.int64)


def test_the_tree_is_nearly_as_good_as_the_full_search() -> None:
    """Over pixels in the middle of good textures the tree's best is but a little further than the best of all."""
    e = Exemplar.of(smooth(7, 64, 64))
    scan = Scan([e], Canvas(48, 48), (3, 9), 1, (2, STAGE))
    torus, exemplar = scan.enter()
    tree = tree_of(exemplar, torus.choices, scan.components())
    for y in range(20):
        raster_kernels.fill_full(torus, exemplar, in_row(y, torus.variant.shape[1]), scan.room)
    ratio = mean_distance(torus, exemplar, scan, tree) / mean_distance(torus, exemplar, scan, None)
    assert 1 <= ratio <= 1.1


def mean_distance(torus: raster_kernels.Torus, exemplar: Any, scan: Scan, tree: Any) -> float:
    """Fill row 20 anew, always seeing the same neighbours, and average the distances of what was taken."""
    picture = exemplar.values[: exemplar.table[0, 4]].reshape(-1, exemplar.table[0, 3]).astype(np.int64)
    total = 0
    for x in range(6, torus.variant.shape[1] - 6):
        yx, done = torus.yx.copy(), torus.done.copy()
        mine = torus._replace(yx=yx, done=done)
        done[20, :] = done[:4, :] = False
        yx[20, :x] = yx[19, :x]
        if tree is None:
            raster_kernels.fill_full(mine, exemplar, np.array([[20, x]]), scan.room)
        else:
            raster_kernels.fill_by_tree(mine, exemplar, tree, 24, 6, np.array([[20, x]]), scan.room)
        v, u = yx[20, x]
        for dy, dx, kind in torus.taps.tolist():
            if kind == raster_kernels.ABOVE:
                there = yx[20 + dy, x + dx]
                total += int(picture[there[0], there[1]] - picture[v + dy, u + dx]) ** 2
    return total / (torus.variant.shape[1] - 12)


def operations(width: int, height: int, w_e: int, h_e: int) -> int:
    """Differences that one pixel costs in a full search, as Multrus 2003, 2.3, prints the law."""
    return width * height * ((h_e - 1) * w_e + -(-w_e // 2))


@pytest.mark.parametrize(("side", "cost"), [(100, 3_130_000), (200, 12_520_000)])
def test_the_cost_law_of_the_source(side: int, cost: int) -> None:
    """Ours holds one pixel less than the law of Multrus 2003, 2.3, for w_e is odd and the pixel itself not compared."""
    assert operations(side, side, 25, 13) == cost
    e = Exemplar.of(smooth(1, side, side), toroidal=True)
    torus, _ = Scan([e], Canvas(8, 8), (13, 25), 1, (0, STAGE)).enter()
    causal = sum(kind == raster_kernels.ABOVE for _, _, kind in torus.taps.tolist())
    assert operations(side, side, 25, 13) == len(torus.choices) * (causal + 1)  # what the search goes through


def test_what_cannot_be_compared_is_refused() -> None:
    for window in (1, 8, (3, 4)):
        with pytest.raises(ia.ParameterError, match="odd"):
            ia.WeiLevoy(window=window)
    with pytest.raises(ia.ParameterError, match="larger exemplar"):
        ia.synthesize(GRAY, 20, ia.WeiLevoy(window=(3, 9), levels=3))
    speckled = Exemplar.of(smooth(9, 20, 20), usable=np.indices((20, 20)).sum(axis=0) % 4 > 0)
    with pytest.raises(ia.MethodError, match="masked"):
        ia.synthesize(speckled, 20, ia.WeiLevoy(window=(3, 9)))
