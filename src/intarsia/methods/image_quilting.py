"""Image quilting: patches that match their neighbours, joined along the cheapest seam.

Efros and Freeman, "Image Quilting for Texture Synthesis and Transfer", SIGGRAPH 2001; Robinson 2004 (source 002).

Departures: the seam is the true minimum cut of the whole overlap, of whatever shape, measured between pixel pairs
(D2-2, D2-3); patches on a wrapped border or in a last row are matched and cut against every neighbour; patches
already used cost a little more (D2-5); among equally good patches an exact continuation has no advantage (D2-4).

Cost: one FFT search over the reduced exemplar for each patch, about N_out / pitch^2 of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from ..draws import draw
from ..errors import MethodError, ParameterError
from ..geometry import spread
from ..lazy import lazy
from ..params import AUTO, check, extent, param
from .base import Ability

if TYPE_CHECKING:
    import numpy as np

    from .. import analysis, sourcemap
    from ..canvas import Canvas
    from ..exemplar import Exemplar
    from ..run import Run
else:
    np = lazy("numpy")
    analysis = lazy("intarsia.analysis")
    sourcemap = lazy("intarsia.sourcemap")

STAGE = 2002  # keeps this method's draws apart from those of others


@dataclass(frozen=True)
class ImageQuilting:
    """Lay overlapping patches that fit their neighbours, and cut them along the cheapest seam."""

    slug: ClassVar[str] = "image-quilting"
    paper: ClassVar[str] = "Efros and Freeman 2001; Robinson 2004"
    summary: ClassVar[str] = "matching patches joined along the cheapest seam"
    supports: ClassVar[frozenset[Ability]] = frozenset(
        {Ability.WRAP, Ability.START, Ability.MASK, Ability.ISOMETRIES, Ability.SEVERAL}
    )

    patch: int | tuple[int, int] | None = param(
        AUTO, "extent", "side of the copied square, overlaps included; automatic: the size of the texture's elements",
        low=1, high=1 << 16, unit="px",
    )  # fmt: skip
    overlap: int | tuple[int, int] | None = param(
        AUTO, "extent", "width that two neighbours share; automatic: a third of the patch",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    tolerance: float = param(0.1, "float", "choose among patches up to this much worse than the best", low=0, high=100)
    channel_weights: tuple[float, ...] | None = param(
        AUTO, "weights", "how much each channel counts; automatic: 0.3, 0.59, 0.11 for red, green, blue",
        low=0, high=1e6,
    )  # fmt: skip
    context: float = param(
        0.0, "float", "how much the surroundings of old pixels count in the search, 0 to 4", low=0, high=4
    )
    isometries: str | tuple[int, ...] = param("none", "isometries", "which mirrored and turned patches may be used")
    usage: float = param(0.05, "float", "price of using a patch again, in usual distances", low=0, high=100)
    min_repeat_distance: int = param(
        0, "int", "no exemplar pixel returns within this distance in the output", low=0, high=1 << 20, unit="px"
    )
    search: str = param(
        "fast", "choice", "short-list at reduced resolution, or at full resolution", choices=("fast", "exact")
    )
    seam: str = param(
        "difference", "choice", "cost of a cut: colour difference, or that divided by the gradient",
        choices=("difference", "gradient"),
    )  # fmt: skip

    def __post_init__(self) -> None:
        check(self)
        if self.patch is not AUTO and self.overlap is not AUTO:
            for side, overlap in zip(extent(self.patch), extent(self.overlap), strict=True):
                if overlap >= side:
                    raise ParameterError(f"overlap={overlap} is not below patch={side} px; choose 0 to {side - 1} px.")

    @property
    def blend(self) -> sourcemap.Blend:
        """Exact copies."""
        return sourcemap.Blend(0)

    @property
    def pitch(self) -> tuple[int, int]:
        """Step from patch to patch, (rows, columns) px; known once patch and overlap are."""
        patch, overlap = extent(self.patch or 0), extent(self.overlap or 0)
        return patch[0] - overlap[0], patch[1] - overlap[1]

    @property
    def footprint(self) -> tuple[int, int]:
        """Rows and columns of the exemplar that a patch needs."""
        return extent(self.patch or 0)

    def settled(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> ImageQuilting:
        """Decide patch and overlap from the size of the texture's elements."""
        patch = analysis.default_patch(exemplars) if self.patch is AUTO else self.patch
        analysis.check_patch(patch, exemplars, self.isometries)
        rows, columns = extent(patch)
        third = (rows // 3, columns // 3) if rows != columns else rows // 3
        return replace(self, patch=patch, overlap=third if self.overlap is AUTO else self.overlap)

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Grow the map window by window; windows that do not touch are worked on at the same time."""
        method = self.settled(exemplars, canvas)
        growth = _Growth(method, exemplars, canvas, seed)
        with run.pool() as each:
            for number, wave in enumerate(growth.waves):
                run.tick(number, len(growth.waves), growth.map)
                found = growth.search(wave, each, run.workers)
                picks = [growth.choose(w, f) for w, f in zip(wave, found, strict=True)]
                growth.paste(list(zip(wave, picks, found, strict=True)), each, run.workers)
        run.tick(len(growth.waves), len(growth.waves), growth.map)
        return growth.map()


class _Growth:
    """A map that grows, and all that is needed to grow it."""

    def __init__(self, method: ImageQuilting, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int) -> None:
        self.method, self.exemplars, self.canvas, self.seed = method, exemplars, canvas, seed
        patch, overlap = extent(method.patch or 1), extent(method.overlap or 0)
        rows, height = spread(canvas.height, patch[0], overlap[0], canvas.wrap.y)
        columns, width = spread(canvas.width, patch[1], overlap[1], canvas.wrap.x)
        self.layout = analysis.Layout(
            tuple(rows), tuple(columns), (height, width), canvas.height, canvas.width, canvas.wrap.y, canvas.wrap.x
        )
        around = (method.context, max(min(patch) // 10, 1)) if method.context else (0.0, 0)
        feats = analysis.features(exemplars, method.channel_weights, around)
        shown = () if canvas.start is None else canvas.start.poses
        poses = analysis.isometry_ids(method.isometries)
        self.variants = analysis.variants(exemplars, feats, poses, (height, width), shown)
        self.finder = analysis.PatchSearch(self.variants, (height, width), min(overlap), method.search == "exact")
        striking = analysis.striking(feats, self.finder) if method.usage else None
        self.repetition = analysis.Repetition(
            self.finder, self.layout, method.usage, method.min_repeat_distance, striking
        )
        rim = max(overlap) if canvas.rim is None else canvas.rim
        self.patchwork = analysis.Patchwork.begin(self.variants, canvas, rim)
        self.waves = analysis.waves(self.layout, self.patchwork.open_windows(self.layout))

    def search(self, wave: list[tuple[int, int]], each: Any, workers: int) -> list[Any]:
        """Find candidates for all windows of a wave."""
        found: list[Any] = [None] * len(wave)
        parts = max(workers if len(wave) >= workers else 1, -(-len(wave) // self.finder.batch()))
        size = -(-len(wave) // parts)
        at = np.array([(self.layout.rows[r], self.layout.columns[c]) for r, c in wave], np.int64)

        def part(begin: int) -> None:
            stop = min(begin + size, len(wave))
            found[begin:stop] = self.finder.find(
                self.patchwork.variant, self.patchwork.yx, at[begin:stop],
                self.repetition.counts, self.repetition.weight,
            )  # fmt: skip

        each(part, range(0, len(wave), size))
        return found

    def choose(self, window: tuple[int, int], found: Any) -> tuple[int, int, int]:
        """Pick at random among the candidates within the tolerance; note its use."""
        bits = draw(self.seed, STAGE, 0, *window)
        pick: tuple[int, int, int] | None
        if found.free and not self.method.min_repeat_distance:  # nothing is known here yet: any patch will do
            pick = analysis.random_patch(self.variants, bits)
        else:
            pick = self.repetition.pick(*window, found, self.method.tolerance, bits)
            pick = pick or self.repetition.pick(
                *window, self.repetition.allowed(*window, found), self.method.tolerance, bits
            )
        if pick is None:
            raise MethodError(
                f"min_repeat_distance={self.method.min_repeat_distance} px leaves no patch for some place; "
                "choose a smaller distance, a smaller patch, or a larger exemplar."
            )
        self.repetition.add(*window, pick)
        return pick

    def paste(self, chosen: list[tuple[Any, Any, Any]], each: Any, workers: int) -> None:
        """Cut the chosen patches in."""
        gradient = self.method.seam == "gradient"

        def part(items: list[tuple[Any, Any, Any]]) -> None:
            for (r, c), pick, found in items:
                at = (self.layout.rows[r], self.layout.columns[c])
                self.patchwork.cut_in(at, pick, found, self.layout, gradient)

        size = -(-len(chosen) // workers)
        each(part, [chosen[k : k + size] for k in range(0, len(chosen), size)])

    def map(self) -> sourcemap.SourceMap:
        """The map as far as it has grown."""
        return self.patchwork.map(self.exemplars, self.canvas, self.method.blend)
