"""Growing under labels in two passes: large patches inside the regions, smaller ones along their boundaries."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ..canvas import Canvas
from ..exemplar import Exemplar
from ..sourcemap import Blend, SourceMap
from .growth import Growth, Laying

PASS = 1 << 20  # draws of the second pass are apart from those of the first


def grown(
    laying: Laying,
    exemplars: Sequence[Exemplar],
    canvas: Canvas,
    blend: Blend,
    fill: Callable[[Growth, int, tuple[int, int]], None],
) -> SourceMap:
    """Grow a map; under labels first the inside of regions, then the rest with smaller patches (S0-86).

    `fill` fills a growth, given what to add to the stage of its draws, and which pass it is of how many.
    """
    small = smaller(laying) if canvas.guide is not None and canvas.guide.is_labels else None
    if small is None:
        growth = Growth(laying, exemplars, canvas)
        fill(growth, 0, (0, 1))
        return growth.map(blend)
    growth = Growth(laying, exemplars, canvas, inside_only=True)
    fill(growth, 0, (0, 2))
    smap = growth.map(blend)
    if not smap.holes.any():
        return smap
    growth = Growth(small, exemplars, replace(canvas, start=smap))
    fill(growth, PASS, (1, 2))
    return growth.map(blend)


def smaller(laying: Laying) -> Laying | None:
    """Return how patches are laid along boundaries; None where they are as large as all others."""
    side, least = laying.boundary, min(laying.patch)
    if not side or side >= least:
        return None
    patch = tuple(max(1, round(p * side / least)) for p in laying.patch)
    overlap = tuple(max(min(o, 1), o * side // least) for o in laying.overlap)
    return replace(
        laying, patch=(patch[0], patch[1]), overlap=(overlap[0], overlap[1]), boundary=0, rim=max(overlap)
    )


def boundary_poses(patch: tuple[int, int], asked: str | tuple[int, ...] | None) -> str | tuple[int, ...]:
    """Return the poses of patches on boundaries: those asked for, or all that a patch of this shape can have."""
    if asked is not None:
        return asked
    return "both" if patch[0] == patch[1] else "180"
