"""The command line ``intarsia``: commands imported on demand, errors, signals, progress and results.

One line for every error, an exit code, a quick stop on Ctrl-C. A command prints a progress bar or JSON lines while it
works, one line or one JSON object at the end. Imports nothing heavy.
"""

from __future__ import annotations

import gc
import importlib
import os
import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from threading import Event
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn

import click

from ..disk import prepare_memory, reason_of
from ..foundation import IntarsiaError, ResourceError, legible
from ..version import VERSION
from . import callers

if TYPE_CHECKING:
    from ..choosing.auto import Choice

LONGEST = 300  # characters of a word: a path may be long, but some are given to do harm
MOST = 2000  # characters of a line

SURE = 0.05  # part of a work after which the time that is left can be told

RARELY = 300_000  # new objects between two looks for garbage: compiling makes millions, and leaves little of it

CANCEL = Event()
"""Set by Ctrl-C, SIGTERM and SIGHUP; every Run of the command line watches it."""

STOPS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that stop a command: Ctrl-C, a polite kill, and a terminal that is closed."""

_shields = 0


class Interrupted(BaseException):
    """Raised in the main thread by Ctrl-C, SIGTERM and SIGHUP; handlers of ordinary errors do not catch it."""


def enable_collection() -> None:
    """Enable garbage collection after all imports, for objects that are made from now on."""
    if not gc.isenabled():
        gc.freeze()
        gc.set_threshold(RARELY)
        gc.enable()


def describe_error(e: BaseException) -> tuple[int, str]:
    """Return the exit code and the message, in one line, of an error."""
    if isinstance(e, IntarsiaError):
        return e.exit_code, one_line(e)
    if isinstance(e, click.ClickException):
        ctx = getattr(e, "ctx", None)
        return e.exit_code, one_line(e.format_message()) + (f" (see {ctx.command_path} --help)" if ctx else "")
    if isinstance(e, (Interrupted, KeyboardInterrupt, click.Abort)):
        return 130, "stopped; the file in the making was not written."
    if isinstance(e, MemoryError):
        return 1, "out of memory; choose a smaller --size, or a smaller exemplar (--crop, --scale)."
    if isinstance(e, OSError) and e.strerror:
        return 1, one_line(f"{e.filename or 'the output'}: {e.strerror.lower()}; the work was not finished.")
    found = one_line(f"{type(e).__name__}: {e}")
    return 1, f"internal error, {found}; please report it (INTARSIA_DEBUG=1 shows where)."


def one_line(message: object) -> str:
    """Return a message as one legible line; long words and long lines are shortened."""
    words = legible(str(message)[: 100 * MOST]).split()
    line = " ".join(w if len(w) <= LONGEST else w[:100] + "..." + w[-80:] for w in words)
    return line if len(line) <= MOST else line[: MOST - 500] + " ... " + line[-400:]


def print_lines(lines: Iterable[str]) -> None:
    """Write lines to stdout; ResourceError if that fails."""
    try:
        click.echo("\n".join(map(legible, lines)))
    except BrokenPipeError:
        raise
    except OSError as e:
        _drop_stdout()
        said = f"the standard output: {reason_of(e)}; the result was not printed, but all else is done."
        raise ResourceError(said) from None


def say_json(answer: Any) -> None:
    """Write an object to stdout as JSON, in plain ASCII without control characters."""
    import json

    print_lines(json.dumps(answer, indent=2).replace("\x7f", "\\u007f").splitlines())


@contextmanager
def stoppable() -> Iterator[None]:
    """Let Ctrl-C, SIGTERM and SIGHUP stop the work in this context at once."""
    before: dict[int, Any] = {}
    with suppress(ValueError):  # not the main thread: somebody else minds the signals
        for number in STOPS:
            if signal.getsignal(number) is not signal.SIG_IGN:  # as under nohup
                before[number] = signal.signal(number, _stop)
    hook = sys.unraisablehook
    sys.unraisablehook = lambda u: None if isinstance(u.exc_value, Interrupted) else hook(u)
    try:
        yield
    finally:
        sys.unraisablehook = hook
        for given, handler in before.items():
            signal.signal(given, handler)


@contextmanager
def unbroken() -> Iterator[None]:
    """Defer stops during a short passage that must be atomic."""
    global _shields
    _shields += 1
    try:
        yield
    finally:
        _shields -= 1


def _stop(number: int, frame: FrameType | None) -> None:
    CANCEL.set()
    if not _shields:
        raise Interrupted


def _drop_stdout() -> None:
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


debug_option = click.option("--debug", is_flag=True, expose_value=False, hidden=True)
"""Taken by every command, behind its name, too; `LazyGroup.main` looks for it."""

COMMANDS = {
    "grow": "Grow a larger or tileable texture from an example.",
    "paint": "Paint with textures: labels say what grows where.",
    "extend": "Continue a picture beyond its borders.",
    "heal": "Fill holes, remove objects, recover lost blocks.",
    "tile": "Make a photograph or a material tileable: only a band along its borders changes.",
    "tileset": "Make 16 or 81 tiles that fit where their corners agree, for fields without end.",
    "weave": "Stream a texture of any size into zarr (resumes), BigTIFF or tiles.",
    "render": "Draw a saved map again: other planes, softer, harder, a window.",
    "replay": "Make a picture again from the recipe it carries.",
    "analyze": "Tell how a texture repeats, how large its elements are, and how to grow it.",
    "score": "Tell how good an output is, and what speaks against it.",
    "maps": "Propose the maps that a photograph or a set lacks: height, normal, roughness.",
    "export": "Write a material as Unreal, Unity, Godot, Blender or glTF reads it.",
    "methods": "List the methods, or the parameters of one.",
    "studio": "Open a page on this machine to see, grow, paint and keep.",
    "warm-up": "Compile everything now, so that the first picture comes at once.",
    "install-plugin": "Put intarsia into Blender, GIMP, Krita or ComfyUI.",
    "where": "Tell where this program is, and what it speaks with others.",
}
"""Name -> description, in the order of help. All but those planned have a module of their name with a `command`."""

PLANNED = {"grow", "paint", "extend", "heal", "tile"}
"""Commands of `verbs.py`, which plans before it works."""

LIGHT = {"-h", "--help", "--help-all", "--version", "methods", "where", "install-plugin"}
"""Words of a command line that needs little memory."""


class LazyGroup(click.Group):
    """A group that imports a command when it is called, and prints every error in one line."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        planned = name in PLANNED
        home = ".verbs" if planned else f".commands.{name.replace('-', '_')}"
        module = importlib.import_module(home, __package__)
        if not planned:
            enable_collection()
        command: click.Command = module.command_of(name) if planned else module.command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))

    def main(  # type: ignore[override]
        self, args: Sequence[str] | None = None, prog_name: str | None = None, **extra: Any
    ) -> NoReturn:
        """Run the command line and leave with an exit code; never a traceback for bad input."""
        given = sys.argv[1:] if args is None else list(args)
        name = prog_name or "intarsia"
        if os.environ.get(f"_{name.upper()}_COMPLETE"):
            super().main(given, name)
        CANCEL.clear()
        callers.begin(given)
        code, debug = 0, "--debug" in given or os.environ.get("INTARSIA_DEBUG") == "1"
        try:
            with stoppable():
                if given and not LIGHT & set(given):
                    prepare_memory()
                with self.make_context(name, given) as ctx:
                    self.invoke(ctx)
                if sys.stdout is not None:
                    sys.stdout.flush()
        except click.exceptions.Exit as e:
            code = e.exit_code
        except SystemExit:
            raise
        except BrokenPipeError:  # as of `intarsia methods | head -1`; there is nobody left to tell
            _drop_stdout()
            code = 1
        except BaseException as e:
            if debug:
                import traceback

                for line in traceback.format_exc().splitlines():
                    callers.say(line)
            code, message = describe_error(e)
            callers.say_error(message, callers.kind_of(e), code)
        sys.exit(code)


