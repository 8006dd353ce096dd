"""Maps sewn by graph cuts, and any map improved by them: seams, and even use of the exemplar.

How visible the seams of a map are: one number for a picture, another to choose among several ways to fill a hole.

Between two neighbouring pixels that do not continue one another runs a seam. It costs what both sides would look
like there: the difference of each pixel and the other side's continuation (Kwatra et al. 2003, equation 1).
"""

from __future__ import annotations

import numpy as np

from ..analysis import variance
from ..analysis.features import Features, features, pose_array
from ..foundation.arrays import Array, Pair
from ..foundation.geometry import ISOMETRIES, Box
from ..kernels.cuts import SeamPrice
from ..model import Exemplars
from ..model.sourcemap import SourceMap, matrices, positions
from ..patches.growth import knee_of
from .energy_kernels import Part, Pieces, exact_energy, warped_energy

# Grain hides a step of tone from single differences; summed with their sign over cells of 8 px, it is seen.
CELL, TONE = 8, 2  # px; how much it counts beside them; at 0 a step as large as grain is not seen
STEPS = np.array([i.j for i in ISOMETRIES], np.int32)
BACK = (0, 1, 2, 3, 4, 7, 6, 5)  # the isometry that takes each back
BAND = 128  # rows of a map that are looked at together, so that little memory is needed


def energy(exemplars: Exemplars, smap: SourceMap) -> int:
    """Return what all seams of a map cost by the price ``sharp``, in knees per million px, rounded down.

    0 where no seam differs from what it parts. A knee is three eighths of the spread of colours, of the exemplar that
    varies most: a seam between two pixels costs the square of what both sides differ, in knees, and from four knees on
    four times that. All planes count as they do in the search. Directions in a normal map turn with a piece that is
    turned by quarters or mirrored, not with one that is bent or turned by other angles. Whole numbers: the same on
    every machine.
    """
    feats = features(exemplars)
    knee = max(knee_of(variance(p, e.usable)) for p, e in zip(feats.pictures, exemplars, strict=True))
    pieces, total = _pieces(feats, exemplars, smap), 0
    for first in range(0, smap.height, BAND):
        size = min(BAND, smap.height - first), smap.width
        band = _band(smap, first, size)
        part = Part(band.yx, band.numbers, band.turns, size)
        if band.exact:
            total += exact_energy(part, pieces, SeamPrice(knee=knee))
        else:
            fine = positions(band.yx, band.sub), matrices(band.frame, band.turns)
            total += warped_energy(part, fine, pieces, SeamPrice(knee=knee))
    return 1_000_000 * total // (knee * smap.height * smap.width)


def _band(smap: SourceMap, first: int, size: Pair) -> SourceMap:
    """Rows of a map with the row below and the first column again, where it goes on there."""
    more = first + size[0] < smap.height or smap.wrap.y
    return smap.window(Box(first, 0, first + size[0] + more, size[1] + smap.wrap.x))


def _pieces(feats: Features, exemplars: Exemplars, smap: SourceMap) -> Pieces:
    """The exemplars as kernels of energies take them; one that is turned is another where it has normals."""
    poses = smap.poses if feats.normals else (0,)
    flat, shown, table, begin = list[Array](), list[Array](), np.zeros((len(exemplars), 8, 4), np.int64), 0
    for number, e in enumerate(exemplars):
        for pose in poses:
            picture = pose_array(feats.posed(number, pose), BACK[pose])
            height, width = picture.shape[:2]
            table[number, pose if feats.normals else slice(None)] = begin, height, width, width
            flat.append(picture.ravel())
            shown.append(e.free.ravel().astype(np.uint8))
            begin += picture.size
    torus = np.repeat([e.toroidal for e in exemplars], 8)
    channels = feats.pictures[0].shape[2]
    return Pieces(np.concatenate(flat), table.reshape(-1, 4), np.concatenate(shown), torus, channels)


def seam_total(feats: Features, exemplars: Exemplars, smap: SourceMap) -> int:
    """Return the cost of all seams of a map without holes, in units of the features; 0 where it is one piece."""
    which, pose, total = smap.numbers, smap.turns, 0
    for axis, wrap in ((0, smap.wrap.y), (1, smap.wrap.x)):
        if smap.exact:
            steps = STEPS[pose][:, :, :, axis]
            broken = (smap.yx + steps != np.roll(smap.yx, -1, axis)).any(axis=2)
        else:  # pieces lie between pixels: they go on where they do to within 1 px, and are read at the nearest pixel
            j, at = matrices(smap.frame, pose)[:, :, :, axis], positions(smap.yx, smap.sub)
            broken = (np.abs(np.roll(at, -1, axis) - at - (j + np.roll(j, -1, axis)) / 2) > 1).any(axis=2)
            steps = np.rint(j).astype(np.int32)
        for part in (which, pose):
            broken |= part != np.roll(part, -1, axis)
        if not wrap:
            broken[(-1, slice(None)) if axis == 0 else (slice(None), -1)] = False
        total += _along(axis, broken, smap.yx, which, steps, feats, exemplars)
    return total


def _along(
    axis: int, broken: Array, yx: Array, which: Array, steps: Array, feats: Features, exemplars: Exemplars
) -> int:
    """The cost of the seams between pixels and the next along an axis; `steps` (H, W, 2) lead on from each pixel."""
    a, b = yx[broken], np.roll(yx, -1, axis)[broken]
    which_a, which_b = which[broken], np.roll(which, -1, axis)[broken]
    step_a, step_b = steps[broken], np.roll(steps, -1, axis)[broken]
    here, there = _read(a, which_a, feats, exemplars)[0], _read(b, which_b, feats, exemplars)[0]
    over, over_ok = _read(a + step_a, which_a, feats, exemplars)
    back, back_ok = _read(b - step_b, which_b, feats, exemplars)
    first, second, plain = (np.abs(p - q).sum(axis=1) for p, q in ((over, there), (back, here), (here, there)))
    signed = np.where(over_ok[:, None], over - there, here - there) + np.where(back_ok[:, None], here - back, 0)
    cells = tuple(index // CELL for index in np.nonzero(broken))
    tone = np.zeros((broken.shape[0] // CELL + 1, broken.shape[1] // CELL + 1, signed.shape[1]), np.int64)
    np.add.at(tone, cells, signed)
    costs = np.where(over_ok, first, plain) + np.where(back_ok, second, plain)
    return int(costs.sum()) + TONE * int(np.abs(tone).sum())


def _read(at: Array, which: Array, feats: Features, exemplars: Exemplars) -> tuple[Array, Array]:
    """Features at exemplar pixels, and whether they may be read: inside, and usable."""
    out = np.zeros((len(at), feats.pictures[0].shape[2]), np.int64)
    ok = np.zeros(len(at), bool)
    for number, exemplar in enumerate(exemplars):
        mine = which == number
        y, x = at[mine].T
        height, width = exemplar.height, exemplar.width
        inside = np.ones(len(y), bool) if exemplar.toroidal else (y >= 0) & (x >= 0) & (y < height) & (x < width)
        y, x = y % height, x % width
        ok[mine] = inside if exemplar.usable is None else inside & exemplar.usable[y, x]
        out[mine] = feats.pictures[number][y, x]
    return out, ok
