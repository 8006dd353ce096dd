"""The settings of patch methods: size and place of the windows, poses, search, and what a repeat costs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from ..canvas import Canvas
from ..geometry import laid
from ..guide import Guide
from ..search.candidates import SHORT_LIST, Search, WindowGrid
from ..search.guide import Guided, WindowGuide
from ..search.posed import PosedExemplars, isometry_ids
from .fill_order import fill_order
from .repetition import Repetition

SLACK = 2  # strays may lie as far as this part of a patch on the wrong side


class Repeats(NamedTuple):
    """What a repeat costs: by which rule, its price, and the least distance of two, px (0: any)."""

    rule: type[Repetition] = Repetition
    usage: float = 0.0
    distance: int = 0


class Boundaries(NamedTuple):
    """How patches lie along the boundaries of a guide's labels.

    ``patch``: their side, px; 0: as large as the others. ``isometries``: poses that may be used there besides.
    ``slack``: how far one label's pixels may lie in another's region, px, before they are replaced; None: any distance.
    """

    patch: int = 0
    isometries: str | tuple[int, ...] = "none"
    slack: int | None = None

    @classmethod
    def of(
        cls, patch: tuple[int, int], side: int | None, isometries: str | tuple[int, ...] | None, slack: int | None
    ) -> Boundaries:
        """Decide for patches of (rows, columns) what is None: half a patch, all poses of its shape, half of that."""
        side = min(patch) // 2 if side is None else side
        poses = isometries if isometries is not None else "both" if patch[0] == patch[1] else "180"
        return cls(side, poses, max(2, (side or min(patch)) // SLACK) if slack is None else slack)


@dataclass(frozen=True)
class PatchSettings:
    """How patches are laid: their size, where, from what, and at which price.

    `weights`, `context`, `structure`, `courses`, `isometries` and `search` as the parameters of these names.
    """

    patch: tuple[int, int]  # rows and columns of a window, px
    overlap: tuple[int, int]  # that neighbours share, px
    # Windows keep their pitch, hang over the border, and begin so many overlaps before it; None: they end at it.
    hangs: int | None = None
    weights: tuple[float, ...] | None = None
    context: float = 0.0  # weight of the surroundings
    structure: float = 0.0  # weight of outlines and slow colour
    courses: float = 0.0  # weight of lines between courses
    isometries: str | tuple[int, ...] = "none"
    search: str = "fast"
    listed: int = SHORT_LIST  # candidates kept of every search
    repeats: Repeats = field(default=Repeats())  # what a repeat costs
    rim: int = 0  # how deep start pixels may be replaced, px
    boundaries: Boundaries = field(default=Boundaries())  # how patches lie along the boundaries of a guide's labels
    # Makes the search of a method that has one of its own, from variants, size of the windows, and how many it lists;
    finder: Callable[[PatchSettings, PosedExemplars, tuple[int, int], int], Search] | None = None
    # and from that, under a guide, what the guide says and the unit of seams, the search under the guide.
    guided: Callable[[Any, WindowGuide, int], Guided[Any]] | None = None

    def poses(self, guide: Guide | None) -> tuple[int, ...]:
        """The isometries in which patches are taken, those for boundaries of labels included."""
        own = isometry_ids(self.isometries)
        if guide is None or not guide.is_labels:
            return own
        return tuple(sorted({*own, *isometry_ids(self.boundaries.isometries)}))

    @property
    def smaller(self) -> PatchSettings | None:
        """How patches are laid along boundaries of labels; None where they are as large as all others."""
        side, least = self.boundaries.patch, min(self.patch)
        if not side or side >= least:
            return None
        rows, columns = (max(1, round(p * side / least)) for p in self.patch)
        shared = zip(self.overlap, (rows, columns), strict=True)
        high, wide = (min(max(min(o, 1), o * side // least), p - 1) for o, p in shared)
        bounds = self.boundaries._replace(patch=0)
        return replace(self, patch=(rows, columns), overlap=(high, wide), boundaries=bounds, rim=max(high, wide))

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
        return laid(length, self.patch[axis], self.overlap[axis], wrap, self.hangs)
