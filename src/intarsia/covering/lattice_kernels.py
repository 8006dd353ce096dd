"""Patches that lie whole steps of a lattice from another: which of them fit best."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kernels.jit import kernel

NEVER = 1 << 62  # the distance of patches that fit less well than the best, wherever that is known
MOST = ((1 << 31) - 1) // 4092**2  # squares of what two features differ by at most: so many stay below 2**31
FIRST = 4  # every so many-th row is measured first: its distance is the least that the whole can have


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
def _apart(window: Any, flat: Any, a: Any, b: Any, n: int) -> Any:
    """Return the squared distance of n numbers of `window` from `a` on and of `flat` from `b` on, in 64 bits.

    Parts of it are added up in 32 bits, and unsigned offsets let these run in vector registers.
    """
    total = np.int64(0)
    for first in range(0, n, MOST):
        part, c, d = np.int32(0), a + np.uint64(first), b + np.uint64(first)
        for k in range(np.uint64(min(n - first, MOST))):
            difference = np.int16(window[c + k] - flat[d + k])
            part = np.int32(part + np.int32(difference) * np.int32(difference))
        total += part
    return total


@kernel
def measure_best(feats: Any, known: Any, posed: Any, most: int, rows: Any) -> None:
    """Write the distance of each patch (distance, variant, row, column) of `rows` from a window into it.

    Those that are surely not among the `most` best have NEVER: their measuring ends where they are farther than these.
    """
    flat, table = posed
    h, w, channels = feats.shape
    window, runs = feats.reshape(h * w * channels), _runs(known, channels)
    least, best = np.zeros(len(rows), np.int64), np.full(most, NEVER, np.int64)
    for k in range(len(rows)):
        v = rows[k, 1]
        begin, stride = table[v, 0] + (rows[k, 2] * table[v, 3] + rows[k, 3]) * channels, table[v, 3] * channels
        for n in range(len(runs)):
            i, a, b = runs[n, 0], runs[n, 1], runs[n, 2]
            if i % FIRST == 0:
                here, there = np.uint64(i * w * channels + a), np.uint64(begin + i * stride + a)
                least[k] += _apart(window, flat, here, there, b - a)
    for k in np.argsort(least):
        v, total = rows[k, 1], least[k]
        begin, stride = table[v, 0] + (rows[k, 2] * table[v, 3] + rows[k, 3]) * channels, table[v, 3] * channels
        for n in range(len(runs)):
            i, a, b = runs[n, 0], runs[n, 1], runs[n, 2]
            if total > best[most - 1]:
                break
            if i % FIRST > 0:
                here, there = np.uint64(i * w * channels + a), np.uint64(begin + i * stride + a)
                total += _apart(window, flat, here, there, b - a)
        rows[k, 0] = total if total <= best[most - 1] else NEVER
        if total >= best[most - 1]:
            continue
        n = most - 1
        while n > 0 and best[n - 1] > total:
            best[n] = best[n - 1]
            n -= 1
        best[n] = total
