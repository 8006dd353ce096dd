"""Draw the house: rooms on their floors, and which stands on which, as ``docs/images/architecture.svg``.

Part of ``make tables``, as it follows from the code; a test compares the picture with the code. Lines that must pass a
floor keep a narrow place of their own on it, so that none runs behind a room (Sugiyama, Tagawa and Toda 1981).
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from house import FLOORS, files_in, is_package, links  # noqa: E402

TARGET = ROOT / "docs" / "images" / "architecture.svg"
WIDTH, LEFT, RIGHT, TOP, PITCH = 1000, 70, 980, 16, 58  # px
TALL, LOW = 36, 24  # of the box of a package, and of that of a module
LETTER = 9  # px, about
GAP, PASSING = 30, 8  # between two boxes, and what a line needs that passes a floor
ROUNDS = 240
Place = tuple[int, str]
"""A floor, and the room on it or the line that passes it."""

STYLE = """
  text { font-family: -apple-system, "Segoe UI", "DejaVu Sans", Helvetica, Arial, sans-serif; fill: #1d2733; }
  .name { font-size: 15px; font-weight: 600; text-anchor: middle; }
  .count { font-size: 12px; text-anchor: middle; fill: #48586a; }
  .file { font-size: 14px; text-anchor: middle; }
  .floor { font-size: 12px; fill: #7d8a98; text-anchor: end; }
  .room { fill: #dbe9f8; stroke: #2f6db3; stroke-width: 1.5; }
  .module { fill: #ffffff; stroke: #9aa7b5; stroke-width: 1; }
  .line { fill: none; stroke: #64748b; stroke-width: 1.3; }
  .tip { fill: #64748b; }
"""


def width_of(name: str) -> int:
    """Return how wide a place is; a line that passes has a name with an arrow in it."""
    return PASSING if ">" in name else max(LETTER * len(shown(name)) + 22, 84 if is_package(name) else 0)


def shown(room: str) -> str:
    """Return what stands in the box of a room."""
    return room if is_package(room) else f"{room}.py"


def chains() -> list[list[Place]]:
    """Return every line as the places it goes through, from the room that imports down to the one that is imported."""
    floor = {room: n for n, rooms in enumerate(FLOORS) for room in rooms}
    out = []
    for room, others in links().items():
        for other in sorted(others):
            passed = [(n, f"{room}>{other}") for n in range(floor[room] - 1, floor[other], -1)]
            out.append([(floor[room], room), *passed, (floor[other], other)])
    return sorted(out)


def laid_out(lines: list[list[Place]]) -> dict[Place, int]:
    """Return the middle x of every place: near those that it is joined with, in an order that crosses few lines."""
    near: dict[Place, list[Place]] = {(n, room): [] for n, rooms in enumerate(FLOORS) for room in rooms}
    for chain in lines:
        for upper, lower in pairwise(chain):
            near.setdefault(upper, []).append(lower)
            near.setdefault(lower, []).append(upper)
    rows = [sorted(p for p in near if p[0] == n) for n in range(len(FLOORS))]
    x = dict.fromkeys(near, (LEFT + RIGHT) // 2)
    best, least = x, None
    for number in range(ROUNDS):
        for row in rows if number % 2 == 0 else rows[::-1]:
            wish = {p: wished(p, near[p], x, number) for p in row}
            if number < ROUNDS // 4:
                row.sort(key=lambda p: (wish[p], p[1]))
            spread(row, wish, x)
        bent = sum(abs(x[a] - x[b]) for c in lines for a, b in pairwise(c)) + 400 * crossings(lines, x)
        if least is None or bent < least:
            best, least = dict(x), bent
    ends = [at + side * width_of(p[1]) // 2 for p, at in best.items() for side in (-1, 1)]
    return {p: at + (LEFT + RIGHT - min(ends) - max(ends)) // 2 for p, at in best.items()}


def wished(place: Place, near: list[Place], x: dict[Place, int], number: int) -> int:
    """Return where a place would lie best: amid its neighbours below, then above, in the end both."""
    beside = [p for p in near if (p[0] < place[0]) == (number % 2 == 0)] if number < ROUNDS // 8 else near
    middles = [x[p] for p in beside or near]
    return sum(middles) // len(middles) if middles else x[place]


def spread(row: list[Place], wish: dict[Place, int], x: dict[Place, int]) -> None:
    """Lay out a row in its order, as near to the wishes as widths allow: half-way between pushed right and left."""
    room = [(width_of(a[1]) + width_of(b[1])) // 2 + GAP for a, b in pairwise(row)]
    first, last = LEFT + width_of(row[0][1]) // 2, RIGHT - width_of(row[-1][1]) // 2
    right, left = [max(first, wish[row[0]])], [min(last, wish[row[-1]])]
    for p, wide in zip(row[1:], room, strict=True):
        right.append(max(wish[p], right[-1] + wide))
    for p, wide in zip(row[-2::-1], room[::-1], strict=True):
        left.append(min(wish[p], left[-1] - wide))
    at = [(a + b) // 2 for a, b in zip(right, left[::-1], strict=True)]
    at[-1] = min(at[-1], last)
    for k in range(len(row) - 2, -1, -1):
        at[k] = min(at[k], at[k + 1] - room[k])
    at[0] = max(at[0], first)
    for k, wide in enumerate(room):
        at[k + 1] = max(at[k + 1], at[k] + wide)
    x.update(zip(row, at, strict=True))


def crossings(lines: list[list[Place]], x: dict[Place, int]) -> int:
    """Count how often two lines cross."""
    steps = [(a[0], x[a], x[b]) for chain in lines for a, b in pairwise(chain)]
    return sum(n == m and (a - c) * (b - d) < 0 for k, (n, a, b) in enumerate(steps) for m, c, d in steps[:k])


def height_of(place: Place) -> int:
    """Return how high a place is; a line that passes a floor is drawn straight where boxes are."""
    return TALL if ">" in place[1] or is_package(place[1]) else LOW


def y_of(floor: int) -> int:
    """Return the middle of a floor: the ground is below."""
    return TOP + PITCH * (len(FLOORS) - 1 - floor) + PITCH // 2


def ports(lines: list[list[Place]], x: dict[Place, int]) -> dict[tuple[int, bool], int]:
    """Return where each line leaves its first box and enters its last, side by side: (number, enters) -> x."""
    out = {}
    for enters in (False, True):
        boxes: dict[Place, list[int]] = {}
        for number, chain in enumerate(lines):
            boxes.setdefault(chain[-1 if enters else 0], []).append(number)
        for place, numbers in boxes.items():
            numbers.sort(key=lambda n: (x[lines[n][-2 if enters else 1]], n))
            step = min(16, (width_of(place[1]) - 20) // len(numbers))
            for k, n in enumerate(numbers):
                out[n, enters] = x[place] + (2 * k - len(numbers) + 1) * step // 2
    return out


def line(chain: list[Place], x: dict[Place, int], begin: int, end: int) -> str:
    """Return a line as a path: curves between floors, straight past the boxes of a floor."""
    path = ""
    for k, (a, b) in enumerate(pairwise(chain)):
        x0, x1 = begin if not k else x[a], end if k == len(chain) - 2 else x[b]
        y0, y1 = y_of(a[0]) + height_of(a) // 2, y_of(b[0]) - height_of(b) // 2
        last = k == len(chain) - 2
        y1 -= 6 if last else 0
        middle = (y0 + y1) // 2
        path += f"M{x0} {y0}" if not k else f"L{x0} {y0}"
        path += f"C{x0} {middle} {x1} {middle} {x1} {y1}"
    tip = f'<path class="tip" d="M{end - 4} {y1 - 1}h8l-4 7z"/>'
    return f'<path class="line" d="{path}"/>{tip}'


def box(place: Place, x: int) -> str:
    """Return the box of a room."""
    floor, room = place
    wide, high, y = width_of(room), height_of(place), y_of(floor)
    left, top = x - wide // 2, y - high // 2
    if not is_package(room):
        frame = f'<rect class="module" x="{left}" y="{top}" width="{wide}" height="{high}" rx="3"/>'
        return f'{frame}<text class="file" x="{x}" y="{y + 5}">{shown(room)}</text>'
    frame = f'<rect class="room" x="{left}" y="{top}" width="{wide}" height="{high}" rx="5"/>'
    name = f'<text class="name" x="{x}" y="{y - 2}">{room}</text>'
    return f'{frame}{name}<text class="count" x="{x}" y="{y + 13}">{len(files_in(room))} files</text>'


def drawing() -> str:
    """Return the picture as SVG, the same for the same imports."""
    lines = chains()
    x = laid_out(lines)
    doors = ports(lines, x)
    tall = 2 * TOP + PITCH * len(FLOORS)
    parts: list[str] = [f'<rect width="{WIDTH}" height="{tall}" fill="#ffffff"/>']
    for n in range(len(FLOORS)):
        shade = "#f6f8fa" if n % 2 else "#ffffff"
        parts.append(f'<rect x="0" y="{y_of(n) - PITCH // 2}" width="{WIDTH}" height="{PITCH}" fill="{shade}"/>')
        parts.append(f'<text class="floor" x="32" y="{y_of(n) + 4}">{n}</text>')
    parts += [line(chain, x, doors[n, False], doors[n, True]) for n, chain in enumerate(lines)]
    parts += [box(p, at) for p, at in sorted(x.items()) if ">" not in p[1]]
    return _svg(tall, parts)


def _svg(tall: int, parts: Iterable[str]) -> str:
    title = "The rooms of intarsia on their floors; a line leads from each room down to those that it stands on."
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {tall}" width="{WIDTH}" height="{tall}"'
    return f'{head} role="img">\n<title>{title}</title>\n<style>{STYLE}</style>\n' + "\n".join(parts) + "\n</svg>\n"


def main() -> None:
    """Write the picture where it is no longer true."""
    if not TARGET.exists() or TARGET.read_text(encoding="utf-8") != drawing():
        TARGET.write_text(drawing(), encoding="utf-8", newline="\n")
        print(TARGET.relative_to(ROOT), file=sys.stderr)


if __name__ == "__main__":
    main()
