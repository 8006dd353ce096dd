"""A contact sheet: the pictures of a batch in a grid, small, eight bits a channel."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .. import files
from ..image import Plane
from ..rendering.mixing import averaged

SIDE = 256
GAP = 8
PAPER = 64


def thumbnail(plane: Plane) -> Plane:
    """Return a picture as 8-bit RGB of at most 256 px a side, reduced by averaging blocks."""
    shown = files.preview(plane)
    n = -(-max(shown.height, shown.width) // SIDE)
    height, width = (max(side - side % n, 1) for side in (shown.height, shown.width))
    if min(height, width) >= n > 1:
        shown = shown.like(averaged(shown.like(shown.samples[:height, :width]), n))
    pixels = shown.samples[:SIDE, :SIDE]
    if shown.alpha:
        opacity = pixels[:, :, -1:].astype(np.uint32)
        pixels = ((pixels[:, :, :-1] * opacity + PAPER * (255 - opacity) + 127) // 255).astype(np.uint8)
    return Plane(np.broadcast_to(pixels, (*pixels.shape[:2], 3)))


def contact_sheet(pictures: Sequence[Plane]) -> Plane:
    """Lay thumbnails out in rows, in their order."""
    columns = math.ceil(math.sqrt(len(pictures)))
    rows = -(-len(pictures) // columns)
    high, wide = max(p.height for p in pictures), max(p.width for p in pictures)
    paper = np.full((rows * (high + GAP) + GAP, columns * (wide + GAP) + GAP, 3), PAPER, np.uint8)
    for number, picture in enumerate(pictures):
        row, column = divmod(number, columns)
        y, x = GAP + row * (high + GAP), GAP + column * (wide + GAP)
        paper[y : y + picture.height, x : x + picture.width] = picture.samples
    return Plane(paper)
