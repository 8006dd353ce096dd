"""Remake the pictures of near-regular textures, of the best tile and of what is found in a built-in exemplar.

The pixels are the same on every machine; the bytes of the JPEG file depend on the version of Pillow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import intarsia as ia

FOLDER = Path(__file__).resolve().parent / "images"
GAP = 16


def rgb(plane: ia.Plane) -> np.ndarray:
    """Three channels."""
    pixels = plane.samples
    return np.repeat(pixels, 3, axis=2) if plane.channels == 1 else pixels[:, :, :3]


Method = ia.NearRegular | ia.GapFilling | ia.BestTile | ia.RasterQuilting


def beside(method: Method, sample: str = "sample:tiles", height: int = 400) -> np.ndarray:
    """The exemplar, and what grows from it."""
    exemplar = rgb(ia.read(sample).base)
    grown = rgb(ia.synthesize(sample, (height, 560), method, seed=3).render())
    above = (grown.shape[0] - exemplar.shape[0]) // 2
    below = grown.shape[0] - exemplar.shape[0] - above
    left = np.pad(exemplar, ((above, below), (0, GAP), (0, 0)), constant_values=255)
    return np.concatenate([left, grown], axis=1)


def analyzed() -> np.ndarray:
    """The exemplar under its lattice, and its best tile, four times."""
    found = ia.analyze("sample:tiles")
    seen = np.asarray(found.overlay())
    tile = np.tile(np.asarray(found.best_tile().planes["albedo"])[:, :, :3], (2, 2, 1))
    above = seen.shape[0] - tile.shape[0]
    right = np.pad(tile, ((above // 2, above - above // 2), (GAP, 0), (0, 0)), constant_values=255)
    return np.concatenate([seen, right], axis=1)


def main() -> None:
    """Write the pictures."""
    FOLDER.mkdir(exist_ok=True)
    pictures = {
        "near-regular": beside(ia.NearRegular()),
        "gap-filling": beside(ia.GapFilling()),
        "raster-quilting": beside(ia.RasterQuilting(patch=42, overlap=7), "sample:pebbles"),
        "unequal": beside(ia.NearRegular(course_heights="unequal"), "sample:stones"),
        "straightened": beside(ia.NearRegular(), "sample:brick", 512),
        "best-tile": beside(ia.BestTile()),
        "analyzed": analyzed(),
    }
    for name, picture in pictures.items():
        path = FOLDER / f"{name}.jpg"
        Image.fromarray(picture).save(path, quality=86, optimize=True)
        print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
