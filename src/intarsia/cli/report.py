"""What a command says: a bar or JSON lines while it works, one line or one JSON object at the end."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ..methods.base import method_class
from ..params import parameters, written
from .app import one_line, say_json, tell

if TYPE_CHECKING:
    from ..choosing.auto import Choice

Step = Callable[[int, int, Any], None]
Listener = Callable[[float, str, Any, tuple[Any, ...]], None]
"""What is called with the fraction that is done, the stage, what makes the map as far as it has grown (or None), and
the exemplars of that map."""

_listener: Listener | None = None
_listening: list[Report] = []
_registered = False


def listen(listener: Listener | None) -> None:
    """Have every Meter of this process call `listener` at each step of its work, too; None: no more."""
    global _listener
    _listener = listener


@dataclass
class Report:
    """The voice of a command. Only pictures and JSON go to stdout, all else to stderr."""

    as_json: bool = False
    progress: str | None = None
    quiet: bool = False
    warnings: list[str] = field(default_factory=list)
    say: Callable[[str], None] = tell  # above the progress bar, while there is one

    def note(self, line: str) -> None:
        """Tell a person something, unless nobody wants to hear it."""
        if not self.quiet:
            self.say(one_line(line))

    def warn(self, *lines: str) -> None:
        """Tell of what may be wrong, in one line each, and once; the JSON result repeats it."""
        for line in lines:
            if line not in self.warnings:
                self.warnings.append(line)
                self.note(f"intarsia: warning: {line}")

    def result(self, result: dict[str, Any]) -> None:
        """Print the result, if JSON is wanted."""
        if self.as_json:
            written = "files" in result or "results" in result
            done = "the files are written" if written and "dry_run" not in result else "nothing else was to be done"
            say_json({**result, "warnings": self.warnings}, done)

    @contextmanager
    def watching(self, parts: int) -> Iterator[Meter]:
        """Show how far a work of so many equal parts is; also say so once when kernels must be compiled."""
        _listening.append(self)
        _listen()
        meter = Meter(self, parts)
        try:
            yield meter
        finally:
            _listening.remove(self)
            meter.close()


class Meter:
    """Progress from 0 to 1, never backwards, as a bar, as JSON lines or not at all."""

    def __init__(self, report: Report, parts: int) -> None:
        self._report, self._parts, self._part, self._span = report, parts, 0, (0.0, 1.0)
        self._fraction, self._told, self._stage = 0.0, 0.0, ""
        self._exemplars: tuple[Any, ...] = ()
        self._lines = report.progress == "json"
        self._wants_bar = not self._lines and not report.quiet and sys.stderr is not None and sys.stderr.isatty()
        self._bar: Any = None

    def stage(self, name: str, begin: float, end: float, exemplars: tuple[Any, ...] = ()) -> Step:
        """Begin a stage that takes the part from `begin` to `end` of 1; return what a Run calls at each step.

        `exemplars` are those of the map that grows in it.
        """
        self._stage, self._span, self._exemplars = name, (begin, end), exemplars
        self._told = 0.0
        return self._step

    def next_part(self, parts: int = 1) -> None:
        """One part of the work is done, or so many."""
        self._part += parts
        self._stage, self._span = "done", (0.0, 0.0)
        self._show(1, 1, last=self._part == self._parts)

    def close(self) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.stop()
            self._bar, self._report.say = None, tell

    def _step(self, done: int, total: int, draft: Any = None) -> None:
        self._show(done, total, last=done == total)
        if _listener is not None:
            _listener(self._fraction, self._stage, draft if self._exemplars else None, self._exemplars)

    def _show(self, done: int, total: int, last: bool) -> None:
        begin, end = self._span
        fraction = (self._part + begin + (end - begin) * done / max(total, 1)) / self._parts
        self._fraction = min(1.0, max(self._fraction, fraction))
        now = time.monotonic()
        if not (self._lines or self._wants_bar) or (now - self._told < 0.05 and not last):
            return
        self._told = now
        if self._lines:
            facts = {"stage": self._stage, "done": done, "total": total, "fraction": round(self._fraction, 4)}
            tell(json.dumps(facts))
        else:
            self._draw()

    def _draw(self) -> None:
        if self._bar is None:
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

            columns = (TextColumn("{task.description:8}"), BarColumn(), TextColumn("{task.percentage:3.0f} %"))
            self._bar = Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True)
            self._task = self._bar.add_task(self._stage, total=1.0)
            self._bar.start()
            print_above = self._bar.console.print
            self._report.say = lambda line: print_above(line, markup=False, highlight=False, soft_wrap=True)
        self._bar.update(self._task, completed=self._fraction, description=self._stage)


def _listen() -> None:
    """Have the reports of the moment told when a kernel of this process must be compiled, and what is wrong with it."""
    global _registered
    if not _registered:
        from ..kernels.cache import on_first_compilation, on_trouble

        _registered = True
        on_first_compilation(_compiling)
        on_trouble(_troubled)


def _compiling() -> None:
    from ..kernels.cache import troubled

    if troubled():  # the line on that tells of it, too
        return
    for report in {id(report): report for report in _listening}.values():
        report.note("compiling for this computer, once, up to a minute (intarsia warm-up does it beforehand)")


def _troubled(line: str) -> None:
    for report in _listening:
        report.warn(line)


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
