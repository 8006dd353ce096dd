"""Growing outward pixel by pixel: which pixels come next, which of them do not touch, and how they are filled."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kernels.draws import below, draw
from ...kernels.jit import kernel
from ...kernels.kd_tree import FAR
from ...kernels.windows import HOLE, canvas_place
from .neighbourhood_kernels import (
    aim,
    find_nearest,
    known_value,
    position_of,
    room_for,
    show,
    template_distance,
    workplace,
)


@kernel
def layer(variant: Any, window: Any, wrap_y: bool, wrap_x: bool, seed: Any, stage: int) -> Any:
    """List the unknown pixels that touch known ones: (n, 2), those with the most known pixels around first.

    Equal ones follow in the order of their draws.
    """
    height, width = variant.shape
    up, side = window[0] // 2, window[1] // 2
    count = 0
    found = np.empty((height * width, 2), np.int64)
    for y in range(height):
        for x in range(width):
            if variant[y, x] == HOLE and _known(variant, y, x, 1, 1, wrap_y, wrap_x) > 0:
                found[count, 0], found[count, 1] = y, x
                count += 1
    known, bits = np.empty(count, np.int64), np.empty(count, np.uint64)
    for k in range(count):
        known[k] = -_known(variant, found[k, 0], found[k, 1], up, side, wrap_y, wrap_x)
        bits[k] = draw(seed, stage, 1, found[k, 0], found[k, 1])
    order = np.argsort(bits, kind="mergesort")
    order = order[np.argsort(known[order], kind="mergesort")]
    return found[:count][order]


@kernel
def _known(variant: Any, y: int, x: int, up: int, side: int, wrap_y: bool, wrap_x: bool) -> int:
    """Count the known taps of a window of (2 up + 1) x (2 side + 1) px."""
    count = 0
    for dy in range(-up, up + 1):
        a = canvas_place(y + dy, variant.shape[0], wrap_y)
        if a < 0:
            continue
        for dx in range(-side, side + 1):
            b = canvas_place(x + dx, variant.shape[1], wrap_x)
            if b >= 0 and variant[a, b] != HOLE:
                count += 1
    return count


@kernel
def ranks(pixels: Any, shape: Any, window: Any, wrap_y: bool, wrap_x: bool) -> Any:
    """Number pixels (n, 2) so that one in the window of an earlier one has a higher rank: equal ranks do not touch."""
    rank = np.full((shape[0], shape[1]), -1, np.int64)
    out = np.empty(len(pixels), np.int64)
    for k in range(len(pixels)):
        most = -1
        for dy in range(-(window[0] // 2), window[0] // 2 + 1):
            a = canvas_place(pixels[k, 0] + dy, shape[0], wrap_y)
            if a < 0:
                continue
            for dx in range(-(window[1] // 2), window[1] // 2 + 1):
                b = canvas_place(pixels[k, 1] + dx, shape[1], wrap_x)
                if b >= 0:
                    most = max(most, rank[a, b])
        rank[pixels[k, 0], pixels[k, 1]] = out[k] = most + 1
    return out


@kernel
def fill(
    variant: Any, yx: Any, pixels: Any, taps: Any, channels: int, ground: Any, wrap_y: bool, wrap_x: bool,
    share: int, first: int, seed: Any, stage: int,
) -> None:  # fmt: skip
    """Fill pixels (n, 2) one after the other, each drawn from the exemplar pixels with the most similar windows.

    `taps` (m, 3): row, column, weight, the heaviest first; `first` components rule candidates out (see `nearest`).
    """
    height, width = variant.shape
    template = room_for(len(taps) * channels)
    work = workplace(ground)
    for k in range(len(pixels)):
        y, x = pixels[k, 0], pixels[k, 1]
        n = 0
        for t in range(len(taps)):
            a, b = canvas_place(y + taps[t, 0], height, wrap_y), canvas_place(x + taps[t, 1], width, wrap_x)
            if a < 0 or b < 0 or variant[a, b] == HOLE:
                continue
            for c in range(channels):
                template.plane[n], template.dy[n], template.dx[n] = c, taps[t, 0], taps[t, 1]
                template.value[n] = known_value(ground, variant[a, b], yx, a, b, c)
                template.weight[n] = taps[t, 2]
                n += 1
        best = _continued(variant, yx, y, x, ground, template, n, wrap_y, wrap_x)
        count = find_nearest(ground, template, n, 1, best, share, first, work)
        pick = below(count, draw(seed, stage, 0, y, x))
        show(ground, variant, yx, y, x, work.variant[pick], work.position[pick])


@kernel
def _continued(
    variant: Any, yx: Any, y: int, x: int, ground: Any, template: Any, n: int, wrap_y: bool, wrap_x: bool
) -> Any:
    """Return the least distance of the exemplar pixels that continue the neighbours of (y, x)."""
    best = FAR
    for k in range(9):
        dy, dx = k // 3 - 1, k % 3 - 1
        a, b = canvas_place(y + dy, variant.shape[0], wrap_y), canvas_place(x + dx, variant.shape[1], wrap_x)
        if a < 0 or b < 0 or variant[a, b] == HOLE:
            continue
        v = variant[a, b]
        position = position_of(ground, v, yx[a, b, 0] - dy, yx[a, b, 1] - dx, 1)
        if position >= 0:
            aim(ground, v, template, n)
            best = min(best, template_distance(ground, v, position, template, n, best))
    return best
