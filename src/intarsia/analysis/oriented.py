"""How far every pixel lies from what has an outline: joints, cracks, edges of things; grain has none.

Along an outline the picture changes across one direction and not along it, and does so for a while. So long even and
odd filters are laid over it in many directions, and of the strongest answer only what exceeds the mean of all of them
counts: grain answers to all alike. Every pixel then is as far as the nearest outline, or farther where that is less
sure, and no threshold says what an outline is.

Source: our own, after oriented energy (Morrone and Owens 1987; Freeman and Adelson 1991) and the distance to features
as a channel to compare (Wu and Yu 2004; Lefebvre and Hoppe 2006, section 3). All decisions are in whole numbers.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from .reduction import block_sums, factor_for

DIRECTIONS = 12
ACROSS, ALONG = 1.8, 6.0  # px of a filter, in an exemplar of USUAL px
USUAL, LEAST = 256, 0.75  # filters grow with the exemplar, and never below three quarters
TAPS = 4096  # sum of what a filter multiplies by
SURE = 256  # an outline as sure as
RANKED = 0.93  # of all pixels, or more
AXES = ((11, 0, 1), (5, 6, 7))  # directions within 15 degrees of rows, and of columns
REACH = 0.07  # of the shorter side: what is farther from all outlines is as far
STRAIGHT, SLANTED = 5, 7  # a step of a px, and one to a corner, in fifths of a px

Array = NDArray[Any]


class Outlines(NamedTuple):
    """How filters answered in every pixel (H, W) of a picture, reduced `factor` times."""

    excess: NDArray[np.int64]  # by how much the strongest direction exceeds the mean of all
    mean: NDArray[np.int64]
    along: NDArray[np.int64]  # (2, H, W): the same of the directions close to rows, and to columns
    factor: int

    @property
    def share(self) -> float:
        """How much of all changes runs along outlines: the mean excess over the mean answer."""
        return int(self.excess.sum()) / max(int(self.mean.sum()), 1)

    def sure(self, excess: NDArray[np.int64]) -> NDArray[np.int64]:
        """Say how sure outlines of such an excess are: 0 to SURE."""
        ranked = np.sort(self.excess, axis=None)
        return np.minimum(SURE * excess // max(int(ranked[int(RANKED * (len(ranked) - 1))]), 1), SURE)


def outlines_of(picture: NDArray[np.int16], usable: NDArray[np.bool_] | None, toroidal: bool) -> Outlines:
    """Look for outlines in features (H, W, C), those of large exemplars on a reduced copy; none where nothing is."""
    factor = factor_for(picture.shape)
    small = picture if factor == 1 else np.asarray(block_sums(picture, factor) // factor**2, np.int16)
    most, along, mean = _answers(small, toroidal)
    if usable is not None:
        inside = _inside(usable if factor == 1 else block_sums(usable, factor) == factor * factor, toroidal)
        most, along, mean = most * inside, along * inside, mean * inside
    return Outlines(np.maximum(most - mean, 0), mean, np.maximum(along - mean, 0), factor)


def outline_distance(found: Outlines, shape: tuple[int, ...], toroidal: bool) -> NDArray[np.int32]:
    """Return how far the pixels of a picture of this shape lie from its outlines: (H, W), in fifths of a px.

    0 on the surest outlines, at most 7 % of the shorter side.
    """
    reach = max(1, round(REACH * min(found.excess.shape)))
    far = _nearest(STRAIGHT * reach * (SURE - found.sure(found.excess)) // SURE, reach, toroidal)
    return _enlarged(far.astype(np.int64) * found.factor, shape[:2], found.factor)


def _answers(picture: NDArray[np.int16], toroidal: bool) -> tuple[Array, Array, Array]:
    """How strongly the filters of all directions answer in every pixel: the most, along axes, and the mean; int64."""
    scale = max(min(picture.shape[:2]) / USUAL, LEAST)
    filters = [_filter(k, scale) for k in range(DIRECTIONS)]
    radius = filters[0].shape[0] // 2
    mode: Literal["wrap", "symmetric"] = "wrap" if toroidal else "symmetric"
    padded = np.pad(picture.astype(np.int64), ((radius, radius), (radius, radius), (0, 0)), mode)
    shape = tuple(fft.next_fast_len(n) for n in padded.shape[:2])
    (h, w), channels = picture.shape[:2], range(picture.shape[2])
    spectra = [fft.fft2(padded[..., c].astype(np.float64), shape) for c in channels]
    total, most, along = np.zeros((h, w), np.int64), np.zeros((h, w), np.int64), np.zeros((2, h, w), np.int64)
    for number, one in enumerate(filters):
        answers = fft.fft2(one, shape)
        squares = np.zeros((h, w))  # of whole numbers, far below 2**53
        for spectrum in spectra:
            columns = fft.ifft(spectrum * answers, axis=0, overwrite_x=True)[2 * radius : 2 * radius + h]
            found = fft.ifft(columns, axis=1, overwrite_x=True)[:, 2 * radius : 2 * radius + w]
            for part in (found.real, found.imag):
                whole = np.rint(part)
                whole *= whole
                squares += whole
        strength = np.sqrt(squares).astype(np.int64)
        total += strength
        np.maximum(most, strength, out=most)
        for axis, close in enumerate(AXES):
            if number in close:
                np.maximum(along[axis], strength, out=along[axis])
    return most, along, total // DIRECTIONS


def _filter(number: int, scale: float) -> NDArray[np.complex128]:
    """The odd filter of a direction, and times i the even one: whole numbers (2 r + 1, 2 r + 1) that add up to 0."""
    across, along = ACROSS * scale, ALONG * scale
    radius = math.ceil(3 * along)
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1].astype(np.float64)
    angle = math.pi * number / DIRECTIONS
    u, v = x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)
    bell = np.exp(-u * u / (2 * along * along) - v * v / (2 * across * across))
    odd, even = bell * v, bell * (v * v / (across * across) - 1)
    even -= bell * (even.sum() / bell.sum())
    taps = [np.rint(part * (TAPS / np.abs(part).sum())) for part in (odd, even)]
    for part in taps:
        part[radius, radius] -= part.sum()
    return np.asarray(taps[0] + 1j * taps[1])


def _inside(there: NDArray[np.bool_], toroidal: bool) -> NDArray[np.bool_]:
    """Which pixels have nothing unusable near, whose edge is none of the picture's."""
    near = 3
    out = ~there
    for axis in (0, 1):
        for _ in range(near):
            out = out | _shifted(out, axis, 1, toroidal, True) | _shifted(out, axis, -1, toroidal, True)
    return ~out


