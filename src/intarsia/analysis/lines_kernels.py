"""The line that runs across a picture where outlines are surest."""

from __future__ import annotations

from typing import Any

from ..kernels.jit import kernel


@kernel
def surest_line(sure: Any, bend: int, line: Any) -> int:
    """Write into `line` (W,) the rows of the path from left to right that adds up most of `sure` (H, W) int64.

    From column to column it keeps its row, or costs `bend` to go one up or down. Of equal paths it is the one that
    ends uppermost, and keeps its row longest before its end. Returns what it adds up to, less what bends cost.
    """
    h, w = sure.shape
    best, way = sure[:, 0].copy(), sure.copy()
    for x in range(1, w):
        before = best.copy()
        for y in range(h):
            step, most = 0, before[y]
            if y > 0 and before[y - 1] - bend > most:
                step, most = -1, before[y - 1] - bend
            if y < h - 1 and before[y + 1] - bend > most:
                step, most = 1, before[y + 1] - bend
            way[y, x] = step
            best[y] = most + sure[y, x]
    at = int(best.argmax())
    total = int(best[at])
    for x in range(w - 1, -1, -1):
        line[x] = at
        if x > 0:
            at += way[at, x]
    return total
