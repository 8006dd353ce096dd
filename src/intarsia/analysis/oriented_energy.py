"""Oriented energy of exemplars: distance to outlines (joints, cracks, edges), and the lines between courses.

At an outline the picture changes across one direction and is constant along it, over some length. Elongated even and
odd filters are therefore applied in 12 directions; the response of a direction is the root of the sum of their squared
outputs over all channels (oriented energy). The measure of an outline is the excess of the strongest response over the
mean of all directions, as grain responds equally to all. Its sureness is the excess relative to a high quantile of the
picture, 0 to 1. The distance to outlines used for matching starts from higher values at less sure ones, so there is no
threshold for outlines.

Source: our own, after oriented energy (Morrone and Owens 1987; Freeman and Adelson 1991) and the distance to features
as a channel to compare (Wu and Yu 2004; Lefebvre and Hoppe 2006, section 3). All decisions are in whole numbers.

Lines between courses (of stones, boards or tiles) run from one side of an exemplar to the other. The path with the
highest sum of sureness of outlines close to its direction is found by dynamic programming, like seams (Efros and
Freeman 2001), then the next at a least distance from the first, and so on. The exemplar has courses if such lines cover
all of it, and outlines of their direction lie on them rather than between them: those of wood, bark and cloth do not.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from ..foundation.arrays import Array, Int16, Int32, Int64, Mask
from ..foundation.filters import fast_length, lowest
from ..kernels import shortest_paths
from . import block_sums, enlarged, factor_for

DIRECTIONS = 12  # of a half circle, 15 degrees each
ACROSS, ALONG = 1.8, 6.0  # px: sigmas of a filter across and along its direction, in an exemplar of USUAL px
USUAL, LEAST = 256, 0.75  # px of the shorter side at which the scale of filters is 1; smallest scale
TAPS = 4096  # sum of the absolute values of a filter, about
SURE = 256  # sureness 1, of outlines whose excess is at the quantile RANKED or above
RANKED = 0.93  # quantile of the excess over all pixels
AXES = ((11, 0, 1), (5, 6, 7))  # directions within 15 degrees of rows, and of columns
REACH = 0.07  # greatest distance to an outline, relative to the shorter side
STRAIGHT, SLANTED = 5, 7  # fifths of a px: length of a step along an axis, and of a diagonal one


class Outlines(NamedTuple):
    """Responses of the filters in every pixel (H, W) of a picture, reduced by `factor`."""

    excess: Int64  # of the strongest response over the mean of all directions, at least 0
    mean: Int64  # response, over all directions
    along: Int64  # (2, H, W): the excess of the strongest direction close to rows, and close to columns
    factor: int

    @property
    def share(self) -> float:
        """The share of outlines in all changes: the sum of the excess over the sum of the mean response."""
        return int(self.excess.sum()) / max(int(self.mean.sum()), 1)

    def sure(self, excess: Int64) -> Int64:
        """Return the sureness, 0 to SURE, for values of the excess, relative to the quantile RANKED of this picture."""
        ranked = np.sort(self.excess, axis=None)
        return np.minimum(SURE * excess // max(int(ranked[int(RANKED * (len(ranked) - 1))]), 1), SURE)


def outlines_of(picture: Int16, usable: Mask | None, toroidal: bool) -> Outlines:
    """Return the outlines of features (H, W, C), those of large exemplars from a reduced copy."""
    factor = factor_for(picture.shape)
    small = picture if factor == 1 else np.asarray(block_sums(picture, factor) // factor**2, np.int16)
    most, along, mean = _filter_responses(small, toroidal)
    if usable is not None:
        # Only pixels without unusable ones within 3 px: the edge of the mask is no outline.
        whole = block_sums(usable, factor) == factor * factor
        inside = lowest(whole.astype(np.int64), 7, "wrap" if toroidal else "constant")
        most, along, mean = most * inside, along * inside, mean * inside
    return Outlines(np.maximum(most - mean, 0), mean, np.maximum(along - mean, 0), factor)


def outline_distance(found: Outlines, shape: tuple[int, ...], toroidal: bool) -> Int32:
    """Return the distance of the pixels of a picture of this shape to its outlines: (H, W), in fifths of a px.

    At most 7 % of the shorter side. Each pixel starts with that, less its share by sureness (0 at sureness SURE); then
    the distance transform takes the minimum over pixels of the start value there plus the distance.
    """
    reach = max(1, round(REACH * min(found.excess.shape)))
    far = _nearest(STRAIGHT * reach * (SURE - found.sure(found.excess)) // SURE, reach, toroidal)
    return np.asarray(enlarged(far * found.factor, shape, found.factor), np.int32)


def _filter_responses(picture: Int16, toroidal: bool) -> tuple[Array, Array, Array]:
    """Return the responses of the filters: the greatest, that close to each axis, and the mean of all; int64."""
    scale = max(min(picture.shape[:2]) / USUAL, LEAST)
    filters = [_filter(k, scale) for k in range(DIRECTIONS)]
    radius = filters[0].shape[0] // 2
    mode: Literal["wrap", "symmetric"] = "wrap" if toroidal else "symmetric"
    padded = np.pad(picture.astype(np.int64), ((radius, radius), (radius, radius), (0, 0)), mode)
    shape = tuple(fast_length(n) for n in padded.shape[:2])
    (h, w), channels = picture.shape[:2], range(picture.shape[2])
    spectra = [fft.fft2(padded[..., c].astype(np.float64), shape) for c in channels]
    total, most, along = np.zeros((h, w), np.int64), np.zeros((h, w), np.int64), np.zeros((2, h, w), np.int64)
    for number, one in enumerate(filters):
        answers = fft.fft2(one, shape)
        squares = np.zeros((h, w))  # of whole numbers, far below 2**53
        for spectrum in spectra:
            columns = fft.ifft(spectrum * answers, axis=0)[2 * radius : 2 * radius + h]
            found = fft.ifft(columns, axis=1)[:, 2 * radius : 2 * radius + w]
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
    """Return the odd filter of a direction plus i times the even one: whole numbers (2 r + 1, 2 r + 1) of sum 0."""
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


def _nearest(far: Array, steps: int, toroidal: bool) -> Array:
    """Return the chamfer distance transform of `far`: the least value plus path length, over at most `steps` steps."""
    most, far = int(far.max(initial=0)), far.astype(np.int32)
    (h, w), sides = far.shape, (0, 1, 2)
    for _ in range(steps):
        wide = np.pad(far, 1, "wrap") if toroidal else np.pad(far, 1, constant_values=most)
        straight, slanted = (
            np.minimum.reduce([wide[y : y + h, x : x + w] for y in sides for x in sides if (y - x) % 2 == odd])
            for odd in (1, 0)
        )  # even: the corners, and the pixel itself
        nearer = np.minimum(straight + STRAIGHT, slanted + SLANTED)
        if not (nearer < far).any():
            break
        far = np.minimum(far, nearer)
    return far


BEND = SURE  # cost of a step of a line to the next row: what 1 px of the surest outline gains
CLOSE = 24, 6  # least distance of lines: 1/24 of the shorter side, at least 6 px
LEAST_LINE = 0.5  # least mean sureness of a line, bends subtracted; a third of the lines in 80 photographs has more
ENDS = 4, 0.125  # least mean sureness in each quarter of a line; the lines of eleven walls have 0.16 and more
FEWEST = 3  # lines of an exemplar with courses, at least
WIDEST = 3  # no course may be higher than 1 / WIDEST of the exemplar
CLEAR = 4.3  # least ratio of sureness on lines to between; seven walls 4.7 to 21, ripples 4.0, bark 2.8, cloth 2.3


class CourseLines(NamedTuple):
    """The K lines between the courses of an exemplar, from the top or the left.

    ``axis``: 0 where they run along rows, 1 where along columns; ``at`` (K, n) int32: of every line the row in each
    column, or the column in each row, px; ``clear``: ratio of the mean sureness on lines to that between them.
    """

    axis: int
    at: Int32
    clear: float

    @property
    def heights(self) -> list[int]:
        """Mean heights of the courses between neighbouring lines, px."""
        return [round(int(gap.sum()) / gap.size) for gap in np.diff(self.at, axis=0)]

    @property
    def told(self) -> str:
        """The number of lines and the sizes of the courses between them, in words."""
        low, high = min(self.heights), max(self.heights)
        size = f"{low} to {high}" if low < high else f"{low}"
        return f"{len(self.at)} lines run across it between courses {size} px {('high', 'wide')[self.axis]}"


def course_lines_of(found: Outlines, shape: tuple[int, ...]) -> CourseLines | None:
    """Return the lines between the courses of a picture of this shape, from its outlines; None if it has none."""
    both = [_along(axis, found.sure(found.along[axis])) for axis in (0, 1)]
    courses = [lines for lines in both if lines is not None]
    if not courses:
        return None
    best = max(courses, key=lambda lines: lines.clear)
    columns = np.minimum(np.arange(shape[1 - best.axis]) // found.factor, best.at.shape[1] - 1)
    return best._replace(at=best.at[:, columns] * found.factor + found.factor // 2)


def surest_line(sure: Array, bend: int) -> tuple[Array, int]:
    """Return the path from left to right with the highest sum of `sure` (H, W): its row in every column (W,), its sum.

    From column to column it keeps its row, or moves to the next row up or down, which costs `bend`. Of equal paths it
    is the one that ends uppermost, and that keeps its row longest before its end.
    """
    total = shortest_paths.accumulate(np.ascontiguousarray(-sure.T), bend)
    end = int(total[-1].argmin())
    return shortest_paths.trace(total, end, bend), -int(total[-1, end])


def _along(axis: int, sure: Array) -> CourseLines | None:
    """Return the lines between courses along one axis, found in the order of their sureness; None if there are none."""
    sure = np.ascontiguousarray(sure if axis == 0 else sure.T)
    (h, w), close, y = sure.shape, max(min(sure.shape) // CLOSE[0], CLOSE[1]), np.arange(sure.shape[0])[:, None]
    left, found = sure.copy(), list[Array]()
    while (best := surest_line(left, BEND))[1] >= LEAST_LINE * SURE * w:
        line = best[0]
        if _goes_through(sure[line, np.arange(w)]):
            found.append(line)
        left[np.abs(y - line) < close] = -w * SURE
    if len(found) < FEWEST:
        return None
    at = np.sort(np.array(found), axis=0)
    gaps = np.diff(np.concatenate([np.zeros_like(at[:1]), at, np.full_like(at[:1], h)]), axis=0).sum(axis=1)
    clear = _clear(sure, at)
    if int(gaps.max()) * WIDEST > h * w or clear < CLEAR:
        return None
    return CourseLines(axis, at, clear)


def _goes_through(sure: Array) -> bool:
    """Return whether the mean sureness `sure` (W,) of a line is large enough in each of its ENDS[0] parts."""
    parts = np.array_split(sure, ENDS[0])
    return all(int(part.sum()) >= ENDS[1] * SURE * len(part) for part in parts)


def _clear(sure: Array, at: Array) -> float:
    """Return the ratio of the mean sureness within 1 px of lines to that in the middle four tenths between them."""
    y = np.arange(len(sure))[:, None]
    number = np.sum([y >= line for line in at[1:-1]], axis=0)  # of the line above, of those that have one below
    above, below = np.take_along_axis(at, number, axis=0), np.take_along_axis(at, number + 1, axis=0)
    inside, near = (at[0] <= y) & (y < at[-1]), np.minimum(y - above, below - y)
    on = inside & (near <= 1)
    middle = inside & (10 * near >= 3 * (below - above))
    between = int(sure[middle].sum()) * max(int(on.sum()), 1)
    return int(sure[on].sum()) * int(middle.sum()) / max(between, 1)
