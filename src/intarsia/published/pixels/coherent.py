"""Ashikhmin at work: row after row, pixels that continue their neighbours."""

from __future__ import annotations

from itertools import chain

from ...canvas import Canvas
from ...exemplar import Exemplars
from ...params import extent
from ...run import Run
from ...sourcemap import SourceMap
from .ashikhmin import Ashikhmin
from .neighbourhoods import with_window
from .raster_kernels import coherent_pixels
from .raster_scan import Scan, scan_reach, similar_pixels

STAGE = 2001  # keeps this method's draws apart from those of others
WIDTHS = 5, 9  # least and most columns of automatic windows
AT_ONCE = 512  # pixels filled between two looks at the clock


def resolved(method: Ashikhmin, exemplars: Exemplars, canvas: Canvas) -> Ashikhmin:
    """Decide the window from the size of the texture's elements."""
    found: Ashikhmin = with_window(method, exemplars, WIDTHS, False, lambda size: scan_reach(size, 1))
    return found


def synthesize(method: Ashikhmin, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Fill row after row."""
    scan = Scan(exemplars, canvas, extent(method.window or 3), 1, (seed, STAGE))
    torus, exemplar = scan.enter()
    similar = similar_pixels(exemplar, torus.choices, scan.components(), method.jumps)
    for pixels in chain(scan.stretches(AT_ONCE), scan.first_ones(AT_ONCE)):
        run.tick(scan.done, scan.total, lambda: scan.map(method.blend))
        coherent_pixels(torus, exemplar, similar, pixels, scan.room)
    run.tick(scan.total, scan.total, lambda: scan.map(method.blend))
    return scan.map(method.blend)
