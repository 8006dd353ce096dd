"""Slow, obvious versions of what `recut_kernels` and `placement_kernels` of `seams` compute, to compare them with."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from analysis.naive_masking import visibility
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_flow

from intarsia.analysis.features import features
from intarsia.kernels.cuts import SeamPrice
from intarsia.model import Exemplar
from intarsia.model.sourcemap import SourceMap
from intarsia.seams.placement_kernels import Look

Source = tuple[int, int, int]  # variant, row, column
Sources = dict[tuple[int, int], Source]


@dataclass
class NaiveMap:
    """A map as a dictionary, over pictures of features that may be masked or toroidal."""

    pictures: list[NDArray[np.int16]]
    usable: list[NDArray[np.bool_]]
    toroidal: list[bool]
    size: tuple[int, int]
    wraps: tuple[bool, bool]
    gradient: bool = False
    threshold: int = 0
    visible: list[NDArray[np.int16]] | None = None  # how much differences count, in 1/128; none: as what they are

    def grown(self, v: int, y: int, x: int) -> Source | None:
        """The pixel of a variant, if there is one that may be shown."""
        h, w = self.usable[v].shape
        if self.toroidal[v]:
            y, x = y % h, x % w
        return (v, y, x) if 0 <= y < h and 0 <= x < w and self.usable[v][y, x] else None

    def on(self, source: Source, dy: int, dx: int) -> Source:
        """What a piece shows one step further; its own pixel where it does not go on."""
        v, y, x = source
        return self.grown(v, y + dy, x + dx) or source

    def far(self, a: Source, b: Source) -> int:
        """Distance of two pixels, rounded up."""
        p, q = (self.pictures[v][y, x].astype(int) for v, y, x in (a, b))
        total = int(((p - q) ** 2).sum())
        return math.isqrt(total) + (math.isqrt(total) ** 2 < total)

    def apart(self, a: Source, b: Source) -> int:
        """The same, as far as it is seen at both."""
        if self.visible is None:
            return self.far(a, b)
        return self.far(a, b) * sum(int(self.visible[v][y, x]) for v, y, x in (a, b)) // 256

    def pair(self, a: Source, b: Source, dy: int, dx: int) -> int:
        """What the seam between two neighbours costs, of which the second lies (dy, dx) further."""
        over, back = self.on(a, dy, dx), self.on(b, -dy, -dx)
        if over == b:
            return 0
        cost = self.apart(a, back) + self.apart(over, b)
        if self.threshold:
            return 4 * cost if cost >= 4 * self.threshold else cost * cost // self.threshold
        return cost * 256 // (16 + self.far(a, over) + self.far(back, b)) if self.gradient else cost

    def neighbours(self) -> Iterator[tuple[tuple[int, int], tuple[int, int], int, int]]:
        """All pairs of neighbouring places, over wrapped borders, too."""
        for y, x, (dy, dx) in product(range(self.size[0]), range(self.size[1]), ((0, 1), (1, 0))):
            there = [y + dy, x + dx]
            for axis in (0, 1):
                if self.wraps[axis]:
                    there[axis] %= self.size[axis]
            if there[0] < self.size[0] and there[1] < self.size[1]:
                yield (y, x), (there[0], there[1]), dy, dx

    def total(self, sources: Sources) -> int:
        """What all seams of a map cost."""
        return sum(self.pair(sources[p], sources[q], dy, dx)
                   for p, q, dy, dx in self.neighbours() if p in sources and q in sources)  # fmt: skip


def naive_total(exemplars: Sequence[Exemplar], smap: SourceMap, price: SeamPrice) -> int:
    """What all seams of an upright map cost, pair by pair."""
    pictures, known = features(exemplars).pictures, price.threshold
    seen = [visibility(p, known, e.usable, e.toroidal) for p, e in zip(pictures, exemplars, strict=True) if known]
    naive = NaiveMap(
        list(pictures), [e.free for e in exemplars], [e.toroidal for e in exemplars], (smap.height, smap.width),
        (smap.wrap.y, smap.wrap.x), price.gradient, known, seen or None,
    )  # fmt: skip
    at = np.argwhere(~smap.holes).tolist()
    return naive.total({(y, x): (int(smap.numbers[y, x]), *smap.yx[y, x].tolist()) for y, x in at})


def scipy_energy(state: NDArray[np.uint8], terms: NDArray[np.int32]) -> int:
    """The least energy by scipy's maximum flow through the graph of the paper: a node for every old seam."""
    h, w = state.shape
    node = np.arange(h * w).reshape(h, w) + 2
    node[state == 0], node[state == 2] = 0, 1
    arcs: dict[tuple[int, int], int] = {}
    size = h * w + 2

    def add(p: int, q: int, cost: int) -> None:
        if p != q and cost:
            arcs[p, q] = arcs.get((p, q), 0) + cost

    for i, j, k in product(range(h), range(w), (0, 1)):
        m, n = i + k, j + 1 - k
        if m >= h or n >= w or 3 in (state[i, j], state[m, n]):
            continue
        p, q, (a, b, c) = int(node[i, j]), int(node[m, n]), terms[i, j, k].tolist()
        if not a:
            add(p, q, b)
            add(q, p, c)
            continue
        for one, other, cost in ((p, size, b), (size, q, c)):
            add(one, other, cost)
            add(other, one, cost)
        add(size, 1, a)
        size += 1
    if not arcs or not (state == 0).any():
        return 0
    rows, columns = zip(*arcs, strict=True)
    graph = csr_matrix((list(arcs.values()), (rows, columns)), shape=(size, size), dtype=np.int32)
    return int(maximum_flow(graph, 0, 1).flow_value)


