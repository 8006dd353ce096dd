"""Trials: several variants of the chosen method, of which the one that keeps best to the exemplar is kept.

Tried are patches of 1, 1.4 and 1.8 elements, with and without surroundings in the search, then further seeds; whatever
was asked for stays. No clock decides, so the same request gives the same picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..canvas import Canvas
from ..draws import draw
from ..errors import CancelledError, MethodError, ParameterError
from ..exemplar import Exemplar
from ..methods.base import Method, make
from ..params import extent, parameters
from ..run import Run
from ..sourcemap import SourceMap
from .auto import Choice
from .score import Score, score

STAGE = 4003  # keeps the seeds of trials apart from other draws
# Of 92 textures 40 have fewer than three sizes to try; halved 89, doubled none.
LARGEST = 0.45  # of the shorter side: of larger patches there are too few places
FIXED = ("best-tile", "repeat")  # no seed changes them
VARIANTS = ((1.0, 0.0), (1.4, 0.0), (1.0, 1.0), (1.8, 0.0), (1.4, 1.0), (1.8, 1.0))
"""Patch relative to the automatic one, and how much surroundings count."""


@dataclass(frozen=True, eq=False)
class Trial:
    """One variant: its method and seed, the map it made, and its score (None where it is the only one)."""

    method: Method
    seed: int
    map: SourceMap
    score: Score | None = None


def carried_out(
    choice: Choice, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run
) -> tuple[Choice, Trial, tuple[Score, ...]]:
    """Make the variants of a choice and keep the best; the next method where the first cannot serve the exemplar.

    Returns the choice that it came of, the best of its trials, and all scores in the order of the trials.
    """
    refused: MethodError | ParameterError | None = None
    for one in (choice, *choice.others):
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


def _best(
    choice: Choice, exemplars: Sequence[Exemplar], canvas: Canvas, seed: int, run: Run
) -> tuple[Trial, tuple[Score, ...]]:
    tried = trial_methods(choice, canvas, seed)
    if len(tried) == 1:
        method, own = tried[0]
        return Trial(method, own, method.synthesize(exemplars, canvas, own, run)), ()
    scores: list[Score] = []
    best: Trial | None = None
    for number, (method, own) in enumerate(tried):
        step = run.step
        part = run if step is None else replace(run, step=_part(step, number, len(tried)))
        try:
            resolved = method.resolved(exemplars, canvas)
            smap = resolved.synthesize(exemplars, canvas, own, part)
        except (MethodError, ParameterError) as e:
            if number == 0 or isinstance(e, CancelledError):
                raise
            continue
        values = score(exemplars, smap, choice.facts.element.size)
        scores.append(values)
        if best is None or best.score is None or values.total < best.score.total:
            best = Trial(resolved, own, smap, values)
    assert best is not None
    return best, tuple(scores)


def _part(step: Any, number: int, count: int) -> Any:
    return lambda done, total, draft: step(number * total + done, count * total, draft)


def trial_methods(choice: Choice, canvas: Canvas, seed: int) -> list[tuple[Method, int]]:
    """Return the methods to try with their seeds: at most as many as are asked for, the automatic one first."""
    if choice.method.slug in FIXED:
        return [(choice.method, seed)]
    values = {p.name: getattr(choice.method, p.name) for p in parameters(choice.method)}
    whole, sides = values.get("patch"), []
    most = max(1, int(LARGEST * choice.facts.side))
    for factor, context in VARIANTS:
        values = dict(values)
        if whole is not None and "patch" not in choice.given and canvas.guide is None:
            values["patch"] = max(min(round(factor * max(extent(whole))), most), min(max(extent(whole)), most))
            if values["patch"] != whole and "overlap" in values and "overlap" not in choice.given:
                values["overlap"] = None
        if "context" in values and "context" not in choice.given:
            values["context"] = context
        if values not in sides:
            sides.append(values)
    out: list[tuple[Method, int]] = []
    for number in range(choice.trials):
        round_, which = divmod(number, len(sides))
        own = seed if round_ == 0 else draw(seed, STAGE, round_)
        out.append((choice.method if number == 0 else make(choice.method.slug, sides[which]), own))
    return out
