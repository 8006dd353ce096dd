"""Remake the picture of a repair: a wall, and the same wall with its worst seams covered anew.

The pixels are the same on every machine; the bytes of the JPEG file depend on the version of Pillow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import intarsia as ia

FOLDER = Path(__file__).resolve().parent / "images"
GAP = 16


def main() -> None:
    """Write the picture."""
    FOLDER.mkdir(exist_ok=True)
    made = ia.synthesize("sample:stones", (336, 432), ia.PatchSampling(), seed=3)
    before, after = (np.asarray(one.render())[:, :, :3] for one in (made, ia.repair(made)))
    path = FOLDER / "repaired.jpg"
    gap = np.full((before.shape[0], GAP, 3), 255, np.uint8)
    Image.fromarray(np.concatenate([before, gap, after], axis=1)).save(path, quality=86, optimize=True)
    print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
