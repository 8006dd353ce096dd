"""Growing under labels: large patches inside the regions, smaller ones along their boundaries, strays replaced."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..canvas import Canvas
from ..exemplar import Exemplar
from ..guide import Guide
from ..lazy import lazy
from ..sourcemap import HOLE, Blend, SourceMap
from .growth import Growth
from .settings import PatchSettings

if TYPE_CHECKING:
    from scipy import ndimage

    from ..search import guide as guidance
else:  # only canvases with a guide need them
    ndimage, guidance = lazy("scipy.ndimage"), lazy("intarsia.search.guide")

PASS = 1 << 20  # draws of the second pass are apart from those of the first
SLACK = 2  # strays may lie as far as this part of a patch on the wrong side

Fill = Callable[[Growth, int, tuple[int, int]], None]
Array = NDArray[Any]


def grown(laying: PatchSettings, exemplars: Sequence[Exemplar], canvas: Canvas, blend: Blend, fill: Fill) -> SourceMap:
    """Grow a map; under labels first the inside of regions, then the rest with smaller patches.

    `fill` fills a growth, given what to add to the stage of its draws, and which pass it is of how many.
    """
    guide = canvas.guide
    if guide is None or not guide.is_labels:
        growth = Growth(laying, exemplars, canvas)
        fill(growth, 0, (0, 1))
        return growth.map(blend)
    small = smaller(laying)
    growth = Growth(laying, exemplars, canvas, inside_only=small is not None)
    fill(growth, 0, (0, 3))
    smap = growth.map(blend)
    if small is not None and smap.holes.any():
        growth = Growth(small, exemplars, replace(canvas, start=smap))
        fill(growth, PASS, (1, 3))
        smap = growth.map(blend)
    if laying.slack is None or not guide.weight:
        return smap
    return _without_strays(laying, exemplars, canvas, smap, fill)


def smaller(laying: PatchSettings) -> PatchSettings | None:
    """Return how patches are laid along boundaries; None where they are as large as all others."""
    side, least = laying.boundary, min(laying.patch)
    if not side or side >= least:
        return None
    patch = tuple(max(1, round(p * side / least)) for p in laying.patch)
    overlap = tuple(min(max(min(o, 1), o * side // least), p - 1) for o, p in zip(laying.overlap, patch, strict=True))
    return replace(laying, patch=(patch[0], patch[1]), overlap=(overlap[0], overlap[1]), boundary=0, rim=max(overlap))


def boundary_poses(patch: tuple[int, int], asked: str | tuple[int, ...] | None) -> str | tuple[int, ...]:
    """Return the poses of patches on boundaries: those asked for, or all that a patch of this shape can have."""
    if asked is not None:
        return asked
    return "both" if patch[0] == patch[1] else "180"


def slack_of(patch: tuple[int, int], boundary: int, asked: int | None) -> int:
    """Return how far strays may lie on the wrong side: as asked, or half a patch of the boundary, at least 2 px."""
    return max(2, (boundary or min(patch)) // SLACK) if asked is None else asked


def _without_strays(
    laying: PatchSettings, exemplars: Sequence[Exemplar], canvas: Canvas, smap: SourceMap, fill: Fill
) -> SourceMap:
    """Replace what strayed too far over a boundary, region by region, up to the very boundary of the target.

    Happens where the exemplars show no boundary of that shape, or none at all between two labels. What other
    regions hold is as if outside the canvas; pixels that a start map locks are not touched.
    """
    assert canvas.guide is not None
    target = guidance.numbered(canvas.guide.target, canvas.guide.names)
    found = shown_labels(smap, canvas.guide)
    stray = strays(found, target, laying.slack or 0, neighbours(canvas.guide))
    free = np.ones(target.shape, bool) if canvas.start is None else canvas.start.holes
    stray &= free
    for k in np.unique(target[stray]).tolist():
        here = target == k
        start = _only(smap, here & (found == k))
        plane = replace(canvas.guide.target, pixels=np.full_like(canvas.guide.target.pixels, canvas.guide.names[k]))
        inner = replace(canvas, start=start, guide=replace(canvas.guide, target=plane))
        growth = Growth(replace(laying, boundary_isometries="none"), exemplars, inner, wanted=stray & here)
        fill(growth, 2 * PASS + k, (2, 3))
        smap = _merged(smap, growth.map(smap.blend), free & here & (stray | (found == k)))
    return smap


def shown_labels(smap: SourceMap, guide: Guide) -> Array:
    """Return the number of the label that every output pixel has where it comes from; -1 in holes."""
    out = np.full(smap.yx.shape[:2], -1, np.int16)
    which = np.zeros(out.shape, np.uint8) if smap.which is None else smap.which
    for n, source in enumerate(guide.sources):
        mine = which == n
        yx = smap.yx[mine]
        out[mine] = guidance.numbered(source, guide.names)[yx[:, 0], yx[:, 1]]
    return out


def neighbours(guide: Guide) -> Array:
    """Return which pairs of labels lie side by side beside the exemplars: (K + 1, K + 1), True for a label alone."""
    size = len(guide.names) + 1
    out = np.eye(size, dtype=bool)
    for source in guide.sources:
        ids = guidance.numbered(source, guide.names)
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


def _only(smap: SourceMap, kept: Array) -> SourceMap:
    which = np.zeros(kept.shape, np.uint8) if smap.which is None else smap.which
    return replace(smap, which=np.where(kept, which, HOLE).astype(np.uint8))


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
