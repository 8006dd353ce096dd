"""Remake the picture of reports: pebbles that were grown well, and pebbles in small squares laid without looking.

The pixels of the textures are the same on every machine; letters and the bytes of the JPEG file depend on Pillow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import intarsia as ia
from intarsia.tasks.drawings import pictures_of
from intarsia.tasks.scoring import Outcome

FOLDER = Path(__file__).resolve().parent / "images"
METHODS = (ia.Graphcut(), ia.RandomTiling(patch=16))


SIDE, GAP, PAPER = 256, 12, (250, 250, 248)  # px of a panel, and between panels


def panel(pixels: np.ndarray) -> np.ndarray:
    """One of the pictures of a report, as large as all others."""
    picture = Image.fromarray(pixels)
    picture.thumbnail((SIDE, SIDE), Image.Resampling.BOX)
    paper = Image.new("RGB", (SIDE + GAP, SIDE + GAP), PAPER)
    paper.paste(picture, (GAP // 2, GAP // 2))
    return np.asarray(paper)


def main() -> None:
    """Write the picture."""
    FOLDER.mkdir(exist_ok=True)
    made = [ia.synthesize("sample:pebbles", 256, method, seed=1, wrap="both") for method in METHODS]
    rows = [np.concatenate([panel(one.pixels) for one in pictures_of(Outcome.of(each))], axis=1) for each in made]
    path = FOLDER / "report.jpg"
    Image.fromarray(np.concatenate(rows)).save(path, quality=80, optimize=True)
    print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
