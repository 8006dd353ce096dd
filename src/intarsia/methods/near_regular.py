"""Near-regular textures: blocks of whole periods at random, the gaps between them filled to fit.

Lopez Recas, Hilsmann and Eisert, "Near-regular texture synthesis by random sampling and gap filling", VMV 2011,
and Lopez Recas's thesis of the same year, 4.2.

Departures of the variant mosaic: the block grid begins where cuts are cheapest, in the joints; blocks are
parallelograms of whole periods, upright where the lattice allows it; positions are rounded from exact multiples of the
real lattice vectors; periods that the exemplar's border cuts are completed from others; every position is used about
equally often; gaps are cut in along the cheapest seam, each inside its own mitred wedges, so that no two cuts meet.

Courses that converge or bow are first laid straight, by a map of whole pixels. The thesis names this as future work
(chapter 6); how it is done is this project's own.

Where only rows repeat (courses of bricks whose joints lie anywhere, boards), the wall is laid course by course from
whole bricks, which is not in the source.

Departures of the variant plain: vectors are real, positions rounded from exact multiples; draws belong to places, so
that any window can be made alone; a wrapped canvas is closed by stretching the lattice.

Cost: for every second block a comparison of all its positions on the pixels around it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from ..errors import ParameterError
from ..lazy import lazy
from ..params import AUTO, check, param
from . import parameters
from .base import Ability

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .. import canvas, sourcemap
    from ..analysis import features
    from ..blocks import gap_filling, mosaic, places, pose_sheet
    from ..canvas import Canvas
    from ..courses import rectified, wall
    from ..exemplar import Exemplar
    from ..geometry import Box
    from ..patches import continuation
    from ..run import Run
    from ..tiles import tiling
    from ..tiles.tile_layout import TileLayout

    Layer = mosaic.Mosaic | wall.Wall | gap_filling.Sampling | TileLayout
else:
    canvas = lazy("intarsia.canvas")
    wall = lazy("intarsia.courses.wall")
    features = lazy("intarsia.analysis.features")
    rectified = lazy("intarsia.courses.rectified")
    continuation = lazy("intarsia.patches.continuation")
    mosaic = lazy("intarsia.blocks.mosaic")
    places = lazy("intarsia.blocks.places")
    pose_sheet = lazy("intarsia.blocks.pose_sheet")
    gap_filling = lazy("intarsia.blocks.gap_filling")
    tiling = lazy("intarsia.tiles.tiling")
    sourcemap = lazy("intarsia.sourcemap")


FEW = "the exemplar holds fewer than two places for a block, so its best tile is repeated; a larger one varies more."


@dataclass(frozen=True)
class NearRegular:
    """Lay blocks of whole periods at random places of the lattice, and fill the gaps between them to fit."""

    slug: ClassVar[str] = "near-regular"
    paper: ClassVar[str] = "Lopez Recas, Hilsmann and Eisert 2011"
    summary: ClassVar[str] = "bricks, tiles, weaves: blocks of whole periods, gaps filled to fit"
    supports: ClassVar[frozenset[Ability]] = frozenset(
        {Ability.WRAP, Ability.START, Ability.MASK, Ability.ISOMETRIES, Ability.WINDOW}
    )

    lattice: tuple[tuple[float, float], ...] | None = param(
        AUTO, "vectors", "by which steps the texture repeats; automatic: found in the exemplar",
        low=-65536, high=65536, unit="px",
    )  # fmt: skip
    block: int | None = param(
        AUTO, "int", "wanted side of a block, rounded to whole periods; automatic: one period, at least about 40 px; "
        "with variant=plain just so wide; automatic: 40",
        low=4, high=1 << 14, unit="px",
    )  # fmt: skip
    border: int | None = param(
        AUTO, "int", "width of the zone in which a gap is compared and cut in; automatic: 14, or 10 with variant=plain",
        low=2, high=256, unit="px",
    )  # fmt: skip
    slack: int = param(3, "int", "how far a gap's block may leave the lattice", low=0, high=16, unit="px")
    bend: int = param(
        0, "int", "with variant=mosaic: how far parts of a gap's block may move so that lines meet; 0: stiff",
        low=0, high=8, unit="px",
    )
    variant: str = param(
        "mosaic", "choice", "blocks of whole periods cut in along joints, or the plain square blocks of the source",
        choices=("mosaic", "plain"),
    )  # fmt: skip
    fit: str = param(
        "difference", "choice", "with variant=plain: what fits a gap, by squared differences or by correlation",
        choices=("difference", "correlation"),
    )  # fmt: skip
    isometries: str | tuple[int, ...] = parameters.poses()
    straighten: str = param(
        "auto", "choice", "lay slanted, converging or bent courses straight first, by whole px; auto: where they then "
        "repeat much better, not with given vectors; on: wherever they are not straight; vectors then hold after it",
        choices=("auto", "on", "off"),
    )  # fmt: skip
    channel_weights: tuple[float, ...] | None = parameters.channel_weights()

    def __post_init__(self) -> None:
        check(self)

    @property
    def blend(self) -> sourcemap.Blend:
        """Exact copies; the plain variant mixes its blocks over 4 px, courses laid straight the steps of edges."""
        return sourcemap.Blend(4 if self.variant == "plain" or self.straighten == "on" else 0)

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> NearRegular:
        """Lay the courses straight and find the lattice; MethodError where there is none."""
        plain = self.variant == "plain"
        border = (10 if plain else 14) if self.border is AUTO else self.border
        block = 40 if plain and self.block is AUTO else self.block
        wanted = self if canvas.start is None or self.straighten == "on" else replace(self, straighten="off")
        footing = rectified.rectified_for(wanted, exemplars[0])
        laid, lattice = footing.exemplar, footing.lattice
        upright = "variant=plain lays all blocks" if plain else "a lattice of one vector has courses that are laid"
        if self.isometries not in ("none", (0,)) and (plain or len(lattice) == 1):
            raise ParameterError(f"isometries={self.isometries}: {upright} upright; leave it out.")
        poses = pose_sheet.resolved_poses(self.isometries, lattice, laid, self.channel_weights)
        straighten = "off" if footing.straight is None else "on"
        return replace(self, lattice=lattice, block=block, border=border, isometries=poses, straighten=straighten)

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Place the random blocks of the canvas, then fill the gaps; courses are laid brick by brick."""
        method = self.resolved(exemplars, canvas)
        footing = rectified.rectified_for(method, exemplars[0])
        held = continuation.Continuation.of(canvas, method.border or 0)
        if held is not None and held.full:
            return replace(held.start, which=None, wrap=canvas.wrap, blend=method.blend)
        layer = self._layer(method, footing, canvas, held, seed, run)
        origin = (0, 0) if held is None else held.anchor
        yx, pose = _laid(layer, (*origin, canvas.height, canvas.width), run)
        yx, source = footing.to_exemplar(yx), exemplars[0].source
        if held is not None:
            yx, pose = held.joined(yx, pose, features.features(exemplars, method.channel_weights).pictures[0])
        return sourcemap.SourceMap(yx, None, pose, (source,), canvas.wrap, method.blend)

    def window(self, exemplars: Sequence[Exemplar], box: Box, seed: int, run: Run) -> sourcemap.SourceMap:
        """Lay the blocks that a box meets; what they are cut from is prepared once for an exemplar and a seed."""

        def prepared() -> tuple[NearRegular, rectified.Rectified, Layer]:
            plane = canvas.Canvas(1, 1)
            method = self.resolved(exemplars, plane)
            footing = rectified.rectified_for(method, exemplars[0])
            return method, footing, self._layer(method, footing, plane, None, seed, run)

        method, footing, layer = exemplars[0].latest("near-regular", (self, seed), prepared)
        yx, pose = _laid(layer, (box.y0, box.x0, box.height, box.width), run)
        return sourcemap.SourceMap(footing.to_exemplar(yx), None, pose, (exemplars[0].source,), blend=method.blend)

    def _layer(
        self, method: NearRegular, footing: rectified.Rectified, canvas: Canvas, held: continuation.Continuation | None,
        seed: int, run: Run,
    ) -> Layer:  # fmt: skip
        """What is laid, so that the lattice of a start goes on; too small an exemplar gives one tile."""
        exemplar = footing.exemplar
        if method.variant == "plain":
            return gap_filling.Sampling.of(method, exemplar, canvas, seed)
        if len(method.lattice or ()) == 1:
            return wall.Wall.of(method, exemplar, canvas, seed)
        try:
            return mosaic.Mosaic.of(method, exemplar, canvas, seed, held if footing.straight is None else None)
        except places.FewPlaces:
            run.notes.append(FEW)
            return tiling.Tiling.of(method, method.border or 0, exemplar).layout(canvas)


def _laid(
    layer: Layer, window: tuple[int, int, int, int], run: Run
) -> tuple[NDArray[np.int32], NDArray[np.uint8] | None]:
    """The pixels and poses of a window (y, x, height, width) of a layer."""
    if isinstance(layer, mosaic.Mosaic):
        return layer.sheet.to_exemplar(layer.window(*window, run))
    if isinstance(layer, (gap_filling.Sampling, wall.Wall)):
        return layer.window(*window, run), None
    return layer.window(*window), None
