"""Graph-cut texture synthesis and seam refinement; the seam energy of a finished map.

The seam energy is one number for a whole map. It is also used to compare alternative fillings of a hole.

A seam runs between two neighbouring canvas pixels of which the second is not the continuation of the first in the
exemplar. Its cost is the sum of two feature distances, one at each of the two pixels: that between what the map shows
there and what the piece on the other side would show there (Kwatra, Schoedl, Essa, Turk and Bobick, "Graphcut
Textures", SIGGRAPH 2003, equation 1).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..analysis import variance
from ..analysis.contrast_masking import FULL, visibility
from ..analysis.features import features, transformed
from ..foundation.arrays import Array, Int16, Pair
from ..foundation.geometry import Box
from ..kernels.cuts import STEEPEST
from ..model import Exemplars
from ..model.sourcemap import BESIDE, SourceMap
from ..patches.patch_synthesis import seam_threshold

BACK = (0, 1, 2, 3, 4, 7, 6, 5)  # the inverse of each of the eight isometries, by their numbers
Looks = list[dict[int, Array]]  # features of each exemplar by pose; a dictionary of one entry is for all poses
BAND = 128  # rows of a map that are processed at a time, which limits memory; no result depends on it


def energy(exemplars: Exemplars, smap: SourceMap) -> int:
    """Return the seam energy of a map by the cost ``sharp``, in thresholds per million px, rounded down.

    The cost is a truncated quadratic. Its threshold is three eighths of the standard deviation of the features (the
    root of the sum of their variances), of the exemplar that varies most. With d the sum of the two feature distances
    of a pair of pixels, each weighted by visibility (:mod:`~intarsia.analysis.contrast_masking`), in thresholds, a
    seam costs d squared up to d = 4, and 4 d beyond.

    All planes count as in the search. Directions in a normal map are transformed with a piece that is mirrored or
    rotated by multiples of 90 degrees, not with one that is bent or rotated by other angles.

    Returns
    -------
    int
        0 where no seam differs. Computed in whole numbers, so the same on every machine.
    """
    feats = features(exemplars)
    knee = max(seam_threshold(variance(p, e.usable)) for p, e in zip(feats.pictures, exemplars, strict=True))
    poses = (smap.poses if feats.normals else ()) or (0,)
    looks = [
        {p: np.dstack([transformed(feats.posed(n, p), BACK[p]), seen]) for p in poses}
        for n, seen in enumerate(visibilities(feats.pictures, exemplars, knee))
    ]
    total = 0
    for _, seam in seams_of(exemplars, smap, looks):
        cost = _distance(seam.over, seam.there) + _distance(seam.here, seam.back)
        total += int(np.where(cost >= STEEPEST * knee, STEEPEST * cost, cost * cost // knee).sum())
    return 1_000_000 * total // (knee * smap.height * smap.width)


def visibilities(pictures: Sequence[Int16], exemplars: Exemplars, knee: int) -> list[Array]:
    """Return the visibility of feature differences at every pixel of each exemplar, for a truncated quadratic cost."""
    return [visibility(p, knee, e.usable, e.toroidal) for p, e in zip(pictures, exemplars, strict=True)]


class Seam(NamedTuple):
    """Pixel pairs across the seams along one axis, and the features of both pieces at both pixels.

    The first pixel of a pair is the upper or left one, the second its lower or right neighbour.
    """

    y: Array  # (n,): canvas rows of the first pixels
    x: Array  # (n,): canvas columns of the first pixels
    here: Array  # (n, C): features of the first pixels
    over: Array  # (n, C): the first piece continued to the second pixel; `here` where the exemplar ends
    back: Array  # (n, C): the second piece continued to the first pixel; `there` where the exemplar ends
    there: Array  # (n, C): features of the second pixels


def seams_of(exemplars: Exemplars, smap: SourceMap, looks: Looks) -> Iterator[tuple[int, Seam]]:
    """Yield an axis (0: pairs of rows, 1: pairs of columns) and its seams, band by band from the top."""
    for first in range(0, smap.height, BAND):
        rows = min(BAND, smap.height - first)
        more = first + rows < smap.height or smap.wrap.y
        band = smap.window(Box(first, 0, first + rows + more, smap.width + smap.wrap.x))
        for axis in range(2):
            yield axis, _parted(axis, band, (rows, smap.width), first, exemplars, looks)


def _parted(axis: int, band: SourceMap, size: Pair, first: int, exemplars: Exemplars, looks: Looks) -> Seam:
    """Return the seams of a band of rows from `first` on; `size` excludes the extra row and column."""
    (this, that), known = BESIDE[axis], ~band.holes
    y, x = np.nonzero((band.parted(axis) & known[this] & known[that])[: size[0], : size[1]])
    which, pose, steps, ends = band.numbers, band.turns, band.steps(axis), []
    for side, way in ((this, 1), (that, -1)):
        yx, number, turn = band.yx[side][y, x], which[side][y, x], pose[side][y, x]
        own, _ = _read(yx, number, turn, exemplars, looks)
        step = np.rint(steps[side][y, x]).astype(np.int32)
        on, there = _read(yx + way * step, number, turn, exemplars, looks)
        ends.append((own, np.where(there[:, None], on, own)))
    (here, over), (there, back) = ends
    return Seam(first + y, x, here, over, back, there)


def _read(at: Array, which: Array, pose: Array, exemplars: Exemplars, looks: Looks) -> tuple[Array, Array]:
    """Return the features at exemplar pixels, and whether each lies inside its exemplar and is usable."""
    out = np.zeros((len(at), next(iter(looks[0].values())).shape[2]), np.int64)
    ok = np.zeros(len(at), bool)
    for number, exemplar in enumerate(exemplars):
        for turn, look in looks[number].items():
            mine = (which == number) & ((pose == turn) | (len(looks[number]) == 1))
            y, x = at[mine].T
            height, width = look.shape[:2]
            inside = (y >= 0) & (x >= 0) & (y < height) & (x < width) | exemplar.toroidal
            y, x = y % height, x % width
            ok[mine], out[mine] = inside & exemplar.free[y, x], look[y, x]
    return out, ok


def _distance(a: Array, b: Array) -> Array:
    """Return feature distances, rounded up and weighted by visibility, the last channel of `a` and `b` (n, C + 1)."""
    squares = ((a[:, :-1] - b[:, :-1]) ** 2).sum(axis=1)
    root = np.sqrt(squares).astype(np.int64)
    return np.asarray((root + (root * root < squares)) * (a[:, -1] + b[:, -1]) // (2 * FULL))
