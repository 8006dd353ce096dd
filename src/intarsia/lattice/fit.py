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

POINTS = 12  # lattice points compared at full resolution: two per direction
ANGLES = 6  # sectors of 30 degrees of a half circle over which these points are spread
FARTHEST = 0.5  # largest offset as a share of each side, so that half of it overlaps
SPARE = 2  # px: search radius beyond the reduction factor, as peaks may lie next to the px of the reduced copy
SPANNED = 0.5  # least determinant of indices, a whole number: 0 if all points are collinear, else 1 or more


def refined(features: Int16, usable: Mask | None, vectors: Int64, factor: int) -> Int64 | None:
    """Return the vectors (1/256 px) refined at full resolution; None if that fails.

    Least squares over at most 12 lattice points far from the origin, as their error is divided by many cells. Fails if
    no point has a clear minimum of differences, all are collinear, or the vectors move by more than `factor` px.
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
    """Return the indices of at most 12 lattice points far from the origin, spread over six directions.

    Their offsets are at most half of each side; the furthest of each direction come first, then the second ones.
    """
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
    """Return the vectors, 1/256 px, by least squares from indices a (n, 1 or 2) and positions p (n, 2) in px.

    None if the points are collinear, or a component changes by more than `factor` px.
    """
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
"""Phases of the cell, in eighths of both vectors, two or more from the lattice points; one of each opposite pair."""
ENOUGH = 4  # lattice points in a half plane beyond chance agreement; 2: three of 35 textures accept another, 8: one


class Ranking:
    """Ranking of lattices. Comments: how many of 35 textures change by other values (docs/design/012)."""

    promising = 400  # lattices of the best mean, which are contrasted with half cells; halved, doubled: none
    fitted = 60  # best of these, which are fitted and contrasted with all phases; 30, 120: none
    rival = 85  # per cent: least confidence, of one preferred for its mean (2 of 96 crops); 42, 100: none
    better = 130  # per cent: and least mean correlation, of that of the most confident; 115: two change, 260: none


class Fitting:
    """Search and fit of correlation peaks. Comments: how many of 35 textures accept another lattice."""

    radius = 0.12  # search radius as a share of the shorter vector; halved: three, doubled: one
    least = 1.5  # px: least search radius; halved, doubled: none
    drift = 0.15  # of the shorter vector: a fit that moves a vector further is rejected; 0: a test texture differs
    slack = 2.0  # px: added to that limit, for short vectors; 1 and 4: none
    loose = 0.01  # of the shorter vector: a lattice with a larger residual is fitted again, blurred; 0: one is 1 px off
    blur = 0.05  # of the shorter vector: sigma of that blur; halved, doubled: one or two move by 1 px
    sigma = 1.5  # px: least sigma of that blur, as the map is already blurred by 1 px; 3: one moves by 1 px


class Scored(NamedTuple):
    """Lattices and their scores."""

    vectors: Int64  # (n, 2, 2): in 1/256 px, rows (dy, dx)
    mean: Int64  # (n,): M at the points, in millionths
    contrast: Int64  # (n,): C = M - the highest mean of the other phases compared
    confidence: Int64  # (n,): K = C (1 - 1 / sqrt(points))
    points: Int64  # (n,): lattice points in one half plane whose offset leaves enough overlap

    def best(self, most: int) -> Int64:
        """Return the indices of the `most` lattices of highest confidence; ties by cell area, then by the vectors."""
        v = self.vectors
        area = np.abs(v[:, 0, 0] * v[:, 1, 1] - v[:, 0, 1] * v[:, 1, 0])
        return np.lexsort([*v.reshape(-1, 4).T[::-1], area, -self.confidence])[:most]

    def ranked(self, most: int) -> Int64:
        """Return the indices of :meth:`best`, with one exception for the first.

        A lattice about as confident as the most confident one but of a much higher mean correlation comes first: small
        tiles that differ only in colour give a small cell of many points, but only the larger cell keeps the colours.
        """
        order = self.best(most)
        if not len(order):
            return order
        top = order[0]
        rivals = order[
            (self.points[order] >= ENOUGH)
            & (100 * self.confidence[order] >= Ranking.rival * self.confidence[top])
            & (100 * self.mean[order] >= Ranking.better * self.mean[top])
        ]
        if len(rivals) and self.confidence[top] > 0:
            top = rivals[np.argmax(self.mean[rivals])]
        return np.concatenate([[top], order[order != top]])


def score(found: CorrelationMap, vectors: Int64) -> Scored:
    """Return the scores of lattices (n, 2, 2) in 1/256 px, contrasted with all phases away from their points."""
    return _contrasted(found, vectors, means(found.values, found.weights, vectors, POINT), RING)


def shortlist(found: CorrelationMap, vectors: Int64) -> Int64:
    """Return the 60 most promising lattices: the 400 best by their mean, then by the contrast with half cells."""
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
    """Vectors fitted to correlation peaks."""

    vectors: Floats  # (2, 2), rows (dy, dx), px
    residual: float  # distance of the peaks from their lattice points, rms, px
    used: int  # number of peaks


def fit(found: CorrelationMap, vectors: Int64) -> Fit | None:
    """Fit the vectors of a lattice, given in 1/256 px, to correlation peaks.

    None if fewer than half of the points have a peak, all peaks are collinear, or a vector moves too far.

    Weighted least squares over the peaks near the lattice points up to index 2, then 5, then all: peaks of far points
    are found only from vectors that are already accurate, and make them more accurate.
    """
    start = current = vectors / float(UNIT)
    length, sums, used = _shorter(start), np.empty(9), 0
    radius = max(Fitting.least, Fitting.radius * length)
    for most in (2, 5, 1 << 20):
        used, tried = fit_step(found.smooth, found.weights, current, most, radius, sums)
        aa, ab, bb = sums[:3].tolist()
        least = 1e-6 * max(aa, bb) ** 2  # above rounding errors; collinear peaks give 0
        moved = _spanned(aa, ab, bb, sums[3:5], sums[5:7], least)
        if moved is None or 2 * used < tried:
            return None
        current = moved
        if np.hypot(*(current - start).T).max() > Fitting.drift * length + Fitting.slack:
            return None
    fit_step(found.smooth, found.weights, current, 1 << 20, radius, sums)
    return Fit(current, math.sqrt(sums[7] / sums[8]) if sums[8] > 0 else 0.0, used)


def resolved(found: CorrelationMap, vectors: Int64, residual: float) -> Int64:
    """Return the vectors, 1/256 px, of an irregular lattice fitted again to a blurred map.

    A lattice is irregular if its residual, px, is more than a hundredth of the shorter vector; the map is blurred by a
    sigma of a twentieth of it. Unchanged if it is regular, that sigma is below 1.5 px, or the residual does not shrink.
    """
    length = _shorter(vectors / float(UNIT))
    sigma = Fitting.blur * length
    if residual <= Fitting.loose * length or sigma < Fitting.sigma:
        return vectors
    wider = np.rint(blurred(found.values.astype(np.float64), sigma, "edge")).astype(np.int32)
    one = fit(found._replace(smooth=wider), vectors)
    return vectors if one is None or one.residual >= residual else _in_units(one)


def regularity(one: Fit) -> float:
    """Return how far the peaks lie from the lattice points: 0 on them, 1 as far as by chance.

    By chance peaks would be uniform over the disc in which they are searched. 1 for fewer than 3 peaks, to which any
    lattice can be fitted.
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
    """Return the fitted lattices, (n, 2, 2) in 1/256 px, and a map from vectors to fits; failed fits are left out.

    `size`: rows and columns of the exemplar, px.
    """
    fits = {}
    for lattice in vectors:
        one = fit(found, lattice)
        if one is not None:
            fits[tuple(_in_units(one).ravel().tolist())] = one
    return distinct(np.array(list(fits), np.int64).reshape(-1, 2, 2), *size), fits
