"""Worker process: drafts, which show coarsely and at once what a job will make."""

from __future__ import annotations

from contextlib import chdir
from dataclasses import replace

import numpy as np

from ...cli import CANCEL, Report
from ...cli.plan import shelves_of
from ...cli.verbs import read_argv
from ...foundation import InputError
from ...foundation.run import Run
from ...methods import make
from ...model import Exemplar
from ...model.canvas import Canvas, Guide
from ...model.image import Plane
from ...model.sourcemap import SourceMap
from ...rendering.magnification import magnified, reduced
from ...synthesis import Scene, carry_out, planned
from .commands import hold
from .decoding import png, seen
from .worker import Answer, Json, Tell

METHOD = "image-quilting"  # its pictures look like those of others from afar, and take a tenth of their time
GUIDED = {"boundary_isometries": "none"}
SIDE, LEAST = 512, 40  # px: of a draft, and of the exemplar reduced for it, as of less nothing would be known again
LARGEST = 1024  # px of a draft whose exemplar cannot be reduced as much as is wanted
FINER = 2  # times as fine as it is grown a painted draft is drawn, as labels take time


def draft(said: Json, tell: Tell) -> Answer:
    """Return a draft of the words of a command, read in a folder, as PNG: reduced, and of the first plane alone."""
    hold()
    with chdir(said["folder"]):
        request = read_argv(said["words"])
        shelf = shelves_of(replace(request, grow=request.grow or 0, magnify=1), Report(quiet=True))[0]
        shelf.sets = [{n: p for n, p in s.items() if n in (next(iter(s)), "mask")} for s in shelf.sets]
        scene = shelf.scene
    canvas, most = scene.canvas, max(min(side for e in scene.exemplars for side in e.shape) // LEAST, 1)
    finer = 1 if canvas.guide is None else min(FINER, most)
    n = min(-(-max(canvas.shape) // SIDE), most // finer)
    if max(canvas.shape) > n * LARGEST:
        raise InputError("the picture is too large for a draft of so small an exemplar.")
    scene = _reduced(scene, n, finer)
    plan = planned(scene, make(METHOD, {} if canvas.guide is None else GUIDED))
    return {}, png(seen(carry_out(plan, request.seed or 0, Run(cancel=CANCEL)).render()))


def _reduced(scene: Scene, n: int, finer: int) -> Scene:
    """Return a scene reduced n times, and `finer` times more where it is grown alone."""
    canvas, guide, start = scene.canvas, scene.canvas.guide, scene.canvas.start
    exemplars, n = tuple(_small(e, n, finer) for e in scene.exemplars), n * finer
    height, width = (max(side // n, 1) for side in canvas.shape)

    def few(plane: Plane, height: int, width: int) -> Plane:
        return plane.like(plane.samples[n // 2 :: n, n // 2 :: n][:height, :width])

    if guide is not None:
        guides = [few(source, *e.shape) for source, e in zip(guide.sources, exemplars, strict=True)]
        guide = Guide(guides, few(guide.target, height, width), guide.weight, guide.reach // n)
    if start is not None:
        here = np.s_[n // 2 :: n, n // 2 :: n]
        last = np.array([e.shape for e in exemplars])[np.minimum(start.numbers[here], len(exemplars) - 1)] - 1
        yx, which = np.minimum(start.yx[here] // n, last), start.numbers[here]
        sources = tuple(e.source for e in exemplars)
        start = SourceMap(yx[:height, :width], which[:height, :width], sources=sources, wrap=start.wrap)
    return Scene(exemplars, Canvas(height, width, canvas.wrap, start, guide))


def _small(exemplar: Exemplar, n: int, finer: int) -> Exemplar:
    """Return an exemplar reduced n times, kept with what is measured of it."""

    def make_it() -> Exemplar:
        return magnified(reduced(replace(exemplar, toroidal=False), n), finer)

    return exemplar.memo(f"draft {n} {finer}", make_it)
