"""How the votes of several pieces become one pixel: integers, floats, normals and labels.

A mixer belongs to one plane of all exemplars. It votes in one cell and returns the codes and, for every
pixel, the weight of all votes (0: nobody votes, the code means nothing). It also averages blocks, for planes
that are smaller than the map.

Colours with opacity are premultiplied, so that what is invisible never tints what is seen: colour = sum w a C /
sum w a, opacity = sum w a / sum w; where every voter is wholly transparent the colours mix plainly. Keeping the
contrast applies to the colours; opacity is always the mean.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from math import fsum
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array, Int32, Int64, Mask, Pair
from ..arrays import Floats as Float64
from ..blend import Mixing
from ..geometry import ISOMETRIES
from ..image import Kind, Plane
from .colour import Curve, code_shelf, code_steps
from .vote_kernels import (
    LIMB,
    VotedExemplars,
    Voters,
    settle_label,
    settle_plain,
    settle_vectors,
    turn_codes,
    vote_alpha,
    vote_alpha_float,
    vote_label,
    vote_plain,
    vote_relative,
)

SAMPLED = 1 << 18
"""Vectors of a map that are looked at, about."""


@dataclass(frozen=True)
class NormalCoding:
    """How a normal map stores its vectors.

    Parameters
    ----------
    dtype : numpy dtype
        Integers store (n + 1) / 2 of their range, so the opposite of a code v is max - v.
    signed : bool
        Floats only: True where they store n itself (-1..1), False for (n + 1) / 2.
    green_down : bool
        True where green points down the picture (``meta["normals"] == "dx"``); otherwise up ("gl").
    """

    dtype: np.dtype[Any]
    signed: bool
    green_down: bool

    @property
    def top(self) -> int:
        """The code of +1."""
        return int(np.iinfo(self.dtype).max) if self.dtype.kind == "u" else 1

    def turn(self) -> tuple[Int64, Int64]:
        """Return (channel, sign), (8, 3) each: laid with a pose, component c is sign * old[channel].

        An output pixel p shows the exemplar at u(p), with J = du/dp. A height h(u(p)) has by the chain rule the slope
        J^T times that of h; a normal holds the slope in x and y, so n_yx' = J^T n_yx, and n_z is kept. All this in the
        picture's axes, x right and y down. Where green points up it is -y, which changes the sign of whatever crosses
        from red to green and back.
        """
        channel = np.tile(np.arange(3), (8, 1))
        sign = np.ones((8, 3), dtype=np.int64)
        for pose, isometry in enumerate(ISOMETRIES):
            (a, b), (c, d) = isometry.j
            cross = 1 if self.green_down else -1
            if isometry.swaps:
                channel[pose, :2] = 1, 0
                sign[pose, :2] = b * cross, c * cross
            else:
                sign[pose, :2] = d, a
        return channel, sign

    def vectors(self, codes: Array) -> Array:
        """Return codes as vectors, times the top of the range: int32 for integers, float64 for floats."""
        if self.dtype.kind == "u":
            return 2 * codes.astype(np.int32) - self.top
        values = codes.astype(np.float64)
        return values if self.signed else 2.0 * values - 1.0

    def codes(self, unit: Float64) -> Array:
        """Return vectors of unit length as codes, rounded half up."""
        if self.signed:
            return unit.astype(self.dtype)
        share = (unit + 1.0) / 2.0
        if self.dtype.kind == "u":
            share = np.floor(np.clip(share, 0.0, 1.0) * self.top + 0.5)
        return share.astype(self.dtype)

    def of_length_1(self, vectors: Array, kept: Mask, codes: Array) -> Array:
        """Return the codes of vectors (h, w, 3) of any length; `codes` where these are `kept`, or the vector is 0."""
        v = vectors.astype(np.float64)
        length = np.sqrt((v[..., 0] * v[..., 0] + v[..., 1] * v[..., 1]) + v[..., 2] * v[..., 2])
        unit = v / np.where(length > 0, length, 1.0)[..., None]
        return np.where((kept | (length == 0))[..., None], codes, self.codes(unit))

    def turned(self, codes: Array, pose: NDArray[np.integer[Any]]) -> Array:
        """Return codes (h, w, 3) turned by the poses (h, w) of their pieces; only 1 - v of floats rounds."""
        if not pose.any():
            return codes
        channel, sign = self.turn()
        if self.dtype.kind == "u":
            turned = np.empty_like(codes)
            turn_codes(codes, pose, (channel, sign), self.top, turned)
            return turned
        out = np.take_along_axis(codes, channel[pose], axis=2)
        opposite = -out if self.signed else (1 - out).astype(self.dtype)
        return np.where(sign[pose] < 0, opposite, out)


def off_unit(plane: Plane) -> float:
    """Return by how much the vectors of a normal map differ from length 1, on average.

    0.02 in maps of 8 bits, 0.1 where these were reduced; 58 of 61 photographs have 0.17 and more. Of large maps every
    few pixels are looked at.
    """
    codes = plane.samples
    step = max(1, math.isqrt(codes.shape[0] * codes.shape[1] // SAMPLED))
    codes = codes[::step, ::step]
    coding = NormalCoding(codes.dtype, plane.is_float and bool((codes < 0).any()), False)
    vectors = coding.vectors(codes).astype(np.float64) / coding.top
    with np.errstate(invalid="ignore", over="ignore"):
        lengths = np.sqrt((vectors * vectors).sum(axis=2))
    lengths = lengths[np.isfinite(lengths)]
    return float(np.abs(lengths - 1.0).mean()) if lengths.size else 0.0


Weights = Int64


class Mixer(Protocol):
    """What a plane needs to be rendered with a feather."""

    def vote(self, plan: Voters, ground: VotedExemplars) -> tuple[Array, Weights]:
        """Return codes (h, w, C) of a cell, and the weights (h, w)."""

    def average(self, codes: Array, s: int) -> Array:
        """Return blocks of s x s pixels of codes (h, w, C) as one each."""


@dataclass(frozen=True)
class Spread:
    """The mean and the range of an exemplar's channels, as light: what keeping the contrast refers to."""

    mean: Float64
    low: Float64
    high: Float64

    @classmethod
    def of(cls, light: Array, share: Array | None = None) -> Spread:
        """Measure pixels (N, C), each counting by its `share`; the mean of equal pixels is that pixel."""
        base = light[0].astype(np.float64)
        away = light - base
        if share is None or not share.any():
            share = np.ones(len(light))
        count = fsum(share)
        mean = base + np.array([fsum(away[:, c] * share) / count for c in range(light.shape[1])])
        return cls(mean, light.min(axis=0).astype(np.float64), light.max(axis=0).astype(np.float64))

    def widen(self, mean: Float64, weight: Array, squares: Float64) -> Float64:
        """Push means away from the overall mean by sum w / sqrt(sum w^2), not beyond the exemplar's range."""
        gain = np.maximum(weight, 1e-300) / np.sqrt(np.where(squares > 0, squares, 1.0))
        return np.clip(self.mean + (mean - self.mean) * gain[..., None], self.low, self.high)


