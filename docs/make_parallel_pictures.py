"""Remake the pictures of parallel-controllable: jitter, also from a picture; outlines kept; turned and scaled.

The pixels are the same on every machine; the bytes of the JPEG file depend on the version of Pillow.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import intarsia as ia

FOLDER = Path(__file__).resolve().parent / "images"
GAP = 16
SIZE = (384, 448)


def around(y: Any, x: Any) -> Any:
    """Degrees of a circle around the middle of the picture."""
    return np.degrees(np.arctan2(192 - y, x - 192))


def growing(y: Any, x: Any) -> Any:
    """From half the size to twice the size."""
    return 0.5 + 1.5 * x / 384 + 0 * y


def main() -> None:
    """Write the pictures."""
    FOLDER.mkdir(exist_ok=True)
    save("parallel.jpg", jittered())
    save("parallel-controls.jpg", controlled())
    save("turned.jpg", turned())


def jittered() -> np.ndarray:
    """Return the exemplar, and what is grown from it with less and with more jitter."""
    exemplar = np.asarray(ia.read("sample:pebbles").base)[:192, :192, :3]
    columns = [np.pad(exemplar, ((96, 96), (0, 0), (0, 0)), constant_values=255)]
    for jitter in (0, None):
        made = ia.synthesize(exemplar, SIZE, ia.ParallelControllable(jitter=jitter), seed=4)
        columns.append(np.pad(np.asarray(made.render())[:, :, :3], ((0, 0), (GAP, 0), (0, 0)), constant_values=255))
    return np.concatenate(columns, axis=1)


def controlled() -> np.ndarray:
    """Return jitter that begins at a third and grows to the right; below, without and with the outlines of a mask."""
    tiles = np.asarray(ia.read("sample:tiles").base)[:, :, :3]
    wide, half = (256, 2 * 384 + GAP), (256, 384)
    ramp = np.linspace(-0.5, 1, wide[1])[None].repeat(wide[0], axis=0).clip(0)
    torus = ia.Exemplar.of(tiles, toroidal=True)
    across = grown(torus, wide, ia.ParallelControllable(jitter=(0, 0, 0.4), jitter_output=ramp, keep_lattice="off"))
    glazed = tiles[:, :, 2].astype(int) > tiles[:, :, 0]  # the grout is pale and warm
    pair = [grown(tiles, half, ia.ParallelControllable(feature=mask, keep_lattice="off")) for mask in (None, glazed)]
    gap = np.full((half[0], GAP, 3), 255, np.uint8)
    below = np.concatenate([pair[0], gap, pair[1]], axis=1)
    return np.concatenate([across, np.full((GAP, wide[1], 3), 255, np.uint8), below])


def grown(exemplar: np.ndarray | ia.Exemplar, size: tuple[int, int], method: ia.ParallelControllable) -> np.ndarray:
    """Return what a method grows."""
    return np.asarray(ia.synthesize(exemplar, size, method, seed=4).render())[:, :, :3]


def turned() -> np.ndarray:
    """Return bricks around a point, planks turned by place, pebbles growing."""
    columns = []
    for name, angle, zoom in (
        ("brick", ia.Field(around), 1.0), ("planks", ia.Field(np.linspace(-60, 60, 384)[:, None] * np.ones(384)), 1.0),
        ("pebbles", 20.0, ia.Field(growing)),
    ):  # fmt: skip
        made = np.asarray(ia.synthesize(f"sample:{name}", 384, ia.ParallelControllable(angle=angle, zoom=zoom), seed=4))
        made = made[..., :3] if made.ndim == 3 else np.repeat(made[..., None], 3, axis=2)
        columns.append(np.pad(made, ((0, 0), (GAP if columns else 0, 0), (0, 0)), constant_values=255))
    return np.concatenate(columns, axis=1)


def save(name: str, picture: np.ndarray) -> None:
    """Write a picture, and tell its size."""
    path = FOLDER / name
    Image.fromarray(picture).save(path, quality=86, optimize=True)
    print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
