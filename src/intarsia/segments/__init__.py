"""Segmentation of an exemplar into texture elements, and the patch size that follows (segment-based fragments).

A picture is cut into segments, segments are grouped by colour, and the group with the most even elements sets the size
of patches and the width of their boundary zone.

Source: the segment-based fragments (docs/sources-003.md). Departures: twelve scales vote, because one fails on blur or
noise; the terms compared have no unit; where no group passes, the size comes from the autocorrelation, and the result
says so. The fragments cluster segments "adaptively" without saying how: here groups are split in two where that
explains most of their colour, and each part again: a tree, in which every node is a group. What the source leaves open
is decided in docs/design/search-and-cuts.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ..analysis import factor_for, reduced
from ..analysis.elements import element_size
from ..analysis.features import features
from ..foundation import ndimage
from ..foundation.arrays import Array, Int16, Int32, Int64, Mask, Pair
from ..model import Exemplar
from .feature_group import FEWEST, FINE, Group, admitted, measured, size_and_gap, sums, zone
from .felzenszwalb import DEVIATION, NOWHERE, PixelGraph, even_colours, smoothed

DEPTH = 3  # splits in a row: at most 8 groups that do not overlap; 2 and 6: ten and eight of 24 sizes differ


@dataclass(frozen=True, eq=False)
class GroupTree:
    """A segmentation and the tree of its groups.

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
        regions, _ = ndimage.label(inside[self.labels])  # -1 is the last entry: outside
        return np.asarray(regions, np.int32)

    def around(self, node: int) -> tuple[Int32, Int32, int]:
        """Return elements, their groups, and the number of the group `node`, in a partition that holds this node.

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


def group_tree(labels: Int32, colours: Array, depth: int = DEPTH) -> GroupTree:
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
    mean = np.stack([sums(flat[some], c[some]) // area for c in colours.reshape(len(flat), -1).T], axis=1)
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


def split(colours: Int64, areas: Int64) -> Mask | None:
    """Split colours in two along the channel and at the value that leave least variance (Otsu's rule).

    Areas are weights. Returns which are in the lower part, or None where all are equal. Equal colours stay
    together, so the order in which they are given does not matter.
    """
    best, result = 0.0, None
    total = int(areas.sum())
    for channel in colours.T:
        values, where = np.unique(channel, return_inverse=True)
        weight = sums(where, areas)
        below = np.cumsum(weight)[:-1]
        partial = np.cumsum(weight * values)
        gap = (partial[:-1] * total - partial[-1] * below).astype(np.float64)
        gain = gap * gap / (below * (total - below)).astype(np.float64)
        if gain.size and gain.max() > best:
            best = float(gain.max())
            result = channel <= values[int(np.argmax(gain))]
    return result


# Chosen on 28 photographs whose sizes were known (docs/design/search-and-cuts.md); then fewer and more on 24 textures
# (docs/design/012): how many sizes differ by a tenth.
PASSES = (1, 4, 12)  # of the blur: sigma 0.7, 1.4, 2.4 px; without 12: seven, with 24: five, 1 alone: 14
SLACKS = (1, 2, 4, 8)  # in standard deviations of the colours; without 8: three, with 16: two, 1 and 4 alone: eight
LEAST_PATCH = 8  # px; 4 and 16: none (of 40 larger ones none and two)


# How groups vote for a size, halved and doubled in the same way.
STEP = 32  # sizes are told apart by one part in so many; 16 and 64: six and seven
REACH = 16  # steps, half an octave: sizes so near support one another; two and four
ALIKE = 5  # steps: sizes so near are one, of which the most even wins; seven and five
ABOUT = 0.1  # energies that differ by less count as equal; three and four, at 0 five
POWER = 6  # of the votes: uneven groups hardly count; three and four, at 0 four
MOST = 1 << 20  # votes of a group without any unevenness: a unit; 1024: the same


class SizeRule(StrEnum):
    """Where a patch size comes from."""

    SEGMENTS = "segments"  # the vote of the segment groups
    AUTOCORRELATION = "autocorrelation"  # no group will do


@dataclass(frozen=True, eq=False)
class Segments:
    """The segments of an exemplar, their groups, and the patch that suits the chosen group.

    Attributes
    ----------
    labels : int32 array, shape (H, W)
        Segment of every pixel: 0, 1, ...; -1 where it does not count.
    groups : int32 array, shape (segments,)
        Group of every segment: 0, 1, ...
    chosen : int, optional
        The feature group, whose segments are the elements of the texture; None: no group will do.
    patch, zone : int
        Side of a patch and width of its boundary zone (a and b of the fragments), px; zone < patch.
    rule : SizeRule
        What they come from.
    scale : (blur, slack), optional
        Where the segments stand out: sigma of the blur in px, and the source's k in standard deviations.
    energy : float
        How uneven the chosen group is; 0 without one.
    support : float
        Share of the vote for sizes like this, 0..1.
    why : str
        The rule in a sentence.
    reduction : int
        The exemplar was looked at this many times smaller.
    """

    labels: Int32
    groups: Int32
    chosen: int | None
    patch: int
    zone: int
    rule: SizeRule
    scale: tuple[float, float] | None
    energy: float
    support: float
    why: str
    reduction: int = 1

    def __post_init__(self) -> None:
        for array in (self.labels, self.groups):
            array.flags.writeable = False

    @property
    def group_map(self) -> Int32:
        """Group of every pixel, (H, W); -1 where it does not count."""
        return np.append(self.groups, np.int32(NOWHERE))[self.labels]


@dataclass(frozen=True, eq=False)
class Candidate:
    """A group at one scale that passes the filters."""

    tree: GroupTree
    node: int
    lists: Group
    scale: Pair
    size: int  # of an element and the gap to the next one, 1/16 px
    gap: int
    energy: float


def segments(exemplar: Exemplar) -> Segments:
    """Return the segments of an exemplar's base plane, computed once."""

    def find() -> Segments:
        feats = features([exemplar])
        return find_segments(feats.pictures[0][:, :, : feats.base], exemplar.usable)

    return exemplar.memo("segments", find)


def find_segments(features: Int16, usable: Mask | None = None) -> Segments:
    """Find the segments of a picture, and which of them are its elements.

    Parameters
    ----------
    features : int16 array, shape (H, W, C)
        Any size. Above 512 px a side a box-reduced copy is looked at.
    usable : bool array, shape (H, W), optional
        False where pixels do not count.

    Returns
    -------
    Segments
        The same on every machine. There is always an answer: for a constant picture, or where no group passes,
        the rule is ``autocorrelation``.
    """
    if usable is not None and usable.all():
        usable = None
    factor = factor_for(features.shape)
    small, mask = reduced(features, usable, factor)
    pixels = small.shape[0] * small.shape[1] if mask is None else int(np.count_nonzero(mask))
    colours = even_colours(small, mask)
    if colours is None:
        return fallback(features, usable, None, "The exemplar is constant.")
    every = list(scales(colours, mask))
    candidates = [c for scale, tree in every for c in candidates_at(scale, tree, pixels)]
    if not candidates:
        return fallback(features, usable, every[len(every) // 2][1], "No group of segments passes the filters.")
    sizes = np.array([c.size for c in candidates], np.int64)
    areas = np.array([int(c.lists.areas.sum()) for c in candidates], np.int64)
    winner, support = vote(sizes, [c.energy for c in candidates], areas)
    return of_group(candidates[winner], support, factor, features.shape[:2])


def vote(sizes: Int64, energies: list[float], areas: Int64) -> tuple[int, float]:
    """Let groups vote for the size of elements; return which of them wins, and the share of the vote for its size.

    Each has 1 / (1 + energy)^6 votes, and supports sizes like its own, less the more they differ. Among the groups
    of the size with most support the one of least energy wins, or of those about as even the one of most area: whole
    elements, not their rims or cores. Of equals it is the first.
    """
    votes = np.array([int(MOST / math.prod([1 + e] * POWER)) for e in energies], np.int64)
    steps = np.searchsorted(_ladder(int(sizes.max())), sizes)
    apart = np.abs(steps[:, None] - steps)
    support = (np.maximum(REACH - apart, 0) * votes).sum(axis=1)
    alike = np.flatnonzero(apart[int(np.argmax(support))] <= ALIKE)
    least = min(energies[k] for k in alike)
    winner = max((k for k in alike.tolist() if energies[k] <= least + ABOUT), key=lambda k: (areas[k], -k))
    share = float(votes[apart[winner] < REACH].sum()) / float(max(votes.sum(), 1))
    return winner, share


def _ladder(top: int) -> Int64:
    """Return whole sizes, each a 32nd larger than the one before: a logarithm that rounds the same everywhere."""
    steps = [FINE]
    while steps[-1] < top:
        steps.append(steps[-1] + max(steps[-1] // STEP, 1))
    return np.array(steps, np.int64)


def scales(colours: Int32, mask: Mask | None) -> Iterator[tuple[Pair, GroupTree]]:
    """Yield segments and groups at every scale: from little to much blur, from little to much slack."""
    unit = int(DEVIATION * math.sqrt(colours.shape[2]))  # the usual distance of a colour from the mean
    blurred, done = colours, 0
    for passes in PASSES:
        blurred, done = smoothed(blurred, passes - done), passes
        graph = PixelGraph(blurred, mask)
        for slack in SLACKS:
            yield (passes, slack), group_tree(graph.segments(slack * unit), colours)


def candidates_at(scale: Pair, tree: GroupTree, pixels: int) -> Iterator[Candidate]:
    """Yield the groups of a scale that pass the filters."""
    for node in range(len(tree.nodes)):
        elements = tree.elements(node)
        if int(elements.max()) < FEWEST:  # measuring takes longest
            continue
        lists = measured(elements)
        if lists is not None and admitted(lists, pixels):
            yield Candidate(tree, node, lists, scale, *size_and_gap(lists), lists.energy)


def of_group(winner: Candidate, support: float, factor: int, shape: tuple[int, ...]) -> Segments:
    """Return the segments of the winner's scale, with the patch and zone that follow from it."""
    labels, groups, chosen = winner.tree.around(winner.node)
    patch = limited(-(-winner.size * factor // FINE), min(shape))
    return Segments(
        enlarged_labels(labels, factor, shape), groups, chosen, patch,
        zone(patch, (winner.gap * factor + FINE // 2) // FINE), SizeRule.SEGMENTS,
        (math.sqrt(winner.scale[0] / 2) * factor, float(winner.scale[1])), winner.energy, support,
        f"{winner.lists.count} elements of segments that look alike are the most even group of the size that most "
        "groups have.", factor,
    )  # fmt: skip


def fallback(features: Int16, usable: Mask | None, tree: GroupTree | None, why: str) -> Segments:
    """Return the size by the autocorrelation, with the segments of the middle scale if there are any."""
    shape = features.shape[:2]
    factor = 1
    if tree is None:
        labels = np.zeros(shape, np.int32) if usable is None else np.where(usable, 0, NOWHERE).astype(np.int32)
        groups = np.zeros(int(labels.max(initial=NOWHERE)) + 1, np.int32)
    else:
        labels, groups, _ = tree.around(tree.leaves[0])
        factor = shape[0] // labels.shape[0]
    patch = limited(element_size(features, usable).size, min(shape))
    return Segments(
        enlarged_labels(labels, factor, shape), groups, None, patch, zone(patch, patch // 3), SizeRule.AUTOCORRELATION,
        None, 0.0, 0.0, f"{why} The size follows from the autocorrelation.", factor,
    )  # fmt: skip


def limited(patch: int, short: int) -> int:
    """Return a patch clamped between 8 px and half the short side, at least 1 px."""
    return max(1, min(max(patch, LEAST_PATCH), short // 2))


def enlarged_labels(labels: Int32, factor: int, shape: tuple[int, ...]) -> Int32:
    """Return every label repeated factor x factor times, the last one continued to the shape."""
    if factor == 1:
        return labels
    y, x = (np.minimum(np.arange(n) // factor, m - 1) for n, m in zip(shape, labels.shape, strict=True))
    return np.ascontiguousarray(labels[np.ix_(y, x)])
