"""Lattice decision: accepted, tentative or refused, with reasons; pitch of courses without a second period.

A texture without a lattice also matches itself at some offsets by chance. The decision therefore depends on the number
of lattice points and on how near to them the correlation peaks lie. Three equal objects on a plain ground match each
other as well as lattice cells do; but a lattice repeats in nearly every part of the exemplar, which is checked too.

Textures that repeat in one direction only (courses of stones, planks, lines of text) have a pitch: a vector
perpendicular to the courses. Shifted by that pitch, and by any amount along the courses, the texture matches itself;
shifted by half the pitch it does not.

Source: no paper. Thresholds were set on photographs with and without a lattice and checked on other crops of them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from ..foundation.arrays import Array, Floats, Int64, Pair
from ..foundation.geometry import UNIT
from .correlation_peaks import MILLION, SHORTEST, CorrelatedPictures, CorrelationMap, overlap
from .fit import ENOUGH, Fit, Scored, regularity, resolved
from .scoring_kernels import NOTHING, course_profile, top_of


class Turning:
    """Refinement of the direction and pitch of courses.

    Each value was halved and doubled on 35 textures: none accepts another lattice; the comments give how many of the
    accepted vectors change by a px. The contrasts of rejected candidates differ (docs/design/012).
    """

    turn = 9 / 1024  # radians, half a degree: step of the first pass; halved, doubled: two change, 0: three
    finer = 8  # the second pass has steps of `turn` divided by this; 4: two change, 16: one
    turns = 4  # steps to either side: a spectral peak of few periods is 2 degrees wide; 2: one changes
    waves = 3  # spectral peaks that are refined, the best; 6 and 12: the same
    stretch = 12  # steps to either side in which the pitch is varied; 6: one changes, 24: the same
    step = 400  # such a step is the pitch divided by this, 1/4 %; 200 and 800: the same on eight textures
    reach = 0.24  # half px per px of pitch: peaks are searched within an eighth of it; halved, doubled: no change
    least = 2  # half px: least search radius of peaks; 1 and 4: the same
    drift = 0.03  # of a pitch, as far as it is varied: fits that change it by more are ignored; 0: three change


class RowPitch(NamedTuple):
    """The pitch of courses and its contrast."""

    pitch: tuple[float, float]  # (dy, dx) across the rows, px
    contrast: int  # millionths: the mean correlation along the rows minus that halfway between
    lines: int  # multiples of the pitch, in one direction, at which enough of the exemplar overlaps
    residual: float  # distance of the correlation peaks from multiples of the pitch, rms, px

    @property
    def rank(self) -> tuple[int, tuple[float, float]]:
        """Sort key: the highest contrast first."""
        return -self.contrast, self.pitch


def row_pitches(found: CorrelationMap, waves: list[Floats]) -> list[RowPitch]:
    """Return the pitches of courses across the three best frequencies, best contrast first.

    `waves`: arrays of frequencies (fy, fx), cycles per px. The best three are refined in direction.
    """
    vectors = [np.rint(UNIT * f / (f @ f)) for f in np.concatenate(waves)]
    vectors = [v for v in vectors if SHORTEST * UNIT <= math.sqrt(float(v @ v)) <= UNIT * max(found.values.shape) / 2]
    tried = [(one, v) for v in vectors if (one := _turned(found, v, 0.0)) is not None]
    tried.sort(key=lambda known: known[0].rank)
    hint = MILLION * Limits.courses / 4  # refining adds at most a fifth to a contrast (158 textures)
    best = [_refined(found, v, one) if one.contrast >= hint else one for one, v in tried[: Turning.waves]]
    return sorted(best, key=lambda one: one.rank)


def _refined(found: CorrelationMap, v: Floats, best: RowPitch) -> RowPitch:
    """Return the pitch refined in direction: first in steps of half a degree, then in eighths of that."""
    turn = 0.0
    for step in (Turning.turn, Turning.turn / Turning.finer):
        middle = turn
        for k in (*range(-Turning.turns, 0), *range(1, Turning.turns + 1)):  # 0: `best`
            one = _turned(found, v, middle + k * step)
            if one is not None and one.contrast > best.contrast:
                best, turn = one, middle + k * step
    return best


def _turned(found: CorrelationMap, v: Floats, turn: float) -> RowPitch | None:
    """Return the best pitch near the length of v (1/256 px), parallel to v + turn * (v rotated by 90 degrees).

    None if it repeats nowhere within the map, or its contrast is not above 0.
    """
    length = math.sqrt(float(v @ v)) / UNIT
    y, x = v[0] - turn * v[1], v[1] + turn * v[0]
    norm = math.sqrt(y * y + x * x)
    direction = np.rint(np.array([y, x]) * 65536 / norm).astype(np.int64)
    high, wide = found.values.shape[0] // 2, found.values.shape[1] // 2
    n = 2 * int((high * abs(direction[0]) + wide * abs(direction[1])) >> 16)  # a line for every half px
    mean, mass = course_profile(found.values, found.weights, direction, n)
    stretched = 1 + np.arange(-Turning.stretch, Turning.stretch + 1) / Turning.step
    lengths = np.rint(2 * UNIT * length * stretched).astype(np.int64)
    contrasts = pitch_contrasts(mean, mass, lengths)
    k = int(np.argmax(contrasts))
    pitch, residual, lines = _fit(mean, mass, float(lengths[k]) / (2 * UNIT))
    if lines < 1 or contrasts[k] <= 0:
        return None
    return RowPitch((float(pitch * y / norm), float(pitch * x / norm)), int(contrasts[k]), lines, residual)


def pitch_contrasts(mean: Int64, mass: Int64, pitches: Int64) -> Int64:
    """Return the mean of a profile at multiples of each pitch minus that halfway between them.

    `mean`, `mass`: the profile and its weights; `pitches`: in 1/256 of an entry of the profile.
    """
    seen, levels = int(mass.nonzero()[0].max(initial=0)), []
    for half in range(2):
        at = (pitches >> half)[:, None] + pitches[:, None] * np.arange((seen << 8) // int(pitches.min()) + 1)
        there = (at >> 8) + 1 <= seen
        low, part = np.where(there, at >> 8, 0), at & 255
        weight = np.where(there, mass[low], 0)
        total = (weight * ((mean[low] * (256 - part) + mean[low + 1] * part) >> 8)).sum(axis=1)
        level = total // np.maximum(weight.sum(axis=1), 1)
        levels.append(np.where(weight.any(axis=1), level, NOTHING))
    return np.asarray(np.where(np.minimum(*levels) > NOTHING, levels[0] - levels[1], NOTHING))


def _fit(mean: Int64, mass: Int64, pitch: float) -> tuple[float, float, int]:
    """Return the pitch, px, fitted to the peaks near its multiples, the rms residual, px, and how many multiples.

    The pitch is returned unchanged, with residual 0, if the fit changes it by more than 3 %.
    """
    found, lines = [], 0
    for k in itertools.count(1):
        at = 2 * k * pitch
        if at >= len(mean) - 2 or mass[round(at)] <= 0:
            break
        lines = k
        reach = max(Turning.least, int(Turning.reach * pitch))
        low = max(1, round(at) - reach)
        window = mean[low : min(len(mean) - 1, round(at) + reach + 1)]
        i = low + int(np.argmax(window))
        before, here, after = (float(m) for m in mean[i - 1 : i + 2])
        if here >= max(before, after) and here > 0 and mass[i + 1] > 0:
            found.append((here * float(mass[i]), k, (i + top_of(before, here, after)) / 2))
    bottom = sum(w * k * k for w, k, _ in found)
    exact = sum(w * k * p for w, k, p in found) / bottom if bottom > 0 else math.inf
    if abs(exact - pitch) > Turning.drift * pitch:
        return pitch, 0.0, lines
    square = sum(w * (p - k * exact) ** 2 for w, k, p in found) / sum(w for w, _, _ in found)
    return exact, math.sqrt(square), lines


Verdict = Literal["sure", "faint", "refused"]
SURE: Verdict = "sure"
TENTATIVE: Verdict = "faint"
REFUSED: Verdict = "refused"

PARTS = 5  # parts per side of the overlap; 3: a floor and a wall of setts refused, 10: 45 degree planks get courses
LEAST_PART = 6  # px: least side of a part; 1 to 12: the same on 92 textures, it matters for tiny exemplars
ALIKE = 0.2  # least correlation of a part that repeats; halved: 3 false lattices, doubled: 8 true ones refused


class Limits:
    """Thresholds of the decision, set on 50 photographs, 21 of them with a lattice.

    Of the 21, 20 were accepted and 1 refused; 4 of the others were accepted wrongly. Each value was halved and doubled
    on 92 textures, 44 of which were not used to set it (docs/design/012).
    """

    least = 0.05  # least confidence K; halved: two walls of irregular bricks get vectors, doubled: two lattices refused
    courses = 0.145  # least contrast of courses; halved: five more textures get courses, doubled: two walls refused
    two = 0.18  # least contrast of only two courses; halved: the same, doubled: a pavement of loose setts refused
    pair = 0.5  # least contrast of two lattice points; 0.2: a wall of 96 px with five bricks gets a false lattice
    few = 0.2  # least contrast of three points; 0: a wall of irregular bricks gets two vectors, 0.4: one other cell
    everywhere = 0.6  # least repeating share of parts for two or three points; 0.4: setts near slabs get one, 0.8: same
    parts = 0.4  # least repeating share for four points or more; halved: knitted wool gets one, 0.6: a floor refused
    rows = 0.45  # least repeating share for courses; 0.4: planks at 45 degrees get courses, 0.6: a wall refused
    scattered = 0.75  # largest scatter of the peaks, 1: as by chance; halved: the same, 1: irregular setts get one
    faint = 0.03  # least confidence of a tentative lattice; halved: the same, 0.05: a floor of tiles refused
    exact = 12.0  # least log10 of the odds against chance of a tentative one; 0: two pavements of 180 crops get one
    least_tentative = 0.025  # least confidence for the chance test; halved: jeans get one, doubled: bamboo loses its
    told = 4.0  # least log10 of the odds in the chance test; halved: the same, doubled: bamboo and lizards lose theirs


@dataclass(frozen=True)
class Lattice:
    """One candidate lattice of a texture.

    Attributes
    ----------
    vectors : tuple of (dy, dx)
        In 1/256 px. Two, the shorter first, or one for courses: perpendicular to them, as long as their pitch.
    confidence : float
        Two vectors: K = contrast (1 - 1 / sqrt(points)). One: the contrast.
    contrast : float
        Two vectors: mean correlation at the lattice points minus that at the best other phase of the cell. One: mean
        correlation at multiples of the pitch minus that halfway between.
    points : int
        Lattice points, or courses, whose offset leaves enough overlap; opposite ones count once.
    residual : float
        Distance of the correlation peaks from the lattice points (rms), px: how irregular the texture is.
    reasons : tuple of str
        The findings for and against it, in short sentences; the last one is the decision.
    verdict : "sure", "faint" or "refused"
        ``faint`` (tentative) is accepted only if no pitch of courses is ``sure``.
    repeats : float
        Share of the exemplar that repeats, of the worse of both vectors, 0 to 1; 1 if not measured.
    odds : float
        Decimal logarithm of the odds against the peaks lying so near to the lattice points by chance; 0 for courses.
    """

    vectors: tuple[Pair, ...]
    confidence: float
    contrast: float
    points: int
    residual: float
    reasons: tuple[str, ...] = ()
    verdict: Verdict = REFUSED
    repeats: float = 1.0
    odds: float = 0.0

    @property
    def kind(self) -> Literal["2-D", "1-D"]:
        """Whether the texture repeats in two directions or in one."""
        return "2-D" if len(self.vectors) == 2 else "1-D"

    @property
    def pixels(self) -> Floats:
        """The vectors in px: float64, shape (2, 2) or (1, 2), rows (dy, dx)."""
        return np.array(self.vectors, np.float64) / UNIT

    @property
    def share(self) -> float:
        """Confidence divided by its threshold, by which lattices of one and of two vectors are compared."""
        return self.confidence / (Limits.least if self.kind == "2-D" else Limits.courses)


@dataclass(frozen=True)
class Lattices:
    """The detected lattices of a texture.

    Attributes
    ----------
    accepted : Lattice or None
        The first of `ranked` if it is accepted, else None.
    ranked : tuple of Lattice
        At most five candidates, best first, accepted or not.
    reason : str
        Why the first was accepted or refused.
    """

    accepted: Lattice | None
    ranked: tuple[Lattice, ...]
    reason: str


def two_vectors(found: CorrelationMap, scored: Scored, k: int, one: Fit, prepared: CorrelatedPictures) -> Lattice:
    """Return the k-th of the scored lattices with its decision.

    `one`: its fit. The repeating share and the final fit are computed only if the score does not refuse it, or if it
    may still pass the chance test.
    """
    mean, contrast, confidence = (int(a[k]) / MILLION for a in (scored.mean, scored.contrast, scored.confidence))
    points = int(scored.points[k])
    near = regularity(one)
    odds = max(0, 2 * one.used - 4) * -math.log10(max(near, 0.01))  # degrees of freedom: 2 a peak, less 4
    near = near if one.used > ENOUGH else 0.0
    rows = scored.vectors[k]
    lattice = Lattice((), confidence, contrast, points, one.residual, odds=odds)
    says = [
        f"{points} lattice points agree with {mean:.3f}, anything else in the cell with at most {mean - contrast:.3f}.",
        f"{one.used} correlation peaks lie {one.residual:.2f} px (rms) from the lattice points.",
    ]
    if _judge(lattice, near)[0] != REFUSED or (points >= ENOUGH and confidence >= Limits.least_tentative):
        rows = resolved(found, rows, one.residual)
        parts = min(support(prepared, (y, x)) for y, x in rows.tolist())
        says.append(f"{100 * parts:.0f} % of the exemplar repeats, or more.")
        lattice = replace(lattice, repeats=parts)
    verdict, why = _judge(lattice, near)
    return replace(lattice, vectors=tuple((y, x) for y, x in rows.tolist()), reasons=(*says, why), verdict=verdict)


def _judge(one: Lattice, near: float) -> tuple[Verdict, str]:
    """Decide whether two vectors are a lattice, and why; `near`: scatter of the peaks, 0 to 1."""
    points, confidence, contrast = one.points, one.confidence, one.contrast
    if points < ENOUGH:
        if points < 2 or contrast < (Limits.pair if points == 2 else Limits.few):
            return REFUSED, f"Refused: {points} lattice points could agree by chance (contrast {contrast:.3f})."
        if one.repeats < Limits.everywhere:
            return REFUSED, f"Refused: {points} lattice points, and only parts of the exemplar repeat."
        return SURE, f"Accepted: only {points} lattice points, but all of the exemplar repeats."
    if confidence >= Limits.faint and one.repeats < Limits.parts:
        return REFUSED, f"Refused: the confidence is {confidence:.3f}, but only parts of the exemplar repeat."
    if confidence >= Limits.least and near > Limits.scattered:
        return REFUSED, f"Refused: the confidence is {confidence:.3f}, but the peaks lie anywhere."
    if confidence >= Limits.least:
        return SURE, f"Accepted: the confidence {confidence:.3f} reaches {Limits.least}."
    if confidence >= Limits.faint and one.odds >= Limits.exact:
        return TENTATIVE, f"Accepted: the confidence is only {confidence:.3f}, but the peaks lie exactly on the points."
    return REFUSED, f"Refused: the confidence {confidence:.3f} is below {Limits.least}."


def lattice_by_chance_test(ranked: Sequence[Lattice]) -> Lattice | None:
    """Return the most confident lattice whose peaks pass the chance test, refused or not; None if there is none.

    Elements of different shapes and colours on a lattice correlate little and only in parts, but their correlation
    peaks lie on the lattice. Eight lattice points are required, twice as many as elsewhere; with four, planks get one.
    Blocks cut along such a lattice do not match, but patches can be aligned to it.
    """
    enough = (one for one in ranked if one.points >= 2 * ENOUGH and one.confidence >= Limits.least_tentative)
    told = (one for one in enough if one.odds >= Limits.told)
    return max(told, key=lambda one: one.confidence, default=None)


def one_vector(found: RowPitch, prepared: CorrelatedPictures) -> Lattice:
    """Return a pitch of courses with its decision: by its contrast, number of courses, and repeating share."""
    pitch = round(UNIT * found.pitch[0]), round(UNIT * found.pitch[1])
    if pitch[1] < 0 or (pitch[1] == 0 and pitch[0] < 0):
        pitch = -pitch[0], -pitch[1]
    contrast = found.contrast / MILLION
    least = Limits.courses if found.lines > 2 else Limits.two
    if found.lines < 2:
        verdict, why = REFUSED, "Refused: a single row could agree by chance."
    elif contrast < least:
        verdict, why = REFUSED, f"Refused: the contrast {contrast:.3f} of the rows is below {least}."
    elif support(prepared, pitch) < Limits.rows:
        verdict, why = REFUSED, "Refused: only parts of the exemplar repeat."
    else:
        verdict, why = SURE, f"Accepted: the contrast {contrast:.3f} of the rows reaches {least}."
    says = f"{found.lines} rows agree {contrast:.3f} better than what lies between them."
    return Lattice((pitch,), contrast, contrast, found.lines, found.residual, (says, why), verdict)


def support(prepared: CorrelatedPictures, vector: Pair) -> float:
    """Return the share of parts of the exemplar, at most 5 x 5, that match the place a vector (1/256 px) away.

    A part counts if half of its pixels are usable in both; it matches if colours or edges correlate by 0.2 or more.
    """
    shape, (dy, dx) = prepared.colours.shape[:2], ((abs(v) + 128) // 256 * (1 if v > 0 else -1) for v in vector)
    other, one = overlap(shape, (dy, dx))
    usable = np.ones(shape) if prepared.usable is None else prepared.usable
    known = usable[one] * usable[other]
    parts = min(PARTS, min(known.shape) // LEAST_PART)
    if parts < 1:
        return 0.0
    down, right = (_begins(n, parts) for n in known.shape)

    def added(values: Array) -> Array:
        return np.asarray(np.add.reduceat(np.add.reduceat(values, down, axis=-2), right, axis=-1))

    count, size = added(known * 1.0), added(np.ones(known.shape))
    alike = count < 0  # all False
    for layer in (prepared.colours, prepared.edges):
        planes = np.ascontiguousarray(np.moveaxis(layer, 2, 0))
        f, g = planes[:, *one] * known, planes[:, *other] * known
        p, q = added(f), added(g)
        ff, gg, fg = (count * added(u * v) - s * t for u, v, s, t in ((f, f, p, p), (g, g, q, q), (f, g, p, q)))
        below = np.sqrt(np.maximum(ff * gg, 0)).sum(axis=0)  # channels are weighted by contrast
        alike |= (fg.sum(axis=0) >= ALIKE * below) & (below > 0)
    seen = 2 * count >= size
    return float(alike[seen].mean()) if seen.any() else 0.0


def _begins(length: int, parts: int) -> list[int]:
    """Return the first indices of nearly equal parts of a length, mirror-symmetric as far as possible."""
    return [k * length // parts if 2 * k <= parts else length - (parts - k) * length // parts for k in range(parts)]
