"""Best tile: repetition of the one period of a regular texture whose opposite borders differ least.

Lopez Recas, Hilsmann and Eisert, "Near-regular texture synthesis by random sampling and gap filling", VMV 2011,
and Lopez Recas's thesis of the same year, 4.1: the best self-similar tile, repeated.

Departures: lattice vectors are exact fractions of a px, so that nothing drifts; masked pixels are not used; on a
periodic canvas the lattice is strained by at most 2 %; courses without a period along them are cut where that shows
least.

Cost: one difference image for each vector, running sums over it, and a division for every output pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

from .. import methods
from ..foundation.params import Steps, Weights, param


@dataclass(frozen=True)
class BestTile(methods.EndlessBase):
    """Repeat the one period of the exemplar whose opposite borders differ least."""

    slug = "best-tile"
    paper = "Lopez Recas, Hilsmann and Eisert 2011"
    summary = "one period of a regular texture, again and again"
    engine = "intarsia.regular.best_tile"
    supports = methods.abilities("wrap", "mask", "window")

    lattice: Steps | None = methods.lattice_vectors(
        "the lattice vectors of the texture; automatic: found in the exemplar"
    )
    band: int = param(
        8, "int", "width of the borders of the tile that are compared; narrower where the exemplar has no room",
        low=1, high=256, unit="px",
    )  # fmt: skip
    channel_weights: Weights = methods.channel_weights()
