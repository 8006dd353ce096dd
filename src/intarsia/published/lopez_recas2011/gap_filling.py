"""Random sampling and gap filling: square blocks at random places of the lattice, the gaps filled to fit.

Lopez Recas, Hilsmann and Eisert, "Near-regular texture synthesis by random sampling and gap filling", VMV 2011,
and Lopez Recas's thesis of the same year, 4.2; what departs from it is told in `sampling.py`.

Cost: for every second block a comparison of all its places on the pixels of its border.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from ...blend import Blend
from ...lazy import lazy
from ...methods import parameters
from ...methods.base import Ability, MethodBase
from ...params import AUTO, param

if TYPE_CHECKING:
    from ... import canvas, sourcemap
    from ...canvas import Canvas
    from ...exemplar import Exemplar
    from ...geometry import Box
    from ...lattice import vectors
    from ...patches import continuation
    from ...run import Run
    from . import goodness, sampling
else:
    canvas = lazy("intarsia.canvas")
    goodness = lazy("intarsia.published.lopez_recas2011.goodness")
    continuation = lazy("intarsia.patches.continuation")
    vectors = lazy("intarsia.lattice.vectors")
    sampling = lazy("intarsia.published.lopez_recas2011.sampling")
    sourcemap = lazy("intarsia.sourcemap")

SEEDS = 4  # whose layouts are kept at a time


@dataclass(frozen=True)
class GapFilling(MethodBase):
    """Lay square blocks at random places of the lattice, and fill the gaps between them with what fits best."""

    slug: ClassVar[str] = "gap-filling"
    paper: ClassVar[str] = "Lopez Recas, Hilsmann and Eisert 2011"
    summary: ClassVar[str] = "square blocks at random places of a lattice, gaps filled to fit"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.WRAP, Ability.MASK, Ability.WINDOW})

    lattice: tuple[tuple[float, float], ...] | None = param(
        AUTO, "vectors", "by which steps the texture repeats; automatic: found in the exemplar",
        low=-65536, high=65536, unit="px",
    )  # fmt: skip
    detector: str = param(
        "contrast", "choice", "how an automatic lattice is found: by contrast, or by the goodness of the source, which "
        "answers on every texture",
        choices=("contrast", "goodness"),
    )  # fmt: skip
    block: int = param(40, "int", "side of a block", low=4, high=1 << 14, unit="px")
    border: int = param(
        10, "int", "width of the zone in which a gap is compared; an even number", low=2, high=256, unit="px"
    )
    slack: int = param(3, "int", "how far a gap's block may leave the lattice", low=0, high=16, unit="px")
    fit: str = param(
        "difference", "choice", "what fits a gap: by squared differences or by correlation",
        choices=("difference", "correlation"),
    )  # fmt: skip
    channel_weights: tuple[float, ...] | None = parameters.channel_weights()

    @property
    def blend(self) -> Blend:
        """Blocks are mixed over 4 px."""
        return Blend(4)

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> GapFilling:
        """Find the lattice; MethodError where there is none."""
        if self.lattice is AUTO and self.detector == "goodness":
            return replace(self, lattice=goodness.lattice_by_goodness(exemplars[0], self.channel_weights))
        if self.lattice is AUTO:
            return replace(self, lattice=vectors.lattice_of(exemplars[0], self.slug, self.channel_weights))
        vectors.check_lattice(self.lattice, exemplars[0])
        return self

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Place the random blocks of the canvas, then fill the gaps."""
        laid = self._laid(exemplars[0], canvas, seed)
        source = exemplars[0].source
        drafting = run.drafting(lambda now: continuation.drafted(now, None, source, canvas.wrap))
        yx, _ = laid.window(0, 0, canvas.height, canvas.width, drafting)
        return sourcemap.SourceMap(yx, None, None, (source,), canvas.wrap, self.blend)

    def window(self, exemplars: Sequence[Exemplar], box: Box, seed: int, run: Run) -> sourcemap.SourceMap:
        """Lay the blocks that a box meets; what they are read from is prepared once for an exemplar and a seed."""
        laid = exemplars[0].latest(
            f"gap-filling {seed % SEEDS}", (self, seed), lambda: self._laid(exemplars[0], canvas.Canvas(1, 1), seed)
        )
        yx, _ = laid.window(box.y0, box.x0, box.height, box.width, run)
        return sourcemap.SourceMap(yx, None, None, (exemplars[0].source,), blend=self.blend)

    def _laid(self, exemplar: Exemplar, canvas: Canvas, seed: int) -> sampling.Sampling:
        known = self.resolved([exemplar], canvas)
        settings = sampling.Settings(
            known.lattice or (), known.block, known.border, known.slack, known.fit, known.channel_weights
        )
        return sampling.Sampling.of(settings, exemplar, canvas, seed)
