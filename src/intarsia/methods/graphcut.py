"""Graph-cut textures: patches of free shape placed by maximum flow, and refinement by expansion moves.

Kwatra, Schoedl, Essa, Turk and Bobick, "Graphcut Textures: Image and Video Synthesis Using Graph Cuts", ACM
Transactions on Graphics (SIGGRAPH) 2003.

Departures: the windows of a grid are filled once, in batches of disjoint windows that may run in parallel, whose order
is that of a raster scan among windows that overlap; a patch extends no further around its window than `overreach`, so
that work and memory stay local; twelve placements are drawn at random
for each window, and the best by coarse cuts on every sixth px is cut in; strong steps cost more than in proportion
(`seam`); placements are compared by outlines and slow colour, too (`edge_weight`); pixels that are used more often than
their share of the area cost more, in the choice of placements (`repeat_penalty`) and in the cut (`evenness`); the
energy of old seams lies on the pixel grid, without seam nodes; refinement does not search placements, but makes an
expansion move (Boykov, Veksler and Zabih 2001) for every piece. With a guide patches are chosen as in image quilting,
without expansion moves.

Cost: for each window one FFT search, twelve maximum flows over a thirty-sixth of the window and its surroundings, and
one over all of it; about 1.2 N_out / pitch^2 windows. For each piece one flow over it and up to two patches around.
"""

from __future__ import annotations

from dataclasses import dataclass

from .. import methods
from ..foundation.params import AUTO, Extent, Poses, Steps, Weights, param

LARGEST = 1 << 16  # px: largest side of a window


@dataclass(frozen=True)
class Graphcut(methods.CutSquares):
    """Graph-cut textures: place large patches cut by minimum cuts, then refine their seams by expansion moves.

    Parameters
    ----------
    patch : int or (rows, columns), px, optional
        Side of a window; default: about one element, half as large again with a lattice or a start map.
    overlap : int or (rows, columns), px, optional
        Width that two neighbours share; default: a third of the patch.
    overreach : int, px, optional
        How far around its window a patch may replace pixels; default: a third of the patch.
    refinements : int
        Rounds of expansion moves, 0 to 1000, default 1.
    seam : {"difference", "gradient", "sharp"}
        Cost of a cut, default "sharp": the squared difference, truncated.
    channel_weights : tuple of float, optional
        How much each channel counts; default: 0.3, 0.59, 0.11 for red, green, blue.
    edge_weight : float
        How much outlines and slow colour count relative to colour, 0 to 4, default 1.
    lattice : one or two vectors (x, y), px, optional
        Offsets of patches are multiples of them, within 3 px (one vector: 1 px); default: any offsets.
    isometries : str or tuple of int
        Which mirrored and rotated patches may be used, default "none".
    repeat_penalty : float
        Price of using a patch again, in usual distances, 0 to 100, default 0.05.
    evenness : float
        Price of using an exemplar pixel more often than its share of the area, in thresholds of the truncated
        quadratic, 0 to 100, default 0.25.

    Raises
    ------
    ParameterError
        for a value out of range, or an overlap that is not below the patch.
    """

    slug = "graphcut"
    paper = "Kwatra et al. 2003"
    summary = "patches of free shape, which grow over each other"
    engine = "intarsia.seams.graphcut_synthesis"
    supports = methods.abilities("wrap", "start", "mask", "guide", "isometries", "several")

    patch: Extent = param(
        AUTO, "extent", "side of a window; automatic: about one element of the texture, half as large again with a "
        "lattice or a start",
        low=1, high=LARGEST, unit="px",
    )  # fmt: skip
    overlap: Extent = param(
        AUTO, "extent", "width that two neighbours share; automatic: a third of the patch",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    overreach: int | None = param(
        AUTO, "int", "how far around its window a patch may replace pixels; automatic: a third of the patch",
        low=0, high=1 << 16, unit="px",
    )  # fmt: skip
    refinements: int = param(
        1, "int", "rounds of expansion moves: every piece may replace its neighbours where that lowers the energy",
        low=0, high=1000,
    )  # fmt: skip
    seam: str = methods.cut_cost("sharp")
    channel_weights: Weights = methods.channel_weights()
    edge_weight: float = methods.edge_weight()
    lattice: Steps | None = methods.lattice_vectors(
        "the lattice vectors of the texture, two or one: offsets of patches from the first are multiples of them, "
        "within 3 px, with one vector 1 px; automatic: any offsets"
    )
    isometries: Poses = methods.poses()
    repeat_penalty: float = methods.repeat_penalty()
    evenness: float = param(
        0.25, "float", "price of using a pixel of the exemplar more often than its share of the area, in knees (three "
        "eighths of the spread of colours); up to 64 times as much if it is salient, nothing on bare ground, with "
        "lattice only salient pixels; 0: none",
        low=0, high=100,
    )  # fmt: skip

    @property
    def keep_lattice(self) -> str:
        """Whether patches are aligned to a lattice."""
        return "on" if self.lattice else "off"
