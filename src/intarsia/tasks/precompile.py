"""Precompilation: small textures are synthesised so that their kernels are compiled, cached on disk and loaded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ..foundation import AUTO_METHOD, Record, expect
from ..foundation.blend import Levelling
from ..foundation.run import Run, run_of
from ..kernels import mark_warm
from ..methods import METHODS, make, method_class
from ..model import Exemplar
from ..synthesis import synthesize
from .completion import heal
from .tileable import tile

Work = Callable[[Run], object]

CHOSEN = ("stones", "brick", "tiles", "pebbles", "gravel")
"""Built-in exemplars for which the automatic choice takes, together, all its common methods."""

PERIODIC = ("near-regular", "gap-filling", "best-tile", "repeat")
"""Methods that need an exemplar with periods."""

PIXEL_BY_PIXEL = ("efros-leung", "wei-levoy", "ashikhmin")
"""Methods that are slow for each pixel."""

LARGE, SMALL = 400, 48  # px: side of the outputs, so that every pass over a map has work to do; and for slow methods


def warm(*methods: str, run: Run | None = None) -> int:
    """Precompile: load or compile the kernels of methods, so that the next synthesis starts without delay.

    Each method synthesises small textures, which are discarded. Compiling takes up to half a minute and is cached on
    disk; servers call this before the first request.

    Parameters
    ----------
    *methods : str
        Names as ``intarsia methods`` lists them. ``"auto"``, or no name, stands for the automatic choice and the
        methods that it chooses most often.
    run : Run, optional
        Threads, progress, cancelling.

    Returns
    -------
    int
        The number of textures that were synthesised.

    Raises
    ------
    ParameterError
        for an unknown name.
    CancelledError
        when the run is cancelled; kernels compiled until then are kept.
    """
    works: list[Work] = []
    for slug in methods or (AUTO_METHOD,):
        expect(slug, str, "methods", "names of methods")
        if slug != AUTO_METHOD:
            method_class(slug)
        works += CHOICES if slug == AUTO_METHOD else [partial(_by, slug)]
    return _do_all(works, run_of(run))


def precompile_all(run: Run) -> int:
    """Compile the kernels of all methods and kinds of pixels for this computer; return the number of runs."""
    kinds = [partial(_pixels, "image-quilting", {"patch": 8}), partial(_pixels, "parallel-controllable", {"angle": 30})]
    works: list[Work] = [*CHOICES, *(partial(_by, slug) for slug in METHODS), *kinds]
    pictures = _do_all([*works, _healed, lambda run: tile("sample:stones", run=run)], run)
    mark_warm()
    return pictures


def _do_all(works: list[Work], run: Run) -> int:
    silent = replace(run, notes=[])  # the textures are discarded
    for number, work in enumerate(works):
        work(silent.part(number, len(works)))
    run.tick(len(works), len(works))
    return len(works)


def _chosen(name: str, run: Run) -> None:
    """Synthesise from a built-in exemplar with the automatic choice."""
    synthesize(f"sample:{name}", LARGE, seed=0, run=run).render(run=run)


CHOICES: list[Work] = [partial(_chosen, name) for name in CHOSEN]


def _by(slug: str, run: Run) -> None:
    """Synthesise by a method with its defaults."""
    exemplar: Any = f"sample:{'tiles' if slug in PERIODIC else 'stones'}"
    size = LARGE
    if slug in PIXEL_BY_PIXEL:
        exemplar, size = _planes()["albedo"], SMALL
    synthesize(exemplar, size, make(slug, {}), seed=0, run=run).render(run=run)


def _planes() -> Record:
    """Return planes of every kind and depth, of one picture."""
    rows, columns = np.mgrid[:SMALL, :SMALL]
    noise = (rows * 73 + columns * 151 + rows * columns * 7) % 251
    colour = np.stack([noise, noise // 2, 250 - noise], axis=2).astype(np.uint8)
    normal = np.dstack([colour[:, :, :2], np.full((SMALL, SMALL), 250, np.uint8)])
    clear = np.dstack([colour, colour[:, :, :1]])
    return {
        "albedo": colour,
        "deep": colour.astype(np.uint16) * 257,
        "light": colour.astype(np.float32) / 255,
        "clear": clear,
        "glow": clear.astype(np.float32) / 255,
        "height": noise.astype(np.uint16),
        "normal": normal,
        "normals": normal.astype(np.float32) / 255,
        "id": (noise // 90).astype(np.uint8),
    }


def _pixels(slug: str, values: Record, run: Run) -> None:
    """Render planes of every kind: copied, feathered and tone-corrected, or interpolated if the map is rotated."""
    planes = _planes()
    grown = synthesize(Exemplar.of(planes), SMALL, make(slug, values), wrap="both", run=run)
    for plane in planes:
        for feather in (0, 3) if grown.map.exact else (0,):
            grown.render(plane, feather=feather, run=run)
        if grown.map.exact:
            grown.render(plane, finish=(Levelling(8),), run=run)


def _healed(run: Run) -> None:
    hole = np.zeros((SMALL, SMALL), bool)
    hole[16:28, 16:28] = True
    heal(_planes()["albedo"], hole, run=run)
