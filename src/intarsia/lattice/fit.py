"""Lattice score and sub-pixel fit: contrast of the correlation at lattice points, weighted least squares over peaks.

The score combines the mean correlation at the lattice points, its contrast with the rest of the cell, and a penalty for
few points. The fit finds correlation peaks near the points and solves for the vectors to a fraction of a px.

Source: Lopez Recas 2011, eq. 3.22 (mean at the lattice points). Departures: contrast with the rest of the cell, the
penalty for few points, sub-pixel vectors by least squares over all peaks.

Large exemplars are searched in a reduced copy; the vectors are then refined at full resolution. For a few far lattice
points the exemplar is compared with itself, shifted by about that vector, in whole numbers; the shift of least squared
difference gives the exact point.
"""

from __future__ import annotations

import math
from collections import Counter
from typing import NamedTuple

import numpy as np

from ..foundation.arrays import Floats, Int16, Int64, Mask, Pair
from ..foundation.filters import blurred
from ..foundation.geometry import UNIT
from .correlation_peaks import CorrelationMap, canonical, distinct
from .scoring_kernels import NOTHING, best_shift, fit_step, means

POINTS = 12  # lattice points compared: two of each direction
ANGLES = 6  # directions of a half circle, 30 degrees each, over which they are spread
FARTHEST = 0.5  # of each side: the other half is left to compare
SPARE = 2  # px besides those that one px of the reduced copy stands for: the peak may lie beside its px
SPANNED = 0.5  # the determinant of whole numbers is 0 where all points lie in a row, 1 or more else


def refined(features: Int16, usable: Mask | None, vectors: Int64, factor: int) -> Int64 | None:
    """Return the vectors (1/256 px) refined at full resolution; None if the exemplar does not allow it.

    Weighted least squares over the lattice points that lie furthest out: their error is divided by many cells.
    """
    mask = np.ones((1, 1), np.bool_) if usable is None else usable
    rows, right, found = [], [], np.empty(2)
    for index in _furthest(vectors, *features.shape[:2]):
        near = np.rint(np.array(index) @ vectors / UNIT).astype(np.int64)
        if best_shift(features, mask, near, factor + SPARE, found):
            rows.append(index)
            right.append(found.tolist())
    return _least_squares(np.array(rows, np.float64), np.array(right), vectors, factor) if rows else None


def _furthest(vectors: Int64, height: int, width: int) -> list[tuple[int, ...]]:
    """Return the furthest lattice points that leave half of each side to compare, spread over directions."""
    n, found = len(vectors), []
    most = [max(1, int(FARTHEST * max(height, width) * UNIT / math.hypot(*v))) for v in vectors]
    for a in range(most[0] + 1):
        for b in range(-most[1], most[1] + 1) if n == 2 else (0,):
            index = (a, b)[:n]
            y, x = (np.array(index) @ vectors) / UNIT
            if index > (0, 0)[:n] and abs(y) <= FARTHEST * height and abs(x) <= FARTHEST * width:
                angle = math.floor(ANGLES * (math.atan2(y, x) % math.pi) / math.pi)
                found.append((-round(math.hypot(y, x)), index, angle))
    seen, ranked = Counter[int](), []
    for nearness, index, angle in sorted(found):
        seen[angle] += 1
        ranked.append((seen[angle], nearness, index))
    return [index for *_, index in sorted(ranked)[:POINTS]]


def _least_squares(a: Floats, p: Floats, vectors: Int64, factor: int) -> Int64 | None:
    """Return the vectors that fit places p (n, 2), px, of points a (n, 1 or 2) of their lattice, in 1/256 px."""
    if len(vectors) == 1:
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
    return canonical(whole[None])[0] if len(whole) == 2 else whole


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


class Ranking:
    """Which lattice is ranked first; halved and doubled on 35 textures: how many change (docs/design/012)."""

    promising = 400  # those whose mean is best: only they are compared with half cells; halved and doubled: none
    fitted = 60  # and only so many with the whole ring; 30 and 120: none
    rival = 85  # per cent of the confidence of the most confident, and; 42 and 100: none; two of 96 crops have one
    better = 130  # per cent of its mean correlation, lead instead; 115: two get another one, 260: none
    finer = 80  # per cent of its confidence, and; 40 and 95: none
    alike = 90  # per cent of its mean, let a lattice that holds all its points and more lead; 45: one
    whole = 0.1  # steps of the finer one: so near to whole numbers it holds them; halved and doubled: none


