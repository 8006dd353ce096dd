"""Random tiling: a patch is drawn for every cell of a grid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..analysis.features import features
from ..foundation.geometry import spread
from ..foundation.params import AUTO, extent
from ..foundation.run import Run, draw
from ..methods.random_tiling import RandomTiling
from ..model import Exemplars
from ..model.canvas import Canvas
from ..model.sourcemap import SourceMap
from ..search import check_patch, default_patch, isometry_ids, posed_exemplars, resolved_isometries
from . import MapBuilder, random_patch

STAGE = 2000  # keeps this method's draws apart from those of others


def resolved(method: RandomTiling, exemplars: Exemplars, canvas: Canvas) -> RandomTiling:
    """Return the method with patch and isometries set, where they are automatic."""
    patch = default_patch(exemplars) if method.patch is AUTO else method.patch
    isometries = resolved_isometries(method.isometries, exemplars, extent(patch))
    check_patch(patch, exemplars, isometries)
    return replace(method, patch=patch, isometries=isometries)


def synthesize(method: RandomTiling, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Place a patch, drawn uniformly from the valid ones, in every cell of the grid, in raster order."""
    patch = method.footprint
    rows, height = spread(canvas.height, patch[0], 0, canvas.wrap.y)
    columns, width = spread(canvas.width, patch[1], 0, canvas.wrap.x)
    begun = () if canvas.start is None else canvas.start.poses
    poses = isometry_ids(method.isometries)
    variants = posed_exemplars(exemplars, features(exemplars), poses, (height, width), begun)
    work = MapBuilder.begin(variants, canvas, canvas.rim or 0)
    for r, y in enumerate(rows):
        run.tick(r, len(rows), lambda: work.map(exemplars, canvas, method.blend))
        for c, x in enumerate(columns):
            pick = random_patch(variants.valid, draw(seed, STAGE, 0, r, c))
            _, known = variants.windows(work.grown, np.array([(y, x)]), (height, width))
            work.lay_over((y, x), pick, known[0], (0, 0))
    return work.map(exemplars, canvas, method.blend)
