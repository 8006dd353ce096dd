"""Cost of repeated exemplar pixels, by their saliency, and initial counts along the exemplar's border."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..analysis.features import Features
from ..analysis.saliency import saliency_map, saliency_weights
from ..foundation.arrays import Array, Int32, Mask
from ..foundation.run import Run
from ..model import Exemplars
from .occurrence_kernels import SHARE

RIM = 6  # px from the border count as shown already; 0: of 174 sheets 16 preferred, 38 not, 14 beside 8: alike


def repeat_costs(strikes: Sequence[Array], price: float, due: float, in_step: bool = False) -> Int32:
    """Return what every occurrence of each pixel adds to the cost of the next.

    `strikes`: of each exemplar, how far every pixel is from its likes, in 1/USUAL of the median. A pixel that occurs
    `due` times costs `price`, in units of seam costs; one more than twice as salient as usual, and more
    than nine of ten pixels, costs up to MOST times that, by the square of how much more: the same thing is seen again
    at once. Bare ground (0) costs nothing, as nobody sees that it returns. Nor does, in step, what does not strike: all
    of it returns anyway, and misses are seen at once.
    """
    weight = saliency_weights(strikes, 0.0 if in_step else 1.0)
    return np.rint(SHARE * price * weight / due).astype(np.int32)


def border_counts(usable: Mask, toroidal: bool, due: float) -> Int32:
    """Return the initial count of every exemplar pixel: `due` at the border, falling to 0 RIM px further in.

    Else a cut that takes all that is shown too seldom ends at the border, in a straight line that no seam would take.
    """
    left, depth = np.pad(usable, RIM + 1, mode="wrap" if toroidal else "constant"), np.zeros(1, np.int32)
    for _ in range(RIM + 1):  # as often as it can be peeled, at most
        depth = depth + left
        for axis in (0, 1):
            left = left & np.roll(left, 1, axis) & np.roll(left, -1, axis)
    inner = depth[RIM + 1 : -RIM - 1, RIM + 1 : -RIM - 1]
    return np.rint(due * np.where(inner, RIM + 1 - inner, 0) / RIM).astype(np.int32)


def usage_of(
    feats: Features, exemplars: Exemplars, area: int, price: float, in_step: bool, run: Run
) -> tuple[Int32, Int32]:
    """Return :func:`rates` and :func:`rim` of all exemplar pixels for a canvas of `area` px."""
    due = max(area / max(sum(int(e.free.sum()) for e in exemplars), 1), 1)
    strikes = feats.memo("strikes", lambda: [saliency_map(p[:, :, : feats.base], e.usable, e.toroidal, run)
                                             for p, e in zip(feats.pictures, exemplars, strict=True)])  # fmt: skip
    rate = repeat_costs(strikes, price, due, in_step)
    if in_step:  # where hardly anything costs nothing draws cuts to the border
        return rate, np.zeros_like(rate)
    first = feats.memo(
        ("rim", due), lambda: np.concatenate([border_counts(e.free, e.toroidal, due).ravel() for e in exemplars])
    )
    return rate, first.copy()  # which is counted on
