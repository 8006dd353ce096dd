"""Near-regular textures: blocks of whole periods at random, the gaps between them filled to fit.

Lopez Recas, Hilsmann and Eisert, "Near-regular texture synthesis by random sampling and gap filling", VMV 2011
(source 001).

Departures: the block grid begins where cuts are cheapest, in the joints; blocks are parallelograms of whole periods,
upright where the lattice allows it; positions are rounded from exact multiples of the real lattice vectors; a seam
may hang outside the exemplar; every position is used equally often; gaps are cut in along the cheapest seam, each
inside its own mitred wedges, so that no two cuts meet (D1-1 to D1-5).

Cost: for every second block a comparison of all its positions on the pixels around it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from ..lazy import lazy
from ..params import AUTO, check, param
from .base import Ability

if TYPE_CHECKING:
    from .. import analysis, sourcemap
    from ..canvas import Canvas
    from ..exemplar import Exemplar
    from ..run import Run
else:
    analysis = lazy("intarsia.analysis")
    sourcemap = lazy("intarsia.sourcemap")


@dataclass(frozen=True)
class NearRegular:
    """Lay blocks of whole periods at random places of the lattice, and fill the gaps between them to fit."""

    slug: ClassVar[str] = "near-regular"
    paper: ClassVar[str] = "Lopez Recas, Hilsmann and Eisert 2011"
    summary: ClassVar[str] = "bricks, tiles, weaves: blocks of whole periods, gaps filled to fit"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.WRAP, Ability.MASK, Ability.WINDOW})

    lattice: tuple[tuple[float, float], ...] | None = param(
        AUTO, "vectors", "by which steps the texture repeats; automatic: found in the exemplar",
        low=-65536, high=65536, unit="px",
    )  # fmt: skip
    block: int | None = param(
        AUTO, "int", "wanted side of a block, rounded to whole periods; automatic: one period, at least about 40 px",
        low=4, high=1 << 14, unit="px",
    )  # fmt: skip
    border: int = param(14, "int", "width of the zone in which a gap is cut in", low=2, high=256, unit="px")
    slack: int = param(3, "int", "how far a gap's block may leave the lattice", low=0, high=16, unit="px")
    channel_weights: tuple[float, ...] | None = param(
        AUTO, "weights", "how much each channel counts; automatic: 0.3, 0.59, 0.11 for red, green, blue",
        low=0, high=1e6,
    )  # fmt: skip

    def __post_init__(self) -> None:
        check(self)

    @property
    def blend(self) -> sourcemap.Blend:
        """Exact copies."""
        return sourcemap.Blend(0)

    def settled(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> NearRegular:
        """Find the lattice; MethodError where there is none."""
        if self.lattice is AUTO:
            return replace(self, lattice=analysis.lattice_of(exemplars[0], self.slug, self.channel_weights))
        analysis.check_lattice(self.lattice, exemplars[0])
        return self

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Place the random blocks of the canvas, then cut in the gaps."""
        settled = self.settled(exemplars, canvas)
        made_of = analysis.Mosaic if len(settled.lattice or ()) == 2 else analysis.Courses
        mosaic = made_of.of(settled, exemplars[0], canvas, seed)
        yx = mosaic.window(0, 0, canvas.height, canvas.width, run)
        return sourcemap.SourceMap(yx, None, None, (exemplars[0].source,), canvas.wrap, self.blend)
