"""Remake the picture of striking things: a heap of pebbles with a red one, grown without and with a limit.

The pixels are the same on every machine; the bytes of the JPEG file depend on the version of Pillow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import intarsia as ia

TARGET = Path(__file__).resolve().parent / "images" / "striking.jpg"
GAP, SIDE, GROWN = 16, 200, 480
MIDDLE, RADIUS = (103, 92), 13  # where the pebble lies that is made red, px


def exemplar() -> np.ndarray:
    """Built-in pebbles, one of which is red."""
    pixels = np.array(ia.read("sample:pebbles").base.pixels)[:SIDE, :SIDE]
    y, x = np.indices((SIDE, SIDE))
    near = (y - MIDDLE[0]) ** 2 + (x - MIDDLE[1]) ** 2 < RADIUS**2
    pixels[near] = np.clip(pixels[near].mean(axis=1, keepdims=True) * (1.6, 0.4, 0.3), 0, 255).astype(np.uint8)
    return pixels


def main() -> None:
    """Write the picture."""
    TARGET.parent.mkdir(exist_ok=True)
    e = exemplar()
    row = [np.full((GROWN, SIDE, 3), 255, np.uint8)]
    row[0][:SIDE] = e
    for share in (None, 0.5):
        made = ia.synthesize(e, GROWN, ia.Graphcut(striking=share), seed=3)
        row += [np.full((GROWN, GAP, 3), 255, np.uint8), np.asarray(made.render(feather=0).pixels)]
    Image.fromarray(np.concatenate(row, axis=1)).save(TARGET, quality=86, optimize=True)
    print(f"{TARGET.name}: {TARGET.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
