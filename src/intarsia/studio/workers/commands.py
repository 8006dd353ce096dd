"""Worker process: run commands with progress and previews, precompile kernels, and grow sketches of methods."""

from __future__ import annotations

import io
import json
import os
import shutil
import tempfile
import time
from contextlib import chdir, redirect_stderr, redirect_stdout
from functools import cache, lru_cache
from typing import Any

import numpy as np

from ...cli import CANCEL, cli, listen
from ...cli.exemplars import ExemplarCache, set_cache
from ...foundation import InputError, MethodError, ParameterError
from ...foundation.run import Run
from ...kernels import no_longer, on_first_compilation
from ...model import Exemplar, Exemplars
from ...model.image import Plane
from ...model.sourcemap import SourceMap
from ...rendering.magnification import cut_out
from ...synthesis import synthesize
from ...tasks import precompile
from .decoding import coloured, exemplar_of, png, reduced, seen
from .worker import Answer, Json, Tell

FIRST, MORE = 20.0, 5.0  # s of compiling in a first command, and in a later one
STEPS = 50  # of progress reported while precompiling

PREVIEW = 512  # px: largest preview
APART = 0.25  # s between two previews
SHARE = 0.03  # of the time at most is spent on previews

LARGEST = 320  # px a side: larger exemplars are reduced
SIDE = 192  # px of a sketch
SLOW = {"efros-leung": (112, 96)}  # compares every pixel with all: px of the exemplar, and of the sketch

_grown: list[bool] = []  # not empty once a command ran here


def command(said: Json, tell: Tell) -> Answer:
    """Run the words of a command in a folder; return what it printed as JSON.

    If it must compile, report about how many seconds that takes, fewer if this process ran a command before.
    """

    def announce() -> None:
        tell(ready=MORE if _grown else FIRST)

    on_first_compilation(announce)
    try:
        with chdir(said["folder"]):
            answer = invoked(said["words"], Drafting(tell))
        _grown.append(True)
        return answer, b""
    finally:
        no_longer(announce)


@cache
def hold() -> None:
    """Cache exemplars between the commands of this process."""
    set_cache(ExemplarCache())


def invoked(words: list[str], drafting: Drafting | None = None) -> Json:
    """Run a command in this process; return what it prints as JSON, or raise its error."""
    hold()
    told, aside = io.StringIO(), io.StringIO()
    listen(drafting)
    try:
        with redirect_stdout(told), redirect_stderr(aside), cli.make_context("intarsia", list(words)) as ctx:
            cli.invoke(ctx)
    finally:
        listen(None)
    answer: Json = json.loads(told.getvalue().strip() or "{}")
    return answer


def warm(said: Json, tell: Tell) -> Answer:
    """Precompile all kernels, and grow one tiny picture by a command; report the progress.

    If cancelled it ends after the kernel that is being compiled; finished kernels stay.
    """
    told = [-1]

    def step(done: int, total: int, draft: Any) -> None:
        if (now := STEPS * done // total) > told[0]:
            told[0] = now
            tell(warm=[now, STEPS + 1])

    precompile.warm(run=Run(step=step, cancel=CANCEL))
    folder = tempfile.mkdtemp(prefix="intarsia-warm-")
    try:
        out = os.path.join(folder, "a.png")
        invoked(["grow", "sample:stones", "--size=64", f"--output={out}", "--json", f"--save-map={out}.npz"])
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    tell(warm=[STEPS + 1, STEPS + 1])
    return {}, b""


class Drafting:
    """Listener of the steps of the work; reports the fraction, the stage, and a preview now and then."""

    def __init__(self, tell: Tell) -> None:
        self._tell, self._next, self._told = tell, 0.0, (-1.0, "")

    def __call__(self, fraction: float, stage: str, draft: Any, exemplars: tuple[Any, ...]) -> None:
        now = time.monotonic()
        if stage != self._told[1] or fraction - self._told[0] >= 0.01:
            self._told = (fraction, stage)
            self._tell(fraction=round(fraction, 4), stage=stage)
        if draft is None or now < self._next:
            return
        picture = drawn(draft(), exemplars)
        ended = time.monotonic()
        if picture is not None:
            self._tell(picture, preview=True)
        self._next = ended + (max(APART, (ended - now) / SHARE) if picture is not None else ended - now)


def drawn(smap: SourceMap, exemplars: Exemplars) -> bytes | None:
    """Return a PNG of a map: copied pixels, clear where nothing is yet; None if all is clear."""
    step = max(-(-max(smap.height, smap.width) // PREVIEW), 1)

    def copied(number: int, y: Any, x: Any) -> Any:
        base = exemplars[number].base
        return seen(base.like(base.samples[y, x][None]))[0, :, :3]

    out = coloured(smap, step // 2, step, copied)
    return png(out) if out[..., 3].any() else None


def sketch(said: Json, tell: Tell) -> Answer:
    """Return a small picture of a method with its default parameters; empty if it cannot serve."""
    try:
        part, side = SLOW.get(said["method"], (LARGEST, SIDE))
        whole = _reduced(*said["paths"])
        height, width = min(whole.height, part), min(whole.width, part)
        exemplar = cut_out(whole, (whole.width - width) // 2, (whole.height - height) // 2, width, height)
        made = synthesize(exemplar, side, said["method"], run=Run(threads=1, cancel=CANCEL))
        return {}, png(seen(made.render()))
    except (MethodError, ParameterError, InputError):
        return {}, b""


@lru_cache(maxsize=4)
def _reduced(*paths: str) -> Exemplar:
    """Return the colours of an exemplar, as displayed, at most LARGEST px a side."""
    whole = exemplar_of(list(paths))
    pixels = np.ascontiguousarray(reduced(seen(whole.base), LARGEST)[:, :, :3])
    step = -(-max(whole.height, whole.width) // LARGEST)
    usable = None if whole.usable is None else whole.usable[::step, ::step][: pixels.shape[0], : pixels.shape[1]]
    return Exemplar({"albedo": Plane(pixels)}, usable)
