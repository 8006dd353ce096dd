"""Parallel controllable synthesis: coordinates handed down from coarse to fine, jittered, and corrected.

Lefebvre and Hoppe, "Parallel controllable texture synthesis", SIGGRAPH 2005, and "Appearance-space texture synthesis",
SIGGRAPH 2006; the correction operation as a memorandum of 2008 defines it (docs/sources-004.md).

Every pixel is a function of its place, the seed and the parameters: any window of an endless texture can be made alone.

Departures: distances are whole numbers; the 32 numbers of a neighbourhood are compared in full, not projected again;
jumps are looked for in a kd-tree and ranked exactly, on coarse levels for every (h / 2)-th pixel; the jumps of a pixel
are those of its different continuations, as in the memorandum (rule=published: those of its neighbours, then shifted);
an exemplar that is no torus is mirrored beyond its borders for comparisons alone: no pixel at the border is a
candidate; for a piece as large as half the exemplar several places are drawn, and the one that repeats its neighbours
least is taken.

Cost: for each pixel, pass and level about five comparisons of 32 numbers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from ..errors import ParameterError
from ..field import Field
from ..geometry import Box, Wrap
from ..lazy import lazy
from ..params import AUTO, check_sizes, functions_of, param
from . import parameters
from .base import Ability, MethodBase

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .. import sourcemap
    from ..analysis import features
    from ..canvas import Canvas
    from ..corrections import descent as corrections_descent
    from ..corrections import guide as corrections_guide
    from ..corrections import outlines as corrections_outlines
    from ..corrections import span, stack
    from ..exemplar import Exemplar
    from ..lattice import vectors
    from ..run import Run
    from ..search import guide
else:
    vectors = lazy("intarsia.lattice.vectors")
    features = lazy("intarsia.analysis.features")
    guide = lazy("intarsia.search.guide")
    corrections_outlines = lazy("intarsia.corrections.outlines")
    corrections_descent = lazy("intarsia.corrections.descent")
    stack = lazy("intarsia.corrections.stack")
    span = lazy("intarsia.corrections.span")
    corrections_guide = lazy("intarsia.corrections.guide")
    sourcemap = lazy("intarsia.sourcemap")

STAGE = 200505  # keeps this method's draws apart from those of others
FARTHEST = 1 << 48  # px: in 1 / 4096 px, as frames and the jitter have it, it stays within an int64
# Set by looking at pictures: large pieces lie anywhere, small ones move a little.
FINE = (0.0, 0.0, 0.1, 0.2)  # automatic jitter from the finest level on, the last for all up to a quarter element
ANYWHERE = 1.0  # the levels of half the exemplar and of all of it


@dataclass(frozen=True)
class ParallelControllable(MethodBase):
    """Refine an endless map of the exemplar from coarse to fine, moving pixels at random and mending what broke."""

    slug: ClassVar[str] = "parallel-controllable"
    paper: ClassVar[str] = "Lefebvre and Hoppe 2005, 2006"
    summary: ClassVar[str] = "coarse to fine, endless: any window alone, randomness set for each scale"
    supports: ClassVar[frozenset[Ability]] = frozenset({Ability.WRAP, Ability.MASK, Ability.GUIDE, Ability.WINDOW})

    jitter: float | tuple[float, ...] | None = param(
        AUTO, "levels", "how far pixels move at random on each level, in steps of that level (1, 2, 4, ... px), the "
        "finest first, the last for all coarser ones; automatic: 0,0,0.1,0.2, 0.2 on up to a quarter of an "
        "element (of clouds, and with snap, feature, angle or zoom: on all), then 0, and 1 from half the exemplar on",
        low=0, high=1,
    )  # fmt: skip
    jitter_output: Field | float | None = param(  # noqa: RUF009
        AUTO, "field", "what part of the jitter holds where in the output, black none, white all of it; automatic: all",
        low=0, high=1, over="output",
    )  # fmt: skip
    jitter_exemplar: Field | float | None = param(  # noqa: RUF009
        AUTO, "field", "what part of the jitter holds for pixels that come from where in the exemplar, so that black "
        "parts stay as they are; automatic: all", low=0, high=1, over="exemplar",
    )  # fmt: skip
    snap: str = param(
        "auto", "choice", "on: pixels move by whole periods of the lattice only, but on the levels of 1 and 2 px, so "
        "that courses and weaves stay in step; auto: where there is a lattice, and no guide",
        choices=("auto", "on", "off"),
    )  # fmt: skip
    lattice: tuple[tuple[float, float], ...] | None = param(
        AUTO, "vectors", "by which steps the texture repeats, where pixels snap; automatic: found in the exemplar",
        low=-65536, high=65536, unit="px",
    )  # fmt: skip
    kappa: float | str = param(
        2, "price", "a jump counts as so many times farther than a continuation, distances not squared; 1: no "
        "preference, inf: never jump",
        low=1, high=1000,
    )  # fmt: skip
    k: int = param(2, "int", "candidates of each kind of continuation: itself and k - 1 similar places", low=1, high=8)
    passes: int = param(2, "int", "how often every pixel of a level is corrected", low=0, high=8)
    subpasses: int = param(
        4, "int", "parts of a pass, which see what the earlier ones found; 1, 4, 9 or 16", low=1, high=16
    )
    neighbourhood: str = param(
        "appearance", "choice", "what is compared: appearance vectors at four points, or the 5 x 5 colours",
        choices=("appearance", "colour"),
    )  # fmt: skip
    neighbourhood_mask: tuple[float, ...] | None = param(
        AUTO, "weights", "with neighbourhood=colour: how much the squared difference of each of the 5 x 5 (or 3 x 3) "
        "pixels counts, row by row; automatic: a Gaussian, 1 in the middle, 1/4 in 2 px", low=0, high=1,
    )  # fmt: skip
    feature: Field | str | None = param(  # noqa: RUF009
        AUTO, "picture", "outlines to keep: the edges of the picture, or those of what is white in a mask of yours; "
        "how far they are is compared as well; automatic: none",
        low=0, high=1, over="exemplar", choices=("edges",),
    )  # fmt: skip
    feature_weight: float = param(
        1, "float", "with feature: how much the distance to the outlines counts; 1: as much as all the colours", low=0,
        high=100,
    )  # fmt: skip
    rule: str = param(
        "near", "choice", "candidates: continuations of the 3 x 3 pixels around and their jumps; jumps looked up "
        "before they are shifted, as published; or of 5 x 5 pixels, as in the memo",
        choices=("near", "published", "memo"),
    )  # fmt: skip
    pin: tuple[tuple[int, ...], ...] | None = param(
        AUTO, "pins", "what of the exemplar is shown where in the output, within a radius; the seam around is found; "
        "automatic: nothing", low=-(1 << 40), high=1 << 40, unit="px",
    )  # fmt: skip
    angle: Field | float = param(  # noqa: RUF009
        0, "field", "how far the texture lies turned, to the left as seen; pixels are then read between pixels",
        low=-180, high=180, unit="degrees", over="output",
    )  # fmt: skip
    zoom: Field | float = param(  # noqa: RUF009
        1, "field", "how many times larger the texture is shown; pixels are then read between pixels",
        low=0.25, high=4, over="output",
    )  # fmt: skip
    channel_weights: tuple[float, ...] | None = parameters.channel_weights()
    spread: float = parameters.spread_price()
    striking: float | None = parameters.striking_share()

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lattice is not AUTO and self.snap == "off":
            raise ParameterError("snap=off moves pixels by no lattice; leave the lattice out, or say snap=on.")
        if math.isqrt(self.subpasses) ** 2 != self.subpasses:
            raise ParameterError(f"subpasses={self.subpasses} is not allowed; choose 1, 4, 9 or 16.")
        if self.neighbourhood_mask is not AUTO:
            object.__setattr__(self, "neighbourhood_mask", self._mask(self.neighbourhood_mask))
        for name in parameters.passes_of(self) if self.pin is not AUTO or not self.exact else ():
            word = "pins" if self.pin is not AUTO else "angle and zoom"
            raise ParameterError(f"{name} lays whole pixels anywhere, and cannot keep {word}; drop it, or drop them.")
        if not self.exact and (self.neighbourhood == "colour" or self.rule == "published"):
            word = "neighbourhood=colour" if self.neighbourhood == "colour" else "rule=published"
            raise ParameterError(f"{word} cannot follow angle and zoom; drop it, or drop them.")

    def _mask(self, mask: tuple[float, ...]) -> tuple[float, ...]:
        """The 25 weights that are meant."""
        if self.neighbourhood != "colour":
            raise ParameterError("neighbourhood_mask needs neighbourhood=colour; say so, or leave it out.")
        if len(mask) not in (9, 25):
            raise ParameterError(
                f"neighbourhood_mask of {len(mask)} numbers is not allowed; give 25 for 5 x 5 pixels, or 9 for 3 x 3."
            )
        if len(mask) == 25:
            return mask
        rows = [(0.0, *mask[n : n + 3], 0.0) for n in (0, 3, 6)]
        return (*[0.0] * 5, *rows[0], *rows[1], *rows[2], *[0.0] * 5)

    @property
    def calmed(self) -> tuple[Field | float | None, Field | float | None]:
        """What part of the jitter holds over the output, and over the exemplar."""
        return self.jitter_output, self.jitter_exemplar

    @property
    def outlines(self) -> corrections_outlines.Outlines | None:
        """Which outlines of the exemplar count, and how much."""
        if self.feature is AUTO or not self.feature_weight:
            return None
        given = self.feature if isinstance(self.feature, Field) else None
        return corrections_outlines.Outlines(given, self.feature_weight)

    @property
    def exact(self) -> bool:
        """Whether pixels are copies: not so where the texture lies turned or scaled."""
        return (self.angle, self.zoom) == (0, 1)

    def resolved(self, exemplars: Sequence[Exemplar], canvas: Canvas) -> ParallelControllable:
        """Decide the jitter, find the lattice; refuse weights and pictures that do not fit."""
        parameters.check_finished(self, canvas.endless)
        size = None if canvas.endless else (canvas.height, canvas.width)
        check_sizes(self, (exemplars[0].height, exemplars[0].width), size)
        if isinstance(self.feature, Field):
            corrections_outlines.marked(self.feature, exemplars[0])
        features.features([exemplars[0]], self.channel_weights)
        if canvas.guide is not None:
            guide.check_guide(exemplars, canvas.guide, 1)
        return self._decided(exemplars[0], canvas.guide is not None)

    def _decided(self, exemplar: Exemplar, guided: bool = False) -> ParallelControllable:
        """Large pieces anywhere, small ones a little, and nothing where corrections could not mend it unseen."""
        lattice, jitter, snap = self.lattice, self.jitter, self.snap
        if snap == "auto":
            known = lattice is not AUTO
            if not known and not guided:
                known = vectors.lattices_of(exemplar, self.channel_weights).accepted is not None
            snap = "on" if known else "off"
        if lattice is not AUTO:
            vectors.check_lattice(lattice, exemplar)
        elif snap == "on":
            lattice = vectors.lattice_of(exemplar, self.slug, self.channel_weights)
        if jitter is AUTO:
            top = (max(exemplar.height, exemplar.width) - 1).bit_length()
            all_over = snap == "on" or self.outlines is not None or not self.exact
            all_over = all_over or stack.is_cloudy(exemplar)
            fine = top if all_over else max(len(FINE), stack.levels_within(exemplar))
            shares = (FINE[min(level, len(FINE) - 1)] if level < fine else 0.0 for level in range(max(top - 1, 0)))
            jitter = (*shares, *[ANYWHERE] * min(top + 1, 2))
        return replace(self, jitter=jitter, lattice=lattice, snap=snap)

    def synthesize(self, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run) -> sourcemap.SourceMap:
        """Compute the window from (0, 0) on; along axes that wrap, a torus of that size."""
        method = self._decided(exemplars[0], canvas.guide is not None)
        return parameters.gone_over(
            method, exemplars, canvas, run, lambda run: self._map(exemplars[0], canvas, seed, run)
        )

    def window(self, exemplars: Sequence[Exemplar], box: Box, seed: int, run: Run) -> sourcemap.SourceMap:
        """Compute any window of the endless texture alone; coordinates up to 2**48 either way."""
        parameters.check_finished(self, True)
        if max(abs(side) for side in (box.y0, box.x0, box.y1, box.x1)) > FARTHEST or min(box.height, box.width) < 1:
            raise ParameterError(f"the window {box} is not allowed; give at least 1 px, within 2**48 px of the origin.")
        return self._map(exemplars[0], box, seed, run)

    def coarse(
        self, exemplars: Sequence[Exemplar], box: Box, level: int, seed: int, run: Run
    ) -> NDArray[np.int32] | None:
        """Return which exemplar pixels the middles of squares of 2**level px show, (h, w, 2), on that level.

        Finer levels move them a little; it is as quick as a window of so many pixels. `box` is one of whole squares.
        None where the exemplar is too small, or lies turned or scaled.
        """
        descent = self._descent(exemplars[0], box, seed)
        if descent.rules.lie is not None or level >= descent.stack.count:
            return None
        return descent.window(*_spans(box), run, level)

    def asked(self, exemplars: Sequence[Exemplar], where: Canvas | Box) -> dict[str, str]:
        """Return a hash of what each function among the parameters says at all places that a picture asks it for.

        Those over the output are asked beside it as well, where its coarse levels begin.
        """
        if not functions_of(self):
            return {}
        places = self._descent(exemplars[0], where, 0).asked(*_spans(where))
        return corrections_descent.hashes(self, exemplars[0], places)

    def _map(self, exemplar: Exemplar, where: Canvas | Box, seed: int, run: Run) -> sourcemap.SourceMap:
        descent, source = self._descent(exemplar, where, seed), (exemplar.source,)
        wrap = Wrap.NONE if isinstance(where, Box) else where.wrap
        around = descent.around

        def drafted(yx: NDArray[np.int32]) -> sourcemap.SourceMap:
            seen = yx[around : len(yx) - around, around : yx.shape[1] - around]
            return sourcemap.SourceMap(seen, None, None, source, wrap, self.blend)

        run = run.drafting(drafted)
        if descent.rules.lie is None:
            return sourcemap.SourceMap(descent.window(*_spans(where), run), None, None, source, wrap, self.blend)
        yx, frame, sub = descent.framed(*_spans(where), run)
        return sourcemap.SourceMap(yx, None, None, source, wrap, self.blend, frame, sub)

    def _descent(self, exemplar: Exemplar, where: Canvas | Box, seed: int) -> corrections_descent.Descent:
        rules = corrections_descent.Corrections.of(self._decided(exemplar))
        levels = stack.exemplar_stack(exemplar, stack.Look.of(self, rules.border))
        if isinstance(where, Box) or where.guide is None:
            return corrections_descent.Descent(levels, rules, seed, STAGE)
        return corrections_descent.Descent(levels, rules, seed, STAGE, corrections_guide.StackGuide(where, levels))


def _spans(where: Canvas | Box) -> tuple[span.Span, span.Span]:
    """The rows and columns of a canvas, which may close in themselves, or of a box of the endless plane."""
    if isinstance(where, Box):
        return span.Span(where.y0, where.y1, 0), span.Span(where.x0, where.x1, 0)
    periods = (where.height if where.wrap.y else 0), (where.width if where.wrap.x else 0)
    return span.Span(0, where.height, periods[0]), span.Span(0, where.width, periods[1])
