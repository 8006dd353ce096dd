"""Kernels of guides: pixels of a coordinate map that do not match their target move to random pixels that do."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..foundation.arrays import Int16, Int32, Int64, UInt8
from ..kernels.jit import kernel
from ..kernels.random_numbers import STEP, below, mixed
from .correction_kernels import nearest_lattice_vector


class GuideOrder(NamedTuple):
    """Exemplar pixels of one level, grouped by their quantised guide values."""

    shown: Int16  # (H * W, G): the guide of the exemplar
    may: UInt8  # (H, W): 1 for candidates
    places: Int32  # candidates y * W + x, group after group
    begins: Int64  # (groups + 1,): index in `places` at which each group begins, and the end
    means: Int16  # (groups, G): mean guide of each group


@kernel
def guide_difference(shown: Any, u: Any, target: Any, p: Any) -> Any:
    """Return the squared difference between the guide of an exemplar pixel and the target of an output pixel."""
    total = np.int64(0)
    for c in range(target.shape[1]):
        d = np.int64(shown[u, c]) - np.int64(target[p, c])
        total += d * d
    return total


@kernel
def group_of(choice: Any, target: Any, p: Any) -> int:
    """Return the group whose mean is nearest to the target, ties to the first."""
    best, found = np.int64(1) << 62, 0
    for n in range(len(choice.means)):
        total = guide_difference(choice.means, n, target, p)
        if total < best:
            best, found = total, n
    return found


@kernel
def offered(coords: Any, i: int, j: int, h: Any, choice: Any, target: Any, torus: bool, enough: Any) -> bool:
    """Return whether the continuation of one of the eight neighbours matches the target."""
    height, width = choice.may.shape
    p = i * coords.shape[1] + j
    for dy in range(-1, 2):
        for dx in range(-1, 2):
            if 0 <= i + dy < coords.shape[0] and 0 <= j + dx < coords.shape[1]:
                y, x = coords[i + dy, j + dx, 0] - h * dy, coords[i + dy, j + dx, 1] - h * dx
                if torus:
                    y, x = y % height, x % width
                inside = 0 <= y < height and 0 <= x < width and choice.may[y, x]
                if inside and guide_difference(choice.shown, y * width + x, target, p) <= enough:
                    return True
    return False


@kernel
def place_anew(
    coords: Any, rows: Any, cols: Any, states: Any, choice: Any, target: Any, rule: Any, lattice: Any
) -> Any:
    """Return a map in which pixels whose guide differs by more than ``rule[0]`` move to the best of random pixels.

    These are drawn from the group whose mean is nearest to the target. ``rows``, ``cols``: absolute coordinates, keys
    of the random numbers; ``states``: one per try, before these are mixed in. ``rule``: the accepted squared
    difference; the spacing h if a pixel stays where the continuation of a neighbour matches, else 0; 1 for a torus. The
    squared difference must fall below half of the old one. With a lattice pixels move by lattice vectors.
    """
    enough, h, torus = rule[0], rule[1], rule[2] > 0
    height, width = choice.may.shape
    out = coords.copy()
    for i in range(coords.shape[0]):
        for j in range(coords.shape[1]):
            y, x, p = np.int64(coords[i, j, 0]), np.int64(coords[i, j, 1]), i * coords.shape[1] + j
            best = guide_difference(choice.shown, y * width + x, target, p)
            if best <= enough or (h and offered(coords, i, j, h, choice, target, torus, enough)):
                continue
            group, best = group_of(choice, target, p), (best + 1) // 2
            first, count = choice.begins[group], choice.begins[group + 1] - choice.begins[group]
            for state in states:
                bits = mixed((mixed((state ^ np.uint64(rows[i])) + STEP) ^ np.uint64(cols[j])) + STEP)
                u = np.int64(choice.places[first + below(count, bits)])
                if len(lattice):
                    dy, dx = nearest_lattice_vector(u // width - y, u % width - x, lattice)
                    if not (0 <= y + dy < height and 0 <= x + dx < width and choice.may[y + dy, x + dx]):
                        continue
                    u = (y + dy) * width + x + dx
                d = guide_difference(choice.shown, u, target, p)
                if d < best:
                    best = d
                    out[i, j, 0], out[i, j, 1] = u // width, u % width
    return out
