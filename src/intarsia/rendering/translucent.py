"""Mixing colours with opacity: premultiplied, so that what is invisible never tints what is seen.

Colour = sum w a C / sum w a, opacity = sum w a / sum w; where every voter is wholly transparent the colours
mix plainly. Keeping the contrast applies to the colours; opacity is always the mean.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..image import Array
from .colour import Curve
from .mix_kernels import LIMB, vote_alpha, vote_alpha_float
from .mixing import Spread, Weights, blocks, cell_shape, rounded_codes, rounded_light, squares_for
from .vote_kernels import VotedExemplars, Voters


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
        self, limbs: tuple[NDArray[np.int64], NDArray[np.int64]], opaque: NDArray[np.int64], weight: Weights,
        squares: NDArray[np.float64],
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
