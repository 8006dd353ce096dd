"""Graph-cut textures: patches of free shape, whose seams later patches may cover again.

Kwatra, Schoedl, Essa, Turk and Bobick, "Graphcut Textures: Image and Video Synthesis Using Graph Cuts", ACM
Transactions on Graphics (SIGGRAPH) 2003.

Departures: windows are filled in raster order, so that work and memory stay local, and a patch reaches no further
around its window than `overreach`; twelve placements are drawn, and compared by cuts on every fourth px; strong steps
cost more than in proportion (`seam`); placements are found by outlines and slow colour, too (`structure`), and where
they keep courses (`courses`); damaged elements are covered by whole ones in the end (`whole`); what is shown already
costs a little more; the energy of old seams lies on the pixel grid itself, without nodes of their own; refinement
matches what lies around the bad place, not the bad place itself, and lets pieces about it grow. Under a guide patches
are chosen as in image quilting, and nothing is refined.

Cost: for each window and each refinement one FFT search, twelve maximum flows over a sixteenth of the window, and one
over all of it; about 2 N_out / pitch^2 of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from ..errors import ParameterError
from ..lazy import lazy
from ..params import AUTO, extent, param
from . import parameters
from .base import Ability

if TYPE_CHECKING:
    from .. import sourcemap
    from ..analysis import symmetry
    from ..canvas import Canvas
    from ..exemplar import Exemplar
    from ..lattice import vectors
    from ..patches import growth as patches_growth
    from ..patches import labelled, settings
    from ..run import Run
    from ..seams import graphcut, whole
    from ..seams import settings as stitching
    from ..search import guide, sizes
else:
    labelled = lazy("intarsia.patches.labelled")
    patches_growth = lazy("intarsia.patches.growth")
    settings = lazy("intarsia.patches.settings")
    guide = lazy("intarsia.search.guide")
    sizes = lazy("intarsia.search.sizes")
    graphcut = lazy("intarsia.seams.graphcut")
    stitching = lazy("intarsia.seams.settings")
    whole = lazy("intarsia.seams.whole")
    vectors = lazy("intarsia.lattice.vectors")
    symmetry = lazy("intarsia.analysis.symmetry")
    sourcemap = lazy("intarsia.sourcemap")

STAGE = 2403  # keeps this method's draws apart from those of others
LARGEST = 1 << 16  # px, of a window
REFINED = 3, 5  # for so many windows so many of the worst places are covered anew: two graders saw no gain in more
TOLERANCE = 0.1  # under a guide: choose among patches up to this much worse than the best


@dataclass(frozen=True)
class Graphcut(parameters.CutSquares):
    """Lay large patches, cut out in the shape that fits best, and cover the worst seams once more."""

    slug: ClassVar[str] = "graphcut"
    paper: ClassVar[str] = "Kwatra et al. 2003"
    summary: ClassVar[str] = "patches of free shape, worst seams covered anew"
    supports: ClassVar[frozenset[Ability]] = frozenset(
        {Ability.WRAP, Ability.START, Ability.MASK, Ability.GUIDE, Ability.ISOMETRIES, Ability.SEVERAL}
    )

    patch: int | tuple[int, int] | None = param(
        AUTO, "extent", "side of a window; automatic: one and a half elements of the texture",
        low=1, high=LARGEST, unit="px",
    )  # fmt: skip
    overlap: int | tuple[int, int] | None = param(
        AUTO, "extent", "width that two neighbours share; automatic: half of the patch",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    overreach: int | None = param(
        AUTO, "int", "how far around its window a patch may replace what is there; automatic: a sixth of the patch",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    refinements: int | None = param(
        AUTO, "int", "how often the worst seam is covered anew; automatic: three times for every five windows",
        low=0, high=1 << 24,
    )  # fmt: skip
    whole: int = param(
        0, "int", "rounds in which damaged elements, such as stones cut in two, are covered by whole ones; 0: none",
        low=0, high=16,
    )  # fmt: skip
    seam: str = parameters.cut_cost("sharp")
    channel_weights: tuple[float, ...] | None = parameters.channel_weights()
    structure: float = parameters.structure_weight()
    courses: float = param(
        0.7, "float", "how much lines that run across the exemplar between courses of stones or boards count in the "
        "search: 1 as much as colour; 0, or where there are none: not", low=0, high=2,
    )  # fmt: skip
    lattice: tuple[tuple[float, float], ...] | None = param(
        AUTO, "vectors", "two steps by which the texture repeats: patches are laid whole steps from the first, give or "
        "take 3 px; automatic: anywhere",
        low=-65536, high=65536, unit="px",
    )  # fmt: skip
    isometries: str | tuple[int, ...] = parameters.poses()
    usage: float = parameters.usage_price()
    spread: float = parameters.spread_price()
    striking: float | None = parameters.striking_share()

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> Graphcut:
        """Decide window, overlap, overreach and refinements from the texture's elements and the canvas."""
        patch, room = self.patch, self._room(exemplars, canvas)
        if patch is AUTO and canvas.guide is None:
            patch = min(sizes.large_patch(exemplars), room)
        elif patch is AUTO:
            patch = sizes.default_patch(exemplars, canvas.guide)
        rows, columns = extent(patch)
        isometries = symmetry.resolved_isometries(self.isometries, exemplars, (rows, columns))
        sizes.check_patch(patch, exemplars, isometries)
        if canvas.guide is not None:
            guide.check_guide(exemplars, canvas.guide, patch)
        half = (rows // 2, columns // 2) if rows != columns else rows // 2
        overlap = half if self.overlap is AUTO else self.overlap
        overreach = min(rows, columns) // 6 if self.overreach is AUTO else self.overreach
        resolved = replace(self, patch=patch, overlap=overlap, overreach=overreach, isometries=isometries)
        if self.refinements is AUTO:
            windows = math.prod(resolved.patch_settings(0).layout(canvas).shape)
            resolved = replace(resolved, refinements=-(-windows * REFINED[0] // REFINED[1]))
        return resolved

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Fill the canvas window by window, then cover the worst seams."""
        method = self.resolved(exemplars, canvas)
        make = method.sewn if canvas.guide is None else method.guided
        return parameters.gone_over(method, exemplars, canvas, run, lambda run: make(exemplars, canvas, seed, run))

    def sewn(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Grow without a guide."""
        growth = patches_growth.Growth(self.patch_settings(0), exemplars, canvas)
        sewn = graphcut.GraphcutGrowth(growth, self.stitch)
        laying = run.part(0, 2) if self.whole else run
        sewn.fill(seed, STAGE, laying, self.refinements or 0)
        sewn.refine(seed, STAGE, laying, self.refinements or 0)
        whole.make_whole(sewn, list(exemplars), self.whole, run.part(1, 2))
        return growth.map(self.blend)

    def guided(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Grow under a guide: patches are chosen window by window as it says, and cut in with old seams remembered."""
        stages = labelled.Stages(self.patch_settings(self.usage), exemplars, canvas, self.blend)
        in_turn = replace(run, threads=1)  # a cut looks at the pixels beside its window, too
        for growth in stages:
            sewn = graphcut.GraphcutGrowth(growth, self.stitch)
            growth.fill(seed, STAGE, in_turn, choose=TOLERANCE, join=sewn.join)
        return stages.map

    @property
    def snap(self) -> str:
        """Whether patches keep to a lattice."""
        return "on" if self.lattice else "off"

    def _room(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> int:
        """The largest window, px, that may lie in every place of a period; what keeps to a lattice is checked."""
        if not self.lattice:
            return LARGEST
        vectors.check_lattice(self.lattice, exemplars[0])
        for wrong, what in (
            (len(self.lattice) == 1, "rows of one vector"), (canvas.wrap.y or canvas.wrap.x, "a canvas that wraps"),
            (canvas.guide is not None, "a guide"), (len(exemplars) > 1, "several exemplars"),
            (self.isometries not in ("none", (0,)), f"isometries={self.isometries}"),
        ):
            if wrong:
                raise ParameterError(f"patches in step with a lattice do not go with {what}; leave the lattice out.")
        room = min(exemplars[0].height, exemplars[0].width) - math.ceil(max(abs(n) for v in self.lattice for n in v))
        if room < sizes.LEAST:
            raise ParameterError("the exemplar holds no patch of 16 px beside one period; leave the lattice out.")
        return room

    @property
    def _steps(self) -> tuple[vectors.Vector, vectors.Vector] | None:
        """The vectors as whole numbers."""
        first, second = vectors.cell_of(self.lattice, (1 << 16, 1 << 16)) if self.lattice else (None, None)
        return (first, second) if first and second else None

    @property
    def stitch(self) -> stitching.GraphcutSettings:
        """How patches are placed and joined; known once overreach is."""
        return stitching.GraphcutSettings(self.usage, self.seam, self.overreach or 0, self._steps)

    def patch_settings(self, usage: float) -> settings.PatchSettings:
        """How windows lie, and the price of repeats under a guide; known once patch and overlap are."""
        overlap = extent(self.overlap or 0)
        return settings.PatchSettings(
            patch=self.footprint, overlap=overlap, weights=self.channel_weights, structure=self.structure,
            courses=self.courses, isometries=self.isometries,
            repeats=settings.Repeats(usage=usage), rim=max(overlap),
            boundaries=settings.Boundaries.of(self.footprint, None, self.isometries, None),
        )  # fmt: skip
