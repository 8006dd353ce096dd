"""Ashikhmin's coherent synthesis: in raster order, each pixel continues one of its neighbours as in the exemplar.

Ashikhmin, "Synthesizing Natural Textures", I3D 2001.

Departures: of the paper's user control nothing is here; a canvas that does not wrap is cut from a slightly larger
torus; where the last rows and columns see the first ones across the border, or a start, these count and propose, too,
and the first ones, which saw noise, are filled a second time at the end.

Cost: a handful of neighbourhoods for each pixel; nothing depends on the exemplar's size.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...methods import Ability
from .raster_window import RasterWindow


@dataclass(frozen=True)
class Ashikhmin(RasterWindow):
    """Fill the canvas row by row with small irregular pieces of the exemplar; fast; for grass, leaves and pebbles."""

    slug: ClassVar[str] = "ashikhmin"
    paper: ClassVar[str] = "Ashikhmin 2001"
    summary: ClassVar[str] = "pixels that continue their neighbours"
    engine: ClassVar[str] = "intarsia.published.pixels.raster_engine"
    stage: ClassVar[int] = 2001
    widest: ClassVar[int] = 9
    at_once: ClassVar[int] = 512
    levels: ClassVar[int] = 1
    noise: ClassVar[str] = "exemplar"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.WRAP, Ability.START, Ability.MASK, Ability.SEVERAL})
