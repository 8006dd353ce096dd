"""Worker process: drafts, which show coarsely and at once what a job will make."""

from __future__ import annotations

from contextlib import chdir
from dataclasses import replace

from ...cli import CANCEL, Report
from ...cli.plan import shelves_of
from ...cli.verbs import read_argv
from ...foundation import InputError
from ...foundation.arrays import Pair
from ...foundation.run import Run
from ...kernels import no_longer, on_first_compilation
from ...methods import make
from ...model import Exemplar
from ...model.canvas import Guide
from ...model.image import Plane
from ...rendering.magnification import magnified, reduced
from ...synthesis import synthesize
from .commands import hold
from .decoding import png, seen
from .worker import Answer, Json, Tell

METHOD = "image-quilting"  # its pictures look like those of others from afar, and take a tenth of their time
SIDE, MOST = 512, 1024  # px of a draft; and at most, where the exemplar cannot be reduced as much as is wanted
LEAST = 40  # px of a reduced exemplar: in less nothing would be known again
BORDER = 8  # px of patches along boundaries of labels: smaller ones are many where little is marked
FINER = 2  # times as fine as it is grown a draft is drawn that has labels or large exemplars, which take time


def draft(said: Json, tell: Tell) -> Answer:
    """Return a draft of the words of a command, read in a folder, as PNG: reduced, and of the first plane alone.

    InputError if it cannot be drafted, or if something would have to be compiled for it, which takes long.
    """
    hold()
    on_first_compilation(_give_up)
    try:
        return {}, png(seen(_drafted(said)))
    finally:
        no_longer(_give_up)


def _give_up() -> None:
    raise InputError("kernels must be compiled first, which others do.")


def _drafted(said: Json) -> Plane:
    with chdir(said["folder"]):
        request = replace(read_argv(said["words"]), magnify=1)
        shelf = shelves_of(request, Report(quiet=True))[0]
        shelf.sets = [{name: s[name] for name in s if name in (next(iter(s)), "mask")} for s in shelf.sets]
        exemplars, canvas = shelf.scene.exemplars, shelf.scene.canvas
    guide, settings, sides = canvas.guide, Json(), [side for e in exemplars for side in e.shape]
    most = max(min(sides) // LEAST, 1)
    finer = 1 if said.get("fine") or (guide is None and max(sides) <= SIDE) else min(FINER, most)
    n = min(-(-max(canvas.shape) // SIDE), most // finer)
    if max(canvas.shape) > n * MOST:
        raise InputError("the picture is too large for a draft of so small an exemplar.")
    exemplars = tuple(_small(exemplar, n, finer) for exemplar in exemplars)
    size = canvas.height // (n * finer) or 1, canvas.width // (n * finer) or 1
    if guide is not None:
        sources = [_few(s, n * finer, e.shape) for s, e in zip(guide.sources, exemplars, strict=True)]
        guide = Guide(sources, _few(guide.target, n * finer, size), guide.weight)
        settings = {"boundary_isometries": "none", "boundary_patch": BORDER}
    method, run = make(METHOD, settings), Run(cancel=CANCEL)
    made = synthesize(exemplars, size, method, seed=request.seed or 0, wrap=canvas.wrap, guide=guide, run=run)
    return made.render()


def _small(exemplar: Exemplar, n: int, finer: int) -> Exemplar:
    """Return an exemplar reduced n times, to grow of it reduced further; kept with what is measured of it."""
    whole = replace(exemplar, toroidal=False)
    return exemplar.memo(f"draft {n} {finer}", lambda: magnified(reduced(whole, n), finer))


def _few(plane: Plane, n: int, shape: Pair) -> Plane:
    """Return every n-th pixel."""
    return plane.like(plane.samples[n // 2 :: n, n // 2 :: n][: shape[0], : shape[1]])
