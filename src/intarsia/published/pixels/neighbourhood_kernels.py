"""Kernels of pixel neighbourhoods: distances, and the search for the exemplar pixels with the most similar ones.

The exemplars lie as planes, one channel after the other, so that one tap of a neighbourhood can be compared at many
exemplar pixels at once. A pixel of a plane is named by its *position*, row * stride + column. A toroidal exemplar
is followed by its own beginning, so that every neighbourhood can be read straight.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...foundation.arrays import Float32, Floats, Int16, Int32, Int64
from ...kernels.jit import kernel
from ...kernels.kd_tree import FAR

CHUNK = 2048  # positions compared together: sums, and the rows they come from, stay in the nearest cache
GROUP = 4  # components added in one go
DENSE = 10  # where more than this part of a chunk is left, all of it is compared exactly
SLACK = 1.0001  # more than single precision loses in a sum of some hundred squares
LEFT_OUT = np.float32(np.inf)
NONE = FAR, np.int64(-1), np.int64(-1)  # distance, variant and position of no exemplar pixel
START, HEIGHT, WIDTH, STRIDE, SIZE, CLOSED, TOP, LEFT, TORUS, LOW, HIGH = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 11


class ExemplarPlanes(NamedTuple):
    """The exemplars in every pose, from which pixels are taken.

    There are two kinds of neighbourhood: 0 reaches up and to the sides, 1 all around.
    """

    values: Int16  # (N,): all planes of the first variant, then of the second, ...
    soft: Float32  # (N,): the same, for sums in vector registers
    table: Int64  # (V, 13): see the names above; LOW and HIGH once for each kind
    closed: Float32  # (2, positions): 0 where a neighbourhood of that kind may lie, else infinity


class Template(NamedTuple):
    """A neighbourhood to search for: components, each one channel of one tap."""

    plane: Int64
    dy: Int64
    dx: Int64
    value: Int32
    weight: Int32
    tap: Int64  # of a raster scan
    offset: Int64  # of the component's value from the pixel's position, in the variant at hand


class SearchBuffers(NamedTuple):
    """Buffers that a search writes to."""

    sums: Float32
    exact: Floats
    distance: Int64
    variant: Int64
    position: Int64


@kernel
def empty_template(components: int) -> Any:
    """Return an empty template for at most so many components."""
    components += GROUP
    wide, narrow = np.empty((5, components), np.int64), np.empty((2, components), np.int32)
    return Template(wide[0], wide[1], wide[2], narrow[0], narrow[1], wide[3], wide[4])


@kernel
def search_buffers(ground: Any) -> Any:
    """Return buffers for all candidates that a search may find."""
    found = np.empty((3, ground.closed.shape[1]), np.int64)
    return SearchBuffers(np.empty(CHUNK, np.float32), np.empty(CHUNK, np.float64), found[0], found[1], found[2])


@kernel
def position_of(ground: Any, v: int, y: int, x: int, kind: int) -> int:
    """Return the position of pixel (y, x) of variant `v`, or -1 where no neighbourhood of that kind may lie."""
    row = ground.table[v]
    if row[TORUS]:
        y, x = y % row[HEIGHT], x % row[WIDTH]
        y += row[HEIGHT] if y < row[TOP] else 0
        x += row[WIDTH] if x < row[LEFT] else 0
    elif y < 0 or x < 0 or y >= row[HEIGHT] or x >= row[WIDTH]:
        return -1
    position = y * row[STRIDE] + x
    return position if ground.closed[kind, row[CLOSED] + position] == 0 else -1


@kernel
def set_offsets(ground: Any, v: Any, template: Any, n: int) -> None:
    """Compute the offsets of a template's components from a position of variant `v`."""
    size, stride = ground.table[v, SIZE], ground.table[v, STRIDE]
    for m in range(n):
        template.offset[m] = template.plane[m] * size + template.dy[m] * stride + template.dx[m]


@kernel
def template_distance(ground: Any, v: Any, position: Any, template: Any, n: int, limit: Any) -> Any:
    """Sum weight * difference**2 over a template aimed at variant `v`; stop once above `limit`."""
    at = ground.table[v, START] + position
    total = np.int64(0)
    for m in range(n):
        d = np.int64(ground.values[at + template.offset[m]]) - template.value[m]
        total += d * d * template.weight[m]
        if total > limit:
            break
    return total


@kernel
def better_of(ground: Any, v: Any, position: Any, template: Any, n: int, best: Any) -> Any:
    """Return the better of `best` (distance, variant, position) and a position; of equals the first in order."""
    set_offsets(ground, v, template, n)
    d = template_distance(ground, v, position, template, n, best[0])
    if d < best[0] or (d == best[0] and (v < best[1] or (v == best[1] and position < best[2]))):
        return d, np.int64(v), np.int64(position)
    return best


