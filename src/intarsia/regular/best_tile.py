"""Method best-tile: the best tile of an exemplar is found once, and repeated over a canvas or a box of the plane."""

from __future__ import annotations

from dataclasses import replace

from ..foundation.geometry import Box
from ..foundation.params import AUTO
from ..foundation.run import Run
from ..lattice import check_lattice, lattice_of
from ..methods.best_tile import BestTile
from ..model import Exemplar, Exemplars
from ..model.canvas import Canvas
from ..model.sourcemap import SourceMap
from .tile_search import TileLayout, Tiling


def resolved(method: BestTile, exemplars: Exemplars, canvas: Canvas) -> BestTile:
    """Return the method with its lattice. Raise MethodError if the exemplar has none."""
    if method.lattice is AUTO:
        return replace(method, lattice=lattice_of(exemplars[0], method.slug, method.channel_weights))
    check_lattice(method.lattice, exemplars[0])
    return method


def synthesize(method: BestTile, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Find the best tile and repeat it over the canvas; the seed is not used."""
    run.tick(0, 2)
    layout = _layout(method, exemplars[0], canvas)
    run.tick(1, 2)
    yx = layout.window(0, 0, canvas.height, canvas.width)
    run.tick(2, 2)
    return SourceMap(yx, None, None, (exemplars[0].source,), canvas.wrap, method.blend)


def window(method: BestTile, exemplars: Exemplars, box: Box, seed: int, run: Run) -> SourceMap:
    """Return the part of the endless tiling that lies in a box."""
    plane = Canvas(1, 1)
    layout = exemplars[0].latest(
        "best-tile", method, lambda: _layout(method.resolved(exemplars, plane), exemplars[0], plane)
    )
    yx = layout.window(box.y0, box.x0, box.height, box.width)
    return SourceMap(yx, None, None, (exemplars[0].source,), blend=method.blend)


def _layout(method: BestTile, exemplar: Exemplar, canvas: Canvas) -> TileLayout:
    return Tiling.of(method.lattice, method.channel_weights, method.band, exemplar).layout(canvas)
