"""Blending of the votes of several pieces into one pixel: integers, floats, normal maps and labels.

A mixer belongs to one plane of all exemplars. Its methods: `vote` returns the codes of a cell and, for every pixel, the
weight of all votes (0: no votes, the code is undefined); `read` returns those of interpolated pixels, where pieces are
rotated, scaled or warped; `average` averages blocks of s x s px, for planes that are smaller than the map.

Colours with opacity are premultiplied, so that transparent pixels do not tint opaque ones: colour = sum w a C /
sum w a, opacity = sum w a / sum w; where every vote is wholly transparent the colours are blended without opacity.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..foundation import lazy
from ..foundation.arrays import Array, Int32, Int64, Pair
from ..foundation.arrays import Floats as Float64
from ..foundation.blend import Blend
from ..foundation.geometry import ISOMETRIES
from ..model.image import Kind, Plane
from . import Curve
from .vote_kernels import LIMB, Reach, VoteGroups, add_votes, encode_vectors, vote_label

if TYPE_CHECKING:
    from . import warped_kernels
    from .warped_kernels import Part
else:  # what few pictures use
    warped_kernels = lazy("intarsia.rendering.warped_kernels")

SLOTS = 1 << 20
"""About how many sums of votes for labels are kept at a time; limits memory, changes no result."""

SAMPLED = 1 << 18
"""About how many vectors of a normal map are sampled by `off_unit`."""


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
        """Return (channel, sign), (8, 3) each: in an isometry, component c becomes sign * old[channel].

        An output pixel p is a copy of the exemplar at u(p), with J = du/dp. A height h(u(p)) has by the chain rule the
        slope J^T times that of h; a normal holds the slope in x and y, so n_yx' = J^T n_yx, and n_z is kept. These are
        the picture's axes, x right and y down. If green points up it is -y, which changes the sign of components that
        move between red and green.
        """
        channel, sign = [], []
        for isometry in ISOMETRIES:
            (a, b), (c, d) = isometry.j
            channel.append((1, 0, 2) if isometry.swaps else (0, 1, 2))
            sign.append((b * self.cross, c * self.cross, 1) if isometry.swaps else (d, a, 1))
        return np.array(channel), np.array(sign)

    @property
    def cross(self) -> int:
        """The sign that a component gets when it moves between red and green."""
        return 1 if self.green_down else -1

    def vectors(self, codes: Array) -> Array:
        """Return codes as vectors, times the top of the range: int32 for integers, float64 for floats."""
        values = codes.astype(np.int32 if self.dtype.kind == "u" else np.float64)
        return values if self.signed else 2 * values - self.top

    def settled(
        self, samples: Array, first: Int64, total: Float64 | None = None, weight: Float64 | None = None
    ) -> Array:
        """Return the codes that :func:`encode_vectors` writes, (h, w, 3)."""
        half = samples.dtype == np.float16  # kernels have no half floats
        samples = samples.astype(np.float32) if half else samples
        out = np.empty((*first.shape, 3), np.float64 if half else samples.dtype)
        top = samples.dtype.type(self.top)
        encode_vectors(samples, self.turn(), first, top, self.signed, total, weight, out)
        return out.astype(self.dtype, copy=False)

    def turned(self, codes: Array, pose: NDArray[np.integer[Any]]) -> Array:
        """Return codes (h, w, 3) turned by the poses (h, w) of their pieces; only 1 - v of floats rounds."""
        if not pose.any():
            return codes
        return self.settled(codes.reshape(-1, 3), 8 * np.arange(pose.size).reshape(pose.shape) + pose)


def off_unit(plane: Plane) -> float:
    """Return the mean absolute difference of the length of a normal map's vectors from 1.

    About 0.02 in maps of 8 bits, 0.1 in reduced ones; 58 of 61 photographs have 0.17 or more. Large maps are sampled.
    """
    codes = plane.samples
    step = max(1, math.isqrt(codes.shape[0] * codes.shape[1] // SAMPLED))
    codes = codes[::step, ::step]
    coding = NormalCoding(codes.dtype, plane.is_float and bool((codes < 0).any()), False)
    vectors = coding.vectors(codes).astype(np.float64) / coding.top
    with np.errstate(invalid="ignore", over="ignore"):
        lengths = np.linalg.norm(vectors, axis=2)
    lengths = lengths[np.isfinite(lengths)]
    return float(np.abs(lengths - 1.0).mean()) if lengths.size else 0.0


_UPRIGHT = (np.tile(np.arange(64), (8, 1)), np.ones((8, 64), np.int64))


def room_for(shape: Pair, channels: int, kind: type) -> tuple[Array, Array]:
    """Return zeros for the sums of a cell: totals (h, w, C), and weights (h, w)."""
    return np.zeros((*shape, channels), kind), np.zeros(shape, kind)


def blocks(values: Array, s: int) -> Array:
    """Return (h, w, C) as blocks (h / s, w / s, s * s, C)."""
    h, w, c = values.shape
    return values.reshape(h // s, s, w // s, s, c).swapaxes(1, 2).reshape(h // s, w // s, s * s, c)


def limbs_of(light: Array) -> Array:
    """Return light (..., C) split into two limbs (..., 2 C), so that sums weighted by 16-bit opacity fit in 64 bits."""
    return np.concatenate([light >> LIMB, light & ((1 << LIMB) - 1)], axis=-1)


@dataclass(frozen=True)
class Colours:
    """Blending of colours, with or without opacity as the last channel, and of data."""

    samples: Array  # (N, C) codes
    curve: Curve

    @cached_property
    def light(self) -> Array:
        """The numbers that are blended, (N, C), int32 or floats."""
        light = self.curve.linear(self.samples)
        return light.astype(np.int32) if light.dtype.kind == "u" else light  # one integer type for kernels

    @property
    def colours(self) -> int:
        """Channels without opacity."""
        return int(self.samples.shape[-1]) - self.curve.alpha

    def read(self, part: Part, reach: Reach) -> Array:
        """Return the codes of the interpolated pixels of a cell."""
        away, first = np.empty((*part.which.shape, self.samples.shape[1])), np.empty(part.which.shape, np.int64)
        warped_kernels.read_light(part, reach, self.light, self.curve.alpha, first, away)
        return self._coded(first, away)

    def _coded(self, first: Int64, away: Array) -> Array:
        """Return the codes of the light of pixels `first` plus `away`; the pixels' own codes where `away` is 0."""
        return np.where(away == 0, self.samples[first], self.curve.code(self.light[first] + away))


