"""Wei and Levoy at work: level after level, row after row, the pixel whose neighbourhood fits best."""

from __future__ import annotations

from collections.abc import Callable

from ...arrays import Int64
from ...canvas import Canvas
from ...exemplar import Exemplars
from ...params import extent
from ...run import Run
from ...sourcemap import SourceMap
from .neighbourhood_kernels import Ground
from .neighbourhoods import with_window
from .raster_kernels import Torus, full_pixels, tree_pixels
from .raster_scan import Scan, scan_reach, tree_of
from .wei_levoy import WeiLevoy

STAGE = 200020  # keeps this method's draws apart from those of others
WIDTHS = 5, 13  # least and most columns of automatic windows
FEW = 6  # pixels that the tree names
LEAVES = 24  # of the tree, looked into for one pixel
AT_ONCE = 64  # pixels filled between two looks at the clock


def resolved(method: WeiLevoy, exemplars: Exemplars, canvas: Canvas) -> WeiLevoy:
    """Decide the window from the size of the texture's elements."""
    found: WeiLevoy = with_window(method, exemplars, WIDTHS, False, lambda size: scan_reach(size, method.levels))
    return found


def synthesize(method: WeiLevoy, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Fill level after level, row after row."""
    side, white = extent(method.window or 3), method.noise == "white"
    scan = Scan(exemplars, canvas, side, method.levels, (seed, STAGE), white)
    for _ in range(method.levels):
        torus, exemplar = scan.enter()
        fill = _filler(method, scan, torus, exemplar)
        for pixels in scan.stretches(AT_ONCE):
            run.tick(scan.done, scan.total, lambda: scan.map(method.blend))
            fill(pixels)
        for pixels in scan.first_ones(AT_ONCE):
            run.tick(scan.done, scan.total, lambda: scan.map(method.blend))
            full_pixels(torus, exemplar, pixels, scan.room)
    run.tick(scan.total, scan.total, lambda: scan.map(method.blend))
    return scan.map(method.blend)


def _filler(method: WeiLevoy, scan: Scan, torus: Torus, exemplar: Ground) -> Callable[[Int64], None]:
    """Return what fills pixels (n, 2) of this level, in turn."""
    if method.matching == "exact":
        return lambda pixels: full_pixels(torus, exemplar, pixels, scan.room)
    tree = tree_of(exemplar, torus.choices, scan.components())
    return lambda pixels: tree_pixels(torus, exemplar, tree, LEAVES, FEW, pixels, scan.room)
