"""Method repeat: plain repetition, positions modulo the exemplar."""

from __future__ import annotations

import numpy as np

from ..foundation.arrays import Int32
from ..foundation.geometry import Box
from ..foundation.run import Run
from ..methods.repeat import Repeat
from ..model import Exemplar, Exemplars
from ..model.canvas import Canvas
from ..model.sourcemap import SourceMap


def resolved(method: Repeat, exemplars: Exemplars, canvas: Canvas) -> Repeat:
    """Return the method unchanged, as it has no automatic parameters."""
    return method


def synthesize(method: Repeat, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Repeat the exemplar over the canvas. The seed is not used."""
    run.tick(0, 1)
    exemplar = exemplars[0]
    yx = _repeated(exemplar, Box(0, 0, canvas.height, canvas.width))
    run.tick(1, 1)
    return SourceMap(yx, None, None, (exemplar.source,), canvas.wrap, method.blend)


def window(method: Repeat, exemplars: Exemplars, box: Box, seed: int, run: Run) -> SourceMap:
    """Return the part of the endless repetition that lies in a box."""
    return SourceMap(_repeated(exemplars[0], box), None, None, (exemplars[0].source,), blend=method.blend)


def _repeated(exemplar: Exemplar, box: Box) -> Int32:
    """Return the exemplar pixels (height, width, 2) of a box."""
    yx = np.empty((box.height, box.width, 2), np.int32)
    yx[:, :, 0] = (np.arange(box.y0, box.y1) % exemplar.height)[:, None]
    yx[:, :, 1] = np.arange(box.x0, box.x1) % exemplar.width
    return yx
