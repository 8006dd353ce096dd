"""Worker process: findings as overlays, views of results and their maps, and edits of exemplars."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.ndimage import uniform_filter

from ... import files
from ...analysis.features import features
from ...analysis.illumination import flattened
from ...analysis.saliency import MEDIAN, saliency_map
from ...choosing.facts import Facts
from ...cli import Report
from ...cli.exemplars import Inputs, cropped, sets_of
from ...cli.outputs import files_of
from ...cli.verbs import read_argv
from ...foundation import InputError
from ...foundation.arrays import Array
from ...foundation.geometry import Wrap
from ...judging import places as judged
from ...materials.maps import proposed
from ...model import Exemplar
from ...model.canvas import Canvas
from ...model.sourcemap import SourceMap
from ...regular.rectify import straight_of
from ...tasks.completion import healed_scene
from ...tasks.drawings import CHOSEN, GROUPS, HEAT, borders, heat, pieces, ramp, to_rgb, usage_colours
from ...tasks.exemplar_analysis import Analysis, analyze
from ...tasks.scoring import Outcome, outcome_of
from .decoding import Pixels, coloured, exemplar_of, png
from .worker import Answer, Json, Tell

LINE, RED = (255, 225, 0, 255), (255, 60, 40, 255)
STRONG = 4  # times the usual saliency: what is drawn
FILL = 70  # opacity of tints, of 255
AROUND = 9  # px of the exemplar over which usage is averaged


def find(said: Json, tell: Tell) -> Answer:
    """Analyse an exemplar; return what `intarsia analyze --json` prints, and which overlays there are."""
    found = _findings(*said["paths"])
    masonry = _facts(found.exemplar).masonry
    more = {
        "overlays": [kind for kind, draw in DRAWN.items() if draw(found) is not None],
        "courses": None if masonry is None else masonry.told,
    }
    return found.as_dict() | more, b""


def overlay(said: Json, tell: Tell) -> Answer:
    """Return an overlay on a clear ground: PNG of the exemplar's size."""
    draw = DRAWN.get(said["kind"])
    drawn = draw and draw(_findings(*said["paths"]))
    if drawn is None:
        raise InputError(f"nothing of this kind was found: {said['kind']}.")
    return {}, png(drawn)


def rim(said: Json, tell: Tell) -> Answer:
    """Return by how many px `heal --grow auto` would enlarge a hole, and that area as PNG."""
    exemplar = exemplar_of(said["paths"])
    hole = files.read_mask(said["mask"], exemplar.base, exemplar.name)
    scene = healed_scene(exemplar, hole, (), Wrap.NONE, None)
    assert scene.canvas.start is not None
    drawn = _clear(exemplar)
    drawn[scene.canvas.start.holes & ~hole] = LINE
    return {"grow": scene.recipe["heal"]["grow"]}, png(drawn)


def edit(said: Json, tell: Tell) -> Answer:
    """Crop, straighten and flatten an exemplar, propose the maps that it lacks; return the names of the new files."""
    exemplar, done = exemplar_of(said["paths"]), []
    if said["crop"] is not None:
        exemplar, done = cropped(exemplar, tuple(said["crop"])), ["cropped"]
    if said["straighten"]:
        straight = straight_of(exemplar)
        if straight is None:
            raise InputError("its courses are straight already, or none of bricks are found.")
        exemplar, done = straight.exemplar, [*done, "straight"]
    if said["flatten"]:
        exemplar, done = flattened(exemplar), [*done, "flat"]
    if said["propose"]:
        exemplar = proposed(replace(exemplar, toroidal=files.tiles(said["paths"][0])))
    stem = "_".join([said["stem"], *done])
    made = files_of(stem, exemplar)
    for name, plane in made.items():
        files.write(os.path.join(said["folder"], name), plane)
    return {"names": list(made), "stem": stem}, b""


@lru_cache(maxsize=4)
def _findings(*paths: str) -> Analysis:
    return analyze(exemplar_of(list(paths)))


def _facts(exemplar: Exemplar) -> Facts:
    return exemplar.memo("studio", lambda: Facts([exemplar], Canvas(2 * exemplar.height, 2 * exemplar.width)))


def _clear(exemplar: Exemplar) -> Pixels:
    return np.zeros((exemplar.height, exemplar.width, 4), np.uint8)


def _lattice(found: Analysis) -> Pixels | None:
    """Return the lines of the lattice, extracted from the overlay that has them over the exemplar."""
    if found.lattice is None:
        return None
    out, drawn = _clear(found.exemplar), found.overlay("lattice").pixels
    out[..., :3] = drawn
    out[..., 3] = np.where((drawn != to_rgb(found.exemplar.base)).any(axis=2), 255, 0)
    return out


