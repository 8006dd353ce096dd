"""Random tiling: patches drawn blindly and laid side by side; the baseline that every other method must beat.

The left-hand comparison of Efros and Freeman 2001, figure 2a, and of Robinson 2004. No departures.

Cost: none to speak of.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from ..draws import draw
from ..geometry import spread
from ..lazy import lazy
from ..params import AUTO, extent
from . import parameters
from .base import Ability, MethodBase

if TYPE_CHECKING:
    from .. import sourcemap
    from ..analysis import features, symmetry
    from ..canvas import Canvas
    from ..exemplar import Exemplar
    from ..patches import growing_map
    from ..run import Run
    from ..search import posed, sizes, windows
else:
    features = lazy("intarsia.analysis.features")
    windows = lazy("intarsia.search.windows")
    growing_map = lazy("intarsia.patches.growing_map")
    sizes = lazy("intarsia.search.sizes")
    symmetry = lazy("intarsia.analysis.symmetry")
    posed = lazy("intarsia.search.posed")
    sourcemap = lazy("intarsia.sourcemap")

STAGE = 2000


@dataclass(frozen=True)
class RandomTiling(MethodBase):
    """Lay patches drawn at random side by side, matching nothing."""

    slug: ClassVar[str] = "random-tiling"
    paper: ClassVar[str] = "Efros and Freeman 2001, figure 2a; Robinson 2004"
    summary: ClassVar[str] = "random patches side by side, the baseline"
    supports: ClassVar[frozenset[Ability]] = frozenset(
        {Ability.WRAP, Ability.START, Ability.MASK, Ability.ISOMETRIES, Ability.SEVERAL}
    )

    patch: int | tuple[int, int] | None = parameters.patch_side()
    isometries: str | tuple[int, ...] = parameters.poses()

    @property
    def pitch(self) -> tuple[int, int]:
        """Step from patch to patch, (rows, columns) px; known once the patch is."""
        return extent(self.patch or 0)

    @property
    def footprint(self) -> tuple[int, int]:
        """Rows and columns of the exemplar that a patch needs."""
        return extent(self.patch or 0)

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> RandomTiling:
        """Decide the patch from the size of the texture's elements."""
        patch = sizes.default_patch(exemplars) if self.patch is AUTO else self.patch
        isometries = symmetry.resolved_isometries(self.isometries, exemplars, extent(patch))
        sizes.check_patch(patch, exemplars, isometries)
        return replace(self, patch=patch, isometries=isometries)

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Draw a patch for every cell of the grid."""
        patch = extent(self.resolved(exemplars, canvas).patch or 1)
        rows, height = spread(canvas.height, patch[0], 0, canvas.wrap.y)
        columns, width = spread(canvas.width, patch[1], 0, canvas.wrap.x)
        layout = windows.WindowGrid(
            tuple(rows), tuple(columns), (height, width), canvas.height, canvas.width, canvas.wrap.y, canvas.wrap.x
        )
        begun = () if canvas.start is None else canvas.start.poses
        poses = posed.isometry_ids(self.isometries)
        variants = posed.posed_exemplars(exemplars, features.features(exemplars), poses, (height, width), begun)
        work = growing_map.GrowingMap.begin(variants, canvas, canvas.rim or 0)
        for r, y in enumerate(rows):
            run.tick(r, len(rows), lambda: work.map(exemplars, canvas, self.blend))
            for c, x in enumerate(columns):
                pick = growing_map.random_patch(variants.valid, draw(seed, STAGE, 0, r, c))
                work.lay_over((y, x), pick, work.known((y, x), layout), layout, (0, 0))
        return work.map(exemplars, canvas, self.blend)
