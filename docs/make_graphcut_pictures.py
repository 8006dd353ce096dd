"""Remake the picture of graph-cut textures: an exemplar, what is grown from it, and the pieces that it is made of.

The pixels are the same on every machine; the bytes of the JPEG file depend on the version of Pillow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import intarsia as ia

FOLDER = Path(__file__).resolve().parent / "images"
GAP = 16


def coloured(made: ia.Synthesis) -> np.ndarray:
    """The output, every piece under a colour of its own."""
    pieces = made.map.pieces()
    y, x = np.indices(pieces.shape)
    away = (made.map.yx - np.stack([y, x], axis=2)).astype(np.int64)  # one shift, one colour
    mixed = (away[:, :, 0] * 7919 + away[:, :, 1] * 104729) % 16777213
    tint = np.stack([mixed % 241, mixed // 241 % 239, mixed // 57599 % 233], axis=2)
    pixels = np.asarray(made.render())[:, :, :3].astype(np.int64)
    return ((2 * pixels + 3 * tint) // 5).astype(np.uint8)


def main() -> None:
    """Write the picture."""
    FOLDER.mkdir(exist_ok=True)
    exemplar = np.asarray(ia.read("sample:pebbles").base)[:256, :256, :3]
    made = ia.synthesize(exemplar, (384, 448), ia.Graphcut(), seed=1)
    grown = np.asarray(made.render())[:, :, :3]
    above = grown.shape[0] - exemplar.shape[0]
    left = np.pad(exemplar, ((above // 2, above - above // 2), (0, GAP), (0, 0)), constant_values=255)
    middle = np.pad(grown, ((0, 0), (0, GAP), (0, 0)), constant_values=255)
    path = FOLDER / "graphcut.jpg"
    Image.fromarray(np.concatenate([left, middle, coloured(made)], axis=1)).save(path, quality=86, optimize=True)
    print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
