"""Things of an exemplar that strike: a leaf on a lawn, the one dark pebble, a drain. Few, compact, and seen at once."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import features
from ..analysis.popout import USUAL, popout
from ..exemplar import Exemplar
from ..kernels.pieces_of_maps import boxes_of_parts, parts

Array = NDArray[Any]
Labels = NDArray[np.int32]


class Bounds(NamedTuple):
    """What makes a thing: set by eye on ten photographs, where leaves, tufts, dark pebbles and chips were found."""

    sure: int = 5 * USUAL // 2  # a thing strikes so much somewhere,
    edges: tuple[int, ...] = (512, 768, 1024, 1536, 2048, 3072, 4096)  # and the first of these at which it is compact,
    steep: tuple[int, int] = (2, 4)  # but for the first, its most is so many times that: a line is no row of things
    least: int = 20  # px: smaller ones are grain
    widest: int = 4  # it is no longer than the exemplar's shorter side through this
    share: int = 10  # %: so much of an exemplar at most is things, those that strike most


BOUNDS = Bounds()


class Things(NamedTuple):
    """What strikes in an exemplar.

    Attributes
    ----------
    labels : int32 array, shape (H, W)
        The number of the thing that a pixel belongs to, from 1, those that strike most first; 0: none.
    areas : int64 array, shape (n,)
        Pixels of each, in their order.
    peaks : int64 array, shape (n,)
        How much each strikes where it strikes most, in 1/256; at least 640.
    strikes : int32 array, shape (H, W)
        How much every pixel strikes, in 1/256 of what is usual.
    """

    labels: Labels
    areas: NDArray[np.int64]
    peaks: NDArray[np.int64]
    strikes: NDArray[np.int32]


class Strength(NamedTuple):
    """A thing among others: less what it strikes in all, its number so far, pixels, and what it strikes at most."""

    less: int
    number: int
    area: int
    peak: int


def things(exemplar: Exemplar) -> Things:
    """Find the things of an exemplar that strike, by how far their look is from that of all others (see `popout`)."""
    return exemplar.memo("things", lambda: _found(exemplar))


def _found(exemplar: Exemplar) -> Things:
    if exemplar.usable is not None and not exemplar.usable.any():
        nothing = np.zeros((exemplar.height, exemplar.width), np.int32)
        return Things(nothing, np.zeros(0, np.int64), np.zeros(0, np.int64), nothing)
    made = features([exemplar])
    strikes = popout(made.pictures[0][:, :, : made.base], exemplar.usable, exemplar.toroidal)
    out, strength = np.zeros(strikes.shape, np.int32), list[Strength]()
    for edge in BOUNDS.edges:
        _add(np.where(out == 0, strikes, 0), edge, exemplar, out, strength)
    names, known, room = np.zeros(len(strength) + 1, np.int32), list[Strength](), out.size * BOUNDS.share // 100
    for one in sorted(strength):
        if one.area <= room:
            room -= one.area
            known.append(one)
            names[one.number] = len(known)
    areas, peaks = ([one[k] for one in known] for k in (2, 3))
    return Things(names[out], np.array(areas, np.int64), np.array(peaks, np.int64), strikes)


def _add(strikes: Array, edge: int, exemplar: Exemplar, out: Labels, strength: list[Strength]) -> None:
    """Number the things that strike so much everywhere, after those that are known."""
    part, wrap = np.empty(strikes.shape, np.int32), (exemplar.toroidal, exemplar.toroidal)
    box = np.empty((parts((strikes >= edge).astype(np.int32), wrap, part), 5), np.int64)
    boxes_of_parts(part, wrap, box)
    mine, strong, top = part[part > 0], strikes[part > 0], np.zeros(len(box) + 1, np.int64)
    np.maximum.at(top, mine, strong)
    total = np.bincount(mine, np.maximum(strong - BOUNDS.edges[0], 0), len(box) + 1).astype(np.int64)
    least = BOUNDS.sure if edge == BOUNDS.edges[0] else BOUNDS.steep[0] * edge
    fits = (top[1:] >= least) & (top[1:] <= BOUNDS.steep[1] * edge) & (box[:, 4] >= BOUNDS.least)
    fits &= BOUNDS.widest * box[:, 2:4].max(axis=1, initial=0) <= min(strikes.shape)
    names = np.zeros(len(box) + 1, np.int32)
    for k in np.flatnonzero(fits).tolist():
        strength.append(Strength(-int(total[k + 1]), len(strength) + 1, int(box[k, 4]), int(top[k + 1])))
        names[k + 1] = len(strength)
    np.maximum(out, names[part], out=out)
