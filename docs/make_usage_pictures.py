"""Remake the picture of even use: pebbles grown without a price of showing again, and with it, and what is shown.

The pixels are the same on every machine; the bytes of the JPEG file depend on the version of Pillow.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import intarsia as ia

TARGET = Path(__file__).resolve().parent / "images" / "usage.jpg"
GAP, SIDE, GROWN = 16, 200, 400
MOST = 12  # showings that are drawn white


def usage(made: ia.Synthesis) -> np.ndarray:
    """How often every pixel of the exemplar is shown, as gray: four, which is due, in the middle."""
    shown = made.map.usage()[0]
    tone = np.interp(shown, (0, 4, MOST), (0, 128, 255)).astype(np.uint8)
    return np.repeat(tone[:, :, None], 3, axis=2)


def main() -> None:
    """Write the picture: the exemplar, and for each price what is shown, above what is grown."""
    TARGET.parent.mkdir(exist_ok=True)
    exemplar = np.ascontiguousarray(ia.read("sample:pebbles").base.pixels[:SIDE, :SIDE])
    row = [np.full((GROWN, SIDE, 3), 255, np.uint8)]
    row[0][:SIDE] = exemplar
    for price in (0, 0.2):
        made = ia.synthesize(exemplar, GROWN, ia.Graphcut(evenness=price), seed=3)
        beside = np.full((GROWN, SIDE, 3), 255, np.uint8)
        beside[:SIDE] = usage(made)
        gap = np.full((GROWN, GAP, 3), 255, np.uint8)
        row += [gap, beside, gap, np.asarray(made.render(feather=0).pixels)]
    Image.fromarray(np.concatenate(row, axis=1)).save(TARGET, quality=86, optimize=True)
    print(f"{TARGET.name}: {TARGET.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
