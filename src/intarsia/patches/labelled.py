"""Growing under labels: large patches inside the regions, smaller ones along their boundaries, strays replaced."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..blend import Blend
from ..canvas import Canvas
from ..exemplar import Exemplar
from ..guide import Guide
from ..lazy import ndimage
from ..search.guide import numbered_labels
from ..sourcemap import HOLE, SourceMap
from .growth import Growth, Turn
from .settings import PatchSettings

PASS = 1 << 20  # draws of the second pass are apart from those of the first


class Stages:
    """The growths that make a map one after another: one alone, or several under labels.

    Iterate and fill each growth, then take the `map`. Under labels the inside of the regions comes first, then the rest
    with smaller patches, then what strayed too far over a boundary, region by region.
    """

    map: SourceMap

    def __init__(self, settings: PatchSettings, exemplars: Sequence[Exemplar], canvas: Canvas, blend: Blend) -> None:
        self.settings, self.exemplars, self.canvas, self.blend = settings, exemplars, canvas, blend

    def __iter__(self) -> Iterator[Growth]:
        guide, settings, exemplars = self.canvas.guide, self.settings, self.exemplars
        if guide is None or not guide.is_labels:
            yield from self._filled(Growth(settings, exemplars, self.canvas))
            return
        small = settings.smaller
        yield from self._filled(Growth(settings, exemplars, self.canvas, small is not None, turn=Turn(0, 0, 3)))
        if small is not None and self.map.holes.any():
            begun = replace(self.canvas, start=self.map)
            yield from self._filled(Growth(small, exemplars, begun, turn=Turn(PASS, 1, 3)))
        if settings.boundaries.slack is not None and guide.weight:
            yield from self._without_strays(guide, settings.boundaries.slack)

    def _filled(self, growth: Growth) -> Iterator[Growth]:
        yield growth
        self.map = growth.map(self.blend)

    def _without_strays(self, guide: Guide, slack: int) -> Iterator[Growth]:
        """Replace what strayed too far over a boundary, region by region, up to the very boundary of the target.

        Happens where the exemplars show no boundary of that shape, or none at all between two labels. What other
        regions hold is as if outside the canvas; pixels that a start map locks are not touched.
        """
        target = numbered_labels(guide.target, guide.names)
        found = shown_labels(self.map, guide)
        stray = strays(found, target, slack, neighbours(guide))
        free = np.ones(target.shape, bool) if self.canvas.start is None else self.canvas.start.holes
        stray &= free
        settings = replace(self.settings, boundaries=self.settings.boundaries._replace(isometries="none"))
        for k in np.unique(target[stray]).tolist():
            here = target == k
            which = np.zeros(target.shape, np.uint8) if self.map.which is None else self.map.which
            kept = np.where(here & (found == k), which, HOLE).astype(np.uint8)
            start = replace(self.map, which=kept)
            plane = replace(guide.target, pixels=np.full_like(guide.target.pixels, guide.names[k]))
            inner = replace(self.canvas, start=start, guide=replace(guide, target=plane))
            growth = Growth(settings, self.exemplars, inner, wanted=stray & here, turn=Turn(2 * PASS + k, 2, 3))
            yield growth
            taken = free & here & (stray | (found == k))
            self.map = _merged(self.map, growth.map(self.map.blend), taken)


def shown_labels(smap: SourceMap, guide: Guide) -> Array:
    """Return the number of the label that every output pixel has where it comes from; -1 in holes."""
    out = np.full(smap.yx.shape[:2], -1, np.int16)
    which = np.zeros(out.shape, np.uint8) if smap.which is None else smap.which
    for n, source in enumerate(guide.sources):
        mine = which == n
        yx = smap.yx[mine]
        out[mine] = numbered_labels(source, guide.names)[yx[:, 0], yx[:, 1]]
    return out


def neighbours(guide: Guide) -> Array:
    """Return which pairs of labels lie side by side beside the exemplars: (K + 1, K + 1), True for a label alone."""
    size = len(guide.names) + 1
    out = np.eye(size, dtype=bool)
    for source in guide.sources:
        ids = numbered_labels(source, guide.names)
        for a, b in ((ids[1:], ids[:-1]), (ids[:, 1:], ids[:, :-1])):
            out[a, b] = out[b, a] = True
    return out


def strays(found: Array, target: Array, slack: int, beside: Array) -> Array:
    """Return the wrong pixels of every patch of them that reaches deeper than `slack` px into a region.

    Where the exemplars never show two labels side by side (`beside`), there is no boundary to keep: all are strays.
    """
    wrong = np.asarray(found != target)
    groups, count = ndimage.label(wrong, np.ones((3, 3)))
    if not count:
        return wrong
    depth = np.zeros(target.shape)
    for k in np.unique(target).tolist():
        here = target == k
        if here.all():
            depth[:] = np.inf
        else:
            depth[here] = ndimage.distance_transform_edt(here)[here]
    deepest = np.append(-1.0, ndimage.maximum(depth, groups, np.arange(1, count + 1)))
    return np.asarray((deepest[groups] > slack) | ~beside[found, target])


def _merged(below: SourceMap, above: SourceMap, taken: Array) -> SourceMap:
    """Return `below` with the pixels `taken` from `above`."""
    parts = []
    for name in ("which", "pose"):
        a, b = getattr(below, name), getattr(above, name)
        zero = np.zeros(taken.shape, np.uint8)
        both = np.where(taken, zero if b is None else b, zero if a is None else a).astype(np.uint8)
        parts.append(None if a is None and not both.any() else both)
    yx = np.where(taken[:, :, None], above.yx, below.yx)
    return replace(below, yx=yx, which=parts[0], pose=parts[1])
