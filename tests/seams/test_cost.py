"""What the seams of a map cost: nothing where it goes on, else the differences on both sides, and steps of tone."""

from __future__ import annotations

import numpy as np
import pytest

from intarsia.analysis.features import features
from intarsia.exemplar import Exemplar
from intarsia.geometry import ISOMETRIES, Wrap
from intarsia.seams.cost import seam_total
from intarsia.sourcemap import SourceMap, identity
from intarsia.testing import noise, texture


def slowly(e: Exemplar, smap: SourceMap) -> int:
    """The cost, pair by pair: what each of two pixels differs from what the other's piece would show there."""
    picture = features([e]).pictures[0].astype(int)
    pose = np.zeros((smap.height, smap.width), int) if smap.pose is None else smap.pose
    total, tone = 0, {}

    def grown(y: int, x: int) -> np.ndarray | None:
        if e.toroidal:
            return picture[y % e.height, x % e.width]
        return picture[y, x] if 0 <= y < e.height and 0 <= x < e.width else None

    for axis, wrap in ((0, smap.wrap.y), (1, smap.wrap.x)):
        for y, x in np.ndindex(smap.height, smap.width):
            v, u = (y + 1, x) if axis == 0 else (y, x + 1)
            if (v >= smap.height or u >= smap.width) and not wrap:
                continue
            v, u = v % smap.height, u % smap.width
            (a, b), (c, d) = smap.yx[y, x].tolist(), smap.yx[v, u].tolist()
            first, second = ([row[axis] for row in ISOMETRIES[pose[p]].j] for p in ((y, x), (v, u)))
            if (a + first[0], b + first[1]) == (c, d) and pose[y, x] == pose[v, u]:
                continue
            here, there = picture[a, b], picture[c, d]
            over, back = grown(a + first[0], b + first[1]), grown(c - second[0], d - second[1])
            total += int(np.abs((here if over is None else over) - there).sum())
            total += int(np.abs(here - (there if back is None else back)).sum())
            step = (here if over is None else over) - there + (0 if back is None else here - back)
            cell = axis, y // 8, x // 8
            tone[cell] = tone.get(cell, 0) + step
    return total + 2 * sum(int(np.abs(t).sum()) for t in tone.values())


@pytest.mark.parametrize("wrap", list(Wrap))
@pytest.mark.parametrize("toroidal", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_seams_cost_what_each_pair_of_neighbours_costs(wrap: Wrap, toroidal: bool, seed: int) -> None:
    """Pieces of 5 x 4 px from anywhere, in any pose."""
    e = Exemplar.of(texture(17, 19, 3, seed), toroidal=toroidal)
    drawn = (noise(60, 3, seed) >> np.uint64(40)).astype(np.int64)
    yx, pose = np.zeros((20, 16, 2), np.int32), np.zeros((20, 16), np.uint8)
    for k in range(16):
        box = np.s_[k // 4 * 5 : k // 4 * 5 + 5, k % 4 * 4 : k % 4 * 4 + 4]
        own = ISOMETRIES[drawn[k, 2] % 8]
        at = np.stack(np.mgrid[:5, :4], axis=2) @ np.array(own.j).T
        yx[box] = np.array([drawn[k, 0] % 7 + 5, drawn[k, 1] % 9 + 5]) + at
        pose[box] = own.id
    smap = SourceMap(yx, None, pose, (e.source,), wrap)
    assert seam_total(features([e]), [e], smap) == slowly(e, smap) > 0


def test_what_goes_on_has_no_seam() -> None:
    """Around a wrapped canvas it does so only where the exemplar does."""
    e = Exemplar.of(texture(17, 19, 3))
    plain = identity([e.source], 0)
    assert seam_total(features([e]), [e], plain) == 0
    round_it = SourceMap(plain.yx, None, None, (e.source,), Wrap.BOTH)
    assert seam_total(features([e]), [e], round_it) == slowly(e, round_it) > 0
