"""Gradient-domain (Poisson) tone correction: steps of brightness and colour at seams of a rendered picture are removed.

In the exemplar both pieces that meet at a seam continue beyond it, so that they can be compared around each of its
pixels. If their difference is constant, as between parts of tiles under different light, it is the step to be removed.
The more it varies, as between a stone and the joint next to it, the less of it is removed, as the content differs.

The correction has these steps with the opposite sign and is as smooth as possible elsewhere: it solves a Poisson
equation, as seamless cloning does (Perez, Gangnet and Blake, "Poisson image editing", SIGGRAPH 2003), but with
measured steps in place of single pixels, and a Green's function of finite radius (`greens_function`). So a rendered
window equals that window of the whole, and pixels far from seams are unchanged. The confidence of a step is our own.
Stored codes are corrected, sRGB codes too: differences of illumination are rather factors than sums, and a correction
added in linear light would turn the dark joint next to a bright stone black. Sums are of whole numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy import fft

from ..foundation import ParameterError
from ..foundation.arrays import Array, Floats, Int32, Int64
from ..foundation.blend import Finish, Levelling
from ..foundation.filters import fast_length, moving_sums
from ..foundation.geometry import Box
from ..foundation.run import Run
from . import SourceAtlas
from .tone_kernels import Surroundings, seam_steps

MAX_RADIUS = 1024
"""The largest radius in px of a plane: transforms of cells with their margin are exact, and fit into memory."""

SMALL = 3  # px to either side over which compared colours are averaged, so that grain does not matter
FINE = 14
"""The Green's function is in whole numbers of 2**-14, so that convolutions by transforms of doubles are exact."""

_EXACT = 6  # px: up to this distance the recurrence is used, which loses digits further out
_EULER = 0.57721566490153286
_BITS, _OPACITY = 16, 8  # bits of a value, and of a weight by opacity
_SIDE = 512  # px: least side of a cell; the cells of a picture are distributed over threads


def tone_corrected(
    draw: Callable[[Box], Array], ground: SourceAtlas, alpha: bool, box: Box, finishes: tuple[Finish, ...], run: Run
) -> Array:
    """Draw a box of the map, in px of the map, and apply the tone corrections; `draw` draws a box of the canvas.

    `alpha`: whether the last channel is opacity, which stays. Raise ParameterError if a radius is too wide.
    """
    for how in finishes:
        if how.radius * (s := ground.scale) > MAX_RADIUS:
            raise ParameterError(
                f"radius={how.radius} is too wide on a {s}x larger plane; at most {MAX_RADIUS // s} px."
            )
    codes = draw(box)
    for how in finishes:
        codes = _levelled(codes, ground, alpha, box, how, run)
    return codes


def _levelled(codes: Array, ground: SourceAtlas, alpha: bool, box: Box, how: Levelling, run: Run) -> Array:
    """Return the codes (h, w, C) of a box after one tone correction."""
    s = ground.scale
    out, radius = codes.copy(), how.radius * s
    side = max(_SIDE, radius)
    cells = [
        Box(y, x, min(y + side, len(out)), min(x + side, out.shape[1]))
        for y in range(0, len(out), side)
        for x in range(0, out.shape[1], side)
    ]
    colours = _Colours.of(ground, alpha)
    size = [fast_length(min(n, side) + 2 * radius) for n in out.shape[:2]]
    spread = fft.rfft2(greens_function(radius), size)
    with run.pool() as each:

        def level(cell: Box) -> None:
            steps = _steps_around(ground, colours.around, cell.moved(box.y0 * s, box.x0 * s), radius)
            if not steps.any():
                return
            first = 2 * radius - 1

            def even(c: int) -> None:
                field = fft.irfft2(fft.rfft2(steps[..., c], size) * spread, size)
                added = np.rint(field[first : first + cell.height, first : first + cell.width])
                colours.move(out[cell.y0 : cell.y1, cell.x0 : cell.x1], c, added, how.strength)

            each(even, range(steps.shape[2]))

        each(level, cells)
        run.tick(1, 1)
    return out


def _steps_around(ground: SourceAtlas, around: Surroundings, cell: Box, radius: int) -> Int32:
    """Return the divergence of the steps in a cell, in px of the plane, and `radius` px to all sides of it.

    `cell`: in px of the plane. Beyond a border of the canvas the divergence is mirrored, as otherwise a seam that ends
    there would be corrected less.
    """
    smap, s = ground.smap, ground.scale
    sides, pads = [], []
    for start, stop, length, wrap in (
        (cell.y0, cell.y1, smap.height, smap.wrap.y), (cell.x0, cell.x1, smap.width, smap.wrap.x),
    ):  # fmt: skip
        begin, end = start - radius, stop + radius
        sides.append((begin, end) if wrap else (max(begin, 0), min(end, length * s)))
        pads.append((sides[-1][0] - begin, end - sides[-1][1]))
    (y0, y1), (x0, x1) = sides
    steps = np.zeros((y1 - y0, x1 - x0, around.means.shape[1]), np.int32)
    seam_steps(ground.cut(Box(y0, x0, y1, x1)), ground.reach.table, around, s, steps)
    return np.pad(steps, (*pads, (0, 0)), "symmetric")


