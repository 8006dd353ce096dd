"""In the process beside: a command of the command line, carried out here; and getting warm."""

from __future__ import annotations

import io
import json
import os
import shutil
import tempfile
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from typing import Any

from .drafting import Drafting
from .worker import Answer, Tell


def command(said: dict[str, Any], tell: Tell) -> Answer:
    """Carry out the words of a command in a folder; return what it printed as JSON."""
    os.chdir(said["folder"])
    drafting = Drafting(tell)
    try:
        return invoked(said["words"], drafting), b""
    finally:
        os.chdir(os.path.dirname(os.path.abspath(__file__)))


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
    """Load the kernels that growing needs, or compile them, and grow one tiny picture; tell how far that is."""
    from ...run import Run
    from ...tasks.warming import warm as load

    def step(done: int, total: int, draft: Any) -> None:
        tell(warm=[done, total + 1])

    count = load(run=Run(step=step))
    folder = tempfile.mkdtemp(prefix="intarsia-warm-")
    try:
        out = os.path.join(folder, "a.png")
        invoked(["grow", "sample:stones", "--size=64", f"--output={out}", "--json", f"--save-map={out}.npz"])
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    tell(warm=[count + 1, count + 1])
    return {"kernels": count}, b""
