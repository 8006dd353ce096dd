"""Courses of unequal heights: bed joints from the lines across an exemplar, and the stones between them.

Lines run along the outlines of stones, so a wide bed has two. Each line is moved to a dark or bright path nearby, and
lines of the same bed are merged; of dark and bright beds those that differ most from the faces between them are kept.
Then beds and mortar are found from one another, as in walls of one pitch. The method is this project's own.
"""

from __future__ import annotations

from itertools import pairwise
from statistics import median_high
from typing import NamedTuple

import numpy as np

from ..analysis.features import course_lines, features
from ..analysis.oriented_energy import surest_line
from ..foundation import MethodError
from ..foundation.arrays import Array, Int16, Int64, Mask
from ..foundation.filters import averages, highest, lowest
from ..foundation.geometry import UNIT
from ..foundation.params import Weights
from ..model import Exemplar
from .masonry import (
    FACE,
    Bricks,
    Contrast,
    Finding,
    Line,
    Masonry,
    along_x,
    bricks_of,
    levelled,
    straying,
    with_joints,
)
from .wall_kernels import NO_JOINT as CUT


class Unequal:
    """Beds by lines, and conditions of a wall. Numbers are stones found in 12 exemplars, 181 as set."""

    near = 24  # beds are searched within the shorter side divided by this from a line; 12: 171 stones, 48: 177
    least = 6  # px: and within this at least; 3: the same, 12: 182
    same = 0.6  # of that reach: beds nearer in the mean are merged; 0.3 and 1.2: the same
    bend = 64  # of 255: cost of a bed per px aside; 32: 180, 128: 185, but beds cut corners of stones
    stray = 0.3  # of the lowest course: a bed may leave its line by it once mortar is known; halved: 175, doubled: 178
    wide = 1  # px to either side over which features are averaged; 0: 184, 2: 168
    low = 0.4  # of the median height, and 4 px: lower stones are wide beds; 0.2: the same, 0.8: 155
    full = 170  # of 255: least mean of the map of faces inside a stone, else it holds joints; 180: the same, 220: 174
    like = 0.2  # of a course's height: by so much its stones may be higher or lower; 0.25: they touch across beds
    some = 4  # least such stones of a course that is used; 2: two stones alternate in a row, 8: three of six are lost
    many = 8  # whole stones from which on no stone cut by the border is used; 4: 176, 16: 187
    enough = 10  # least whole stones of a wall; 5: one exemplar of cobbles more is one, 20: five of ten are none
    covered = 0.45  # least share of the exemplar in known stones; ten walls: 0.53 to 0.73, a house front: 0.25
    joints = 96  # of 255: largest mean of the map of faces on joints; ten walls: 5 to 68, hexagons 130, text 114, 176


class UnequalMasonry(NamedTuple):
    """Courses of unequal heights along x: masonry of the exemplar, its bricks, and heights of its courses."""

    picture: Int16  # (H, W, C): features, axes swapped if courses are upright
    usable: Mask
    upright: bool
    work: Masonry
    bricks: Bricks
    own: Int64  # (n,): the height of every brick, px
    heights: tuple[int, ...]  # of the courses with enough bricks of about that height, from top to bottom, px
    faces: int  # mean of the map of faces on joints, 0 to 255

    @property
    def sure(self) -> bool:
        """Whether the automatic choice may use it: by share of known stones, number of whole ones, and joints."""
        known = int((self.own * self.bricks.sizes).sum()) >= Unequal.covered * self.usable.size
        whole = int((self.bricks.table[:, 3:] != CUT).all(axis=1).sum())
        return known and whole >= Unequal.enough and self.faces <= Unequal.joints

    @property
    def told(self) -> str:
        """A description of its stones and courses for messages."""
        size = "wide" if self.upright else "high"
        high = f"{min(self.heights)} to {max(self.heights)}" if len(set(self.heights)) > 1 else f"{self.heights[0]}"
        return f"{len(self.own)} stones lie in courses {high} px {size}"

    @property
    def pitch(self) -> tuple[float, float]:
        """The mean step from course to course: (x, y) px."""
        step = sum(self.heights) / len(self.heights)
        return (step, 0.0) if self.upright else (0.0, step)


def unequal_masonry(exemplar: Exemplar, weights: Weights = None) -> UnequalMasonry:
    """Return the courses of an exemplar by its lines. Raise MethodError if there are none, or no whole brick."""
    return exemplar.memo(("masonry", weights), lambda: _found(exemplar, weights))


def unequal_masonry_or_none(exemplar: Exemplar, weights: Weights = None) -> UnequalMasonry | None:
    """Return the courses of an exemplar; None if it has none, or they hold no bricks."""
    try:
        return unequal_masonry(exemplar, weights)
    except MethodError:
        return None


def clear_masonry(exemplar: Exemplar, weights: Weights = None) -> UnequalMasonry | None:
    """Return the courses of an exemplar if they are clear enough for the automatic choice; else None."""
    found = unequal_masonry_or_none(exemplar, weights)
    return found if found is not None and found.sure else None


def _found(exemplar: Exemplar, weights: Weights) -> UnequalMasonry:
    feats = features([exemplar], weights)
    lines = course_lines(feats, exemplar)
    if lines is None:
        raise MethodError("no lines run across the exemplar between courses.")
    upright = lines.axis == 1
    picture, level, usable = along_x(feats, exemplar, upright)
    work = masonry_between_lines(level, usable, lines.at)
    bricks = bricks_of(work)
    if bricks is None:
        raise MethodError("the courses of the exemplar hold no whole brick.")
    bricks = _sorted_out(work, bricks)
    own = _heights(work, bricks)
    mine = [own[bricks.table[:, 0] == k].tolist() for k in work.spans]
    heights = tuple(median_high(some) for some in mine if some)
    often = [int((np.abs(own - height) <= Unequal.like * height).sum()) for height in heights]
    heights = tuple(h for h, n in zip(heights, often, strict=True) if n >= min(Unequal.some, max(often)))
    work = work._replace(line=Line(0, min(heights) * UNIT, (0, 1)))
    return UnequalMasonry(picture, usable, upright, work, bricks, own, heights, faces_at_joints(work))


