"""What a finished picture is gone over for: what strikes and returns, and what strikes more often than asked."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..canvas import Canvas
from ..exemplar import Exemplars
from ..methods.base import Method, keeps_lattice, traits
from ..run import Run
from ..segments.wholes import wholes
from ..sourcemap import SourceMap
from .covering import Laying
from .spreading import spread_out
from .striking import thinned


def gone_over(
    method: Method, asked: Mapping[str, float], exemplars: Exemplars, canvas: Canvas, run: Run,
    make: Callable[[Run], SourceMap],
) -> SourceMap:  # fmt: skip
    """Make the map of a method, and go over it for what is `asked`: `spread` and `striking`, and by how much."""
    parts = 1 + len(asked)
    smap, its = make(run.part(0, parts)), traits(method)
    lattice = method.lattice if keeps_lattice(method) else None  # type: ignore[attr-defined]
    own = canvas.start is None  # else it may be what was given
    laying = Laying(its.channel_weights, its.isometries, lattice or (), its.min_repeat_distance, own)
    if "spread" in asked:
        smap = spread_out(asked["spread"], laying, exemplars, canvas, smap, run.part(1, parts))
    whole = getattr(method, "whole", 0) and all(wholes(e) is not None for e in exemplars)
    if "striking" in asked and not whole:  # to cover one of packed elements would fuse two others
        smap = thinned(asked["striking"], laying, exemplars, canvas, smap, run.part(parts - 1, parts))
    return smap
