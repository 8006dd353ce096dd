"""Planes as whole numbers: stretched to the range of all exemplars, weighted, at the size of the base plane.

All steps are integer arithmetic, or single IEEE operations.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import ParameterError
from ..exemplar import Exemplar
from ..image import Kind, Plane
from ..rendering.colour import code_values
from .ranges import ends
from .reduction import block_sums
from .variance import spreads

RANGE = 1023
LUMINANCE = (0.30, 0.59, 0.11)  # weights of red, green and blue (Robinson 2004)
MAX_LABELS = 16
FARTHEST = 256 * RANGE  # black lies at most so far from the exemplar's own range: sums of its squares stay whole

Int32 = NDArray[np.int32]


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
    values: list[Int32], exemplars: Sequence[Exemplar], plane: Plane, zero: int
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


def variance_of(values: list[Int32], exemplars: Sequence[Exemplar]) -> float:
    """Sum of the channels' variances; integer sums, so the same on every machine."""
    used = [
        v.reshape(-1, v.shape[2]) if e.usable is None else v[e.usable] for v, e in zip(values, exemplars, strict=True)
    ]
    flat = np.concatenate(used)
    return float(sum(spreads(flat))) / len(flat) ** 2
