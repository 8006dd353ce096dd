"""Draw a map: every pixel is a vote of the pieces within the feather around it; without one, an exact copy.

    out(p) = sum over taps of w E(u) / sum w,   q = p + tap,   u = S(q) + J(q) (p - q),   w = t(u)

Taps run from -(f // 2) to (f + 1) // 2 on each axis; t(u) = min(1, d(u) / ((f + 1) // 2 + 1)), d the
chessboard distance from u to the nearest pixel that is unusable or outside the exemplar. The work is done in
cells, boxes of the output that know their surroundings within the feather; a cell never depends on how the
canvas was cut. `grow` and `shrink` are how many times a plane is larger or smaller than the map, else 1. A finish
comes last, of a picture that reaches as far beyond the window as the finish does. Maps whose pieces are turned or
scaled, or lie between pixels, are drawn by warped.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array, Int32, UInt8
from ..blend import Blend, Mixing
from ..errors import InputError, ParameterError, said
from ..exemplar import Exemplars
from ..geometry import Box
from ..image import Kind, Plane
from ..lazy import lazy
from ..run import Run
from ..sourcemap import SourceMap, check_stretch
from .colour import Curve
from .ground import cut_out_map, enlarged, ground_of, refuse_holes, usable_pixels
from .mixing import Mixer, NormalCoding, coding_of, mixer_of
from .vote_kernels import Map, VotedExemplars, copy_cell, make_plan

if TYPE_CHECKING:
    from . import finish, warped
else:  # what few pictures need
    finish, warped = lazy("intarsia.rendering.finish"), lazy("intarsia.rendering.warped")

MAX_SPREAD = 2000
"""The widest feather in px of a plane; weights and sums of 64 bits hold no more."""

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
        Without holes where it is drawn, and within the reach of a finish.
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
        Of the dtype, kind, transfer and meta of the exemplar's.

    Raises
    ------
    ParameterError
        for an unknown plane, a window outside the canvas, or sides that a smaller plane does not divide.
    InputError
        for holes, and for exemplars that do not fit the map or one another.
    """
    blend, run = blend or smap.blend, run or Run()
    _check_exemplars(exemplars, smap)
    planes, scale = _planes(exemplars, name)
    box = box or Box(0, 0, smap.height, smap.width)
    job = (_Job if smap.exact else warped.Warped).of(exemplars, planes, scale, smap, blend)
    shrink = max(-scale, 1)
    check_stretch(box.y0, box.y1, smap.height, smap.wrap.y, "rows")
    check_stretch(box.x0, box.x1, smap.width, smap.wrap.x, "columns")
    if any(v % shrink for v in (box.y0, box.x0, box.height, box.width, smap.height, smap.width)):
        raise ParameterError(
            f"{box.width}x{box.height} px do not suit a plane {shrink}x smaller; give multiples of {shrink}."
        )
    if not blend.finish or planes[0].kind in (Kind.NORMAL, Kind.LABEL):
        return planes[0].like(_draw_box(job, box, smap, shrink, run))
    assert isinstance(job, _Job)  # the others have no finish
    usable = usable_pixels(exemplars, job.scale)
    bench = finish.Bench(job.samples, job.ground.table, usable, planes[0].alpha, job.full, job.wrap, job.scale)
    codes = bench.finished(lambda wide: _draw_box(job, wide, smap, 1, run), box, blend.finish, run)
    if shrink > 1:
        step = _ROWS * shrink
        bands = [job.mixer.average(codes[y : y + step], shrink) for y in range(0, box.height, step)]
        codes = np.concatenate(bands)
    return planes[0].like(codes)


