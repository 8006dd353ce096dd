"""The whole elements of posed exemplars: their masks, the joints around them, and which pixels belong to which."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import pose_array
from ..kernels.pieces_of_maps import boxes_of_parts
from ..lazy import ndimage
from ..search.posed import PosedExemplars
from ..segments.wholes import Wholes

Array = NDArray[Any]
RING = 4  # px: so far around an element its joint is wanted
RIM = 5  # px: elements so near the exemplar's border may not be whole


@dataclass(frozen=True, eq=False)
class Element:
    """A whole element of a variant: where its mask begins, the mask, and around it the joint that is wanted."""

    variant: int
    at: tuple[int, int]
    mask: NDArray[np.bool_]
    ring: NDArray[np.bool_]
    whole: bool

    @property
    def side(self) -> float:
        """Root of its area, px."""
        return math.sqrt(int(self.mask.sum()))


class Elements:
    """All elements of posed exemplars, from 1."""

    def __init__(self, variants: PosedExemplars, found: list[Wholes]) -> None:
        self.all: list[Element | None] = [None]
        kin, first = [np.zeros(1, np.int64)], np.cumsum([1, *(len(w.sure) - 1 for w in found)])
        labels, inside, sure, boxes, masks, begin = [], [], [0.0], [], [], 0
        for v in range(len(variants)):
            mine, shape = found[int(variants.exemplar[v])], variants.picture(v).shape[:2]
            names, depth = (pose_array(a, int(variants.pose[v])) for a in (mine.labels, mine.inside))
            pad = [(0, n - m) for n, m in zip(shape, names.shape, strict=True)]
            inside.append(np.pad(depth, pad, "wrap").ravel())
            labels.append(np.pad(np.where(names > 0, names + len(self.all) - 1, 0), pad).ravel())
            ends = np.zeros((int(names.max(initial=0)), 5), np.int64)
            boxes_of_parts(np.ascontiguousarray(names), (False, False), ends)
            for k, (top, left, height, width) in enumerate(ends[:, :4].tolist(), 1):
                part = np.s_[top : top + height, left : left + width]
                element = _element(v, names, part, names[part] == k)
                if element.whole:
                    y, x = (int(at.mean()) for at in np.nonzero(element.mask))
                    area = int(element.mask.sum())
                    boxes.append((begin, *element.mask.shape, area, y, x, len(self.all)))
                    masks.append(element.mask.ravel())
                    begin += element.mask.size
                self.all.append(element)
            sure += mine.sure[1:].tolist()
            kin.append(int(first[int(variants.exemplar[v])]) + np.arange(len(mine.sure) - 1))
        self.labels, self.inside = np.concatenate(labels).astype(np.int32), np.concatenate(inside)
        every = np.array([0] + [int(e.mask.sum()) for e in self.all if e is not None], np.int64)
        self.known, self.kin = (every, np.array(sure)), np.concatenate(kin)
        self.boxes = np.array(boxes, np.int64).reshape(-1, 7)
        self.masks = np.concatenate(masks) if masks else np.zeros(0, bool)

    def __getitem__(self, number: int) -> Element:
        element = self.all[number]
        assert element is not None, "elements are numbered from 1"
        return element


def _element(v: int, names: Array, part: tuple[slice, ...], mask: NDArray[np.bool_]) -> Element:
    (h, w), n = names.shape, RING
    off = [part[0].start < RIM, part[1].start < RIM, part[0].stop > h - RIM, part[1].stop > w - RIM]
    big = np.pad(mask, n)
    ring = ndimage.binary_dilation(big, iterations=n) & ~big
    y, x = np.nonzero(ring)
    y, x = y + part[0].start - n, x + part[1].start - n
    free = (y >= 0) & (x >= 0) & (y < h) & (x < w)
    free[free] = names[y[free], x[free]] == 0
    ring[ring] = free
    return Element(v, (part[0].start, part[1].start), mask, ring, not any(off))