@kernel
def add_distances(soft: Any, start: int, template: Any, n: int, sums: Any) -> None:
    """Add the first `n` components at len(sums) positions from `start` on, four at a time; `n` is such a multiple.

    Plainly: sums += sum of weight * (exemplar - value)**2, in the precision of `sums`; in doubles these are whole
    numbers below 2**53, so exact.
    """
    size, number = len(sums), sums.dtype.type
    for m in range(0, n, GROUP):
        a, b = start + template.offset[m], start + template.offset[m + 1]
        c, d = start + template.offset[m + 2], start + template.offset[m + 3]
        ra, rb, rc, rd = soft[a : a + size], soft[b : b + size], soft[c : c + size], soft[d : d + size]
        ta, tb = np.float32(template.value[m]), np.float32(template.value[m + 1])
        tc, td = np.float32(template.value[m + 2]), np.float32(template.value[m + 3])
        wa, wb = number(template.weight[m]), number(template.weight[m + 1])
        wc, wd = number(template.weight[m + 2]), number(template.weight[m + 3])
        for i in range(size):
            ea, eb, ec, ed = ra[i] - ta, rb[i] - tb, rc[i] - tc, rd[i] - td  # squares below 2**24 are exact
            sums[i] += (wa * (ea * ea) + wb * (eb * eb)) + (wc * (ec * ec) + wd * (ed * ed))


@kernel
def widened(best: Any, share: int) -> Any:
    """Return best * (1 + share / 65536), rounded down."""
    if best >= np.int64(1) << 54:
        return FAR
    return best + (best >> 16) * share + (((best & 65535) * share) >> 16)


@kernel
def find_nearest(ground: Any, template: Any, n: int, kind: int, best: Any, share: int, first: int, work: Any) -> int:
    """Find all positions that are at most share / 65536 further from a template than the nearest; return how many.

    They are written into `work`, in the order of variants and positions. `best` is a distance known to exist, or
    FAR. The first `first` components are compared everywhere, in single precision, to leave out what is too far
    already; all others exactly, and only these decide.
    """
    first = min(first, n) // GROUP * GROUP
    limit = widened(best, share)
    count = 0
    for m in range(n, n + GROUP):  # fill the last group up with what does not count
        template.plane[m], template.dy[m], template.dx[m], template.value[m], template.weight[m] = 0, 0, 0, 0, 0
    for v in range(len(ground.table)):
        row = ground.table[v]
        set_offsets(ground, v, template, n + GROUP)
        for begin in range(row[LOW + kind], row[HIGH + kind], CHUNK):
            size = min(CHUNK, row[HIGH + kind] - begin)
            sums, exact = work.sums[:size], work.exact[:size]
            at = row[CLOSED] + begin
            sums[:] = ground.closed[kind, at : at + size]
            add_distances(ground.soft, row[START] + begin, template, first, sums)
            bound = np.float32(np.float64(limit) * SLACK + 1.0)
            near = 0
            for i in range(size):
                near += sums[i] <= bound
            dense = near * DENSE > size
            if dense:
                exact[:] = 0
                add_distances(ground.soft, row[START] + begin, template, -(-n // GROUP) * GROUP, exact)
            for i in range(size if near else 0):
                if sums[i] <= bound:
                    d = np.int64(exact[i]) if dense else template_distance(ground, v, begin + i, template, n, limit)
                    if d <= limit:
                        work.distance[count], work.variant[count], work.position[count] = d, v, begin + i
                        count += 1
                        if d < best:
                            best = d
                            limit = widened(best, share)
                            bound = np.float32(np.float64(limit) * SLACK + 1.0)
    kept = 0
    for k in range(count):
        if work.distance[k] <= limit:
            work.distance[kept], work.variant[kept] = work.distance[k], work.variant[k]
            work.position[kept] = work.position[k]
            kept += 1
    return kept


@kernel
def known_value(ground: Any, v: int, yx: Any, y: int, x: int, plane: int) -> Any:
    """Return the value in a plane of the exemplar pixel that a map shows at (y, x)."""
    row = ground.table[v]
    return ground.values[row[START] + plane * row[SIZE] + yx[y, x, 0] * row[STRIDE] + yx[y, x, 1]]


@kernel
def write_pixel(ground: Any, variant: Any, yx: Any, y: int, x: int, v: Any, position: Any) -> None:
    """Write into a map that (y, x) is copied from the exemplar pixel at a position."""
    row = ground.table[v]
    variant[y, x] = v
    yx[y, x, 0] = position // row[STRIDE] % row[HEIGHT]
    yx[y, x, 1] = position % row[STRIDE] % row[WIDTH]
