"""Damaged elements: bodies of an output that no body of the exemplar is like.

Exemplar and output are cut into segments in the same way. A segment of the exemplar is known by its area, its outline,
how long it is and in which direction, its colour and how even that is. A cut stone is too small or has another outline,
two that merged are too large, a two-coloured one is uneven: none of the exemplar's is near it. How near the exemplar's
own are to one another says what is near.

Source: segments, Felzenszwalb and Huttenlocher 2004; the comparison is our own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..segments.felzenszwalb import DEVIATION, FAINT, LEAST_PIXELS, Int32, Int64, PixelGraph, smoothed
from .windows import smaller

REDUCED = 2  # times: joints of 2 px are seen still, and 512 px cost a quarter
PASSES, SLACK = 1, 2  # of the segments; blur of 2 passes and slack 5 named the better as often
FEWEST = 6  # whole segments of the exemplar; of fewer nothing is known
USUAL = 9, 10  # nine of ten segments of the exemplar have one of their own as near: farther is damaged
FINE = 64  # parts of 1 that features are rounded to: whole numbers, the same on every machine
AREA, OUTLINE, LONG, COLOUR, EVEN = 1.0, 0.5, 1.5, 1.2, 1.5  # weights; halved and doubled it names as many


@dataclass(frozen=True, eq=False)
class Elements:
    """The whole segments of exemplars: what is known of each, (n, features), and how near their own like is to most.

    ``middle`` and ``deviation``: of the colours, so that outputs are cut up by the contrast of the exemplars.
    """

    middle: Array
    deviation: Array
    known: Int64
    usual: int

    @classmethod
    def of(
        cls, pictures: Sequence[NDArray[np.int16]], usable: Sequence[NDArray[np.bool_] | None]
    ) -> Elements | None:
        """Cut exemplars (H, W, C) up; None where they have too few segments that are whole."""
        small = [smaller(p, REDUCED) for p in pictures]
        masks = [None if m is None else _whole(m) for m in usable]
        chosen = [p.reshape(-1, p.shape[2]) if m is None else p[m] for p, m in zip(small, masks, strict=True)]
        flat = np.concatenate(chosen).astype(np.int64)
        if not len(flat):
            return None
        middle = flat.sum(axis=0) // len(flat)
        spread = ((flat - middle) ** 2).sum(axis=0) // len(flat)
        deviation = np.array([math.isqrt(FINE * FINE * int(v)) for v in spread])
        deviation = np.maximum(deviation, np.int64(FAINT * int(deviation.max())))
        if int(deviation.max()) == 0:
            return None
        found = [segments(p, middle, deviation, m)[1] for p, m in zip(small, masks, strict=True) if min(p.shape[:2])]
        known = np.concatenate(found)
        if len(known) < FEWEST:
            return None
        own = np.sort(_nearest(known, known, 2))
        return cls(middle, deviation, known, int(own[len(own) * USUAL[0] // USUAL[1]]))

    def outlined(self, picture: Array) -> tuple[NDArray[np.bool_], float]:
        """Where the outlines of segments that are like none of the exemplars' run: (H, W) of an output (H, W, C).

        And how many of 100 whole segments these are.
        """
        labels, far = self.judged(picture)
        damaged = np.concatenate([[False], far > self.usual])[labels]
        edges = damaged & _edges(np.where(damaged, labels, 0))
        out = np.zeros(picture.shape[:2], bool)
        whole = edges.repeat(REDUCED, axis=0).repeat(REDUCED, axis=1)
        out[: whole.shape[0], : whole.shape[1]] = whole
        return out, 100 * int((far > self.usual).sum()) / max(len(far), 1)

    def judged(self, picture: Array) -> tuple[Int32, Int64]:
        """Return the segments of an output on half its px, whole ones from 1, 0 elsewhere; and how far each is."""
        small = smaller(picture, REDUCED)
        if min(small.shape[:2]) < 1:
            return np.zeros(small.shape[:2], np.int32), np.zeros(0, np.int64)
        labels, features = segments(small, self.middle, self.deviation, None)
        return labels, _nearest(features, self.known, 1)


def segments(
    picture: Array, middle: Array, deviation: Array, usable: NDArray[np.bool_] | None
) -> tuple[Int32, Int64]:
    """Cut a picture up: segments off its borders, from 1, 0 elsewhere, and what each of them is: (n, features).

    Features are whole numbers of 1 / FINE: log of the area, outline by its root, how long and how slanted it is, the
    mean of every channel in deviations, and how uneven it is.
    """
    even = ((picture.astype(np.int64) - middle) * (DEVIATION * FINE) // np.maximum(deviation, 1)).astype(np.int32)
    if usable is not None:
        even[~usable] = 0
    colours = smoothed(even, PASSES)
    labels = PixelGraph(colours, usable).segments(SLACK * math.isqrt(DEVIATION * DEVIATION * picture.shape[2]))
    rim = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
    area = np.bincount(labels[labels >= 0], minlength=1)
    whole = area >= LEAST_PIXELS
    whole[rim[rim >= 0]] = False
    number = np.zeros(len(area) + 1, np.int32)  # the last: nowhere
    number[:-1][whole] = np.arange(1, int(whole.sum()) + 1)
    labels = number[labels]
    return labels, _features(labels, colours, int(whole.sum()))


def _features(labels: Int32, colours: Int32, count: int) -> Int64:
    """What is known of segments 1 to `count`."""
    inside = np.flatnonzero(labels)
    names = labels.ravel()[inside] - 1
    rows, columns = np.divmod(inside, labels.shape[1])

    def mean(values: Array) -> Array:  # sums of whole numbers below 2**53 are exact
        return np.bincount(names, values.astype(np.float64), count) / area

    area = np.bincount(names, minlength=count)
    outline = np.bincount(names[_edges(labels).ravel()[inside]], minlength=count)
    y, x = mean(rows), mean(columns)
    high, wide, slant = mean(rows * rows) - y * y, mean(columns * columns) - x * x, mean(rows * columns) - x * y
    size = high + wide + 0.3  # of one pixel
    flat, root = colours.reshape(-1, colours.shape[2])[inside].astype(np.int64), colours.shape[2] ** 0.5 * DEVIATION
    tones = [mean(c) for c in flat.T]
    uneven = sum(mean(c * c) - t * t for c, t in zip(flat.T, tones, strict=True))
    columns_of = [
        AREA * np.log2(area), OUTLINE * outline / np.sqrt(area), LONG * (high - wide) / size, LONG * 2 * slant / size,
        *(COLOUR * t / root for t in tones), EVEN * np.sqrt(np.maximum(uneven, 0)) / root,
    ]  # fmt: skip
    return np.asarray(np.rint(np.stack(columns_of, axis=1) * FINE), np.int64)


def _edges(labels: Int32) -> NDArray[np.bool_]:
    """Pixels with one of 4 neighbours in another segment."""
    edge = np.zeros(labels.shape, bool)
    for a, b in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        differs = labels[a] != labels[b]
        edge[a] |= differs
        edge[b] |= differs
    return edge


def _nearest(features: Int64, known: Int64, rank: int) -> Int64:
    """The distance of each to the nearest of those known, or the next, in 1 / FINE, rounded down."""
    from scipy.spatial import cKDTree  # it is slow to import

    if not len(features):
        return np.zeros(0, np.int64)
    near = np.asarray(cKDTree(known).query(features, k=[rank])[1]).reshape(-1)
    off: Int64 = features - known[near]
    return np.asarray(np.sqrt((off * off).sum(axis=1).astype(np.float64)), np.int64)


def _whole(usable: NDArray[np.bool_]) -> NDArray[np.bool_]:
    return np.asarray(smaller(usable.astype(np.int64), REDUCED) == 1)
