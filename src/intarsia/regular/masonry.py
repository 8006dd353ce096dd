"""Masonry analysis: bed joints, head joints and bricks of an exemplar of courses.

Courses run along x here, between bed joints; for upright courses the axes are swapped before.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..analysis.features import Features
from ..foundation import MethodError
from ..foundation.arrays import Array, Int16, Int64, Mask, Pair
from ..foundation.filters import averages, blurred, moving_sums
from ..foundation.geometry import UNIT
from ..kernels import shortest_paths
from ..lattice import Vector
from ..model import Exemplar
from .wall_kernels import NO_JOINT as CUT


def along_x(feats: Features, exemplar: Exemplar, upright: bool) -> tuple[Array, Array, Array]:
    """Return features, features without slopes of normals, and usable pixels; axes are swapped if `upright`."""
    found = feats.pictures[0], feats.level, exemplar.free
    one, two, three = (np.ascontiguousarray(a.swapaxes(0, 1)) for a in found) if upright else found
    return one, two, three


def peaks(profile: Array, height: float, prominence: float, distance: int) -> list[int]:
    """Return the peaks of a profile (n,) of at least this height, prominence and distance, as SciPy's find_peaks does.

    The middle of a plateau is its peak. Of two peaks nearer than `distance` the higher one stays, the later of equals.
    """
    found = [at for at in _tops(profile) if profile[at] >= height]
    kept: list[int] = []
    for at in sorted(found, key=lambda at: (profile[at], at), reverse=True):
        if all(abs(at - other) >= distance for other in kept):
            kept.append(at)
    return [at for at in sorted(kept) if _prominence(profile, at) >= prominence]


def _tops(profile: Array) -> list[int]:
    """Return the middles of plateaus that are higher than both neighbours."""
    begins = np.concatenate([[0], np.flatnonzero(np.diff(profile)) + 1])
    ends = np.append(begins[1:], len(profile)) - 1
    level = profile[begins]
    inner = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])) + 1
    return [int(at) for at in (begins[inner] + ends[inner]) // 2]


def _prominence(profile: Array, at: int) -> float:
    """Return the prominence of a peak: its least descent towards a higher point, or to the end, on either side."""
    lowest = []
    for side in (profile[at::-1], profile[at:]):
        higher = np.flatnonzero(side > profile[at])
        lowest.append(side[: higher[0] if len(higher) else len(side)].min())
    return float(profile[at] - max(lowest))


FACE = 255  # value of a pixel on the face of a brick in maps of faces; mortar has 0


class Mortar:
    """Classification of mortar. Effects of other values are of 16 walls (docs/design/012)."""

    noise = 16.0  # added variance of each channel; 1: 2 joints of 25 are lost, 256: one course of 5
    near = 1  # up to so many tenths of the way from mortar to faces a pixel is mortar; 0: a wall loses 1 joint of 43
    far = 8  # from so many tenths on it is face; 7: one wall loses two joints of 25
    middle = (3, 7)  # tenths of a course's height sampled as face; (4, 6): 54 joints of 113, (1, 9): all walls differ
    dull = FACE // 3  # pixels above it count as face in local means, which it also bounds; halved, doubled: not visible
    sharp = 4096  # largest weight of a channel; weights are whole numbers, so that rounding errors do not decide
    least = 4  # least pixels of mortar and of face; halved and doubled: the same


class Contrast(NamedTuple):
    """Linear classifier of mortar and faces: channel weights, and how well they separate both."""

    score: float
    weights: Int64 = np.zeros(0, np.int64)  # of the channels
    low: int = 0  # weighted sum of the median mortar
    high: int = 0  # weighted sum of the median face

    @classmethod
    def of(cls, smooth: Array, usable: Mask, beds: Array, pitch: float) -> Contrast:
        """Return Fisher's linear discriminant between pixels on the beds (n, W) and midway between; score 0 if none.

        The weights are rounded to whole numbers, so that results are the same on every machine. `smooth`: features
        (H, W, C); `pitch`: of the courses, px.
        """
        first, last = Mortar.middle
        parts = np.linspace(first / 10, last / 10, max(2, int(pitch * (last - first) / 10)))
        between = np.rint(beds[:-1, None] + parts[:, None] * (beds[1:] - beds[:-1])[:, None]).astype(np.int64)
        mortar = _on(np.concatenate([beds - 1, beds]), usable, 1)
        face = _on(between.reshape(-1, usable.shape[1]), usable, 0)
        if min(mortar.sum(), face.sum()) < Mortar.least:
            return cls(0.0)
        one, two = smooth[mortar].astype(np.float64), smooth[face].astype(np.float64)
        a, b = np.median(one, axis=0), np.median(two, axis=0)
        spread = np.atleast_2d(np.cov(one, rowvar=False) + np.cov(two, rowvar=False)) / 2
        weights = np.linalg.solve(spread + Mortar.noise * np.eye(smooth.shape[2]), b - a)
        score = float((weights * (b - a)).sum())
        if score < 1e-9:
            return cls(0.0)
        whole = np.rint(weights * (Mortar.sharp / np.abs(weights).max())).astype(np.int64)
        return cls(score, whole, int((a * whole).sum()), int((b * whole).sum()))

    def faces_of(self, smooth: Array) -> Int16:
        """Return the map of faces (H, W): 0 for mortar to FACE for faces; FACE everywhere if the score is 0."""
        if not self.score:
            return np.full(smooth.shape[:2], FACE, np.int16)
        value, apart = smooth.astype(np.int64) @ self.weights - self.low, self.high - self.low
        faces = (value * 10 - Mortar.near * apart) * FACE // ((Mortar.far - Mortar.near) * max(apart, 1))
        return np.asarray(np.clip(faces, 0, FACE), np.int16)


def _on(rows: Array, usable: Mask, rim: int) -> Mask:
    """Return the usable pixels of some rows (n, W), without `rim` rows at the top and bottom."""
    on: Mask = np.zeros(usable.shape, bool)
    ok = (rows >= rim) & (rows < len(on) - rim)
    on[rows[ok], np.nonzero(ok)[1]] = True
    return on & usable


def levelled(faces: Array, pitch: int) -> Int16:
    """Return the map of faces scaled to equal local means of faces, so that mortar between dull faces is found, too."""
    part = faces > Mortar.dull
    total, count = np.where(part, faces, 0), part.astype(np.int64)
    for axis in (0, 1):
        total, count = (moving_sums(values, axis, max(1, pitch), "symmetric") for values in (total, count))
    factor = FACE / np.clip(total / np.maximum(count, 1), Mortar.dull, FACE)
    return np.asarray(np.clip(np.rint(faces * factor), 0, FACE), np.int16)


def mortar_at(row: Array, x: int) -> Pair:
    """Return the run of mortar around x in a row of the map of faces: first, end; empty if x is no mortar."""
    a = b = min(max(x, 0), len(row) - 1)
    while a > 0 and row[a - 1] < FACE // 2:
        a -= 1
    while b < len(row) and row[b] < FACE // 2:
        b += 1
    return a, b


class Finding:
    """Search for beds and joints. Effects of other values are of 16 walls (docs/design/012)."""

    outside = 0.1  # of the pitch: a bed may lie outside the exemplar by it; halved: 44 repeats, not 32, doubled: same
    stray = 0.22  # of the pitch: a bed may leave its line by it; halved: 117 joints of 129, doubled: false courses
    pull = 40  # of 255: cost per px of straying so far; 0: 3 joints of 18 are lost, 160: 6 of 88 are false
    rounds = 3  # alternations of mortar from beds and beds from mortar; 1: 507 stacked joints instead of 310
    columns = 64  # least columns sampled for the phase; 32, 128: the same, all: a normal map gains a joint
    phases = 12  # phases tried; halved: one wall finds 21 joints of 26, doubled: the same
    coarse = 24  # px: above this pitch pixels are averaged; never: one course of 5 lost, always: 75 joints of 148
    low = 150  # of 255: largest mean cost of a path along a joint; halved: 271 joints of 310; 255: boards get joints
    depth = 60  # least prominence of that cost; halved: 436 joints instead of 349 (false), doubled: 270, not 366
    apart = 4  # least distance of joints is a course's height divided by this; halved: 1 of 16 changes, doubled: 2
    readable = (7, 8)  # least usable share of a course in each column; 15/16 and 3/4: one straightened wall changes
    least_span = 4  # least columns of a course; halved and doubled: the same


class Line(NamedTuple):
    """The straight line that a bed follows: row ``(phase + i pitch) / 256 + x slope``.

    `phase`, `pitch` in 1/256 px down the rows; `slope` as a fraction (rows, columns) of whole numbers.
    """

    phase: int
    pitch: int
    slope: Vector

    def lean(self, x: Array) -> Int64:
        """Return the rows, 1/256 px, by which the line in columns `x` lies below that in column 0."""
        return np.asarray(x * (self.slope[0] * UNIT) // self.slope[1], np.int64)

    def places(self, shape: Pair) -> Int64:
        """Return the rows in column 0 of the beds in the exemplar and just outside it, 1/256 px."""
        lean = np.arange(shape[1]) * self.slope[0] // self.slope[1]
        first = (-int(lean.max()) * UNIT - self.phase) // self.pitch - 1
        end = ((shape[0] - int(lean.min())) * UNIT - self.phase) // self.pitch + 3
        return self.phase + self.pitch * np.arange(first, end)

    def rows(self, shape: Pair) -> Int64:
        """Return the rows of these beds in every column of the exemplar: (n, W)."""
        lean = np.arange(shape[1]) * self.slope[0] // self.slope[1]
        return (self.places(shape)[:, None] + UNIT // 2) // UNIT + lean


class Masonry(NamedTuple):
    """Bed joints, head joints and mortar of an exemplar."""

    line: Line  # where beds lie on average
    beds: Int64  # (n, W): the row of every bed in every column
    spans: dict[int, Pair]  # columns (first, end) in which course k, between beds k and k + 1, is whole
    joints: Int64  # (m, H): the column of every joint in every row
    of_course: dict[int, list[int]]  # the joints of each course, from left to right
    faces: Int16  # (H, W): map of faces, 0 for mortar to 255
    thickness: int  # median width of a head joint, px


def line_of(smooth: Array, usable: Mask, vector: Vector) -> Line:
    """Return the line of the beds, perpendicular to the vector, at the phase of the highest contrast."""
    down, aside = vector if vector[0] > 0 else (-vector[0], -vector[1])
    pitch = round((down * down + aside * aside) / down)
    every = max(1, usable.shape[1] // Finding.columns)
    smooth, usable = np.ascontiguousarray(smooth[:, ::every]), np.ascontiguousarray(usable[:, ::every])
    best, found = -1.0, 0
    for phase in (n * pitch // Finding.phases for n in range(Finding.phases)):
        line = Line(phase, pitch, (-aside * every, down))
        faces = Contrast.of(smooth, usable, line.rows(usable.shape), pitch / UNIT).faces_of(smooth)
        score = Contrast.of(smooth, usable, _beds(faces, line), pitch / UNIT).score
        if score > best * 1.0001:  # rounding errors do not decide
            best, found = score, phase
    return Line(found, pitch, (-aside, down))


def masonry_of_pitch(picture: Array, usable: Mask, vector: Vector) -> Masonry:
    """Find beds, mortar and joints. Raise MethodError if no course is whole."""
    coarse = vector[0] ** 2 + vector[1] ** 2 > (Finding.coarse * UNIT) ** 2
    smooth = averages(picture.astype(np.int32), 1) if coarse else picture
    line = line_of(smooth, usable, vector)
    beds = line.rows(usable.shape)
    for _ in range(Finding.rounds):
        faces = Contrast.of(smooth, usable, beds, line.pitch / UNIT).faces_of(smooth)
        beds = _beds(faces, line)
    line = _resolved(line, beds, usable.shape)
    faces = levelled(faces, line.pitch // UNIT)
    return with_joints(line, beds, usable, faces)


def with_joints(line: Line, beds: Array, usable: Mask, faces: Array) -> Masonry:
    """Find the joints of whole courses between known beds. Raise MethodError if no course is whole."""
    spans = _spans(usable, beds, Finding.outside * line.pitch / UNIT)
    found, of_course = list[Array](), dict[int, list[int]]()
    for k, span in spans.items():
        across = joints_across(faces, beds[k], beds[k + 1], span)
        of_course[k] = list(range(len(found), len(found) + len(across)))
        found += across
    joints = np.array(found, np.int64).reshape(-1, len(faces))
    return Masonry(line, beds, spans, joints, of_course, faces, _thickness(faces, joints, of_course, beds))


def _spans(usable: Mask, beds: Array, out: float) -> dict[int, Pair]:
    """Return the columns of each whole course, at most `out` px beyond the exemplar, longest run only.

    Raise MethodError if there is none.
    """
    spans = {}
    for k, (above, below) in enumerate(pairwise(beds)):
        inside = (above >= -out) & (below <= len(usable) + out) & _readable(usable, above, below)
        edges = np.flatnonzero(np.diff(inside, prepend=False, append=False)).reshape(-1, 2)  # of runs of true values
        first, end = max(edges.tolist(), key=lambda run: run[1] - run[0], default=(0, 0))
        if end - first >= Finding.least_span:
            spans[k] = first, end
    if not spans:
        raise MethodError("the exemplar holds no whole course; give a larger exemplar, or use method repeat.")
    return spans


def _resolved(line: Line, beds: Array, shape: Pair) -> Line:
    """Return the line with the mean phase of the beds."""
    inside = (beds >= 1) & (beds < shape[0] - 1)
    if not inside.any():
        return line
    off = (beds * UNIT - line.lean(np.arange(shape[1])) - line.places(shape)[:, None])[inside]
    return line._replace(phase=line.phase + int(off.sum()) // len(off))


def straying(cost: Array, line: Array, reach: int, beyond: int) -> Int64:
    """Return the cost of a bed at rows -reach to reach from a line (W,): (W, 2 reach + 1).

    `cost` (H, W) plus a quadratic term, 40 at `reach`; `beyond` outside of the exemplar.
    """
    aside = np.arange(-reach, reach + 1)
    y = line[:, None] + aside
    found = cost[np.clip(y, 0, len(cost) - 1), np.arange(len(line))[:, None]].astype(np.int64)
    found += Finding.pull * aside**2 // reach**2
    found[(y < 0) | (y >= len(cost))] = beyond
    return found


def _beds(faces: Array, line: Line) -> Int64:
    """Return the rows (n, W) of the cheapest paths through mortar near the lines of the beds."""
    reach = max(1, int(Finding.stray * line.pitch / UNIT))
    rows = line.rows(faces.shape)
    return np.stack([row + shortest_paths.cheapest(straying(faces, row, reach, FACE // 2)) - reach for row in rows])


def _readable(usable: Array, above: Array, below: Array) -> Mask:
    """Return the columns (W,) in which at least 7/8 of a course is usable."""
    height = usable.shape[0]
    good = np.concatenate([np.zeros((1, usable.shape[1]), np.int64), np.cumsum(usable, axis=0)])
    x = np.arange(usable.shape[1])
    top, end = np.clip(above, 0, height), np.clip(below, 0, height)
    part, whole = Finding.readable
    return np.asarray((good[end, x] - good[top, x]) * whole >= part * np.maximum(end - top, 1))


def joints_across(faces: Array, above: Array, below: Array, span: Pair) -> list[Int64]:
    """Return the joints of one course: for each its column in every row of the exemplar."""
    height = len(faces)
    x0, x1 = span
    tall = int(np.median(below[x0:x1] - above[x0:x1]))
    middle = (above + below) // 2
    half = max(1, tall // 2)
    v = np.arange(-half, half + 1)
    y = middle[x0:x1] + v[:, None]
    x = np.broadcast_to(np.arange(x0, x1), y.shape)
    cost = faces[np.clip(y, 0, height - 1), x].astype(np.int64)
    up, down = shortest_paths.accumulate(cost[: half + 1], 0), shortest_paths.accumulate(cost[half:][::-1].copy(), 0)
    profile = (up[-1] + down[-1] - cost[half]) // len(v)
    padded = np.concatenate([[FACE], profile, [FACE]]).astype(np.float64)  # so that joints at the ends are valleys, too
    joints = []
    for valley in peaks(FACE - padded, FACE - Finding.low, Finding.depth, max(1, tall // Finding.apart)):
        at = valley - 1
        path = np.concatenate([shortest_paths.trace(up, at, 0), shortest_paths.trace(down, at, 0)[::-1][1:]]) + x0
        rows = middle[at + x0] + v
        inner = slice(len(v) // 4, len(v) - len(v) // 4)
        path += int(np.median([(a + b) // 2 - x for a, b, x in _mortar(faces, rows[inner], path[inner])] or [0]))
        joints.append(np.interp(np.arange(height), rows, path).round().astype(np.int64))
    return joints


def _mortar(faces: Array, rows: Array, columns: Array) -> list[tuple[int, int, int]]:
    """Return the mortar around places, (first, end, column), row by row; places off mortar are left out."""
    places = zip(rows.tolist(), columns.tolist(), strict=True)
    found = [(*mortar_at(faces[y], x), x) for y, x in places if 0 <= y < len(faces)]
    return [place for place in found if place[1] > place[0]]


def _thickness(faces: Array, joints: Array, of_course: dict[int, list[int]], beds: Array) -> int:
    """Return the median width of the joints in the middle half of their courses, px; 4 if there are none."""
    widths: list[int] = []
    for k, some in of_course.items():
        top, end = int(np.median(beds[k])), int(np.median(beds[k + 1]))
        quarter = max(1, (end - top) // 4)
        rows = np.arange(max(0, top + quarter), min(len(faces), end - quarter))
        for j in some:
            widths += [b - a for a, b, _ in _mortar(faces, rows, joints[j, rows])]
    return int(np.median(widths)) if widths else 4


Brick = tuple[int, int, int, int, int]


class Sorting:
    """Choice of the bricks of an exemplar. Counts are of 16 walls of 512 px (docs/design/012)."""

    margin = 3  # px at the border of the exemplar that are left for seams; halved, doubled: not visible
    broken = 0.3  # of the median brick: least length; halved: one wall uses chips, doubled: 9 of 67 are lost
    half = 0.45  # of the mean brick: least length of cut ones if few are whole; halved: slivers in four walls
    least = 0.9  # of the shortest whole brick: the same if many are whole; halved: three walls use halved setts
    few = 8  # fewer whole bricks are few; halved: 859 pieces cut by the border are used instead of 268, doubled: 343
    enough = 16  # whole bricks from which on no cut one is used; 20: one piece in seven of a wall of stones looked cut
    straying = 70  # of 255: largest mean of the map of faces on a brick's beds; without: two setts count as one stone


class Bond:
    """Costs of joints by the nearest joint of another course, in units of :class:`~.course_layout.Costs`.

    Numbers are counts of stacked joints in the same 16 walls, or those that differ.
    """

    stacked = 500  # joints one upon another; 0: 417 instead of 313, halved: 125 for 123, doubled: 87 for 83
    unusual = 240  # largest cost of rare distances; 0: a drawn English bond has 53 of 279 near others, not 22
    rare = 60  # distances e times rarer than the most common; halved: 293 instead of 310, doubled: 103 for 79
    blur = 0.08  # of a mean brick, at least 1.5 px: sigma of distances; halved: 254 for 232, doubled: 139 for 125
    close = 0.1  # quantile of the distances below which joints are stacked; halved: 286, not 241, doubled: 182, not 258
    beyond = 4  # divides the costs for the next course but one; halved: 330 for 280, doubled: 100 for 77


class Bricks(NamedTuple):
    """The bricks of an exemplar."""

    # (n, 5): of every brick its course, first column and end in the exemplar, and for its left and right end the
    # number of the joint, or CUT (NO_JOINT) where the border of the exemplar cuts it.
    table: Int64
    usual: float  # the mean length of a whole brick, px
    least: int  # the shortest piece of a brick that looks like one, px
    beside: Int64  # cost of a joint by its distance in px from the nearest one in the next course
    beyond: Int64  # the same for the next course but one
    common: int  # the most common distance from joints of the next course, px

    @property
    def sizes(self) -> Int64:
        """Length of every brick, px."""
        return np.asarray(self.table[:, 2] - self.table[:, 1], np.int64)


def bricks_of(work: Masonry) -> Bricks | None:
    """Return the bricks; None if there are fewer than two joints, or than one in two courses, or no brick is whole."""
    places = {k: _places(work, k) for k in work.spans}
    if sum(len(p) for p in places.values()) < max(2, len(places) // 2):
        return None
    whole: list[Brick] = []
    cut: list[Brick] = []
    for k, (x0, x1) in work.spans.items():
        joints = list(zip(places[k], work.of_course[k], strict=True))
        half, begin, end = work.thickness // 2, x0 + Sorting.margin, x1 - Sorting.margin
        while joints and joints[0][0] < x0 + half:  # only half of the joint is there
            begin = max(begin, joints.pop(0)[0] + half)
        while joints and joints[-1][0] >= x1 - half:
            end = min(end, joints.pop()[0] - half)
        whole += [(k, a, b, left, right) for (a, left), (b, right) in pairwise(joints)]
        if joints:
            (a, left), (b, right) = joints[0], joints[-1]
            cut += [(k, begin, a, CUT, left), (k, b, end, right, CUT)]
    whole, cut = (_straight(work, [e for e in some if e[2] - e[1] >= 3]) for some in (whole, cut))
    if not whole and not cut:
        return None
    lengths = np.array([b - a for _, a, b, _, _ in whole or cut])
    usual = float(np.median(lengths))
    whole = [e for e in whole if e[2] - e[1] >= max(Sorting.broken * usual, 3)]
    if whole:
        usual = float(np.mean([e[2] - e[1] for e in whole]))
    shortest = min((e[2] - e[1] for e in whole), default=0)
    least = Sorting.half * usual if len(whole) < Sorting.few else Sorting.least * shortest
    cut = [] if len(whole) >= Sorting.enough else cut  # cut ends are straight with sharp corners
    table = np.array(whole + [e for e in cut if e[2] - e[1] >= max(least, 3)], np.int64).reshape(-1, 5)
    if not len(table) or not (table[:, 3] != CUT).any():
        return None
    beside, common = _costs(_distances(places, 1), usual)
    beyond, _ = _costs(_distances(places, 2), usual)
    return Bricks(table, usual, max(2, int(min(least, Sorting.half * usual))), beside, beyond // Bond.beyond, common)


def _straight(work: Masonry, some: list[Brick]) -> list[Brick]:
    """Leave out bricks whose beds do not run through mortar, but keep at least 8."""
    if len(some) <= Sorting.few:
        return some
    off = []
    for k, a, b, _, _ in some:
        beds = np.clip(work.beds[k : k + 2, a:b], 0, work.faces.shape[0] - 1)
        off.append(work.faces[beds, np.arange(a, b)].mean())
    least = max(Sorting.straying, sorted(off)[Sorting.few - 1])
    return [e for e, face in zip(some, off, strict=True) if face <= least]


def _places(work: Masonry, k: int) -> list[int]:
    """Return the columns of the joints of a course, in the middle of it."""
    x0, x1 = work.spans[k]
    y = int(np.median(work.beds[k][x0:x1] + work.beds[k + 1][x0:x1])) // 2
    height = work.joints.shape[1]
    low, high = np.clip([y - 2, y + 3], 0, height - 1)
    return [int(np.median(work.joints[j, low : high + 1])) for j in work.of_course[k]]


def _distances(places: dict[int, list[int]], step: int) -> list[int]:
    """Return the distances, px, of joints from the nearest one `step` courses further, in both directions."""
    found = []
    for k, some in places.items():
        other = places.get(k + step)
        if some and other:
            found += [min(abs(a - b) for b in other) for a in some]
            found += [min(abs(a - b) for a in some) for b in other]
    return found


def _costs(distances: list[int], usual: float) -> tuple[Int64, int]:
    """Return the cost by distance, higher for rare and for the smallest ones; and the most common distance, px."""
    reach = int(2 * usual) + 2
    if not distances:
        return np.zeros(reach, np.int64), int(usual / 2)
    seen = np.array([d for d in distances if d < reach], np.int64)
    count = np.bincount(seen, minlength=reach).astype(np.float64)
    density = blurred(count, max(1.5, Bond.blur * usual), "symmetric", (0,))
    common = int(np.argmax(density))
    cost = np.clip(-Bond.rare * np.log((density + 1e-9) / max(density.max(), 1e-9)), 0, Bond.unusual)
    low = max(float(np.quantile(np.array(distances), Bond.close)), 1.0)
    d = np.arange(reach)
    cost += np.where(d < low, Bond.stacked * (1 - d / low), 0)
    return np.asarray(np.rint(cost), np.int64), common
