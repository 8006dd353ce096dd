"""Exemplars whose courses slant, converge or bow, laid straight: the same pixels, moved by whole px.

Every pixel of the straight exemplar is one of the exemplar, so that copies stay exact; where courses are widened some
pixels are shown twice, where they are narrowed some are left out. Pixels move across the courses, to where the phase of
the courses puts them; along them only as much as makes the joints between bricks stand upright.

Source: Lopez Recas 2011, chapter 6 (geometry corrected before the synthesis); how is not said there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..analysis.features import features
from ..analysis.sums import factor_for, reduced
from ..arrays import Array
from ..exemplar import Exemplar
from ..image import Plane
from ..lattice.correlation_map import pictures
from ..lazy import ndimage
from .phase import TURN, Phase, phases, samples

WORK_SIDE = 256  # px: larger exemplars are reduced to it, to be looked at, as waves of 6 px are the shortest followed
LEAN = 256  # joints lean by whole multiples of 1 / LEAN: a unit


class Bending(NamedTuple):
    """Which courses are laid straight; halved and doubled on the 16 pictures of `Following` (docs/design/012)."""

    move: float = 1.0  # px: less is not worth a change: pixels move by whole ones
    strength: float = 0.02  # share of an exemplar that its courses make up; halved: the same, doubled: three are lost
    narrowest: float = 0.5  # times as wide may a course become; 0.25: scales are bent, 0.7: two are lost
    widest: float = 2.0  # and that; as above with 4 and 1.4
    steepest: float = 0.35  # px down for each along: more would be sheared; halved: the same, doubled: scales are
    strong: float = 0.05  # share of the edges that count as joints; halved and doubled: joints lean by other 1 / LEAN


BENDING = Bending()


@dataclass(frozen=True, eq=False)
class Straight:
    """An exemplar laid straight."""

    exemplar: Exemplar  # its pixels where they lie now; what lay outside is not usable
    yx: NDArray[np.int32]  # (H, W, 2): the pixel of the given exemplar that each pixel is
    slant: float  # px down per px along (or px aside per px down) by which the courses leaned
    converging: float  # how much wider the courses are at one end than at the other, as a share
    off: float  # how far courses lay from straight, parallel and equal ones at most, px

    def to_exemplar(self, yx: NDArray[np.int32]) -> NDArray[np.int32]:
        """Turn pixels of the straight exemplar into those of the given one."""
        return np.ascontiguousarray(self.yx[yx[..., 0], yx[..., 1]])


def straight_of(exemplar: Exemplar, weights: tuple[float, ...] | None = None) -> Straight | None:
    """Lay the courses of an exemplar straight; None where none are found, or they are straight already."""
    return exemplar.memo(("straight", weights), lambda: _straight(exemplar, weights))


def _straight(exemplar: Exemplar, weights: tuple[float, ...] | None) -> Straight | None:
    picture = features([exemplar], weights).pictures[0]
    if min(picture.shape[:2]) < 32:
        return None
    factor = factor_for(picture.shape, WORK_SIDE)
    small, mask = reduced(picture, exemplar.usable, factor)
    for phase in phases(pictures(small, mask)):
        if phase.strength < BENDING.strength:
            return None
        found = _laid(exemplar, picture, phase, factor)
        if found is not None:
            return found
    return None


def _laid(exemplar: Exemplar, picture: Array, phase: Phase, factor: int) -> Straight | None:
    """Follow a phase; None where it is no smooth change of straight courses, or no change."""
    usable = np.ones(picture.shape[:2], bool) if exemplar.usable is None else exemplar.usable
    if phase.upright:
        picture, usable = picture.swapaxes(0, 1), usable.T
    height, width = usable.shape
    seen = [n // factor * factor for n in (height, width)]
    at = np.rint(phase.at(samples(height, seen[0])[:, None], samples(width, seen[1]))).astype(np.int64)
    pitch, slope, off = _flat(at)
    steps = np.diff(at, axis=0) * pitch
    if steps.min() < TURN * BENDING.narrowest or steps.max() > TURN * BENDING.widest:
        return None
    if abs(slope) > BENDING.steepest or max(off, abs(slope) * width) < BENDING.move:
        return None
    lean = _lean(picture, usable)
    yx, inside = _moved(at, round(pitch * 256), lean)
    ends = np.diff(at[[0, -1]], axis=0)[0]
    converging = float(ends.max() / ends.min() - 1)
    inside &= usable[yx[..., 0], yx[..., 1]]
    if phase.upright:
        yx, inside = yx.swapaxes(0, 1)[..., ::-1], inside.T
    whole = np.ascontiguousarray(yx, np.int32)
    return Straight(_gathered(exemplar, whole, inside), whole, slope, converging, off)


def _flat(at: NDArray[np.int64]) -> tuple[float, float, float]:
    """The straight, parallel and equal courses next to a phase: pitch px, slope, and how far it is off at most, px."""
    height, width = at.shape
    y, x = np.arange(height) * 2 + 1 - height, np.arange(width) * 2 + 1 - width
    # Sums of whole numbers; the places sum to nothing, so that each slope is a quotient.
    down = int((at.sum(axis=1) * y).sum()) / (width * int((y * y).sum()))
    along = int((at.sum(axis=0) * x).sum()) / (height * int((x * x).sum()))
    left = at - int(at.sum()) / at.size - down * y[:, None] - along * x
    return TURN / (2 * down), -along / down, float(np.abs(left).max() / (2 * down))


def _lean(picture: Array, usable: NDArray[np.bool_]) -> int:
    """How far the joints between bricks lean, 1 / LEAN px along for each px across: the mean of the strongest edges."""
    smooth = np.rint(ndimage.gaussian_filter(picture.astype(np.float64), (1.5, 1.5, 0)) * 16).astype(np.int64)
    across, along = np.zeros(smooth.shape, np.int64), np.zeros(smooth.shape, np.int64)
    across[1:-1], along[:, 1:-1] = smooth[2:] - smooth[:-2], smooth[:, 2:] - smooth[:, :-2]
    square = (along * along).sum(axis=2)
    steep = usable & (square > 4 * (across * across).sum(axis=2))
    if steep.sum() < 100:
        return 0
    strong = steep & (square >= np.sort(square[steep])[-max(100, int(BENDING.strong * steep.sum()))])
    return int(np.rint(-LEAN * int((across * along).sum(axis=2)[strong].sum()) / max(int(square[strong].sum()), 1)))


def _moved(at: NDArray[np.int64], pitch: int, lean: int) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The pixel next to each place of the straight exemplar (courses along x, `pitch` 1/256 px), and which exist."""
    width = at.shape[1]
    low, high = int(at.min()), int(at.max())
    tall = (high - low) * pitch // (TURN * 256) + 1
    wanted = low + np.arange(tall, dtype=np.int64) * TURN * 256 // pitch
    rows, known = np.empty((tall, width), np.int64), np.empty((tall, width), bool)
    half = TURN * 128 // pitch
    for k in range(width):
        column = at[:, k]
        rows[:, k] = np.searchsorted((column[1:] + column[:-1]) // 2, wanted)
        known[:, k] = (wanted >= column[0] - half) & (wanted <= column[-1] + half)
    shift = (np.arange(tall) - tall // 2) * lean // LEAN
    first, last = -int(shift.max()), width - int(shift.min())
    x = np.arange(first, last) + shift[:, None]
    inside = (x >= 0) & (x < width)
    x = np.clip(x, 0, width - 1)
    r = np.arange(tall)[:, None]
    return np.stack([rows[r, x], x], axis=2), inside & known[r, x]


def _gathered(exemplar: Exemplar, yx: NDArray[np.int32], usable: NDArray[np.bool_]) -> Exemplar:
    """The exemplar of other pixels, in all planes; vectors of normal maps stay as they are."""

    def moved(plane: Plane) -> Plane:
        pixels, y, x = plane.pixels, yx[..., 0], yx[..., 1]
        if plane.height < exemplar.height:
            s = exemplar.height // plane.height
            return replace(plane, pixels=pixels[y // s, x // s])
        s = plane.height // exemplar.height
        parts = pixels.reshape(exemplar.height, s, exemplar.width, s, *pixels.shape[2:])
        taken = parts[y, :, x].swapaxes(1, 2)
        return replace(plane, pixels=taken.reshape(y.shape[0] * s, y.shape[1] * s, *pixels.shape[2:]))

    planes = {name: moved(p) for name, p in exemplar.planes.items()}
    return replace(exemplar, planes=planes, usable=usable, toroidal=False)
