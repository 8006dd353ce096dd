"""Remake the picture of levelling: a wall lit from one side, grown without and with it.

The pixels are the same on every machine; the bytes of the JPEG file depend on the version of Pillow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import intarsia as ia

FOLDER = Path(__file__).resolve().parent / "images"
GAP = 16


def lit(name: str) -> np.ndarray:
    """A built-in exemplar, twice as light on the right as on the left."""
    pixels = np.asarray(ia.read(f"sample:{name}").base)
    slope = np.linspace(0.6, 1.2, pixels.shape[1]).reshape(1, -1, *[1] * (pixels.ndim - 2))
    return np.clip(pixels * slope, 0, 255).astype(np.uint8)


def levelled(name: str, method: ia.RandomTiling | ia.ImageQuilting) -> np.ndarray:
    """The exemplar, and what grows from it, as it is and levelled."""
    exemplar = lit(name)[:256, :256]
    made = ia.synthesize(exemplar, (256, 400), method, seed=5)
    pictures = [exemplar, made.render().pixels, made.render(finish=(ia.Levelling(96),)).pixels]
    gap = np.full((256, GAP, *exemplar.shape[2:]), 255, np.uint8)
    row = [p for picture in pictures for p in (np.asarray(picture), gap)][:-1]
    return np.concatenate(row, axis=1)


def main() -> None:
    """Write the picture."""
    FOLDER.mkdir(exist_ok=True)
    path = FOLDER / "levelled.jpg"
    Image.fromarray(levelled("planks", ia.ImageQuilting())).save(path, quality=86, optimize=True)
    print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
