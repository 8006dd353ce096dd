"""Textures that repeat in one direction only: courses of stones, planks, lines of text.

Stones of free length make rows that lie one pitch apart; along the row nothing returns. What is known is the
pitch, a vector across the rows: moved by it along any line parallel to the rows, the texture agrees with
itself, and half a pitch further it does not.

Source: no paper; our own rule, as two vectors must be wrong on such textures.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .candidates import SHORTEST, UNIT
from .correlation_map import CorrelationMap
from .scoring_kernels import course_profile, pitch_contrasts
from .shift_kernels import top_of

Floats = NDArray[np.float64]
Int64 = NDArray[np.int64]


class Turning(NamedTuple):
    """How rows are looked for. Halved and doubled on 35 textures, all accept what they did, moved by a pixel on a few.

    What differs are the contrasts of the rows that are listed (docs/design/012).
    """

    turn: float = 9 / 1024  # about half a degree; halved and doubled: two move, 0: three
    finer: int = 8  # of the steps by which the direction is made exact; 4: two move, 16: one
    turns: int = 4  # steps to either side: waves of a few periods know their direction to about 2 degrees; 2: one moves
    waves: int = 3  # best waves that are refined; 6 and 12: the same
    stretch: int = 12  # steps by which the pitch is made longer and shorter; 6: one moves, 24: the same
    step: int = 400  # of them in a pitch: 1/4 %; 200 and 800: the same on eight
    reach: float = 0.24  # half px a px of pitch: peaks are looked for within an eighth of it; halved, doubled: as is
    least: int = 2  # half px, and at least so far; 1 and 4: the same
    drift: float = 0.03  # of a pitch, as far as it is stretched: a fit that moves further found others; at 0 three move
    apart: float = 0.02  # of a pitch, and 1 px: nearer ones are one; 0 to 0.04: the same


TURNING = Turning()


@dataclass(frozen=True)
class RowPitch:
    """Rows that lie one pitch apart."""

    pitch: tuple[float, float]  # (dy, dx) across the rows, px
    contrast: int  # millionths: the mean correlation along the rows minus that halfway between
    lines: int  # rows, on one side of the origin, whose offset leaves enough overlap
    residual: float  # how far the rows lie from whole pitches, rms, px


def courses(found: CorrelationMap, waves: list[Floats]) -> list[RowPitch]:
    """Try every wave as courses, the best ones turned and stretched; best first, nearly equal ones once."""
    vectors = [np.rint(UNIT * f / (f @ f)) for f in np.concatenate(waves)]
    vectors = [v for v in vectors if SHORTEST * UNIT <= math.sqrt(float(v @ v)) <= UNIT * max(found.values.shape) / 2]
    tried = [(one, v) for v in vectors if (one := _turned(found, v, 0.0)) is not None]
    tried.sort(key=_rank)
    kept: list[RowPitch] = []
    for one, _ in sorted([_refined(found, v, one) for one, v in tried[: TURNING.waves]], key=_rank):
        if all(_apart(one.pitch, other.pitch) > 1 + TURNING.apart * math.hypot(*one.pitch) for other in kept):
            kept.append(one)
    return kept


def _rank(tried: tuple[RowPitch, Floats]) -> tuple[int, tuple[float, float]]:
    return -tried[0].contrast, tried[0].pitch


def _apart(a: tuple[float, float], b: tuple[float, float]) -> float:
    return min(math.hypot(a[0] - b[0], a[1] - b[1]), math.hypot(a[0] + b[0], a[1] + b[1]))


def _refined(found: CorrelationMap, v: Floats, best: RowPitch) -> tuple[RowPitch, Floats]:
    """Turn the direction: first by half degrees, then by eighths of that."""
    turn = 0.0
    for step in (TURNING.turn, TURNING.turn / TURNING.finer):
        middle = turn
        for k in (*range(-TURNING.turns, 0), *range(1, TURNING.turns + 1)):  # 0 is known
            one = _turned(found, v, middle + k * step)
            if one is not None and one.contrast > best.contrast:
                best, turn = one, middle + k * step
    return best, v


def _turned(found: CorrelationMap, v: Floats, turn: float) -> RowPitch | None:
    """Find the best pitch about as long as v (1/256 px) across the direction v + turn * (v turned by 90 degrees)."""
    length = math.sqrt(float(v @ v)) / UNIT
    y, x = v[0] - turn * v[1], v[1] + turn * v[0]
    norm = math.sqrt(y * y + x * x)
    direction = np.rint(np.array([y, x]) * 65536 / norm).astype(np.int64)
    high, wide = found.values.shape[0] // 2, found.values.shape[1] // 2
    n = 2 * int((high * abs(direction[0]) + wide * abs(direction[1])) >> 16)  # a line for every half px
    mean, mass = np.empty(n, np.int64), np.empty(n, np.int64)
    course_profile(found.values, found.weights, direction, mean, mass)
    stretched = 1 + np.arange(-TURNING.stretch, TURNING.stretch + 1) / TURNING.step
    lengths = np.rint(2 * UNIT * length * stretched).astype(np.int64)
    contrasts = np.empty(len(lengths), np.int64)
    pitch_contrasts(mean, mass, lengths, contrasts)
    k = int(np.argmax(contrasts))
    pitch, residual, lines = _fit(mean, mass, float(lengths[k]) / (2 * UNIT))
    if lines < 1 or contrasts[k] <= 0:
        return None
    return RowPitch((float(pitch * y / norm), float(pitch * x / norm)), int(contrasts[k]), lines, residual)


def _fit(mean: Int64, mass: Int64, pitch: float) -> tuple[float, float, int]:
    """Fit the pitch to the peaks of the profile near its multiples: pitch, rms residual (px), lines seen."""
    top, bottom, found, lines = 0.0, 0.0, [], 0
    k = 1
    while 2 * k * pitch < len(mean) - 2:
        at = 2 * k * pitch
        if mass[round(at)] <= 0:
            break
        lines = k
        reach = max(TURNING.least, int(TURNING.reach * pitch))
        low = max(1, round(at) - reach)
        window = mean[low : min(len(mean) - 1, round(at) + reach + 1)]
        i = low + int(np.argmax(window))
        before, here, after = (float(m) for m in mean[i - 1 : i + 2])
        if here >= max(before, after) and here > 0 and mass[i + 1] > 0:
            peak = (i + top_of(before, here, after)) / 2
            weight = here * float(mass[i])
            top += weight * k * peak
            bottom += weight * k * k
            found.append((weight, k, peak))
        k += 1
    if bottom <= 0:
        return pitch, 0.0, lines
    exact = top / bottom
    if abs(exact - pitch) > TURNING.drift * pitch:
        return pitch, 0.0, lines
    square = sum(w * (p - k * exact) ** 2 for w, k, p in found) / sum(w for w, _, _ in found)
    return exact, math.sqrt(square), lines
