"""Structure tensor of a texture, continuity across its borders, and detection of label pictures."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..foundation.arrays import Array, Int16, Mask

SEAMLESS = 1.3  # largest mean difference across a border, relative to that of neighbours inside, that counts as none


@dataclass(frozen=True)
class Structure:
    """Dominant orientation of the edges of a texture.

    Attributes
    ----------
    coherence : float
        0 to 1: how far all edges have one direction, from the eigenvalues l1 >= l2 as (l1 - l2) / (l1 + l2).
    angle : float
        That direction, degrees: 0 to the right, 90 downwards.
    """

    coherence: float
    angle: float


@dataclass(frozen=True)
class Border:
    """The mean difference across the borders, relative to that of neighbours inside; inf if it is not known."""

    rows: float  # from the bottom row to the top row
    columns: float  # from the last column to the first

    @property
    def closed(self) -> bool:
        """Whether the exemplar can be tiled without visible seams, along both axes."""
        return max(self.rows, self.columns) <= SEAMLESS


def structure_of(picture: Int16, usable: Mask | None) -> Structure:
    """Return the orientation of edges, from the structure tensor of the sum of all channels of a picture (H, W, C)."""
    total = picture.sum(axis=2, dtype=np.int64)
    if min(total.shape) < 3:
        return Structure(0.0, 0.0)
    down, right = total[2:, 1:-1] - total[:-2, 1:-1], total[1:-1, 2:] - total[1:-1, :-2]
    if usable is not None:
        free = usable[2:, 1:-1] & usable[:-2, 1:-1] & usable[1:-1, 2:] & usable[1:-1, :-2]
        down, right = down[free], right[free]
    yy, xx, xy = (int((a * b).sum()) for a, b in ((down, down), (right, right), (down, right)))
    if yy + xx == 0:
        return Structure(0.0, 0.0)
    coherence = math.hypot(xx - yy, 2 * xy) / (xx + yy)
    across = 0.5 * math.atan2(2 * xy, xx - yy)  # direction of the gradient; edges are perpendicular to it
    return Structure(coherence, round(math.degrees(across) + 90, 1) % 180)


def border_of(picture: Int16, usable: Mask | None) -> Border:
    """Return the mean difference across each pair of opposite borders, relative to that of neighbours along the axis.

    A difference is summed over channels. `picture` (H, W, C); `usable` (H, W): pixels to compare.
    """
    shares = []
    for axis in (0, 1):
        p = np.moveaxis(picture, axis, 0).astype(np.int64)
        free = np.ones(p.shape[:2], bool) if usable is None else np.moveaxis(usable, axis, 0)
        if len(p) < 4:
            shares.append(math.inf)
            continue
        steps = np.abs(p[1:] - p[:-1]).sum(axis=2)
        inside = free[1:] & free[:-1]
        over = np.abs(p[0] - p[-1]).sum(axis=1)[free[0] & free[-1]]
        usual = int(steps[inside].sum()) / max(int(inside.sum()), 1)
        shares.append(float(over.sum()) / len(over) / usual if len(over) and usual else math.inf)
    return Border(*shares)


def flat_colours(samples: Array, most: int, equal: int) -> bool:
    """Return whether samples (H, W, C) have 2 to `most` colours, and `equal` of 10 neighbours are equal."""
    codes = np.zeros(samples.shape[:2], np.uint64)
    for c in range(samples.shape[2]):
        codes = codes * np.uint64(65599) + samples[..., c].astype(np.uint64)
    if not 2 <= len(np.unique(codes)) <= most:
        return False
    alike = int((codes[1:] == codes[:-1]).sum()) + int((codes[:, 1:] == codes[:, :-1]).sum())
    return 10 * alike >= equal * max(2 * codes.size - sum(codes.shape), 1)
