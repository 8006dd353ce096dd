"""Ashikhmin: row by row, each pixel continues one of its neighbours just as the exemplar does.

Ashikhmin, "Synthesizing Natural Textures", I3D 2001; with `jumps`, the candidates of Tong and others, "Synthesis of
Bidirectional Texture Functions on Arbitrary Surfaces", SIGGRAPH 2002 (k-coherence).

Departures: of the paper's user control nothing is here; a canvas that does not wrap is cut from a slightly larger
torus; where the last rows and columns see the first ones across the border, or a start, these count and propose, too,
and the first ones, which saw noise, are filled a second time at the end; similar pixels are found by neighbourhoods
above and to the left, the same that are compared.

Cost: a handful of neighbourhoods for each pixel; nothing depends on the exemplar's size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, ClassVar

from ...errors import ParameterError
from ...lazy import lazy
from ...methods.base import Ability, MethodBase
from ...params import AUTO, check, extent, param, words

if TYPE_CHECKING:
    from ... import sourcemap
    from ...canvas import Canvas
    from ...exemplar import Exemplar
    from ...run import Run
    from . import neighbourhoods, raster_kernels, raster_scan, tree
else:
    neighbourhoods = lazy("intarsia.published.pixels.neighbourhoods")
    raster_scan = lazy("intarsia.published.pixels.raster_scan")
    tree = lazy("intarsia.published.pixels.tree")
    raster_kernels = lazy("intarsia.published.pixels.raster_kernels")
    sourcemap = lazy("intarsia.sourcemap")

STAGE = 2001  # keeps this method's draws apart from those of others
LEAST, MOST = 5, 9  # columns of automatic windows
AT_ONCE = 512  # pixels filled between two looks at the clock


@dataclass(frozen=True)
class Ashikhmin(MethodBase):
    """Let small irregular pieces of the exemplar grow row by row; fast, and good at grass, leaves and pebbles."""

    slug: ClassVar[str] = "ashikhmin"
    paper: ClassVar[str] = "Ashikhmin 2001; Tong et al. 2002"
    summary: ClassVar[str] = "pixels that continue their neighbours"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.WRAP, Ability.START, Ability.MASK, Ability.SEVERAL})

    window: int | tuple[int, int] | None = param(
        AUTO, "extent", "neighbourhood that is compared: w_e columns, odd, and h_e rows from the pixel up; automatic: "
        "as wide as the texture's elements up to 9 px, and half as high",
        low=1, high=255, unit="px",
    )  # fmt: skip
    jumps: int = param(0, "int", "similar exemplar pixels tried beside each continuation", low=0, high=64)

    def __post_init__(self) -> None:
        check(self)
        if self.window is not AUTO and (extent(self.window)[1] % 2 == 0 or extent(self.window) == (1, 1)):
            raise ParameterError(f"window={words(self.window)} is not allowed; choose an odd width, and not 1x1.")

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> Ashikhmin:
        """Decide the window from the size of the texture's elements."""
        if self.window is AUTO:
            reach = raster_scan.scan_reach
            side = neighbourhoods.default_window(exemplars, LEAST, MOST, lambda n: reach((n // 2 + 1, n), 1))
            return replace(self, window=(side // 2 + 1, side))
        neighbourhoods.check_window(exemplars, words(self.window), raster_scan.scan_reach(extent(self.window), 1))
        return self

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Fill row after row."""
        method = self.resolved(exemplars, canvas)
        scan = raster_scan.Scan(exemplars, canvas, extent(method.window or 3), 1, (seed, STAGE))
        torus, exemplar = scan.enter()
        similar = tree.similar_pixels(exemplar, torus.choices, scan.components(), method.jumps)
        for pixels in chain(scan.stretches(AT_ONCE), scan.first_ones(AT_ONCE)):
            run.tick(scan.done, scan.total, lambda: scan.map(self.blend))
            raster_kernels.coherent_pixels(torus, exemplar, similar, pixels, scan.room)
        run.tick(scan.total, scan.total, lambda: scan.map(self.blend))
        return scan.map(self.blend)
