"""Measurements of exemplar and canvas that the rules of automatic choice use, their report in words, and warnings.

Each measurement is made when a rule asks for it.

Source: no single paper. docs/design/000-architecture.md lists which measurement each rule uses. Whatever a rule
compares is computed from sums of integers, so that the same rule fires on every machine.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..analysis import block_sums, blocks
from ..analysis.elements import ElementSize
from ..analysis.features import Features, course_lines, features, outlines
from ..analysis.illumination import Illumination, illumination_of
from ..analysis.oriented_energy import CourseLines
from ..analysis.structure import edge_coherence
from ..foundation import lazy
from ..foundation.arrays import Int16
from ..foundation.geometry import UNIT
from ..foundation.run import Run, run_of
from ..lattice import cell_of, lattices_of, vectors_of
from ..lattice.decision import Lattice, Lattices, lattice_by_chance_test
from ..model import Exemplar, Exemplars, sampled
from ..model.canvas import Canvas
from ..model.image import Kind
from ..regular.rectify import Rectification, rectified_if_better
from ..search import elements

if TYPE_CHECKING:
    from ..regular import block_grid, tile_search, unequal_courses, wall
else:  # most exemplars need some of them, few need all
    block_grid, tile_search = lazy("intarsia.regular.block_grid"), lazy("intarsia.regular.tile_search")
    unequal_courses, wall = lazy("intarsia.regular.unequal_courses"), lazy("intarsia.regular.wall")

WORK_SIDE = 512  # px: of larger exemplars coherence, outlines and light are those of a reduced copy
COMPARED = 1024  # px: least side of the square in the middle in which periods are compared, which takes at most 8 s
SAMPLED = 1 << 18  # px, about, in which colours are counted, which takes a few ms


# Thresholds of what is detected; each was halved and doubled on 92 textures (docs/design/012).
# A lattice is loose if it repeats less than PARTLY of the exemplar and its points are missed by LOOSE px (rms) or more.
PARTLY = 0.6  # with 0.4 roof scales and pavers count as a lattice and are cut, with 0.9 three lattices are lost
LOOSE = 1.0  # with 0.5 the same textures are loose, with 2 roof scales and pavers count as a lattice and are cut
# An exemplar is ordered if a 1-D lattice has ROWS rows that match, and by HINT better than what lies between them.
ROWS = 3  # with 2 clouds and a manhole cover are ordered, too; with 6 six textures no longer are
HINT = 0.045  # with half the number the same textures are ordered, with double six no longer are
BRICKS = 0.5  # share of courses that must be whole bricks; seven textures of courses have 0.62 and more, text 0.28
ALONG = 0.1  # of the pitch of rows: tolerance for vectors along rows or to the next one; 0 to 0.4 give the same


# Thresholds of the rules. Set by eye on 27 photographs without a lattice and 21 with one. Each was halved and doubled
# on 92 textures, 44 of which were not used when it was set (docs/design/012).
ONE_PICTURE = 0.15  # periods whose `variation` is less count as equal; half: not those of a roof, double: three more
# Least `outlines` of a texture of outlined elements. Of 30 photographs with more, graph cuts looked better in 9 and
# corrections pixel by pixel (a rule that is gone) in 4; with less in 4 and 11.
OUTLINED = 0.88
JOINTED = 0.6  # largest `joints` of clear joints; 0.3: two walls of tiles are graph-cut, 0.7: three more are blocks
# Evenness of graph cuts with a lattice, where threads and joints must meet; of 24 outputs with 0.25 people preferred 7,
# and 17 with 0.1.
STEPPED = 0.1
ACROSS = 3.0  # elements along the shorter side; fewer give a warning; half: 24 textures fewer have it, double: 23 more
PERIODS = 2.0  # periods, below which there is a warning: 1 of 16 such lattices was right, below 3 periods 4 of 12
LEAST_SIDE = 32  # px: shorter side, below which there is a warning; with half and double the same textures have it


def _middle(shape: tuple[int, ...], side: int) -> tuple[slice, slice]:
    """Return the slices of the middle of a picture, at most `side` px a side."""
    rows, columns = (slice(max(0, n - side) // 2, max(0, n - side) // 2 + side) for n in shape[:2])
    return rows, columns


def _loose(found: Lattice) -> bool:
    """Whether elements follow a lattice only loosely (PARTLY, LOOSE), so that whole periods do not fit each other."""
    return found.repeats < PARTLY and found.residual >= LOOSE


def _holds_rows(two: Lattice, rows: Lattice) -> bool:
    """Whether a sure 2-D lattice has one vector from row to row of a 1-D lattice, and the other along the rows.

    1-D lattices often have a higher confidence, as more periods are seen; but periods along the rows must be kept.
    """
    if two.kind == "1-D" or two.verdict != "sure" or _loose(two):
        return False
    ((y, x),) = rows.vectors
    steps = sorted(abs(v * y + u * x) / (y * y + x * x) for v, u in two.vectors)
    return steps[0] < ALONG and abs(steps[1] - 1) < ALONG


class Facts:
    """Measurements of the first exemplar with usable pixels, and of the canvas; each is made when it is asked for."""

    def __init__(self, exemplars: Exemplars, canvas: Canvas, run: Run | None = None) -> None:
        self.exemplars, self.canvas, self.run = tuple(exemplars), canvas, run_of(run)
        self.exemplar = sampled(exemplars)[0]

    @property
    def side(self) -> int:
        """The shorter side of the exemplar, px."""
        return min(self.exemplar.shape)

    @cached_property
    def picture(self) -> Int16:
        """The exemplar in feature space (H, W, C), as methods compare it."""
        return features([self.exemplar]).pictures[0]

    @cached_property
    def constant(self) -> bool:
        """Whether all usable pixels have one colour."""
        seen = self.picture if self.exemplar.usable is None else self.picture[self.exemplar.usable]
        seen = seen.reshape(-1, self.picture.shape[2])
        few = seen[:: max(1, len(seen) // SAMPLED)]
        return not len(seen) or bool((few == seen[:1]).all() and (seen == seen[:1]).all())

    @cached_property
    def lattices(self) -> Lattices:
        """The lattices found in it."""
        return lattices_of(self.exemplar)

    @cached_property
    def two(self) -> Lattice | None:
        """The 2-D lattice that methods may use; None if there is none, or it is loose."""
        found = self.lattices.accepted
        if found is None or found.kind == "2-D":
            return None if found is None or _loose(found) else found
        return next((one for one in self.lattices.ranked if _holds_rows(one, found)), None)

    @cached_property
    def lattice(self) -> Lattice | None:
        """The lattice that methods may use: 2-D rather than 1-D; None if there is none.

        A 1-D lattice counts only if its rows are courses of bricks: lines of text would be cut by it.
        """
        found = self.lattices.accepted
        rows = found is not None and found.kind == "1-D" and self.two is None
        return found if found is not None and rows and self._laid(found) else self.two

    @property
    def about(self) -> Lattice | None:
        """The lattice that elements follow at least loosely, sure enough to align patches of free shape to it.

        The 2-D `lattice`, or a loose 2-D one; a 1-D lattice whose rows are no courses of bricks, such as lines of text
        or boards; or, without an accepted lattice, one whose low peaks pass the chance test.
        """
        known = self.lattice or self.lattices.accepted
        if known is None:
            return lattice_by_chance_test(self.lattices.ranked)
        return known if known.kind == "2-D" or self.lattice is None else None

    @property
    def ordered(self) -> bool:
        """Whether its elements lie in rows or loosely on a lattice, without a lattice that methods may use."""
        rows = (one for one in self.lattices.ranked if one.kind == "1-D" and one.points >= ROWS)
        loose = self.lattices.accepted is not None or any(one.contrast >= HINT for one in rows)
        return self.lattice is None and loose

    @cached_property
    def straight(self) -> tuple[Rectification, Lattice] | None:
        """The rectification of its courses and the lattice that they then have, if its confidence is much higher.

        With several threads, the measurements that nearly every exemplar needs are made in parallel first.
        """
        if self.run.workers > 1:
            with self.run.pool() as each:
                each(lambda name: getattr(self, name), ("lattices", "courses", "element"))
        return rectified_if_better(self.exemplar)

    @cached_property
    def variation(self) -> float:
        """Mean difference between its periods: 0 if they are equal, 1 as unrelated places; 1 without a 2-D lattice."""
        if self.two is None:
            return 1.0
        free = self.exemplar.free
        longest = max(abs(n) for v in self.two.vectors for n in v) // UNIT
        part = _middle(self.picture.shape, max(COMPARED, 4 * longest))
        if not free[part].any():
            part = _middle(self.picture.shape, max(self.picture.shape))
        seen = np.ascontiguousarray(self.picture[part])
        return tile_search.period_difference(seen, self.two.vectors, free[part].copy())

    @cached_property
    def joints(self) -> float:
        """Cost of cuts along joints between periods, relative to cuts anywhere, 0 to 1; 1 without a 2-D lattice."""
        if self.two is None:
            return 1.0
        return block_grid.joint_contrast(self.picture, cell_of(vectors_of(self.two), self.picture.shape))

    @cached_property
    def element(self) -> ElementSize:
        """The size of its elements, from its autocorrelation."""
        return elements(self.exemplar)

    @cached_property
    def reduction(self) -> int:
        """The whole factor by which the copy is reduced on which the slower measurements are made."""
        return max(1, -(-max(self.exemplar.shape) // WORK_SIDE))

    @cached_property
    def small(self) -> Exemplar:
        """That copy; the exemplar itself if it is small enough."""
        n, e = self.reduction, self.exemplar
        if n == 1 or min(e.shape) < 8 * n:
            return e
        planes = {}
        for name, plane in e.planes.items():
            if plane.shape == e.shape:
                if plane.kind is Kind.LABEL or plane.is_float:
                    planes[name] = plane.like(blocks(plane.samples, n)[:, 0, :, 0])
                else:
                    planes[name] = plane.like((block_sums(plane.samples, n) // (n * n)).astype(plane.pixels.dtype))
        usable = None if e.usable is None else np.asarray(blocks(e.usable, n).all(axis=(1, 3)))
        weights = {name: weight for name, weight in e.weights.items() if name in planes}
        counted = any(weights.get(name, 1.0) for name in planes)  # else all that counts is left out here
        return Exemplar(planes, usable, e.toroidal, e.name, weights if counted else {})

    @cached_property
    def _seen(self) -> Features:
        return features([self.small])

    @cached_property
    def coherence(self) -> float:
        """How far all edges have one direction, 0 to 1."""
        return edge_coherence(self._seen.pictures[0], self.small.usable)

    @cached_property
    def outlines(self) -> float:
        """How much the strongest oriented filter response exceeds the mean of all directions, relative to that mean."""
        return outlines(self._seen, [self.small])[0].share

    @cached_property
    def courses(self) -> CourseLines | None:
        """The lines between its courses (bed joints), in px of the exemplar; None if it has none."""
        return course_lines(features([self.exemplar]), self.exemplar)

    @cached_property
    def masonry(self) -> unequal_courses.UnequalMasonry | None:
        """Its courses of unequal heights, if their stones are clear enough to be placed one by one; else None."""
        return unequal_courses.clear_masonry(self.exemplar)

    def _laid(self, rows: Lattice) -> bool:
        """Whether the rows of a 1-D lattice are courses of which bricks between head joints fill at least half."""
        return wall.brick_share(vectors_of(rows), self.exemplar) >= BRICKS

    @cached_property
    def light(self) -> Illumination:
        """Its illumination gradient."""
        apart = float(self.element.size)
        if self.two is not None:
            (p, q), (r, s) = self.two.vectors
            apart = min(apart, math.sqrt(abs(p * s - q * r)) / UNIT)
        return illumination_of(self.small, apart / self.reduction)

    @property
    def across(self) -> float:
        """The number of elements along the shorter side."""
        return self.side / max(self.element.size, 1)


def measurements(f: Facts) -> dict[str, str]:
    """Return what the rules and the warnings look at, by name, in words."""
    e, light, varied = f.element, f.light, "no periods to compare"
    if f.two is not None:
        differ, joints = f"periods differ by {100 * f.variation:.0f} % of the contrast", f"{f.joints:.2f} of others"
        varied = f"{differ}; cuts in joints cost {joints}"
    kept = "joints or lines that must be kept" if f.outlines >= OUTLINED else "no outline that must be kept"
    size = f"about {e.size} px ({e.width} wide, {e.height} high), {f.across:.1f} of them across"
    return {
        "lattice": _lattice(f),
        "variation": varied,
        "elements": size if e.found else f"not seen; {e.size} px is a guess",
        "outlines": f"along outlines filters answer by {f.outlines:.2f} of the mean more: {kept}",
        "courses": "no lines across it that part courses" if f.courses is None else f.courses.told,
        "light": f"a slope, {light.factor:.1f} times brighter on one side" if light.strong else "no strong slope",
    }


def _lattice(f: Facts) -> str:
    if f.lattice is not None:
        return f"{_shown(f.lattice)} px, confidence {f.lattice.confidence:.2f}"
    best = max((one.confidence for one in f.lattices.ranked), default=0.0)
    about = "" if f.about is None else f", but elements lie about steps of {_shown(f.about)} px"
    return f"none (best candidate {best:.2f}){about}"


def _shown(found: Lattice) -> str:
    return " and ".join(f"{x:.2f},{y:.2f}" for x, y in vectors_of(found))


def warnings_of(f: Facts) -> tuple[str, ...]:
    """Return warnings on defects of the exemplar that no method can correct, in sentences that say what to do."""
    out: list[str] = []
    if f.side < LEAST_SIDE:
        out.append(f"the exemplar is only {f.side} px on its shorter side; a larger one gives more to choose from.")
    if f.constant or f.canvas.start is not None or f.canvas.guide is not None:
        return tuple(out)
    lattice = f.lattice if f.straight is None else f.straight[1]
    if f.side >= LEAST_SIDE and lattice is not None:
        longest = max((y * y + x * x) ** 0.5 for y, x in lattice.vectors) / UNIT
        if f.side < PERIODS * longest:
            out.append(f"the exemplar holds fewer than two periods of {longest:.0f} px; a larger one varies more.")
    elif f.side >= LEAST_SIDE and f.across < ACROSS:
        out.append(
            f"the exemplar is {f.across:.1f} elements of {f.element.size} px across, so repeats will show; "
            "a larger exemplar varies more."
        )
    if f.light.strong and not f.exemplar.toroidal:
        out.append(
            f"{100 * f.light.share:.0f} % of what its parts differ by is one slope of light, {f.light.factor:.1f} "
            "times brighter on one side: flatten it (--flatten), if that is light and not the texture."
        )
    return tuple(out)
