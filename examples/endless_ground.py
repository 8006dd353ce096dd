"""Lay ground without end from sixteen tiles: python examples/endless_ground.py [ROW] [COLUMN].

A game that walks over it draws the tiles in sight; nothing else is known or stored.
"""

from __future__ import annotations

import sys
from pathlib import Path

import intarsia as ia

PLACE = 1_000_000, -250_000  # row and column, far out


def main(size: int = 96, folder: Path = Path("demo"), place: tuple[int, int] = PLACE) -> list[Path]:
    """Make tiles of `size` px, and write them and what is in sight at a place: six by eight tiles."""
    folder.mkdir(exist_ok=True)
    tiles = ia.tileset("sample:pebbles", 16, size=size, seed=1)
    seen = tiles.laid(tiles.rule.field(6, 8, first=place))
    written = [folder / "pebbles_tiles.png", folder / f"pebbles_at_{place[0]}_{place[1]}.png"]
    for path, picture in zip(written, (tiles.render(), seen), strict=True):
        ia.write(path, picture, force=True)
    return written


if __name__ == "__main__":
    row, column = map(int, sys.argv[1:3]) if len(sys.argv) > 2 else PLACE
    print(*main(place=(row, column)), sep="\n")
