"""What an exemplar of courses holds: its beds, the joints between its bricks, and the bricks.

A course runs along x here, from bed to bed; whoever has courses that stand upright swaps the axes before.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..errors import MethodError
from ..kernels import paths
from ..lattice.vectors import UNIT, Vector
from ..lazy import ndimage
from .mortar import FACE, levelled, model, mortar_at
from .peaks import peaks


class Finding(NamedTuple):
    """How beds and joints are found. What halving and doubling does is of 16 walls (docs/design/012)."""

    outside: float = 0.1  # of the pitch a bed may lie outside the exemplar; halved: 44 repeats for 32, doubled: as is
    stray: float = 0.22  # of the pitch a bed may leave its line; halved: 117 joints of 129, doubled: false courses
    pull: int = 40  # of 255 is paid for straying so far; at 0 3 joints of 18 are lost, at 160 6 of 88 are invented
    rounds: int = 3  # times that mortar and beds are found from one another; at 1 507 joints lie over others for 310
    phases: int = 12  # are tried; halved: one wall finds 21 joints of 26, doubled: as is
    coarse: int = 24  # px of pitch: px are averaged above it; never: one course of 5 is lost, always: 75 joints of 148
    low: int = 150  # of 255 a joint's crossing costs at most; halved: 271 joints of 310; 255: boards get joints
    depth: int = 60  # and so much less than both sides; halved: 436 joints, not 349 (invented), doubled: 270, not 366
    apart: int = 4  # joints lie a course's height / apart from one another; halved 1 of 16 changes, doubled 2
    readable: tuple[int, int] = (7, 8)  # of a course must be usable; 15/16 and 3/4: one straightened wall changes
    least_span: int = 4  # columns of a course: fewer have no inside; halved and doubled: nothing


FINDING = Finding()


@dataclass(frozen=True)
class Line:
    """The straight line that a bed follows: row ``(phase + i pitch) / 256 + x slope``.

    `phase`, `pitch` in 1/256 px down the rows; `slope` as a fraction (rows, columns) of whole numbers.
    """

    phase: int
    pitch: int
    slope: Vector

    def lean(self, x: Array) -> NDArray[np.int64]:
        """How far down the line is in some columns, 1/256 px."""
        return np.asarray(x * (self.slope[0] * UNIT) // self.slope[1], np.int64)

    def rows(self, i: int, width: int) -> NDArray[np.int64]:
        """The row of bed `i` in every column of the exemplar."""
        x = np.arange(width, dtype=np.int64)
        return (self.phase + i * self.pitch + UNIT // 2) // UNIT + x * self.slope[0] // self.slope[1]


@dataclass(frozen=True, eq=False)
class Brickwork:
    """Beds, joints and bricks of an exemplar."""

    line: Line  # where beds lie on average
    beds: NDArray[np.int64]  # (n, W): the row of every bed that is found, in every column
    courses: list[int]  # numbers k of the whole courses, between beds k and k + 1
    spans: dict[int, tuple[int, int]]  # the columns (first, end) of each course that lie in the exemplar
    joints: NDArray[np.int64]  # (m, H): the column of every joint in every row
    of_course: dict[int, list[int]]  # the joints of each course, from left to right
    faces: NDArray[np.int16]  # (H, W): how little a pixel looks like mortar: 0 to 255
    thickness: int  # width of a joint, px


def line_of(smooth: Array, usable: NDArray[np.bool_], vector: Vector) -> Line:
    """Where the beds lie: across the vector, at the phase at which they differ most from what lies between."""
    down, aside = vector if vector[0] > 0 else (-vector[0], -vector[1])
    pitch = round((down * down + aside * aside) / down)
    best, found = -1.0, Line(0, pitch, (-aside, down))
    for n in range(FINDING.phases):
        line = Line(n * pitch // FINDING.phases, pitch, (-aside, down))
        faces, _ = model(smooth, usable, _lines(line, usable.shape), pitch / UNIT)
        _, score = model(smooth, usable, _beds(faces, line), pitch / UNIT)
        if score > best * 1.0001:  # no last bit of the linear algebra decides
            best, found = score, line
    return found


def brickwork_of(picture: Array, usable: NDArray[np.bool_], vector: Vector) -> Brickwork:
    """Find beds, mortar and joints; MethodError where no course is whole."""
    height = len(picture)
    size = 3 if vector[0] ** 2 + vector[1] ** 2 > (FINDING.coarse * UNIT) ** 2 else 1
    smooth = ndimage.uniform_filter(picture.astype(np.int32), (size, size, 1))
    line = line_of(smooth, usable, vector)
    beds = _lines(line, usable.shape)
    for _ in range(FINDING.rounds):
        faces, _ = model(smooth, usable, beds, line.pitch / UNIT)
        beds = _beds(faces, line)
    line = _resolved(line, beds, height)
    faces = levelled(faces, line.pitch // UNIT)
    courses, spans = spans_of(usable, beds, line.pitch)
    return with_joints(line, beds, courses, spans, faces)


def with_joints(
    line: Line, beds: Array, courses: list[int], spans: dict[int, tuple[int, int]], faces: Array
) -> Brickwork:
    """Find the joints of courses whose beds and mortar are known."""
    found, of_course = list[Array](), dict[int, list[int]]()
    for k in courses:
        across = joints_across(faces, beds[k], beds[k + 1], spans[k])
        of_course[k] = list(range(len(found), len(found) + len(across)))
        found += across
    joints = np.array(found, np.int64).reshape(-1, len(faces))
    return Brickwork(line, beds, courses, spans, joints, of_course, faces, _thickness(faces, joints, of_course, beds))


def spans_of(usable: NDArray[np.bool_], beds: Array, pitch: int) -> tuple[list[int], dict[int, tuple[int, int]]]:
    """Which courses are whole, and in which columns; MethodError where none is. `pitch`: 1/256 px."""
    courses, spans = list[int](), dict[int, tuple[int, int]]()
    out = FINDING.outside * pitch / UNIT
    for k in range(len(beds) - 1):
        inside = (beds[k] >= -out) & (beds[k + 1] <= len(usable) + out)
        inside &= _readable(usable, beds[k], beds[k + 1])
        span = _longest(inside)
        if span[1] - span[0] >= FINDING.least_span:
            courses.append(k)
            spans[k] = span
    if not courses:
        raise MethodError("the exemplar holds no whole course; give a larger exemplar, or use method repeat.")
    return courses, spans


def _resolved(line: Line, beds: Array, height: int) -> Line:
    """The line moved to where the beds are."""
    inside = (beds >= 1) & (beds < height - 1)
    if not inside.any():
        return line
    exact = beds * UNIT - line.lean(np.arange(beds.shape[1]))
    places = np.array([line.phase + i * line.pitch for i in _numbers(line, height, beds.shape[1])], np.int64)
    off = (exact - places[:, None])[inside]
    return Line(line.phase + int(off.sum()) // len(off), line.pitch, line.slope)


def _numbers(line: Line, height: int, width: int) -> list[int]:
    """The beds that are in the exemplar, or just outside it."""
    lean = np.arange(width) * line.slope[0] // line.slope[1]
    first = (-int(lean.max()) * UNIT - line.phase) // line.pitch - 1
    last = ((height - int(lean.min())) * UNIT - line.phase) // line.pitch + 2
    return list(range(int(first), int(last) + 1))


def _lines(line: Line, shape: tuple[int, int]) -> NDArray[np.int64]:
    return np.stack([line.rows(i, shape[1]) for i in _numbers(line, *shape)])


def _beds(faces: Array, line: Line) -> NDArray[np.int64]:
    """The beds near their lines that stay in mortar best."""
    (height, width), reach = faces.shape, max(1, int(FINDING.stray * line.pitch / UNIT))
    offsets, found = np.arange(-reach, reach + 1), []
    for row in _lines(line, faces.shape):
        y = row[:, None] + offsets
        cost = faces[np.clip(y, 0, height - 1), np.arange(width)[:, None]].astype(np.int64)
        cost += FINDING.pull * offsets**2 // reach**2
        cost[(y < 0) | (y >= height)] = FACE // 2
        found.append(row + paths.cheapest(cost) - reach)
    return np.stack(found).astype(np.int64)


def _readable(usable: Array, above: Array, below: Array) -> NDArray[np.bool_]:
    """The columns in which most of a course may be used."""
    height = usable.shape[0]
    good = np.concatenate([np.zeros((1, usable.shape[1]), np.int64), np.cumsum(usable, axis=0)])
    x = np.arange(usable.shape[1])
    top, end = np.clip(above, 0, height), np.clip(below, 0, height)
    part, whole = FINDING.readable
    return np.asarray((good[end, x] - good[top, x]) * whole >= part * np.maximum(end - top, 1))


def _longest(inside: Array) -> tuple[int, int]:
    """The longest run of true values: first, end."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(np.int8), [0]])))
    if not len(edges):
        return 0, 0
    runs = edges.reshape(-1, 2)
    best = runs[np.argmax(runs[:, 1] - runs[:, 0])]
    return int(best[0]), int(best[1])


