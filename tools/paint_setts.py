"""The built-in material: granite setts in mossy joints, as four maps of one surface that wrap around.

Nothing in its colours is lit: light comes from the maps beside it.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import relief
from numpy.typing import NDArray
from relief import F, I, box_blur, hash_of, hashed_share, picked, smooth

SIDE = 512  # room for a hundred stones, so that few are seen to return in what grows from them

DEEP = 16.0
"""Px from the lowest joint to the highest stone: what white of the height stands for."""

COURSE = 51.2  # px, a tenth of the side

cloud = partial(relief.cloud, side=SIDE)


def painted() -> dict[str, NDArray[np.generic]]:
    """Paint albedo, normal (OpenGL), roughness and height (16 bits)."""
    y, x = relief.grid(SIDE)
    wy = y + 0.5 + 3.0 * (cloud(32, 301, 3) - 0.5)
    wx = x + 0.5 + 6.0 * (cloud(32, 302, 3) - 0.5)
    inside, number, u, v = relief.laid(wy % SIDE, wx % SIDE, (10,) * 10, (36.0, 32.0), 3.6, 9.0, 320, SIDE)
    inside = inside + 2.2 * (cloud(8, 303, 2) - 0.5)
    shift = hash_of(number, 1, 304) % SIDE
    rough = cloud(32, 305, 5)[(y + shift) % SIDE, (x + 3 * shift) % SIDE]
    fine, grain = cloud(4, 306, 2), cloud(2, 307, 2)
    moss = 0.3 + 0.35 * smooth(-inside / 3.0) + 0.9 * (cloud(4, 308, 2) - 0.5)  # too fine for a cut to be seen
    moss = np.clip(moss, 0.0, 1.0)
    stone = np.clip(inside * 0.7 + 0.5, 0.0, 1.0)
    height = _height(inside, number, u, v, rough, fine, moss, stone)
    return {
        "albedo": _bytes(_albedo(inside, number, rough, fine, grain, moss, stone)),
        "normal": _normals(height),
        "roughness": _bytes(255.0 * _roughness(inside, number, rough, fine, moss, stone)),
        "height": np.floor(np.clip(height / DEEP, 0.0, 1.0) * 65535.0 + 0.5).astype(np.uint16),
    }


def _height(inside: F, number: I, u: F, v: F, rough: F, fine: F, moss: F, stone: F) -> F:
    """Px above the lowest joint."""
    lean = (hashed_share(number, 330) - 0.5) * u + (hashed_share(number, 331) - 0.5) * v
    crown = box_blur(smooth(inside / 17.0), 4)  # no ridges where the distances to two borders meet
    top = 4.5 + 6.5 * crown + 2.0 * hashed_share(number, 332) + 2.4 * lean
    top = top + 4.0 * (rough - 0.5) + 0.5 * (fine - 0.5)
    joint = 1.0 + 1.8 * cloud(4, 333, 2) + moss * (2.2 * cloud(3, 334, 2) + 1.0)
    return box_blur(top * stone + joint * (1.0 - stone), 1)


def _albedo(inside: F, number: I, rough: F, fine: F, grain: F, moss: F, stone: F) -> F:
    palette = [
        (136, 134, 132), (124, 125, 128), (146, 141, 135), (130, 123, 118), (116, 118, 122), (150, 145, 141),
        (138, 127, 118), (120, 121, 119),
    ]  # fmt: skip
    granite = picked(palette, hash_of(number, 2, 340)) * (0.89 + 0.14 * hashed_share(number, 341))[..., None]
    granite = granite * (0.86 + 0.5 * (rough - 0.5) + 0.4 * (grain - 0.5) + 0.14 * fine)[..., None]
    worn = smooth(inside / 12.0)
    granite = granite * (0.82 + 0.2 * worn)[..., None]
    earth = np.array([62.0, 54.0, 42.0]) * (0.7 + 0.4 * cloud(4, 342, 2))[..., None]
    green = np.array([66.0, 78.0, 34.0]) * (0.65 + 0.6 * cloud(3, 334, 2))[..., None]
    joint = earth * (1.0 - moss)[..., None] + green * moss[..., None]
    creeping = (moss * smooth(1.0 - inside / 4.0) * 0.5)[..., None]  # over the rims of stones
    granite = granite * (1.0 - creeping) + green * creeping
    return granite * stone[..., None] + joint * (1.0 - stone)[..., None]


def _roughness(inside: F, number: I, rough: F, fine: F, moss: F, stone: F) -> F:
    """From 0, a mirror, to 1: the crowns of stones are polished by feet."""
    worn = box_blur(smooth(inside / 15.0), 4) * (0.45 + 0.55 * hashed_share(number, 350))
    granite = 0.74 - 0.42 * worn + 0.3 * (rough - 0.5) + 0.1 * (fine - 0.5)
    joint = 0.86 + 0.12 * moss
    return np.clip(granite * stone + joint * (1.0 - stone), 0.05, 1.0)


def _normals(height: F) -> NDArray[np.uint8]:
    """Vectors of unit length, x to the right and y up the picture, as (n + 1) / 2 of 8 bits."""
    gx = 0.5 * (np.roll(height, -1, 1) - np.roll(height, 1, 1))
    gy = 0.5 * (np.roll(height, -1, 0) - np.roll(height, 1, 0))
    norm = np.sqrt(gx * gx + gy * gy + 1.0)
    return _bytes(127.5 * (np.stack([-gx / norm, gy / norm, 1.0 / norm], axis=2) + 1.0))


def _bytes(values: F) -> NDArray[np.uint8]:
    return np.floor(np.clip(values, 0.0, 255.0) + 0.5).astype(np.uint8)
