"""Near-regular textures: blocks of whole periods at random, the gaps between them filled to fit.

Lopez Recas, Hilsmann and Eisert, "Near-regular texture synthesis by random sampling and gap filling", VMV 2011,
and Lopez Recas's thesis of the same year, 4.2.

Each of the ways to lay has its own file, and tells there what departs from the source: the mosaic of lattice blocks
(`blocks/mosaic.py`), courses where only rows repeat (`courses/wall.py`), and the best tile, where an exemplar holds too
little for a mosaic (`tiles/tiling.py`). The blocks of the source are the method `gap-filling`.

Courses that converge or bow are first laid straight, by a map of whole pixels. The thesis names this as future work
(chapter 6); how it is done is this project's own.

Cost: for every second block a comparison of all its positions on the pixels around it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Protocol

from ..blend import Blend
from ..errors import ParameterError
from ..lazy import lazy
from ..params import AUTO, param
from . import parameters
from .base import Ability, MethodBase

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .. import canvas, sourcemap
    from ..analysis import features
    from ..arrays import Laid
    from ..blocks import grid, mosaic, places, pose_sheet
    from ..canvas import Canvas
    from ..courses import rectified as rectification
    from ..courses import unequal, wall
    from ..exemplar import Exemplar
    from ..geometry import Box
    from ..patches import continuation
    from ..run import Run
    from ..tiles import tiling
else:
    canvas = lazy("intarsia.canvas")
    unequal = lazy("intarsia.courses.unequal")
    wall = lazy("intarsia.courses.wall")
    features = lazy("intarsia.analysis.features")
    rectification = lazy("intarsia.courses.rectified")
    continuation = lazy("intarsia.patches.continuation")
    grid = lazy("intarsia.blocks.grid")
    mosaic = lazy("intarsia.blocks.mosaic")
    places = lazy("intarsia.blocks.places")
    pose_sheet = lazy("intarsia.blocks.pose_sheet")
    tiling = lazy("intarsia.tiles.tiling")
    sourcemap = lazy("intarsia.sourcemap")


FEW = "the exemplar holds fewer than two places for a block, so its best tile is repeated; a larger one varies more."
SEEDS = 4  # whose layouts are kept at a time


class Layer(Protocol):
    """An endless texture: any window of it can be made alone."""

    def window(
        self, y0: int, x0: int, height: int, width: int, run: Run
    ) -> tuple[NDArray[np.int32], NDArray[np.uint8] | None]:
        """The exemplar pixels (height, width, 2) and the poses (height, width) of a window; None: all upright."""


@dataclass(frozen=True)
class NearRegular(MethodBase):
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
        AUTO, "int", "wanted side of a block, rounded to whole periods; automatic: one period, at least about 40 px",
        low=4, high=1 << 14, unit="px",
    )  # fmt: skip
    border: int = param(
        14, "int", "width of the zone in which a gap is compared and cut in", low=2, high=256, unit="px"
    )
    slack: int = param(3, "int", "how far a gap's block may leave the lattice", low=0, high=16, unit="px")
    bend: int = param(
        0, "int", "how far parts of a gap's block may move so that lines meet; 0: stiff",
        low=0, high=8, unit="px",
    )
    heights: str = param(
        "equal", "choice", "heights of courses: equal, as the lattice says, or unequal, by the lines that run across "
        "the exemplar between them; the lattice then is their mean pitch",
        choices=("equal", "unequal"),
    )
    isometries: str | tuple[int, ...] = parameters.poses()
    straighten: str = param(
        "auto", "choice", "lay slanted, converging or bent courses straight first, by whole px; auto: where they then "
        "repeat much better, not with given vectors; on: wherever they are not straight; vectors then hold after it",
        choices=("auto", "on", "off"),
    )  # fmt: skip
    channel_weights: tuple[float, ...] | None = parameters.channel_weights()
    spread: float = parameters.spread_price()
    striking: float | None = parameters.striking_share()

    @property
    def blend(self) -> Blend:
        """Exact copies; courses laid straight mix the steps of their edges over 4 px."""
        return Blend(4 if self.straighten == "on" else 0)

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> NearRegular:
        """Lay the courses straight and find the lattice; MethodError where there is none."""
        parameters.check_finished(self, canvas.endless)
        if self.heights == "unequal":
            self._check_unequal(canvas)
        straighten = self.straighten if canvas.start is None or self.straighten == "on" else "off"
        rectified = replace(self, straighten=straighten)._rectified(exemplars[0])
        lattice = rectified.lattice
        if self.isometries not in ("none", (0,)) and len(lattice) == 1:
            raise ParameterError(
                f"isometries={self.isometries}: along one vector courses are laid, all of them upright; leave it out."
            )
        poses = pose_sheet.resolved_poses(self.isometries, lattice, rectified.exemplar, self.channel_weights)
        straighten = "off" if rectified.straight is None else "on"
        return replace(self, lattice=lattice, isometries=poses, straighten=straighten)

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Place the random blocks of the canvas, then fill the gaps; courses are laid brick by brick."""
        method = self.resolved(exemplars, canvas)
        if parameters.passes_of(method) and method.straighten == "on":
            return method.laid(exemplars, canvas, seed, run)
        return parameters.gone_over(
            method, exemplars, canvas, run, lambda run: method.laid(exemplars, canvas, seed, run)
        )

    def laid(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Lay the blocks or courses of a canvas; known once all parameters are."""
        start = continuation.Continuation.of(canvas, self.border)
        if start is not None and start.full:
            return replace(start.start, which=None, wrap=canvas.wrap, blend=self.blend)
        rectified, layer = self._layer(exemplars[0], canvas, start, seed, run)
        origin = (0, 0) if start is None else start.anchor
        source = exemplars[0].source

        def drafted(laid: Laid) -> sourcemap.SourceMap:
            on_exemplar = rectified.to_exemplar(laid[0]), *laid[1:]
            return continuation.drafted(on_exemplar, canvas.start, source, canvas.wrap)

        yx, pose = layer.window(*origin, canvas.height, canvas.width, run.drafting(drafted))
        yx = rectified.to_exemplar(yx)
        if start is not None:
            yx, pose = start.joined(yx, pose, features.features(exemplars, self.channel_weights).pictures[0])
        return sourcemap.SourceMap(yx, None, pose, (source,), canvas.wrap, self.blend)

    def window(self, exemplars: Sequence[Exemplar], box: Box, seed: int, run: Run) -> sourcemap.SourceMap:
        """Lay the blocks that a box meets; what they are cut from is prepared once for an exemplar and a seed."""
        parameters.check_finished(self, True)

        def prepared() -> tuple[Blend, tuple[rectification.Rectified, Layer]]:
            plane = canvas.Canvas(1, 1)
            method = self.resolved(exemplars, plane)
            return method.blend, method._layer(exemplars[0], plane, None, seed, run)

        beside = f"near-regular {seed % SEEDS}"  # so that a few that are looked at in turn do not drive each other out
        blend, (rectified, layer) = exemplars[0].latest(beside, (self, seed), prepared)
        yx, pose = layer.window(box.y0, box.x0, box.height, box.width, run)
        return sourcemap.SourceMap(rectified.to_exemplar(yx), None, pose, (exemplars[0].source,), blend=blend)

    def _check_unequal(self, canvas: Canvas) -> None:
        """Refuse what courses of unequal heights have no place for."""
        if self.spread:
            raise ParameterError("heights=unequal lays stones, not blocks; leave spread out.")
        if self.straighten == "on":
            raise ParameterError("heights=unequal follows courses as they run; leave straighten out.")
        if canvas.start is not None:
            raise ParameterError("heights=unequal lays a whole canvas; take another method where one is begun.")

    def _rectified(self, exemplar: Exemplar) -> rectification.Rectified:
        if self.heights == "unequal":
            lattice = (unequal.masonry_of(exemplar, self.channel_weights).pitch,)
            if self.lattice not in (AUTO, lattice):
                raise ParameterError("heights=unequal finds every course by itself; leave lattice out.")
            return rectification.Rectified(exemplar, lattice, None)
        return rectification.rectified_for(exemplar, self.slug, self.lattice, self.straighten, self.channel_weights)

    def _layer(
        self, exemplar: Exemplar, canvas: Canvas, start: continuation.Continuation | None, seed: int, run: Run
    ) -> tuple[rectification.Rectified, Layer]:
        """What is laid, of what, so that the lattice of a start goes on; too small an exemplar gives one tile."""
        rectified = self._rectified(exemplar)
        exemplar, lattice, weights = rectified.exemplar, rectified.lattice, self.channel_weights
        settings = grid.BlockSettings(
            lattice, self.block, self.border, self.slack, self.bend, self.isometries, weights
        )
        if self.heights == "unequal":
            return rectified, wall.Wall.unequal(weights, exemplar, canvas, seed)
        if len(lattice) == 1:
            return rectified, wall.Wall.of(lattice, weights, exemplar, canvas, seed)
        start = start if rectified.straight is None else None
        try:
            return rectified, mosaic.Mosaic.of(settings, exemplar, canvas, seed, start)
        except places.FewPlaces:
            run.notes.append(FEW)
            return rectified, tiling.Tiling.of(lattice, weights, self.border, exemplar).layout(canvas)
