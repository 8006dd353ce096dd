"""A patch as it was cut into a window of a map."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from ..patches.growth import Pick

Box = tuple[int, int, int, int]  # first row and column, rows and columns


@dataclass(frozen=True, eq=False)
class Cut:
    """A patch cut into a window: what seams cost more than before, where it lies, and which of its pixels are taken."""

    change: int
    box: Box
    pick: Pick
    take: NDArray[Any]


def middle(box: Box) -> Box:
    """The middle of a window, half as high and wide."""
    y, x, h, w = box
    return y + h // 4, x + w // 4, h // 2, w // 2
