"""In the process beside: what a method makes of an exemplar, small, to choose by."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

import numpy as np

from ...cli.exits import CANCEL
from ...errors import CancelledError, InputError, MethodError, ParameterError
from ...exemplar import Exemplar
from ...image import Plane
from ...run import Run
from ...synthesis import synthesize
from .looking import exemplar_of
from .pictures import png, reduced, seen
from .worker import Answer, Tell

LARGEST = 320  # px a side of an exemplar: larger ones are reduced, so that all of it is seen
SIDE = 192  # px of what is grown
SLOW = {"efros-leung": (112, 96)}  # compares every pixel with all: of how much of the exemplar, and how much is grown
KEPT = 4

_small: OrderedDict[str, Exemplar] = OrderedDict()


def sketch(said: dict[str, Any], tell: Tell) -> Answer:
    """Grow a small picture with the usual parameters of a method; `why` there is none, where it cannot serve."""
    try:
        exemplar, method = _reduced(said["paths"]), said["method"]
        part, side = SLOW.get(method, (LARGEST, SIDE))
        made = synthesize(_middle(exemplar, part), side, method, run=Run(threads=1, cancel=CANCEL))
        return {}, png(seen(made.render()))
    except CancelledError:
        raise
    except (MethodError, ParameterError, InputError) as e:
        return {"why": str(e)}, b""


def _reduced(paths: list[str]) -> Exemplar:
    """The colours of an exemplar, as they are seen, at most LARGEST px a side; the last few are kept."""
    key = "\n".join(paths)
    if key not in _small:
        whole = exemplar_of(paths)
        pixels = np.ascontiguousarray(reduced(seen(whole.base), LARGEST)[:, :, :3])
        step = -(-max(whole.height, whole.width) // LARGEST)
        usable = None if whole.usable is None else whole.usable[::step, ::step][: pixels.shape[0], : pixels.shape[1]]
        _small[key] = Exemplar({"albedo": Plane(pixels)}, usable)
        while len(_small) > KEPT:
            _small.popitem(last=False)
    _small.move_to_end(key)
    return _small[key]


def _middle(exemplar: Exemplar, side: int) -> Exemplar:
    """What lies in the middle of an exemplar, at most so many px a side."""
    if max(exemplar.height, exemplar.width) <= side:
        return exemplar
    firsts = (max((n - side) // 2, 0) for n in exemplar.base.pixels.shape[:2])
    rows, columns = (slice(first, first + side) for first in firsts)
    usable = None if exemplar.usable is None else exemplar.usable[rows, columns]
    return Exemplar({"albedo": Plane(exemplar.base.pixels[rows, columns])}, usable)
