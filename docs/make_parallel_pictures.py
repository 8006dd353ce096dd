"""Remake the pictures of parallel-controllable: with less and with more jitter; turned and scaled place by place.

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
    return np.clip(0.5 + 1.5 * x / 384, 0.25, 4) + 0 * y


def main() -> None:
    """Write the pictures."""
    FOLDER.mkdir(exist_ok=True)
    jittered()
    turned()


def jittered() -> None:
    """Less and more jitter, beside the exemplar."""
    exemplar = np.asarray(ia.read("sample:pebbles").base)[:192, :192, :3]
    columns = [np.pad(exemplar, ((96, 96), (0, 0), (0, 0)), constant_values=255)]
    for jitter in (0, None):
        made = ia.synthesize(exemplar, SIZE, ia.ParallelControllable(jitter=jitter), seed=4)
        columns.append(np.pad(np.asarray(made.render())[:, :, :3], ((0, 0), (GAP, 0), (0, 0)), constant_values=255))
    save("parallel.jpg", columns)


def turned() -> None:
    """Bricks around a point, planks turned by place, pebbles growing."""
    columns = []
    for name, angle, zoom in (
        ("brick", ia.Field(around), 1.0), ("planks", ia.Field(np.linspace(-60, 60, 384)[:, None] * np.ones(384)), 1.0),
        ("pebbles", 20.0, ia.Field(growing)),
    ):  # fmt: skip
        made = np.asarray(ia.synthesize(f"sample:{name}", 384, ia.ParallelControllable(angle=angle, zoom=zoom), seed=4))
        made = made[..., :3] if made.ndim == 3 else np.repeat(made[..., None], 3, axis=2)
        columns.append(np.pad(made, ((0, 0), (GAP if columns else 0, 0), (0, 0)), constant_values=255))
    save("turned.jpg", columns)


def save(name: str, columns: list[Any]) -> None:
    """Write pictures side by side."""
    path = FOLDER / name
    Image.fromarray(np.concatenate(columns, axis=1)).save(path, quality=86, optimize=True)
    print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
