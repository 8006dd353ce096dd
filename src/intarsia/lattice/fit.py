"""How good a guessed lattice is, and where exactly its vectors end.

The score asks four questions: does the texture agree with itself at the lattice points; does it agree less
anywhere else in the cell; do enough points say so; and do peaks lie where the points are. The last one also
gives the vectors to a fraction of a px.

Source: Lopez Recas 2011, eq. 3.22 (mean at the lattice points). Departures: contrast with the rest of the
cell, the penalty for few points, sub-pixel vectors by least squares over all peaks.

Large exemplars: the lattice is searched in a reduced copy, then made exact at full resolution.

At full resolution only a few lattice points are looked at: the exemplar, moved by about that vector, is
compared with itself in whole numbers, a few px to every side. Where it differs least lies the exact vector.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..foundation.arrays import Floats, Int16, Int32, Int64, Mask, Pair
from ..foundation.filters import blurred
from ..foundation.geometry import UNIT
from .candidates import CorrelationMap, canonical, distinct
from .scoring_kernels import NOTHING, best_shift, fit_step, means

WINDOW = 512  # px: side of what is compared; as much as a search sees that reduces nothing
POINTS = 12  # lattice points looked at: two of each direction
ANGLES = 6  # directions of a half circle, 30 degrees each, over which they are spread
FARTHEST = 0.5  # of each side: the other half is left to compare
SPARE = 2  # px besides those that one px of the reduced copy stands for: the peak may lie beside its px
SPANNED = 0.5  # the determinant of whole numbers is 0 where all points lie in a row, 1 or more else


def refined(features: Int16, usable: Mask | None, vectors: Int64, factor: int) -> Int64 | None:
    """Make the vectors (1/256 px) exact at full resolution; None where the exemplar does not allow it.

    Weighted least squares over the points that lie furthest out: their error is shared by many cells.
    """
    height, width = features.shape[:2]
    mask = np.ones((1, 1), np.bool_) if usable is None else usable
    rows, right = [], []
    found = np.empty(2)
    radius = factor + SPARE
    for index in _furthest(vectors, height, width):
        at = (np.array(index) @ vectors) / UNIT
        if best_shift(features, mask, np.rint(at).astype(np.int64), radius, WINDOW, found):
            rows.append(index)
            right.append((float(found[0]), float(found[1])))
    return _least_squares(rows, right, vectors, factor)


def _furthest(vectors: Int64, height: int, width: int) -> list[tuple[int, ...]]:
    """Lattice points that leave half of each side to compare, the furthest first, spread over directions."""
    n = len(vectors)
    most = [max(1, int(FARTHEST * max(height, width) * UNIT / math.hypot(*v))) for v in vectors]
    found = []
    for a in range(most[0] + 1):
        for b in range(-most[1], most[1] + 1) if n == 2 else (0,):
            index = (a, b)[:n]
            if index <= (0, 0)[:n]:
                continue
            y, x = (np.array(index) @ vectors) / UNIT
            if abs(y) <= FARTHEST * height and abs(x) <= FARTHEST * width:
                angle = math.floor(ANGLES * (math.atan2(y, x) % math.pi) / math.pi)
                found.append((round(math.hypot(y, x)), angle, index))
    found.sort(key=lambda f: (-f[0], f[2]))
    seen: dict[int, int] = {}
    ranked = []
    for far, angle, index in found:
        seen[angle] = seen.get(angle, 0) + 1
        ranked.append((seen[angle], -far, index))
    return [index for _, _, index in sorted(ranked)[:POINTS]]


def _least_squares(
    rows: list[tuple[int, ...]], right: list[tuple[float, float]], vectors: Int64, factor: int
) -> Int64 | None:
    if not rows:
        return None
    a, p = np.array(rows, np.float64), np.array(right)
    n = len(vectors)
    if n == 1:
        across = vectors[0] / math.hypot(*vectors[0])
        exact = ((a[:, 0] * (p @ across)).sum() / (a[:, 0] ** 2).sum()) * across[None]
    else:
        (aa, ab), (_, bb) = a.T @ a  # whole numbers
        t0, t1 = (a[:, :, None] * p[:, None]).sum(axis=0)
        exact = _spanned(aa, ab, bb, t0, t1, SPANNED)
        if exact is None:
            return None
    whole: Int64 = np.rint(UNIT * exact).astype(np.int64)
    if np.abs(whole - vectors).max() > UNIT * factor:
        return None
    if n == 2:
        whole = canonical(whole[None])[0]
    return whole


POINT = np.array([(0, 0)])
HALVES = np.array([(4, 0), (0, 4), (4, 4)])
RING = np.array(
    [
        (i, j)
        for i in range(8)
        for j in range(8)
        if max(min(i, 8 - i), min(j, 8 - j)) >= 2 and (i, j) <= ((8 - i) % 8, (8 - j) % 8)
    ]
)
"""Phases of the cell, in eighths, away from the lattice points; of opposite ones, which agree, one."""
ENOUGH = 4  # lattice points of a half plane that do not agree by chance; 2: three accept another one, 8: one


class Ranking(NamedTuple):
    """Which lattice leads. Halved and doubled on 35 textures: how many accept another one (docs/design/012)."""

    promising: int = 400  # those whose mean is best: only they are compared with half cells; halved and doubled: none
    fitted: int = 60  # and only so many with the whole ring; 30 and 120: none
    rival: int = 85  # per cent of the confidence of the most confident, and; 42 and 100: none; two of 96 crops have one
    better: int = 130  # per cent of its mean correlation, lead instead; 115: two get another one, 260: none
    finer: int = 80  # per cent of its confidence, and; 40 and 95: none
    alike: int = 90  # per cent of its mean, let a lattice that holds all its points and more lead; 45: one
    whole: float = 0.1  # steps of the finer one: so near to whole numbers it holds them; halved and doubled: none


class Fitting(NamedTuple):
    """Where peaks are looked for. Halved and doubled on 35 textures: how many accept another one."""

    radius: float = 0.12  # of the shorter vector: peaks are looked for within; halved: three, doubled: one
    least: float = 1.5  # px, and at least so far; halved and doubled: none
    drift: float = 0.15  # of the shorter vector: who moves further found another; 0: a rule differs
    slack: float = 2.0  # px more, for grain; 1 and 4: none
    loose: float = 0.01  # of the shorter vector: peaks further off make a lattice loose,; 0: one is 1 px off
    blur: float = 0.05  # and its map is blurred by this much; halved and doubled: one or two move by 1 px
    sigma: float = 1.5  # px: no less is blurred, beside the map's own 1 px; 3: one moves by 1 px


RANKING, FITTING = Ranking(), Fitting()


@dataclass(frozen=True)
class Scored:
    """Lattices and how good they are."""

    vectors: Int64  # (n, 2, 2): in 1/256 px, rows (dy, dx)
    mean: Int64  # (n,): M at the points, in millionths
    contrast: Int64  # (n,): C = M - the best of the ring
    confidence: Int64  # (n,): K = C (1 - 1 / sqrt(points))
    points: Int64  # (n,): lattice points in one half plane whose offset leaves enough overlap

    def best(self, most: int) -> Int64:
        """Return which are most confident, ties in order of size, then of their numbers."""
        v = self.vectors
        area = np.abs(v[:, 0, 0] * v[:, 1, 1] - v[:, 0, 1] * v[:, 1, 0])
        keys = [v[:, i, j] for i in (1, 0) for j in (1, 0)]
        result: Int64 = np.lexsort([*keys, area, -self.confidence])[:most]
        return result

    def ranked(self, most: int) -> Int64:
        """Return the best, first of all one that is about as confident as the most confident but agrees far better.

        A cell of many small tiles, equal but for their colour, has more points; that of the colours agrees.
        """
        order = self.best(most)
        if len(order):
            top = order[0]
            rivals = order[
                (self.points[order] >= ENOUGH)
                & (100 * self.confidence[order] >= RANKING.rival * self.confidence[top])
                & (100 * self.mean[order] >= RANKING.better * self.mean[top])
            ]
            if len(rivals) and self.confidence[top] > 0:
                top = rivals[np.argmax(self.mean[rivals])]
            finer = [k for k in order if self._refines(int(k), int(top))]
            top = finer[0] if finer else top
            order = np.concatenate([[top], order[order != top]])
        return order

    def _refines(self, k: int, top: int) -> bool:
        """Say whether lattice k holds all points of the top one and more, and is about as good.

        The ring of eighths sees the double cell of a lattice, but not its sevenfold one.
        """
        sure = 100 * self.confidence[k] >= RANKING.finer * self.confidence[top]
        if not sure or 100 * self.mean[k] < RANKING.alike * self.mean[top]:
            return False
        small, large = (self.vectors[i].astype(np.float64) for i in (k, top))
        (p, q), (r, s) = small
        times = large @ np.array([[s, -q], [-r, p]]) / (p * s - q * r)
        whole = np.rint(times)
        index = abs(round(float(whole[0, 0] * whole[1, 1] - whole[0, 1] * whole[1, 0])))
        return index > 1 and bool(np.abs(times - whole).max() < RANKING.whole)


def score(found: CorrelationMap, vectors: Int64, phases: Int64) -> Scored:
    """Score lattices against the phases given."""
    mean, points = means(found.values, found.weights, vectors, POINT)
    return _contrasted(found, vectors, mean, points, phases)


def shortlist(found: CorrelationMap, vectors: Int64) -> Int64:
    """Keep the lattices worth a closer look: by their mean, then by contrast with their half cells."""
    mean, points = means(found.values, found.weights, vectors, POINT)
    keep = np.flatnonzero((points >= 2) & (mean > 0))
    hope = mean[keep] * _few(points[keep]) // 1000
    keep = keep[np.argsort(-hope, kind="stable")[: RANKING.promising]]
    scored = _contrasted(found, vectors[keep], mean[keep], points[keep], HALVES)
    return scored.vectors[scored.best(RANKING.fitted)]


def _few(points: Int64) -> Int64:
    """1 - 1 / sqrt(n), in thousandths; roots are rounded alike everywhere."""
    return np.asarray(1000 - np.rint(1000 / np.sqrt(np.maximum(points, 1))), np.int64)


def _contrasted(
    found: CorrelationMap, vectors: Int64, mean: Int64, points: Int64, phases: Int64
) -> Scored:
    aside, _ = means(found.values, found.weights, vectors, phases)
    known = (points > 0) & (aside > NOTHING)
    contrast = np.where(known, mean - aside, -1_000_000)
    return Scored(vectors, mean, contrast, contrast * _few(points) // 1000, points)


@dataclass(frozen=True)
class Fit:
    """Vectors (2, 2) in px that agree best with the peaks, and how far the peaks lie from them (rms, px)."""

    vectors: Floats
    residual: float
    used: int


def fit(found: CorrelationMap, vectors: Int64, smooth: Int32 | None = None) -> Fit | None:
    """Move the vectors of a lattice to where the peaks are; None where there are none, or elsewhere.

    Weighted least squares over the peaks near the lattice points up to index 2, then 5, then all: the further
    out, the more exact a vector must be to find the right peak, and the more exact it becomes. `smooth` replaces
    the map whose peaks are looked for.
    """
    smooth = found.smooth if smooth is None else smooth
    start = vectors / float(UNIT)
    current = start
    length = min(math.hypot(*row) for row in start)
    sums = np.empty(9)
    used = 0
    for most in (2, 5, 1 << 20):
        radius = max(FITTING.least, FITTING.radius * length)
        used, tried = fit_step(smooth, found.weights, current, most, radius, sums)
        aa, ab, bb = (float(n) for n in sums[:3])
        least = 1e-6 * max(aa, bb) ** 2  # rounding: peaks in one line give 0
        moved = _spanned(aa, ab, bb, sums[3:5], sums[5:7], least)
        if moved is None or 2 * used < tried:
            return None
        current = moved
        if np.hypot(*(current - start).T).max() > FITTING.drift * length + FITTING.slack:
            return None
    fit_step(smooth, found.weights, current, 1 << 20, max(FITTING.least, FITTING.radius * length), sums)
    return Fit(current, math.sqrt(sums[7] / sums[8]) if sums[8] > 0 else 0.0, used)


def resolved(found: CorrelationMap, vectors: Int64, residual: float) -> Int64:
    """Fit loose lattices once more, to wider peaks: each single peak is then a matter of chance.

    Where the peaks lie further than a hundredth of the shorter vector from the lattice points, the map is
    blurred by a twentieth of it first.
    """
    length = min(math.hypot(*row) for row in vectors / float(UNIT))
    sigma = FITTING.blur * length
    if residual <= FITTING.loose * length or sigma < FITTING.sigma:
        return vectors
    wider = np.rint(blurred(found.values.astype(np.float64), sigma, "edge")).astype(np.int32)
    one = fit(found, vectors, wider)
    if one is None or one.residual >= residual:
        return vectors
    result: Int64 = canonical(np.rint(UNIT * one.vectors).astype(np.int64)[None])[0]
    return result


def regularity(one: Fit) -> float:
    """Say how far the peaks lie from the lattice points: 0 on them, 1 as far as peaks found by chance would.

    Chance spreads them evenly over the disc in which they are looked for. 1 for less than 3 peaks, which every
    lattice can be fitted to.
    """
    if one.used < 3:
        return 1.0
    radius = max(FITTING.least, FITTING.radius * min(math.hypot(*row) for row in one.vectors))
    return min(1.0, one.residual * math.sqrt(2 * one.used / (one.used - 2)) / radius)


def _spanned(aa: float, ab: float, bb: float, t0: Floats, t1: Floats, least: float) -> Floats | None:
    """Solve the normal equations of two vectors; None where all points lie in a row."""
    determinant = aa * bb - ab * ab
    return np.array([bb * t0 - ab * t1, aa * t1 - ab * t0]) / determinant if determinant > least else None


def fitted(found: CorrelationMap, vectors: Int64, size: Pair) -> tuple[Int64, dict[tuple[int, ...], Fit]]:
    """Fit many lattices, dropping those whose fit fails; returns them in 1/256 px, and each one's fit."""
    fits = {}
    for lattice in vectors:
        one = fit(found, lattice)
        if one is not None:
            exact = canonical(np.rint(UNIT * one.vectors).astype(np.int64)[None])
            fits[tuple(exact.ravel().tolist())] = one
    return distinct(np.array(list(fits), np.int64).reshape(-1, 2, 2), *size), fits


def relatives(vectors: Int64) -> Int64:
    """List the lattices of twice the cell and of half the cell: what guesses are most often wrong by."""
    v, w = vectors[:, 0], vectors[:, 1]
    double = [(2 * v, w), (v, 2 * w), (v + w, v - w)]
    half = [(v // 2, w), (v, w // 2), ((v + w) // 2, w)]
    return canonical(np.concatenate([np.stack(pair, axis=1) for pair in (*double, *half)]))