class Fitting:
    """Where correlation peaks are looked for. Halved and doubled on 35 textures: how many accept another one."""

    radius = 0.12  # of the shorter vector: peaks are looked for within; halved: three, doubled: one
    least = 1.5  # px, and at least so far; halved and doubled: none
    drift = 0.15  # of the shorter vector: a fit that moves further found another lattice; 0: a rule differs
    slack = 2.0  # px more, for grain; 1 and 4: none
    loose = 0.01  # of the shorter vector: peaks further off make a lattice loose,; 0: one is 1 px off
    blur = 0.05  # and its map is blurred by this much; halved and doubled: one or two move by 1 px
    sigma = 1.5  # px: no less is blurred, beside the map's own 1 px; 3: one moves by 1 px


class Scored(NamedTuple):
    """Lattices and their scores."""

    vectors: Int64  # (n, 2, 2): in 1/256 px, rows (dy, dx)
    mean: Int64  # (n,): M at the points, in millionths
    contrast: Int64  # (n,): C = M - the best of the ring
    confidence: Int64  # (n,): K = C (1 - 1 / sqrt(points))
    points: Int64  # (n,): lattice points in one half plane whose offset leaves enough overlap

    def best(self, most: int) -> Int64:
        """Return the numbers of the `most` most confident lattices; ties by cell area, then by the vectors."""
        v = self.vectors
        area = np.abs(v[:, 0, 0] * v[:, 1, 1] - v[:, 0, 1] * v[:, 1, 0])
        return np.lexsort([*v.reshape(-1, 4).T[::-1], area, -self.confidence])[:most]

    def ranked(self, most: int) -> Int64:
        """Return the best, first the lattice that leads.

        A lattice that is about as confident as the most confident one but has a far better mean correlation comes
        first: a cell of many small tiles, equal but for their colour, has more points, but only the larger cell keeps
        the colours.
        """
        order = self.best(most)
        if len(order):
            top = order[0]
            rivals = order[
                (self.points[order] >= ENOUGH)
                & (100 * self.confidence[order] >= Ranking.rival * self.confidence[top])
                & (100 * self.mean[order] >= Ranking.better * self.mean[top])
            ]
            if len(rivals) and self.confidence[top] > 0:
                top = rivals[np.argmax(self.mean[rivals])]
            finer = [k for k in order if self._refines(int(k), int(top))]
            top = finer[0] if finer else top
            order = np.concatenate([[top], order[order != top]])
        return order

    def _refines(self, k: int, top: int) -> bool:
        """Return whether lattice k contains all points of the leading one and more, and is about as good.

        The ring of eighths detects the double cell of a lattice, but not its sevenfold one.
        """
        sure = 100 * self.confidence[k] >= Ranking.finer * self.confidence[top]
        if not sure or 100 * self.mean[k] < Ranking.alike * self.mean[top]:
            return False
        small, large = (self.vectors[i].astype(np.float64) for i in (k, top))
        (p, q), (r, s) = small
        times = large @ np.array([[s, -q], [-r, p]]) / (p * s - q * r)
        whole = np.rint(times)
        index = abs(round(float(whole[0, 0] * whole[1, 1] - whole[0, 1] * whole[1, 0])))
        return index > 1 and bool(np.abs(times - whole).max() < Ranking.whole)


def score(found: CorrelationMap, vectors: Int64) -> Scored:
    """Return the scores of lattices, contrasted with the ring of phases."""
    return _contrasted(found, vectors, means(found.values, found.weights, vectors, POINT), RING)


def shortlist(found: CorrelationMap, vectors: Int64) -> Int64:
    """Return the most promising lattices: by their mean, then by the contrast with their half cells."""
    known = means(found.values, found.weights, vectors, POINT)
    mean, points = known
    keep = np.flatnonzero((points >= 2) & (mean > 0))
    hope = mean[keep] * _few(points[keep]) // 1000
    keep = keep[np.argsort(-hope, kind="stable")[: Ranking.promising]]
    scored = _contrasted(found, vectors[keep], known[:, keep], HALVES)
    return scored.vectors[scored.best(Ranking.fitted)]


def _few(points: Int64) -> Int64:
    """Return 1 - 1 / sqrt(n) in thousandths, rounded so that it is the same on every machine."""
    return np.asarray(1000 - np.rint(1000 / np.sqrt(np.maximum(points, 1))), np.int64)


