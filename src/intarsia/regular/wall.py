"""Walls: an endless texture of courses of whole bricks, of one pitch or unequal heights, with head joints anywhere.

The piece at a pixel depends only on the pixel and the seed, so any window of the endless texture can be computed alone.

For textures of which only courses repeat, Lopez Recas 2011 places blocks as elsewhere; placing whole bricks course by
course is not in the source.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis import nearest
from ..analysis.features import features
from ..foundation import MethodError
from ..foundation.arrays import Array, Int32, Int64, Laid, Pair
from ..foundation.filters import highest
from ..foundation.geometry import UNIT
from ..foundation.params import Weights
from ..foundation.run import Run
from ..kernels import shortest_paths
from ..lattice import Pairs, cell_of
from ..model import Exemplar
from ..model.canvas import Canvas
from . import wall_kernels
from .course_layout import CourseLayout, boards_of
from .course_rows import Piece, Rows
from .masonry import FACE, Masonry, along_x, bricks_of, masonry_of_pitch
from .unequal_courses import Unequal, faces_at_joints, unequal_masonry

Strip = tuple[Array, Array, Array]


class LRUCache:
    """LRU cache of strips by pairs of numbers, limited to `most` bytes."""

    def __init__(self, most: int) -> None:
        self._most, self._held = most, dict[Pair, Strip]()  # replaced, never changed, as threads share it

    def __reduce__(self) -> Any:
        return LRUCache, (self._most,)

    def all(self, keys: Sequence[Pair], make: Callable[[Sequence[Pair]], Sequence[Strip]]) -> list[Strip]:
        """Return the values of the keys, in their order; `make` computes the missing ones in one call."""
        held = self._held
        found = {key: held[key] for key in keys if key in held}
        missing = [key for key in keys if key not in found]
        found |= zip(missing, make(missing), strict=True)
        held = {key: made for key, made in self._held.items() if key not in found} | found
        sizes = [sum(array.nbytes for array in made) for made in held.values()]
        beyond = np.cumsum(sizes[::-1])[::-1] > self._most
        self._held = {key: made for (key, made), far in zip(held.items(), beyond, strict=True) if not far}
        return [found[key] for key in keys]


Each = Callable[[Callable[[Any], Any], Iterable[Any]], list[Any]]
HELD = 24 << 20  # bytes of courses cached for neighbouring windows
CHUNK = 256  # columns of a bed cut at once, so that a window needs few chunks; 128, 512: the same bytes
RUN_UP = 48  # columns on both sides that fix the cut at the end of a chunk; 24, 96: the same bytes


RIM = 4  # rims of joint width / RIM around faces of stones count as face; without them slivers are visible


class Reach:
    """Range and costs of cuts. If no effect is noted, less than 1 % of the pixels of nine walls of 320 px change."""

    beyond = 4  # px: a cut in a head joint may wander by the joint's width plus this; halved, doubled: not visible
    most = 24  # px: and by this at most, in beds too; halved: two walls change, doubled: the same bytes
    bed = 4  # a cut in a bed may wander by the pitch divided by this; halved, doubled: 5 % of planks, not visible
    dear = 3  # weight of a misplaced face relative to a seam; 1: weaker seams, but bricks are cut, 6: the same


def courses_of(
    lattice: Pairs, weights: Weights, exemplar: Exemplar
) -> tuple[Masonry, Array, Array, bool]:
    """Return the masonry of an exemplar, its features, its usable pixels, and whether courses are upright.

    If they are, the axes of the first three are swapped. Cached with the exemplar.
    """

    def found() -> tuple[Masonry, Array, Array, bool]:
        vector = cell_of(lattice, (exemplar.height, exemplar.width))[0]
        upright = abs(vector[1]) > abs(vector[0])
        picture, level, usable = along_x(features([exemplar], weights), exemplar, upright)
        return masonry_of_pitch(level, usable, vector[::-1] if upright else vector), picture, usable, upright

    return exemplar.latest("courses", (lattice, weights), found)


def brick_share(lattice: Pairs, exemplar: Exemplar) -> float:
    """Return the share of the length of courses in known bricks; 0 if there are none, or joints look like faces."""
    try:
        work = courses_of(lattice, None, exemplar)[0]
        bricks = bricks_of(work)
    except MethodError:
        return 0.0
    length = sum(end - begin for begin, end in work.spans.values())
    if bricks is None or faces_at_joints(work) > Unequal.joints:
        return 0.0
    return float(bricks.sizes.sum()) / max(length, 1)


@dataclass(frozen=True, eq=False)
class Wall:
    """An endless wall of courses."""

    work: Masonry  # of the exemplar, with courses along x
    layout: CourseLayout  # the pieces of each course
    rows: Rows  # the rows at which courses begin
    scene: tuple[Any, ...]  # exemplar data for the kernels: see :mod:`intarsia.regular.wall_kernels`
    upright: bool  # the courses of the exemplar and of the canvas run down the rows: axes are swapped
    known: NDArray[np.intp] | None  # (2, H, W): for every pixel the nearest usable one; None where all are
    strips: LRUCache = field(default_factory=partial(LRUCache, HELD), repr=False)

    @classmethod
    def of(
        cls, lattice: Pairs, weights: Weights, exemplar: Exemplar, canvas: Canvas, seed: int
    ) -> Wall:
        """Find courses and bricks, and lay them out; without a lattice courses of unequal heights, by their lines.

        Raise MethodError if no course is whole, ParameterError if the courses cannot close around the canvas.
        """
        if lattice is None:
            picture, usable, upright, work, bricks, own, heights, _ = unequal_masonry(exemplar, weights)
            layout = CourseLayout(work, bricks, Rows.stacked(heights, canvas, upright, seed), seed, own)
            shown = highest(work.faces, work.thickness // RIM * 2 + 1, "symmetric")
        else:
            work, picture, usable, upright = courses_of(lattice, weights, exemplar)
            rows, shown = Rows.equal(work.line, canvas, upright), work.faces
            layout = CourseLayout(work, bricks_of(work) or boards_of(work), rows, seed)
        spare = 1 if work.thickness > 2 else 0  # px less, so that no sliver of a neighbour is included
        halves = np.array([(work.thickness + 1) // 2 - spare, work.thickness // 2 - spare], np.int64)
        scene = (picture, usable, _misplacement_costs(picture, work, shown), work.beds, work.joints, halves)
        return cls(work, layout, layout.rows, scene, upright, nearest(usable))

    def window(self, y0: int, x0: int, height: int, width: int, run: Run | None = None) -> Int32:
        """Return the exemplar pixels (height, width, 2) of a window of the wall, without rotation or mirroring."""
        if self.upright:
            y0, x0, height, width = x0, y0, width, height
        out = np.full((height, width, 2), -1, np.int32)
        run = run or Run()
        columns, parts = self._pace
        near = range(x0 * parts // columns - 1, (x0 + width - 1) * parts // columns + 2)
        chunks = [m for m in near if self._from(m) < x0 + width and self._from(m + 1) > x0]
        corners = [self.rows.course_at(y, x) for y in (y0, y0 + height) for x in (x0, x0 + width)]
        courses = range(min(corners) - 2, max(corners) + 3)
        done, total, draft = 0, len(chunks) * (2 * len(courses) + 1), partial(self._draft, out)
        with run.pool() as each:
            for m in chunks:
                run.tick(done, total, draft)
                names = [(m, i) for i in courses]
                strips = self.strips.all(names, partial(self._laid, each))
                run.tick(done + 1 + len(strips), total, draft)
                cuts = each(self._cut_bed, [*pairwise(strips)])
                for (strip, following), (top, end) in zip(pairwise(strips[1:]), pairwise(cuts), strict=True):
                    inner = slice(RUN_UP, RUN_UP + len(top))
                    end = end + (following[2] - strip[2])[inner]
                    wall_kernels.write_course(
                        strip[0][:, inner], strip[2][inner] - y0, top, end, out, self._from(m) - x0
                    )
                done += 2 * len(courses)
        run.tick(total, total, draft)
        return self._usable(out)

    def _draft(self, out: Int32) -> Laid:
        """Return the exemplar pixels of a window so far, and which of its pixels are placed."""
        laid = out[:, :, 0] >= 0
        return self._usable(out), None, laid.T if self.upright else laid

    def _usable(self, out: Int32) -> Int32:
        """Return the nearest usable exemplar pixels, with the axes of the exemplar."""
        yx: Array = np.clip(out, 0, np.subtract(self.scene[1].shape, 1))
        if self.known is not None:
            yx = np.moveaxis(self.known[:, yx[..., 0], yx[..., 1]], 0, 2)
        return np.ascontiguousarray(yx.swapaxes(0, 1)[..., ::-1] if self.upright else yx, np.int32)

    @property
    def _reach(self) -> int:
        """Largest distance of a cut from the line of a bed, px."""
        return max(2, min(Reach.most, self.work.line.pitch // UNIT // Reach.bed))

    @property
    def _pace(self) -> Pair:
        """Columns per chunk as a fraction: columns, and the number of chunks that they are divided into."""
        return (wide, max(1, wide // CHUNK)) if (wide := self.rows.width) else (CHUNK, 1)

    def _from(self, m: int) -> int:
        """Return the first column of a chunk of columns."""
        columns, chunks = self._pace
        return m * columns // chunks

    def _laid(self, each: Each, names: Sequence[Pair]) -> list[Strip]:
        """Return the strips of courses in chunks. Chains are laid out in turn, as they depend on one another; head
        joints are cut in parallel.
        """
        spare = RUN_UP + 2 * Reach.most
        pieces = [self.layout.pieces(i, self._from(m) - spare, self._from(m + 1) + spare) for m, i in names]
        return each(self._make_strip, [(*name, some) for name, some in zip(names, pieces, strict=True)])

    def _make_strip(self, course: tuple[int, int, list[Piece]]) -> Strip:
        """Return a course in a chunk: exemplar pixels (R, w, 2), costs beyond its beds (R, w), first canvas row (w,).
        """
        m, i, pieces = course
        first = self._from(m) - RUN_UP
        wide = self._from(m + 1) + RUN_UP + 1 - first
        reach, y0 = self._reach, self.rows.row(2 * i, first)  # rows are counted from there, to stay small numbers
        top = self.rows.rows(i, first, wide, y0)
        below = self.rows.rows(i + 1, first, wide, y0)
        tall = int((below - top).max()) + 2 * reach + 1
        table = np.array([self._row(i, p, first, y0) for p in pieces], np.int64)
        spans = np.array([self._span(i, k, pieces, y0) for k in range(len(pieces))], np.int64)
        out, wrong = np.empty((tall, wide, 2), np.int32), np.empty((tall, wide), np.int64)
        wall_kernels.place_course(self.scene, table, top - reach, spans, out, wrong)
        return out, wrong, top - reach + y0

    def _row(self, i: int, p: Piece, first: int, y0: int) -> tuple[int, ...]:
        """Return a piece for the kernels; its beds are centred on the lines of the course above and below."""
        line = self.work.line
        here, away = p.source + (p.end - p.first) // 2, (p.first + p.end) // 2
        x = np.clip(np.arange(p.source, p.source + p.end - p.first), 0, self.scene[1].shape[1] - 1)
        off = (self.work.beds[p.course][x] + self.work.beds[p.course + 1][x]) * UNIT - 2 * line.lean(x)
        place = int(off.sum()) // (2 * len(x)) + int(line.lean(np.array(here)))
        ty = (place - self.rows.place(2 * i + 1, away) + UNIT // 2) // UNIT + y0
        return p.first - first, p.end - first, p.source - p.first + first, ty, *p[3:8]

    def _span(self, i: int, k: int, pieces: list[Piece], y0: int) -> tuple[int, int, int]:
        """Return the first row of the head joint before a piece, its number of rows, and the range of its cut, px."""
        if k == 0:
            return 0, 1, 0
        left, right = pieces[k - 1], pieces[k]
        wander = min(self.work.thickness + Reach.beyond, Reach.most)
        wander = max(0, min(wander, (left.end - left.first) // 2 - 1, (right.end - right.first) // 2 - 1))
        ends = [self.rows.row(2 * (i + n), right.first + s * wander) - y0 for n in (0, 1) for s in (-1, 1)]
        return min(ends) - self._reach - 1, max(ends) - min(ends) + 2 * self._reach + 3, wander

    def _cut_bed(self, both_strips: tuple[Strip, Strip]) -> Int64:
        """Cut two courses along their bed.

        Return how many rows of the band around the bed the upper one keeps in each column of the chunk.
        """
        upper, lower = both_strips
        cost, gap = wall_kernels.bed_costs(self.scene, upper[:2], lower[:2], lower[2] - upper[2], self._reach)
        wide, both = len(cost), 2 * RUN_UP + 1
        pins = [
            shortest_paths.least_cut(cost[part], gap[part])[RUN_UP] for part in (slice(both), slice(wide - both, wide))
        ]
        inner = cost[RUN_UP : wide - RUN_UP].copy()
        for end, pin in zip((0, -1), pins, strict=True):
            kept = inner[end, pin]
            inner[end] = shortest_paths.BARRED
            inner[end, pin] = kept
        return np.asarray(shortest_paths.least_cut(inner, gap[RUN_UP : wide - RUN_UP])[:-1], np.int64)


def _misplacement_costs(picture: Array, work: Masonry, shown: Array) -> Int64:
    """Return the cost (H, W) of pixels beyond their piece: the map of faces scaled to 3 times the colour contrast."""
    faces = work.faces
    mortar, face = picture[faces < FACE // 4], picture[faces > 3 * FACE // 4]
    contrast = math.dist(mortar.mean(axis=0), face.mean(axis=0)) if len(mortar) and len(face) else 0.0
    return np.asarray(shown.astype(np.int64) * int(Reach.dear * contrast) // FACE, np.int64)
