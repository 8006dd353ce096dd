"""Trials: several variants of the chosen method, of which the one that people would prefer by its score is kept.

Tried are the automatic choice, patches of 1.4 and 1.8 elements, then further seeds of all these; whatever was asked for
stays. The automatic choice is kept unless another is better by LEAST_GAIN. No clock decides, so the same request gives
the same picture. Another method is never tried: between methods the score is wrong too often (docs/auto.md).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..foundation import CancelledError, MethodError, ParameterError, lazy
from ..foundation.params import extent, parameters
from ..foundation.run import Run, draw
from ..methods import Method, make
from ..model import Exemplars
from ..model.canvas import Canvas
from ..model.sourcemap import SourceMap
from .auto import FIXED, Choice

if TYPE_CHECKING:
    from .. import judging
else:  # one picture needs none
    judging = lazy("intarsia.judging")

STAGE = 4003  # keeps the seeds of trials apart from other draws
# Of 92 textures 40 have fewer than three sizes to try; halved 89, doubled none.
LARGEST = 0.45  # of the shorter side: of larger patches there are too few places
SIZES = (1.0, 1.4, 1.8)  # patches relative to the automatic one
LEAST_GAIN = 2.2  # of 100: of bests of four, seven of eight that gained so much were preferred blind, nine of 22 others


@dataclass(frozen=True, eq=False)
class Trial:
    """One variant: its method and seed, and the map it made."""

    method: Method
    seed: int
    map: SourceMap


def carried_out(
    choice: Choice, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run
) -> tuple[Choice, Trial, tuple[judging.Score, ...]]:
    """Make the variants of a choice and keep the best; the next method where the first cannot serve the exemplar.

    Returns the choice that it came of, the best of its trials, and all scores in the order of the trials, if there are
    several.
    """
    refused: MethodError | ParameterError | None = None
    for one in _in_turn(choice):
        try:
            best, scores = _best(one, exemplars, canvas, seed, run)
        except (MethodError, ParameterError) as e:
            refused = refused or e
            continue
        if refused is not None:
            run.notes.append(f"{choice.method.slug} was left: {refused}")
        return one, best, scores
    assert refused is not None
    raise refused


def _in_turn(choice: Choice) -> Iterator[Choice]:
    yield choice
    yield from choice.others()


def _best(
    choice: Choice, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run
) -> tuple[Trial, tuple[judging.Score, ...]]:
    tried = trial_methods(choice, canvas, seed)
    if len(tried) == 1:
        method, own = tried[0]
        return Trial(method, own, method.synthesize(exemplars, canvas, own, run)), ()
    scores = list[judging.Score]()
    best: Trial | None = None
    least = 0.0
    for number, (method, own) in enumerate(tried):
        try:
            resolved = method.resolved(exemplars, canvas)
            smap = resolved.synthesize(exemplars, canvas, own, run.part(number, len(tried)))
        except (MethodError, ParameterError) as e:
            if number == 0 or isinstance(e, CancelledError):
                raise
            continue
        scores.append(judging.score_map(exemplars, smap))
        good = scores[-1].total
        if best is None or good > least:
            best, least = Trial(resolved, own, smap), good + (0 if best else LEAST_GAIN)
    assert best is not None
    return best, tuple(scores)


def trial_methods(choice: Choice, canvas: Canvas, seed: int) -> list[tuple[Method, int]]:
    """Return the methods to try with their seeds: at most as many as are asked for, the automatic one first."""
    if choice.method.slug in FIXED:
        return [(choice.method, seed)]
    variants = _sizes(choice, canvas)
    variants[0] = choice.method
    out: list[tuple[Method, int]] = []
    for number in range(choice.trials):
        round_, which = divmod(number, len(variants))
        own = seed if round_ == 0 else draw(seed, STAGE, round_)
        out.append((variants[which], own))
    return out


def _sizes(choice: Choice, canvas: Canvas) -> list[Method]:
    """The method that is chosen with patches of several sizes, the automatic one first."""
    values = {p.name: getattr(choice.method, p.name) for p in parameters(choice.method)}
    whole = values.get("patch")
    if whole is None or "patch" in choice.given or canvas.guide is not None:
        return [choice.method]
    most, automatic = max(1, int(LARGEST * choice.facts.side)), max(extent(whole))
    sides = dict.fromkeys(max(min(round(factor * automatic), most), min(automatic, most)) for factor in SIZES)
    loose = {"overlap": None} if "overlap" in values and "overlap" not in choice.given else {}
    return [make(choice.method.slug, {**values, **loose, "patch": side}) for side in sides]
