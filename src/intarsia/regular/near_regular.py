"""Method near-regular: a lattice is found, then blocks, courses or one tile are placed by it."""

from __future__ import annotations

from dataclasses import replace

from ..foundation import ParameterError
from ..foundation.arrays import Laid
from ..foundation.geometry import Box, Wrap
from ..foundation.params import AUTO
from ..foundation.run import Run
from ..methods.near_regular import NearRegular
from ..model import Exemplar, Exemplars
from ..model.canvas import Canvas
from ..model.sourcemap import SourceMap
from ..patches import drafted
from .continuation import FewPlaces
from .mosaic import Mosaic
from .rectify import Rectified, rectified_for
from .tile_search import TileLayout, Tiling
from .unequal_courses import unequal_masonry
from .wall import Wall

FEW = "the exemplar holds fewer than two places for a block, so its best tile is repeated; a larger one varies more."
SEEDS = 4  # number of layouts that are kept, by seed modulo this
Layer = Wall | Mosaic | TileLayout  # an endless texture, any window of which can be computed alone


def resolved(method: NearRegular, exemplars: Exemplars, canvas: Canvas) -> NearRegular:
    """Rectify the courses and find the lattice.

    Raise MethodError if there is none, ParameterError if blocks of two vectors are to close around a canvas.
    """
    if method.course_heights == "unequal" and method.straighten == "on":
        raise ParameterError("course_heights=unequal follows courses as they run; leave straighten out.")
    rectified = _rectified(method, exemplars[0])
    if len(rectified.lattice) == 2 and canvas.wrap is not Wrap.NONE:
        raise ParameterError("wrap: near-regular closes courses, not a lattice of two vectors; take graphcut for that.")
    straighten = "off" if rectified.straight is None else "on"
    return replace(method, lattice=rectified.lattice, straighten=straighten)


def synthesize(method: NearRegular, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Return the map of a canvas: of two lattice vectors a mosaic of blocks, of one a wall of courses.

    The best tile is repeated if the exemplar is too small for blocks.
    """
    rectified, layer = _layer(method, exemplars[0], canvas, seed, run)
    source = exemplars[0].source

    def shown(laid: Laid) -> SourceMap:
        return drafted((rectified.to_exemplar(laid[0]), *laid[1:]), source, canvas.wrap)

    yx = rectified.to_exemplar(layer.window(0, 0, canvas.height, canvas.width, run.drafting(shown)))
    return SourceMap(yx, None, None, (source,), canvas.wrap, method.blend)


def window(method: NearRegular, exemplars: Exemplars, box: Box, seed: int, run: Run) -> SourceMap:
    """Return the map of a box of the endless texture; lattice and layout are cached for an exemplar and a seed."""

    def prepared() -> tuple[NearRegular, tuple[Rectified, Layer]]:
        plane = Canvas(1, 1)
        known = method.resolved(exemplars, plane)
        return known, _layer(known, exemplars[0], plane, seed, run)

    beside = f"near-regular {seed % SEEDS}"  # so that a few seeds used in turn do not evict each other
    known, (rectified, layer) = exemplars[0].latest(beside, (method, seed), prepared)
    yx = rectified.to_exemplar(layer.window(box.y0, box.x0, box.height, box.width, run))
    return SourceMap(yx, None, None, (exemplars[0].source,), blend=known.blend)


def _rectified(method: NearRegular, exemplar: Exemplar) -> Rectified:
    if method.course_heights == "unequal":
        lattice = (unequal_masonry(exemplar, method.channel_weights).pitch,)
        if method.lattice not in (AUTO, lattice):
            raise ParameterError("course_heights=unequal finds every course by itself; leave lattice out.")
        return Rectified(exemplar, lattice, None)
    return rectified_for(exemplar, method.slug, method.lattice, method.straighten, method.channel_weights)


def _layer(
    method: NearRegular, exemplar: Exemplar, canvas: Canvas, seed: int, run: Run
) -> tuple[Rectified, Layer]:
    """Return the rectified exemplar and the endless texture; the best tile if the exemplar is too small for blocks."""
    rectified = _rectified(method, exemplar)
    exemplar, lattice, weights = rectified.exemplar, rectified.lattice, method.channel_weights
    if len(lattice) == 1:
        given = None if method.course_heights == "unequal" else lattice
        return rectified, Wall.of(given, weights, exemplar, canvas, seed)
    try:
        return rectified, Mosaic.of(method, exemplar, seed)
    except FewPlaces:
        run.notes.append(FEW)
        return rectified, Tiling.of(lattice, weights, method.border, exemplar).layout(canvas)
