"""Plain repetition: the exemplar again and again; right for a picture that is already tileable.

No paper; the yardstick for repetition. Cost: none to speak of.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from ..lazy import lazy
from ..params import check
from .base import Ability

if TYPE_CHECKING:
    import numpy as np

    from .. import sourcemap
    from ..canvas import Canvas
    from ..exemplar import Exemplar
    from ..run import Run
else:
    np = lazy("numpy")
    sourcemap = lazy("intarsia.sourcemap")


@dataclass(frozen=True)
class Repeat:
    """Repeat the exemplar side by side."""

    slug: ClassVar[str] = "repeat"
    paper: ClassVar[str] = "none"
    summary: ClassVar[str] = "the exemplar again and again"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.START})

    def __post_init__(self) -> None:
        check(self)

    @property
    def blend(self) -> sourcemap.Blend:
        """Exact copies."""
        return sourcemap.Blend(0)

    def settled(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> Repeat:
        """Nothing is automatic here."""
        return self

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Take positions modulo the exemplar; the seed changes nothing."""
        run.tick(0, 1)
        exemplar = exemplars[0]
        rows, columns = np.arange(canvas.height) % exemplar.height, np.arange(canvas.width) % exemplar.width
        yx = np.empty((canvas.height, canvas.width, 2), np.int32)
        yx[:, :, 0], yx[:, :, 1] = rows[:, None], columns[None, :]
        pose = None
        if canvas.start is not None:
            kept = ~canvas.start.holes
            yx[kept] = canvas.start.yx[kept]
            if canvas.start.pose is not None:
                pose = np.where(kept, canvas.start.pose, 0)
        run.tick(1, 1)
        return sourcemap.SourceMap(yx, None, pose, (exemplar.source,), canvas.wrap, self.blend)
