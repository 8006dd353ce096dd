"""Parameters that several methods have, told once, and what methods have in common that cut overlapping squares.

A parameter of that name means the same everywhere.
"""

from __future__ import annotations

from functools import partial

from ..errors import ParameterError
from ..params import AUTO, extent, param
from .base import MethodBase

patch_side = partial(
    param, AUTO, "extent",
    "side of the copied square, overlaps included; automatic: the size of the texture's elements",
    low=1, high=1 << 16, unit="px",
)  # fmt: skip
channel_weights = partial(
    param, AUTO, "weights", "how much each channel counts; automatic: 0.3, 0.59, 0.11 for red, green, blue",
    low=0, high=1e6,
)  # fmt: skip
structure_weight = partial(
    param, 1.0, "float", "how much outlines and slow colour count beside colour; 0: colour alone", low=0, high=4
)
poses = partial(
    param, "none", "isometries", "which mirrored and turned patches may be used; auto: those that keep the look"
)
usage_price = partial(param, 0.05, "float", "price of using a patch again, in usual distances", low=0, high=100)
lattice_vectors = partial(param, AUTO, "vectors", low=-65536, high=65536, unit="px")
repeat_distance = partial(
    param, 0, "int", "no exemplar pixel returns within this distance in the output", low=0, high=1 << 20, unit="px"
)
search_ways = partial(
    param, "fast", "choice", "short-list at reduced resolution, or at full resolution", choices=("fast", "exact")
)
spread_price = partial(
    param, 0.0, "float", "price of what strikes and returns: the finished picture is gone over, and it is covered "
    "where that is worth its seams; 8 is much, 0: nothing is",
    low=0, high=100,
)  # fmt: skip
striking_share = partial(
    param, AUTO, "float", "how often a thing that strikes, such as the one leaf on a lawn, is shown, as a share of how "
    "often area asks: 1 as often as in the exemplar, 0 never; the others are covered; automatic: as it comes",
    low=0, high=100,
)  # fmt: skip
cut_cost = partial(
    param, kind="choice", help="cost of a cut: colour difference, that divided by the gradient, or sharp: its square "
    "up to what is clearly seen, so that many faint steps are cheaper than a strong one",
    choices=("difference", "gradient", "sharp"),
)  # fmt: skip
layout = partial(
    param, "spread", "choice", "spread: overlaps widen evenly, so that patches end at the border; raster: patch and "
    "overlap as they are given, cropped at the right and lower border (where the output does not wrap)",
    choices=("spread", "raster"),
)  # fmt: skip
boundary_patch = partial(
    param, AUTO, "int", "side of the patches along boundaries of painted labels; automatic: half; 0: like all others",
    low=0, high=1 << 16, unit="px",
)  # fmt: skip
boundary_poses = partial(
    param, AUTO, "isometries", "poses that patches on such boundaries may have besides; automatic: all of a square"
)
boundary_slack = partial(
    param, AUTO, "int", "how far a label may stray over such a boundary, else it is cut there; automatic: half a patch",
    low=0, high=1 << 16, unit="px",
)  # fmt: skip


class CutSquares(MethodBase):
    """Squares that overlap their neighbours and are cut along seams: what follows from `patch` and `overlap`."""

    patch: int | tuple[int, int] | None
    overlap: int | tuple[int, int] | None
    layout: str = "spread"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.patch is AUTO or self.overlap is AUTO:
            return
        for side, overlap in zip(extent(self.patch), extent(self.overlap), strict=True):
            if overlap >= side:
                raise ParameterError(f"overlap={overlap} is not below patch={side} px; choose 0 to {side - 1} px.")

    @property
    def pitch(self) -> tuple[int, int]:
        """Step from patch to patch, (rows, columns) px; known once patch and overlap are."""
        patch, overlap = extent(self.patch or 0), extent(self.overlap or 0)
        return patch[0] - overlap[0], patch[1] - overlap[1]

    @property
    def hangs(self) -> int | None:
        """From the first corner on at their pitch, or spread to end at the border."""
        return 0 if self.layout == "raster" else None

    @property
    def footprint(self) -> tuple[int, int]:
        """Rows and columns of the exemplar that a patch needs."""
        return extent(self.patch or 0)