@click.command(
    "intarsia",
    cls=LazyGroup,
    invoke_without_command=True,
    epilog='Shell completion: put  eval "$(_INTARSIA_COMPLETE=bash_source intarsia)"  into ~/.bashrc '
    "(zsh_source, fish_source for other shells).",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
@click.version_option(VERSION, "--version", message="%(prog)s %(version)s")
@click.option("--debug", is_flag=True, expose_value=False, help="Show where an error came from.")
@click.pass_context
def cli(ctx: click.Context) -> None:
    """Grow textures from an example.

    A small picture goes in; a larger, tileable, exactly reproducible one made of its pieces comes out.
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


Step = Callable[[int, int, Any], None]
Listener = Callable[[float, str, Any, tuple[Any, ...]], None]
"""Called with the fraction that is done, the stage, what makes a draft of the map (or None), and its exemplars."""

_listener: Listener | None = None
_listening: list[Report] = []


def listen(listener: Listener | None) -> None:
    """Set the listener that every Meter of this process calls at each step; None removes it."""
    global _listener
    _listener = listener


@dataclass
class Report:
    """The messages of a command. Only pictures and JSON go to stdout, all else to stderr."""

    as_json: bool = False
    progress: str | None = None
    quiet: bool = False
    warnings: list[str] = field(default_factory=list)
    say: Callable[[str], None] = callers.say  # above the progress bar, while there is one

    def note(self, line: str) -> None:
        """Print a line for a person, unless quiet."""
        if not self.quiet:
            self.say(one_line(line))

    def warn(self, *lines: str) -> None:
        """Print warnings, one line each, each once; they are also in the JSON result."""
        for line in lines:
            if line not in self.warnings:
                self.warnings.append(line)
                if not callers.reads_lines():
                    self.note(f"intarsia: warning: {line}")
                elif not self.quiet:
                    callers.say(one_line(line), "warning")

    def result(self, result: dict[str, Any]) -> None:
        """Print the result, if JSON is wanted; tell it to a caller that reads lines."""
        if self.as_json:
            say_json({**result, "warnings": self.warnings})
        if callers.reads_lines():
            callers.tell(result={**result, "warnings": self.warnings})

    @contextmanager
    def watching(self, parts: int) -> Iterator[Progress]:
        """Show the progress of a work of so many equal parts in this context, and note if kernels are compiled."""
        _listening.append(self)
        _listen()
        meter = Progress(self, parts)
        try:
            yield meter
        finally:
            _listening.remove(self)
            meter.close()


class Progress:
    """Progress from 0 to 1, never backwards, as a bar, as JSON lines or not at all."""

    def __init__(self, report: Report, parts: int) -> None:
        self._report, self._parts, self._part, self._span = report, parts, 0, (0.0, 1.0)
        self._fraction, self._told, self._stage = 0.0, 0.0, ""
        self._began = time.monotonic()
        self._exemplars: tuple[Any, ...] = ()
        self._lines = report.progress == "json"
        self._wants_bar = not self._lines and not report.quiet and sys.stderr is not None and sys.stderr.isatty()
        self._bar: Any = None

    def stage(self, name: str, begin: float, end: float, exemplars: tuple[Any, ...] = ()) -> Step:
        """Begin a stage that takes the part from `begin` to `end` of 1; return what a Run calls at each step.

        `exemplars` are those of the map that grows in it.
        """
        self._stage, self._span, self._exemplars, self._told = name, (begin, end), exemplars, 0.0
        if _listener is not None:
            _listener(self._fraction, name, None, exemplars)
        return self._step

    def next_part(self, parts: int = 1) -> None:
        """Count one part of the work as done, or so many."""
        self._part += parts
        self._stage, self._span = "done", (0.0, 0.0)
        self._show(1, 1, last=self._part == self._parts)

    def close(self) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.stop()
            self._bar, self._report.say = None, callers.say

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
            part, spent = self._fraction, now - self._began
            left = round(spent / part * (1 - part), 1) if part > SURE else None
            callers.tell(stage=self._stage, done=done, total=total, fraction=round(part, 4), remaining=left)
            return
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


@cache
def _listen() -> None:
    """Let the active reports print when kernels must be compiled, and what goes wrong with their cache."""
    from ..kernels import on_first_compilation, on_trouble, troubled

    def compiling() -> None:
        if callers.reads_lines():
            callers.tell(stage="compile", done=0, total=1, fraction=0.0, remaining=None)
        for report in () if troubled() else _listening:  # the line on that tells of it, too
            report.note("compiling for this computer, once, up to a minute (intarsia warm-up does it beforehand)")

    def warn(line: str) -> None:
        for report in _listening:
            report.warn(line)

    on_first_compilation(compiling)
    on_trouble(warn)


def as_json(choice: Choice, explain: bool) -> dict[str, Any]:
    """Return a choice as JSON; with its measurements, some of which take time, only to `explain` it."""
    from ..choosing.facts import measurements

    measured = {"measurements": measurements(choice.facts)} if explain else {}
    return {"rule": choice.rule, "why": list(choice.why), **measured}


def explain(report: Report, about: dict[str, Any], warnings: tuple[str, ...]) -> None:
    """Print a choice for a person, if its measurements were asked for."""
    auto = about.get("auto", {})
    if "measurements" not in auto or report.quiet:
        return
    from ..foundation.params import written
    from ..methods import parameters_of

    usual = {name: p.default for name, p in parameters_of(about["method"]).items()}
    values = [(k, v) for k, v in about["parameters"].items() if v != usual[k]] or [("all", "usual")]
    lines = [f"{name:13}{said}" for name, said in auto["measurements"].items()]
    lines += [f"{'rule':13}{auto['rule']}"] + [f"{'':13}{why}" for why in auto["why"]]
    lines += [f"{'method':13}{about['method']}"]
    lines += [f"{'parameters' if not n else '':13}{k} {written(v)}" for n, (k, v) in enumerate(values)]
    lines += [f"{'trial ' + str(n):13}{one['total']:.3f}" for n, one in enumerate(auto.get("scores", ()), 1)]
    lines += [f"{'warning':13}{line}" for line in warnings]
    for line in [*lines, f"{'command':13}{auto['command']}"]:
        report.say(line)
