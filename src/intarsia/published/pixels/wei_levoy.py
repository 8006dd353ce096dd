"""Wei-Levoy: row by row, each pixel is the one whose neighbourhood above and to the left fits best.

Wei and Levoy, "Fast Texture Synthesis using Tree-structured Vector Quantization", SIGGRAPH 2000, as Multrus 2003
describes it (chapter 2).

Departures, all but the last three off with ``noise="white"``: the noise at the beginning is made of exemplar pixels, so
that it has the texture's own colours; where the last rows and columns see the first ones across the border, these
count, too, and the first ones, which saw noise, are filled a second time at the end, so that the border fits; pixels of
a start count on all sides; a canvas that does not wrap is cut from a slightly larger torus; finer levels begin with
what the coarser one shows; the tree is a kd-tree whose best few are compared exactly, together with the continuations
of the pixels beside, in place of a quantiser.

Cost: exact, all neighbourhoods of the exemplar for each pixel; with the tree, 24 of its leaves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from ...errors import ParameterError
from ...lazy import lazy
from ...methods.base import Ability, MethodBase
from ...params import AUTO, check, extent, param, words

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ... import sourcemap
    from ...canvas import Canvas
    from ...exemplar import Exemplar
    from ...run import Run
    from . import neighbourhoods, raster_kernels, raster_scan
    from . import tree as pixels_tree
    from .neighbourhood_kernels import Ground
else:
    neighbourhoods = lazy("intarsia.published.pixels.neighbourhoods")
    raster_scan = lazy("intarsia.published.pixels.raster_scan")
    pixels_tree = lazy("intarsia.published.pixels.tree")
    raster_kernels = lazy("intarsia.published.pixels.raster_kernels")
    sourcemap = lazy("intarsia.sourcemap")

STAGE = 200020  # keeps this method's draws apart from those of others
LEAST, MOST = 5, 13  # columns of automatic windows
FEW = 6  # pixels that the tree names
LEAVES = 24  # of the tree, looked into for one pixel
AT_ONCE = 64  # pixels filled between two looks at the clock


@dataclass(frozen=True)
class WeiLevoy(MethodBase):
    """Fill the canvas row by row with the pixels whose surroundings fit best; the result is tileable."""

    slug: ClassVar[str] = "wei-levoy"
    paper: ClassVar[str] = "Wei and Levoy 2000; Multrus 2003"
    summary: ClassVar[str] = "pixels row by row, the best fitting of all"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.WRAP, Ability.START, Ability.MASK, Ability.SEVERAL})

    window: int | tuple[int, int] | None = param(
        AUTO, "extent", "neighbourhood that is compared: w_e columns, odd, and h_e rows from the pixel up; automatic: "
        "as wide as the texture's elements, and half as high",
        low=1, high=255, unit="px",
    )  # fmt: skip
    levels: int = param(1, "int", "levels of detail, the coarsest first, each half the size of the next", low=1, high=8)
    matching: str = param(
        "tree", "choice", "ask a tree for a few similar places, or compare all of them", choices=("tree", "exact")
    )
    noise: str = param(
        "exemplar", "choice", "what the canvas is before: pixels of the exemplar, or white noise; white: as published, "
        "only what lies above and to the left counts, and no pixel is filled twice",
        choices=("exemplar", "white"),
    )  # fmt: skip

    def __post_init__(self) -> None:
        check(self)
        if self.window is not AUTO and (extent(self.window)[1] % 2 == 0 or extent(self.window) == (1, 1)):
            raise ParameterError(f"window={words(self.window)} is not allowed; choose an odd width, and not 1x1.")

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> WeiLevoy:
        """Decide the window from the size of the texture's elements."""
        if self.window is AUTO:
            side = neighbourhoods.default_window(
                exemplars, LEAST, MOST, lambda n: raster_scan.scan_reach((n // 2 + 1, n), self.levels)
            )
            return replace(self, window=(side // 2 + 1, side))
        reach = raster_scan.scan_reach(extent(self.window), self.levels)
        neighbourhoods.check_window(exemplars, words(self.window), reach)
        return self

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Fill level after level, row after row."""
        method = self.resolved(exemplars, canvas)
        side, white = extent(method.window or 3), method.noise == "white"
        scan = raster_scan.Scan(exemplars, canvas, side, method.levels, (seed, STAGE), white)
        for _ in range(method.levels):
            torus, exemplar = scan.enter()
            fill = method.filler(scan, torus, exemplar)
            for pixels in scan.stretches(AT_ONCE):
                run.tick(scan.done, scan.total, lambda: scan.map(self.blend))
                fill(pixels)
            for pixels in scan.first_ones(AT_ONCE):
                run.tick(scan.done, scan.total, lambda: scan.map(self.blend))
                raster_kernels.full_pixels(torus, exemplar, pixels, scan.room)
        run.tick(scan.total, scan.total, lambda: scan.map(self.blend))
        return scan.map(self.blend)

    def filler(
        self, scan: raster_scan.Scan, torus: raster_kernels.Torus, exemplar: Ground
    ) -> Callable[[NDArray[np.int64]], None]:
        """Return what fills pixels (n, 2) of this level, in turn."""
        if self.matching == "exact":
            return lambda pixels: raster_kernels.full_pixels(torus, exemplar, pixels, scan.room)
        tree = pixels_tree.tree_of(exemplar, torus.choices, scan.components())
        return lambda pixels: raster_kernels.tree_pixels(torus, exemplar, tree, LEAVES, FEW, pixels, scan.room)
