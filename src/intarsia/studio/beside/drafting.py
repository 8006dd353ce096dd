"""In the process beside: how far a command is, told a few times a second, with a picture of what has grown so far."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .worker import Tell

if TYPE_CHECKING:
    from ...exemplar import Exemplar
    from ...sourcemap import SourceMap

SIDE = 512  # px: a preview is no larger
APART = 0.25  # s between two previews
SHARE = 0.03  # of the time goes into previews, at most


class Drafting:
    """Hears each step of the work; tells the fraction, the stage, and a preview now and then."""

    def __init__(self, tell: Tell) -> None:
        self._tell, self._next, self._told = tell, 0.0, (-1.0, "")

    def __call__(self, fraction: float, stage: str, draft: Any, exemplars: tuple[Any, ...]) -> None:
        now = time.monotonic()
        if stage != self._told[1] or fraction - self._told[0] >= 0.01:
            self._told = (fraction, stage)
            self._tell(fraction=round(fraction, 4), stage=stage)
        if draft is None or now < self._next:
            return
        picture = drawn(draft(), exemplars)
        ended = time.monotonic()
        if picture is not None:
            self._tell(picture, preview=True)
        self._next = ended + (max(APART, (ended - now) / SHARE) if picture is not None else ended - now)


def drawn(smap: SourceMap, exemplars: Sequence[Exemplar], side: int = SIDE) -> bytes | None:
    """Return a PNG of a map, at most `side` px a side: copied pixels, clear where nothing is yet; None of nothing."""
    import numpy as np

    from ...sourcemap import HOLE
    from .pictures import coloured, png

    step = max(-(-max(smap.height, smap.width) // side), 1)
    yx = smap.yx[step // 2 :: step, step // 2 :: step]
    which = np.zeros(yx.shape[:2], np.uint8) if smap.which is None else smap.which[step // 2 :: step, step // 2 :: step]
    if (which == HOLE).all():
        return None
    out = np.zeros((*which.shape, 4), np.uint8)
    for number, exemplar in enumerate(exemplars):
        here = which == number
        if here.any():
            ys, xs = yx[here][:, 0], yx[here][:, 1]
            own = (ys >= 0) & (ys < exemplar.height) & (xs >= 0) & (xs < exemplar.width)
            ys, xs = np.where(own, ys, 0), np.where(own, xs, 0)
            out[here, :3] = coloured(exemplar.base, ys, xs)
            out[here, 3] = np.where(own, 255, 0)
    return png(out) if out[..., 3].any() else None
