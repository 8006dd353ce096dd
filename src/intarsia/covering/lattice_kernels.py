"""Patches that lie whole steps of a lattice from another: where they are, and which of them fit best."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel

NEVER = 1 << 62  # the distance of patches that fit less well than the best, wherever that is known
FIRST = 4  # every so many-th row is measured first: its distance is the least that the whole can have


@kernel
def mark_steps(steps: Any, most: Any, shown: Any, torus: bool, fine: Any, valid: Any, there: Any) -> None:
    """Mark in `there` all places up to `most` whole steps from the one `shown`, and around them, where a patch may lie.

    `steps` (1 or 2, 2): of so many parts of a px as the first of `fine` says; the second: how far around, px. `valid`
    (rows, columns): the places where a patch may lie; on a torus they are all.
    """
    rows, columns = valid.shape
    unit, slack = fine
    beside = most[1] if len(steps) > 1 else 0
    for m in range(-most[0], most[0] + 1):
        for n in range(-beside, beside + 1):
            dy, dx = m * steps[0, 0], m * steps[0, 1]
            if beside:
                dy, dx = dy + n * steps[1, 0], dx + n * steps[1, 1]
            y, x = shown[0] + (dy + unit // 2) // unit, shown[1] + (dx + unit // 2) // unit
            if not torus and not (-slack <= y < rows + slack and -slack <= x < columns + slack):
                continue
            for i in range(y - slack, y + slack + 1):
                for j in range(x - slack, x + slack + 1):
                    if torus:
                        there[i % rows, j % columns] = valid[i % rows, j % columns]
                    elif 0 <= i < rows and 0 <= j < columns:
                        there[i, j] = valid[i, j]


@kernel
def _runs(known: Any, channels: int) -> Any:
    """Where known pixels lie side by side: rows, and in these the first number and the one after the last, (n, 3)."""
    h, w = known.shape
    runs, count = np.empty((h * (w // 2 + 1), 3), np.int64), 0
    for i in range(h):
        j = 0
        while j < w:
            begin = j
            while j < w and known[i, j]:
                j += 1
            if j > begin:
                runs[count, 0], runs[count, 1], runs[count, 2] = i, begin * channels, j * channels
                count += 1
            j += 1
    return runs[:count]


@kernel
def _apart(a: Any, b: Any) -> int:
    """Return the squared distance of two rows of numbers."""
    total = 0
    for k in range(np.uint64(a.size)):
        difference = int(a[k]) - int(b[k])
        total += difference * difference
    return total


@kernel
def measure_best(feats: Any, known: Any, posed: Any, most: int, rows: Any) -> None:
    """Write the distance of each patch (distance, variant, row, column) of `rows` from a window into it.

    Those that are surely not among the `most` best have NEVER: their measuring ends where they are farther than these.
    """
    flat, table = posed
    h, w, channels = feats.shape
    window, runs = feats.reshape(h, w * channels), _runs(known, channels)
    least, best = np.zeros(len(rows), np.int64), np.full(most, NEVER, np.int64)
    for k in range(len(rows)):
        v = rows[k, 1]
        begin, stride = table[v, 0] + (rows[k, 2] * table[v, 3] + rows[k, 3]) * channels, table[v, 3] * channels
        for n in range(len(runs)):
            i, a, b = runs[n, 0], runs[n, 1], runs[n, 2]
            if i % FIRST == 0:
                at = begin + i * stride
                least[k] += _apart(window[i, a:b], flat[at + a : at + b])
    for k in np.argsort(least):
        v, total = rows[k, 1], least[k]
        begin, stride = table[v, 0] + (rows[k, 2] * table[v, 3] + rows[k, 3]) * channels, table[v, 3] * channels
        for n in range(len(runs)):
            i, a, b = runs[n, 0], runs[n, 1], runs[n, 2]
            if total > best[most - 1]:
                break
            if i % FIRST > 0:
                at = begin + i * stride
                total += _apart(window[i, a:b], flat[at + a : at + b])
        rows[k, 0] = total if total <= best[most - 1] else NEVER
        if total >= best[most - 1]:
            continue
        n = most - 1
        while n > 0 and best[n - 1] > total:
            best[n] = best[n - 1]
            n -= 1
        best[n] = total
