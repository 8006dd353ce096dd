"""The best tile, repeated: one period of a regular texture, chosen where its opposite borders agree most.

Lopez Recas, Hilsmann and Eisert, "Near-regular texture synthesis by random sampling and gap filling", VMV 2011,
and Lopez Recas's thesis of the same year, 4.1: the best self-similar tile, repeated.

Departures: lattice vectors of fractions of a px, by exact fractions, so that nothing drifts; pixels under a mask are
not used; around a wrapped canvas the lattice is strained by at most 2 %; courses without a period along them are cut
off where that shows least.

Cost: one difference image for each vector, running sums over it, and a division for every output pixel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from ..lazy import lazy
from ..params import AUTO, param
from . import parameters
from .base import Ability, MethodBase

if TYPE_CHECKING:
    from .. import canvas, sourcemap
    from ..canvas import Canvas
    from ..exemplar import Exemplar
    from ..geometry import Box
    from ..lattice import vectors
    from ..run import Run
    from ..tiles import tiling
    from ..tiles.tile_layout import TileLayout
else:
    canvas = lazy("intarsia.canvas")
    vectors = lazy("intarsia.lattice.vectors")
    tiling = lazy("intarsia.tiles.tiling")
    sourcemap = lazy("intarsia.sourcemap")


@dataclass(frozen=True)
class BestTile(MethodBase):
    """Repeat the one period of the exemplar whose opposite borders agree most."""

    slug: ClassVar[str] = "best-tile"
    paper: ClassVar[str] = "Lopez Recas, Hilsmann and Eisert 2011"
    summary: ClassVar[str] = "one period of a regular texture, again and again"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.WRAP, Ability.MASK, Ability.WINDOW})

    lattice: tuple[tuple[float, float], ...] | None = param(
        AUTO, "vectors", "by which steps the texture repeats; automatic: found in the exemplar",
        low=-65536, high=65536, unit="px",
    )  # fmt: skip
    band: int = param(
        8, "int", "width of the borders of the tile that are compared; narrower where the exemplar has no room",
        low=1, high=256, unit="px",
    )  # fmt: skip
    channel_weights: tuple[float, ...] | None = parameters.channel_weights()

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> BestTile:
        """Find the lattice; MethodError where there is none."""
        if self.lattice is AUTO:
            return replace(self, lattice=vectors.lattice_of(exemplars[0], self.slug, self.channel_weights))
        vectors.check_lattice(self.lattice, exemplars[0])
        return self

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Find the best tile and lay it out; the seed changes nothing."""
        run.tick(0, 2)
        layout = self._layout(exemplars, canvas)
        run.tick(1, 2)
        yx, _ = layout.window(0, 0, canvas.height, canvas.width)
        run.tick(2, 2)
        return sourcemap.SourceMap(yx, None, None, (exemplars[0].source,), canvas.wrap, self.blend)

    def window(self, exemplars: Sequence[Exemplar], box: Box, seed: int, run: Run) -> sourcemap.SourceMap:
        """Lay out what of the tiles a box meets; the tile is found once for an exemplar."""

        layout = exemplars[0].latest("best-tile", self, lambda: self._layout(exemplars, canvas.Canvas(1, 1)))
        yx, _ = layout.window(box.y0, box.x0, box.height, box.width)
        return sourcemap.SourceMap(yx, None, None, (exemplars[0].source,), blend=self.blend)

    def _layout(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> TileLayout:
        lattice, weights = self.resolved(exemplars, canvas).lattice, self.channel_weights
        return tiling.Tiling.of(lattice, weights, self.band, exemplars[0]).layout(canvas)
