"""Lines that run across an exemplar from side to side: joints between courses of stones, boards or tiles.

One by one the path is looked for along which outlines in its direction are surest; it bends where courses do, and none
comes close to another. They are courses where such lines are spread over the whole exemplar, and outlines in their
direction lie on them rather than between: wood, bark and cloth have lines anywhere.

Source: our own; paths by dynamic programming as seams are (Efros and Freeman 2001). All decisions are in whole numbers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.paths import surest_line
from .oriented import SURE, Outlines

BEND = SURE  # a line that steps aside by a px loses what a px of the surest outline is worth
CLOSE = 24, 6  # lines are as far apart as this part of the shorter side, and so many px, or more
LEAST = 0.5  # sureness of a line, bends subtracted. Of all that are found in 80 photographs a third has more
ENDS = 4, 0.125  # no line is what is less sure in one of so many parts; of lines of eleven walls 0.16 and more
FEWEST = 3  # lines
WIDEST = 3  # no course is higher than this part of the exemplar, whose ends are none
CLEAR = 4.3  # times as sure on lines as halfway between. Of seven walls 4.7 to 21; of ripples 4.0, bark 2.8, cloth 2.3
HALF = 1024  # steps from a line to the middle of a course

Array = NDArray[Any]


class Lines(NamedTuple):
    """Lines between courses, in their order.

    ``axis``: 0 where they run along rows, 1 where along columns; ``at`` (K, n) int32: of every line the row in each
    column, or the column in each row, px; ``sure`` (K,): how sure each is, 0 to 1; ``clear``: how much more so than
    what lies between them.
    """

    axis: int
    at: NDArray[np.int32]
    sure: tuple[float, ...]
    clear: float

    @property
    def heights(self) -> list[int]:
        """How high the courses between them are in the mean, px."""
        return [round(int(gap.sum()) / gap.size) for gap in np.diff(self.at, axis=0)]


def lines_of(found: Outlines, shape: tuple[int, ...], toroidal: bool) -> Lines | None:
    """Return the lines between the courses of a picture of this shape, by its outlines; None where it has none."""
    both = [_along(axis, found.sure(found.along[axis]), toroidal) for axis in (0, 1)]
    courses = [lines for lines in both if lines is not None]
    if not courses:
        return None
    best = max(courses, key=lambda lines: lines.clear)
    at = best.at * found.factor + found.factor // 2
    at = at.repeat(found.factor, axis=1)
    at = np.pad(at, ((0, 0), (0, shape[1 - best.axis] - at.shape[1])), "edge")
    return best._replace(at=np.asarray(at, np.int32))


def from_middle(lines: Lines, shape: tuple[int, ...], toroidal: bool) -> NDArray[np.int32]:
    """Return how far each pixel of a picture (H, W) lies from the middle of its course: 0, to HALF on lines.

    Beyond the first and the last line courses go on as high as they are in the mean.
    """
    n = shape[lines.axis]
    above, below = _around(lines.at.astype(np.int64), n, toroidal)
    far = HALF * np.abs(2 * np.arange(n)[:, None] - above - below) // np.maximum(below - above, 1)
    return np.asarray(far if lines.axis == 0 else far.T, np.int32)


def _around(at: Array, n: int, toroidal: bool) -> tuple[Array, Array]:
    """Where the lines above and below every pixel of a picture n px high lie, (n, W) each."""
    if toroidal:
        at = np.concatenate([at[-1:] - n, at, at[:1] + n])
    else:
        high = max(int((at[-1] - at[0]).sum()) // ((len(at) - 1) * at.shape[1]), 1)
        more = high * np.arange(1, max(int(at[0].max()), n - int(at[-1].min())) // high + 2)[:, None]
        at = np.concatenate([at[0] - more[::-1], at, at[-1] + more])
    number, y = np.zeros((n, at.shape[1]), np.int64), np.arange(n)[:, None]
    for line in at[1:-1]:
        number += y >= line
    return np.take_along_axis(at, number, axis=0), np.take_along_axis(at, number + 1, axis=0)


def _along(axis: int, sure: Array, toroidal: bool) -> Lines | None:
    """Look for lines along one axis, the surest first."""
    sure = np.ascontiguousarray(sure if axis == 0 else sure.T)
    (h, w), close, y = sure.shape, max(min(sure.shape) // CLOSE[0], CLOSE[1]), np.arange(sure.shape[0])[:, None]
    left = np.concatenate([sure] * 2, axis=1) if toroidal else sure.copy()  # round the torus, lines end as they begin
    path, found = np.empty(left.shape[1], np.int32), []
    while (total := surest_line(left, BEND, path)) >= LEAST * SURE * len(path):
        line = np.roll(path[w // 2 : w // 2 + w], w // 2) if toroidal else path.copy()
        if _goes_through(sure[line, np.arange(w)]):
            found.append((line, total / (SURE * len(path))))
        far = np.abs(y - line)
        taken = (np.minimum(far, h - far) if toroidal else far) < close
        left[np.tile(taken, (1, left.shape[1] // w))] = -len(path) * SURE
    if len(found) < FEWEST:
        return None
    found.sort(key=lambda one: int(one[0].sum()))
    at = np.sort(np.array([line for line, _ in found]), axis=0)
    ends = [at[-1:] - h, at[:1] + h] if toroidal else [np.zeros_like(at[:1]), np.full_like(at[:1], h)]
    gaps = np.diff(np.concatenate([ends[0], at, ends[1]]), axis=0).sum(axis=1)
    clear = _clear(sure, at, toroidal)
    if int(gaps.max()) * WIDEST > h * w or clear < CLEAR:
        return None
    return Lines(axis, at, tuple(worth for _, worth in found), clear)


def _goes_through(sure: Array) -> bool:
    """Whether what is sure so much from side to side ends nowhere between."""
    parts = np.array_split(sure, ENDS[0])
    return all(int(part.sum()) >= ENDS[1] * SURE * len(part) for part in parts)


def _clear(sure: Array, at: Array, toroidal: bool) -> float:
    """How much surer outlines are on lines than about halfway between two of them."""
    h = len(sure)
    above, below = _around(at.astype(np.int64), h, toroidal)
    up, down = np.arange(h)[:, None] - above, below - np.arange(h)[:, None]
    inside = np.ones(sure.shape, bool) if toroidal else (above >= at[0]) & (below <= at[-1])
    on = inside & (np.minimum(up, down) <= 1)
    middle = inside & (10 * np.minimum(up, down) >= 3 * (below - above))
    between = int(sure[middle].sum()) * max(int(on.sum()), 1)
    return int(sure[on].sum()) * int(middle.sum()) / max(between, 1)
