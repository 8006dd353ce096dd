"""Planes as whole numbers: stretched to the range of all exemplars, weighted, at the size of the base plane.

Numbers have one unit for all exemplars, and what lies far off is cut: heights may be metres, millimetres or shares, and
hold a hole of -1e30, and what the rest looks like must still be seen. No 8-bit picture is ever cut, so that such a
picture and its floats give the same features (law 13). All steps are integer arithmetic, or single IEEE operations.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..arrays import Array, Int32, Mask, Pair
from ..errors import ParameterError
from ..exemplar import Exemplar, Exemplars, resized
from ..image import Kind, Plane
from ..rendering.colour import WHITE, Unit, code_shares, code_values, has_own_unit, inner_range
from .sums import block_sums, spreads

MOST_SPREAD = 256  # all values may span so many times what 998 of 1000 do; 8 bits cannot tell more apart


def counted(planes: Sequence[Plane], usable: Sequence[Mask | None]) -> tuple[list[Int32], int]:
    """Return planes of one name as whole numbers (H, W, C) that can be compared, and what 0 is in them.

    Floats are counted in units of their own size, taken from their usable pixels (masks are those of the base, and
    may be a multiple or fraction of a plane's size). Where they hold nothing but whole codes of 16 bits within 0 to 1,
    those are returned, as for integers.
    """
    if not any(map(has_own_unit, planes)):
        return [code_values(p) for p in planes], 0
    masks = [... if m is None else resized(m, (p.height, p.width)) for m, p in zip(usable, planes, strict=True)]
    colours = planes[0].channels - planes[0].alpha
    seen = [code_shares(p.samples[..., :colours])[m] for p, m in zip(planes, masks, strict=True)]
    if not any(s.size for s in seen):
        return [code_values(p) for p in planes], 0
    unit = Unit.of(np.concatenate([s.ravel() for s in seen]))
    if not unit.origin and -16 <= unit.exponent <= 0:
        codes = [WHITE.count(s) for s in seen]
        if all((unit.count(s) == c << unit.bits - unit.exponent).all() for s, c in zip(seen, codes, strict=True)):
            unit = WHITE
    return [code_values(p, unit) for p in planes], int(unit.count(np.zeros(1))[0])


def ends(values: Sequence[Array]) -> Pair:
    """Return least and greatest of whole numbers, or less where a few of them lie very far from the rest.

    Where they span over 256 times what is left without one of a thousand at either end, that range is returned,
    widened by itself on both sides.
    """
    low, high = min(int(v.min()) for v in values), max(int(v.max()) for v in values)
    if high - low <= MOST_SPREAD:
        return low, high
    least, most = map(int, inner_range(np.concatenate([v.ravel() for v in values])))
    within = most - least
    if 0 < within * MOST_SPREAD < high - low:
        return max(low, least - within), min(high, most + within)
    return low, high


RANGE = 1023
LUMINANCE = (0.30, 0.59, 0.11)  # weights of red, green and blue (Robinson 2004)
MAX_LABELS = 16
FARTHEST = 256 * RANGE  # black lies at most so far from the exemplar's own range: sums of its squares stay whole


def labels_of(planes: list[Plane]) -> Int32 | None:
    """The labels that occur, if they are few enough for a channel each."""
    if planes[0].kind is not Kind.LABEL or planes[0].channels > 1:
        return None
    names = np.unique(np.concatenate([np.unique(code_values(p)) for p in planes]))
    return names if len(names) <= MAX_LABELS else None


def values_of(codes: Int32, plane: Plane, labels: Int32 | None = None) -> Int32:
    """Code values of a plane, colour under transparency taken away, few labels as one channel each."""
    if labels is not None:
        return np.asarray(codes == labels, dtype=np.int32) * 65535
    if plane.alpha:
        alpha = codes[:, :, -1:].astype(np.int64)
        premultiplied = codes[:, :, :-1] * alpha // 65535
        return np.concatenate([premultiplied, alpha], axis=2).astype(np.int32)
    return codes


def at_base_size(values: Int32, exemplar: Exemplar) -> Int32:
    s = values.shape[0] // exemplar.height
    if s > 1:
        return np.asarray(block_sums(values, s) // (s * s), np.int32)
    s = exemplar.height // values.shape[0]
    return np.asarray(values.repeat(s, axis=0).repeat(s, axis=1), np.int32)


def stretched(
    values: list[Int32], exemplars: Exemplars, plane: Plane, zero: int
) -> tuple[list[Int32], Int32, bool]:
    """Stretch to 0 .. RANGE over all exemplars; normal maps to -RANGE/2 .. RANGE/2 around flat.

    Returns the pictures, what a pixel of value 0, counted as `zero`, becomes (1, 1, C), and True for a normal map.
    """
    black = np.zeros((1, 1, values[0].shape[2]), np.int32)
    usable = [v if e.usable is None else v[e.usable] for v, e in zip(values, exemplars, strict=True)]
    usable = [v for v in usable if v.size]
    low, high = min(int(v.min()) for v in usable), max(int(v.max()) for v in usable)
    if plane.kind is Kind.NORMAL:
        middle = 0 if low < 0 else 65535  # twice the value of a zero component
        span = 131070 if low < 0 else 65535
        twice = [2 * v.astype(np.int64) - middle for v in values]
        if plane.meta.get("normals") == "dx":  # as if green pointed up, which `posed` reckons with
            for v in twice:
                v[..., 1] *= -1
        signed = [np.asarray(v * RANGE // (2 * span), np.int32) for v in twice]
        return signed, black, True
    if plane.kind is not Kind.LABEL:
        low, high = ends(usable)
    span = max(high - low, 1)
    shifted = [np.clip(v, low, high).astype(np.int64) - low for v in values]
    if plane.kind is not Kind.LABEL:
        black += min(max(((zero - low) * 2 * RANGE + span) // (2 * span), -FARTHEST), FARTHEST)
    return [np.asarray((v * (2 * RANGE) + span) // (2 * span), np.int32) for v in shifted], black, False


def weighted(values: list[Int32], plane: Plane, weights: tuple[float, ...] | None) -> list[Int32]:
    if plane.kind is Kind.LABEL:
        return values
    factors = [math.sqrt(share) for share in channel_shares(plane, weights, values[0].shape[2])]
    return [np.stack([times(v[:, :, c], f) for c, f in enumerate(factors)], axis=2) for v in values]


def channel_shares(plane: Plane, weights: tuple[float, ...] | None, count: int) -> list[float]:
    """Return how much each of `count` channels of a base plane counts, 1 for those that count most.

    A single weight is that of all colours."""
    colours = plane.channels - plane.alpha
    if weights is None:
        weights = LUMINANCE if colours == 3 and plane.kind is Kind.COLOUR else (1.0,) * colours
    if len(weights) == 1:
        weights *= colours
    if len(weights) not in (colours, count):
        raise ParameterError(f"channel_weights: {len(weights)} numbers for {count} channels; give {colours} of them.")
    weights = (*weights, max(weights))[:count]
    return [w / max(weights) for w in weights]


def times(values: Int32, factor: float) -> Int32:
    scale = round(factor * 65536)
    return np.asarray((values.astype(np.int64) * scale + 32768) >> 16, dtype=np.int32)


def variance_of(values: list[Int32], exemplars: Exemplars) -> float:
    """Sum of the channels' variances; integer sums, so the same on every machine."""
    used = [
        v.reshape(-1, v.shape[2]) if e.usable is None else v[e.usable] for v, e in zip(values, exemplars, strict=True)
    ]
    flat = np.concatenate(used)
    return float(sum(spreads(flat))) / len(flat) ** 2
