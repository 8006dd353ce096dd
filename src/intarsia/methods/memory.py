"""What a work will take of memory at its peak: measured so far, and counted from there on."""

from __future__ import annotations

import numpy as np

from ..blend import Blend
from ..canvas import Canvas
from ..disk.depth import dtype_of
from ..disk.limits import taken
from ..exemplar import Exemplar
from .base import Method, passes_of, traits

WORKING = 45 << 20
"""Bytes that the first kernels and the writer of files add to what planning took."""

LEAST = 200 << 20
"""Bytes of Python and its libraries at work, where planning needed few of them."""

MAP, FRAMES, FEATHER, LEVEL, SPREAD = 9, 161, 3, 10, 57
"""Bytes: of a px of the map, of frames and fractions and what they are made of, of feathering a px, of levelling a
sample, of a px of a map that is gone over."""

ENCODED = 0.7
"""What a picture shrinks to in a file, of a texture with much grain."""

SEARCHED = {"repeat": 3, "random-tiling": 3, "parallel-controllable": 570}
"""Bytes that a method keeps of each px of the exemplars while it works; of the others, and around what is there:"""
SEARCHED_USUALLY, SEARCHED_AROUND = 30, 110


def memory_of(
    exemplars: tuple[Exemplar, ...], canvas: Canvas, method: Method, blend: Blend, depth: str | None
) -> int:
    """Estimate the peak of this process's memory in bytes, within 25 % where kernels are compiled already.

    Exemplars must be read and methods resolved: what that took is measured, not counted again.
    """
    area, own = canvas.height * canvas.width, sum(e.height * e.width for e in exemplars)
    searched = SEARCHED.get(method.slug, SEARCHED_USUALLY) if canvas.start is None else SEARCHED_AROUND
    each = MAP + (FEATHER if blend.feather else 0) + (0 if traits(method).exact else FRAMES)
    each += SPREAD if passes_of(method) else 0
    drawn = 0.0
    for plane in exemplars[0].planes.values():
        samples = plane.pixels.size * area / (exemplars[0].height * exemplars[0].width)
        held = plane.pixels.itemsize
        made = held if depth is None else np.dtype(dtype_of(depth)).itemsize
        written = (made if made != held else 0) + ENCODED * made + (made if made == 2 else 0)  # 16 bits: bytes swapped
        drawn = max(drawn, samples * (held + max(written, LEVEL if blend.finish else 0)))
    return int(max(LEAST, taken() + WORKING) + own * searched + area * each + drawn)
