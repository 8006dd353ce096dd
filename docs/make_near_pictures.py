"""Remake the pictures of near-regular textures and of the best tile from a built-in exemplar.

The pixels are the same on every machine; the bytes of the JPEG file depend on the version of Pillow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import intarsia as ia

FOLDER = Path(__file__).resolve().parent / "images"
GAP = 16


def beside(method: ia.NearRegular | ia.BestTile) -> np.ndarray:
    """The exemplar, and what grows from it."""
    exemplar = np.asarray(ia.read("sample:tiles").base)[:, :, :3]
    grown = np.asarray(ia.synthesize("sample:tiles", (400, 560), method, seed=3).render())[:, :, :3]
    above = (grown.shape[0] - exemplar.shape[0]) // 2
    below = grown.shape[0] - exemplar.shape[0] - above
    left = np.pad(exemplar, ((above, below), (0, GAP), (0, 0)), constant_values=255)
    return np.concatenate([left, grown], axis=1)


def main() -> None:
    """Write the pictures."""
    FOLDER.mkdir(exist_ok=True)
    for name, method in (("near-regular", ia.NearRegular()), ("best-tile", ia.BestTile())):
        path = FOLDER / f"{name}.jpg"
        Image.fromarray(beside(method)).save(path, quality=86, optimize=True)
        print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
