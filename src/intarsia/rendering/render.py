"""Render a map: each pixel is a weighted blend of the pieces within the feather around it; without one, an exact copy.

    out(p) = sum over taps of w E(u) / sum w,   q = p + tap,   u = S(q) + J(q) (p - q),   w = t(u)

Taps run from -(f // 2) to (f + 1) // 2 on each axis; t(u) = min(1, d(u) / ((f + 1) // 2 + 1)), d the
chessboard distance from u to the nearest pixel that is unusable or outside the exemplar. The output is rendered in
cells, boxes that are cut out of the map with a margin of the feather; no cell depends on how the canvas is divided.
`grow` and `shrink`: how many times a plane is larger or smaller than the map, else 1. Tone correction comes last.
If a map has frames or fractions of px, exemplar pixels are interpolated (`warped_kernels`).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..foundation import InputError, ParameterError, lazy, said
from ..foundation.arrays import Array
from ..foundation.blend import Blend
from ..foundation.geometry import Box
from ..foundation.run import Run
from ..model import Exemplars
from ..model.image import Kind, Plane
from ..model.sourcemap import SourceMap, check_stretch
from . import SourceAtlas
from .blending import Mixer, Normals, mixer_of
from .vote_kernels import copy_cell, group_votes

if TYPE_CHECKING:
    from . import seam_levelling, warped_kernels
else:  # what few pictures use
    seam_levelling, warped_kernels = (
        lazy("intarsia.rendering.seam_levelling"),
        lazy("intarsia.rendering.warped_kernels"),
    )

MAX_SPREAD = 2000
"""The widest feather in px of a plane; weights and sums fit into 64 bits up to it."""

_ROWS, _COLUMNS = 64, 1024  # of a cell; about 40 bytes of sums a pixel


def render(
    exemplars: Exemplars, smap: SourceMap, name: str | None = None, blend: Blend | None = None,
    box: Box | None = None, run: Run | None = None,
) -> Plane:  # fmt: skip
    """Draw a plane of a map.

    Parameters
    ----------
    exemplars : sequence of Exemplar
        In the order of their numbers in the map.
    smap : SourceMap
        Without holes where it is drawn.
    name : str, optional
        The plane, or the packed map; the first of the first exemplar by default. A plane s times larger than the
        base gives a picture s times larger than the map, with a feather of s times as many px; one s times
        smaller gives one s times smaller, averaged in blocks.
    blend : Blend, optional
        Feather, mixing and finish; those of the map by default.
    box : Box, optional
        The window to draw, in px of the map; along wrapped axes it may lie anywhere. All by default.
    run : Run, optional
        Threads, progress, cancelling.

    Returns
    -------
    Plane
        With the dtype, kind, transfer and meta of the exemplars' planes.

    Raises
    ------
    ParameterError
        for an unknown plane, a window outside the canvas, or sides that a smaller plane does not divide.
    InputError
        for holes, and for exemplars that do not fit the map or one another.
    """
    blend, run = blend or smap.blend, run or Run()
    check_exemplars(exemplars, smap)
    planes, scale = _planes(exemplars, name)
    box = box or Box(0, 0, smap.height, smap.width)
    grow = max(scale, 1)
    if smap.exact:
        check_spread(blend.feather, grow, f"on a {grow}x larger plane")
    else:
        check_blend(blend, planes[0].kind)
    ground = SourceAtlas.of(exemplars, planes, scale, smap, blend.feather * grow)
    job = _Job(ground, blend.feather * grow, mixer_of(planes, ground.samples, blend))
    shrink = max(-scale, 1)
    check_stretch(box.y0, box.y1, smap.height, smap.wrap.y, "rows")
    check_stretch(box.x0, box.x1, smap.width, smap.wrap.x, "columns")
    if any(v % shrink for v in (box.y0, box.x0, box.height, box.width, smap.height, smap.width)):
        raise ParameterError(
            f"{box.width}x{box.height} px do not suit a plane {shrink}x smaller; give multiples of {shrink}."
        )
    if not blend.finish or planes[0].kind in (Kind.NORMAL, Kind.LABEL):
        return planes[0].like(_draw_box(job, box, shrink, run))
    codes = seam_levelling.tone_corrected(
        lambda wide: _draw_box(job, wide, 1, run), ground, planes[0].alpha, box, blend.finish, run
    )
    if shrink > 1:
        step = _ROWS * shrink
        bands = [job.mixer.average(codes[y : y + step], shrink) for y in range(0, box.height, step)]
        codes = np.concatenate(bands)
    return planes[0].like(codes)


def _draw_box(job: _Job, box: Box, shrink: int, run: Run) -> Array:
    """Return the codes of a box of the map, cell by cell; smaller planes are averaged in each cell."""
    grow, smap, samples = job.ground.scale, job.ground.smap, job.ground.samples
    out = np.zeros((box.height * grow // shrink, box.width * grow // shrink, samples.shape[1]), samples.dtype)
    cells = [
        (row, column)
        for row in _cell_sides(box.y0, box.y1, smap.height, max(_ROWS, job.feather) // grow, shrink)
        for column in _cell_sides(box.x0, box.x1, smap.width, max(_COLUMNS, job.feather) // grow, shrink)
    ]

    def draw(cell: tuple[_Side, _Side]) -> None:
        (y, ty, h), (x, tx, w) = cell
        codes = job.draw(y * grow, x * grow, h * grow, w * grow)
        if shrink > 1:
            codes = job.mixer.average(codes, shrink)
        top, left = ty * grow // shrink, tx * grow // shrink
        out[top : top + codes.shape[0], left : left + codes.shape[1]] = codes

    with run.pool() as each:
        batch = 8 * run.workers
        for start in range(0, len(cells), batch):
            each(draw, cells[start : start + batch])
            run.tick(min(start + batch, len(cells)), len(cells))
    return out


@dataclass(frozen=True)
class _Job:
    """The source atlas, the feather and the mixer that cells are rendered with."""

    ground: SourceAtlas
    feather: int  # in px of the plane
    mixer: Mixer

    def draw(self, y: int, x: int, height: int, width: int) -> Array:
        """Return the codes (h, w, C) of a cell whose first pixel is (y, x)."""
        f, ground = self.feather, self.ground
        if f == 0 and ground.scale == 1 and ground.smap.exact and not isinstance(self.mixer, Normals):
            here = slice(y, y + height), slice(x, x + width)
            codes, whole = self._copies(ground.full[0][here], ground.full[1][here])
            if whole:
                return codes
        origin = (y - f // 2, x - f // 2)
        part = ground.cut(Box(*origin, origin[0] + height + f, origin[1] + width + f))
        core = (slice(f // 2, f // 2 + height), slice(f // 2, f // 2 + width))
        ground.refuse_holes(part[1][core])
        if f == 0:
            return self._own(part)
        codes, weight = self.mixer.vote(group_votes(part, origin, ground.reach.table, f), ground.reach)
        lost = weight == 0  # no votes: the pixel's own source is copied
        if lost.any():
            codes[lost] = self._own(tuple(np.ascontiguousarray(a[core]) for a in part))[lost]
        return codes

    def _own(self, part: tuple[Array, ...]) -> Array:
        """Return the codes of every pixel's own source."""
        if not self.ground.smap.exact:
            return self.mixer.read(warped_kernels.Part(*part), self.ground.reach)
        codes, _ = self._copies(part[0], part[1])
        return self.mixer.coding.turned(codes, part[2]) if isinstance(self.mixer, Normals) else codes

    def _copies(self, yx: Array, which: Array) -> tuple[Array, bool]:
        """Return the codes of exemplar pixels, and whether all of these exist."""
        samples = self.ground.samples
        codes = np.empty((*which.shape, samples.shape[1]), samples.dtype)
        bits = np.dtype(f"u{samples.itemsize}")  # copied as bits, of any dtype
        return codes, copy_cell(yx, which, self.ground.reach.table, samples.view(bits), codes.view(bits))


