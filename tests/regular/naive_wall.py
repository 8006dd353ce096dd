"""Slow and obvious twins of the kernels of courses."""

from __future__ import annotations

import itertools
import math

import numpy as np

FAR = 1 << 60
UNREADABLE, STEP = 1 << 20, 8
FACE = -1


def cheapest_cost(cost: np.ndarray) -> int:
    """The cost of the cheapest path down a field, by trying all of them."""
    n, k = cost.shape
    best = None
    for start in range(k):
        for steps in itertools.product((-1, 0, 1), repeat=n - 1):
            path = np.cumsum((start, *steps))
            if path.min() >= 0 and path.max() < k:
                total = int(cost[np.arange(n), path].sum())
                best = total if best is None else min(best, total)
    return best


def cut_cost(cost: np.ndarray, gap: np.ndarray, path: np.ndarray) -> int:
    """What a cut costs: its own costs, and those of the pixels that it goes along between the lines."""
    total = int(cost[np.arange(len(path)), path].sum())
    for t in range(1, len(path)):
        low, high = sorted((path[t - 1], path[t]))
        total += int(gap[t - 1, low:high].sum() + gap[t, low:high].sum())
    return total


def least_cut_cost(cost: np.ndarray, gap: np.ndarray) -> int:
    """The cost of the least cut, by trying all of them."""
    paths = itertools.product(range(cost.shape[1]), repeat=cost.shape[0])
    return min(cut_cost(cost, gap, np.array(path)) for path in paths)


def chain_cost(chain, length, sizes, start, joint, pair, closing, rules) -> int:
    """What a chain of elements (with or without a cut last one) costs; FAR where it does not fit."""
    _, slack, least, cut, again, _ = rules
    elements, is_cut = chain
    total, u = 0, 0
    for n, m in enumerate(elements):
        if n and u >= length:
            return FAR
        total += int(start[m, u])
        if n:
            total += int(pair[elements[n - 1], m] + joint[u])
        if n > 1 and elements[n - 2] == m:
            total += again
        rest = length - u
        if is_cut and n == len(elements) - 1:
            if not (n and 0 < rest < sizes[m]):
                return FAR
            return total + int(closing[m]) + cut + 3000 * max(0, least - rest) // least
        u += int(sizes[m])
        if u > length + slack:
            return FAR
    if is_cut or abs(length - u) > slack:
        return FAR
    return total + int(closing[elements[-1]]) + 8 * abs(length - u)


def best_chain_cost(length, sizes, start, joint, pair, closing, rules) -> int:
    """The cost of the best chain, by trying all."""
    most = (length + rules[1]) // int(min(sizes)) + 1
    best = FAR
    for n in range(1, most + 1):
        for rest in itertools.product(range(len(sizes)), repeat=n - 1):
            for is_cut in (False, True):
                chain = ((int(rules[0]), *rest), is_cut)
                best = min(best, chain_cost(chain, length, sizes, start, joint, pair, closing, rules))
    return best


def apart(picture, a, b, y, x) -> int:
    h, w = picture.shape[:2]
    one = picture[min(max(a, 0), h - 1), min(max(b, 0), w - 1)].astype(np.int64)
    two = picture[min(max(y, 0), h - 1), min(max(x, 0), w - 1)].astype(np.int64)
    return math.isqrt(int(((one - two) ** 2).sum()))


def astray(scene, piece, y, x, side) -> int:
    _, usable, faces, _, joints, halves = scene
    if not (0 <= y < usable.shape[0] and 0 <= x < usable.shape[1] and usable[y, x]):
        return UNREADABLE
    kind, end = piece[5 + side], piece[7 + side]
    limit = (end + halves[0] if side == 0 else end - halves[1]) if kind == FACE else joints[kind, y]
    return int(faces[y, x]) + STEP if (x < limit) == (side == 0) else 0


def junction_costs(scene, left, right, first, rows, reach):
    """What every cut between two pieces costs in every row, and what changing sides costs at every pixel."""
    u = right[0]
    cost = np.zeros((rows, 2 * reach + 1), np.int64)
    gap = np.zeros((rows, 2 * reach), np.int64)
    for r in range(rows):
        y = first + r

        def differ(x, y=y):
            return apart(scene[0], y + left[3], x + left[2], y + right[3], x + right[2])

        for k in range(2 * reach + 1):
            cut = u - reach + k
            shown_left = sum(astray(scene, left, y + left[3], x + left[2], 1) for x in range(u - reach, cut))
            shown_right = sum(
                astray(scene, right, y + right[3], x + right[2], 0) for x in range(cut, u + reach)
            )
            cost[r, k] = differ(cut - 1) + differ(cut) + shown_left + shown_right
        for k in range(2 * reach):
            gap[r, k] = differ(u - reach + k)
    return cost, gap


def part(scene, upper, lower, shift, reach):
    band, wide = 2 * reach + 1, len(shift)
    cost, gaps = np.zeros((wide, band + 1), np.int64), np.zeros((wide, band), np.int64)
    for x in range(wide):
        for k in range(band):
            gaps[x, k] = apart(scene[0], *upper[0][shift[x] + k, x], *lower[0][k, x])
        for k in range(band + 1):
            shown = sum(int(upper[1][shift[x] + j, x]) for j in range(k))
            shown += sum(int(lower[1][j, x]) for j in range(k, band))
            cost[x, k] = shown + gaps[x, max(k - 1, 0)] + gaps[x, min(k, band - 1)]
    return cost, gaps


def stones_about(own: list[int], height: int, rule, like: float) -> list[int]:
    """The stones about as high as a course; where they are few, those next in height that are not too far off."""
    beyond = [max(abs(high - height) - int(rule.near * height), 0) for high in own]
    ranked = sorted(range(len(own)), key=lambda k: (beyond[k], k))
    near = sum(abs(high - height) <= like * height for high in own)
    return sorted(ranked[: max(beyond.count(0), min(rule.fewest, near), 1)])