@dataclass(frozen=True)
class _Colours:
    """The colours of a plane as whole numbers: local means and variance for the kernel, and range of the codes."""

    around: Surroundings
    shift: int  # codes are converted to whole numbers of 2**-shift
    spread: Floats  # (C, 2): least and greatest code of the exemplars

    @classmethod
    def of(cls, ground: SourceAtlas, alpha: bool) -> _Colours:
        codes, usable = ground.samples[:, : ground.samples.shape[1] - alpha], ground.usable
        weights = _opacity(ground.samples[:, -1]) if alpha else None
        if usable is not None:
            weights = usable.astype(np.int64) if weights is None else weights * usable
        seen = _finite(codes if weights is None or not weights.any() else codes[weights > 0])
        spread = np.stack([seen.min(axis=0), seen.max(axis=0)], axis=1).astype(np.float64)
        if codes.dtype.kind == "f":
            shift = min(_BITS - math.frexp(float(np.abs(spread).max()))[1], 1000)
            top = math.ldexp(1.0, _BITS)
            values = np.rint(np.clip(np.ldexp(_finite(codes), shift), -top, top)).astype(np.int64)
        else:
            shift = _BITS - 8 * codes.itemsize
            values = codes.astype(np.int64) << shift
        means = _means(ground.reach.table, values, weights, SMALL * ground.scale)
        counts = np.zeros(0, np.bool_) if weights is None else weights > 0
        counted = values[counts] if counts.any() else values
        n, square = len(counted), int((counted * counted).sum())  # exact but for the last division
        variance = (n * square - sum(int(total) ** 2 for total in counted.sum(axis=0))) / (n * n)
        return cls(Surroundings(means, counts, variance), shift, spread)

    def move(self, codes: Array, c: int, steps: Floats, strength: float) -> None:
        """Add `strength` times the steps (h, w), which are overwritten, to channel `c` of codes.

        Results are clipped to the range of the exemplars, or the code itself where that is outside.
        """
        own, (low, high) = codes[..., c].astype(np.float64), self.spread[c]
        steps *= math.ldexp(strength, -self.shift - FINE)
        steps += own
        np.clip(steps, np.minimum(own, low), np.maximum(own, high), out=steps)
        codes[..., c] = steps if codes.dtype.kind == "f" else np.floor(steps + 0.5, out=steps)


def _finite(codes: Array) -> Array:
    """Return floats as doubles, 0 where not finite, as masked pixels may be; integers unchanged."""
    if codes.dtype.kind != "f":
        return codes
    return np.nan_to_num(codes.astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)


def _opacity(alpha: Array) -> Int64:
    """Return opacity as weights of 8 bits."""
    if alpha.dtype.kind == "f":
        share = np.clip(np.nan_to_num(alpha.astype(np.float64), nan=0.0), 0.0, 1.0)
        return np.rint(share * ((1 << _OPACITY) - 1)).astype(np.int64)
    return np.asarray(alpha.astype(np.int64) >> 8 * alpha.itemsize - _OPACITY)


def _means(table: Int64, values: Int64, weights: Int64 | None, radius: int) -> Int64:
    """Return the mean over the box around every pixel of exemplars, (N, C) end to end, rounded down; 0 of nothing."""
    means = np.zeros_like(values)
    for start, height, width, toroidal in table:
        pixels = slice(start, start + height * width)
        weight = np.ones((height, width, 1), np.int64) if weights is None else weights[pixels].reshape(height, width, 1)
        sums = [values[pixels].reshape(height, width, -1) * weight, weight]
        for axis in range(2):
            sums = [moving_sums(s, axis, radius, "wrap" if toroidal else "constant") for s in sums]
        means[pixels] = (sums[0] // np.maximum(sums[1], 1)).reshape(-1, values.shape[1])
    return means


@lru_cache(maxsize=8)
def greens_function(radius: int) -> Int64:
    """Return the lattice Green's function up to `radius` px from a point: (2 radius - 1, 2 radius - 1), in 2**-FINE.

    Its discrete Laplacian is 1 at the point, and about 0 elsewhere near it: convolved with the divergence of a field of
    steps it gives the picture whose gradient is nearest to these steps. Near the point it is the exact one of the
    square grid, by the recurrence of McCrea and Whipple ("Random paths in two and three dimensions", 1940), further out
    its logarithmic asymptote; it falls smoothly to 0 at the radius.
    """
    from_point = np.abs(np.arange(1 - radius, radius))
    square = from_point[:, None] ** 2 + from_point**2
    value = _far(np.sqrt(np.maximum(square, 1)))
    exact = np.flatnonzero(from_point <= _EXACT)
    low, high = (f(*np.ix_(from_point[exact], from_point[exact])) for f in (np.minimum, np.maximum))
    value[np.ix_(exact, exact)] = np.array(_near())[high, low]
    fading = (1.0 - square / (radius * radius)) ** 2
    out = np.where(square < radius * radius, np.rint((value - _far(radius)) * fading * (1 << FINE)), 0).astype(np.int64)
    out.flags.writeable = False
    return out


def _far(distance: Array | float) -> Array:
    """Return the asymptotic Green's function at a distance in px."""
    return np.asarray((np.log(distance) + _EULER + 1.5 * math.log(2.0)) / (2.0 * math.pi))


def _near() -> list[list[float]]:
    """Return the exact Green's function of a point at (0, 0) on the infinite square grid: rows x, y from 0 to x."""
    n = _EXACT + 1
    a = [[0.0] * (n + 1) for _ in range(n + 1)]
    for k in range(1, n + 1):  # along the diagonal, then the diagonal next to it
        a[k][k] = a[k - 1][k - 1] + 1.0 / (math.pi * (2 * k - 1))
    a[1][0] = 0.25
    for k in range(1, n):
        a[k + 1][k] = 2.0 * a[k][k] - a[k][k - 1]
    for gap in range(2, n + 1):
        for y in range(n + 1 - gap):
            x = y + gap - 1  # all neighbours of this pixel but the right one are known
            a[x + 1][y] = 4.0 * a[x][y] - a[x - 1][y] - a[x][y + 1] - a[x][abs(y - 1)]
    return a