class Integers(Colours):
    """Blending of 8 and 16 bit codes by sums of whole numbers, rounded once."""

    @cached_property
    def limbs(self) -> Array:
        """The light of the colours, in two limbs."""
        return limbs_of(self.light[:, :-1])

    def vote(self, plan: VoteGroups, reach: Reach) -> tuple[Array, Array]:
        """Return the codes of a cell, and the weight of all votes of every pixel."""
        plain = room_for(plan.shape, self.colours, np.int64)
        add_votes((plan, reach), self.samples, self.curve.table, None, _UPRIGHT, None, plain)
        codes = self._rounded(*plain)
        if self.curve.alpha:
            seen = room_for(plan.shape, 2 * self.colours, np.int64)
            add_votes((plan, reach), self.limbs, None, self.samples[:, -1], _UPRIGHT, None, seen)
            codes = self._seen(codes, plain[1], self._rounded(*seen), seen[1])
        return codes, plain[1]

    def average(self, codes: Array, s: int) -> Array:
        """Return codes (h, w, C) averaged in blocks of s x s px."""
        light = blocks(self.curve.linear(codes).astype(np.int64), s)
        light, alpha = light[..., : self.colours], light[..., self.colours :]
        weight = np.full(light.shape[:2], s * s)
        mean = self._rounded(light.sum(axis=2), weight)
        if not self.curve.alpha:
            return mean
        opaque = alpha.sum(axis=(2, 3))
        seen = self._rounded((limbs_of(light) * alpha).sum(axis=2), opaque)
        return self._seen(mean, weight, seen, opaque)

    def _seen(self, plain: Array, weight: Int64, seen: Array, opaque: Int64) -> Array:
        """Return colours with opacity; where the opacity is 0, the colours blended without it."""
        weight = np.maximum(weight, 1)
        alpha = ((2 * opaque + weight) // (2 * weight)).astype(plain.dtype)
        return np.concatenate([np.where((opaque > 0)[..., None], seen, plain), alpha[..., None]], axis=2)

    def _rounded(self, total: Int64, weight: Int64) -> Array:
        """Return sums of light, or of its limbs, divided by weights, as codes."""
        if total.shape[2] == self.colours:
            return self.curve.divided(total, weight)
        share, (high, low) = np.maximum(weight, 1)[..., None], np.split(total, 2, axis=2)
        whole, rest = np.divmod(high + (low >> LIMB), share)
        rest = (rest << LIMB) + (low & ((1 << LIMB) - 1))
        # The code table rounds; without a curve, round half up here.
        total = (whole << LIMB) + (rest // share if self.curve.srgb else (2 * rest + share) // (2 * share))
        return self.curve.divided(total, np.ones_like(weight))


class Floats(Colours):
    """Blending in float64; where all votes agree, an exact copy."""

    def vote(self, plan: VoteGroups, reach: Reach) -> tuple[Array, Array]:
        """Return the codes of a cell, and the weight of all votes of every pixel."""
        codes, weight = self._mixed(plan, reach, None)
        if self.curve.alpha:
            seen, opaque = self._mixed(plan, reach, self.light[:, -1])
            codes[..., :-1] = np.where((opaque > 0)[..., None], seen[..., :-1], codes[..., :-1])
        return codes, weight

    def _mixed(self, plan: VoteGroups, reach: Reach, opacity: Array | None) -> tuple[Array, Array]:
        first = np.full(plan.shape, -1)
        total, weight = sums = room_for(plan.shape, self.samples.shape[1], np.float64)
        turn = _UPRIGHT
        if self.curve.alpha:  # differences of single floats are single ones, without opacity double ones
            turn = turn[0], turn[1].astype(self.light.dtype)
        add_votes((plan, reach), self.light, None, opacity, turn, first, sums)
        away = total / np.where(weight > 0, weight, 1.0)[..., None]
        return self._coded(np.maximum(first >> 3, 0), away), weight

    def average(self, codes: Array, s: int) -> Array:
        """Return codes (h, w, C) averaged in blocks of s x s px; blocks of equal codes are exact."""
        block, light = blocks(codes, s), blocks(self.curve.linear(codes).astype(np.float64), s)
        alike = np.ones_like(light[..., :1])
        mean, _ = self._averaged(block, light, alike)
        if self.curve.alpha:
            seen, opaque = self._averaged(block, light, np.maximum(light[..., -1:], 0.0))
            mean[..., :-1] = np.where((opaque > 0)[..., None], seen[..., :-1], mean[..., :-1])
            mean[..., -1:], _ = self._averaged(block[..., -1:], light[..., -1:], alike)  # rounded as a single channel
        return mean

    def _averaged(self, block: Array, light: Array, share: Array) -> tuple[Array, Array]:
        pick = np.argmax(share > 0, axis=2)[:, :, None]  # the first that is not transparent
        code, base = (np.take_along_axis(a, pick, axis=2)[:, :, 0] for a in (block, light))
        weight = share.sum(axis=(2, 3))
        away = ((light - base[:, :, None]) * share).sum(axis=2) / np.where(weight > 0, weight, 1.0)[..., None]
        return np.where(away == 0, code, self.curve.code(base + away)), weight


@dataclass(frozen=True)
class Normals:
    """Blending of normals: turned with their piece, averaged, normalised; where all agree, an exact copy."""

    samples: Array  # (N, 3) codes
    light: Array  # (N, 3) vectors
    coding: NormalCoding

    def vote(self, plan: VoteGroups, reach: Reach) -> tuple[Array, Array]:
        """Return the codes of a cell, and the weight of all votes of every pixel; 0 where vectors cancel."""
        first = np.full(plan.shape, -1)
        total, weight = sums = room_for(plan.shape, 3, np.float64)
        add_votes((plan, reach), self.light, None, None, self.coding.turn(), first, sums)
        return self.coding.settled(self.samples, first, total, weight), weight

    def read(self, part: Part, reach: Reach) -> Array:
        """Return the codes of the interpolated pixels of a cell."""
        vector, first = np.empty((*part.which.shape, 3)), np.empty(part.which.shape, np.int64)
        warped_kernels.read_vectors(part, reach, self.light, self.coding.cross, first, vector)
        return self.coding.settled(self.samples, first, vector)

    def average(self, codes: Array, s: int) -> Array:
        """Return codes (h, w, 3) averaged in blocks of s x s px, made unit length; blocks of equal ones are exact."""
        vectors = blocks(self.coding.vectors(codes), s).astype(np.float64)
        vector = vectors.sum(axis=2)
        vector[(vectors == vectors[:, :, :1]).all(axis=(2, 3))] = 0.0  # an exact copy
        first = 8 * np.arange(vector.size // 3).reshape(vector.shape[:2])
        leading = blocks(codes, s)[:, :, 0].reshape(-1, 3)
        return self.coding.settled(leading, first, vector)


@dataclass(frozen=True)
class Labels:
    """Majority vote of labels: the label of the largest weight, of equals the smallest."""

    ranks: Int32  # (N,): index of a pixel's label among all labels in order
    names: Array  # (K, C): the labels in order

    @classmethod
    def of(cls, samples: Array) -> Labels:
        """Return the mixer of pixels (N, C), whose labels are numbered; several channels are one label."""
        names, ranks = np.unique(samples[:, 0] if samples.shape[1] == 1 else samples, axis=0, return_inverse=True)
        return cls(ranks.reshape(-1).astype(np.int32), names.reshape(-1, samples.shape[1]))

    def vote(self, plan: VoteGroups, reach: Reach) -> tuple[Array, Array]:
        """Return the labels of a cell, and the weight of all votes of every pixel."""
        out, weight = np.zeros(plan.shape, np.int32), np.zeros(plan.shape, np.int64)
        (height, width), room = plan.shape, min(len(self.names), (plan.feather + 1) ** 2)
        rows = max(SLOTS // (width * room), 1)
        for begin in range(0, height, rows):
            size = (min(rows, height - begin), width, room)
            label, share = np.zeros(size, np.int32), np.zeros(size, np.int64)
            vote_label(plan, reach, self.ranks, begin, (label, share), weight[begin : begin + rows])
            out[begin : begin + rows] = label[..., 0]
        return self.names[out], weight

    def read(self, part: Part, reach: Reach) -> Array:
        """Return the labels of the interpolated pixels of a cell."""
        out = np.empty(part.which.shape, np.int32)
        warped_kernels.read_labels(part, reach, self.ranks, out)
        return self.names[out]

    def average(self, codes: Array, s: int) -> Array:
        """Return the most frequent label of each block of s x s px, of equals the smallest."""
        own = Labels.of(codes.reshape(-1, codes.shape[2]))
        names, block = own.names, blocks(own.ranks.reshape(*codes.shape[:2], 1), s)[..., 0]
        votes = (block[..., None, :] == block[..., :, None]).sum(axis=2)  # number of equal labels in the block
        return np.asarray(names[np.where(votes == votes.max(axis=2, keepdims=True), block, len(names)).min(axis=2)])


Mixer = Integers | Floats | Normals | Labels
"""How the pixels of a plane are blended, by its kind and type."""


def mixer_of(planes: Sequence[Plane], samples: Array, blend: Blend) -> Mixer:
    """Return the mixer of one plane of all exemplars."""
    plane, dtype = planes[0], planes[0].pixels.dtype
    if plane.kind is Kind.NORMAL:
        signed = any(p.is_float and bool((p.pixels < 0).any()) for p in planes)
        coding = NormalCoding(dtype, signed, plane.meta.get("normals", "gl") == "dx")
        return Normals(samples, coding.vectors(samples), coding)
    if plane.kind is Kind.LABEL:
        return Labels.of(samples)
    return (Floats if plane.is_float else Integers)(samples, Curve.of(plane, blend.mixing))


def averaged(plane: Plane, n: int) -> Array:
    """Return blocks of n x n pixels as one each, by the kind of the plane."""
    mixer = mixer_of([plane], plane.samples[:1, 0], Blend())
    with np.errstate(invalid="ignore", over="ignore"):  # masked pixels may be NaN
        return mixer.average(plane.samples, n)
