"""Kernels of Efros-Leung synthesis: which pixels can be filled in parallel, and how one is filled."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kernels.jit import kernel
from ...kernels.maps import HOLE, canvas_place
from ...kernels.random_numbers import below, draw
from .neighbourhood_kernels import (
    NONE,
    better_of,
    empty_template,
    find_nearest,
    known_value,
    position_of,
    search_buffers,
    write_pixel,
)


@kernel
def ranks(pixels: Any, grown: Any, window: Any) -> Any:
    """Rank pixels (n, 2): one in the window of an earlier one has a higher one; equal ranks are independent."""
    (height, width), wrap = grown.variant.shape, grown.wrap
    rank = np.full((height, width), -1, np.int64)
    out = np.empty(len(pixels), np.int64)
    for k in range(len(pixels)):
        most = -1
        for dy in range(-(window[0] // 2), window[0] // 2 + 1):
            a = canvas_place(pixels[k, 0] + dy, height, wrap[0])
            if a < 0:
                continue
            for dx in range(-(window[1] // 2), window[1] // 2 + 1):
                b = canvas_place(pixels[k, 1] + dx, width, wrap[1])
                if b >= 0:
                    most = max(most, rank[a, b])
        rank[pixels[k, 0], pixels[k, 1]] = out[k] = most + 1
    return out


@kernel
def fill(
    grown: Any, pixels: Any, taps: Any, channels: int, ground: Any, share: int, first: int, seed: Any, stage: int
) -> None:  # fmt: skip
    """Fill pixels (n, 2) one after the other, each drawn from the exemplar pixels with the most similar windows.

    `taps` (m, 3): row, column, weight, the heaviest first; `first` components rule candidates out (see `nearest`).
    """
    variant, yx, wrap = grown
    height, width = variant.shape
    template = empty_template(len(taps) * channels)
    work = search_buffers(ground)
    for k in range(len(pixels)):
        y, x = pixels[k, 0], pixels[k, 1]
        n = 0
        for t in range(len(taps)):
            a, b = canvas_place(y + taps[t, 0], height, wrap[0]), canvas_place(x + taps[t, 1], width, wrap[1])
            if a < 0 or b < 0 or variant[a, b] == HOLE:
                continue
            for c in range(channels):
                template.plane[n], template.dy[n], template.dx[n] = c, taps[t, 0], taps[t, 1]
                template.value[n] = known_value(ground, variant[a, b], yx, a, b, c)
                template.weight[n] = taps[t, 2]
                n += 1
        best = _continued(grown, y, x, ground, template, n)
        count = find_nearest(ground, template, n, 1, best, share, first, work)
        pick = below(count, draw(seed, stage, 0, y, x))
        write_pixel(ground, variant, yx, y, x, work.variant[pick], work.position[pick])


@kernel
def _continued(grown: Any, y: int, x: int, ground: Any, template: Any, n: int) -> Any:
    """Return the least distance of the exemplar pixels that continue the neighbours of (y, x)."""
    variant, yx, wrap = grown
    best = NONE
    for k in range(9):
        dy, dx = k // 3 - 1, k % 3 - 1
        a, b = canvas_place(y + dy, variant.shape[0], wrap[0]), canvas_place(x + dx, variant.shape[1], wrap[1])
        if a < 0 or b < 0 or variant[a, b] == HOLE:
            continue
        v = variant[a, b]
        position = position_of(ground, v, yx[a, b, 0] - dy, yx[a, b, 1] - dx, 1)
        if position >= 0:
            best = better_of(ground, v, position, template, n, best)
    return best[0]
