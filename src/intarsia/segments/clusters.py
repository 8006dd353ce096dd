"""Groups of segments that look alike, and the separate elements of a group.

The segment-based fragments (docs/sources-003.md) cluster segments "adaptively" without saying how. Here they are split
in two where that explains most of their colour, and each part again: a tree, in which every node is a group. Why so is
told in docs/design/008-segments.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..lazy import ndimage
from .felzenszwalb import NOWHERE

Int32 = NDArray[np.int32]
Int64 = NDArray[np.int64]

DEPTH = 3  # splits in a row: at most 8 groups that do not overlap; 2 and 6: ten and eight of 24 sizes differ


@dataclass(frozen=True, eq=False)
class GroupTree:
    """Segments, and the groups that they form.

    Attributes
    ----------
    labels : int32 array, shape (H, W)
        Segment of every pixel; -1: does not count.
    nodes : tuple of int arrays
        The segments of every group, parents before their parts.
    leaves : tuple of int
        The nodes without parts; every segment is in one of them.
    """

    labels: Int32
    nodes: tuple[Int64, ...]
    leaves: tuple[int, ...]

    def elements(self, node: int) -> Int32:
        """Return the elements of a group: its connected regions, numbered from 1; 0 elsewhere.

        Segments of one group that touch are one element: a stone that noise has cut in two becomes whole.
        """
        inside = np.zeros(int(self.labels.max()) + 2, bool)
        inside[self.nodes[node]] = True
        return _regions(inside[self.labels])  # -1 is the last entry: outside

    def around(self, node: int) -> tuple[Int32, Int32, int]:
        """Return elements, their groups, and the group that is `node`: a partition that holds this node.

        Elements are the connected regions of all groups, -1 where nothing counts.
        """
        mine = set(self.nodes[node].tolist())
        parts = [n for n in self.leaves if n != node and not mine & set(self.nodes[n].tolist())]
        parts = sorted([*parts, node], key=lambda n: int(self.nodes[n].min()))
        out = np.full(self.labels.shape, NOWHERE, np.int32)
        groups: list[int] = []
        for g, n in enumerate(parts):
            found = self.elements(n)
            out = np.where(found > 0, found + np.int32(len(groups) - 1), out).astype(np.int32)
            groups += [g] * int(found.max())
        return out, np.array(groups, np.int32), parts.index(node)


def group_tree(labels: Int32, colours: NDArray[Any], depth: int = DEPTH) -> GroupTree:
    """Group segments by their mean colour.

    Parameters
    ----------
    labels : int32 array, shape (H, W)
        Segment of every pixel, -1: does not count.
    colours : integer array, shape (H, W, C)
        Channels that count alike, see :func:`even_colours`.
    depth : int
        How many times in a row a group is split.
    """
    flat = labels.ravel()
    some = flat >= 0
    area = np.bincount(flat[some])
    mean = np.stack([_sums(flat[some], c[some]) // area for c in colours.reshape(len(flat), -1).T], axis=1)
    nodes: list[Int64] = []
    leaves: list[int] = []

    def grow(members: Int64, level: int) -> None:
        nodes.append(members)
        mine = len(nodes) - 1
        parts = split(mean[members], area[members]) if level < depth else None
        if parts is None:
            leaves.append(mine)
            return
        for part in (parts, ~parts):
            grow(members[part], level + 1)

    grow(np.arange(len(area)), 0)
    return GroupTree(labels, tuple(nodes), tuple(leaves))


def split(colours: Int64, areas: Int64) -> NDArray[np.bool_] | None:
    """Split colours in two along the channel and at the value that leave least variance (Otsu's rule).

    Areas are weights. Returns which are in the lower part, or None where all are equal. Equal colours stay
    together, so the order in which they are given does not matter.
    """
    best, result = 0.0, None
    total = int(areas.sum())
    for channel in colours.T:
        values, where = np.unique(channel, return_inverse=True)
        weight = _sums(where, areas)
        below = np.cumsum(weight)[:-1]
        partial = np.cumsum(weight * values)
        gap = (partial[:-1] * total - partial[-1] * below).astype(np.float64)
        gain = gap * gap / (below * (total - below)).astype(np.float64)
        if gain.size and gain.max() > best:
            best = float(gain.max())
            result = channel <= values[int(np.argmax(gain))]
    return result


def _sums(where: NDArray[Any], values: NDArray[Any]) -> Int64:
    """Add up whole values by their number; exact, for doubles hold sums below 2**53."""
    return np.asarray(np.rint(np.bincount(where, values)), np.int64)


def _regions(mask: NDArray[np.bool_]) -> Int32:
    found, _ = ndimage.label(mask)
    return np.asarray(found, np.int32)
