"""Random sampling and gap filling: random blocks of a near-regular texture, gaps filled by the best match.

Lopez Recas, Hilsmann and Eisert, "Near-regular texture synthesis by random sampling and gap filling", VMV 2011,
and Lopez Recas's thesis of the same year, 4.2; departures are listed in `engine.py`.

Cost: for every second block, its border is compared with all of the exemplar, by Fourier transforms.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ... import methods
from ...foundation.blend import Blend
from ...foundation.params import param
from ...methods import Ability, MethodBase


@dataclass(frozen=True)
class GapFilling(MethodBase):
    """Copy square blocks from random places of the lattice, and fill the gaps between them with the best match."""

    slug: ClassVar[str] = "gap-filling"
    paper: ClassVar[str] = "Lopez Recas, Hilsmann and Eisert 2011"
    summary: ClassVar[str] = "square blocks at random places of a lattice, gaps filled to fit"
    engine: ClassVar[str] = "intarsia.published.lopez_recas2011.engine"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.MASK})

    lattice: tuple[tuple[float, float], ...] | None = methods.lattice_vectors(
        "by which steps the texture repeats; automatic: found in the exemplar"
    )
    detector: str = param(
        "contrast", "choice", "how an automatic lattice is found: by contrast, or by the goodness of the source, which "
        "answers on every texture",
        choices=("contrast", "goodness"),
    )  # fmt: skip
    block: int = param(40, "int", "side of a block", low=4, high=1 << 14, unit="px")
    border: int = param(
        10, "int", "width of the zone in which a gap is compared; an even number", low=2, high=256, unit="px"
    )
    lattice_tolerance: int = param(3, "int", "how far a gap's block may leave the lattice", low=0, high=16, unit="px")
    fit: str = param(
        "difference", "choice", "what fits a gap: by squared differences or by correlation",
        choices=("difference", "correlation"),
    )  # fmt: skip
    channel_weights: tuple[float, ...] | None = methods.channel_weights()

    @property
    def blend(self) -> Blend:
        """Blocks are feathered over 4 px."""
        return Blend(4)
