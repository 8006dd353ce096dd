"""Large pieces spread out: of several places drawn for each, the one that repeats its neighbours least."""

from __future__ import annotations

from typing import Any

from ..kernels.jit import kernel

SEEN = 2  # pieces looked at on each side
TURNS = 4  # pieces of even and odd rows and columns, one kind after the other
SHARE, FAR = 1024, 16  # what overlaps and distances of a whole piece count


@kernel
def shown_again(ay: Any, ax: Any, by: Any, bx: Any, di: int, dj: int, h: Any, size: Any) -> Any:
    """Return how much of the exemplar a piece at (ay, ax) shows that another shows, too, and how near by.

    The other one, at (by, bx) of the exemplar, lies `di`, `dj` pieces of h x h px from it in the output. Both run
    across the exemplar's border to its other side, so that two stretches may overlap along either axis.
    """
    high, wide = (by - ay) % size[0], (bx - ax) % size[1]
    total = 0 * h
    for _ in range(2):
        across = wide
        for _ in range(2):
            oy, ox = h - abs(high), h - abs(across)
            if oy > 0 and ox > 0:
                sy, sx = (di * h - high) * FAR // h, (dj * h - across) * FAR // h
                total += ((oy * SHARE // h) * (ox * SHARE // h) << 16) // (sy * sy + sx * sx + 1)
            across -= size[1]
        high -= size[0]
    return total


@kernel
def scatter(choices: Any, rows: Any, cols: Any, h: Any, size: Any, out: Any) -> None:
    """Choose for each pixel of a level (rows, columns), absolute coordinates, one of its places (K, H, W, 2).

    The turns go by even and odd coordinates; a pixel looks at those of earlier turns only, so what is chosen depends on
    SEEN (TURNS - 1) px around. Of equal places the first is taken. ``out`` (H, W, 2): exemplar pixels (y, x).
    """
    height, width = out.shape[:2]
    for turn in range(TURNS):
        for i in range(height):
            for j in range(width):
                if 2 * (rows[i] & 1) + (cols[j] & 1) != turn:
                    continue
                best, kept = 0 * h, -1
                for k in range(choices.shape[0]):
                    y, x = choices[k, i, j, 0], choices[k, i, j, 1]
                    total = 0 * h
                    for di in range(-min(SEEN, i), min(SEEN, height - 1 - i) + 1):
                        for dj in range(-min(SEEN, j), min(SEEN, width - 1 - j) + 1):
                            if 2 * (rows[i + di] & 1) + (cols[j + dj] & 1) < turn:
                                oy, ox = out[i + di, j + dj, 0], out[i + di, j + dj, 1]
                                total += shown_again(y, x, oy, ox, di, dj, h, size)
                    if kept < 0 or total < best:
                        best, kept = total, k
                out[i, j, 0], out[i, j, 1] = choices[kept, i, j, 0], choices[kept, i, j, 1]
