"""Engine of raster quilting: patches placed row by row, cut as in Robinson's program of 2004 along two one-way paths.

Not a minimum cut: each path is monotone, and its cost is that of single pixels (docs/design/search-and-cuts.md).
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from ...analysis import valid_windows
from ...analysis.features import features
from ...foundation.arrays import Array, Int64, Mask, Pair
from ...foundation.params import AUTO, extent
from ...foundation.run import Run, below, draw
from ...kernels import shortest_paths
from ...model import Exemplars
from ...model.canvas import Canvas
from ...model.sourcemap import HOLE, SourceMap
from ...search import check_patch, default_patch
from .engine_kernels import norms, overlap_sums
from .raster_quilting import RasterQuilting

STAGE = 2004  # keeps this method's draws apart from those of others


def resolved(method: RasterQuilting, exemplars: Exemplars, canvas: Canvas) -> RasterQuilting:
    """Return the method with the patch derived from the size of the texture's elements, the overlap from the patch."""
    patch = default_patch(exemplars) if method.patch is AUTO else method.patch
    rows, columns = extent(patch)
    sixth = (rows // 6, columns // 6) if rows != columns else rows // 6
    check_patch(patch, exemplars)
    return replace(method, patch=patch, overlap=sixth if method.overlap is AUTO else method.overlap)


def synthesize(
    method: RasterQuilting, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run
) -> SourceMap:
    """Place patch after patch, in raster order."""
    exemplar = exemplars[0]
    picture = features(exemplars, method.channel_weights).pictures[0]
    valid = valid_windows(picture.shape, exemplar.usable, False, method.footprint)
    shared, pitch = extent(method.overlap or 0), method.pitch
    yx = np.zeros((canvas.height, canvas.width, 2), np.int32)
    holes = np.ones((canvas.height, canvas.width), bool)

    def laid() -> SourceMap:
        which = np.where(holes, np.uint8(HOLE), np.uint8(0)) if holes.any() else None
        return SourceMap(yx.copy(), which, None, (exemplar.source,), canvas.wrap, method.blend)

    rows, columns = (
        range(0, max(length - o, 1), step)
        for length, o, step in zip((canvas.height, canvas.width), shared, pitch, strict=True)
    )
    part = -(-len(valid) // run.workers)
    with run.pool() as each:
        for number, (y, x) in enumerate(product(rows, columns)):
            run.tick(number, len(rows) * len(columns), laid)
            here = np.s_[y : y + method.footprint[0], x : x + method.footprint[1]]
            shown, known = picture[yx[here][..., 0], yx[here][..., 1]], ~holes[here]
            among = [(picture[low:], valid[low : low + part], shown, known) for low in range(0, len(valid), part)]
            sums = np.concatenate([*each(lambda these: overlap_sums(*these, method.tolerance), among)])
            u, v = _chosen(sums, method.tolerance, draw(seed, STAGE, 0, y, x))
            patch = np.moveaxis(np.indices(known.shape, np.int32), 0, 2) + np.array((u, v), np.int32)
            ways = shared[0] if y else 0, shared[1] if x else 0
            new = cut(norms(shown, picture[patch[..., 0], patch[..., 1]]), ways, method.turning == "text")
            yx[here][new], holes[here] = patch[new], False
    return laid()


def _chosen(sums: Array, tolerance: float, bits: int) -> Pair:
    """Draw one of the places whose sum is within the tolerance of the least; negative sums are no places."""
    limit = (1 + tolerance) * int(sums[sums >= 0].min())
    at = np.flatnonzero((sums >= 0) & (sums <= limit))
    u, v = divmod(int(at[below(len(at), bits)]), sums.shape[1])
    return u, v


def cut(norms: Int64, overlap: Pair, text: bool = False) -> Mask:
    """Return which pixels of a patch (h, w) replace the picture, by the norms of the differences from it.

    `overlap`: rows above and columns to the left that are known, 0: none. `text`: turn where the sum of both paths less
    the pixel that both count is least, not the sum alone.
    """
    rows, columns = (min(o, n) for o, n in zip(overlap, norms.shape, strict=True))
    new = np.ones(norms.shape, bool)
    down = accumulated(norms[:, :columns]) if columns else None
    along = accumulated(norms[:rows].T) if rows else None
    turn = 0, 0
    if down is not None and along is not None:
        corner = down[:rows] + along[:columns].T - (norms[:rows, :columns] if text else 0)
        turn = divmod(int(corner.argmin()), columns)
        new[: turn[0] + 1, : turn[1] + 1] = False
    elif down is not None:
        turn = 0, int(down[0].argmin())
    elif along is not None:
        turn = int(along[0].argmin()), 0
    if down is not None:
        for i, j in enumerate(traced(down, *turn)):
            new[turn[0] + i, : j + 1] = False
    if along is not None:
        for j, i in enumerate(traced(along, turn[1], turn[0])):
            new[: i + 1, turn[1] + j] = False
    return new


def accumulated(error: Array) -> Int64:
    """Return cumulative path costs of a strip from its last row up: each pixel and the least of three predecessors."""
    total: Int64 = shortest_paths.accumulate(np.ascontiguousarray(error[::-1]), 0)
    return total[::-1]


def traced(total: Array, row: int, column: int) -> list[int]:
    """Return the cheapest path to the last row of a strip, the column in each row; ties go straight on, then left."""
    columns: list[int] = shortest_paths.trace(np.ascontiguousarray(total[row:][::-1]), column, 0)[::-1].tolist()
    return columns
