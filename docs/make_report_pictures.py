"""Remake the picture of reports: pebbles that were grown well, and pebbles in small squares laid without looking.

The pixels of the textures are the same on every machine; letters and the bytes of the JPEG file depend on Pillow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import intarsia as ia
from intarsia.tasks.report import sheet_of
from intarsia.tasks.scoring import Outcome

FOLDER = Path(__file__).resolve().parent / "images"
METHODS = (ia.Graphcut(), ia.RandomTiling(patch=16))


def main() -> None:
    """Write the picture."""
    FOLDER.mkdir(exist_ok=True)
    made = [ia.synthesize("sample:pebbles", 256, method, seed=1, wrap="both") for method in METHODS]
    sheets = [Image.fromarray(np.asarray(sheet_of(Outcome.of(one)).pixels)) for one in made]
    halves = [sheet.resize((sheet.width // 2, sheet.height // 2), Image.Resampling.BOX) for sheet in sheets]
    path = FOLDER / "report.jpg"
    both = np.concatenate([np.asarray(one) for one in halves])
    Image.fromarray(both).save(path, quality=80, optimize=True)
    print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
