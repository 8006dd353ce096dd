"""The settings of patch methods: size and place of the windows, poses, search, and what a repeat costs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..canvas import Canvas
from ..geometry import hang, spread
from ..guide import Guide
from ..search.candidates import Search
from ..search.posed import PosedExemplars, isometry_ids
from ..search.windows import WindowGrid
from .fill_order import fill_order
from .repetition import RepetitionRule


@dataclass(frozen=True)
class PatchSettings:
    """How patches are laid: their size, where, from what, and at which price.

    Attributes
    ----------
    patch, overlap : (rows, columns)
        Of a window, px; neighbours share `overlap`.
    hangs : bool
        Windows keep their pitch and may hang over the border (Multrus 2003), or are spread to end at it.
    weights, context, isometries, search
        As the parameters of the methods: channel weights, weight of the surroundings, poses, search.
    pyramid : (filter, kept)
        Of the pyramid search: what is averaged, and how many positions are followed.
    listed : int
        Candidates kept of every search.
    repeats, usage, distance
        The rule of repetition control, its price of a repeat, and the least distance of two.
    rim : int
        How deep start pixels may be replaced, px.
    boundary : int
        Side of the patches along the boundaries of a guide's labels, px; 0: as large as the others.
    boundary_isometries
        The poses that may be used there besides.
    slack : int, optional
        How far one label's pixels may lie in another's region, px, before they are replaced; None: any distance.
    finder : callable, optional
        Makes the search of a method that has one of its own, from variants and the size of the windows.
    """

    patch: tuple[int, int]
    overlap: tuple[int, int]
    hangs: bool = False
    weights: tuple[float, ...] | None = None
    context: float = 0.0
    isometries: str | tuple[int, ...] = "none"
    search: str = "fast"
    pyramid: tuple[str, int] = ("mean", 1)
    listed: int = 16
    repeats: RepetitionRule = RepetitionRule.PRICES
    usage: float = 0.0
    distance: int = 0
    rim: int = 0
    boundary: int = 0
    boundary_isometries: str | tuple[int, ...] = "none"
    slack: int | None = None
    finder: Callable[[PosedExemplars, tuple[int, int]], Search] | None = None

    def poses(self, guide: Guide | None) -> tuple[int, ...]:
        """The isometries in which patches are taken, those for boundaries of labels included."""
        own = isometry_ids(self.isometries)
        if guide is None or not guide.is_labels:
            return own
        return tuple(sorted({*own, *isometry_ids(self.boundary_isometries)}))

    def layout(self, canvas: Canvas) -> WindowGrid:
        """The windows on a canvas: a grid, or around what it starts with; under a guide always a grid."""
        if canvas.guide is None and canvas.start is not None and not canvas.start.holes.all():
            patch = (min(self.patch[0], canvas.height), min(self.patch[1], canvas.width))
            overlap = (min(self.overlap[0], patch[0] - 1), min(self.overlap[1], patch[1] - 1))
            wraps = canvas.wrap.y, canvas.wrap.x
            found = fill_order(~canvas.start.holes, patch, overlap, wraps)
            return WindowGrid((), (), patch, canvas.height, canvas.width, *wraps, tuple(found))
        rows, height = self._axis(0, canvas.height, canvas.wrap.y)
        columns, width = self._axis(1, canvas.width, canvas.wrap.x)
        return WindowGrid(
            tuple(rows), tuple(columns), (height, width), canvas.height, canvas.width, canvas.wrap.y, canvas.wrap.x
        )

    def _axis(self, axis: int, length: int, wrap: bool) -> tuple[list[int], int]:
        if self.hangs and not wrap:
            return hang(length, self.patch[axis], self.overlap[axis])
        return spread(length, self.patch[axis], self.overlap[axis], wrap)
