"""In the process beside: a command of the command line, carried out here; and getting warm."""

from __future__ import annotations

import io
import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import cache
from typing import Any

from .drafting import Drafting
from .worker import Answer, Tell

FIRST, MORE = 20.0, 5.0  # s that compiling takes: of all that a first command runs, and of what a later one adds
STEPS = 50  # of what is told while this process gets ready

_grown: list[bool] = []  # whether a command was carried out here


def command(said: dict[str, Any], tell: Tell) -> Answer:
    """Carry out the words of a command in a folder; return what it printed as JSON."""
    os.chdir(said["folder"])
    try:
        with _saying_how_long(tell):
            return invoked(said["words"], Drafting(tell)), b""
    finally:
        os.chdir(os.path.dirname(os.path.abspath(__file__)))


@contextmanager
def _saying_how_long(tell: Tell) -> Iterator[None]:
    """Once a command must compile: tell about how many seconds that takes, fewer where one grew before."""
    from ...kernels.cache import no_longer, on_first_compilation

    def announce() -> None:
        tell(ready=MORE if _grown else FIRST)

    on_first_compilation(announce)
    try:
        yield
        _grown.append(True)
    finally:
        no_longer(announce)


def prepare(said: dict[str, Any], tell: Tell) -> Answer:
    """Grow an exemplar once, so that what growing needs to know of it is known to this process; nothing is kept."""
    return command(said | {"words": ["grow", *said["words"], "--size=512", "--output=out.png", "--json"]}, tell)


@cache
def _hold() -> None:
    """Keep exemplars between the commands of this process."""
    from ...cli.exemplars import Held, hold

    hold(Held())


def invoked(words: list[str], drafting: Drafting | None = None) -> dict[str, Any]:
    """Run a command as a shell would, but here: what it tells as JSON, or its error."""
    from ...cli.app import cli
    from ...cli.report import listen

    _hold()
    told, aside = io.StringIO(), io.StringIO()
    listen(drafting)
    try:
        with redirect_stdout(told), redirect_stderr(aside), cli.make_context("intarsia", list(words)) as ctx:
            cli.invoke(ctx)
    finally:
        listen(None)
    text = told.getvalue().strip()
    answer: dict[str, Any] = json.loads(text) if text else {}
    return answer


def warm(said: dict[str, Any], tell: Tell) -> Answer:
    """Grow what makes this process ready, and one tiny picture by a command; tell how far that is.

    Where it is cancelled it ends after the kernel that is being compiled, and what was made until then stays.
    """
    from ...cli.exits import CANCEL
    from ...run import Run
    from ...tasks.warming import warm as load

    told = [-1]

    def step(done: int, total: int, draft: Any) -> None:
        if (now := STEPS * done // total) > told[0]:
            told[0] = now
            tell(warm=[now, STEPS + 1])

    count = load(run=Run(step=step, cancel=CANCEL))
    folder = tempfile.mkdtemp(prefix="intarsia-warm-")
    try:
        out = os.path.join(folder, "a.png")
        invoked(["grow", "sample:stones", "--size=64", f"--output={out}", "--json", f"--save-map={out}.npz"])
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    tell(warm=[STEPS + 1, STEPS + 1])
    return {"grown": count}, b""
