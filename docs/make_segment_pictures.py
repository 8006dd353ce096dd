"""Remake the pictures of docs/methods/segment-based.md from built-in procedural exemplars."""

from __future__ import annotations

import numpy as np
from make_pictures import FOLDER, beside, grown, rgb, sample
from PIL import Image

import intarsia as ia
from intarsia.tasks.drawings import segment_overlay


def segments() -> np.ndarray:
    """Two exemplars as they are, and with their groups of segments."""
    names = ("stones", "pebbles")
    return beside(*(p for n in names for p in (sample(n), segment_overlay(ia.read(f"sample:{n}")))))


def segment_based() -> np.ndarray:
    """An exemplar, and what grows from it."""
    return beside(sample("stones"), rgb(grown("stones", 400, ia.SegmentBased(), seed=1)))


if __name__ == "__main__":
    for name, make in (("segments", segments), ("segment-based", segment_based)):
        path = FOLDER / f"{name}.jpg"
        Image.fromarray(make()).save(path, quality=86, optimize=True)
        print(f"{path.name}: {path.stat().st_size // 1000} kB")
