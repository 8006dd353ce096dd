"""Kernels of raster-scan synthesis on a torus: causal neighbourhoods, their full search, tree search, coherence.

At the beginning every pixel of the torus has a value, mostly noise; the first pixels see it where their
neighbourhoods reach across the border. Pixels below and to the right count only if they are known for good: those
of a start, and the first rows and columns, seen by the last ones across a border that wraps.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...foundation.arrays import Int16, Int32, Int64, Mask, UInt8
from ...kernels.jit import kernel
from ...kernels.kd_tree import FAR, ask, asking_room
from ...kernels.random_numbers import below, draw
from .neighbourhood_kernels import (
    CLOSED,
    NONE,
    SIZE,
    START,
    STRIDE,
    better_of,
    empty_template,
    find_nearest,
    known_value,
    position_of,
    search_buffers,
    set_offsets,
    template_distance,
    write_pixel,
)


@kernel
def project(ground: Any, places: Any, components: Any, mean: Any, axes: Any, out: Any) -> None:
    """Project the neighbourhoods at (variant, position) `places` (N, 2) to points `out` (N, D).

    `components` (n, 3) are plane, row and column of each value; see :func:`project_vector`.
    """
    values = np.empty(len(components), np.int32)
    for i in range(len(places)):
        row = ground.table[places[i, 0]]
        for m in range(len(components)):
            step = components[m, 0] * row[SIZE] + components[m, 1] * row[STRIDE] + components[m, 2]
            values[m] = ground.values[row[START] + places[i, 1] + step]
        project_vector(values, mean, axes, out[i])


@kernel
def project_vector(values: Any, mean: Any, axes: Any, out: Any) -> None:
    """Project a vector (n,) to a point (D,): the rounded sums of (value - mean) * axis / 16384."""
    for d in range(len(axes)):
        total = np.int64(8192)
        for m in range(len(mean)):
            total += (values[m] - mean[m]) * axes[d, m]
        out[d] = total >> 14


ABOVE, BELOW, COARSE = 0, 1, 2  # kinds of taps: always counted; counted where known for good; of the coarser level
FIRST = 12  # components by which a full search rules most candidates out, or SHARE / 16 of them
SHARE = 10
BRANCHES = 4  # neighbours whose continuations make the first bound


class Torus(NamedTuple):
    """The torus that is filled, and the shape of its neighbourhoods."""

    variant: UInt8  # (H, W)
    yx: Int32  # (H, W, 2)
    done: Mask  # (H, W): known for good
    coarse: Int16  # (P, H, W): what the coarser level shows here
    taps: Int64  # (n, 3): row, column, kind; the nearest first
    channels: int  # planes of this level; those of the coarser one follow
    whole: bool  # whether neighbourhoods all around count, and find room in the exemplar
    wraps: tuple[bool, bool]  # whether the canvas, too, continues in itself, down and along
    choices: Int64  # (m, 2): every (variant, position) that a neighbourhood of kind 0 fits
    seed: np.uint64
    stage: int
    level: int


@kernel
def template_of(torus: Any, ground: Any, y: int, x: int, template: Any) -> Any:
    """Read the neighbourhood of (y, x); return its number of components, its kind, and if it is the usual one."""
    height, width = torus.variant.shape
    n, kind, usual = 0, 0, True
    for t in range(len(torus.taps)):
        dy, dx, sort = torus.taps[t, 0], torus.taps[t, 1], torus.taps[t, 2]
        a, b = (y + dy) % height, (x + dx) % width
        if sort != COARSE and a == y and b == x:  # a tiny torus comes round to the pixel itself
            usual = usual and sort == BELOW
            continue
        if sort == BELOW:
            beyond = (y + dy >= height and not torus.wraps[0]) or (not 0 <= x + dx < width and not torus.wraps[1])
            if not torus.whole or not torus.done[a, b] or beyond:
                continue
            kind, usual = 1, False
        first, planes = (torus.channels, len(torus.coarse)) if sort == COARSE else (0, torus.channels)
        for c in range(planes):
            template.plane[n], template.dy[n], template.dx[n], template.tap[n] = first + c, dy, dx, t
            if sort == COARSE:
                template.value[n] = torus.coarse[c, a, b]
            else:
                template.value[n] = known_value(ground, torus.variant[a, b], torus.yx, a, b, c)
            template.weight[n] = 1
            n += 1
    return n, kind, usual


@kernel
def continuation(torus: Any, ground: Any, y: int, x: int, t: int, kind: int) -> Any:
    """Return (variant, position) that continues tap `t` at (y, x) as in the exemplar; -1 where the exemplar ends."""
    a = (y + torus.taps[t, 0]) % torus.variant.shape[0]
    b = (x + torus.taps[t, 1]) % torus.variant.shape[1]
    v, i, j = torus.variant[a, b], torus.yx[a, b, 0] - torus.taps[t, 0], torus.yx[a, b, 1] - torus.taps[t, 1]
    return np.int64(v), np.int64(position_of(ground, v, i, j, kind))


@kernel
def best_continuation(torus: Any, ground: Any, y: int, x: int, kind: int, template: Any, n: int) -> Any:
    """Return (distance, variant, position) of the best exemplar pixel that continues a nearest neighbour."""
    best, left = NONE, BRANCHES
    for t in range(len(torus.taps)):
        if torus.taps[t, 2] != ABOVE:
            continue
        v, at = continuation(torus, ground, y, x, t, kind)
        if at >= 0:
            best = better_of(ground, v, at, template, n, best)
        left -= 1
        if left == 0:
            break
    return best


@kernel
def drawn(torus: Any, level: int, y: int, x: int) -> Any:
    """Return (variant, position) drawn among the choices for (y, x), with the random numbers of a level."""
    k = below(len(torus.choices), draw(torus.seed, torus.stage, level, y, x))
    return torus.choices[k, 0], torus.choices[k, 1]


@kernel
def fill_full(torus: Any, ground: Any, pixels: Any, components: int) -> None:
    """Fill pixels (n, 2), in turn, with the exemplar pixels whose neighbourhoods are most similar of all."""
    template, work = empty_template(components), search_buffers(ground)
    for k in range(len(pixels)):
        n, kind, _ = template_of(torus, ground, pixels[k, 0], pixels[k, 1], template)
        full_pixel(torus, ground, pixels[k, 0], pixels[k, 1], n, kind, template, work)


@kernel
def full_pixel(torus: Any, ground: Any, y: int, x: int, n: int, kind: int, template: Any, work: Any) -> None:
    """Fill a pixel by comparing its neighbourhood with all others; of equal ones the first is taken."""
    torus.done[y, x] = True
    if n == 0:
        v, at = drawn(torus, torus.level, y, x)
        write_pixel(ground, torus.variant, torus.yx, y, x, v, at)
        return
    best = best_continuation(torus, ground, y, x, kind, template, n)[0]
    find_nearest(ground, template, n, kind, best, 0, max(FIRST, n * SHARE // 16), work)
    write_pixel(ground, torus.variant, torus.yx, y, x, work.variant[0], work.position[0])


@kernel
def fill_by_tree(torus: Any, ground: Any, tree: Any, leaves: int, few: int, pixels: Any, components: int) -> None:
    """Fill pixels (n, 2), in turn, with the best of a few found by a tree and of the continuations.

    Neighbourhoods that are not the usual ones are searched in full.
    """
    template, work = empty_template(components), search_buffers(ground)
    point, room = np.empty(tree.points.shape[1], np.int64), asking_room(tree.points.shape[1])
    near, number = np.empty(few, np.int64), np.empty(few, np.int64)
    for i in range(len(pixels)):
        y, x = pixels[i, 0], pixels[i, 1]
        n, kind, usual = template_of(torus, ground, y, x, template)
        if not usual or n == 0:
            full_pixel(torus, ground, y, x, n, kind, template, work)
            continue
        torus.done[y, x] = True
        best = best_continuation(torus, ground, y, x, kind, template, n)
        project_vector(template.value, tree.mean, tree.axes, point)
        for k in range(ask(tree, point, leaves, near, number, room)):
            best = better_of(ground, torus.choices[number[k], 0], torus.choices[number[k], 1], template, n, best)
        write_pixel(ground, torus.variant, torus.yx, y, x, best[1], best[2])


@kernel
def fill_coherent(torus: Any, ground: Any, pixels: Any, components: int) -> None:
    """Fill pixels (n, 2), in turn, with the best of those that continue their neighbours in the exemplar.

    Where the exemplar ends, a drawn one is tried. Of equal candidates the first stays.
    """
    template, tried = empty_template(components), np.empty((len(torus.taps), 2), np.int64)
    for y, x in pixels:
        n, kind, _ = template_of(torus, ground, y, x, template)
        best, variant, position, count = FAR, np.int64(-1), np.int64(-1), 0
        for m in range(0, n, torus.channels):  # there is but one level
            t = template.tap[m]
            v, at = continuation(torus, ground, y, x, t, kind)
            if at < 0:
                v, at = drawn(torus, 8 + t, y, x)
                if ground.closed[kind, ground.table[v, CLOSED] + at] != 0:
                    continue
            known = False
            for k in range(count):
                known = known or (tried[k, 0] == v and tried[k, 1] == at)
            if known:
                continue
            tried[count, 0], tried[count, 1] = v, at
            count += 1
            set_offsets(ground, v, template, n)
            d = template_distance(ground, v, at, template, n, best)
            if d < best:
                best, variant, position = d, v, at
        if variant < 0:
            variant, position = drawn(torus, torus.level, y, x)
        write_pixel(ground, torus.variant, torus.yx, y, x, variant, position)
        torus.done[y, x] = True


@kernel
def start_from_noise(variant: Any, yx: Any, ground: Any, choices: Any, seed: Any, stage: int, level: int) -> None:
    """Fill every pixel with an exemplar pixel drawn uniformly among the choices (m, 2)."""
    for y in range(variant.shape[0]):
        for x in range(variant.shape[1]):
            k = below(len(choices), draw(seed, stage, 64 + level, y, x))
            write_pixel(ground, variant, yx, y, x, choices[k, 0], choices[k, 1])
