"""Pictures of what was found in an exemplar, drawn over it: one function for each kind."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import files
from ..analysis.features import features
from ..blocks.grid import phase_of
from ..exemplar import Exemplar
from ..image import Plane
from ..lattice.lattice import Lattice
from ..lattice.vectors import UNIT

YELLOW, CYAN, WHITE = (255.0, 225.0, 0.0), (0.0, 225.0, 255.0), (255.0, 255.0, 255.0)
PAPER = 128.0  # under what is transparent
CORE, RIM = 0.6, 1.7  # px: half the width of a line, and of the dark rim that sets it off from bright pictures
POINT = 2.2  # px: radius of a lattice point
SHADE = 0.6  # how dark the rim is


def lattice_lines(exemplar: Exemplar, lattice: Lattice, size: float) -> Plane:
    """Draw the lines of the lattice, through where blocks are cut, and its points.

    Yellow lines run along the second vector, cyan ones along the first; rows without a period have yellow lines only.
    `size`: that of the elements, px.
    """
    picture = on_paper(exemplar)
    height, width = picture.shape[:2]
    cell = (lattice.vectors[0], lattice.vectors[1] if len(lattice.vectors) == 2 else None)
    phase = phase_of(features([exemplar]).pictures[0], cell, max(1.5 * size, 48.0))
    y, x = np.mgrid[:height, :width] + 0.5 - np.reshape(phase, (2, 1, 1))
    p, q = np.array(cell[0]) / UNIT
    if cell[1] is None:
        along = (y * p + x * q) / np.hypot(p, q)
        return as_plane(_line(picture, _off(along / np.hypot(p, q)) * np.hypot(p, q), YELLOW))
    r, s = np.array(cell[1]) / UNIT
    area = p * s - q * r
    first, second = (y * s - x * r) / area, (x * p - y * q) / area
    picture = _line(picture, _off(first) * abs(area) / np.hypot(r, s), YELLOW)
    picture = _line(picture, _off(second) * abs(area) / np.hypot(p, q), CYAN)
    a, b = first - np.floor(first), second - np.floor(second)
    corners = [np.hypot((a - i) * p + (b - j) * r, (a - i) * q + (b - j) * s) for i in (0, 1) for j in (0, 1)]
    return as_plane(_line(picture, np.maximum(np.min(corners, axis=0) - POINT, 0.0), WHITE))


def on_paper(exemplar: Exemplar) -> Any:
    """The exemplar in 8 bits as floats (H, W, 3); what is transparent lies on gray."""
    shown = files.preview(exemplar.base)
    pixels = shown.samples.astype(np.float64)
    if shown.alpha:
        opaque = pixels[..., -1:] / 255
        pixels = pixels[..., :-1] * opaque + PAPER * (1 - opaque)
    return np.array(np.broadcast_to(pixels[..., :3], (*pixels.shape[:2], 3)))


def as_plane(picture: Any) -> Plane:
    """Floats of 0 to 255 as an 8-bit plane."""
    return Plane(np.clip(np.rint(picture), 0, 255).astype(np.uint8))


def _off(share: Any) -> Any:
    """How far numbers are from whole ones."""
    return np.abs(share - np.rint(share))


def _line(picture: Any, distance: Any, colour: tuple[float, float, float]) -> Any:
    """Draw what lies at distance 0 px, smooth at its edges: a dark rim, then the colour."""
    rim = SHADE * np.clip(RIM + 0.5 - distance, 0, 1)[..., None]
    core = np.clip(CORE + 0.5 - distance, 0, 1)[..., None]
    return picture * (1 - rim) * (1 - core) + np.array(colour) * core
