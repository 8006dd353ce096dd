"""The cut of Efros and Freeman as Robinson's program of 2004 computes it: two one-way paths that meet in the corner.

Not the cheapest cut: each path only runs on, and sees single pixels (docs/design/004-cuts.md).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array

FAR = np.int64(1) << 60


def cut(norms: NDArray[np.int64], overlap: tuple[int, int], text: bool = False) -> NDArray[np.bool_]:
    """Return which pixels of a patch (h, w) are new, by the norms of what differs from what is there.

    `overlap`: rows above and columns to the left that are known, 0: none. `text`: turn where the sum of both paths less
    the pixel that both count is least, not the sum alone.
    """
    rows, columns = (min(o, n) for o, n in zip(overlap, norms.shape, strict=True))
    new = np.ones(norms.shape, bool)
    down = accumulated(norms[:, :columns]) if columns else None
    along = accumulated(norms[:rows].T).T if rows else None
    turn = 0, 0
    if down is not None and along is not None:
        corner = down[:rows] + along[:, :columns] - (norms[:rows, :columns] if text else 0)
        turn = divmod(int(corner.argmin()), columns)
        new[: turn[0] + 1, : turn[1] + 1] = False
    elif down is not None:
        turn = 0, int(down[0].argmin())
    elif along is not None:
        turn = int(along[:, 0].argmin()), 0
    if down is not None:
        for i, j in enumerate(traced(down, *turn)):
            new[turn[0] + i, : j + 1] = False
    if along is not None:
        for j, i in enumerate(traced(along.T, turn[1], turn[0])):
            new[: i + 1, turn[1] + j] = False
    return new


def accumulated(error: Array) -> NDArray[np.int64]:
    """Add up a strip from its last row on: each pixel and the least of its three predecessors."""
    total = np.array(error, np.int64)
    for i in range(len(total) - 2, -1, -1):
        before = np.pad(total[i + 1], 1, constant_values=FAR)
        total[i] += np.minimum(np.minimum(before[:-2], before[1:-1]), before[2:])
    return total


def traced(total: Array, row: int, column: int) -> list[int]:
    """Follow the sums of a strip to its last row: the column in each row; of equal ones straight on, then the left."""
    columns = [column]
    for i in range(row + 1, len(total)):
        ways = [(int(total[i, j]), k, j) for k, j in enumerate((column, column - 1, column + 1))
                if 0 <= j < total.shape[1]]  # fmt: skip
        column = min(ways)[2]
        columns.append(column)
    return columns
