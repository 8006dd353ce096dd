"""Guides for corrections: labels or target pictures as feature channels on every level (2006, section 5).

Source and target are blurred by the same Gaussian stack. Near a boundary a pixel of a coarse level partly has both
labels, so that coarse levels match boundaries to boundaries before finer ones decide single pixels.
"""

from __future__ import annotations

import math

import numpy as np

from ..foundation.arrays import Array, Pair
from ..foundation.run import seed_state
from ..model.canvas import Canvas
from ..search.guide import ONE, codes_of
from .appearance import BITS, bordered, stack_of, without_gaps
from .guide_kernels import GuideOrder, place_anew
from .stack import ExemplarStack, StackLevel

TRIES = 8  # random exemplar pixels of which the best is taken
ENOUGH = 4  # differences up to the full one divided by this are accepted
NEAR = 3  # finest levels, on which a pixel stays if the continuation of a neighbour matches the target
EDGE = 2  # level whose blur tells finer ones the distance to a boundary
SOME = 4096  # neighbourhoods from which the variance is computed
FULL = ONE << BITS  # the full difference of a channel
FINE = 32  # fractional bits of a scale


class StackGuide:
    """The guide of one canvas on all levels.

    Attributes
    ----------
    unit : int
        The squared difference of a pixel that differs fully from its target.
    enough : int
        The squared difference up to which a pixel matches its target. For pictures it decreases with their weight, as
        tones that no candidate has must come from new places. For labels it does not: on coarse levels only pixels far
        from all boundaries would match the inside of a region, and repeat.
    """

    def __init__(self, canvas: Canvas, stack: ExemplarStack) -> None:
        assert canvas.guide is not None
        exemplar = stack.exemplar
        self._stack, self._weight, self._wraps = stack, canvas.guide.weight, (canvas.wrap.y, canvas.wrap.x)
        (source,), self._target = codes_of(canvas.guide, canvas.wrap)
        source, channels = without_gaps(source, exemplar), source.shape[2]
        self.unit = (min(channels, 2) if canvas.guide.is_labels else channels) * FULL * FULL
        strict = 1.0 if canvas.guide.is_labels else max(self._weight, 1.0)
        self.enough = int(self.unit / (ENOUGH * strict) ** 2)
        self._edge = min(EDGE, stack.count - 1) if canvas.guide.is_labels and not canvas.guide.reach else 0
        whole = [np.arange(exemplar.height), np.arange(exemplar.width)]
        shown = stacked(source, [whole] * stack.count, (exemplar.toroidal, exemplar.toroidal), self._edge)
        self._choices = [_choice(values, _open(stack, level)) for level, values in enumerate(shown)]
        self._asked: list[Array] = []

    def lay(self, places: list[list[Array]]) -> None:
        """Set the target of every level: that at its places (rows, columns), px, clamped to the canvas."""
        sides = self._target.shape[:2]
        inside = [[np.clip(at, 0, n - 1) for at, n in zip(pair, sides, strict=True)] for pair in places]
        asked = stacked(self._target, inside, self._wraps, self._edge)
        self._asked = [values.reshape(-1, values.shape[2]) for values in asked]

    def placed_by_guide(self, coords: Array, level: int, at: tuple[Array, Array], drawn: Pair, lattice: Array) -> Array:
        """Return a map (H, W, 2) in which pixels that do not match the target are replaced by random ones that do.

        ``at``: absolute rows and columns; ``drawn``: seed and stage of the random numbers; ``lattice``: vectors by
        which pixels may move, or empty.
        """
        states = np.array([seed_state(*drawn, level * TRIES + n) for n in range(TRIES)], np.uint64)
        near = 1 << level if level < min(NEAR, len(self._stack.levels)) else 0
        rule = np.array([self.enough, near, self._stack.exemplar.toroidal], np.int64)
        choice, asked = self._choices[level], self._asked[level]
        return np.asarray(place_anew(coords, at[0], at[1], states, choice, asked, rule, lattice))

    def beside(self, level: StackLevel, number: int) -> StackLevel:
        """Return a level with the guides of exemplar and target, scaled to the appearance of the level.

        A full difference counts `weight` times the root mean square difference in appearance of random pairs of
        exemplar pixels, as the range of appearance differs between levels.
        """
        exemplar, table = self._stack.exemplar, level.table.reshape(len(level.inner), -1)
        counts = self._weight * math.sqrt(2 * _variance(table[level.open > 0]) / self.unit)
        scale = round(counts * (1 << FINE))
        shown, asked = (
            np.asarray((values.astype(np.int64) * scale + (1 << (FINE - 1))) >> FINE, np.int32)
            for values in (self._choices[number].shown, self._asked[number])
        )
        shown = bordered(shown.reshape(exemplar.height, exemplar.width, -1), level.border, False)
        return level._replace(shown=shown.ravel(), asked=asked.ravel())


def _variance(vectors: Array) -> float:
    """Return the mean squared distance of vectors (N, n) from their mean, from a sample, exactly; 1 at least."""
    some = vectors[:: max(1, len(vectors) // SOME)].astype(np.int64)
    total = some.sum(axis=0)
    return max((len(some) * int((some * some).sum()) - int((total * total).sum())) / len(some) ** 2, 1.0)


def _open(stack: ExemplarStack, level: int) -> Array:
    """Return the open pixels of a level: (H, W), 1 or 0; for uncorrected levels those of the coarsest corrected one."""
    if not stack.levels:
        return stack.exemplar.free.astype(np.uint8)
    place = stack.levels[min(level, len(stack.levels) - 1)]
    inside = slice(place.border, -place.border)
    return np.ascontiguousarray(place.open.reshape(-1, place.stride)[inside, inside])


def _choice(shown: Array, may: Array) -> GuideOrder:
    """Return the open pixels of a level grouped by quantised guide values."""
    flat, places = shown.reshape(-1, shown.shape[2]), np.flatnonzero(may)
    bits = min(4 if flat.shape[1] < 3 else 3, 62 // flat.shape[1])
    key = np.zeros(len(places), np.int64)
    for c in range(flat.shape[1]):
        key = (key << bits) | ((flat[places, c].astype(np.int64) << bits) // (FULL + 1))
    order = np.argsort(key, kind="stable")
    begins = np.append(np.flatnonzero(np.diff(key[order], prepend=-1)), len(order))
    sums = np.add.reduceat(flat[places[order]].astype(np.int64), begins[:-1], axis=0)
    means = sums // np.diff(begins)[:, None]
    return GuideOrder(flat, may, places[order].astype(np.int32), begins.astype(np.int64), means.astype(np.int16))


def stacked(picture: Array, places: list[list[Array]], closed: tuple[bool, bool], edge: int = 0) -> list[Array]:
    """Return the Gaussian stack of a picture (H, W, C) at places (rows, columns) of each level: int16 in 1 / 16.

    One channel at a time, so that no level is kept in full; ``closed``: which axes wrap. Levels finer than ``edge``
    also hold its blurred channels, which encode the distance to a boundary: a rim or shadow along it in the exemplar is
    placed along the new one, while the sharp channels keep the boundary in place.
    """
    sharp: list[list[Array]] = [[] for _ in places]
    soft: list[list[Array]] = [[] for _ in places]
    for channel in np.moveaxis(picture, 2, 0):
        for level, blurred in enumerate(stack_of(channel, len(places), closed)):
            sharp[level].append(blurred[np.ix_(*places[level])])
            for finer in range(edge if level == edge else 0):
                soft[finer].append(blurred[np.ix_(*places[finer])])
    return [np.stack(a + b, axis=2).astype(np.int16) for a, b in zip(sharp, soft, strict=True)]
