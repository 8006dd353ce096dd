"""In the process beside: a command of the command line, carried out here; and getting warm."""

from __future__ import annotations

import gc
import io
import json
import os
import shutil
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import cache
from typing import Any

from .drafting import Drafting
from .worker import Answer, Tell

AGAIN = 2.0  # s between two estimates of how long compiling takes
USUAL, FEW = 0.15, 5  # s that a kernel takes on two idle cores: believed until more than so many were made here


def command(said: dict[str, Any], tell: Tell) -> Answer:
    """Carry out the words of a command in a folder; return what it printed as JSON."""
    os.chdir(said["folder"])
    try:
        with _saying_how_long(said["words"], tell):
            return invoked(said["words"], Drafting(tell)), b""
    finally:
        gc.unfreeze()  # this process is not as brief as a command is
        os.chdir(os.path.dirname(os.path.abspath(__file__)))


@contextmanager
def _saying_how_long(words: list[str], tell: Tell) -> Iterator[None]:
    """Once a command must compile: tell about how many seconds that takes, and anew as kernels appear on the disk."""
    from ...choosing.auto import AUTO_METHOD
    from ...kernels.announcing import no_longer, on_first_compilation
    from ...tasks.warming import missing_kernels

    (method,) = [w.partition("=")[2] for w in words if w.startswith("--method=")] or [AUTO_METHOD]
    ended = threading.Event()

    def watch(whole: int) -> None:
        began, left = time.monotonic(), whole
        while left:
            pace = (time.monotonic() - began + FEW * USUAL) / (whole - left + FEW)
            tell(ready=left * pace)
            if ended.wait(AGAIN):
                return
            left = missing_kernels(method)

    def announce() -> None:
        threading.Thread(target=watch, args=(missing_kernels(method),), daemon=True).start()

    on_first_compilation(announce)
    try:
        yield
    finally:
        no_longer(announce)
        ended.set()


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
    """Load the kernels that growing needs, or have them compiled, and grow one tiny picture; tell how far that is.

    Where it is cancelled it ends at once, and what was made until then stays.
    """
    from ...cli.exits import CANCEL
    from ...run import Run
    from ...tasks.warming import made_beside
    from ...tasks.warming import warm as load

    def step(done: int, total: int, draft: Any) -> None:
        tell(warm=[done, total + 1])

    run = Run(step=step, cancel=CANCEL)
    with made_beside(run):
        count = load(run=run)
    folder = tempfile.mkdtemp(prefix="intarsia-warm-")
    try:
        out = os.path.join(folder, "a.png")
        invoked(["grow", "sample:stones", "--size=64", f"--output={out}", "--json", f"--save-map={out}.npz"])
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    tell(warm=[count + 1, count + 1])
    return {"kernels": count}, b""
