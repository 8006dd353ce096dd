"""The options of the automatic choice, and what is told of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from ..choosing.auto import AUTO_METHOD, MOST_TRIALS, Auto, By
from ..errors import ParameterError
from ..methods.base import Method, make, method_class
from ..params import parameters
from .again import written
from .options import Union, opt
from .pictures import value_of

if TYPE_CHECKING:
    from ..choosing.auto import Choice
    from .report import Report

TRIALS = opt(
    "trials", "--trials", type=click.IntRange(1, MOST_TRIALS), metavar="N",
    help="Make N variants and keep the best. With --method auto only; the best by what --by says. Default: 1.",
)  # fmt: skip
BY = opt(
    "by", "--by", type=click.Choice([by.value for by in By]),
    help="What trials are compared by. How good people would find them, or what their seams cost: then only seeds are "
    "tried, and it is found sooner. Default: score.",
)  # fmt: skip
EXPLAIN = opt(
    "explain", "--explain", is_flag=True,
    help="With --method auto: tell what was measured, which rule chose, and the command without auto.",
)


def chosen_of(slug: str, trials: int | None, by: str | None, given: dict[str, Any], union: Union) -> Method | Auto:
    """Make the method that is named, or the choice among those that have the given options."""
    if by is not None and trials is None:
        raise ParameterError(f"--by {by} says how trials are compared; give --trials N as well, or drop it.")
    if slug == AUTO_METHOD:
        values = {n: value_of(union[n][0], t) for n, t in given.items() if t is not None}
        return Auto(trials or 1, values, by=by or By.SCORE)
    if trials is not None:
        raise ParameterError("--trials belongs to --method auto; name that, or drop it.")
    own = {p.name: p for p in parameters(method_class(slug))}
    return make(slug, {n: value_of(own.get(n, union[n][0]), t) for n, t in given.items() if t is not None})


def as_json(choice: Choice, explain: bool) -> dict[str, Any]:
    """What JSON says of a choice; measurements only where they are asked for, as some take time."""
    out: dict[str, Any] = {"rule": choice.rule, "why": list(choice.why)}
    if explain:
        from ..choosing.report import measurements

        out["measurements"] = {name: m.as_dict() for name, m in measurements(choice.facts).items()}
    return out


def explain(report: Report, about: dict[str, Any], warnings: tuple[str, ...]) -> None:
    """Tell a person of a choice, where measurements were asked for."""
    if "measurements" in about.get("auto", ()) and not report.quiet:
        for line in _explained(about, warnings):
            report.say(line)


def _explained(about: dict[str, Any], warnings: tuple[str, ...]) -> list[str]:
    auto = about["auto"]
    lines = [f"{name:13}{m['says']}" for name, m in auto["measurements"].items()]
    lines += [f"{'rule':13}{auto['rule']}"] + [f"{'':13}{why}" for why in auto["why"]]
    lines += [f"{'method':13}{about['method']}"]
    lines += [f"{'parameters' if not n else '':13}{k} {written(v)}" for n, (k, v) in enumerate(_set(about))]
    lines += [f"{'trial ' + str(n):13}{line}" for n, line in enumerate(_tried(auto), 1)]
    lines += [f"{'warning':13}{line}" for line in warnings]
    return [*lines, f"{'command':13}{auto['command']}"]


def _tried(auto: dict[str, Any]) -> list[str]:
    """What is said of each variant that was tried."""
    energies = auto.get("energies", [])
    scores = [f"{s['total']:.3f}, " for s in auto.get("scores", [])] or [""] * len(energies)
    return [f"{score}energy {energy}" for score, energy in zip(scores, energies, strict=True)]


def _set(about: dict[str, Any]) -> list[tuple[str, Any]]:
    usual = {p.name: p.default for p in parameters(method_class(about["method"]))}
    found = [(k, v) for k, v in about["parameters"].items() if v != usual[k]]
    return found or [("all", "usual")]
