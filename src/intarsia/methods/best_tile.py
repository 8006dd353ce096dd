"""Best tile: repetition of the one period of a regular texture whose opposite borders differ least.

Lopez Recas, Hilsmann and Eisert, "Near-regular texture synthesis by random sampling and gap filling", VMV 2011,
and Lopez Recas's thesis of the same year, 4.1: the best self-similar tile, repeated.

Departures: lattice vectors are exact fractions of a px, so that nothing drifts; masked pixels are not used; on a
periodic canvas the lattice is strained by at most 2 %; of a 1-D lattice whole courses are repeated, cut across where
the cut shows least.

Cost: one difference image for each vector, running sums over it, and a division for every output pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

from .. import methods
from ..foundation.params import Steps, Weights, param


@dataclass(frozen=True)
class BestTile(methods.EndlessBase):
    """Best tile: repeat the one period of a regular texture whose opposite borders differ least.

    Parameters
    ----------
    lattice : one or two vectors (x, y), px, optional
        The periods of the texture; default: found in the exemplar.
    band : int
        Width, 1 to 256 px, of the borders of the tile that are compared, default 8; narrower where the exemplar has no
        room.
    channel_weights : tuple of float, optional
        How much each channel counts; default: 0.3, 0.59, 0.11 for red, green, blue.

    Raises
    ------
    ParameterError
        for a value out of range.
    """

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