def energy(mask: NDArray[np.uint8], state: NDArray[np.uint8], terms: NDArray[np.int32]) -> int:
    """What a choice of old and new costs."""
    total = 0
    for i, j, k in product(range(state.shape[0]), range(state.shape[1]), (0, 1)):
        m, n = i + k, j + 1 - k
        if m < state.shape[0] and n < state.shape[1] and 3 not in (state[i, j], state[m, n]):
            a, b, c = terms[i, j, k].tolist()
            total += {(0, 0): a, (0, 1): b, (1, 0): c, (1, 1): 0}[int(mask[i, j]), int(mask[m, n])]
    return total


def exhaustive_energy(state: NDArray[np.uint8], terms: NDArray[np.int32], saved: NDArray[np.int32]) -> int:
    """The least energy of all choices, where pixels that stay cost so much besides."""
    free = np.argwhere(state == 1)
    best = None
    for bits in product((0, 1), repeat=len(free)):
        mask = (state == 2).astype(np.uint8)
        mask[tuple(free.T)] = bits
        cost = energy(mask, state, terms) + int(saved[mask == 0].sum())
        best = cost if best is None else min(best, cost)
    return best


def naive_repeats(
    naive: NaiveMap, sources: Sources, box: tuple[int, int, int, int], row: Source, look: Look, once: int
) -> int:
    """How much more what a candidate shows counts for lying near, 256 = all of it once; `once` less what goes on."""
    y0, x0, h, w = box
    reach, total, step = 3 * max(h, w) // 2 + 1, 0, look.step
    rows = [(look.y + a) % naive.size[0] for a in range(step // 2, look.rows, step)]
    columns = [(look.x + b) % naive.size[1] for b in range(step // 2, look.columns, step)]
    for (y, x), (v, i, j) in sources.items():
        if y not in rows or x not in columns or v != row[0]:
            continue
        gap = []
        for axis, (at, middle) in enumerate(((y, y0 + h // 2), (x, x0 + w // 2))):
            n = naive.size[axis]
            gap.append((at - middle + n // 2) % n - n // 2 if naive.wraps[axis] else at - middle)
        di, dj = i - row[1], j - row[2]
        if naive.toroidal[v]:
            di, dj = di % naive.usable[v].shape[0], dj % naive.usable[v].shape[1]
        goes_on = (di, dj) == (gap[0] + h // 2, gap[1] + w // 2)
        if 0 <= di < h and 0 <= dj < w:
            far = max(map(abs, gap))
            total += -once if goes_on else 768 * (reach - far) // reach if far < reach else 0
    return total * step * step // (h * w)