def check_exemplars(exemplars: Exemplars, smap: SourceMap) -> None:
    """Raise InputError if exemplars differ from those of a map in number or size."""
    if not exemplars or (smap.sources and len(smap.sources) != len(exemplars)):
        raise InputError(
            f"the map has {max(len(smap.sources), 1)} exemplars, {len(exemplars)} are given; give its own."
        )
    for exemplar, source in zip(exemplars, smap.sources, strict=False):
        if (exemplar.height, exemplar.width) != (source.height, source.width):
            raise InputError(
                f"{exemplar.name} is {exemplar.width}x{exemplar.height} px, the map wants {source.name} of "
                f"{source.width}x{source.height}; give its own, cropped and scaled as they were."
            )


def check_alike(exemplars: Exemplars) -> None:
    """Raise InputError if the planes of exemplars cannot be drawn in one picture."""
    for name in (*exemplars[0].drawn, *exemplars[0].packs):
        _planes(exemplars, name)


def check_drawable(exemplars: Exemplars, height: int, width: int, feather: int) -> None:
    """Raise ParameterError if a plane of another size than the base cannot be drawn at this size and feather.

    `height` and `width` are those of the map, or of a window of it; `feather` is that of the map, in px.
    """
    for name in exemplars[0].pictures:
        _, scale = _planes(exemplars, name)
        if scale < 0 and (height % -scale or width % -scale):
            raise ParameterError(
                f"{width}x{height} px do not suit the plane {name}, {-scale}x smaller; give multiples of {-scale}."
            )
        check_spread(feather, scale, f"on the plane {name}, {scale}x larger")


