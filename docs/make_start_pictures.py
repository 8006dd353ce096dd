"""Remake the pictures of extending, healing and tiling from built-in exemplars.

The pixels are the same on every machine; the bytes of the JPEG files depend on the version of Pillow.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import intarsia as ia

FOLDER = Path(__file__).resolve().parent / "images"
GAP = 16


def rgb(picture: Any) -> np.ndarray:
    """Return 8-bit pixels as (H, W, 3)."""
    pixels = np.asarray(picture)
    return np.dstack([pixels] * 3) if pixels.ndim == 2 else pixels[:, :, :3]


def beside(*pictures: np.ndarray) -> np.ndarray:
    """Put pictures side by side on white, centred."""
    height = max(p.shape[0] for p in pictures)
    parts = []
    for p in pictures:
        above = (height - p.shape[0]) // 2
        parts.append(np.pad(p, ((above, height - p.shape[0] - above), (0, GAP), (0, 0)), constant_values=255))
    return np.concatenate(parts, axis=1)[:, :-GAP]


def extended() -> np.ndarray:
    """A part of the sample, and the same part continued on all sides."""
    part = rgb(ia.read("sample:stones").base)[:192, :192]
    return beside(part, rgb(ia.extend(part, ia.Margins(100, 100, 100, 100), seed=2)))


def holes(side: int) -> np.ndarray:
    """A disc, a scratch, and lost blocks."""
    y, x = np.mgrid[:side, :side]
    hole = (y - 124) ** 2 + (x - 150) ** 2 < 30**2
    hole |= abs(y - 0.55 * x - 60) < 3
    for row, column in ((24, 32), (64, 72), (184, 64), (208, 200), (152, 216), (16, 120)):
        hole[row : row + 16, column : column + 16] = True
    return hole


def healed() -> np.ndarray:
    """The sample with holes, and healed."""
    part = rgb(ia.read("sample:stones").base)[:256, :256].copy()
    hole = holes(256)
    part[hole] = (255, 0, 255)
    return beside(part, rgb(ia.heal(part, hole)))


def tiled() -> np.ndarray:
    """Parts of two samples, shifted by half their size, as they are and tiled: borders meet in the middle."""
    rows = []
    for name in ("gravel", "stones"):
        part = rgb(ia.read(f"sample:{name}").base)[:210, :240]
        rows.append(beside(*(np.roll(p, (105, 120), (0, 1)) for p in (part, rgb(ia.tile(part))))))
    return np.concatenate([rows[0], np.full((GAP, rows[0].shape[1], 3), 255, np.uint8), rows[1]])


def main() -> None:
    """Write the pictures."""
    FOLDER.mkdir(exist_ok=True)
    for name, make in {"extended": extended, "healed": healed, "tiled": tiled}.items():
        path = FOLDER / f"{name}.jpg"
        Image.fromarray(make()).save(path, quality=86, optimize=True)
        print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
