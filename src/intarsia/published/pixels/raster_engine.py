"""Engine of Wei-Levoy and Ashikhmin synthesis: coarse to fine, in raster order, the best matching neighbourhood."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...foundation.params import extent
from ...foundation.run import Run
from ...model import Exemplars
from ...model.canvas import Canvas
from ...model.sourcemap import SourceMap
from .ashikhmin import Ashikhmin
from .neighbourhood_kernels import ExemplarPlanes
from .neighbourhoods import with_window
from .raster_kernels import fill_by_tree, fill_coherent, fill_full
from .raster_scan import Scan, scan_reach, tree_of
from .wei_levoy import WeiLevoy

FEW = 6  # pixels that the tree names
LEAVES = 24  # of the tree, looked into for one pixel
Way = tuple[Callable[..., None], tuple[Any, ...]]
"""A kernel that fills pixels, and its arguments after the torus and the exemplars."""


def resolved(method: WeiLevoy | Ashikhmin, exemplars: Exemplars, canvas: Canvas) -> WeiLevoy | Ashikhmin:
    """Return the method with its window derived from the size of the texture's elements."""
    found: WeiLevoy | Ashikhmin = with_window(
        method, exemplars, (5, method.widest), False, lambda size: scan_reach(size, method.levels)
    )
    return found


def synthesize(
    method: WeiLevoy | Ashikhmin, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run
) -> SourceMap:
    """Fill the levels from coarse to fine, each row by row."""
    draws, white = (seed, method.stage), method.noise == "white"
    scan = Scan(exemplars, canvas, extent(method.window or 3), method.levels, draws, white)
    for _ in range(method.levels):
        torus, exemplar = scan.enter()
        first, again = _ways(method, scan, exemplar)
        for (fill, more), ask in ((first, scan.unknown_runs), (again, scan.saw_noise)):
            for pixels in ask(method.at_once):
                run.tick(scan.done, scan.total, lambda: scan.map(method.blend))
                fill(torus, exemplar, *more, pixels, scan.room)
    run.tick(scan.total, scan.total, lambda: scan.map(method.blend))
    return scan.map(method.blend)


def _ways(method: WeiLevoy | Ashikhmin, scan: Scan, exemplar: ExemplarPlanes) -> tuple[Way, Way]:
    """Return how pixels of this level are filled, and how those that saw noise are filled again."""
    if isinstance(method, Ashikhmin):
        return ((fill_coherent, ()),) * 2
    if method.matching == "tree":
        return (fill_by_tree, (tree_of(exemplar, scan.torus.choices, scan.components()), LEAVES, FEW)), (fill_full, ())
    return ((fill_full, ()),) * 2
