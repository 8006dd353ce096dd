"""Block grid of near-regular textures: parallelograms of whole periods whose edges lie in the joints.

All lengths are whole numbers of 1/256 px, so that the position of a block is exact even far from the origin (rows and
columns may be as large as 2**40 px). A block is spanned by two lattice vectors; for the usual lattices of bricks, tiles
and weaves it is a rectangle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..foundation.arrays import Array, Floats, Int16, Int64, Mask, Pair
from ..foundation.geometry import UNIT
from ..lattice import Vector, Vectors
from ..lattice.correlation_peaks import lattice_points, overlap
from . import block_kernels

Places = dict[Pair, Int64]
Cell = tuple[Vector, Vector | None]

LEAST_SIDE = 40.0  # px: least side of a block, so that single atypical elements are not scattered
UPRIGHT = 0.12  # a vector within this slope of an axis counts as lying along it
COMBINATIONS = 6  # largest multiple of each lattice vector in the sums among which the sides of a block are searched
BORDER = 14  # px: width of the band of a cut, the default of method near-regular
PAIRS = 10  # lattice vectors by which the exemplar is shifted to measure the cost of a phase


@dataclass(frozen=True)
class BlockGrid:
    """Where blocks lie: block (i, j) begins at ``phase + i rows + j columns``."""

    rows: Vector  # offset from a block to the one below, (dy, dx) in 1/256 px
    columns: Vector  # offset from a block to the one on its right
    phase: Vector  # first corner of block (0, 0), the same in the exemplar and on the canvas, 1/256 px
    cell: Cell  # the lattice vectors, 1/256 px; the second is None if there is no period along the courses

    @property
    def vectors(self) -> Vectors:
        """The lattice vectors; there must be two."""
        assert self.cell[1] is not None
        return self.cell[0], self.cell[1]

    @property
    def determinant(self) -> int:
        """Area of a block in 1/65536 px, positive."""
        return self.rows[0] * self.columns[1] - self.rows[1] * self.columns[0]

    def origin(self, i: int, j: int) -> Pair:
        """Return the first corner of a block, 1/256 px; exact for any i, j."""
        return (
            self.phase[0] + i * self.rows[0] + j * self.columns[0],
            self.phase[1] + i * self.rows[1] + j * self.columns[1],
        )

    def block_of(self, y: int, x: int) -> Pair:
        """Return the block that covers the canvas pixel (y, x)."""
        dy, dx = y * UNIT - self.phase[0], x * UNIT - self.phase[1]
        return (
            (dy * self.columns[1] - dx * self.columns[0]) // self.determinant,
            (dx * self.rows[0] - dy * self.rows[1]) // self.determinant,
        )

    @cached_property
    def reach(self) -> tuple[Pair, Pair]:
        """How far a block reaches before its first corner, at most (0, 0), and behind it, (y, x) in 1/256 px."""
        (a, b), (c, d) = self.rows, self.columns
        return (min(0, a) + min(0, c), min(0, b) + min(0, d)), (max(0, a) + max(0, c), max(0, b) + max(0, d))

    def window(self, i: int, j: int, half: float) -> tuple[Pair, NDArray[np.int8], Mask]:
        """Return the first pixel of a block's window, the neighbour whose overlap each pixel is in, and the block.

        The last two as :func:`~.block_kernels.wedges` writes them; `half`: half the width of the overlap, px.
        """
        (y, x), (at, shape) = self.origin(i, j), self._box(i, j, half)
        frame = np.array((*self.rows, *self.columns, y - at[0] * UNIT, x - at[1] * UNIT), np.int64)
        sides, core = np.empty(shape, np.int8), np.empty(shape, np.bool_)
        block_kernels.wedges(frame, half, sides, core)
        return at, sides, core

    def intersecting(self, y0: int, x0: int, height: int, width: int, half: float) -> list[Pair]:
        """Return the blocks whose windows meet a box of the canvas, row by row; `half` as for :meth:`window`."""
        reach = math.ceil(half) + 1
        ends = [(y, x) for y in (y0 - reach, y0 + height + reach) for x in (x0 - reach, x0 + width + reach)]
        rows, columns = zip(*(self.block_of(y, x) for y, x in ends), strict=True)
        found = []
        for i in range(min(rows) - 1, max(rows) + 2):
            for j in range(min(columns) - 1, max(columns) + 2):
                (y, x), (tall, wide) = self._box(i, j, half)
                if y < y0 + height and x < x0 + width and y + tall > y0 and x + wide > x0:
                    found.append((i, j))
        return found

    def _box(self, i: int, j: int, half: float) -> tuple[Pair, Pair]:
        """Return the first pixel and shape of the window around a block, with its overlap."""
        (y, x), ((above, before), (below, after)) = self.origin(i, j), self.reach
        more = math.ceil(half) + 1
        at = y // UNIT + above // UNIT - more, x // UNIT + before // UNIT - more
        return at, (2 * more + 2 - (above - below) // UNIT, 2 * more + 2 - (before - after) // UNIT)


def adjacent_blocks(i: int, j: int) -> tuple[Pair, ...]:
    """Return the blocks above, below, to the left and to the right."""
    return (i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)


def block_grid(cell: Cell, target: float | None, room: tuple[int, ...]) -> BlockGrid:
    """Return a grid of blocks of whole periods, along the axes if the lattice allows it; its phase is 0.

    If there are courses only, a block spans whole pitches across them, and any length along them. `target`: wanted side
    in px (None: one period, or enough to reach 40 px); `room`: rows and columns of the exemplar, of which a block takes
    at most half. The second side is reversed if needed, so that the determinant is positive.
    """
    v1, v2 = cell
    if v2 is None:
        free = v1[1], -v1[0]
        down, across = (v1, free) if abs(v1[0]) >= abs(v1[1]) else (free, v1)
    else:
        down, across = _upright(v1, v2, room)
    sides = []
    for v, available in ((_towards(down, 0), room[0]), (_towards(across, 1), room[1])):
        length = math.hypot(*v) / UNIT
        wanted = target if target is not None else max(length, LEAST_SIDE)
        n = max(1, round(wanted / length))
        while n > 1 and n * length > available / 2:
            n -= 1
        sides.append((v[0] * n, v[1] * n))
    (a, b), (c, d) = sides
    return BlockGrid((a, b), (c, d) if a * d >= b * c else (-c, -d), (0, 0), cell)


def phase_costs(features: Int16, grid: BlockGrid, border: int, axis: int) -> Floats | None:
    """Return the cost per px of cuts at every phase of a period, 1/16 of a feature unit; None if unknown.

    `axis` 0: horizontal cuts, one phase per row of a period; 1: vertical cuts. The exemplar is compared with itself
    shifted by lattice vectors; around every row the cheapest path in a band of `border` px is found, and costs are
    averaged over rows that are whole periods apart. Infinite at phases without a row.
    """
    picture, band = features if axis == 0 else features.swapaxes(0, 1), max(border, 2)
    period = abs((grid.rows[0], grid.columns[1])[axis]) / UNIT
    if period < 2:
        return None
    total, count = np.zeros((2, math.ceil(period)), np.int64)
    for shift in _lattice_shifts(grid.cell, features.shape[:2]):
        here, there = overlap(picture.shape[:2], shift if axis == 0 else shift[::-1])
        cost = colour_distances(picture[here], picture[there])
        if cost.shape[0] >= band and cost.shape[1] >= 8:
            along = block_kernels.crossings(np.ascontiguousarray(cost.T), band)
            phases = ((here[0].start + np.arange(len(along)) + band // 2) % period).astype(np.int64)
            np.add.at(total, phases, along)
            np.add.at(count, phases, 1)
    known = count > 0
    return np.rint(np.where(known, total / np.maximum(count, 1), np.inf)) if known.any() else None


def colour_distances(a: Array, b: Array) -> Int64:
    """Return the Euclidean distances of pixels (..., C), 1/16 of a feature unit, rounded down."""
    return np.asarray(np.floor(16.0 * np.sqrt(((a.astype(np.int64) - b) ** 2).sum(axis=-1))), np.int64)


def joint_contrast(picture: Int16, cell: Cell) -> float:
    """Return the cost of cuts at the best phase, in the joints, divided by the mean cost over all phases.

    The larger one of both axes. 0: cuts in joints cost nothing; 1: the phase makes no difference, or is unknown.
    """
    grid, worst = block_grid(cell, None, picture.shape), 0.0
    for axis in (0, 1):
        costs = phase_costs(picture, grid, BORDER, axis)
        seen = np.ones(1) if costs is None else costs[np.isfinite(costs)]
        whole = float(seen.sum())
        worst = max(worst, float(seen.min()) * len(seen) / whole if whole else 0.0)
    return worst


def with_best_phase(picture: Int16, grid: BlockGrid, border: int) -> tuple[BlockGrid, tuple[float, float]]:
    """Return the grid with the phase at which cuts are cheapest, on all axes along which it has a period.

    Also return the cost per px of these cuts for each axis, 1/16 of a feature unit; 0 where it is unknown.
    """
    (down, along), second = grid.cell
    found = [(0, 0.0), (0, 0.0)]
    for axis in (0, 1) if second is not None else (int(abs(down) < abs(along)),):
        costs = phase_costs(picture, grid, border, axis)
        if costs is not None:
            at = int(np.argmin(costs))
            found[axis] = at, float(costs[at])
    (y, below), (x, aside) = found
    return replace(grid, phase=(y * UNIT, x * UNIT)), (below, aside)


def phase_of(picture: Int16, cell: Cell) -> tuple[float, float]:
    """Return the best phase of the grid of the smallest blocks, (y, x) px."""
    y, x = with_best_phase(picture, block_grid(cell, 1.0, picture.shape), BORDER)[0].phase
    return y / UNIT, x / UNIT


def block_places(grid: BlockGrid, valid: Mask, kind: Pair) -> Int64:
    """Return the positions in the exemplar where a block may be read: (n, 2) in 1/256 px, its first corner.

    `valid` (H, W): usable pixels; the whole block must lie on them. `kind`: parity of its
    row and column; for blocks of half periods the positions differ between parities.
    """
    v1, v2 = grid.vectors
    height, width = valid.shape
    low, high = np.array(grid.reach, np.int64)
    box = -low // UNIT - 1, (np.array((height, width)) * UNIT - high) // UNIT + 1
    places = lattice_points(grid.origin(*kind), v1, v2, *np.array(box).tolist())
    inside = (places + low >= -UNIT // 2).all(axis=1)
    inside &= (places + high <= np.array((height, width)) * UNIT + UNIT // 2).all(axis=1)
    places = places[inside]
    if not valid.all() and len(places):
        ok = block_kernels.all_usable(places, np.array((grid.rows, grid.columns), np.int64), valid)
        places = places[ok]
    order = np.lexsort((places[:, 1], places[:, 0]))
    return np.asarray(places[order])


def _upright(v1: Vector, v2: Vector, room: tuple[int, ...]) -> Vectors:
    """Return the shortest vectors of a lattice along both axes; the two given if there are none."""
    times = slice(-COMBINATIONS, COMBINATIONS + 1)
    sums = np.mgrid[times, times].reshape(2, -1).T @ np.array((v1, v2))
    # Then half periods, as in checkered lattices such as basket weave.
    for some in (sums.tolist(), (sums // 2).tolist()):
        down, across = _shortest_along(some, 0, room), _shortest_along(some, 1, room)
        if down is not None and across is not None and down[0] * across[1] != down[1] * across[0]:
            return down, across
    first, second = sorted((v1, v2), key=lambda v: -abs(v[0]) / (abs(v[1]) + 1))
    return first, second


def _shortest_along(sums: list[Vector], axis: int, room: tuple[int, ...]) -> Vector | None:
    """Return the shortest vector along an axis, if one is at most 0.6 of the exemplar long."""
    near = [v for v in sums if 0 < v[axis] <= room[axis] * UNIT * 0.6 and abs(v[1 - axis]) <= UPRIGHT * v[axis]]
    if not near:
        return None
    shortest = min(v[axis] for v in near)
    return min((v for v in near if v[axis] <= 1.3 * shortest), key=lambda v: (abs(v[1 - axis]), v[axis]))


def _towards(v: Vector, axis: int) -> Vector:
    return v if v[axis] > 0 or (v[axis] == 0 and v[1 - axis] > 0) else (-v[0], -v[1])


def _lattice_shifts(cell: Cell, shape: tuple[int, ...]) -> list[Vector]:
    """Return lattice vectors that leave at least half of each side in common with the exemplar, px, spread evenly."""
    v1, v2 = cell
    if v2 is None:
        length = math.hypot(*v1)
        v2 = (round(v1[1] / length * UNIT * 7), round(-v1[0] / length * UNIT * 7))
    times = np.mgrid[-8:9, :9].reshape(2, -1).T
    moves = np.rint(times[(times > 0).any(axis=1)] @ np.array((v1, v2)) / UNIT).astype(np.int64)
    moves = moves[(np.abs(moves) <= np.array(shape[:2]) // 2).all(axis=1) & moves.any(axis=1)]
    found = sorted(moves.tolist(), key=lambda s: (abs(s[0]) + abs(s[1]), s))
    return found[:: max(1, len(found) // PAIRS)][:PAIRS]
