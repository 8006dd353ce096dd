"""What is told of the automatic choice."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..methods.base import method_class
from ..params import parameters
from ..request.argv import written

if TYPE_CHECKING:
    from ..choosing.auto import Choice
    from .report import Report


def as_json(choice: Choice, explain: bool) -> dict[str, Any]:
    """What JSON says of a choice; measurements only where they are asked for, as some take time."""
    out: dict[str, Any] = {"rule": choice.rule, "why": list(choice.why)}
    if explain:
        from ..choosing.facts import measurements

        out["measurements"] = measurements(choice.facts)
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
