"""Finish a drawn picture: even out steps of light and colour across seams.

Where two pieces meet, each of them goes on in its exemplar beyond the seam, so both can be compared around every
place of it. Where they show the same but for light or colour, as two halves of tiles do, they differ by the same all
around, and that is the step to be evened out. Where they show something else, a stone and the joint beside it, they
differ here so and there otherwise; as far as they do, the step is meant, and stays.

What is added to the picture has just these steps, the other way round, and is as smooth as can be elsewhere: it solves
a Poisson equation, as seamless cloning does (Perez, Gangnet and Blake, "Poisson image editing", SIGGRAPH 2003), but
with measured steps in place of single pixels, and with a potential that ends at the radius (`potential`), so that a
window is that window of the whole, and far from seams every byte stays. Where to trust a step is this project's own.
All is done to the stored numbers, sRGB codes too: a step of light is a factor more than a sum, and in linear light
what is added to a bright stone turns the gap beside it black. Sums are of whole numbers.
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
from . import Ground
from .steps_kernels import Surroundings, seam_steps

MAX_RADIUS = 1024
"""The widest radius in px of a plane: transforms of cells with so much around them are exact, and fit into memory."""

SMALL = 3  # px to either side: what is compared is averaged so far, so that grain does not count
FINE = 14
"""Potentials are whole numbers of 2**-14: sums over them by transforms of doubles come out exact."""

_EXACT = 6  # px: so far the recurrence is used, which loses digits further out
_EULER = 0.57721566490153286
_BITS, _OPACITY = 16, 8  # of a value, of a weight
_SIDE = 512  # px of a cell, at least: several threads share those of a picture


@dataclass(frozen=True)
class Finishing:
    """All that finishing a plane needs."""

    ground: Ground
    alpha: bool  # whether opacity comes last; it stays
    run: Run

    def finished(self, draw: Callable[[Box], Array], box: Box, finishes: tuple[Finish, ...]) -> Array:
        """Draw a box of the map, in px of the map, and finish it; `draw` draws any box that lies on the canvas."""
        for how in finishes:
            if how.radius * (s := self.ground.scale) > MAX_RADIUS:
                raise ParameterError(
                    f"radius={how.radius} is too wide on a {s}x larger plane; at most {MAX_RADIUS // s} px."
                )
        codes = draw(box)
        for how in finishes:
            codes = self._levelled(codes, box, how)
        return codes

    def _levelled(self, codes: Array, box: Box, how: Levelling) -> Array:
        """Level what is drawn of a box: codes (h, w, C)."""
        ground, s = self.ground, self.ground.scale
        out, radius = codes.copy(), how.radius * s
        side, (y0, x0) = max(_SIDE, radius), (box.y0 * s, box.x0 * s)
        cells = [
            Box(y, x, min(y + side, len(out)), min(x + side, out.shape[1]))
            for y in range(0, len(out), side)
            for x in range(0, out.shape[1], side)
        ]
        colours = _Colours.of(ground, self.alpha)
        size = [fast_length(min(n, side) + 2 * radius) for n in out.shape[:2]]
        spread = fft.rfft2(potential(radius), size)
        with self.run.pool() as each:

            def level(cell: Box) -> None:
                wide = self._with_margin(cell.moved(y0, x0), radius)
                steps = np.zeros((wide.height, wide.width, colours.around.means.shape[1]), np.int32)
                seam_steps(ground.cut(wide), ground.reach.table, colours.around, s, steps)
                if not steps.any():
                    return
                steps = _with_mirrors(steps, wide, cell.moved(y0, x0), radius)
                first = 2 * radius - 1

                def even(c: int) -> None:
                    field = fft.irfft2(fft.rfft2(steps[..., c], size) * spread, size)
                    added = np.rint(field[first : first + cell.height, first : first + cell.width])
                    colours.move(out[cell.y0 : cell.y1, cell.x0 : cell.x1], c, added, how.strength)

                each(even, range(steps.shape[2]))

            each(level, cells)
            self.run.tick(1, 1)
        return out

    def _with_margin(self, cell: Box, radius: int) -> Box:
        """Return a cell, in px of the plane, with what lies around it, as far as the canvas goes."""
        smap, s = self.ground.smap, self.ground.scale
        y0, x0, y1, x1 = cell.y0 - radius, cell.x0 - radius, cell.y1 + radius, cell.x1 + radius
        if not smap.wrap.y:
            y0, y1 = max(y0, 0), min(y1, smap.height * s)
        if not smap.wrap.x:
            x0, x1 = max(x0, 0), min(x1, smap.width * s)
        return Box(y0, x0, y1, x1)


def _with_mirrors(steps: Int32, wide: Box, cell: Box, radius: int) -> Int32:
    """Return the steps around a cell, `radius` px to all sides; beyond the border of the canvas as in a mirror.

    Else a seam that ends at the border would be evened out less there.
    """
    rows = (wide.y0 - cell.y0 + radius, cell.y1 + radius - wide.y1)
    columns = (wide.x0 - cell.x0 + radius, cell.x1 + radius - wide.x1)
    return np.pad(steps, (rows, columns, (0, 0)), "symmetric")


@dataclass(frozen=True)
class _Colours:
    """The colours of a plane: what kernels compare, what numbers they became, and their range."""

    around: Surroundings
    shift: int  # codes become whole numbers of 2**-shift
    spread: Floats  # (C, 2): least and greatest code of the exemplars

    @classmethod
    def of(cls, ground: Ground, alpha: bool) -> _Colours:
        codes = ground.samples[:, : ground.samples.shape[1] - alpha]
        weights = _weights(ground, alpha)
        seen = codes if weights is None or not weights.any() else codes[weights > 0]
        if codes.dtype.kind == "f":  # what is masked out may hold anything
            seen = np.nan_to_num(seen.astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)
        spread = np.stack([seen.min(axis=0), seen.max(axis=0)], axis=1).astype(np.float64)
        if codes.dtype.kind == "f":
            shift = min(_BITS - math.frexp(float(np.abs(spread).max()))[1], 1000)
        else:
            shift = _BITS - 8 * codes.itemsize
        values = _as_integers(codes, shift)
        means = _means(ground.reach.table, values, weights, SMALL * ground.scale)
        counts = np.zeros(0, np.bool_) if weights is None else weights > 0
        return cls(Surroundings(means, counts, _variance(values[counts] if counts.any() else values)), shift, spread)

    def move(self, codes: Array, c: int, steps: Floats, strength: float) -> None:
        """Add the steps (h, w), which are changed, to channel `c` of codes, within the range of the exemplars."""
        own, (low, high) = codes[..., c].astype(np.float64), self.spread[c]
        steps *= math.ldexp(strength, -self.shift - FINE)
        steps += own
        np.clip(steps, np.minimum(own, low), np.maximum(own, high), out=steps)
        codes[..., c] = steps if codes.dtype.kind == "f" else np.floor(steps + 0.5, out=steps)


def _variance(values: Int64) -> float:
    """The variance of whole numbers (n, C), of all channels together; exact but for the last division."""
    n, square = len(values), int((values * values).sum())
    return (n * square - sum(int(total) ** 2 for total in values.sum(axis=0))) / (n * n)


def _weights(ground: Ground, alpha: bool) -> Int64 | None:
    """How much every pixel of the exemplars counts; None where all count alike."""
    opaque, usable = _opacity(ground.samples[:, -1]) if alpha else None, ground.usable
    if usable is None:
        return opaque
    return usable.astype(np.int64) if opaque is None else opaque * usable


def _as_integers(codes: Array, shift: int) -> Int64:
    """Return codes as whole numbers of 2**-shift; what is not finite, which only masked pixels may be, as 0."""
    if codes.dtype.kind != "f":
        return np.asarray(codes.astype(np.int64) << shift)
    values = np.nan_to_num(codes.astype(np.float64), nan=0.0, posinf=0.0, neginf=0.0)
    top = math.ldexp(1.0, _BITS)
    return np.asarray(np.rint(np.clip(np.ldexp(values, shift), -top, top)), np.int64)


def _opacity(alpha: Array) -> Int64:
    """Return opacity as weights of 8 bits."""
    if alpha.dtype.kind == "f":
        share = np.clip(np.nan_to_num(alpha.astype(np.float64), nan=0.0), 0.0, 1.0)
        return np.rint(share * ((1 << _OPACITY) - 1)).astype(np.int64)
    return np.asarray(alpha.astype(np.int64) >> (0 if alpha.itemsize == 1 else 16 - _OPACITY))


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
def potential(radius: int) -> Int64:
    """Return the potential around a point, less than `radius` px away: (2 radius - 1, 2 radius - 1), in 2**-FINE.

    Its sum of differences to the four neighbours is 1 at the point, and about 0 elsewhere near it: added up over the
    divergence of a field of steps it gives a picture that has these steps, as far as a picture can. Near the point it
    is the exact one of the square grid, by the recurrence of McCrea and Whipple ("Random paths in two and three
    dimensions", 1940), further out its logarithm; towards the radius it fades.
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
    """The potential so far away, px; as what is given."""
    return np.asarray((np.log(distance) + _EULER + 1.5 * math.log(2.0)) / (2.0 * math.pi))


def _near() -> list[list[float]]:
    """The potential of a point at (0, 0) on a grid without end, in rows x >= y >= 0."""
    n = _EXACT + 1
    a = [[0.0] * (n + 1) for _ in range(n + 1)]
    for k in range(1, n + 1):  # along the diagonal, and beside it: both neighbours below are known
        a[k][k] = a[k - 1][k - 1] + 1.0 / (math.pi * (2 * k - 1))
    a[1][0] = 0.25
    for k in range(1, n):
        a[k + 1][k] = 2.0 * a[k][k] - a[k][k - 1]
    for gap in range(2, n + 1):
        for y in range(n + 1 - gap):
            x = y + gap - 1  # the pixel whose neighbours are all known but the right one
            a[x + 1][y] = 4.0 * a[x][y] - a[x - 1][y] - a[x][y + 1] - a[x][abs(y - 1)]
    return a
