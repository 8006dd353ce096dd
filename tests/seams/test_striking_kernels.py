"""What kernels count and mark where striking things are covered, against their plain twins."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

import intarsia as ia
from intarsia.canvas import Canvas
from intarsia.exemplar import Exemplar
from intarsia.seams import striking_kernels as kernels
from intarsia.seams.covering import Laying
from intarsia.seams.striking import Often, Thinning
from intarsia.testing import texture

ONE = ia.Run(1)


def thinning(isometries: str, wrap: str, toroidal: bool) -> Thinning:
    """A map of pieces in several poses, about to be thinned."""
    pixels = texture(66, 58, 3, 7) // 4 + 60
    pixels[20:29, 30:40] = (230, 60, 20)
    e = Exemplar.of(pixels.astype(np.uint8), toroidal=toroidal)
    method = ia.ImageQuilting(patch=16, overlap=6, isometries=isometries)
    made = ia.synthesize(e, (90, 101), method, seed=2, wrap=wrap, run=ONE)
    often = Often(0.5, [e], Canvas(90, 101, wrap), np.zeros((90, 101), bool))
    return Thinning(often, Laying(isometries=isometries), [e], Canvas(90, 101, wrap), made.map, 24)


@pytest.mark.parametrize(
    ("isometries", "wrap", "toroidal"),
    [("none", "none", False), ("both", "y", False), ("both", "both", True), ("180", "none", True)],
)
def test_placements_strike_as_their_pixels_do(isometries: str, wrap: str, toroidal: bool) -> None:
    """What a placement strikes is the mean of what it shows, over the border of the exemplar from its beginning."""
    work = thinning(isometries, wrap, toroidal)
    rng = np.random.default_rng(3)
    for box in ((10, 20, 12, 9), (70, 85, 20, 16), (0, 0, 30, 7)):
        rows = np.zeros((40, 4), np.int64)
        rows[:, 1] = rng.integers(0, len(work.growth.variants), 40)
        rows[:, 2:] = rng.integers(-6 if toroidal else 0, 60, (40, 2))
        strikes = np.empty(len(rows), np.int64)
        kernels.mean_strikes(work.looks, box, rows, strikes)
        for row, mean in zip(rows.tolist(), strikes.tolist(), strict=True):
            begin, h, w = work.looks.frames[row[1]].tolist()
            picture = work.looks.strikes[begin : begin + h * w].reshape(h, w)
            y, x = (row[2] + np.arange(box[2])) % h, (row[3] + np.arange(box[3])) % w
            assert mean == picture[np.ix_(y, x)].sum() // (box[2] * box[3])


@pytest.mark.parametrize("edge", [0, 1, 2, 3])
def test_a_part_is_marked_with_its_edge(edge: int) -> None:
    """So many steps around it, and no further than the window."""
    part = np.zeros((40, 50), np.int32)
    part[3:9, 44:50] = part[3:6, :4] = part[20:26, 20:23] = 7
    for box in ((0, 40, 14, 20), (18, 15, 12, 20), (0, 38, 8, 10)):
        mine = part[np.ix_((box[0] + np.arange(box[2])) % 40, (box[1] + np.arange(box[3])) % 50)] == 7
        out = np.empty(box[2:], np.int32)
        assert kernels.mark_part(part, (False, True), box, 7, edge, 9, out) == mine.sum()
        expected = ndimage.binary_dilation(mine, iterations=edge) if edge else mine
        assert (out == 9 * expected).all()
