"""Grow a wall from a small picture of one, and look at what was decided: python examples/grow_wall.py [SIZE]."""

from __future__ import annotations

import sys
from pathlib import Path

import intarsia as ia


def main(size: int = 1024, folder: Path = Path("demo")) -> Path:
    """Grow, tell the parameters that were chosen, write the picture with its recipe."""
    folder.mkdir(exist_ok=True)
    made = ia.synthesize("sample:stones", (size // 2, size), seed=1)
    print(made.method)
    out = folder / "wall.png"
    ia.write(out, made, recipe=made.recipe_text, force=True)
    return out


if __name__ == "__main__":
    print(main(*(int(a) for a in sys.argv[1:])))
