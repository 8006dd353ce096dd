"""Lay ground without end from sixteen tiles: python examples/endless_ground.py [ROW] [COLUMN].

A game that walks over it draws the tiles in sight; nothing else is known or stored.
"""

from __future__ import annotations

import sys
from pathlib import Path

import intarsia as ia


def main(row: int = 1_000_000, column: int = -250_000, folder: Path = Path("demo")) -> list[Path]:
    """Make the tiles, and write them and what is in sight at a place: six by eight tiles."""
    folder.mkdir(exist_ok=True)
    tiles = ia.tileset("sample:pebbles", 16, size=96, seed=1)
    seen = tiles.laid(tiles.rule.field(6, 8, first=(row, column)))
    written = [folder / "pebbles_tiles.png", folder / f"pebbles_at_{row}_{column}.png"]
    for path, picture in zip(written, (tiles.render(), seen), strict=True):
        ia.write(path, picture, force=True)
    return written


if __name__ == "__main__":
    print(*main(*(int(a) for a in sys.argv[1:])), sep="\n")
