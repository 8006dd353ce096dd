"""Plain repetition: the exemplar again and again; right for a picture that is already tileable.

No paper; the yardstick for repetition. Cost: none to speak of.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from ..lazy import lazy
from .base import Ability, MethodBase

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .. import geometry, sourcemap
    from ..canvas import Canvas
    from ..exemplar import Exemplar
    from ..geometry import Box
    from ..run import Run
else:
    geometry = lazy("intarsia.geometry")
    np = lazy("numpy")
    sourcemap = lazy("intarsia.sourcemap")


@dataclass(frozen=True)
class Repeat(MethodBase):
    """Repeat the exemplar side by side."""

    slug: ClassVar[str] = "repeat"
    paper: ClassVar[str] = "none"
    summary: ClassVar[str] = "the exemplar again and again"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.START, Ability.WINDOW})

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Take positions modulo the exemplar; the seed changes nothing."""
        run.tick(0, 1)
        exemplar = exemplars[0]
        yx, pose = _repeated(exemplar, geometry.Box(0, 0, canvas.height, canvas.width)), None
        if canvas.start is not None:
            kept = ~canvas.start.holes
            yx[kept] = canvas.start.yx[kept]
            if canvas.start.pose is not None:
                pose = np.where(kept, canvas.start.pose, 0)
        run.tick(1, 1)
        return sourcemap.SourceMap(yx, None, pose, (exemplar.source,), canvas.wrap, self.blend)

    def window(self, exemplars: Sequence[Exemplar], box: Box, seed: int, run: Run) -> sourcemap.SourceMap:
        """Take positions modulo the exemplar, wherever they are."""
        exemplar = exemplars[0]
        return sourcemap.SourceMap(_repeated(exemplar, box), None, None, (exemplar.source,), blend=self.blend)


def _repeated(exemplar: Exemplar, box: Box) -> NDArray[np.int32]:
    """The exemplar pixels (height, width, 2) of a box."""
    yx = np.empty((box.height, box.width, 2), np.int32)
    yx[:, :, 0] = (np.arange(box.y0, box.y1) % exemplar.height)[:, None]
    yx[:, :, 1] = np.arange(box.x0, box.x1) % exemplar.width
    return yx
