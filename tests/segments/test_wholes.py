"""The tree of basins is that of a slow reading, pixel by pixel."""

from __future__ import annotations

import math

import numpy as np
import pytest

from intarsia.segments.basins_kernels import HUE, choose
from intarsia.segments.wholes import SHAPE, Tree, tree_of


def lowest(low: np.ndarray, y: int, x: int) -> tuple[int, int]:
    """Where a pixel flows to in the end."""
    h, w = low.shape
    while True:
        near = [(b, a) for b in (y - 1, y, y + 1) for a in (x - 1, x, x + 1) if 0 <= b < h and 0 <= a < w]
        best = min(near, key=lambda p: (low[p], p))
        if low[best] == low[y, x] and best >= (y, x):
            return y, x
        y, x = best


def naive(labels: np.ndarray, relief: np.ndarray, soft: np.ndarray, size: float) -> list[tuple[set[int], set[int]]]:
    """Merge basins, every border told anew from the pixels: the basins of both parts of every merge."""
    h, w = labels.shape
    spread, unit = math.sqrt(sum(float(c.var()) for c in np.moveaxis(soft.astype(float), 2, 0))), (0.3 * size) ** 2
    groups = [{k} for k in range(int(labels.max()) + 1)]
    merges = []
    while len(groups) > 1:
        of = {k: n for n, group in enumerate(groups) for k in group}
        names = np.vectorize(of.get)(labels)
        borders: dict[tuple[int, int], list[int]] = {}
        for y in range(h):
            for x in range(w):
                for b, a in ((y, x + 1), (y + 1, x)):
                    if b < h and a < w and names[y, x] != names[b, a]:
                        pair = min(names[y, x], names[b, a]), max(names[y, x], names[b, a])
                        borders.setdefault(pair, []).append(max(relief[y, x], relief[b, a]))
        area = np.bincount(names.ravel())
        mean = np.stack([np.bincount(names.ravel(), soft[..., c].ravel()) / area for c in range(soft.shape[2])], 1)
        prices = {}
        for (a, b), border in borders.items():
            far, least = float(np.linalg.norm(mean[a] - mean[b])) / spread, min(area[a], area[b])
            prices[a, b] = (sum(border) / len(border) + HUE * min(far, 2)) * math.sqrt(least / (least + unit))
        one, two = min(prices, key=lambda pair: prices[pair])
        merges.append((groups[one], groups[two]))
        groups = [g for k, g in enumerate(groups) if k not in (one, two)] + [groups[one] | groups[two]]
    return merges


def parts(tree: Tree) -> list[set[int]]:
    """The basins of every node."""
    out: list[set[int]] = []
    for k, (a, b) in enumerate(tree.kids.tolist()):
        out.append({k} if a < 0 else out[a] | out[b])
    return out


@pytest.mark.parametrize("seed", range(3))
def test_the_tree_is_that_of_a_slow_reading(seed: int) -> None:
    draws = np.random.default_rng(seed)
    relief, soft = draws.integers(0, 330, (17, 15)), draws.integers(-400, 400, (17, 15, 2)).astype(np.int32)
    tree = tree_of(relief, soft, 20.0)
    low = np.empty((17, 15), np.int64)
    padded = np.pad(relief * 16, 1, "edge")
    rows = (padded[:-2] + 2 * padded[1:-1] + padded[2:] + 2) >> 2
    low[:] = (rows[:, :-2] + 2 * rows[:, 1:-1] + rows[:, 2:] + 2) >> 2
    ends = {lowest(low, y, x): int(tree.labels[y, x]) for y in range(17) for x in range(15)}
    assert len(set(ends.values())) == len(ends) == int(tree.labels.max()) + 1
    assert all(tree.labels[y, x] == ends[lowest(low, y, x)] for y in range(17) for x in range(15))
    nodes, n = parts(tree), len(ends)
    slow = naive(tree.labels, relief, soft, 20.0)
    assert [sorted(map(sorted, (nodes[a], nodes[b]))) for a, b in tree.kids[n:].tolist()] == [
        sorted(map(sorted, pair)) for pair in slow
    ]
    for k, group in enumerate(nodes):  # sums and outlines are those of the pixels
        mine = np.isin(tree.labels, list(group))
        y, x = np.nonzero(mine)
        rim = (y == 0).astype(int) + (y == 16) + (x == 0) + (x == 14)
        assert tree.facts[k].tolist() == [
            len(y), y.sum(), x.sum(), (y * y).sum(), (x * x).sum(), (x * y).sum(), rim.sum()
        ]  # fmt: skip
        steps = [np.maximum(a, b)[p != q] for a, b, p, q in (
            (relief[1:], relief[:-1], mine[1:], mine[:-1]),
            (relief[:, 1:], relief[:, :-1], mine[:, 1:], mine[:, :-1]),
        )]  # fmt: skip
        values = np.concatenate(steps)
        assert tree.outline[k].tolist() == [values.sum(), len(values), (values > round(SHAPE.strong * 256)).sum()]


@pytest.mark.parametrize("seed", range(4))
def test_the_best_set_of_nodes_is_chosen(seed: int) -> None:
    """Of all sets of nodes of a small tree that share no pixel none has more score by area."""
    rng = np.random.default_rng(seed)
    n, leaves = 6, list(range(6))
    kids, pixels = np.full((2 * n - 1, 2), -1, np.int64), [{k} for k in range(n)]
    area = np.concatenate([rng.integers(1, 9, n), np.zeros(n - 1, np.int64)])
    for k in range(n, 2 * n - 1):
        kids[k] = [leaves.pop(int(rng.integers(len(leaves)))) for _ in range(2)]
        leaves.append(k)
        pixels.append(pixels[kids[k, 0]] | pixels[kids[k, 1]])
        area[k] = area[kids[k]].sum()
    score = np.where(rng.random(2 * n - 1) < 0.3, 0.0, rng.random(2 * n - 1))
    name, scores = np.empty(2 * n - 1, np.int64), np.empty(2 * n)
    total, count = choose(kids, area, score, 0.2, name, scores)

    def best(nodes: list[int]) -> float:
        if not nodes:
            return 0.0
        first, *others = nodes
        apart = [k for k in others if not pixels[k] & pixels[first]]
        return max(best(others), area[first] * score[first] + best(apart))

    assert total == pytest.approx(best(list(range(2 * n - 1))))
    tops = [k for k in range(2 * n - 1) if name[k] > 0 and score[k] == scores[name[k]]]
    assert len(tops) == count - 1 == len(set(name[name > 0].tolist()))
    assert all(score[k] > 0.2 and all(name[leaf] == name[k] for leaf in pixels[k]) for k in tops)