def _sorted_out(work: Masonry, bricks: Bricks) -> Bricks:
    """Leave out bricks that contain joints or lie in a wide bed, and those cut by the border if 8 are whole."""
    own = _heights(work, bricks)
    least = max(Unequal.low * median_high(own), 4)
    full = [_filled(work, brick) for brick in bricks.table.tolist()]
    table = bricks.table[(own >= least) & full]
    whole = (table[:, 3:] != CUT).all(axis=1)
    table = table[whole] if int(whole.sum()) >= Unequal.many else table
    if not (table[:, 3] != CUT).any():
        raise MethodError("the courses of the exemplar hold no whole brick.")
    return bricks._replace(table=table)


def _filled(work: Masonry, brick: list[int]) -> bool:
    """Return whether a brick is one face inside, and not several with joints between; `brick`: row of the table."""
    k, a, b = brick[:3]
    rim = min(max(work.thickness, 2), (b - a - 1) // 2)
    top, end = work.beds[k, a + rim : b - rim] + rim, work.beds[k + 1, a + rim : b - rim] - rim
    y = np.arange(max(int(top.min()), 0), min(int(end.max()), len(work.faces)))[:, None]
    inside = (y >= top) & (y < end)
    faces = work.faces[y[:, 0], a + rim : b - rim][inside]
    return int(faces.sum(dtype=np.int64)) >= Unequal.full * len(faces)


def _heights(work: Masonry, bricks: Bricks) -> Int64:
    """Return the height of every brick, px, between the middles of the beds above and below."""
    between = [work.beds[k + 1, a:b] - work.beds[k, a:b] for k, a, b, _, _ in bricks.table]
    return np.array([int(high.sum()) // len(high) for high in between], np.int64)


def faces_at_joints(work: Masonry) -> int:
    """Return the mean of the map of faces on head joints, 0 to 255; 255 without joints."""
    (height, width), total, count = work.faces.shape, 0, 0
    y = np.arange(height)
    for k, some in work.of_course.items():
        for x in np.clip(work.joints[some], 0, width - 1):
            within = (work.beds[k, x] < y) & (y < work.beds[k + 1, x])
            total += int(work.faces[y, x][within].sum(dtype=np.int64))
            count += int(within.sum())
    return total // count if count else FACE


def masonry_between_lines(picture: Array, usable: Mask, lines: Array) -> Masonry:
    """Find beds, mortar and joints from lines (n, W), rows in px, in features (H, W, C).

    Raise MethodError if fewer than two beds are found, or no course is whole.
    """
    reach = max(min(usable.shape) // Unequal.near, Unequal.least)
    smooth = averages(picture.astype(np.int32), Unequal.wide)
    pitch = int(np.diff(lines, axis=0).sum()) // ((len(lines) - 1) * lines.shape[1])
    beds, best = np.empty((0, 0), np.int64), -1.0
    for cost in _fields(smooth, reach):
        some = _apart(_drawn(cost, lines.astype(np.int64), reach), reach)
        score = Contrast.of(smooth, usable, some, pitch).score if len(some) > 1 else 0.0
        if score > best * 1.0001:  # rounding errors do not decide
            beds, best = some, score
    if len(beds) < 2:
        raise MethodError("the lines that run across the exemplar hold no course between them.")
    lowest = min(int((b - a).sum()) // len(a) for a, b in pairwise(beds))
    for _ in range(Finding.rounds):
        faces = Contrast.of(smooth, usable, beds, pitch).faces_of(smooth)
        beds = np.sort(_drawn(faces, beds, max(1, int(Unequal.stray * lowest))), axis=0)
    faces = levelled(faces, pitch)
    return with_joints(Line(0, lowest * UNIT, (0, 1)), beds, usable, faces)


def _fields(smooth: Array, reach: int) -> list[Int64]:
    """Return the cost (H, W) of a bed at every pixel, 0 to 255: first for dark beds, then for bright ones."""
    light, side = smooth.sum(axis=2), 2 * reach + 1
    closed = lowest(highest(light, side, "symmetric"), side, "symmetric")
    opened = highest(lowest(light, side, "symmetric"), side, "symmetric")
    found = []
    for depth in (closed - light, light - opened):
        most = max(int(np.sort(depth, axis=None)[19 * (depth.size - 1) // 20]), 1)
        sure = averages(np.minimum(depth, most) * FACE // most, reach // 3)
        found.append(np.asarray(FACE - sure, np.int64))
    return found


def _drawn(cost: Array, lines: Array, reach: int) -> Int64:
    """Return the cheapest paths at most `reach` px from lines (n, W)."""
    fields = [straying(cost, line, reach, FACE - FACE // 2) for line in lines]
    return np.asarray(lines + np.stack([surest_line(-field.T, Unequal.bend)[0] for field in fields]) - reach)


def _apart(beds: Array, reach: int) -> Int64:
    """Return the beds (n, W), from top to bottom, with those nearer than 0.6 `reach` px in the mean merged."""
    kept: list[Array] = []
    for bed in np.sort(beds, axis=0):
        if kept and int((bed - kept[-1]).sum()) < Unequal.same * reach * len(bed):
            kept[-1] = (kept[-1] + bed) // 2
        else:
            kept.append(bed)
    return np.stack(kept)
