"""Peaks of a profile, as `scipy.signal.find_peaks` finds them; to import that takes longer than to grow a wall."""

from __future__ import annotations

import numpy as np

from ..arrays import Array


def peaks(profile: Array, height: float, prominence: float, distance: int) -> list[int]:
    """Return where a profile (n,) has peaks so high, that rise so far above what separates them from higher ones.

    The middle of a plateau counts. Of two nearer than `distance` the higher one stays, the later one of two as high.
    """
    found = [at for at in _tops(profile) if profile[at] >= height]
    kept: list[int] = []
    for at in sorted(found, key=lambda at: (profile[at], at), reverse=True):
        if all(abs(at - other) >= distance for other in kept):
            kept.append(at)
    return [at for at in sorted(kept) if _prominence(profile, at) >= prominence]


def _tops(profile: Array) -> list[int]:
    """The middles of what is higher than both neighbours."""
    begins = np.concatenate([[0], np.flatnonzero(np.diff(profile)) + 1])
    ends = np.append(begins[1:], len(profile)) - 1
    level = profile[begins]
    inner = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])) + 1
    return [int(at) for at in (begins[inner] + ends[inner]) // 2]


def _prominence(profile: Array, at: int) -> float:
    """How far one must go down from a peak, at least, to come to a higher one, or to the end."""
    lowest = []
    for side in (profile[at::-1], profile[at:]):
        higher = np.flatnonzero(side > profile[at])
        lowest.append(side[: higher[0] if len(higher) else len(side)].min())
    return float(profile[at] - max(lowest))
