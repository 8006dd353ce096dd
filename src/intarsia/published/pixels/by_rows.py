"""Wei and Levoy, and Ashikhmin, at work: level after level, row after row, the pixel whose neighbourhood fits best."""

from __future__ import annotations

from collections.abc import Callable

from ...foundation.arrays import Int64
from ...foundation.params import extent
from ...foundation.run import Run
from ...model import Exemplars
from ...model.canvas import Canvas
from ...model.sourcemap import SourceMap
from .ashikhmin import Ashikhmin
from .neighbourhood_kernels import Ground
from .neighbourhoods import with_window
from .raster_kernels import Torus, coherent_pixels, full_pixels, tree_pixels
from .raster_scan import Scan, scan_reach, similar_pixels, tree_of
from .wei_levoy import WeiLevoy

FEW = 6  # pixels that the tree names
LEAVES = 24  # of the tree, looked into for one pixel
Fill = Callable[[Int64], None]


def resolved(method: WeiLevoy | Ashikhmin, exemplars: Exemplars, canvas: Canvas) -> WeiLevoy | Ashikhmin:
    """Decide the window from the size of the texture's elements."""
    found: WeiLevoy | Ashikhmin = with_window(
        method, exemplars, (5, method.widest), False, lambda size: scan_reach(size, method.levels)
    )
    return found


def synthesize(
    method: WeiLevoy | Ashikhmin, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run
) -> SourceMap:
    """Fill level after level, row after row."""
    draws, white = (seed, method.stage), method.noise == "white"
    scan = Scan(exemplars, canvas, extent(method.window or 3), method.levels, draws, white)
    for _ in range(method.levels):
        fill, again = _fillers(method, scan, *scan.enter())
        for way, ask in ((fill, scan.stretches), (again, scan.first_ones)):
            for pixels in ask(method.at_once):
                run.tick(scan.done, scan.total, lambda: scan.map(method.blend))
                way(pixels)
    run.tick(scan.total, scan.total, lambda: scan.map(method.blend))
    return scan.map(method.blend)


def _fillers(method: WeiLevoy | Ashikhmin, scan: Scan, torus: Torus, exemplar: Ground) -> tuple[Fill, Fill]:
    """Return what fills pixels (n, 2) of this level, in turn, and what fills those again that saw noise."""

    def full(pixels: Int64) -> None:
        full_pixels(torus, exemplar, pixels, scan.room)

    def coherent(pixels: Int64) -> None:
        coherent_pixels(torus, exemplar, similar, pixels, scan.room)

    def by_tree(pixels: Int64) -> None:
        tree_pixels(torus, exemplar, tree, LEAVES, FEW, pixels, scan.room)

    if isinstance(method, Ashikhmin):
        similar = similar_pixels(exemplar, torus.choices, scan.components(), method.jumps)
        return coherent, coherent
    if method.matching == "exact":
        return full, full
    tree = tree_of(exemplar, torus.choices, scan.components())
    return by_tree, full
