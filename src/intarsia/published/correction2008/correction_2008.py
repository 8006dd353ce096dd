"""Parallel controllable texture synthesis with the candidate sets and the distance of a memorandum of 2008.

A memorandum of 2008 on the correction operation of Lefebvre and Hoppe (docs/sources-004.md); rule=published is that of
their paper of 2005.

Departures: those of parallel-controllable; of a pixel's similar places k - 1 are jumped to, as it is one of the k
itself; neighbourhoods have 5 x 5 pixels, or 3 x 3 by a mask.

Cost: up to twice that of parallel-controllable.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...foundation import ParameterError
from ...foundation.params import AUTO, param
from ...methods.parallel_controllable import ParallelControllable


@dataclass(frozen=True)
class Correction2008(ParallelControllable):
    """Refine an endless map from coarse to fine; each pixel takes the nearest of its proximity and its jump set."""

    slug = "correction-2008"
    paper = "memorandum of 2008"
    summary = "coarse to fine, corrected by colours and candidates of a memorandum"

    k: int = param(2, "int", "candidates of each kind of continuation: itself and k - 1 similar places", low=1, high=8)
    subpasses: int = param(
        4, "int", "parts of a pass, which see what the earlier ones found; 1, 4, 9 or 16", low=1, high=16
    )
    neighbourhood: str = param(
        "colour", "choice", "what is compared: the 5 x 5 colours, or appearance vectors at four points",
        choices=("colour", "appearance"),
    )  # fmt: skip
    neighbourhood_mask: tuple[float, ...] | None = param(
        AUTO, "weights", "with neighbourhood=colour: how much the squared difference of each of the 5 x 5 (or 3 x 3) "
        "pixels counts, row by row; automatic: a Gaussian, 1 in the middle, 1/4 in 2 px", low=0, high=1,
    )  # fmt: skip
    rule: str = param(
        "memo", "choice", "candidates: continuations of the 5 x 5 pixels around and their jumps; of 3 x 3; or, as in "
        "2005, of 3 x 3, jumps looked up before they are shifted",
        choices=("memo", "near", "published"),
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if math.isqrt(self.subpasses) ** 2 != self.subpasses:
            raise ParameterError(f"subpasses={self.subpasses} is not allowed; choose 1, 4, 9 or 16.")
        if self.neighbourhood_mask is not AUTO:
            object.__setattr__(self, "neighbourhood_mask", self._mask(self.neighbourhood_mask))
        if not self.exact and (self.neighbourhood == "colour" or self.rule == "published"):
            word = "neighbourhood=colour" if self.neighbourhood == "colour" else "rule=published"
            raise ParameterError(f"{word} cannot follow angle and zoom; drop it, or drop them.")

    def _mask(self, mask: tuple[float, ...]) -> tuple[float, ...]:
        """Return the mask as 25 weights; ParameterError if it has another length, or vectors are compared."""
        if self.neighbourhood != "colour":
            raise ParameterError("neighbourhood_mask needs neighbourhood=colour; say so, or leave it out.")
        if len(mask) not in (9, 25):
            raise ParameterError(
                f"neighbourhood_mask of {len(mask)} numbers is not allowed; give 25 for 5 x 5 pixels, or 9 for 3 x 3."
            )
        if len(mask) == 25:
            return mask
        rows = [(0.0, *mask[n : n + 3], 0.0) for n in (0, 3, 6)]
        return (*[0.0] * 5, *rows[0], *rows[1], *rows[2], *[0.0] * 5)