def check_spread(feather: int, grow: int, where: str) -> None:
    """Raise ParameterError if a feather is too wide on a plane `grow` times larger than the map."""
    grow = max(grow, 1)
    if feather * grow > MAX_SPREAD:
        raise ParameterError(f"feather={feather} is too wide {where}; give at most {MAX_SPREAD // grow} px.")


def check_blend(blend: Blend, kind: Kind = Kind.COLOUR) -> None:
    """Raise ParameterError if interpolated pixels have no such blend."""
    reason = "pieces of this map are turned, scaled or moved by fractions of a pixel"
    if blend.feather:
        raise ParameterError(f"{reason}, and a feather joins whole pixels only; draw it without (--feather 0).")
    if blend.finish and kind not in (Kind.NORMAL, Kind.LABEL):
        raise ParameterError(f"{reason}, and levelling compares whole pixels only; draw it without (--even-tone 0).")


def _planes(exemplars: Exemplars, name: str | None) -> tuple[list[Plane], int]:
    """Return the plane of every exemplar, and how many times it is larger than the base (negative: smaller).

    Raise ParameterError if it is unknown, InputError if it is missing or differs between exemplars.
    """
    name = exemplars[0].pictures[0] if name is None else name
    if not isinstance(name, str) or exemplars[0].picture(name) is None:
        known = dict.fromkeys((*exemplars[0].drawn, *exemplars[0].packs))
        raise ParameterError(f"plane={said(name)} is unknown; choose one of {', '.join(known)}.")
    found, facts = [], []
    for exemplar in exemplars:
        plane = exemplar.picture(name)
        if plane is None:
            raise InputError(f"{exemplar.name} has no plane {name}, {exemplars[0].name} has; give it one.")
        larger = plane.height >= exemplar.height
        scale = plane.height // exemplar.height if larger else -(exemplar.height // plane.height)
        green = plane.kind is Kind.NORMAL and plane.meta.get("normals", "gl")
        facts.append((plane.pixels.dtype, plane.channels, plane.kind, plane.transfer, scale, green))
        found.append(plane)
        if facts[-1] != facts[0]:
            raise InputError(
                f"the plane {name} of {exemplar.name} differs from that of {exemplars[0].name} in type, "
                "channels, kind, transfer or scale; make them equal."
            )
    return found, facts[0][4]


_Side = tuple[int, int, int]
"""Side of a cell, in px of the map: its first px on the canvas, its first px in the picture, its length."""


def _cell_sides(start: int, stop: int, length: int, step: int, multiple: int) -> list[_Side]:
    """Divide start .. stop of an axis at the canvas's borders, and these stretches into cells of about `step` px.

    Lengths of cells are multiples of `multiple`, but for the last one of a stretch.
    """
    cuts = [start, *range(start - start % length + length, stop, length), stop]
    stretches = [(a % length, a - start, b - a) for a, b in pairwise(cuts)]
    step = max(step // multiple, 1) * multiple
    return [(y + i, t + i, min(step, n - i)) for y, t, n in stretches for i in range(0, n, step)]