def _contrasted(found: CorrelationMap, vectors: Int64, known: Int64, phases: Int64) -> Scored:
    """Return the scores of lattices whose means and points are known, contrasted with other phases of their cells."""
    (mean, points), aside = known, means(found.values, found.weights, vectors, phases)[0]
    known = (points > 0) & (aside > NOTHING)
    contrast = np.where(known, mean - aside, -1_000_000)
    return Scored(vectors, mean, contrast, contrast * _few(points) // 1000, points)


class Fit(NamedTuple):
    """Vectors (2, 2) in px that fit the peaks best, and the distance of the peaks from their points (rms, px)."""

    vectors: Floats
    residual: float
    used: int


def fit(found: CorrelationMap, vectors: Int64) -> Fit | None:
    """Fit the vectors of a lattice to correlation peaks; None if there are none, or the vectors move too far.

    Weighted least squares over the peaks near the lattice points up to index 2, then 5, then all: points further out
    need a more exact vector to find their peak, and make it more exact.
    """
    start = current = vectors / float(UNIT)
    length, sums, used = _shorter(start), np.empty(9), 0
    radius = max(Fitting.least, Fitting.radius * length)
    for most in (2, 5, 1 << 20):
        used, tried = fit_step(found.smooth, found.weights, current, most, radius, sums)
        aa, ab, bb = sums[:3].tolist()
        least = 1e-6 * max(aa, bb) ** 2  # rounding: peaks in one line give 0
        moved = _spanned(aa, ab, bb, sums[3:5], sums[5:7], least)
        if moved is None or 2 * used < tried:
            return None
        current = moved
        if np.hypot(*(current - start).T).max() > Fitting.drift * length + Fitting.slack:
            return None
    fit_step(found.smooth, found.weights, current, 1 << 20, radius, sums)
    return Fit(current, math.sqrt(sums[7] / sums[8]) if sums[8] > 0 else 0.0, used)


def resolved(found: CorrelationMap, vectors: Int64, residual: float) -> Int64:
    """Return the vectors of a loose lattice fitted again to wider peaks; unchanged if the lattice is not loose.

    If the peaks lie further than a hundredth of the shorter vector from the lattice points, the map is blurred by a
    twentieth of it first, so that no single peak decides.
    """
    length = _shorter(vectors / float(UNIT))
    sigma = Fitting.blur * length
    if residual <= Fitting.loose * length or sigma < Fitting.sigma:
        return vectors
    wider = np.rint(blurred(found.values.astype(np.float64), sigma, "edge")).astype(np.int32)
    one = fit(found._replace(smooth=wider), vectors)
    return vectors if one is None or one.residual >= residual else _in_units(one)


def regularity(one: Fit) -> float:
    """Return how far the peaks lie from the lattice points: 0 on them, 1 as far as peaks found by chance would.

    By chance they would be uniform over the disc in which they are looked for. 1 for less than 3 peaks, which every
    lattice can be fitted to.
    """
    if one.used < 3:
        return 1.0
    radius = max(Fitting.least, Fitting.radius * _shorter(one.vectors))
    return min(1.0, one.residual * math.sqrt(2 * one.used / (one.used - 2)) / radius)


def _shorter(vectors: Floats) -> float:
    return min(math.hypot(*row) for row in vectors)


def _in_units(one: Fit) -> Int64:
    """Return the fitted vectors in 1/256 px, reduced."""
    return np.asarray(canonical(np.rint(UNIT * one.vectors).astype(np.int64)[None])[0])


def _spanned(aa: float, ab: float, bb: float, t0: Floats, t1: Floats, least: float) -> Floats | None:
    """Solve the normal equations of two vectors; None if all points are collinear."""
    determinant = aa * bb - ab * ab
    return np.array([bb * t0 - ab * t1, aa * t1 - ab * t0]) / determinant if determinant > least else None


def fitted(found: CorrelationMap, vectors: Int64, size: Pair) -> tuple[Int64, dict[tuple[int, ...], Fit]]:
    """Fit many lattices, without those whose fit fails. Return them in 1/256 px, and the fit of each."""
    fits = {}
    for lattice in vectors:
        one = fit(found, lattice)
        if one is not None:
            fits[tuple(_in_units(one).ravel().tolist())] = one
    return distinct(np.array(list(fits), np.int64).reshape(-1, 2, 2), *size), fits


def relatives(vectors: Int64) -> Int64:
    """Return the lattices of double and half cells: the most frequent errors of candidates."""
    v, w = vectors[:, 0], vectors[:, 1]
    double = [(2 * v, w), (v, 2 * w), (v + w, v - w)]
    half = [(v // 2, w), (v, w // 2), ((v + w) // 2, w)]
    return canonical(np.concatenate([np.stack(pair, axis=1) for pair in (*double, *half)]))
