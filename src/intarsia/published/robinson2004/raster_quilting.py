"""Image quilting row by row: patches as they are given, cropped at the border, joined along two one-way paths.

Robinson, "An Implementation of the Efros and Freeman Image Quilting Algorithm", project report, Computer Science 766,
2004 (see docs/sources-002.md).

Departures: norms are whole numbers, in 1/16 of a step of the features, so that every machine draws the same patches;
masked pixels are not copied.

Cost: for every patch all places of the exemplar are compared, most of them only in a part of the overlap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from ...draws import below, draw
from ...lazy import lazy
from ...methods import parameters
from ...methods.base import Ability
from ...params import AUTO, extent, param

if TYPE_CHECKING:
    import numpy as np

    from ... import sourcemap
    from ...analysis import features, usable
    from ...canvas import Canvas
    from ...exemplar import Exemplar
    from ...run import Run
    from ...search import sizes
    from . import two_paths
    from . import two_paths_kernels as kernels
else:
    np = lazy("numpy")
    features = lazy("intarsia.analysis.features")
    usable = lazy("intarsia.analysis.usable")
    sizes = lazy("intarsia.search.sizes")
    sourcemap = lazy("intarsia.sourcemap")
    two_paths = lazy("intarsia.published.robinson2004.two_paths")
    kernels = lazy("intarsia.published.robinson2004.two_paths_kernels")

STAGE = 2004  # keeps this method's draws apart from those of others


@dataclass(frozen=True)
class RasterQuilting(parameters.CutSquares):
    """Lay overlapping patches row by row, and cut each in along the two paths of the report of 2004."""

    slug: ClassVar[str] = "raster-quilting"
    paper: ClassVar[str] = "Robinson 2004"
    summary: ClassVar[str] = "quilting as published: row by row, cut along two one-way paths"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.MASK})

    patch: int | tuple[int, int] | None = parameters.patch_side()
    overlap: int | tuple[int, int] | None = param(
        AUTO, "extent", "width that two neighbours share; automatic: a sixth of the patch",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    tolerance: float = param(0.1, "float", "choose among patches up to this much worse than the best", low=0, high=100)
    turning: str = param(
        "program", "choice", "where the two paths meet: where their sum is least, as in the report's program, or, as "
        "in its text, their sum less the pixel that both count",
        choices=("program", "text"),
    )  # fmt: skip
    channel_weights: tuple[float, ...] | None = parameters.channel_weights()

    @property
    def hangs(self) -> int:
        """From the first corner on, at their pitch."""
        return 0

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> RasterQuilting:
        """Decide the patch from the size of the texture's elements, and the overlap from the patch."""
        patch = sizes.default_patch(exemplars) if self.patch is AUTO else self.patch
        rows, columns = extent(patch)
        sixth = (rows // 6, columns // 6) if rows != columns else rows // 6
        sizes.check_patch(patch, exemplars)
        return replace(self, patch=patch, overlap=sixth if self.overlap is AUTO else self.overlap)

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Lay patch after patch, row after row."""
        method, exemplar = self.resolved(exemplars, canvas), exemplars[0]
        picture = features.features(exemplars, self.channel_weights).pictures[0]
        valid = usable.valid_windows(picture.shape, exemplar.usable, False, method.footprint)
        shared, pitch = extent(method.overlap or 0), method.pitch
        yx = np.zeros((canvas.height, canvas.width, 2), np.int32)
        holes = np.ones((canvas.height, canvas.width), bool)

        def laid() -> sourcemap.SourceMap:
            which = np.where(holes, np.uint8(sourcemap.HOLE), np.uint8(0)) if holes.any() else None
            return sourcemap.SourceMap(yx.copy(), which, None, (exemplar.source,), canvas.wrap, self.blend)

        rows, columns = (
            range(0, max(length - o, 1), step)
            for length, o, step in zip((canvas.height, canvas.width), shared, pitch, strict=True)
        )
        for number, y in enumerate(rows):
            run.tick(number, len(rows), laid)
            for x in columns:
                here = np.s_[y : y + method.footprint[0], x : x + method.footprint[1]]
                shown, known = picture[yx[here][..., 0], yx[here][..., 1]], ~holes[here]
                sums = kernels.overlap_sums(picture, valid, shown, known, method.tolerance)
                u, v = method.chosen(sums, draw(seed, STAGE, 0, y, x))
                patch = np.moveaxis(np.indices(known.shape, np.int32), 0, 2) + np.array((u, v), np.int32)
                norms = kernels.norms(shown, picture[patch[..., 0], patch[..., 1]])
                ways = shared[0] if y else 0, shared[1] if x else 0
                new = two_paths.cut(norms, ways, method.turning == "text")
                yx[here][new], holes[here] = patch[new], False
        return laid()

    def chosen(self, sums: np.ndarray, bits: int) -> tuple[int, int]:
        """Draw one of the places whose sum is within the tolerance of the least; negative: none is there."""
        limit = (1 + self.tolerance) * int(sums[sums >= 0].min())
        at = np.flatnonzero((sums >= 0) & (sums <= limit))
        u, v = divmod(int(at[below(len(at), bits)]), sums.shape[1])
        return u, v
