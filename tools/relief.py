"""Noise, relief and light for painted surfaces, in steps that IEEE 754 rounds alike on every machine.

Only + - * / and square roots of single numbers are used. All fields wrap around, and are SIDE x SIDE px
unless another side is given.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

SIDE = 256
F = NDArray[np.float64]
I = NDArray[np.int64]  # noqa: E741 - beside F
LIGHT = (-0.48, -0.62, 0.62)
"""Where the light comes from: x to the right, y down, z to the eye."""


def grid(side: int = SIDE) -> tuple[I, I]:
    y, x = np.mgrid[:side, :side]
    return y.astype(np.int64), x.astype(np.int64)


def hash_of(a: I, b: int, seed: int) -> I:
    """Mix two numbers and a seed to 32 bits."""
    z = np.atleast_1d(a).astype(np.uint32) * np.uint32(0x9E3779B1)
    z = z + np.uint32((b * 0x85EBCA77 + seed * 0xC2B2AE3D) & 0xFFFFFFFF)
    for shift, factor in ((16, 0x7FEB352D), (15, 0x846CA68B)):
        z = (z ^ (z >> np.uint32(shift))) * np.uint32(factor)
    return (z ^ (z >> np.uint32(16))).astype(np.int64).reshape(np.shape(a))


def hashed_share(a: I, seed: int) -> F:
    return hash_of(a, 0, seed) / 4294967296.0


def picked(palette: Sequence[tuple[int, int, int]], which: I) -> F:
    return np.array(palette, np.float64)[which % len(palette)]


def smooth(t: NDArray[np.floating[Any]]) -> F:
    """Ease from 0 to 1."""
    u: F = np.clip(t, 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)


def lattice(tall: int, wide: int, seed: int, side: int = SIDE) -> F:
    """Value noise that wraps, with cells of tall x wide px, in 0..1."""
    ny, nx = max(1, side // tall), max(1, side // wide)
    knots = hashed_share(np.arange(ny * nx), seed).reshape(ny, nx)
    p, q = np.arange(side) * (ny / side), np.arange(side) * (nx / side)
    i, j = p.astype(np.int64), q.astype(np.int64)
    f, g = smooth(p - i)[:, None], smooth(q - j)[None, :]
    rows = knots[i % ny] * (1 - f) + knots[(i + 1) % ny] * f
    return rows[:, j % nx] * (1 - g) + rows[:, (j + 1) % nx] * g


def stretched(wide: int, tall: int, seed: int) -> F:
    """Noise drawn out along y, of two octaves."""
    return 0.65 * lattice(tall, wide, seed) + 0.35 * lattice(max(1, tall // 2), max(1, wide // 2), seed + 1000)


def cloud(cell: int, seed: int, octaves: int, side: int = SIDE) -> F:
    """Noise of several octaves, each half as large and half as strong."""
    total, weight, norm = np.zeros((side, side)), 1.0, 0.0
    for octave in range(octaves):
        total = total + weight * lattice(max(1, cell >> octave), max(1, cell >> octave), seed + 100 * octave, side)
        norm, weight = norm + weight, weight * 0.55
    return total / norm


def rounded_box(u: F, v: F, wide: F | float, tall: F | float, radius: float) -> F:
    """Distance to the edge of a box with round corners, positive inside."""
    p, q = np.abs(u) - wide + radius, np.abs(v) - tall + radius
    a, b = np.maximum(p, 0.0), np.maximum(q, 0.0)
    distance: F = radius - np.sqrt(a * a + b * b) - np.minimum(np.maximum(p, q), 0.0)
    return distance


def laid(
    y: F, x: F, counts: Sequence[int], widths: tuple[float, float], gap: float, radius: float, seed: int,
    side: int = SIDE,
) -> tuple[F, I, F, F]:
    """Lay rows of stones: px inside of an edge, a number, and the place in a stone, -1 to 1, across and down.

    As many in each row as is said; their widths, the least and how much more is drawn, are stretched to fill it.
    Stones end ``gap`` px before the middle of joints, with corners of a radius.
    """
    tall = side / len(counts)
    row = np.minimum((y / tall).astype(np.int64), len(counts) - 1)
    inside, number = np.zeros(y.shape), np.zeros(y.shape, np.int64)
    across, down = np.zeros(y.shape), np.zeros(y.shape)
    for r, count in enumerate(counts):
        ends = np.concatenate([[0.0], np.cumsum(widths[0] + widths[1] * hashed_share(np.arange(count), seed + r))])
        ends = ends * (side / ends[-1])
        local = (x + 97.0 * r + 11.0) % side
        stone = np.clip(np.searchsorted(ends, local, side="right") - 1, 0, count - 1)
        u, v = local - (ends[stone] + ends[stone + 1]) / 2, y - (r + 0.5) * tall
        wide, high = (ends[stone + 1] - ends[stone]) / 2 - gap, tall / 2 - gap
        mine = row == r
        inside = np.where(mine, rounded_box(u, v, wide, high, radius), inside)
        number = np.where(mine, r * 16 + stone, number)
        across, down = np.where(mine, u / wide, across), np.where(mine, v / high, down)
    return inside, number, across, down


def light(height: F, strength: float) -> tuple[F, F]:
    """Light a relief from the upper left: shade (1 is flat), and gloss."""
    gx = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) * (0.5 * strength)
    gy = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) * (0.5 * strength)
    norm = np.sqrt(gx * gx + gy * gy + 1.0)
    facing = np.clip((-gx * LIGHT[0] - gy * LIGHT[1] + LIGHT[2]) / norm, 0.0, 1.0)
    gloss = np.clip((-gx * -0.36 - gy * -0.46 + 0.81) / norm, 0.0, 1.0)
    for _ in range(5):
        gloss = gloss * gloss
    return 0.45 + 0.55 / LIGHT[2] * facing, gloss * 0.6


def box_blur(a: F, radius: int) -> F:
    """A box, twice, along both axes, with wrap."""
    for axis in (0, 1, 0, 1):
        total = a.copy()
        for k in range(1, radius + 1):
            total = total + np.roll(a, k, axis) + np.roll(a, -k, axis)
        a = total / (2 * radius + 1)
    return a


def shadow(height: F) -> F:
    """Shade what lies behind something higher, as seen from the light."""
    worst = np.zeros(height.shape)
    for k in range(1, 9):
        above = np.roll(height, (k, (k * 3) // 4), (0, 1)) - 0.95 * k - height
        worst = np.maximum(worst, above)
    return 1.0 - 0.5 * smooth(worst / 3.0)
