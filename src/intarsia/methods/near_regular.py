"""Near-regular texture synthesis: random blocks of whole lattice periods, with the gaps between them filled to fit.

Lopez Recas, Hilsmann and Eisert, "Near-regular texture synthesis by random sampling and gap filling", VMV 2011,
and Lopez Recas's thesis of the same year, 4.2.

Each layout has its own file, with its departures from the source: the mosaic of lattice blocks
(`regular/mosaic.py`), courses for 1-D lattices (`regular/wall.py`), and the best tile, if an exemplar is too small for
a mosaic (`regular/tile_search.py`). The blocks of the source are the method `gap-filling`.

Courses that converge or bow are rectified first, by a map of whole pixels. The thesis names this as future work
(chapter 6); the algorithm is this project's own.

Cost: for every second block a comparison of all its positions on the pixels around it.
"""

from __future__ import annotations

from dataclasses import dataclass

from .. import methods
from ..foundation.blend import Blend
from ..foundation.params import AUTO, Steps, Weights, param


@dataclass(frozen=True)
class NearRegular(methods.EndlessBase):
    """Near-regular texture synthesis: random blocks of whole periods, and blocks that fit in the gaps between them.

    Parameters
    ----------
    lattice : one or two vectors (x, y), px, optional
        The periods of the texture; default: found in the exemplar.
    block : int, px, optional
        Wanted side of a block, rounded to whole periods; default: one period, at least about 40 px.
    border : int
        Width of the zone in which a gap is compared and cut in, 2 to 256 px, default 14.
    lattice_tolerance : int
        How far a gap's block may deviate from the lattice, 0 to 16 px, default 3.
    course_heights : {"equal", "unequal"}
        Heights of courses: as the lattice says (default), or by the lines that run across the exemplar between them.
    straighten : {"auto", "on", "off"}
        Rectify slanted, converging or bent courses first; default "auto": if they then repeat much better.
    channel_weights : tuple of float, optional
        How much each channel counts; default: 0.3, 0.59, 0.11 for red, green, blue.

    Raises
    ------
    ParameterError
        for a value out of range.
    """

    slug = "near-regular"
    paper = "Lopez Recas, Hilsmann and Eisert 2011"
    summary = "bricks, tiles, weaves: blocks of whole periods, gaps filled to fit"
    engine = "intarsia.regular.near_regular"
    supports = methods.abilities("wrap", "mask", "window")

    lattice: Steps | None = methods.lattice_vectors(
        "the lattice vectors of the texture; automatic: found in the exemplar"
    )
    block: int | None = param(
        AUTO, "int", "wanted side of a block, rounded to whole periods; automatic: one period, at least about 40 px",
        low=4, high=1 << 14, unit="px",
    )  # fmt: skip
    border: int = param(
        14, "int", "width of the zone in which a gap is compared and cut in", low=2, high=256, unit="px"
    )
    lattice_tolerance: int = param(
        3, "int", "how far a gap's block may deviate from the lattice", low=0, high=16, unit="px"
    )
    course_heights: str = param(
        "equal", "choice", "heights of courses: equal, as the lattice says, or unequal, by the lines that run across "
        "the exemplar between them; the lattice then is their mean pitch",
        choices=("equal", "unequal"),
    )
    straighten: str = param(
        "auto", "choice", "rectify slanted, converging or bent courses first, by whole px; auto: if they then repeat "
        "much better, not with given vectors; on: whenever courses of bricks are not straight; vectors hold after it",
        choices=("auto", "on", "off"),
    )  # fmt: skip
    channel_weights: Weights = methods.channel_weights()

    @property
    def blend(self) -> Blend:
        """Exact copies; rectified courses are feathered over 4 px."""
        return Blend(4 if self.straighten == "on" else 0)
