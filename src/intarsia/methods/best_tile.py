"""The best tile, repeated: one period of a regular texture, chosen where its opposite borders agree most.

Lopez Recas, Hilsmann and Eisert, "Near-regular texture synthesis by random sampling and gap filling", VMV 2011,
and Lopez Recas's thesis of the same year, 4.1: the best self-similar tile, repeated.

Departures: lattice vectors of fractions of a px, by exact fractions, so that nothing drifts; pixels under a mask are
not used; around a wrapped canvas the lattice is strained by at most 2 %; courses without a period along them are cut
off where that shows least.

Cost: one difference image for each vector, running sums over it, and a division for every output pixel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from .. import methods
from ..foundation.params import param
from . import Ability, EndlessBase


@dataclass(frozen=True)
class BestTile(EndlessBase):
    """Repeat the one period of the exemplar whose opposite borders agree most."""

    slug: ClassVar[str] = "best-tile"
    paper: ClassVar[str] = "Lopez Recas, Hilsmann and Eisert 2011"
    summary: ClassVar[str] = "one period of a regular texture, again and again"
    engine: ClassVar[str] = "intarsia.regular.best_tile"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.WRAP, Ability.MASK, Ability.WINDOW})

    lattice: tuple[tuple[float, float], ...] | None = methods.lattice_vectors(
        "by which steps the texture repeats; automatic: found in the exemplar"
    )
    band: int = param(
        8, "int", "width of the borders of the tile that are compared; narrower where the exemplar has no room",
        low=1, high=256, unit="px",
    )  # fmt: skip
    channel_weights: tuple[float, ...] | None = methods.channel_weights()
