"""A tile laid out px by px, in fractions: what the layout of tiles must agree with."""

from __future__ import annotations

from fractions import Fraction
from math import floor

from intarsia.regular.tile_search import TileLayout


def naive_shown(layout: TileLayout, y: int, x: int) -> tuple[int, int]:
    """The px of a tile at a place of the plane, in fractions: whole periods off, the rest rounded (eq. 3.29)."""
    down, across = layout.rates
    dy, dx = y - layout.anchor[0], x - layout.anchor[1]
    shares = [dy * down[k] + dx * across[k] for k in (0, 1)]
    shares = [s - floor(s) for s in shares]
    along = [sum(s * v[k] for s, v in zip(shares, layout.vectors, strict=True)) for k in (0, 1)]
    return tuple(layout.anchor[k] + floor(along[k] / 256 + Fraction(1, 2)) for k in (0, 1))
