"""Which patches may be laid at a place so that nothing returns too near, asked of every patch and every other one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from intarsia.patches.repetition import Repetition
from intarsia.patches.repetition_kernels import placement, returns_too_near


def permitted(control: Repetition, row: int, column: int, others: NDArray) -> list[NDArray[np.bool_]]:
    """Of every variant, where a patch may begin beside the placements `others`."""
    (h, w), at, out = control.layout.patch, control.layout.at(row, column), []
    laid = control._laid
    for v, valid in enumerate(control.search.variants.valid):
        table = valid.copy()
        for u, s in np.argwhere(valid).tolist():
            mine = np.empty(8, np.int64)
            placement(laid.frames, laid.shape, v, u, s, *at, mine)
            table[u, s] = not any(
                returns_too_near(mine, other, h, w, laid.canvas, laid.frames[v, 7:9], control.distance)
                for other in others
            )
        out.append(table)
    return out
