"""Rectification: exemplars whose courses slant, converge or bow are straightened by moving pixels by whole px.

Every pixel of the rectified exemplar is one of the exemplar, so that copies stay exact; where courses are widened some
pixels are used twice, where they are narrowed some are left out. The phase of the courses, a polynomial through the
beds, gives the new position across the courses; along them rows are sheared so that head joints become upright.

Source: Lopez Recas 2011, chapter 6 (geometry corrected before the synthesis); the procedure is not given there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from statistics import median_high

import numpy as np

from ..analysis import blocks
from ..analysis.features import features
from ..foundation.arrays import Array, Int32, Int64, Mask, Pair
from ..foundation.filters import blurred
from ..foundation.params import Steps, Weights
from ..lattice import check_lattice, find_lattice, lattice_of, lattices_of, vectors_of
from ..lattice.decision import Lattice
from ..model import Exemplar
from ..model.image import Plane
from .unequal_courses import clear_masonry, unequal_masonry_or_none

TERMS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3), (1, 3))
"""Powers (across, along) of the polynomial, as perspective and a bow need them."""
TURN = 1 << 16  # units of phase per course; coefficients are whole numbers of them


class Following:
    """Fit of the phase to beds. Halved and doubled on 5 drawn walls and 7 photographs (docs/design/012)."""

    places = 64  # samples of each bed; halved and doubled: the same
    stray = 0.2  # courses: samples with this residual have weight 1/2; halved and doubled: the same
    loose = 0.04  # courses: with a larger median residual heights differ, and the fit fails; doubled: 3 more fit
    faint = 0.001  # ridge that keeps coefficients not determined by the beds near 0; halved and doubled: the same
    fits = 4  # iterations of reweighted least squares; halved and doubled: the same

LEAST = 8  # least usable samples of a bed; beds with fewer are left out
AROUND = 2  # distances of beds to either side whose median is the local pitch


def _factors(beds: Int64, usable: Mask) -> list[int] | None:
    """Return the coefficients of TERMS, 1 / TURN courses, of the phase through the beds; None if heights differ.

    None, too, for fewer than three beds. `beds` (n, W): rows, px; the polynomial's variables run from -1 to 1 over the
    exemplar. Only places at pixels of `usable` (H, W) are fitted.
    """
    height, width = usable.shape
    x = np.arange(0, width, max(width // Following.places, 1))
    y = beds[:, x]
    seen = (y >= 0) & (y < height) & usable[np.clip(y, 0, height - 1), x]
    known = seen.sum(axis=1) >= LEAST
    if known.sum() < 3:
        return None
    y, seen = y[known], seen[known]
    across, along = (2.0 * y + 1 - height) / height, (2.0 * x + 1 - width) / width
    a = np.stack([(across**i * along**j)[seen] for i, j in TERMS], axis=1)
    b = np.repeat(_numbered(y, seen), seen.sum(axis=1))
    ridge = Following.faint * len(b) * np.diag([0.0] * 3 + [1.0] * (len(TERMS) - 3))
    sure = np.ones(len(b))
    for _ in range(Following.fits):
        left = np.einsum("ki,kj,k->ij", a, a, sure) + ridge
        found = np.linalg.solve(left, np.einsum("ki,k,k->i", a, b, sure))
        off = np.abs(a @ found - b)
        sure = 1 / (1 + (off / Following.stray) ** 2)
    return [int(v) for v in np.rint(found * TURN)] if np.median(off) < Following.loose else None


def _numbered(y: Array, seen: Array) -> Array:
    """Return the number of each bed (n, places), counting missing ones, by the local pitch."""
    both = seen[1:] & seen[:-1]
    gaps = np.where(both, np.diff(y, axis=0), 0).sum(axis=1) / np.maximum(both.sum(axis=1), 1)
    usual = [median_high(gaps[max(k - AROUND, 0) : k + AROUND + 1]) for k in range(len(gaps))]
    return np.concatenate([[0], np.cumsum(np.rint(gaps / np.maximum(usual, 1)))])


def _phase(factors: list[int], shape: Pair) -> Int64:
    """Return the phase of every pixel, 1 / TURN courses; products one by one, the same on every machine."""
    across, along = (np.asarray((2.0 * np.arange(n) + 1 - n) / n) for n in shape)
    terms = zip(factors, TERMS, strict=True)
    parts = (math.prod([across[:, None]] * i + [along] * j, start=float(f)) for f, (i, j) in terms)
    return np.asarray(np.rint(sum(parts) + np.zeros(shape)), np.int64)


class Gain:
    """Use of the rectified exemplar: of 163 textures nine can be straightened, two gain (docs/design/012)."""

    least = 1.4  # least ratio of confidence to that unrectified; 1: stone blocks are rectified (1.2), 2.8: only one is
    clear = 2.0  # least ratio of confidence to its threshold if unrectified it has no lattice; halved, doubled: same
    off = 3.0  # px: least bend; patches aligned to the lattice follow smaller ones; halved and doubled: the same
    level = 2.0  # px: courses that slant by less over the exemplar are made level; 1 px at each end is rounding


@dataclass(frozen=True, eq=False)
class Rectified:
    """The exemplar that blocks are read from, its lattice, (x, y) px, and its rectification, or None."""

    exemplar: Exemplar
    lattice: Steps
    straight: Rectification | None

    def to_exemplar(self, yx: Int32) -> Int32:
        """Return the pixels of the given exemplar for pixels of the rectified one."""
        return yx if self.straight is None else np.ascontiguousarray(self.straight.yx[yx[..., 0], yx[..., 1]])


def rectified_for(
    exemplar: Exemplar, slug: str, lattice: Steps | None = None, choice: str = "auto", weights: Weights = None
) -> Rectified:
    """Decide whether to rectify, and find the lattice. Raise MethodError, naming the method `slug`, if there is none.

    `choice`: auto, on or off. With given vectors, `lattice` (x, y) px, ``auto`` leaves the exemplar as it is; with
    ``on`` they are those of the rectified one.
    """
    if lattice is not None:
        straight = straight_of(exemplar, weights) if choice == "on" else None
        laid = exemplar if straight is None else straight.exemplar
        check_lattice(lattice, laid)
        return Rectified(laid, lattice, straight)
    better = None
    if choice != "off":
        better = rectified_if_better(exemplar, weights) if choice == "auto" else rectified_lattice(exemplar, weights)
    if better is not None:
        return Rectified(better[0].exemplar, vectors_of(better[1]), better[0])
    return Rectified(exemplar, lattice_of(exemplar, slug, weights), None)


def rectified_if_better(exemplar: Exemplar, weights: Weights = None) -> tuple[Rectification, Lattice] | None:
    """Return the rectified exemplar and its lattice, if that is much more confident than as it is; else None.

    None, too, if the exemplar has two vectors as it is: patches aligned to that lattice follow its bends.
    """
    plain = lattices_of(exemplar, weights).accepted
    if plain is not None and plain.kind == "2-D":
        return None
    if plain is None and clear_masonry(exemplar, weights) is None:
        return None  # 138 of 199 textures have no lattice; only two, of bricks, gain
    straight = straight_of(exemplar, weights)
    found = None if straight is None or straight.off < Gain.off else rectified_lattice(exemplar, weights)
    if found is None:
        return None
    if plain is None:
        return found if found[1].share >= Gain.clear else None
    return found if found[1].confidence >= Gain.least * plain.confidence else None


def rectified_lattice(exemplar: Exemplar, weights: Weights = None) -> tuple[Rectification, Lattice] | None:
    """Return the rectified exemplar and its lattice; None if it is straight already, or has none."""
    straight = straight_of(exemplar, weights)
    if straight is None:
        return None
    laid = straight.exemplar
    found = find_lattice(features([laid], weights).pictures[0], laid.usable, courses=True).accepted
    return None if found is None else (straight, _level(found, laid))


def _level(found: Lattice, laid: Exemplar) -> Lattice:
    """Return the lattice with courses that slant by less than `Gain.level` px made level."""
    ((y, x),) = found.vectors
    if abs(x) * laid.width < Gain.level * abs(y):
        return replace(found, vectors=((abs(y), 0),))
    return replace(found, vectors=((0, abs(x)),)) if abs(y) * laid.height < Gain.level * abs(x) else found


LEAN = 256  # units of the lean of head joints per px


class Bending:
    """Bounds of rectification; each was halved and doubled (docs/design/012)."""

    move = 1.0  # px: least largest displacement, as pixels move by whole px; halved: a straight wall is bent
    narrowest = 0.5  # least factor by which a course is widened anywhere; halved: the same, doubled: none is rectified
    widest = 2.0  # largest such factor; doubled: the same, halved: none is rectified
    steepest = 0.35  # px down per px along: largest slant of courses; halved and doubled: the same
    strong = 0.05  # share of the steep edges taken as joints, the strongest; halved, doubled: lean by other 1 / LEAN


@dataclass(frozen=True, eq=False)
class Rectification:
    """A rectified exemplar."""

    exemplar: Exemplar  # the rectified exemplar; pixels from outside the given one are not usable
    yx: Int32  # (H, W, 2): for each of its pixels the pixel of the given exemplar
    slant: float  # px down per px along (or px aside per px down) by which the courses leaned
    converging: float  # how much wider the courses are at one end than at the other, as a share
    off: float  # how far courses lay from straight, parallel and equal ones at most, px


def straight_of(exemplar: Exemplar, weights: Weights = None) -> Rectification | None:
    """Rectify the courses of an exemplar; None if there are none, or they are straight already."""
    return exemplar.memo(("straight", weights), lambda: _straight(exemplar, weights))


def _straight(exemplar: Exemplar, weights: Weights) -> Rectification | None:
    """Rectify by the beds; None if they do not fit a polynomial phase within the bounds, or are straight already."""
    wall = unequal_masonry_or_none(exemplar, weights)
    if wall is None:
        return None
    usable = exemplar.free.T if wall.upright else exemplar.free
    factors = _factors(wall.work.beds, usable)
    if factors is None:
        return None
    at = _phase(factors, usable.shape)
    pitch, slope, off = _flat(at)
    steps = np.diff(at, axis=0) * pitch
    if steps.min() < TURN * Bending.narrowest or steps.max() > TURN * Bending.widest:
        return None
    if abs(slope) > Bending.steepest or max(off, abs(slope) * usable.shape[1]) < Bending.move:
        return None
    lean = _lean(wall.picture, usable)
    yx, inside = _moved(at, round(pitch * 256), lean)
    ends = np.diff(at[[0, -1]], axis=0)[0]
    converging = float(ends.max() / ends.min() - 1)
    inside &= usable[yx[..., 0], yx[..., 1]]
    if wall.upright:
        yx, inside = yx.swapaxes(0, 1)[..., ::-1], inside.T
    whole = np.ascontiguousarray(yx, np.int32)
    return Rectification(_gathered(exemplar, whole, inside), whole, slope, converging, off)


def _flat(at: Int64) -> tuple[float, float, float]:
    """Return the straight equal courses nearest to a phase: pitch px, slope, and the largest distance, px."""
    height, width = at.shape
    y, x = np.arange(height) * 2 + 1 - height, np.arange(width) * 2 + 1 - width
    # Sums of whole numbers; y and x each sum to 0, so that the slopes of least squares are quotients.
    down = int((at.sum(axis=1) * y).sum()) / (width * int((y * y).sum()))
    along = int((at.sum(axis=0) * x).sum()) / (height * int((x * x).sum()))
    left = at - int(at.sum()) / at.size - down * y[:, None] - along * x
    return TURN / (2 * down), -along / down, float(np.abs(left).max() / (2 * down))


def _lean(picture: Array, usable: Mask) -> int:
    """Return how far head joints lean, 1 / LEAN px along for each px across, from the strongest edges."""
    smooth = np.rint(blurred(picture.astype(np.float64), 1.5, "symmetric") * 16).astype(np.int64)
    across, along = np.zeros(smooth.shape, np.int64), np.zeros(smooth.shape, np.int64)
    across[1:-1], along[:, 1:-1] = smooth[2:] - smooth[:-2], smooth[:, 2:] - smooth[:, :-2]
    square = (along * along).sum(axis=2)
    steep = usable & (square > 4 * (across * across).sum(axis=2))
    if steep.sum() < 100:
        return 0
    strong = steep & (square >= np.sort(square[steep])[-max(100, int(Bending.strong * steep.sum()))])
    return int(np.rint(-LEAN * int((across * along).sum(axis=2)[strong].sum()) / max(int(square[strong].sum()), 1)))


def _moved(at: Int64, pitch: int, lean: int) -> tuple[Int64, Mask]:
    """Return the pixel of each place of the rectified exemplar (courses along x, `pitch` 1/256 px), and which exist."""
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


def _gathered(exemplar: Exemplar, yx: Int32, usable: Mask) -> Exemplar:
    """Return the exemplar with pixels gathered from `yx` in all planes; vectors of normal maps are not rotated."""

    def moved(plane: Plane) -> Plane:
        pixels, y, x = plane.pixels, yx[..., 0], yx[..., 1]
        if plane.height < exemplar.height:
            s = exemplar.height // plane.height
            return replace(plane, pixels=pixels[y // s, x // s])
        s = plane.height // exemplar.height
        taken = blocks(pixels, s)[y, :, x].swapaxes(1, 2)
        return replace(plane, pixels=taken.reshape(y.shape[0] * s, y.shape[1] * s, *pixels.shape[2:]))

    planes = {name: moved(p) for name, p in exemplar.planes.items()}
    return replace(exemplar, planes=planes, usable=usable, toroidal=False)
