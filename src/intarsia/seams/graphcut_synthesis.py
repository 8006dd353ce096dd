"""The method graphcut: windows filled by graph-cut placement, then refined by expansion moves."""

from __future__ import annotations

import math
from dataclasses import replace

from ..foundation import ParameterError
from ..foundation.geometry import UNIT
from ..foundation.params import AUTO, extent
from ..foundation.run import Run
from ..lattice import Vectors, cell_of, check_lattice
from ..methods.graphcut import LARGEST, Graphcut
from ..model import Exemplars
from ..model.canvas import Canvas
from ..model.sourcemap import SourceMap
from ..patches.patch_synthesis import Boundaries, PatchSettings, PatchSynthesis, Stages, decided
from ..search import LEAST, free_patch
from .graphcut_moves import expand, fill
from .graphcut_textures import GraphcutMap, GraphcutSettings
from .lattice_alignment import SLACK, STRAIGHT

STAGE = 2403  # keeps this method's draws apart from those of others
SMALLER = 70  # % of the side of the largest patches, without a lattice or start map; 100 and 50 were judged worse
TOLERANCE = 0.1  # under a guide: a patch is drawn among those that cost at most 10 % more than the best


def resolved(method: Graphcut, exemplars: Exemplars, canvas: Canvas) -> Graphcut:
    """Return the method with window, overlap and overreach set, by the size of the elements and the canvas."""
    room, kept = _room(method, exemplars, canvas), method.lattice or canvas.start is not None
    made: Graphcut = decided(
        method, exemplars, canvas.guide, lambda: min(free_patch(exemplars, 100 if kept else SMALLER), room)
    )
    return replace(made, overreach=min(made.footprint) // 3) if method.overreach is AUTO else made


def synthesize(method: Graphcut, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Fill the canvas in batches of windows, then refine it by expansion moves; under a guide by :func:`_guided`."""
    if canvas.guide is not None:
        return _guided(method, exemplars, canvas, seed, run)
    growth = PatchSynthesis(settings_of(method), exemplars, canvas)
    with run.crew() as crew:
        sewn = GraphcutMap(growth, stitch_of(method), run=crew)
        fill(sewn, seed, STAGE, crew, method.refinements)
        expand(sewn, crew, method.refinements, int(growth.windows.sum()), 1)
    return growth.map(method.blend)


def _guided(method: Graphcut, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run) -> SourceMap:
    """Choose patches window by window under the guide, and cut them in over existing seams; no expansion moves."""
    stages = Stages(settings_of(method, method.repeat_penalty), exemplars, canvas, method.blend)
    in_turn = replace(run, threads=1)  # a cut also reads the pixels next to its window
    for growth in stages:
        sewn = GraphcutMap(growth, stitch_of(method), run=in_turn)
        growth.fill(seed, STAGE, in_turn, choose=TOLERANCE, join=sewn.join)
    return stages.map


def _room(method: Graphcut, exemplars: Exemplars, canvas: Canvas) -> int:
    """Return the largest window side, px, that fits at every offset of a period; LARGEST without a lattice.

    ParameterError for parameters that exclude a lattice.
    """
    if not method.lattice:
        return LARGEST
    check_lattice(method.lattice, exemplars[0])
    for wrong, what in (
        (canvas.guide is not None, "a guide"), (len(exemplars) > 1, "several exemplars"),
        (method.isometries not in ("none", (0,)), f"isometries={method.isometries}"),
    ):  # fmt: skip
        if wrong:
            raise ParameterError(f"patches in step with a lattice do not go with {what}; leave the lattice out.")
    room = min(exemplars[0].height, exemplars[0].width) - math.ceil(max(abs(n) for v in method.lattice for n in v))
    if room < LEAST:
        raise ParameterError("the exemplar holds no patch of 16 px beside one period; leave the lattice out.")
    return room


def _steps(method: Graphcut) -> tuple[Vectors | None, int]:
    """Return the lattice vectors and the slack, px.

    A single vector gets a second one at right angles, so short that places along it are not restricted.
    """
    if not method.lattice:
        return None, 0
    (y, x), second = cell_of(method.lattice, (1 << 16, 1 << 16))
    share = (2 * STRAIGHT + 1) * UNIT / math.hypot(y, x)
    return ((y, x), second or (round(-x * share), round(y * share))), SLACK if second else STRAIGHT


def stitch_of(method: Graphcut) -> GraphcutSettings:
    """Return the parameters of placing and cutting; the method's `overreach` must be decided."""
    return GraphcutSettings(method.repeat_penalty, method.seam, method.overreach or 0, *_steps(method), method.evenness)


def settings_of(method: Graphcut, usage: float = 0.0) -> PatchSettings:
    """Return the parameters of windows, patch and overlap being set; `usage`: price of repeats under a guide."""
    overlap = extent(method.overlap or 0)
    return PatchSettings(
        patch=method.footprint, overlap=overlap, weights=method.channel_weights, structure=method.edge_weight,
        isometries=method.isometries, usage=usage, rim=max(overlap),
        boundaries=Boundaries.of(method.footprint, None, method.isometries, None),
    )  # fmt: skip
