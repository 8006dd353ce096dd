"""``intarsia render``: a saved map drawn again. Imports nothing heavy before the work."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING

from ...foundation import MAX_PIXELS, InputError, ParameterError
from ...request import Request
from .. import CANCEL, Report
from ..verbs import HelpfulCommand

if TYPE_CHECKING:
    from ...model.sourcemap import SourceMap


def draw(request: Request, report: Report) -> None:
    """Draw a map that was saved with --save-map again: with other planes of the same size, softer, or in part."""
    if request.saved is None or request.saved == "-":
        raise ParameterError("a map is read from a file; give the name of a .npz.")
    from ...model.sourcemap import SourceMap

    smap, times = SourceMap.load(request.saved), request.magnify
    smap.check_sources()
    if request.window is not None:
        x, y, width, height = request.window
        if any(v % times for v in request.window):
            raise ParameterError(
                f"--window {x},{y},{width},{height} does not suit --magnify {times}; give multiples of {times}."
            )
        _check_window(smap, times, request.window)
    if not request.files:  # maps of built-in exemplars name their own
        names = tuple(source.name for source in smap.sources)
        if not names or not all(name.startswith("sample:") for name in names):
            raise ParameterError("the map needs its exemplars to be drawn; name them with --exemplar FILE.")
        request = replace(request, files=names)
    redraw(smap, request, report)


def _check_window(smap: SourceMap, times: int, window: tuple[int, int, int, int]) -> None:
    x, y, width, height = window
    for start, length, whole, closed, axis in (
        (x, width, smap.width * times, smap.wrap.x, "columns"),
        (y, height, smap.height * times, smap.wrap.y, "rows"),
    ):
        if not closed and (start < 0 or start + length > whole):
            raise ParameterError(
                f"--window {x},{y},{width},{height}: {axis} {start} to {start + length} do not lie in 0 to {whole} "
                f"of the map ({smap.width * times}x{smap.height * times} px); choose a part of it."
            )
    if width * height > MAX_PIXELS:
        raise ParameterError(f"--window {x},{y},{width},{height} is too large; give at most 2**31 px in all.")


def redraw(smap: SourceMap, request: Request, report: Report) -> None:
    """Read the exemplars, check them against the map, and draw all of their planes."""
    from ... import files
    from ...foundation.geometry import Box
    from ...foundation.run import Run
    from ...rendering.render import check_drawable, check_exemplars, render
    from ..exemplars import Inputs, sets_of, stem_of
    from ..outputs import Staging, check_all, check_depths, filled_name, plane_files

    began = time.perf_counter()
    sets = sets_of(request, report)
    if len(sets) != max(len(smap.sources), 1):
        raise InputError(f"the map was made of {len(smap.sources)} exemplars, {len(sets)} are given; give as many.")
    n = request.magnify
    x, y, width, height = request.window or (0, 0, smap.width * n, smap.height * n)
    part = Box(y // n, x // n, (y + height) // n, (x + width) // n)
    out = filled_name(request.out or "", {"stem": stem_of(sets[0]), "w": width, "h": height})
    pictures = plane_files(out, sets[0])
    check_all(pictures.values(), request.force, set())
    exemplars = Inputs(sets, request, report).exemplars
    check_exemplars(exemplars, smap)
    check_depths(pictures, exemplars[0], (width, height), request)
    blend = smap.blend.but(feather=request.feather, mixing=request.mixing, finish=request.corrections)
    check_drawable(exemplars, part.height, part.width, blend.feather)
    with report.watching(len(pictures)) as meter, Staging(request.force) as staging:
        for name, path in pictures.items():
            run = Run(request.threads, meter.stage("render", 0.0, 1.0), CANCEL)
            picture = render(exemplars, smap, name, blend, part, run)
            meter.next_part()
            files.write(staging.place(path), picture, depth=request.depth, run=Run(request.threads))
        staging.commit()
    seconds = time.perf_counter() - began
    report.note(f"{', '.join(pictures.values())}: {width}x{height} px, feather {blend.feather}, {seconds:.1f} s")
    report.result({
        "files": [{"path": path, "holds": name} for name, path in pictures.items()],
        "size": [width, height],
        "window": [x, y, width, height],
        "blend": blend.as_recipe,
        "exemplars": [{"sha256": e.digest, "size": [e.width, e.height]} for e in exemplars],
        "timings": {"total": round(seconds, 3)},
    })


command = HelpfulCommand("render", draw)
