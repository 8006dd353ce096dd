"""How a command ends: one line and an exit code for every error, and a quick stop on Ctrl-C."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import Event
from types import FrameType
from typing import Any

import click

from ..errors import IntarsiaError

LONGEST = 300  # characters of a word: a path may be long, but some are given to do harm

CANCEL = Event()
"""Set by Ctrl-C and SIGTERM; every Run of the command line watches it."""

_shields = 0


class Interrupted(BaseException):
    """Ctrl-C or SIGTERM, raised wherever the main thread is; no handler of ordinary errors swallows it."""


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

            traceback.print_exc()
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
    """Return a message without line breaks, and without words that nobody would read to their end."""
    return " ".join(w if len(w) <= LONGEST else w[:100] + "..." + w[-80:] for w in str(message).split())


def tell(line: str) -> None:
    """Write a line to stderr, wherever that leads."""
    with suppress(OSError, ValueError):
        click.echo(line, err=True)


@contextmanager
def stoppable() -> Iterator[None]:
    """Let Ctrl-C and SIGTERM stop the work at once."""
    before: dict[int, Any] = {}
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
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
