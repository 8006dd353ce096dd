"""Pixels of a level: which of them a window needs, and where in the output they lie."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .correction_kernels import Axis

Array = NDArray[Any]


class Span(NamedTuple):
    """Pixels start .. stop-1 of an axis at some level; `period` of them close in themselves, if it is not 0."""

    start: int
    stop: int
    period: int

    @property
    def at(self) -> Array:
        """The absolute coordinates, each one in the first period."""
        every = np.arange(self.start, self.stop, dtype=np.int64)
        return every % self.period if self.period else every

    def wider(self, margin: int) -> Span:
        """The span with so many more px on either side."""
        return Span(self.start - margin, self.stop + margin, self.period)

    def above(self) -> Span:
        """The pixels of the next coarser level that these come from."""
        if self.period:
            above = (self.period + 1) // 2
            return Span(0, above, above)
        return Span(self.start >> 1, ((self.stop - 1) >> 1) + 1, 0)


def at_rest(span: Span) -> Axis:
    """The pixels of a level, each from itself."""
    return Axis(np.arange(len(span.at)), np.zeros(len(span.at), np.int64), span.at)


def places_of(level: int, spans: list[tuple[Span, Span]]) -> list[Array]:
    """Where in the output the rows and the columns of a level lie, px."""
    return [place_of(own.at, own, level, whole.period) for own, whole in zip(spans[level], spans[0], strict=True)]


def place_of(at: Array, span: Span, level: int, whole: int) -> Array:
    """Where in the output the pixels `at` of a span lie, px: the middle of the squares that they stand for.

    A torus of `whole` px is shared out evenly among its pixels.

    Where they cannot all be `h` px apart, the odd steps lie in other places on every level.
    """
    if span.period:
        odd = 2 * span.period * (level * 79 % 128) // 128  # 79 / 128: about the golden section
        return np.asarray(((2 * at + 1) * whole + odd) // (2 * span.period))
    return np.asarray((at << level) + ((1 << level) >> 1))
