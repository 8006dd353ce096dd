"""In the process beside: pictures of a result as it was made: pieces, joins, damage, how often, and from where."""

from __future__ import annotations

import json
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from ... import files
from ...cli.exemplars import Shelf, sets_of
from ...cli.help import read_argv
from ...cli.report import Report
from ...errors import InputError
from ...sourcemap import SourceMap
from ...tasks.drawings import HEAT, borders, heat, pieces, ramp, used
from ...tasks.scoring import Outcome, outcome_of
from .pictures import Pixels, png
from .worker import Answer, Tell

AROUND = 9  # px of the exemplar over which it is told how often it is shown
WIDEST = 1 << 24  # px of a map that is sent whole

_held: dict[str, Outcome] = {}


def view(said: dict[str, Any], tell: Tell) -> Answer:
    """Draw a kind of view over a result, at most `side` px a side: PNG with opacity."""
    smap, side = SourceMap.load(said["map"]), said["side"]
    if said["kind"] == "seams":
        return {}, png(_joins(said, smap, side))
    step = max(-(-max(smap.height, smap.width) // side), 1)
    drawn = {"pieces": _pieces, "usage": _usage, "provenance": _provenance}[said["kind"]](smap, step)
    return {}, png(drawn)


def origins(said: dict[str, Any], tell: Tell) -> Answer:
    """Return where every pixel of a box comes from: uint16, little-endian, (H, W, 3): exemplar, row, column.

    65535: from nowhere. Without a box: of all of the map.
    """
    smap = _map(said["map"])
    x, y, width, height = said["box"] or (0, 0, smap.width, smap.height)
    if width * height > WIDEST:
        raise InputError(f"the map has more than {WIDEST} px; ask for a box of it.")
    part = np.s_[y : y + height, x : x + width]
    which = _which(smap)[part]
    out = np.empty((*which.shape, 3), "<u2")
    out[..., 0], out[..., 1:] = which, np.clip(smap.yx[part], 0, 65534)
    out[which == 255] = 65535
    return {"width": smap.width, "height": smap.height}, out.tobytes()


@lru_cache(maxsize=1)
def _map(path: str) -> SourceMap:
    """The map that was asked for last: a pointer goes over it part by part."""
    return SourceMap.load(path)


def _which(smap: SourceMap) -> NDArray[np.uint8]:
    return np.zeros(smap.yx.shape[:2], np.uint8) if smap.which is None else smap.which


def _pieces(smap: SourceMap, step: int) -> Pixels:
    drawn = pieces(smap.pieces(), step)
    return np.dstack([drawn, np.full(drawn.shape[:2], 255, np.uint8)])


def _usage(smap: SourceMap, step: int) -> Pixels:
    """Each pixel in the colour of how often its place of the exemplar is shown: white MANY times the mean or more."""
    which, yx = _which(smap)[::step, ::step], smap.yx[::step, ::step]
    counts = [uniform_filter(count.astype(np.float32), AROUND, mode="nearest") for count in smap.usage()]
    mean = sum(float(c.sum()) for c in counts) / max(sum(c.size for c in counts), 1)
    out = np.zeros((*which.shape, 4), np.uint8)
    for number, count in enumerate(counts):
        here = which == number
        times = count[yx[here][:, 0], yx[here][:, 1]] / max(mean, 1e-9)
        out[here, :3] = used(times)
        out[here, 3] = 255
    return out


def _provenance(smap: SourceMap, step: int) -> Pixels:
    """Each pixel in the colour of its place in the exemplar: red to the right, green downwards, blue by exemplar."""
    which, yx = _which(smap)[::step, ::step], smap.yx[::step, ::step]
    out = np.zeros((*which.shape, 4), np.uint8)
    for number, source in enumerate(smap.sources):
        here = which == number
        ys, xs = yx[here][:, 0] / max(source.height - 1, 1), yx[here][:, 1] / max(source.width - 1, 1)
        out[here, 0], out[here, 1] = 40 + 200 * xs, 40 + 200 * ys
        out[here, 2], out[here, 3] = (150 + 97 * number) % 256, 255
    return out


def _joins(said: dict[str, Any], smap: SourceMap, side: int) -> Pixels:
    """What judging found, over the result: the redder, the more a join costs."""
    outcome = _outcome(said, smap)
    size = (smap.height, smap.width)
    step = max(-(-max(size) // side), 1)
    shape = tuple(-(-n // step) for n in size)
    out = np.zeros((*shape, 4), np.uint8)
    _, opaque = heat(outcome, size, shape)
    out[..., :3], out[..., 3] = ramp(HEAT, opaque), 230 * opaque
    out[borders(smap.pieces()[::step, ::step])] = (20, 20, 20, 150)
    return out


def _outcome(said: dict[str, Any], smap: SourceMap) -> Outcome:
    """Judge a result as the command `score` does, once."""
    key = json.dumps([said["map"], said["words"]])
    if key not in _held:
        _held.clear()
        asked, quiet = read_argv(said["words"]), Report(quiet=True)
        exemplars = Shelf(sets_of(asked, quiet), asked, quiet).exemplars
        _held[key] = outcome_of(exemplars, files.read(said["picture"], alpha=asked.alpha), map=smap)
    return _held[key]