def _draw_box(job: _Job | warped.Warped, box: Box, smap: SourceMap, shrink: int, run: Run) -> Array:
    """Draw a box of the map; smaller planes are averaged at once."""
    grow = job.scale
    rows, columns = _stretches(box.y0, box.y1, smap.height), _stretches(box.x0, box.x1, smap.width)
    samples = job.samples
    out = np.zeros((box.height * grow // shrink, box.width * grow // shrink, samples.shape[1]), samples.dtype)
    cells = [
        (y * grow, x * grow, ty * grow // shrink, tx * grow // shrink, h * grow, w * grow)
        for y, ty, h in _cell_sides(rows, max(_ROWS, job.feather) // grow, shrink)
        for x, tx, w in _cell_sides(columns, max(_COLUMNS, job.feather) // grow, shrink)
    ]

    def draw(cell: tuple[int, int, int, int, int, int]) -> None:
        y, x, ty, tx, h, w = cell
        codes = job.draw(y, x, h, w)
        if shrink > 1:
            codes = job.mixer.average(codes, shrink)
        out[ty : ty + codes.shape[0], tx : tx + codes.shape[1]] = codes

    with run.pool() as each:
        batch = 8 * run.workers
        for start in range(0, len(cells), batch):
            each(draw, cells[start : start + batch])
            run.tick(min(start + batch, len(cells)), len(cells))
    return out


@dataclass(frozen=True)
class _Job:
    """All that a cell needs to be drawn."""

    full: Map
    wrap: tuple[bool, bool]
    scale: int
    feather: int  # in px of the plane
    ground: VotedExemplars
    samples: Array  # (N, C) codes of all exemplars
    mixer: Mixer
    coding: NormalCoding | None

    @classmethod
    def of(cls, exemplars: Exemplars, planes: list[Plane], scale: int, smap: SourceMap, blend: Blend) -> _Job:
        grow, shrink = max(scale, 1), max(-scale, 1)
        feather = blend.feather * grow
        check_spread(blend.feather, grow, f"a {grow}x larger plane")
        samples, ground = ground_of(exemplars, [enlarged(p.samples, shrink) for p in planes], grow, feather)
        none = np.zeros(smap.yx.shape[:2] if smap.which is None or smap.pose is None else (0, 0), np.uint8)
        none.flags.writeable = False
        coding = coding_of(planes)
        usable = usable_pixels(exemplars, grow) if blend.mixing is Mixing.VARIANCE else None
        curve = Curve.of(planes[0], blend.mixing)
        return cls(
            (smap.yx, none if smap.which is None else smap.which, none if smap.pose is None else smap.pose),
            (smap.wrap.y, smap.wrap.x), grow, feather, ground, samples,
            mixer_of(planes[0], samples, coding, curve, blend.mixing, usable), coding,
        )  # fmt: skip

    def draw(self, y: int, x: int, height: int, width: int) -> Array:
        """Return the codes (h, w, C) of a cell whose first pixel is (y, x)."""
        f = self.feather
        if f == 0 and self.scale == 1 and self.coding is None:
            here = slice(y, y + height), slice(x, x + width)
            codes, whole = self._copies(self.full[0][here], self.full[1][here])
            if whole:
                return codes
        origin = (y - f // 2, x - f // 2)
        box = Box(*origin, origin[0] + height + f, origin[1] + width + f)
        part = cut_out_map(self.full, box, self.scale, self.wrap, self.ground.table)
        core = (slice(f // 2, f // 2 + height), slice(f // 2, f // 2 + width))
        refuse_holes(part[1][core], self.full[1])
        if f == 0:
            return self._own(*part)
        codes, weight = self.mixer.vote(make_plan(part, origin, self.ground.table, f), self.ground)
        lost = weight == 0  # nobody votes: the pixel speaks for itself
        if lost.any():
            codes[lost] = self._own(part[0][core], part[1][core], part[2][core])[lost]
        return codes

    def _copies(self, yx: Int32, which: UInt8) -> tuple[Array, bool]:
        """The codes of exemplar pixels, and whether all of these are there."""
        codes = np.empty((*which.shape, self.samples.shape[1]), self.samples.dtype)
        bits = np.dtype(f"u{self.samples.itemsize}")  # whatever the dtype, copy bits
        return codes, copy_cell(yx, which, self.ground.table, self.samples.view(bits), codes.view(bits))

    def _own(self, yx: Int32, which: UInt8, pose: UInt8) -> Array:
        codes, _ = self._copies(np.ascontiguousarray(yx), np.ascontiguousarray(which))
        return codes if self.coding is None else self.coding.turned(codes, pose)


def _check_exemplars(exemplars: Exemplars, smap: SourceMap) -> None:
    if not exemplars or (smap.sources and len(smap.sources) != len(exemplars)):
        raise InputError(
            f"the map has {max(len(smap.sources), 1)} exemplars, {len(exemplars)} are given; give its own."
        )
    for exemplar, source in zip(exemplars, smap.sources, strict=False):
        if (exemplar.height, exemplar.width) != (source.height, source.width):
            raise InputError(
                f"{exemplar.name} is {exemplar.width}x{exemplar.height} px, the map wants {source.name} of "
                f"{source.width}x{source.height}; give the exemplars that it was made of."
            )


def check_alike(exemplars: Exemplars) -> None:
    """Refuse exemplars whose planes cannot lie in one picture, before any work on them."""
    for name in (*exemplars[0].drawn, *exemplars[0].packs):
        _planes(exemplars, name)


def check_drawable(exemplars: Exemplars, height: int, width: int, feather: int) -> None:
    """Refuse what a plane of another size than the base cannot be drawn with, before anything is grown.

    `height` and `width` are those of the map, or of a window of it; `feather` is that of the map, in px.
    """
    for name in exemplars[0].pictures:
        _, scale = _planes(exemplars, name)
        if scale < 0 and (height % -scale or width % -scale):
            raise ParameterError(
                f"{width}x{height} px do not suit the plane {name}, {-scale}x smaller; give multiples of {-scale}."
            )
        check_spread(feather, scale, f"the plane {name}, {scale}x larger")


def check_spread(feather: int, grow: int, plane: str) -> None:
    """Refuse a feather that is too wide on a plane so many times larger than the map."""
    if feather * max(grow, 1) > MAX_SPREAD:
        most = MAX_SPREAD // grow
        raise ParameterError(f"feather={feather} is too wide on {plane}; at most {most} px.")


def _planes(exemplars: Exemplars, name: str | None) -> tuple[list[Plane], int]:
    """Find the plane in every exemplar, and how many times larger than the base (negative: smaller)."""
    name = exemplars[0].pictures[0] if name is None else name
    if not isinstance(name, str) or exemplars[0].picture(name) is None:
        known = dict.fromkeys((*exemplars[0].drawn, *exemplars[0].packs))
        raise ParameterError(f"plane={said(name)} is unknown; choose one of {', '.join(known)}.")
    found: list[tuple[Plane, int]] = []
    for exemplar in exemplars:
        plane = exemplar.picture(name)
        if plane is None:
            raise InputError(f"{exemplar.name} has no plane {name}, {exemplars[0].name} has; give it one.")
        larger = plane.height >= exemplar.height
        found.append((plane, plane.height // exemplar.height if larger else -(exemplar.height // plane.height)))
        if _facts_of(*found[-1]) != _facts_of(*found[0]):
            raise InputError(
                f"the plane {name} of {exemplar.name} differs from that of {exemplars[0].name} in type, "
                "channels, kind, transfer or scale; make them equal."
            )
    return [plane for plane, _ in found], found[0][1]


def _facts_of(plane: Plane, scale: int) -> tuple[object, ...]:
    green = plane.meta.get("normals", "gl") if plane.kind is Kind.NORMAL else ""
    return plane.pixels.dtype, plane.channels, plane.kind, plane.transfer, scale, green


def _stretches(start: int, stop: int, length: int) -> list[tuple[int, int, int]]:
    """Cut a stretch of an endless axis at the canvas's borders: (first on canvas, first drawn, length)."""
    cuts = [start, *range(start - start % length + length, stop, length), stop]
    return [(a % length, a - start, b - a) for a, b in pairwise(cuts)]


def _cell_sides(stretches: list[tuple[int, int, int]], step: int, multiple: int) -> list[tuple[int, int, int]]:
    step = max(step // multiple, 1) * multiple
    return [(y + i, t + i, min(step, n - i)) for y, t, n in stretches for i in range(0, n, step)]
