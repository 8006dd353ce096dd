"""The command ``intarsia``: its commands, each imported when it is called, and how one speaks and ends.

Legible lines, one for every error, an exit code, and a quick stop on Ctrl-C. Imports nothing heavy.
"""

from __future__ import annotations

import gc
import importlib
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from threading import Event
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn

import click

from ..disk.limits import make_room
from ..errors import IntarsiaError, ResourceError, legible
from ..lazy import lazy
from ..version import VERSION

if TYPE_CHECKING:
    import json
else:
    json = lazy("json")

LONGEST = 300  # characters of a word: a path may be long, but some are given to do harm
MOST = 2000  # characters of a line

RARELY = 50_000  # new objects between two looks for garbage: compiling makes millions, and leaves little of it

CANCEL = Event()
"""Set by Ctrl-C, SIGTERM and SIGHUP; every Run of the command line watches it."""

STOPS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""What stops a command: Ctrl-C, a polite kill, and a terminal that is closed."""

_shields = 0


class Interrupted(BaseException):
    """Ctrl-C, SIGTERM or SIGHUP, raised wherever the main thread is; no handler of ordinary errors swallows it."""


def begun() -> None:
    """Say that all is imported and the work begins: from here on garbage is looked for, not among what is there."""
    if not gc.isenabled():
        gc.freeze()
        gc.set_threshold(RARELY)
        gc.enable()


def guarded(work: Callable[[], None], debug: bool = False) -> int:
    """Do the work; return the exit code, after one line on stderr where it failed."""
    CANCEL.clear()
    try:
        with stoppable():
            work()
            if sys.stdout is not None:
                sys.stdout.flush()
    except click.exceptions.Exit as e:
        return e.exit_code
    except SystemExit:
        raise
    except BrokenPipeError:  # as of `intarsia methods | head -1`; there is nobody left to tell
        _drop_stdout()
        return 1
    except BaseException as e:
        if debug or os.environ.get("INTARSIA_DEBUG") == "1":
            import traceback

            for line in traceback.format_exc().splitlines():
                tell(line)
        code, message = judge(e)
        tell(f"intarsia: {message}")
        return code
    return 0


def judge(e: BaseException) -> tuple[int, str]:
    """Return the exit code of an error, and its message as one line."""
    if isinstance(e, IntarsiaError):
        return e.exit_code, one_line(e)
    if isinstance(e, click.UsageError):
        where = f" (see {e.ctx.command_path} --help)" if e.ctx is not None else ""
        return 2, one_line(e.format_message()) + where
    if isinstance(e, click.ClickException):
        return e.exit_code, one_line(e.format_message())
    if isinstance(e, (Interrupted, KeyboardInterrupt, click.Abort)):
        return 130, "stopped; the file in the making was not written."
    if isinstance(e, MemoryError):
        return 1, "out of memory; choose a smaller --size, or a smaller exemplar (--crop, --scale)."
    if isinstance(e, OSError) and e.strerror:
        return 1, one_line(f"{e.filename or 'the output'}: {e.strerror.lower()}; the work was not finished.")
    found = one_line(f"{type(e).__name__}: {e}")
    return 1, f"internal error, {found}; please report it (INTARSIA_DEBUG=1 shows where)."


def one_line(message: object) -> str:
    """Return a message as a legible line, without what nobody would read to its end."""
    words = legible(str(message)[: 100 * MOST]).split()
    line = " ".join(w if len(w) <= LONGEST else w[:100] + "..." + w[-80:] for w in words)
    return line if len(line) <= MOST else line[: MOST - 500] + " ... " + line[-400:]


def tell(line: str) -> None:
    """Write a line to stderr, wherever that leads."""
    with suppress(OSError, ValueError):
        click.echo(legible(line), err=True)


def reason_of(e: OSError) -> str:
    """Why the system refused, in its own words."""
    return (e.strerror or str(e)).lower()


def say(lines: Iterable[str], done: str = "nothing else was to be done") -> None:
    """Write lines to stdout. ResourceError where that fails, with what is `done` all the same."""
    try:
        click.echo("\n".join(map(legible, lines)))
    except BrokenPipeError:
        raise
    except OSError as e:
        _drop_stdout()
        raise ResourceError(f"the standard output: {reason_of(e)}; the result was not printed, but {done}.") from None


def say_json(answer: Any, done: str = "nothing else was to be done") -> None:
    """Write an object to stdout as JSON, in plain ASCII without control characters."""
    say(json.dumps(answer, indent=2).replace("\x7f", "\\u007f").splitlines(), done)


@contextmanager
def stoppable() -> Iterator[None]:
    """Let Ctrl-C, SIGTERM and SIGHUP stop the work at once."""
    before: dict[int, Any] = {}
    try:
        for number in STOPS:
            if signal.getsignal(number) is not signal.SIG_IGN:  # as under nohup
                before[number] = signal.signal(number, _stop)
    except ValueError:  # not the main thread: somebody else minds the signals
        pass
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
    """Keep a stop away from a short passage that must be done whole or not at all."""
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


COMMANDS = {
    "grow": "Grow a larger or tileable texture from an example.",
    "paint": "Paint with textures: labels say what grows where.",
    "extend": "Continue a picture beyond its borders.",
    "heal": "Fill holes, remove objects, recover lost blocks.",
    "tile": "Make a photograph or a material tileable: only a band along its borders changes.",
    "weave": "Stream a texture of any size into zarr (resumes), BigTIFF or tiles.",
    "render": "Draw a saved map again: other planes, softer, harder, a window.",
    "replay": "Make a picture again from the recipe it carries.",
    "analyze": "Tell how a texture repeats, how large its elements are, and how to grow it.",
    "score": "Tell how good an output is, and what speaks against it.",
    "methods": "List the methods, or the parameters of one.",
    "studio": "Open a page on this machine to see, grow, paint and keep.",
    "warm-up": "Compile everything now, so that the first picture comes at once.",
}
"""Name -> what it does, in the order of the help. The module is named alike and holds `command`."""

PLANNED = {"grow", "paint", "extend", "heal", "tile"}
"""What is planned first, all alike by `commands/grow.py`, which says when the work begins."""

LIGHT = {"-h", "--help", "--help-all", "--version", "methods"}
"""What needs next to no memory."""


class LazyGroup(click.Group):
    """A group that imports a command when it is called, and says every error in one line."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        planned = name in PLANNED
        module = importlib.import_module(f".commands.{'grow' if planned else name.replace('-', '_')}", __package__)
        if not planned:
            begun()
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

        def work() -> None:
            if given and not LIGHT & set(given):
                make_room()
            with self.make_context(name, given) as ctx:
                self.invoke(ctx)

        sys.exit(guarded(work, "--debug" in given))


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
