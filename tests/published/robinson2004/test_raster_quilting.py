"""Quilting as the report of 2004 has it, whose sections and program are named (Robinson 2004)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from kernels.naive_cuts import two_path_mask

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.foundation.run import below, draw
from intarsia.model import Exemplar
from intarsia.published.robinson2004.engine import STAGE, cut
from intarsia.testing import texture


def norm(a, b) -> int:
    return int(math.sqrt(sum((int(p) - int(q)) ** 2 for p, q in zip(a, b, strict=True))) * 16)


def accumulated(error: dict, rows: int, columns: int, turned: bool) -> dict:
    """The least sum from a pixel of a strip to its far end: itself, and the least of the three after it."""
    out: dict = {}
    for i, j in sorted(error, key=lambda p: -p[turned]):
        after = [(i + 1, j + k) if not turned else (i + k, j + 1) for k in (0, -1, 1)]
        out[i, j] = error[i, j] + min((out[p] for p in after if p in out), default=0)
    return out


def naive_cut(error: np.ndarray, rows: int, columns: int, text: bool) -> np.ndarray:
    """The program's getCutMap, pixel by pixel."""
    h, w = error.shape
    down = accumulated({(i, j): int(error[i, j]) for i in range(h) for j in range(columns)}, rows, columns, False)
    along = accumulated({(i, j): int(error[i, j]) for i in range(rows) for j in range(w)}, rows, columns, True)
    keep = np.ones((h, w), bool)
    turn = None
    if rows and columns:
        corner = [(i, j) for i in range(rows) for j in range(columns)]
        turn = min(corner, key=lambda p: (down[p] + along[p] - text * int(error[p]), p))
        keep[: turn[0] + 1, : turn[1] + 1] = False
    if columns:
        i, j = turn or min(((0, j) for j in range(columns)), key=lambda p: (down[p], p))
        while i < h:
            keep[i, : j + 1] = False
            i += 1
            j = min((p for p in (j, j - 1, j + 1) if (i, p) in down), key=lambda p, i=i: down[i, p], default=0)
    if rows:
        i, j = turn or min(((i, 0) for i in range(rows)), key=lambda p: (along[p], p))
        while j < w:
            keep[: i + 1, j] = False
            j += 1
            i = min((p for p in (i, i - 1, i + 1) if (p, j) in along), key=lambda p, j=j: along[p, j], default=0)
    return keep


@pytest.mark.parametrize("text", [False, True])
@pytest.mark.parametrize("overlap", [(0, 0), (0, 3), (4, 0), (3, 2), (5, 9)])
def test_the_cut_is_that_of_the_program(overlap: tuple[int, int], text: bool) -> None:
    for seed in range(20):
        error = np.random.default_rng(seed).integers(0, 9, (8, 9))
        np.testing.assert_array_equal(cut(error, overlap, text), naive_cut(error, *overlap, text))


def test_the_text_s_own_turning_rule_is_the_other_twin_s() -> None:
    """Where no two sums are equal, both twins cut alike."""
    for seed in range(20):
        error = np.random.default_rng(seed).integers(0, 1 << 40, (9, 9))
        np.testing.assert_array_equal(cut(error, (4, 4), True), two_path_mask(error, 4) == 1)


SETTINGS = [((30, 33), 12, 3), ((25, 22), (9, 11), (2, 4)), ((21, 30), 8, 0)]


@pytest.mark.parametrize(("size", "patch", "overlap"), SETTINGS)
def test_it_is_the_method_of_the_report(size, patch, overlap) -> None:
    """Raster order, sums of norms over the overlap, a draw within a tenth of the least, cropped patches."""
    e = Exemplar.of(texture(24, 26, 3, 4))
    picture = features([e]).pictures[0]
    (h, w), (oy, ox) = (patch if isinstance(patch, tuple) else (patch,) * 2 for patch in (patch, overlap))
    yx = np.full((*size, 2), -1)
    for y in range(0, max(size[0] - oy, 1), h - oy):
        for x in range(0, max(size[1] - ox, 1), w - ox):
            window = [(i, j) for i in range(y, min(y + h, size[0])) for j in range(x, min(x + w, size[1]))]
            known = [p for p in window if yx[p][0] >= 0]
            sums = {
                (u, v): sum(norm(picture[tuple(yx[i, j])], picture[u + i - y, v + j - x]) for i, j in known)
                for u in range(24 - h + 1) for v in range(26 - w + 1)
            }  # fmt: skip
            near = [p for p in sorted(sums) if sums[p] <= 1.1 * min(sums.values())]
            u, v = near[below(len(near), draw(9, STAGE, 0, y, x))]
            tall, wide = window[-1][0] - y + 1, window[-1][1] - x + 1
            error = np.zeros((tall, wide), int)
            for i, j in known:
                error[i - y, j - x] = norm(picture[tuple(yx[i, j])], picture[u + i - y, v + j - x])
            keep = naive_cut(error, min(oy, tall) if y else 0, min(ox, wide) if x else 0, False)
            for i, j in window:
                if keep[i - y, j - x]:
                    yx[i, j] = u + i - y, v + j - x
    made = ia.synthesize(e, size, ia.RasterQuilting(patch=patch, overlap=overlap), seed=9)
    np.testing.assert_array_equal(made.map.yx, yx)


def test_the_overlap_is_a_sixth_and_masked_pixels_are_left_out() -> None:
    usable = np.ones((60, 60), bool)
    usable[20:24, 30:33] = False
    made = ia.synthesize(Exemplar.of(texture(60, 60, 3), usable=usable), 90, ia.RasterQuilting(patch=18), seed=2)
    assert made.method.overlap == 3
    assert usable[made.map.yx[..., 0], made.map.yx[..., 1]].all()
