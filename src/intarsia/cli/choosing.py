"""The options of the automatic choice, what is told of it, and the command that repeats a picture without it."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from ..auto import AUTO_METHOD, MOST_TRIALS, Auto
from ..errors import ParameterError
from ..methods.base import Method, make, method_class
from ..params import Parameter, parameters, words
from .options import opt
from .pictures import value_of

if TYPE_CHECKING:
    from ..auto import Choice
    from .plan import Order
    from .request import Inputs, Targets, Wish

TRIALS = opt(
    "trials", "--trials", type=click.IntRange(1, MOST_TRIALS), metavar="N",
    help="With --method auto: make N variants and keep the one closest to the exemplar. Default: 1.",
)  # fmt: skip
EXPLAIN = opt(
    "explain", "--explain", is_flag=True,
    help="With --method auto: tell what was measured, which rule chose, and the command without auto.",
)
UNION = dict[str, tuple[Parameter, list[str]]]


def chosen_of(slug: str, trials: int | None, given: dict[str, Any], union: UNION) -> Method | Auto:
    """Make the method that is named, or the choice among those that have the given options."""
    if slug == AUTO_METHOD:
        return Auto(trials or 1, {n: value_of(union[n][0], t) for n, t in given.items() if t is not None})
    if trials is not None:
        raise ParameterError("--trials belongs to --method auto; name that, or drop it.")
    own = {p.name: p for p in parameters(method_class(slug))}
    return make(slug, {n: value_of(own.get(n, union[n][0]), t) for n, t in given.items() if t is not None})


def told(choice: Choice, explain: bool) -> dict[str, Any]:
    """What JSON says of a choice; measurements only where they are asked for, as some take time."""
    out: dict[str, Any] = {"rule": choice.rule, "why": list(choice.why)}
    if explain:
        from ..measure.report import measurements

        out["measurements"] = {name: m.as_dict() for name, m in measurements(choice.facts).items()}
    return out


def explained(about: dict[str, Any], warnings: tuple[str, ...]) -> list[str]:
    """The lines that a person reads of a choice."""
    auto = about["auto"]
    lines = [f"{name:13}{m['says']}" for name, m in auto["measurements"].items()]
    lines += [f"{'rule':13}{auto['rule']}"] + [f"{'':13}{why}" for why in auto["why"]]
    lines += [f"{'method':13}{about['method']}"]
    lines += [f"{'parameters' if not n else '':13}{k} {_shown(v)}" for n, (k, v) in enumerate(_set(about))]
    lines += [f"{'trial ' + str(n):13}{s['total']:.3f}" for n, s in enumerate(auto.get("scores", []), 1)]
    lines += [f"{'warning':13}{line}" for line in warnings]
    return [*lines, f"{'command':13}{auto['command']}"]


def command_of(order: Order, method: Method, seed: int, inputs: Inputs, wish: Wish, targets: Targets) -> str:
    """Return the command that makes the picture again without choosing, for a shell."""
    said: list[str] = ["intarsia", "grow"]
    said += [next(iter(found.values())) for found in order.sets]
    said += ["--several"] * (len(order.sets) > 1)
    for found in order.sets:
        for number, (name, path) in enumerate(found.items()):
            if number:
                said += ["--mask", path] if name == "mask" else ["--map", f"{name}={path}"]
    for name, value in inputs.recipe().items():
        said += [f"--{name}"] if value is True else [f"--{name}", _shown(value)]
    width, height = order.size
    said += ["-o", next(iter(order.pictures.values())), "--size", f"{width}x{height}", "--seed", str(seed)]
    said += ["--wrap", wish.wrap] * (wish.wrap != "none")
    said += ["--depth", str(targets.depth)] * (targets.depth is not None)
    said += ["--feather", str(wish.feather)] * (wish.feather is not None)
    said += ["--mixing", str(wish.mixing)] * (wish.mixing is not None)
    lattice = any(p.name == "lattice" for p in parameters(method))  # it was not repaired
    said += ["--repair", str(wish.repair)] * (wish.repair > 0 and not lattice)
    said += ["--force"] * targets.force
    return shlex.join([*said, "--method", method.slug, *options_of(method, wish.pictures)])


def options_of(method: Method, pictures: Mapping[str, str]) -> list[str]:
    """Return the options that give a method its parameters, but for those that are the usual ones.

    `pictures` names the files of those that are pictures.
    """
    said: list[str] = []
    for p in parameters(method):
        value = getattr(method, p.name)
        if value != p.default:
            said += [f"--{p.name.replace('_', '-')}", pictures.get(p.name) or text_of(p.kind, value)]
    return said


def text_of(kind: str, value: Any) -> str:
    """Write a parameter as the command line reads it."""
    if kind == "extent":
        return words(value)
    if kind == "vectors":
        return " ".join(",".join(repr(float(n)) for n in v) for v in value)
    return _shown(value)


def _set(about: dict[str, Any]) -> list[tuple[str, Any]]:
    usual = {p.name: p.default for p in parameters(method_class(about["method"]))}
    found = [(k, v) for k, v in about["parameters"].items() if v != usual[k]]
    return found or [("all", "usual")]


def _shown(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        if value and isinstance(value[0], (list, tuple)):
            return " ".join(",".join(f"{n:.6g}" for n in v) for v in value)
        return ",".join(str(v) for v in value)
    return str(value)
