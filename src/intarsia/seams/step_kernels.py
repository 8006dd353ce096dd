"""Where patches lie that are whole steps of a lattice from another."""

from __future__ import annotations

from typing import Any

from ..kernels.jit import kernel


@kernel
def mark_steps(steps: Any, ends: Any, shown: Any, torus: bool, fine: Any, valid: Any, there: Any) -> None:
    """Mark in `there` all places whole steps from the one `shown`, and around them, where a patch may lie.

    `steps` (2, 2): of so many parts of a px as the first of `fine` says; the second: how far around, px. `ends` (2, 2):
    the first number of each step that is tried, and the one after the last. `valid` (rows, columns): the places where a
    patch may lie; on a torus they are all.
    """
    rows, columns = valid.shape
    unit, slack = fine
    for m in range(ends[0, 0], ends[0, 1]):
        for n in range(ends[1, 0], ends[1, 1]):
            dy, dx = m * steps[0, 0] + n * steps[1, 0], m * steps[0, 1] + n * steps[1, 1]
            y, x = shown[0] + (dy + unit // 2) // unit, shown[1] + (dx + unit // 2) // unit
            if not torus and not (-slack <= y < rows + slack and -slack <= x < columns + slack):
                continue
            for i in range(y - slack, y + slack + 1):
                for j in range(x - slack, x + slack + 1):
                    if torus:
                        there[i % rows, j % columns] = valid[i % rows, j % columns]
                    elif 0 <= i < rows and 0 <= j < columns:
                        there[i, j] = valid[i, j]
