"""Compute one window of an endless texture, far from its origin: python examples/endless_window.py [SIZE].

The same window is cut from a larger one, to show that both are equal, pixel for pixel.
"""

from __future__ import annotations

import sys
from pathlib import Path

import intarsia as ia
from intarsia.synthesis import Synthesis


def main(size: int = 256, folder: Path = Path("demo")) -> list[Path]:
    """Compute the window alone, and in its surroundings."""
    folder.mkdir(exist_ok=True)
    exemplar, method = ia.read("sample:pebbles"), ia.ParallelControllable()
    row, column = -(2**33), 10**10
    small = ia.Box(row, column, row + size, column + size)
    large = ia.Box(row - 100, column - 100, row + size + 100, column + size + 100)
    alone = method.window([exemplar], small, seed=3, run=ia.Run())
    around = method.window([exemplar], large, seed=3, run=ia.Run())
    same = (alone.yx == around.yx[100:-100, 100:-100]).all()
    print("computed alone and cut from a larger one:", "equal" if same else "DIFFERENT")

    path = folder / "endless_window.png"
    ia.write(path, Synthesis((exemplar,), alone, method.blend, method).render(), force=True)
    return [path]


if __name__ == "__main__":
    print(*main(*(int(a) for a in sys.argv[1:])), sep="\n")
