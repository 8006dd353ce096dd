"""Grow a wall, find its worst seams and cover them anew: python examples/repair_seams.py [SIZE].

Writes three pictures: as grown, repaired, and in white what the repair replaced.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import intarsia as ia


def main(size: int = 512, folder: Path = Path("demo")) -> list[Path]:
    """Grow, repair, compare the two maps."""
    folder.mkdir(exist_ok=True)
    grown = ia.synthesize("sample:stones", size, ia.PatchSampling(), seed=3)
    repaired = ia.repair(grown, passes=4)
    changed = (grown.map.yx != repaired.map.yx).any(axis=2)
    print(f"{changed.mean():.0%} of the pixels were replaced")
    pictures = {"before": grown, "after": repaired, "changed": np.where(changed, 255, 0).astype(np.uint8)}
    for name, picture in pictures.items():
        ia.write(folder / f"repair_{name}.png", picture, force=True)
    return [folder / f"repair_{name}.png" for name in pictures]


if __name__ == "__main__":
    print(*main(*(int(a) for a in sys.argv[1:])), sep="\n")
