"""Remake the pictures of magnified and of flowing textures: magnified, flowing.

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
SIDE = 448


def side_by_side(name: str, pictures: list[Any]) -> None:
    """Write pictures of any height next to one another."""
    high = max(len(p) for p in pictures)
    columns = [np.pad(p[:, :, :3], ((0, high - len(p)), (0, GAP), (0, 0)), constant_values=255) for p in pictures]
    path = FOLDER / f"{name}.jpg"
    Image.fromarray(np.concatenate(columns, axis=1)[:, :-GAP]).save(path, quality=84, optimize=True)
    print(f"{path.name}: {path.stat().st_size // 1000} kB")


def magnified() -> list[Any]:
    """Pebbles; grown at full size; at a quarter of it, each map pixel drawn as a square; and blended."""
    exemplar = ia.read("sample:pebbles")
    whole = ia.synthesize(exemplar, SIDE, ia.ParallelControllable(), seed=5)
    small = ia.synthesize(ia.magnified(exemplar, 4), SIDE // 4, ia.ParallelControllable(), seed=5)
    return [np.asarray(p) for p in (exemplar.base, whole.render(), small.render(feather=0), small.render())]


def flowing() -> list[Any]:
    """Pebbles in a channel, fastest in the middle: frames 0, 1, 25, 50."""
    made = ia.synthesize("sample:pebbles", 256, ia.ParallelControllable(), seed=3, wrap="both")
    frames = [made]
    for frame in range(1, 51):
        made = ia.advect(made, lambda y, x: (0 * y, 3 * np.sin(np.pi * (y + 0.5) / 256) ** 2), frame=frame)
        frames.append(made)
    return [np.asarray(frames[n].render()) for n in (0, 1, 25, 50)]


def main() -> None:
    """Write the pictures."""
    FOLDER.mkdir(exist_ok=True)
    side_by_side("magnified", magnified())
    side_by_side("flowing", flowing())


if __name__ == "__main__":
    main()
