"""Automatic choice of a method and its parameters by rules on measurements of the exemplar; deterministic.

    made = ia.synthesize("moss.png", 1024)                                # method="auto"
    choice = ia.Auto(trials=4).choose([ia.read("moss.png")], ia.Canvas(1024, 1024))
    print(choice.rule, choice.method, choice.why)

The rules are in ``rules.py``, the measurements in ``facts.py``.

Trials are variants of the chosen method, of which the one with the best score is kept: the automatic choice, patches
of 1.4 and 1.8 times its size, then further seeds of all these. Given parameters are never varied. Another variant is
kept only if its score exceeds that of the automatic choice by more than LEAST_GAIN. The number of trials is given, not
a time, so the same request gives the same picture. Other methods are never tried: between methods the score disagrees
with people too often (docs/auto.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from ..foundation import (
    AUTO_METHOD,
    FEATHER,
    MOST_TRIALS,
    CancelledError,
    IntarsiaError,
    MethodError,
    ParameterError,
    Record,
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

EVEN = 96  # px on either side of a seam over which tone is corrected; with 64 slow steps of tone show a little more


@dataclass(frozen=True, eq=False)
class Choice:
    """A chosen method, and the reasons.

    Attributes
    ----------
    method : Method
        With every parameter decided.
    rule : str
        The name of the rule that fired; "only" if what was asked for left only this method.
    why, warnings : tuple of str
        Sentences.
    facts : Facts
        The measurements, made lazily.
    trials : int
        Number of variants that are made to keep the best.
    given : dict
        The parameters that were given.
    others : function
        Returns the next choices, best first, if the method fails on this exemplar; evaluated once, at the first call.
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
    def decided(self) -> Record:
        """The parameters of DECIDED that differ from their defaults, by name.

        So a patch size that the method finds by itself is included.
        """
        usual = {p.name: (p.default, "off") for p in parameters(self.method)}
        return {k: v for k, v in values_of(self.method).items() if v not in usual[k] and k in DECIDED}

    @property
    def blend(self) -> Blend:
        """The blend of the method, with gradient-domain tone correction at seams.

        Without correction for start maps, guides, endless planes, and methods that do not copy exactly.
        """
        own, canvas, exemplar = self.method.blend, self.facts.canvas, self.facts.exemplars[0]
        if canvas.endless or canvas.start is not None or canvas.guide is not None or not traits(self.method).exact:
            return own
        widest = FEATHER * exemplar.height // max(plane.height for plane in exemplar.planes.values())
        return replace(own, finish=(Levelling(min(EVEN, widest)),)) if widest else own

    @property
    def recipe(self) -> Record:
        """The choice as saved in recipes, for information only."""
        return {"rule": self.rule, "why": list(self.why)}


@dataclass(frozen=True)
class Auto:
    """Automatic choice: choose the method and its parameters by rules on measurements of the exemplar.

    Parameters
    ----------
    trials : int
        Number of variants to make, 1 to 64, default 1; the one with the best score is kept.
    given : dict
        Values of parameters by name, default none; only methods that have all of them are chosen from.
    needs : set of Ability
        Required abilities, default none, besides those that exemplars and canvas need.

    Raises
    ------
    ParameterError
        if no method has these parameters, or allows these values.
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
        able, refused = list[str](), None
        for slug in METHODS:
            if not (self.given.keys() <= parameters_of(slug).keys() and self.needs <= method_class(slug).supports):
                continue
            try:
                make(slug, dict(self.given))
                able.append(slug)
            except ParameterError as e:
                refused = refused or e
        if not able:
            asked = ", ".join([*self.given, *sorted(a.value for a in self.needs)])
            raise refused or ParameterError(f"no method has all of {asked}; drop some, or name a method.")
        object.__setattr__(self, "able", tuple(able))

    def choose(self, exemplars: Exemplars, canvas: Canvas, run: Run | None = None) -> Choice:
        """Return the choice of the first rule that holds, among the methods with the needed abilities.

        Parameters
        ----------
        exemplars : sequence of Exemplar
            The first with usable pixels is measured.
        canvas : Canvas
            Its size, wrap, start map and guide count.
        run : Run, optional
            Threads.

        Returns
        -------
        Choice
            The method with every parameter decided, and the reasons.

        Raises
        ------
        ParameterError, MethodError
            if there is none.
        """
        return self.decide(choosing_facts.Facts(exemplars, canvas, run))

    def decide(self, facts: choosing_facts.Facts) -> Choice:
        """Return the choice for given measurements."""
        able = self._able(facts)
        first = next(able)
        return replace(first, warnings=choosing_facts.warnings_of(facts), others=cache(lambda: tuple(able)))

    def _able(self, facts: choosing_facts.Facts) -> Iterator[Choice]:
        """Yield the choices that can be resolved, best first; raise an error if there are none."""
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

    def first_unresolved(self, exemplars: Exemplars, canvas: Canvas) -> Choice:
        """Return the first choice unresolved: its method has only the parameters of the rule and those given."""
        facts = choosing_facts.Facts(exemplars, canvas)
        for rule, slug, values, why in self.ranked(facts):
            known = {**values, **self.given}
            return Choice(make(slug, known), rule, why, choosing_facts.warnings_of(facts), facts, given=known)
        raise ParameterError(self._none(facts))

    def ranked(self, facts: choosing_facts.Facts) -> Iterator[tuple[str, str, Record, tuple[str, ...]]]:
        """Yield (rule, method, parameters, reasons), best first: the rules that hold, then the remaining methods."""
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
"""Rules whose method works on every exemplar: later rules are not needed."""
ONLY = "only"
FIXED = ("best-tile", "repeat")
"""Methods whose result does not depend on the seed."""
DECIDED = ("lattice", "straighten", "course_heights", "patch", "overlap", "isometries", "evenness")
"""Parameters that are decided by a rule, a measurement or a trial."""

STAGE = 4003  # stage of the counter-based random numbers that are the seeds of trials
# Largest patch of a trial, relative to the shorter side of the exemplar, which holds too few places for larger ones. Of
# 92 textures 40 have fewer than three sizes to try so; with half the number 89, with double none.
LARGEST = 0.45
SIZES = (1.0, 1.4, 1.8)  # patch sizes of trials, relative to the automatic one
# Least gain in score, of 100, for which another variant replaces the automatic choice. With four trials people
# preferred the variant, blind, in seven of eight cases with such a gain, and in nine of 22 with a smaller one.
LEAST_GAIN = 2.2


class Trial(NamedTuple):
    """One variant: method, seed and map."""

    method: Method
    seed: int
    map: SourceMap


def carried_out(
    choice: Choice, exemplars: Exemplars, canvas: Canvas, seed: int, run: Run
) -> tuple[Choice, Trial, tuple[judging.Score, ...]]:
    """Make the variants of a choice and return the best; use the next choice if a method fails on the exemplar.

    Returns the choice that was used, the best of its trials, and the scores in the order of the trials, if there are
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
    """Return the methods to try with their seeds, at most `choice.trials`, the automatic one first."""
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
    """Return the chosen method with several patch sizes, the automatic one first."""
    values = values_of(choice.method)
    whole = values.get("patch")
    if whole is None or "patch" in choice.given or canvas.guide is not None:
        return [choice.method]
    most, automatic = max(1, int(LARGEST * choice.facts.side)), max(extent(whole))
    sides = dict.fromkeys(max(min(round(factor * automatic), most), min(automatic, most)) for factor in SIZES)
    loose = {"overlap": None} if "overlap" in values and "overlap" not in choice.given else {}
    return [make(choice.method.slug, {**values, **loose, "patch": side}) for side in sides]