def _nearest(far: Array, steps: int, toroidal: bool) -> Array:
    """The least of `far` and what the pixels around have, a step farther for every px between."""
    most, far = int(far.max(initial=0)), far.astype(np.int32)
    for _ in range(steps):
        rows = [_shifted(far, 0, k, toroidal, most) for k in (1, -1)]
        straight = [*rows, *(_shifted(far, 1, k, toroidal, most) for k in (1, -1))]
        slanted = [_shifted(row, 1, k, toroidal, most) for row in rows for k in (1, -1)]
        nearer = np.minimum(np.minimum.reduce(straight) + STRAIGHT, np.minimum.reduce(slanted) + SLANTED)
        if not (nearer < far).any():
            break
        far = np.minimum(far, nearer)
    return far


def _shifted(values: Array, axis: int, by: int, toroidal: bool, beyond: Any) -> Array:
    out = np.roll(values, by, axis)
    if not toroidal:
        np.moveaxis(out, axis, 0)[0 if by > 0 else -1] = beyond
    return out


def _enlarged(values: Array, shape: tuple[int, ...], factor: int) -> NDArray[np.int32]:
    """Every value as a block, the last ones beyond."""
    if factor > 1:
        values = values.repeat(factor, axis=0).repeat(factor, axis=1)
        values = np.pad(values, [(0, n - m) for n, m in zip(shape, values.shape, strict=True)], "edge")
    return np.asarray(values, np.int32)
