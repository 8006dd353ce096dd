"""Remake the picture of parallel-controllable: an exemplar, what is grown from it with less and with more jitter.

The pixels are the same on every machine; the bytes of the JPEG file depend on the version of Pillow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import intarsia as ia

FOLDER = Path(__file__).resolve().parent / "images"
GAP = 16
SIZE = (384, 448)


def main() -> None:
    """Write the picture."""
    FOLDER.mkdir(exist_ok=True)
    exemplar = np.asarray(ia.read("sample:pebbles").base)[:192, :192, :3]
    columns = [np.pad(exemplar, ((96, 96), (0, 0), (0, 0)), constant_values=255)]
    for jitter in (0, None):
        made = ia.synthesize(exemplar, SIZE, ia.ParallelControllable(jitter=jitter), seed=4)
        columns.append(np.pad(np.asarray(made.render())[:, :, :3], ((0, 0), (GAP, 0), (0, 0)), constant_values=255))
    path = FOLDER / "parallel.jpg"
    Image.fromarray(np.concatenate(columns, axis=1)).save(path, quality=86, optimize=True)
    print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
