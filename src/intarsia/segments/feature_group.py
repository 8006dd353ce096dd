"""Selection of the feature group of a segmentation (SelectFeature): bricks and not mortar, dots and not ground.

Source: the segment-based fragments (docs/sources-003.md), algorithms SelectFeature, EdgeScore and SelectParameters. The
elements of the group should be of one size, evenly spread and compact. Departures: the terms have no unit, so that a
picture twice as large gives the same group; elements at the border are measured only where too few lie inside; large
elements count more than crumbs; how the patch size follows from the lists is our rule (docs/design/search-and-cuts.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..foundation import ndimage
from ..foundation.arrays import Array, Int32, Int64, Mask, Pair
from .felzenszwalb import LEAST_PIXELS

FINE = 16  # centroids are kept in 1/16 px: a unit; 8 and 32: no size differs by a tenth
RAGGED = 0.2  # weight of the edge score against the other terms; halved: 6 of 24 sizes differ, doubled: 2, at 0: 8
DISC = 4 * math.pi  # squared perimeter over area of a disc
NEAR = 8  # at most 6 points are nearest together, and each is near itself
# Of a boundary zone, ours: how many of 24 differ by 2 px.
LEAST_ZONE = 3  # px, where a patch is larger; 1: none, 6: three
NARROW = 6  # parts of the patch, one of them at least; 12: ten, 3: 19
WIDE = 3  # parts of the patch, one of them at most; 6: six, 2: three


# What is asked of a group. Halved and doubled on 24 textures: sizes that differ by a tenth (docs/design/012).
FEWEST = 5  # elements, as in SelectFeature of the fragments; 3: nine, 10: eleven
SPREAD = 0.5  # of the picture: the box around the group is larger, as there; halved: two of 64, 0.9: five
COVER = 0.02  # of the picture: a group of less is dirt; halved: three, doubled: six


@dataclass(frozen=True, eq=False)
class Group:
    """The lists of the fragments for one group: an entry for each element that counts.

    Attributes
    ----------
    sizes : int array, shape (n, 2)
        Height and width of the box around each element, px (SizeList).
    offsets : int array, shape (n, 2)
        Absolute offset (y, x) from its centroid to the nearest one of the group, 1/16 px (DistanceList).
    areas, edges : int arrays, shape (n,)
        Pixels of each element, and those of them with a neighbour outside it (EdgeScore).
    count : int
        Elements of the group, those at the border included.
    box : int
        Area of the box around the group, px.
    """

    sizes: Int64
    offsets: Int64
    areas: Int64
    edges: Int64
    count: int
    box: int

    @property
    def distances(self) -> Int64:
        """Distance to the nearest element, 1/16 px, rounded down."""
        square = (self.offsets * self.offsets).sum(axis=1)
        return np.asarray(np.sqrt(square.astype(np.float64)), np.int64)

    @property
    def edge_score(self) -> float:
        """Squared perimeter over area, 4 pi for a disc: the mean over elements, by their area."""
        return float((self.edges * self.edges).sum()) / float(self.areas.sum())

    @property
    def energy(self) -> float:
        """How uneven the group is, 0 or more: coefficients of variation, weighted by area: no unit, no 0 / 0."""
        height, width = (variation(self.sizes[:, k], self.areas) for k in (0, 1))
        return variation(self.distances, self.areas) + (height + width) / 2 + RAGGED * self.edge_score / DISC


def measured(elements: Int32) -> Group | None:
    """Return the lists of the elements of a group (1, 2, ... in a map, 0 elsewhere); None if fewer than 2 count."""
    count = int(elements.max(initial=0))
    inside = np.flatnonzero(elements)
    names = elements.ravel()[inside]
    areas = np.bincount(names, minlength=count + 1)[1:]
    counted = np.flatnonzero(areas >= LEAST_PIXELS)
    if len(counted) < 2:
        return None
    found = ndimage.find_objects(elements)
    ends = np.array([(s[0].start, s[0].stop, s[1].start, s[1].stop) for s in found])[counted]
    rows, columns = np.divmod(inside, elements.shape[1])
    centres = np.stack([FINE * sums(names, v, count + 1)[1:] // np.maximum(areas, 1) for v in (rows, columns)], axis=1)
    edges = np.bincount(names[edge_pixels(elements).ravel()[inside]], minlength=count + 1)[1:]
    whole = (ends[:, 0] > 0) & (ends[:, 2] > 0)
    whole &= (ends[:, 1] < elements.shape[0]) & (ends[:, 3] < elements.shape[1])
    if np.count_nonzero(whole) < FEWEST:
        whole[:] = True
    box = (ends[:, 1].max() - ends[:, 0].min()) * (ends[:, 3].max() - ends[:, 2].min())
    kept = counted[whole]
    return Group(
        np.stack([ends[:, 1] - ends[:, 0], ends[:, 3] - ends[:, 2]], axis=1)[whole].astype(np.int64),
        nearest_offsets(centres[counted])[whole], areas[kept], edges[kept], len(counted), int(box),
    )  # fmt: skip


def nearest_offsets(points: Int64) -> Int64:
    """Return the absolute offset (y, x) from every point to its nearest other; of equal ones the smallest."""
    k = min(len(points), NEAR)
    from scipy.spatial import cKDTree  # it is slow to import

    near = cKDTree(points).query(points, k=k)[1].reshape(len(points), k)
    mine = np.arange(len(points))[:, None]
    offset = np.abs(points[near] - points[mine])
    square = (offset * offset).sum(axis=2)
    square[near == mine] = np.iinfo(np.int64).max
    best = np.lexsort((offset[:, :, 1], offset[:, :, 0], square), axis=1)[:, 0]
    return np.asarray(offset[mine[:, 0], best], np.int64)


def admitted(group: Group | None, pixels: int) -> bool:
    """Return whether a group passes: at least 5 elements, spread over more than half of the picture, 2 % covered."""
    if group is None or group.count < FEWEST:
        return False
    return bool(group.box > SPREAD * pixels and group.areas.sum() >= COVER * pixels)


def size_and_gap(group: Group) -> Pair:
    """Return the usual size of an element with the gap to the next one, and that gap alone, 1/16 px.

    Element and gap together are the distance from centre to centre; long elements lie nearer than they are long.
    """
    total = int(group.areas.sum())
    long = int((group.areas * group.sizes.max(axis=1)).sum()) * FINE // total
    apart = int((group.areas * group.distances).sum()) // total
    across = FINE * group.sizes.sum(axis=1) // 2
    gap = np.maximum(group.distances - across, 0)
    return max(long, apart), int((group.areas * gap).sum()) // total


def zone(patch: int, gap: int) -> int:
    """Return the width of the boundary zone for a patch: one gap, from a sixth to a third of the patch, px."""
    high = max(patch // WIDE, min(LEAST_ZONE, patch - 1))
    return min(max(gap, patch // NARROW, min(LEAST_ZONE, high)), high)


def variation(values: Int64, weights: Int64) -> float:
    """Return the weighted coefficient of variation of whole numbers; the mean is taken as 1 at least."""
    total, first = int(weights.sum()), int((weights * values).sum())
    second = int((weights * values * values).sum())
    return math.sqrt(total * second - first * first) / max(first, total)


def edge_pixels(elements: Array) -> Mask:
    """Return the pixels with one of 4 neighbours outside their element; the border of the picture is no edge."""
    edge = np.zeros(elements.shape, bool)
    for axis in (0, 1):
        a, b = (np.s_[:-1], np.s_[1:]) if axis == 0 else (np.s_[:, :-1], np.s_[:, 1:])
        differs = elements[a] != elements[b]
        edge[a] |= differs
        edge[b] |= differs
    return edge


def sums(where: Array, values: Array, count: int = 0) -> Int64:
    """Return the sums of whole values by number, at least `count` of them; exact below 2**53."""
    return np.asarray(np.rint(np.bincount(where, values, count)), np.int64)