def cell_shape(plan: Voters) -> Pair:
    """Return the height and width of the cell that a plan is for."""
    return plan.labels.shape[0] - plan.feather, plan.labels.shape[1] - plan.feather


def squares_for(spread: Spread | None, shape: Pair) -> Float64:
    """Make room for sums of squared weights, where they are needed."""
    return np.zeros(shape if spread else (0, 0))


def blocks(values: Array, s: int) -> Array:
    """Return (h, w, C) as blocks (h / s, w / s, s * s, C)."""
    h, w, c = values.shape
    return values.reshape(h // s, s, w // s, s, c).swapaxes(1, 2).reshape(h // s, w // s, s * s, c)


@dataclass(frozen=True)
class Integers:
    """8- and 16-bit colour without opacity, and data: whole sums, rounded once."""

    samples: Array  # (N, C) codes
    curve: Curve
    spread: Spread | None

    def vote(self, plan: Voters, ground: VotedExemplars) -> tuple[Array, Weights]:
        shape = cell_shape(plan)
        total = np.zeros((*shape, self.samples.shape[1]), np.int64)
        weight, squares = np.zeros(shape, np.int64), squares_for(self.spread, shape)
        vote_plain(plan, ground, self.samples, self.curve.table, total, weight, squares)
        if self.spread is None:
            return rounded_codes(total, weight, self.curve), weight
        mean = total / np.maximum(weight, 1)[..., None]
        return rounded_light(self.spread.widen(mean, weight, squares), self.curve), weight

    def average(self, codes: Array, s: int) -> Array:
        total = blocks(self.curve.linear(codes).astype(np.int64), s).sum(axis=2)
        return rounded_codes(total, np.full(total.shape[:2], s * s, np.int64), self.curve)


def rounded_codes(total: Int64, weight: Weights, curve: Curve) -> Array:
    """Return total / weight as codes, rounded once, half up."""
    codes = np.zeros(total.shape, curve.dtype)
    steps, shelf, shift = np.zeros(0, np.int32), np.zeros(0, np.int32), 0
    if curve.srgb:
        steps = code_steps(curve.dtype.itemsize)
        shelf, shift = code_shelf(curve.dtype.itemsize)
    settle_plain(total, weight, steps, shelf, shift, codes)
    return codes


def rounded_light(light: Float64, curve: Curve) -> Array:
    """Return light that is no ratio of whole numbers as codes."""
    whole = np.floor(light if curve.srgb else light + 0.5).astype(np.int64)
    return rounded_codes(whole, np.ones(whole.shape[:2], np.int64), curve)


_UPRIGHT = np.ones((8, 64), np.int64)
_IN_PLACE = np.tile(np.arange(64), (8, 1))


@dataclass(frozen=True)
class Floats:
    """Float colour without opacity, and data: sums in float64, where all agree an exact copy."""

    samples: Array  # (N, C) codes
    light: Array  # (N, C)
    curve: Curve
    spread: Spread | None

    def vote(self, plan: Voters, ground: VotedExemplars) -> tuple[Array, Weights]:
        shape = cell_shape(plan)
        total = np.zeros((*shape, self.samples.shape[1]))
        first, weight, squares = (np.full(shape, -1), np.zeros(shape, np.int64), squares_for(self.spread, shape))
        vote_relative(plan, ground, self.light, (_IN_PLACE, _UPRIGHT), total, first, weight, squares)
        base = np.maximum(first >> 3, 0)
        light, codes = self.light[base], self.samples[base]
        mean = light + total / np.maximum(weight, 1)[..., None]
        same = total == 0
        if self.spread:
            alone = squares == weight.astype(np.float64) ** 2
            mean = self.spread.widen(mean, weight, squares)
            same = alone[..., None] | (mean == light)
        return np.where(same, codes, self.curve.code(mean)), weight

    def average(self, codes: Array, s: int) -> Array:
        block = blocks(codes, s)
        light = blocks(self.curve.linear(codes).astype(np.float64), s)
        away = (light - light[:, :, :1]).sum(axis=2)
        return np.where(away == 0, block[:, :, 0], self.curve.code(light[:, :, 0] + away / (s * s)))


@dataclass(frozen=True)
class TranslucentIntegers:
    """8- and 16-bit colour with opacity last: whole sums, rounded once."""

    samples: Array  # (N, C) codes
    curve: Curve
    spread: Spread | None

    def vote(self, plan: Voters, ground: VotedExemplars) -> tuple[Array, Weights]:
        shape = cell_shape(plan)
        colours = (*shape, self.samples.shape[1] - 1)
        limbs = (np.zeros(colours, np.int64), np.zeros(colours, np.int64))
        opaque, weight = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
        squares = squares_for(self.spread, shape)
        vote_alpha(plan, ground, self.samples, self.curve.table, limbs, opaque, weight, squares)
        return self._resolved(limbs, opaque, weight, squares), weight

    def average(self, codes: Array, s: int) -> Array:
        light = blocks(self.curve.linear(codes).astype(np.int64), s)
        alpha = light[..., -1:]
        share = np.where((alpha > 0).any(axis=2, keepdims=True), alpha, 1)
        colours = light[..., :-1]
        limbs = ((share * (colours >> LIMB)).sum(axis=2), (share * (colours & ((1 << LIMB) - 1))).sum(axis=2))
        weight = np.full(alpha.shape[:2], s * s, np.int64)
        return self._resolved(limbs, alpha[..., 0].sum(axis=2), weight, np.zeros((0, 0)))

    def _resolved(
        self, limbs: tuple[Int64, Int64], opaque: Int64, weight: Weights,
        squares: Float64,
    ) -> Array:  # fmt: skip
        shared = np.maximum(np.where(opaque > 0, opaque, weight), 1)
        share = shared[..., None]
        high, low = limbs[0] + (limbs[1] >> LIMB), limbs[1] & ((1 << LIMB) - 1)
        whole, rest = high // share, ((high % share) << LIMB) + low
        codes = np.empty((*weight.shape, self.samples.shape[1]), self.curve.dtype)
        if squares.size and self.spread:
            mean = whole * float(1 << LIMB) + rest / share
            codes[..., :-1] = rounded_light(self.spread.widen(mean, shared, squares), self.curve)
        else:  # the steps of the curve round; without a curve, round half up here
            last = rest // share if self.curve.srgb else (2 * rest + share) // (2 * share)
            codes[..., :-1] = rounded_codes((whole << LIMB) + last, np.ones_like(weight), self.curve)
        codes[..., -1] = (2 * opaque + np.maximum(weight, 1)) // (2 * np.maximum(weight, 1))
        return codes


@dataclass(frozen=True)
class TranslucentFloats:
    """Float colour with opacity last: sums in float64, where all agree an exact copy."""

    samples: Array  # (N, C) codes
    light: Array  # (N, C)
    curve: Curve
    spread: Spread | None

    def vote(self, plan: Voters, ground: VotedExemplars) -> tuple[Array, Weights]:
        shape = cell_shape(plan)
        total, first = np.zeros((*shape, self.samples.shape[1])), np.zeros((*shape, 2), np.int64)
        opaque, weight = np.zeros(shape), np.zeros(shape, np.int64)
        squares = squares_for(self.spread, shape)
        vote_alpha_float(plan, ground, self.light, total, first, opaque, weight, squares)
        shared = np.where(opaque > 0, opaque, np.maximum(weight, 1))
        codes, light = self.samples[first[..., 0]], self.light[first[..., 0]].astype(np.float64)
        codes[..., -1], light[..., -1] = self.samples[first[..., 1], -1], self.light[first[..., 1], -1]
        mean = light + total / shared[..., None]
        mean[..., -1] = light[..., -1] + total[..., -1] / np.maximum(weight, 1)
        same = total == 0
        if self.spread:
            mean[..., :-1] = self.spread.widen(mean[..., :-1], shared, squares)
            alone = squares == shared * shared
            same[..., :-1] = alone[..., None] | (mean == light)[..., :-1]
        return np.where(same, codes, self.curve.code(mean)), weight

    def average(self, codes: Array, s: int) -> Array:
        light = blocks(self.curve.linear(codes).astype(np.float64), s)
        alpha = np.maximum(light[..., -1:], 0.0)
        share = np.where((alpha > 0).any(axis=2, keepdims=True), alpha, 1.0)
        pick = np.argmax(share > 0, axis=2)[:, :, None]  # the first that is seen
        base, code = (np.take_along_axis(a, pick, axis=2)[:, :, 0] for a in (light, blocks(codes, s)))
        away = ((light - base[:, :, None]) * share).sum(axis=2) / share.sum(axis=2)
        base[..., -1] = light[:, :, 0, -1]
        code[..., -1] = blocks(codes, s)[:, :, 0, -1]
        away[..., -1] = (light[..., -1] - base[:, :, None, -1]).sum(axis=2) / (s * s)
        return np.where(away == 0, code, self.curve.code(base + away))


@dataclass(frozen=True)
class Normals:
    """Vectors: turned with their piece, mixed, made unit length again; where all agree an exact copy."""

    samples: Array  # (N, 3) codes
    light: Array  # (N, 3) vectors
    coding: NormalCoding

    def vote(self, plan: Voters, ground: VotedExemplars) -> tuple[Array, Weights]:
        shape = cell_shape(plan)
        turn = self.coding.turn()
        total = np.zeros((*shape, 3), np.int64 if self.light.dtype.kind == "i" else np.float64)
        first, weight = np.full(shape, -1), np.zeros(shape, np.int64)
        vote_relative(plan, ground, self.light, turn, total, first, weight, squares_for(None, shape))
        if self.coding.dtype.kind == "u":
            codes = np.zeros((*shape, 3), self.coding.dtype)
            settle_vectors(self.samples, turn, total, first, weight, self.coding.top, codes)
            return codes, weight
        first = np.maximum(first, 0)
        codes = self.coding.turned(self.samples[first >> 3], first & 7)
        channel, sign = turn  # 1 - v may round; what was added up did not
        base = np.take_along_axis(self.light[first >> 3], channel[first & 7], axis=2) * sign[first & 7]
        vector = base * weight[..., None] + total
        weight[~vector.any(axis=2)] = 0  # opposite votes cancel: the own pixel decides
        return self.coding.of_length_1(vector, (total == 0).all(axis=2), codes), weight

    def average(self, codes: Array, s: int) -> Array:
        vectors = blocks(self.coding.vectors(codes), s).astype(
            np.int64 if self.coding.dtype.kind == "u" else np.float64
        )
        vector = vectors.sum(axis=2)
        same = (vectors == vectors[:, :, :1]).all(axis=(2, 3)) | ~vector.any(axis=2)
        return self.coding.of_length_1(vector, same, blocks(codes, s)[:, :, 0])


@dataclass(frozen=True)
class LabelMixer:
    """Names: the label with the largest weight, the smallest of equals."""

    ranks: Int32  # (N,): place of a pixel's label among all labels in order
    names: Array  # (K, C)

    @classmethod
    def of(cls, samples: Array) -> LabelMixer:
        """Number the labels of pixels (N, C); several channels are one name."""
        names, ranks = np.unique(samples[:, 0] if samples.shape[1] == 1 else samples, axis=0, return_inverse=True)
        return cls(ranks.reshape(-1).astype(np.int32), names.reshape(-1, samples.shape[1]))

    def vote(self, plan: Voters, ground: VotedExemplars) -> tuple[Array, Weights]:
        shape = cell_shape(plan)
        out, weight = np.zeros(shape, np.int32), np.zeros(shape, np.int64)
        todo = [(0, shape[0], 4)]
        while todo:  # few pixels hear more than four labels; where they do, take fewer rows with more room
            begin, end, room = todo.pop()
            slots = (
                np.zeros((end - begin, shape[1], room), np.int32), np.zeros((end - begin, shape[1], room), np.int64)
            )
            if vote_label(plan, ground, self.ranks, begin, end, slots):
                settle_label(*slots, out[begin:end], weight[begin:end])
            elif end - begin == 1:
                todo.append((begin, end, 2 * room))
            else:
                middle = (begin + end) // 2
                todo += [(begin, middle, 2 * room), (middle, end, 2 * room)]
        return self.names[out], weight

    def average(self, codes: Array, s: int) -> Array:
        names, ranks = np.unique(codes.reshape(-1, codes.shape[2]), axis=0, return_inverse=True)
        block = blocks(ranks.reshape(*codes.shape[:2], 1), s)[..., 0]
        votes = (block[..., None, :] == block[..., :, None]).sum(axis=2)  # how many of the block agree with each
        best = np.where(votes == votes.max(axis=2, keepdims=True), block, len(names)).min(axis=2)
        chosen: Array = names[best]
        return chosen


def coding_of(planes: Sequence[Plane]) -> NormalCoding | None:
    """Tell how the vectors of one plane of all exemplars are coded; None where it holds none."""
    if planes[0].kind is not Kind.NORMAL:
        return None
    signed = any(p.is_float and bool((p.pixels < 0).any()) for p in planes)
    return NormalCoding(planes[0].pixels.dtype, signed, planes[0].meta.get("normals", "gl") == "dx")


def mixer_of(
    plane: Plane, samples: Array, coding: NormalCoding | None, curve: Curve, mixing: Mixing,
    usable: Mask | None,
) -> Mixer:  # fmt: skip
    """Choose how the votes for a plane become one pixel; `usable` says which samples count for its contrast."""
    if coding is not None:
        return Normals(samples, coding.vectors(samples), coding)
    if plane.kind is Kind.LABEL:
        return LabelMixer.of(samples)
    light = curve.linear(samples) if plane.is_float else samples
    spread = None
    if mixing is Mixing.VARIANCE:
        seen = slice(None) if usable is None else np.flatnonzero(usable)
        values = curve.linear(samples[seen])
        spread = Spread.of(values[:, :-1], values[:, -1]) if plane.alpha else Spread.of(values)
    if plane.is_float:
        return (TranslucentFloats if plane.alpha else Floats)(samples, light, curve, spread)
    return (TranslucentIntegers if plane.alpha else Integers)(samples, curve, spread)


def averaged(plane: Plane, n: int) -> Array:
    """Return blocks of n x n pixels as one each, by the kind of the plane."""
    mixer = mixer_of(plane, plane.samples[:1, 0], coding_of([plane]), Curve.of(plane), Mixing.MEAN, None)
    with np.errstate(invalid="ignore", over="ignore"):  # masked pixels may be NaN
        return mixer.average(plane.samples, n)
