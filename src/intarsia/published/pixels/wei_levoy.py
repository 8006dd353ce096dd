"""Wei-Levoy synthesis: in raster order, each pixel is the one with the best matching causal neighbourhood.

Wei and Levoy, "Fast Texture Synthesis using Tree-structured Vector Quantization", SIGGRAPH 2000, as Multrus 2003
describes it (chapter 2).

Departures, all but the last three off with ``noise="white"``: the noise at the beginning is made of exemplar pixels, so
that it has the texture's own colours; where the last rows and columns see the first ones across the border, these
count, too, and the first ones, which saw noise, are filled a second time at the end, so that the border fits; pixels of
a start count on all sides; a canvas that does not wrap is cut from a slightly larger torus; finer levels begin with
what the coarser one shows; the tree is a kd-tree whose best few are compared exactly, together with the continuations
of the pixels beside, in place of a quantiser.

Cost: exact, all neighbourhoods of the exemplar for each pixel; with the tree, 24 of its leaves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...foundation.params import param
from ...methods import Ability
from .raster_window import RasterWindow


@dataclass(frozen=True)
class WeiLevoy(RasterWindow):
    """Fill the canvas row by row with the pixels whose neighbourhoods match best; the result is tileable."""

    slug: ClassVar[str] = "wei-levoy"
    paper: ClassVar[str] = "Wei and Levoy 2000; Multrus 2003"
    summary: ClassVar[str] = "pixels row by row, the best fitting of all"
    engine: ClassVar[str] = "intarsia.published.pixels.raster_engine"
    stage: ClassVar[int] = 200020
    widest: ClassVar[int] = 13
    at_once: ClassVar[int] = 64
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.WRAP, Ability.START, Ability.MASK, Ability.SEVERAL})

    levels: int = param(1, "int", "levels of detail, the coarsest first, each half the size of the next", low=1, high=8)
    matching: str = param(
        "tree", "choice", "search a kd-tree for a few similar neighbourhoods, or compare all", choices=("tree", "exact")
    )
    noise: str = param(
        "exemplar", "choice", "what the canvas is before: pixels of the exemplar, or white noise; white: as published, "
        "only what lies above and to the left counts, and no pixel is filled twice",
        choices=("exemplar", "white"),
    )  # fmt: skip
