"""Efros-Leung non-parametric sampling: the texture grows outward from a seed, one pixel at a time.

Efros and Leung, "Texture Synthesis by Non-parametric Sampling", ICCV 1999, as Multrus 2003 describes it
(chapter 2).

Departures: candidates at exactly the tolerance count, too, for otherwise there are none where the best fits exactly;
the Gaussian's weights are whole numbers, so that every machine draws the same pixel; there is no upper
limit on the best distance, so no pixel is ever postponed; pixels of a layer with equally many known neighbours
follow in an order that is drawn.

Cost: all windows of the exemplar are compared for each output pixel, most of them only in their nearest pixels.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...foundation import ParameterError
from ...foundation.params import AUTO, check, extent, param, words
from ...methods import Ability, MethodBase


@dataclass(frozen=True)
class EfrosLeung(MethodBase):
    """Grow the texture outward from a seed; each pixel is drawn from those with the most similar neighbourhoods."""

    slug: ClassVar[str] = "efros-leung"
    paper: ClassVar[str] = "Efros and Leung 1999; Multrus 2003"
    summary: ClassVar[str] = "pixels grown outward, drawn from similar places"
    engine: ClassVar[str] = "intarsia.published.pixels.efros_leung_engine"
    supports: ClassVar[frozenset[Ability]] = frozenset(
        {Ability.WRAP, Ability.START, Ability.MASK, Ability.ISOMETRIES, Ability.SEVERAL}
    )

    window: int | tuple[int, int] | None = param(
        AUTO, "extent", "neighbourhood that is compared, odd; automatic: the size of the texture's elements",
        low=1, high=255, unit="px",
    )  # fmt: skip
    tolerance: float = param(0.1, "float", "choose among places up to this much worse than the best", low=0, high=100)
    isometries: str | tuple[int, ...] = param("none", "isometries", "which mirrored and turned pieces may be used")

    def __post_init__(self) -> None:
        check(self)
        if self.window is not AUTO and not all(n % 2 and n > 1 for n in extent(self.window)):
            raise ParameterError(f"window={words(self.window)} is not allowed; choose odd numbers from 3 on.")
