"""The bricks of an exemplar as pieces for new courses: their sizes, and how their joints lie over one another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..lazy import ndimage
from .brickwork import Brickwork
from .wall_kernels import FACE

Brick = tuple[int, int, int, int, int]

class Sorting(NamedTuple):
    """Which bricks of an exemplar are shown. Counts are of 16 walls of 512 px (docs/design/012)."""

    margin: int = 3  # px at the border of the exemplar, left for the seam; halved and doubled: nothing is seen
    broken: float = 0.3  # of the usual brick is the least; halved: one wall lays chips, doubled: 9 of 67 are lost
    half: float = 0.45  # of it must be seen at the border, where whole ones are few; halved: slivers in four walls
    least: float = 0.9  # of the shortest whole one, where they are many; halved: three walls show halved setts
    few: int = 8  # whole bricks; halved: 859 pieces cut by the border are shown instead of 268, doubled: 343
    enough: int = 16  # of them: none is shown that the border cuts; at 20 whole stones one piece in seven looked cut
    straying: int = 70  # of 255 is what beds of a brick may look like; without it setts show two stones as one


class Bond(NamedTuple):
    """What joints cost by where those of other courses lie, in units of `Costs`; from the same 16 walls."""

    stacked: int = 500  # one upon another; at 0 417 joints instead of 313, halved 125 for 123, doubled 87 for 83
    unusual: int = 240  # as they never lie in the exemplar; at 0 a drawn English bond has 53 of 279 near others, not 22
    rare: int = 60  # e times rarer than the most usual; halved: 293 upon others instead of 310, doubled 103 for 79
    blur: float = 0.08  # of a brick, at least 1.5 px, smooths distances; halved 254 for 232, doubled 139 for 125
    close: float = 0.1  # of all distances are smaller, and stacked; halved: 286 instead of 241, doubled: 182, not 258
    beyond: int = 4  # times less count joints of the next course but one; halved 330 for 280, doubled 100 for 77


SORTING, BOND = Sorting(), Bond()


@dataclass(frozen=True, eq=False)
class Bricks:
    """The bricks of an exemplar."""

    # (n, 5): of every brick its course, first column and end in the exemplar, and what lies at both ends: the
    # number of a joint, or FACE where the border of the exemplar cuts it.
    table: NDArray[np.int64]
    usual: float  # the mean length of a whole brick, px
    least: int  # the shortest piece of a brick that looks like one, px
    beside: NDArray[np.int64]  # what a joint costs by its distance (px) from the nearest one in the next course,
    beyond: NDArray[np.int64]  # and in the next but one
    common: int  # the distance from joints of the next course that is the most usual

    @property
    def sizes(self) -> NDArray[np.int64]:
        """Length of every brick, px."""
        return np.asarray(self.table[:, 2] - self.table[:, 1], np.int64)


def bricks_of(work: Brickwork) -> Bricks | None:
    """List the bricks; None where the courses are not made of bricks."""
    places = {k: _places(work, k) for k in work.courses}
    if sum(len(p) for p in places.values()) < max(2, len(work.courses) // 2):
        return None
    whole: list[Brick] = []
    cut: list[Brick] = []
    for k in work.courses:
        names, at, (x0, x1) = work.of_course[k], places[k], work.spans[k]
        half, begin, end = work.thickness // 2, x0 + SORTING.margin, x1 - SORTING.margin
        while at and at[0] < x0 + half:  # only half of the joint is there
            begin, names, at = max(begin, at[0] + half), names[1:], at[1:]
        while at and at[-1] >= x1 - half:
            end, names, at = min(end, at[-1] - half), names[:-1], at[:-1]
        whole += [(k, at[n], at[n + 1], names[n], names[n + 1]) for n in range(len(at) - 1)]
        if at:
            cut += [(k, begin, at[0], FACE, names[0]), (k, at[-1], end, names[-1], FACE)]
    whole, cut = (_straight(work, [e for e in some if e[2] - e[1] >= 3]) for some in (whole, cut))
    if not whole and not cut:
        return None
    lengths = np.array([b - a for _, a, b, _, _ in whole or cut])
    usual = float(np.median(lengths))
    whole = [e for e in whole if e[2] - e[1] >= max(SORTING.broken * usual, 3)]
    if whole:
        usual = float(np.mean([e[2] - e[1] for e in whole]))
    shortest = min((e[2] - e[1] for e in whole), default=0)
    least = SORTING.half * usual if len(whole) < SORTING.few else SORTING.least * shortest
    cut = [] if len(whole) >= SORTING.enough else cut  # its end is straight, and its corners are sharp
    table = np.array(whole + [e for e in cut if e[2] - e[1] >= max(least, 3)], np.int64).reshape(-1, 5)
    if not len(table) or not (table[:, 3] != FACE).any():
        return None
    beside, common = _costs(_distances(places, 1), usual)
    beyond, _ = _costs(_distances(places, 2), usual)
    return Bricks(table, usual, max(2, int(min(least, SORTING.half * usual))), beside, beyond // BOND.beyond, common)


def _straight(work: Brickwork, some: list[Brick]) -> list[Brick]:
    """Leave out bricks whose beds leave the mortar, while enough are left."""
    if len(some) <= SORTING.few:
        return some
    off = []
    for k, a, b, _, _ in some:
        beds = np.clip(work.beds[k : k + 2, a:b], 0, work.faces.shape[0] - 1)
        off.append(work.faces[beds, np.arange(a, b)].mean())
    least = max(SORTING.straying, sorted(off)[SORTING.few - 1])
    return [e for e, face in zip(some, off, strict=True) if face <= least]


def _places(work: Brickwork, k: int) -> list[int]:
    """The columns of the joints of a course, in the middle of it."""
    x0, x1 = work.spans[k]
    y = int(np.median(work.beds[k][x0:x1] + work.beds[k + 1][x0:x1])) // 2
    height = work.joints.shape[1]
    low, high = np.clip([y - 2, y + 3], 0, height - 1)
    return [int(np.median(work.joints[j, low : high + 1])) for j in work.of_course[k]]


def _distances(places: dict[int, list[int]], step: int) -> list[int]:
    """How far each joint lies from the nearest of another course."""
    found = []
    for k, some in places.items():
        other = places.get(k + step)
        if some and other:
            found += [min(abs(a - b) for b in other) for a in some]
            found += [min(abs(a - b) for a in some) for b in other]
    return found


def _costs(distances: list[int], usual: float) -> tuple[NDArray[np.int64], int]:
    """What a distance costs: the more the rarer it is, and dear below what nearly all keep."""
    reach = int(2 * usual) + 2
    if not distances:
        return np.zeros(reach, np.int64), int(usual / 2)
    seen = np.array([d for d in distances if d < reach], np.int64)
    count = np.bincount(seen, minlength=reach).astype(np.float64)
    density = ndimage.gaussian_filter(count, max(1.5, BOND.blur * usual))
    common = int(np.argmax(density))
    cost = np.clip(-BOND.rare * np.log((density + 1e-9) / max(density.max(), 1e-9)), 0, BOND.unusual)
    low = max(float(np.quantile(np.array(distances), BOND.close)), 1.0)
    d = np.arange(reach)
    cost += np.where(d < low, BOND.stacked * (1 - d / low), 0)
    return np.asarray(np.rint(cost), np.int64), common