def joints_across(faces: Array, above: Array, below: Array, span: tuple[int, int]) -> list[NDArray[np.int64]]:
    """The joints of one course: for each its column in every row of the exemplar."""
    height = len(faces)
    x0, x1 = span
    tall = int(np.median(below[x0:x1] - above[x0:x1]))
    middle = (above + below) // 2
    half = max(1, tall // 2)
    v = np.arange(-half, half + 1)
    y = middle[x0:x1] + v[:, None]
    x = np.broadcast_to(np.arange(x0, x1), y.shape)
    cost = faces[np.clip(y, 0, height - 1), x].astype(np.int64)
    up, down = paths.accumulate(cost[: half + 1]), paths.accumulate(cost[half:][::-1].copy())
    profile = (up[-1] + down[-1] - cost[half]) // len(v)
    joints = []
    for at in _minima(profile, tall // FINDING.apart):
        path = np.concatenate([paths.trace(up, at), paths.trace(down, at)[::-1][1:]]) + x0
        rows = middle[at + x0] + v
        path += int(np.median(_middles(faces, rows, path)))
        joints.append(np.interp(np.arange(height), rows, path).round().astype(np.int64))
    return joints


def _middles(faces: Array, rows: Array, path: Array) -> list[int]:
    """How far the middle of the mortar lies from a path, row by row; the first pixel of its right half."""
    found = [0]
    quarter = len(rows) // 4
    for y, x in zip(rows[quarter : len(rows) - quarter], path[quarter : len(rows) - quarter], strict=True):
        if 0 <= y < len(faces):
            a, b = mortar_at(faces[y], int(x))
            if b > a:
                found.append((a + b) // 2 - int(x))
    return found[1:] or found


def _minima(profile: Array, apart: int) -> list[int]:
    """Where a profile of crossing costs has a deep valley between walls of faces."""
    padded = np.concatenate([[FACE], profile, [FACE]]).astype(np.float64)
    return [x - 1 for x in peaks(FACE - padded, FACE - FINDING.low, FINDING.depth, max(1, apart))]


def _thickness(faces: Array, joints: Array, of_course: dict[int, list[int]], beds: Array) -> int:
    """The median width of the joints in the middle half of their courses, px."""
    widths: list[int] = []
    for k, some in of_course.items():
        top, end = int(np.median(beds[k])), int(np.median(beds[k + 1]))
        quarter = max(1, (end - top) // 4)
        for j in some:
            for y in range(max(0, top + quarter), min(len(faces), end - quarter)):
                a, b = mortar_at(faces[y], int(joints[j, y]))
                widths += [b - a] if b > a else []
    return int(np.median(widths)) if widths else 4
