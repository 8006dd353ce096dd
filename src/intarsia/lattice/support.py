"""Whether all of a texture repeats, or only a few things in it that happen to be alike.

Three equal coins on a cloth agree with each other exactly as well as the cells of a lattice do, and three
points always span one. But a lattice repeats everywhere: in nearly every part of the exemplar.

Source: no paper; our own test.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .correlation_map import Pictures

PARTS = 5  # along each side of the overlap
LEAST_PART = 6  # px: smaller parts say nothing
ALIKE = 0.2  # correlation of a part that repeats


def support(prepared: Pictures, vector: tuple[int, int]) -> float:
    """Return the share of parts of the overlap that repeat when moved by a vector (1/256 px)."""
    dy, dx = ((v + 128) // 256 for v in vector)
    height, width = prepared.colours.shape[:2]
    rows, columns = height - abs(dy), width - abs(dx)
    parts = min(PARTS, rows // LEAST_PART, columns // LEAST_PART)
    if parts < 1:
        return 0.0
    one = np.s_[max(dy, 0) : max(dy, 0) + rows, max(dx, 0) : max(dx, 0) + columns]
    other = np.s_[max(-dy, 0) : max(-dy, 0) + rows, max(-dx, 0) : max(-dx, 0) + columns]
    alike, seen = 0, 0
    for y in range(parts):
        for x in range(parts):
            box = np.s_[y * rows // parts : (y + 1) * rows // parts, x * columns // parts : (x + 1) * columns // parts]
            known = None if prepared.usable is None else prepared.usable[one][box] & prepared.usable[other][box]
            if known is not None and 2 * known.sum() < known.size:
                continue
            seen += 1
            alike += any(
                _correlation(picture[one][box], picture[other][box], known) >= ALIKE
                for picture in (prepared.colours, prepared.edges)
            )
    return alike / seen if seen else 0.0


def _correlation(f: NDArray[np.float64], g: NDArray[np.float64], known: NDArray[np.bool_] | None) -> float:
    """Correlation of equal px; channels count by their contrast."""
    if known is not None:
        f, g = f[known][:, None], g[known][:, None]
    f, g = f - f.mean(axis=(0, 1)), g - g.mean(axis=(0, 1))
    below = float(np.sqrt((f * f).sum(axis=(0, 1)) * (g * g).sum(axis=(0, 1))).sum())
    return float((f * g).sum()) / below if below > 0 else 0.0
