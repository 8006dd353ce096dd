"""The choice of a method and of its parameters from what is measured: transparent, and the same on every machine.

    made = ia.synthesize("moss.png", 1024)                                # method="auto"
    choice = ia.Auto(trials=4).choose([ia.read("moss.png")], ia.Canvas(1024, 1024))
    print(choice.rule, choice.method, choice.why)

The rules are in ``rules.py``, the measurements in ``facts.py``.

Trials are several variants of the chosen method, of which the one that people would prefer by its score is kept. Tried
are the automatic choice, patches of 1.4 and 1.8 elements, then further seeds of all these; whatever was asked for
stays. The automatic choice is kept unless another is better by LEAST_GAIN. No clock decides, so the same request gives
the same picture. Another method is never tried: between methods the score is wrong too often (docs/auto.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Any

from ..foundation import (
    AUTO_METHOD,
    FEATHER,
    MOST_TRIALS,
    CancelledError,
    IntarsiaError,
    MethodError,
    ParameterError,
    chosen,
    expect,
    lazy,
    whole_within,
)
from ..foundation.blend import Blend, Levelling
from ..foundation.params import extent, parameters, values_of
from ..foundation.run import Run, draw
from ..methods import METHODS, Ability, Method, make, method_class, needed, parameters_of, traits

if TYPE_CHECKING:
    from .. import judging
    from ..model import Exemplars
    from ..model.canvas import Canvas
    from ..model.sourcemap import SourceMap
    from . import facts as choosing_facts
    from . import rules
else:
    choosing_facts = lazy("intarsia.choosing.facts")
    rules, judging = lazy("intarsia.choosing.rules"), lazy("intarsia.judging")

EVEN = 96  # px to either side of a seam that light is evened out by; 64: steps of slow tone are seen a little more


@dataclass(frozen=True, eq=False)
class Choice:
    """What was chosen, and why.

    Attributes
    ----------
    method : Method
        With every parameter decided.
    rule : str
        The name of the rule that fired; "only" where what was asked for left but this method.
    why, warnings : tuple of str
        Sentences.
    facts : Facts
        What was measured, and can be.
    trials : int
        How many variants are made, to keep the best of.
    given : dict
        The parameters that were asked for.
    others : function
        What comes next, best first, if the method cannot serve this exemplar after all; measured once it is asked.
    """

    method: Method
    rule: str
    why: tuple[str, ...]
    warnings: tuple[str, ...]
    facts: choosing_facts.Facts
    trials: int = 1
    given: Mapping[str, Any] = field(default_factory=dict)
    others: Callable[[], tuple[Choice, ...]] = tuple

    @property
    def decided(self) -> dict[str, Any]:
        """The parameters that were decided, as options of the method: those that differ from the usual ones.

        A size that the method would find by itself is among them, one that no rule decides is not.
        """
        usual = {p.name: (p.default, "off") for p in parameters(self.method)}
        return {k: v for k, v in values_of(self.method).items() if v not in usual[k] and k in DECIDED}

    @property
    def blend(self) -> Blend:
        """How pieces are joined: as the method means it, and steps of light at seams evened out.

        Not where a picture is begun or painted, nor endless, nor where pieces are no exact copies.
        """
        own, canvas, exemplar = self.method.blend, self.facts.canvas, self.facts.exemplars[0]
        if canvas.endless or canvas.start is not None or canvas.guide is not None or not traits(self.method).exact:
            return own
        widest = FEATHER * exemplar.height // max(plane.height for plane in exemplar.planes.values())
        return replace(own, finish=(Levelling(min(EVEN, widest)),)) if widest else own

    @property
    def recipe(self) -> dict[str, Any]:
        """What a recipe says of it; nothing of it is needed to repeat the picture."""
        return {"rule": self.rule, "why": list(self.why)}


@dataclass(frozen=True)
class Auto:
    """Choose the method by what the exemplar is like.

    Parameters
    ----------
    trials : int
        Make so many variants and keep the best, 1 to 64. 1: make one.
    given : dict
        Parameters that the method must have; only methods that have all of them are chosen from.
    needs : set of Ability
        Abilities that it must have, beside those that exemplars and canvas ask for.

    Raises
    ------
    ParameterError
        where no method has these parameters, or allows these values.
    """

    trials: int = 1
    given: Mapping[str, Any] = field(default_factory=dict)
    needs: frozenset[Ability] = frozenset()
    able: tuple[str, ...] = field(init=False, default=(), repr=False)

    slug = AUTO_METHOD

    def __post_init__(self) -> None:
        object.__setattr__(self, "trials", whole_within("trials", self.trials, 1, MOST_TRIALS, "trials"))
        expect(self.given, Mapping, "given", "a dict of parameters")
        expect(self.needs, (set, frozenset), "needs", "a set of abilities")
        object.__setattr__(self, "needs", frozenset(chosen(Ability, "needs", need) for need in self.needs))
        able = [s for s in METHODS if self.given.keys() <= parameters_of(s).keys()]
        able = [s for s in able if self.needs <= method_class(s).supports]
        if not able:
            asked = ", ".join([*self.given, *sorted(a.value for a in self.needs)])
            raise ParameterError(f"no method has all of {asked}; drop some, or name a method.")
        kept, refused = [], None
        for slug in able:
            try:
                make(slug, dict(self.given))
                kept.append(slug)
            except ParameterError as e:
                refused = refused or e
        if not kept:
            assert refused is not None
            raise refused
        object.__setattr__(self, "able", tuple(kept))

    def choose(self, exemplars: Exemplars, canvas: Canvas, run: Run | None = None) -> Choice:
        """Choose by the first rule that holds, among the methods that can do what is asked.

        Raises
        ------
        ParameterError, MethodError
            where none can.
        """
        return self.decide(choosing_facts.Facts(exemplars, canvas, run))

    def decide(self, facts: choosing_facts.Facts) -> Choice:
        """Choose by facts that are known."""
        able = self._able(facts)
        first = next(able)
        return replace(first, warnings=choosing_facts.warnings_of(facts), others=cache(lambda: tuple(able)))

    def _able(self, facts: choosing_facts.Facts) -> Iterator[Choice]:
        """The choices that can serve, best first; an error where there are none."""
        refused, served = None, False
        for rule, slug, values, why in self.ranked(facts):
            try:
                method = make(slug, {**values, **self.given}).resolved(facts.exemplars, facts.canvas)
            except IntarsiaError as e:
                refused = refused or e
                continue
            yield Choice(method, rule, why, (), facts, self.trials, dict(self.given))
            served = True
        if not served:
            raise refused or ParameterError(self._none(facts))

    def leading(self, exemplars: Exemplars, canvas: Canvas) -> Choice:
        """Return the choice that leads, its method with the known parameters alone, which are also `given`."""
        facts = choosing_facts.Facts(exemplars, canvas)
        for rule, slug, values, why in self.ranked(facts):
            known = {**values, **self.given}
            return Choice(make(slug, known), rule, why, choosing_facts.warnings_of(facts), facts, given=known)
        raise ParameterError(self._none(facts))

    def ranked(self, facts: choosing_facts.Facts) -> Iterator[tuple[str, str, dict[str, Any], tuple[str, ...]]]:
        """Yield (rule, method, parameters, reasons), best first: the rules that hold, then what else there is."""
        asked = needed(facts.exemplars, facts.canvas)
        able = [s for s in self.able if asked <= method_class(s).supports]
        listed = list[str]()
        for rule in rules.RULES:
            if rule.method in able and rule.holds(facts):
                known = parameters_of(rule.method)
                values = {k: v for k, v in rule.parameters(facts).items() if k in known}
                yield rule.name, rule.method, values, rule.why(facts)
                listed.append(rule.method)
                if rule.name in GENERAL:
                    break
        for slug in able:
            if slug not in listed and (self.given or self.needs or not listed):
                listed.append(slug)
                yield ONLY, slug, {}, (f"Of the methods that can do what is asked, {slug} is the first.",)

    def _none(self, facts: choosing_facts.Facts) -> str:
        words = ", ".join(sorted(a.value for a in needed(facts.exemplars, facts.canvas) | self.needs))
        extra = f" with {', '.join(self.given)}" if self.given else ""
        return f"no method can do all that is asked ({words}){extra}; ask for less, or name a method."


GENERAL = ("begun", "guided", "several", "patches")
"""Rules of the generalist, which can serve every exemplar: what comes after them is not needed."""
ONLY = "only"
FIXED = ("best-tile", "repeat")
"""Methods that no seed changes."""
DECIDED = ("lattice", "straighten", "heights", "patch", "overlap", "isometries", "evenness")
"""Parameters that a rule, a measurement or a trial decides."""

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
    refused: IntarsiaError | None = None
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
    values = values_of(choice.method)
    whole = values.get("patch")
    if whole is None or "patch" in choice.given or canvas.guide is not None:
        return [choice.method]
    most, automatic = max(1, int(LARGEST * choice.facts.side)), max(extent(whole))
    sides = dict.fromkeys(max(min(round(factor * automatic), most), min(automatic, most)) for factor in SIZES)
    loose = {"overlap": None} if "overlap" in values and "overlap" not in choice.given else {}
    return [make(choice.method.slug, {**values, **loose, "patch": side}) for side in sides]
