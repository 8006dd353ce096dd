"""Engine of parallel-controllable and correction-2008: a canvas, a window or a coarse view of the endless map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..analysis.features import features
from ..foundation import ParameterError
from ..foundation.arrays import Float32, Int32
from ..foundation.field import Field
from ..foundation.geometry import Box, Wrap
from ..foundation.params import AUTO, check_sizes, functions_of, parameters
from ..foundation.run import Run
from ..lattice import check_lattice, lattice_of, lattices_of
from ..methods.parallel_controllable import ParallelControllable
from ..model import Exemplar, Exemplars
from ..model.canvas import Canvas
from ..model.sourcemap import SourceMap
from ..search.guide import check_guide
from .appearance import Outlines, marked
from .coordinate_pyramid import INTEGERS_OF, CorrectionParameters, PyramidSynthesis, field_hash
from .guide import StackGuide
from .span import Span, Spans
from .stack import ComparisonSettings, exemplar_stack, is_cloudy, levels_within

FARTHEST = 1 << 48  # px: largest coordinate, which in units of 1 / 4096 px fits into an int64
# Jitter in units of a level's spacing, set by eye: large pieces move anywhere, small ones a little.
FINE = (0.0, 0.0, 0.1, 0.2)  # automatic jitter from the finest level on; the last holds up to a quarter element
ANYWHERE = 1.0  # automatic jitter of the two coarsest levels, of half the exemplar and of all of it


def resolved(method: ParallelControllable, exemplars: Exemplars, canvas: Canvas) -> ParallelControllable:
    """Return the method with automatic parameters decided; raise if parameters do not fit the exemplar."""
    size = None if canvas.endless else (canvas.height, canvas.width)
    check_sizes(method, (exemplars[0].height, exemplars[0].width), size)
    if isinstance(method.feature, Field):
        marked(method.feature, exemplars[0])
    features([exemplars[0]], method.channel_weights)
    if canvas.guide is not None:
        check_guide(exemplars, canvas.guide, 1)
    return decided(method, exemplars[0], canvas.guide is not None)


def decided(method: ParallelControllable, exemplar: Exemplar, guided: bool = False) -> ParallelControllable:
    """Return the method with jitter, keep_lattice and lattice decided.

    Automatic jitter moves large pieces anywhere and small ones a little; levels between a quarter of an element and
    half the exemplar are not jittered, unless the lattice is kept, there is a feature, or the texture is cloudy,
    rotated or scaled.
    """
    lattice, jitter, keep = method.lattice, method.jitter, method.keep_lattice
    if keep == "auto":
        known = lattice is not AUTO
        known = known or (not guided and lattices_of(exemplar, method.channel_weights).accepted is not None)
        keep = "on" if known else "off"
    if lattice is not AUTO:
        check_lattice(lattice, exemplar)
    elif keep == "on":
        lattice = lattice_of(exemplar, method.slug, method.channel_weights)
    if jitter is AUTO:
        top = (max(exemplar.height, exemplar.width) - 1).bit_length()
        all_over = keep == "on" or Outlines.of(method) is not None or not method.exact or is_cloudy(exemplar)
        fine = top if all_over else max(len(FINE), levels_within(exemplar))
        shares = (FINE[min(level, len(FINE) - 1)] if level < fine else 0.0 for level in range(max(top - 1, 0)))
        jitter = (*shares, *[ANYWHERE] * min(top + 1, 2))
    return replace(method, jitter=jitter, lattice=lattice, keep_lattice=keep)


def synthesize(
    method: ParallelControllable, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run
) -> SourceMap:
    """Return the map of a canvas, that of the endless texture from (0, 0) on; axes that wrap are periodic."""
    return _map(method, exemplars[0], canvas, seed, run)


def window(method: ParallelControllable, exemplars: Exemplars, box: Box, seed: int, run: Run) -> SourceMap:
    """Return the map of any window of the endless texture; coordinates up to 2**48 px."""
    if max(abs(side) for side in (box.y0, box.x0, box.y1, box.x1)) > FARTHEST or min(box.height, box.width) < 1:
        raise ParameterError(f"the window {box} is not allowed; give at least 1 px, within 2**48 px of the origin.")
    return _map(method, exemplars[0], box, seed, run)


def coarse(
    method: ParallelControllable, exemplars: Exemplars, box: Box, level: int, seed: int, run: Run
) -> Int32 | None:
    """Return the exemplar pixels at the middles of squares of 2**level px, (h, w, 2), after synthesis of that level.

    Finer levels would move them a little. The time is that of a window of h x w px. `box`: of whole squares. None if
    the exemplar has no such level, or the texture is rotated or scaled.
    """
    descent = _descent(method, exemplars[0], box, seed)
    if descent.rules.orientation is not None or level >= descent.stack.count:
        return None
    return descent.window(*_spans(box), run, level)


def asked(method: ParallelControllable, exemplars: Exemplars, where: Canvas | Box) -> dict[str, str]:
    """Return a hash of the values of each function parameter at all places where a picture evaluates it.

    A recipe cannot store a function, but a picture depends only on these values. Functions over the output are also
    evaluated outside of it, at positions of coarser levels; functions over the exemplar at all of its pixels.
    """
    exemplar, over = exemplars[0], {p.name: p.over for p in parameters(method)}
    outside = _descent(method, exemplar, where, 0).asked(*_spans(where))
    inside = [[np.arange(exemplar.height), np.arange(exemplar.width)]]
    return {
        name: field_hash(field, INTEGERS_OF[name], inside if over[name] == "exemplar" else outside)
        for name, field in functions_of(method).items()
    }


def _map(method: ParallelControllable, exemplar: Exemplar, where: Canvas | Box, seed: int, run: Run) -> SourceMap:
    descent, wrap = _descent(method, exemplar, where, seed), Wrap.NONE if isinstance(where, Box) else where.wrap
    around = descent.around

    def made(yx: Int32, *turned: Float32) -> SourceMap:
        return SourceMap(yx, None, None, (exemplar.source,), wrap, method.blend, *turned)

    run = run.drafting(lambda yx: made(yx[around : len(yx) - around, around : yx.shape[1] - around]))
    if descent.rules.orientation is None:
        return made(descent.window(*_spans(where), run))
    return made(*descent.oriented_window(*_spans(where), run))


def _descent(method: ParallelControllable, exemplar: Exemplar, where: Canvas | Box, seed: int) -> PyramidSynthesis:
    rules = CorrectionParameters.of(decided(method, exemplar))
    levels = exemplar_stack(exemplar, ComparisonSettings.of(method), rules.border)
    wanted = StackGuide(where, levels) if isinstance(where, Canvas) and where.guide is not None else None
    return PyramidSynthesis(levels, rules, seed, wanted)


def _spans(where: Canvas | Box) -> Spans:
    """Return the rows and columns of a canvas, with periods where it wraps, or of a box of the endless plane."""
    if isinstance(where, Box):
        return Span(where.y0, where.y1, 0), Span(where.x0, where.x1, 0)
    return Span(0, where.height, where.height * where.wrap.y), Span(0, where.width, where.width * where.wrap.x)
