"""Paint the built-in exemplars by formula, and write them where the package keeps them.

    python tools/make_samples.py            into src/intarsia/files/painted
    python tools/make_samples.py -o FOLDER  elsewhere

They wrap around, and have the same pixels on every machine: all in them follows from hashed integers.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from paint_setts import painted as setts
from PIL import Image
from relief import (
    LIGHT,
    SIDE,
    F,
    I,
    box_blur,
    cloud,
    grid,
    hash_of,
    hashed_share,
    laid,
    lattice,
    light,
    picked,
    rounded_box,
    shadow,
    smooth,
    stretched,
)

FOLDER = Path(__file__).parents[1] / "src" / "intarsia" / "files" / "painted"
Pixels = NDArray[Any]


def tiles() -> Pixels:
    """Glazed tiles of uneven blues and greens, with pale grout."""
    side = 64
    y, x = grid()
    row, column = y // side, x // side
    number = row * 4 + column
    v = (y % side) + 0.5 - side / 2 + 1.6 * (hashed_share(number, 1) - 0.5)
    u = (x % side) + 0.5 - side / 2 + 1.6 * (hashed_share(number, 2) - 0.5)
    half = side / 2 - 2.6 + 0.9 * (lattice(16, 16, 3) - 0.5)
    inside = rounded_box(u, v, half, half, 5.0)  # px to the edge, positive inside
    glaze = cloud(64, 4, 4)
    cover = np.clip(inside + 0.5, 0.0, 1.0)[..., None]
    crown = 2.6 * smooth(inside / 6.5) + 2.2 * cloud(32, 5, 2)
    height = crown * cover[..., 0] + (0.4 + 0.9 * cloud(4, 6, 2)) * (1 - cover[..., 0])
    palette = [
        (38, 104, 118), (52, 132, 134), (30, 82, 112), (84, 152, 140), (116, 168, 150), (44, 112, 100), (70, 126, 150),
    ]  # fmt: skip
    colour = picked(palette, hash_of(number, 0, 7)) * (0.86 + 0.28 * hashed_share(number, 8))[..., None]
    pooled = smooth(1.0 - inside / 16.0)  # glaze gathers, darker, toward the edge
    colour = colour * (1.12 - 0.34 * pooled - 0.36 * (glaze - 0.5))[..., None]
    cloudy = smooth((cloud(16, 9, 4) - 0.42) / 0.3)
    colour = colour * (0.9 + 0.16 * cloudy)[..., None] + 9.0 * cloudy[..., None]
    joint = np.array([196.0, 187.0, 170.0]) * (0.72 + 0.36 * cloud(8, 10, 4))[..., None]
    joint = joint * (0.62 + 0.38 * smooth(-inside / 2.6))[..., None]
    shade, gloss = light(height, 0.9)
    lit = (colour * cover + joint * (1 - cover)) * shade[..., None]
    return _painted(lit + cover * 120.0 * gloss[..., None])


def pebbles() -> Pixels:
    """River pebbles, heaped: browns, greys and a few reds."""
    top, normal, number, rim = _heap(19, 21)
    palette = [
        (142, 122, 100), (168, 150, 126), (116, 104, 94), (150, 146, 138), (188, 176, 156),
        (96, 90, 86), (128, 98, 76), (172, 132, 102), (138, 136, 132), (204, 198, 186),
    ]  # fmt: skip
    colour = picked(palette, hash_of(number, 0, 30)) * (0.84 + 0.3 * hashed_share(number, 31))[..., None]
    shift = hash_of(number, 3, 32) % SIDE
    y, x = grid()
    bands = cloud(16, 33, 4)[(y + shift) % SIDE, (x + shift // 3) % SIDE]
    grain = cloud(3, 34, 2)
    colour = colour * (0.84 + 0.34 * (bands - 0.5) + 0.3 * grain)[..., None]
    facing = normal[0] * LIGHT[0] + normal[1] * LIGHT[1] + normal[2] * LIGHT[2]
    shade = 0.34 + 0.86 * np.clip(facing, 0.0, 1.0)
    around = box_blur(top, 9)
    open_sky = np.clip(0.98 + (top - around) * 0.075, 0.24, 1.08)
    cast = shadow(top)
    sheen = np.clip(facing, 0.0, 1.0)
    sheen = sheen * sheen * sheen * sheen * sheen * sheen
    lit = colour * (shade * open_sky * cast * (0.7 + 0.3 * rim))[..., None] + (26.0 * sheen * cast)[..., None]
    return _painted(lit)


def stones() -> Pixels:
    """A wall of dressed stones in courses, of sandy tones that each have many, in wide joints of dark mortar."""
    y, x = grid()
    wy = y + 0.5 + 1.6 * (cloud(32, 41, 2) - 0.5)
    wx = x + 0.5 + 3.0 * (cloud(32, 42, 3) - 0.5)
    inside, number, _, _ = laid(wy % SIDE, wx % SIDE, (6, 5, 5, 6, 5, 5, 6), (36.0, 16.0), 2.6, 6.0, 200)
    inside = inside + 1.8 * (cloud(8, 43, 2) - 0.5)
    shift = hash_of(number, 1, 44) % SIDE
    rough = cloud(16, 45, 4)[(y + shift) % SIDE, (x + 3 * shift) % SIDE]
    fine = cloud(4, 46, 2)
    bulge = 3.4 * smooth(inside / 7.0)
    cover = np.clip(inside * 0.6 + 0.5, 0.0, 1.0)
    height = (bulge + 4.0 * (rough - 0.5) + 0.8 * fine + 1.5) * cover + 0.8 * cloud(4, 49, 2) * (1.0 - cover)
    palette = [(176, 148, 112), (164, 142, 116), (172, 152, 124), (156, 134, 106), (168, 140, 109)]
    colour = picked(palette, number) * (0.96 + 0.08 * hashed_share(number, 51))[..., None]
    colour = colour * (0.86 + 0.4 * (rough - 0.5) + 0.24 * fine)[..., None]
    mortar = np.array([112.0, 104.0, 92.0]) * (0.7 + 0.24 * cloud(4, 53, 2))[..., None]
    shade, _ = light(height, 0.75)
    shade = shade * cover + (0.94 + 0.06 * shade) * (1.0 - cover)
    lit = (colour * cover[..., None] + mortar * (1 - cover)[..., None]) * shade[..., None]
    return _painted(lit)


def planks() -> Pixels:
    """Weathered boards of warm wood, with grain, knots, butt joints and nails."""
    y, x = grid()
    boards = np.array([0, 47, 102, 150, 206, 256])
    board = np.searchsorted(boards, x[0], side="right") - 1
    left, right = boards[board], boards[board + 1]
    joint = hash_of(np.arange(5), 0, 61) % SIDE  # each board has one butt joint
    along = (y - joint[board]) % SIDE
    across = (x - left) + 0.5
    number = np.broadcast_to(board, y.shape)
    shift = hash_of(number, 5, 62) % SIDE
    slow = stretched(8, 64, 63)[(y + shift) % SIDE, (x + shift) % SIDE]
    bend, knot, ring = _knots(along, across, number)
    t = across * 0.135 + 2.6 * slow + bend + 9.0 * hashed_share(number, 64)
    wave = t - np.floor(t)
    late = smooth(wave / 0.82) * (1.0 - smooth((wave - 0.82) / 0.18))  # slow to darken, quick to clear
    fibre = stretched(1, 24, 65)
    fine = stretched(2, 48, 66)
    palette = [(176, 128, 82), (160, 112, 70), (190, 144, 96), (150, 106, 70), (182, 136, 92)]
    base = picked(palette, hash_of(number, 6, 67))
    base = base * (0.9 + 0.16 * hashed_share(number, 68))[..., None]
    dark = np.stack([0.34 * late, 0.4 * late, 0.46 * late], axis=2)
    colour = base * (1.0 - 0.62 * dark) * (0.8 + 0.24 * fibre + 0.2 * fine)[..., None]
    colour = colour * (0.92 + 0.16 * cloud(64, 69, 3))[..., None]
    tone = np.array([84.0, 50.0, 28.0]) * (0.75 + 0.5 * ring)[..., None]
    colour = colour * (1 - knot[..., None]) + tone * knot[..., None]
    edge = np.minimum(np.minimum(across, right - x - 0.5), np.minimum(along + 0.5, SIDE - along - 0.5))
    edge = edge + 0.9 * (stretched(2, 16, 70) - 0.5)
    height = 2.6 * smooth((edge - 0.4) / 3.2) + 0.55 * fibre - 0.7 * late + 0.5 * fine
    shade, _ = light(height, 0.55)
    gap = smooth((edge - 0.3) / 1.6)
    lit = colour * (shade * (0.16 + 0.84 * gap))[..., None]
    for at in (9, SIDE - 10):
        for share in (0.25, 0.75):
            lit = _nail(lit, along - at, across - np.floor(share * (right - left)) - 0.5)
    return _painted(lit)


def _heap(cell: int, seed: int) -> tuple[F, tuple[F, F, F], I, F]:
    """Drop ellipsoids around a jittered grid: the highest surface, its normal, its number, and how far from its rim."""
    n = SIDE // cell
    step = SIDE / n
    top = np.full((SIDE, SIDE), -1e9)
    facts = [np.zeros((SIDE, SIDE)) for _ in range(4)]
    owner = np.zeros((SIDE, SIDE), np.int64)
    for number in range(2 * n * n):
        i = number % (n * n)
        at = [float(hashed_share(np.array(number), seed + k)) for k in range(8)]
        late = number >= n * n
        cy, cx = (i // n + at[0]) * step, (i % n + at[1]) * step
        long = step * ((0.5 + 0.62 * at[2] * at[2]) if late else (0.62 + 0.34 * at[2]))
        short = long * (0.62 + 0.34 * at[3])
        a, b = at[4] - 0.5, at[5] - 0.5
        norm = float(np.sqrt(a * a + b * b)) or 1.0
        c, s = (a / norm, b / norm) if norm > 1e-6 else (1.0, 0.0)
        rows, columns = _reached(cy, long), _reached(cx, long)
        window = np.ix_(rows % SIDE, columns % SIDE)
        dy, dx = (rows + 0.5 - cy)[:, None], (columns + 0.5 - cx)[None, :]
        u, v = (c * dx + s * dy) / long, (-s * dx + c * dy) / short
        d2 = u * u + v * v
        d2 = d2 * (0.35 + 0.65 * d2)  # flatter than a ball
        tall = short * 0.62
        lift = 6.0 * at[6] - 3.0 + (2.0 if late else 0.0)
        z = np.where(d2 < 1.0, lift + tall * np.sqrt(np.clip(1.0 - d2, 0.0, 1.0)), -1e9)
        wins = z > top[window]
        gx, gy = c * u / long - s * v / short, s * u / long + c * v / short
        nz = np.sqrt(np.clip(1.0 - d2, 0.0, 1.0)) / (short * 0.8)
        for store, value in zip((top, *facts), (z, gx, gy, nz, 1.0 - d2), strict=True):
            store[window] = np.where(wins, value, store[window])
        owner[window] = np.where(wins, number, owner[window])
    gx, gy, gz, rim = facts
    bare = top < -1e8
    top, gz = np.where(bare, -3.0, top), np.where(bare, 1.0, gz)
    norm_of = np.sqrt(gx * gx + gy * gy + gz * gz) + 1e-9
    return top, (gx / norm_of, gy / norm_of, gz / norm_of), owner, smooth(rim / 0.35)


def _reached(centre: float, reach: float) -> I:
    return np.arange(int(centre - reach - 1), int(centre + reach + 2))


def _knots(along: I, across: F, board: I) -> tuple[F, F, F]:
    """Place a knot on some boards: how it bends the grain, how much of it shows, and its rings."""
    bend, knot, ring = np.zeros(along.shape), np.zeros(along.shape), np.zeros(along.shape)
    for number, (at, off, size) in {0: (150, 30, 4.0), 2: (74, 17, 5.5), 3: (190, 38, 4.5), 4: (120, 12, 3.5)}.items():
        dy, dx = (along - at) / 2.1, across - off
        d = np.sqrt(dy * dy + dx * dx)
        mine = board == number
        reach = size * 3.2
        bend = bend + np.where(mine, 2.4 * size / 4.0 * reach * dx / (dx * dx + dy * dy + reach * size) * 0.55, 0.0)
        knot = np.maximum(knot, np.where(mine, 1.0 - smooth((d - size * 0.75) / (size * 0.5)), 0.0))
        phase = d / 1.7
        phase = phase - np.floor(phase)
        ring = np.where(mine & (d < size * 1.6), 4.0 * phase * (1.0 - phase), ring)
    return bend, knot, ring


def _nail(lit: F, dy: F | I, dx: F) -> F:
    d = np.sqrt(dy * dy + dx * dx + 0.0)
    head = np.clip(2.6 - d, 0.0, 1.0)[..., None]
    halo = (1.0 - 0.35 * np.clip(1.0 - (d - 2.0) / 3.0, 0.0, 1.0))[..., None]
    steel = 62.0 - 9.0 * (dx + dy)
    return lit * halo * (1 - head) + np.stack([steel, steel * 0.97, steel * 0.95], axis=2) * head


def _painted(lit: F) -> Pixels:
    return np.floor(np.clip(lit, 0.0, 255.0) + 0.5).astype(np.uint8)


SURFACES: dict[str, Callable[[], Pixels]] = {"tiles": tiles, "pebbles": pebbles, "stones": stones, "planks": planks}


def painted() -> dict[str, Pixels]:
    """Paint all of them, by the names of their files without ending."""
    return {n: paint() for n, paint in SURFACES.items()} | {f"setts_{n}": pixels for n, pixels in setts().items()}


def write(folder: Path) -> None:
    """Write them as PNG, which is read without OpenImageIO: to import it takes 0.1 s of every command."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, pixels in painted().items():
        Image.fromarray(pixels).save(folder / f"{name}.png", optimize=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--out", type=Path, default=FOLDER)
    write(parser.parse_args().out)
