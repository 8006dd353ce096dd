"""Show which exemplar pixel every output pixel is: python examples/trace_pixels.py [SIZE].

Writes three pictures: what was grown, its pieces in colours, and how often each part of the exemplar was used.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import intarsia as ia


def main(size: int = 512, folder: Path = Path("demo")) -> list[Path]:
    """Grow, then read the map."""
    folder.mkdir(exist_ok=True)
    made = ia.synthesize("sample:stones", size, seed=5)
    y, x = made.map.yx[size // 2, size // 3]
    print(f"output pixel (row {size // 2}, column {size // 3}) is exemplar pixel (row {y}, column {x})")

    pieces = made.map.pieces()
    print(f"{len(np.unique(pieces))} pieces, {size * size / len(np.unique(pieces)):.0f} px each on average")
    palette = np.random.default_rng(0).integers(64, 256, (int(pieces.max()) + 1, 3), dtype=np.uint8)

    usage = made.map.usage()[0]
    print(f"{(usage > 0).mean():.0%} of the exemplar is shown, the most used pixel {usage.max()} times")
    heat = (usage * 255 // usage.max()).astype(np.uint8)

    pictures = {"grown": made.render(), "pieces": palette[pieces], "usage": heat}
    for name, picture in pictures.items():
        ia.write(folder / f"trace_{name}.png", picture, force=True)
    return [folder / f"trace_{name}.png" for name in pictures]


if __name__ == "__main__":
    print(*main(*(int(a) for a in sys.argv[1:])), sep="\n")