def _courses(found: Analysis) -> Pixels | None:
    """Return the lines between courses, two px thick."""
    lines, out = _facts(found.exemplar).courses, _clear(found.exemplar)
    if lines is None:
        return None
    drawn = out.swapaxes(0, 1) if lines.axis == 1 else out
    columns = np.arange(drawn.shape[1])
    for line in np.asarray(lines.at, np.int64):
        for row in (line, line + 1):
            inside = (row >= 0) & (row < drawn.shape[0])
            drawn[row[inside], columns[inside]] = LINE
    return out


def _striking(found: Analysis) -> Pixels | None:
    """Return the most salient regions, tinted and outlined."""
    exemplar, made, out = found.exemplar, features([found.exemplar]), _clear(found.exemplar)
    strikes = lambda: saliency_map(made.pictures[0][:, :, : made.base], exemplar.usable, exemplar.toroidal)  # noqa: E731
    most = exemplar.memo("strikes", strikes) > STRONG * MEDIAN
    out[most] = (*RED[:3], FILL)
    out[borders(most)] = RED
    return out if most.any() else None


def _segments(found: Analysis) -> Pixels | None:
    """Return each group in its tint, the chosen one in orange, with their borders."""
    segments = found.segments
    if not len(segments.groups):
        return None
    group, out = segments.group_map, _clear(found.exemplar)
    for number in range(int(group.max(initial=0)) + 1):
        tint = CHOSEN if number == segments.chosen else GROUPS[number % len(GROUPS)]
        out[group == number] = (*tint, FILL + 60 * (number == segments.chosen))
    out[borders(segments.labels)] = (20, 20, 20, 255)
    return out


DRAWN = {"lattice": _lattice, "courses": _courses, "striking": _striking, "segments": _segments}
"""Overlays in the order in which the page lists them; they return None where nothing was found."""


def view(said: Json, tell: Tell) -> Answer:
    """Return a view of a result, at most `side` px a side: PNG with opacity."""
    smap = SourceMap.load(said["map"])
    step = max(-(-max(smap.height, smap.width) // said["side"]), 1)
    if said["kind"] == "seams":
        return {}, png(_joins(said, smap, step))
    return {}, png({"pieces": _pieces, "usage": _usage, "provenance": _provenance}[said["kind"]](smap, step))


def _pieces(smap: SourceMap, step: int) -> Pixels:
    drawn = pieces(smap.pieces(), step)
    return np.dstack([drawn, np.full(drawn.shape[:2], 255, np.uint8)])


def _usage(smap: SourceMap, step: int) -> Pixels:
    """Return each pixel coloured by how often its place of the exemplar is used: white from MANY times the mean on."""
    counts = [uniform_filter(count.astype(np.float32), AROUND, mode="nearest") for count in smap.usage()]
    mean = sum(float(c.sum()) for c in counts) / max(sum(c.size for c in counts), 1)
    return coloured(smap, 0, step, lambda number, y, x: usage_colours(counts[number][y, x] / max(mean, 1e-9)))


def _provenance(smap: SourceMap, step: int) -> Pixels:
    """Return each pixel coloured by its place in the exemplar: red by column, green by row, blue by exemplar."""

    def places(number: int, y: Array, x: Array) -> Array:
        tall, wide = (max(n - 1, 1) for n in (smap.sources[number].height, smap.sources[number].width))
        return np.stack([40 + 200 * (x / wide), 40 + 200 * (y / tall), np.full(len(x), (150 + 97 * number) % 256)], 1)

    return coloured(smap, 0, step, places)


def _joins(said: Json, smap: SourceMap, step: int) -> Pixels:
    """Return the costs of joins over the result: the redder, the higher."""
    outcome = _outcome(said["map"], said["picture"], *said["words"])
    size = (smap.height, smap.width)
    shape = tuple(-(-n // step) for n in size)
    out = np.zeros((*shape, 4), np.uint8)
    opaque = heat(outcome, size, shape) ** 0.6
    out[..., :3], out[..., 3] = ramp(HEAT, opaque), 230 * opaque
    out[borders(smap.pieces()[::step, ::step])] = (20, 20, 20, 150)
    return out


def places(said: Json, tell: Tell) -> Answer:
    """Return where a result loses its score, by part, as JSON."""
    found = _outcome(said["map"], said["picture"], *said["words"])
    return {}, json.dumps(judged.places(found.judged)).encode()


@lru_cache(maxsize=1)
def _outcome(saved: str, picture: str, *words: str) -> Outcome:
    """Score a result as the command `score` does, once."""
    asked, quiet = read_argv(list(words)), Report(quiet=True)
    exemplars = Inputs(sets_of(asked, quiet), asked, quiet).exemplars
    smap = SourceMap.load(saved) if asked.saved else None  # that of what was mended has other exemplars
    return outcome_of(exemplars, files.read(picture, alpha=asked.alpha), map=smap, wrap=asked.wrap)
