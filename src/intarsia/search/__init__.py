"""Patch search: candidates, posed exemplars, window grids, and default patch sizes.

A variant is an exemplar in one of the eight isometries (its pose). Variants are numbered by exemplar, then by isometry.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np

from ..analysis import valid_windows, without_patch
from ..analysis.elements import ElementSize, element_size
from ..analysis.features import Features, features, transformed
from ..foundation import ParameterError, lazy
from ..foundation.arrays import Array, Int16, Int32, Int64, Mask, Pair, UInt8
from ..foundation.geometry import ISOMETRIES, ISOMETRY_SETS
from ..foundation.params import extent, words
from ..kernels.maps import OrientedExemplars, PartialMap, gather_all
from ..model import Exemplar, Exemplars, sampled
from ..model.sourcemap import HOLE
from .fourier_kernels import Correlated

if TYPE_CHECKING:
    from ..analysis import symmetry
else:  # where poses are chosen
    symmetry = lazy("intarsia.analysis.symmetry")

Choice = TypeVar("Choice")
Wraps = tuple[bool, bool]  # whether the canvas is toroidal along rows (vertically) and columns (horizontally)

MAX_VARIANTS = 250  # variants are numbered in 8 bits, of which HOLE is one
STRIP = 256  # rows of a map that are converted at a time, which limits memory


@dataclass(frozen=True, eq=False)
class PosedExemplars:
    """The features of all exemplars in all isometries (variants), in one array, as kernels take them.

    A toroidal exemplar is padded on the right and below with its own beginning, so that no window has to be wrapped.
    """

    flat: Int16  # all features, one variant after the other, each (rows, stride, channels)
    table: Int64  # (V, 4): where a variant begins in ``flat``, height, width, and the stride in px
    exemplar: UInt8  # (V,): number of the exemplar
    pose: UInt8  # (V,): number of the isometry, 0 to 7
    # Of every variant, the first pixels of patches that hold usable pixels only; none of variants that are only read.
    valid: tuple[Mask, ...]
    channels: int
    toroidal: Mask  # (V,): whether the exemplar is toroidal

    def __len__(self) -> int:
        return len(self.table)

    @cached_property
    def posed(self) -> OrientedExemplars:
        """The features and their table, as kernels take them."""
        return OrientedExemplars(self.flat, self.table)

    def picture(self, v: int) -> Int16:
        """Return a view of the features of a variant, (rows, stride, channels)."""
        start, _, _, stride = (int(n) for n in self.table[v])
        stop = int(self.table[v + 1, 0]) if v + 1 < len(self) else len(self.flat)
        return self.flat[start:stop].reshape(-1, stride, self.channels)

    def laid_out(self, pictures: Sequence[Array]) -> Array:
        """Return pictures of the exemplars, (H, W) or (H, W, C), posed as all variants and laid out as ``flat``."""
        rows = []
        for v, (number, pose) in enumerate(zip(self.exemplar.tolist(), self.pose.tolist(), strict=True)):
            posed = transformed(pictures[number], pose)
            beyond = [(0, n - m) for n, m in zip(self.picture(v).shape[:2], posed.shape, strict=False)]
            rows.append(np.pad(posed, beyond + [(0, 0)] * (posed.ndim - 2), "wrap").ravel())
        return np.concatenate(rows)

    def showing(self, pictures: Sequence[Array]) -> PosedExemplars:
        """Return the same variants with other features (H, W, C) of the exemplars."""
        channels, table = pictures[0].shape[2], self.table.copy()
        table[:, 0] = table[:, 0] // self.channels * channels
        return replace(self, flat=self.laid_out(pictures), table=table, channels=channels)

    def windows(self, grown: PartialMap, at: Array, patch: Sequence[int]) -> tuple[Array, Array]:
        """Return the features (n, h, w, C) of windows of a map that begin at `at` (n, 2), and masks (n, h, w) uint8.

        The masks are 1 where a pixel is known; features are 0 elsewhere.
        """
        feats, known = np.empty((len(at), *patch, self.channels), np.int16), np.empty((len(at), *patch), np.uint8)
        gather_all(grown, self.posed, at, feats, known)
        return feats, known

    @cached_property
    def turns(self) -> Int64:
        """Coordinate transforms from variant v to variant k: (V, V, 7) of a, b, c, d, e, f, g.

        Pixel (y, x) of v is (a y + b x + e, c y + d x + f) of k, if g is 1. All are 0 for variants of different
        exemplars, and for v = k.
        """
        out = np.zeros((len(self), len(self), 7), np.int64)
        start, j = self.frames[:, 1:3], self.frames[:, 3:7].reshape(-1, 2, 2)
        for v, k in np.ndindex(out.shape[:2]):
            if v != k and self.exemplar[v] == self.exemplar[k]:
                out[v, k] = *(j[k].T @ j[v]).ravel(), *(j[k].T @ (start[v] - start[k])), 1
        return out

    @cached_property
    def frames(self) -> Int64:
        """Transforms of the variants to their exemplars: (V, 7).

        Columns: exemplar; row and column of its pixel at (0, 0) of the variant; the 2 x 2 matrix J by rows. Pixel p of
        the variant is the exemplar's (0, 0) pixel plus J p.
        """
        rows = []
        for v, (_, *size, _) in enumerate(self.table.tolist()):
            iso = ISOMETRIES[self.pose[v]]
            start = iso.start(*(size[::-1] if iso.swaps else size))
            rows.append([self.exemplar[v], *start, *iso.j[0], *iso.j[1]])
        return np.array(rows, np.int64)

    def to_exemplars(self, yx: Int32, variant: UInt8) -> tuple[Int32, UInt8, UInt8]:
        """Convert variant coordinates into (yx, which, pose) of the exemplars; holes have `which` HOLE and `pose` 0."""
        if not self.pose.any():
            which = _lookup(self.exemplar, variant)
            return yx, which, np.zeros_like(which)
        out = np.zeros_like(yx)
        for top in range(0, len(yx), STRIP):
            rows = slice(top, top + STRIP)
            for v, frame in enumerate(self.frames.astype(np.int32)):
                mine = variant[rows] == v
                out[rows][mine] = frame[1:3] + yx[rows][mine] @ frame[3:7].reshape(2, 2).T
        return out, _lookup(self.exemplar, variant), np.where(variant == HOLE, 0, _lookup(self.pose, variant))


def isometry_ids(choice: str | tuple[int, ...]) -> tuple[int, ...]:
    """Return the isometry numbers that an ``isometries`` parameter names."""
    return ISOMETRY_SETS[choice] if isinstance(choice, str) else choice


def posed_exemplars(
    exemplars: Exemplars,
    feats: Features,
    poses: tuple[int, ...],
    patch: Pair,
    shown: tuple[int, ...] = (),
) -> PosedExemplars:
    """Return every exemplar in every isometry of `poses`, for patches of (rows, columns) px.

    Isometries in `shown`, those of a start map, are added as variants that can be read; no patch is taken from them.

    Raises
    ------
    ParameterError
        if there are more than MAX_VARIANTS variants.
    MethodError
        if no patch of any exemplar is free of masked pixels.
    """
    if len(exemplars) * len(poses) > MAX_VARIANTS:
        raise ParameterError(
            f"{len(exemplars)} exemplars in {len(poses)} poses are too many; at most {MAX_VARIANTS} in all."
        )
    blocks, rows, which, pose, valid = [], [], [], [], []
    begin = 0
    for number, exemplar in enumerate(exemplars):
        for p in sorted({*poses, *shown}):
            picture = feats.posed(number, p)
            height, width = picture.shape[:2]
            if exemplar.toroidal:
                picture = np.pad(picture, ((0, patch[0] - 1), (0, patch[1] - 1), (0, 0)), mode="wrap")
            usable = None if exemplar.usable is None else transformed(exemplar.usable, p)
            allowed = valid_windows(picture.shape, usable, exemplar.toroidal, patch)
            valid.append(allowed if p in poses else np.zeros_like(allowed))
            blocks.append(picture.ravel())
            rows.append((begin, height, width, picture.shape[1]))
            which.append(number)
            pose.append(p)
            begin += picture.size
    if not any(v.any() for v in valid):
        raise without_patch(patch)
    flat = blocks[0] if len(blocks) == 1 else np.concatenate(blocks)
    return PosedExemplars(
        flat,
        np.array(rows, np.int64),
        np.array(which, np.uint8),
        np.array(pose, np.uint8),
        tuple(valid),
        feats.pictures[0].shape[2],
        np.array([exemplars[n].toroidal for n in which], bool),
    )


def in_one_row(valid: Sequence[Mask]) -> tuple[UInt8, Int64]:
    """Return the tables of all variants as one flat uint8 table, and (V, 3): begin, rows and columns of each."""
    begins = np.cumsum([0] + [v.size for v in valid])
    offsets = np.array([(b, *v.shape) for b, v in zip(begins.tolist(), valid, strict=False)], np.int64)
    return np.concatenate([v.astype(np.uint8).ravel() for v in valid]), offsets


def _lookup(table: UInt8, variant: Array) -> UInt8:
    full = np.full(256, HOLE, np.uint8)
    full[: len(table)] = table
    out = np.empty(variant.shape, np.uint8)
    for top in range(0, len(variant), STRIP):  # indexing converts numbers to 64 bits: strips limit memory
        out[top : top + STRIP] = full[variant[top : top + STRIP]]
    return out


@dataclass(frozen=True)
class WindowGrid:
    """The windows of a canvas: first rows, first columns, size of a window, size of the canvas, px, and its wraps.

    Windows form a grid, and are named by its row and column; or they lie freely, with first pixels `places`, and are
    named by (number, 0).
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    patch: Pair
    size: Pair
    wraps: Wraps
    places: tuple[Pair, ...] | None = None

    @property
    def shape(self) -> Pair:
        """Rows and columns of windows."""
        return (len(self.rows), len(self.columns)) if self.places is None else (len(self.places), 1)

    def at(self, row: int, column: int) -> Pair:
        """Return the first pixel of a window on the canvas."""
        return (self.rows[row], self.columns[column]) if self.places is None else self.places[row]

    def widened(self, picture: Array, outside: int) -> Array:
        """Return a picture of the canvas padded by a window's size on all sides: wrapped around, or with `outside`."""
        for axis, (size, wrap) in enumerate(zip(self.patch, self.wraps, strict=True)):
            pad = [(size, size) if a == axis else (0, 0) for a in (0, 1)]
            picture = np.pad(picture, pad, mode="wrap") if wrap else np.pad(picture, pad, constant_values=outside)
        return picture

    def of_windows(self, every: Array) -> Array:
        """Select the grid's windows from values of all windows of a :meth:`widened` picture: (rows, columns)."""
        return np.asarray(every[np.ix_(np.array(self.rows) + self.patch[0], np.array(self.columns) + self.patch[1])])

    def within(self, radius: int, places: Array, at: Pair) -> Array:
        """Return which of the places (n, 2) lie within `radius` px of `at` along each axis."""
        gaps = np.abs(places - at)
        for axis, (length, wrap) in enumerate(zip(self.size, self.wraps, strict=True)):
            if wrap:
                gaps[:, axis] = np.minimum(gaps[:, axis], length - gaps[:, axis])
        return np.asarray((gaps <= radius).all(axis=1))


SHORT_LIST = 16  # default number of candidates that a search returns for each window


@dataclass(frozen=True, eq=False)
class Candidates:
    """The candidates of one window: rows of (distance, variant, row, column), best first, and the usual distance.

    A distance is the sum of squared feature differences over the known pixels. ``usual``: about its 5 % quantile over
    the positions of the first variant searched (:func:`.fourier_kernels.patch_distances`); ``feats`` (h, w, C),
    ``known`` (h, w): what the window holds. There are no rows where nothing is known yet, so that any patch fits.
    """

    rows: Int64
    usual: int
    feats: Array
    known: Array

    @classmethod
    def of_all(cls, rows: Array, counts: Array, usual: Sequence[int], feats: Array, known: Array) -> list[Candidates]:
        """Return the candidates of n windows: the first `counts` (n,) of `rows` (n, K, 4), -1: any fits."""
        each = enumerate(zip(counts.tolist(), usual, strict=True))
        return [cls(rows[k, : max(c, 0)], u, feats[k], known[k]) for k, (c, u) in each]


def nearest(rows: Array) -> Array:
    """Return rows of candidates (n, 4) sorted stably by distance."""
    return rows[np.argsort(rows[:, 0], kind="stable")]


@dataclass(frozen=True, eq=False)
class Reduced:
    """Reduced windows, as :class:`.fourier.PatchSearch` correlates them with reduced exemplars."""

    energies: Array  # (n,): sum of squares of each window
    slots: Array  # (n,): which of m masks of known cells is that of the window
    squares: list[Array]  # of each variant (m, rows, columns): its sum of squares under each mask, at each position
    spectra: dict[Pair, Array]  # conjugate spectra of the windows, padded to each shape of a transform

    def correlated(self, v: int, values: Array, valid: Array) -> Correlated:
        """Return correlations with variant `v`, `values` (n, rows, columns), and what is needed for distances."""
        return Correlated(values, self.squares[v], self.slots, self.energies, valid, v)


@dataclass(frozen=True, eq=False)
class Prices:
    """The prices of repeats in the short-list.

    ``counts``: for every variant int32 uses of its coarse positions (rows, columns), 256 = one full repeat. A full
    repeat costs ``weight`` / 65536 of the usual distance.
    """

    counts: list[Array]
    weight: int


class Search(Protocol):
    """A patch search.

    ``valid``: for every variant the coarse positions that can be found, (rows, columns) bool, one for each cell of
    ``factor`` x ``factor`` px; ``cells``: rows and columns of a patch in cells.
    """

    variants: PosedExemplars
    patch: Pair
    valid: list[Array]
    factor: int
    cells: Pair

    def batch(self) -> int:
        """Return how many windows are best searched at a time."""

    def find(self, grown: PartialMap, at: Array, prices: Prices) -> list[Candidates]:
        """Return the candidates for the windows that begin at `at` (n, 2) of a map under synthesis."""


def resolved_isometries(choice: Choice, exemplars: Exemplars, patch: Pair) -> Choice | str | tuple[int, ...]:
    """Return an ``isometries`` parameter, with "auto" resolved for patches of (rows, columns) px."""
    return symmetry.allowed_isometries(exemplars, patch[0] == patch[1]) if choice == "auto" else choice


LEAST = 16  # px: smallest default side of a patch
USUAL = 64  # px: limit up to which a patch holds two elements along a side
LARGEST_SHARE = 0.6  # largest default patch side, relative to the exemplar's shorter side
SUPPLY = 8  # at least 1/SUPPLY of the patches of one exemplar must be free of masked pixels


def elements(exemplar: Exemplar) -> ElementSize:
    """Return the size of the texture's elements, measured once for each exemplar."""
    return exemplar.memo("elements", lambda: element_size(features([exemplar]).pictures[0], exemplar.usable))


def default_patch(exemplars: Exemplars) -> int:
    """Return a patch side in px: the size of the largest elements, or twice that up to 64 px.

    Patches smaller than an element cut all of them; a fine regular texture keeps its rows only if a patch covers two or
    more. At most 0.6 of the exemplar's shorter side, and less where masks leave few patches.
    """
    return patch_with_supply(exemplars, element_patch(exemplars))


def element_patch(exemplars: Exemplars) -> int:
    """Return a patch side in px for the largest elements, regardless of masks."""
    used = sampled(exemplars)
    return patch_for_element(max(elements(e).size for e in used), min(min(e.height, e.width) for e in used))


def free_patch(exemplars: Exemplars, share: int) -> int:
    """Return a patch side in px for graph cuts: `share` per cent of 1.5 times the default, at most 0.4 of the exemplar.

    With seams of free shape a patch is hardly ever visible as a whole, so it may be larger than an element; still
    larger patches make repeats visible. The 0.4 refer to the shorter side of the smallest exemplar, and limit the side
    only above the default. The result is at least 16 px, or the default if that is less, as far as masks allow.
    """
    plain = default_patch(exemplars)
    side = min(min(e.height, e.width) for e in sampled(exemplars))
    large = max(plain, min(3 * plain // 2, 2 * side // 5))
    return patch_with_supply(exemplars, max(large * share // 100, min(plain, LEAST)))


def patch_with_supply(exemplars: Exemplars, patch: int, least: int = LEAST) -> int:
    """Return a patch side, px, of at most `patch`, for which enough patches are free of masked pixels.

    Reduced by an eighth at a time, down to `least`, until 1/SUPPLY of the patches of one exemplar are free; then, if
    none is, by 1 px at a time until one is.
    """
    if all(e.usable is None for e in exemplars):
        return patch
    while patch > least and not any(SUPPLY * free >= every for free, every in _places(exemplars, patch)):
        patch = max(patch - max(patch // 8, 1), least)
    while patch > 1 and not any(free for free, _ in _places(exemplars, patch)):
        patch -= 1
    return patch


def _places(exemplars: Exemplars, patch: int) -> list[Pair]:
    """Return for every exemplar the number of patches of this size without masked pixels, and of all."""
    free = [valid_windows((e.height, e.width), e.usable, e.toroidal, (patch, patch)) for e in exemplars]
    return [(int(np.count_nonzero(f)), max(f.size, 1)) for f in free]


def patch_for_element(element: float, side: int) -> int:
    """Return the patch side, px, for elements of `element` px in an exemplar whose shorter side is `side` px."""
    wanted = max(element, min(2 * element, USUAL), LEAST)
    return int(min(wanted, max(LARGEST_SHARE * side, min(side, 3)), side))


def check_patch(
    patch: int | Pair,
    exemplars: Exemplars,
    isometries: str | tuple[int, ...] = "none",
    seams: int | Pair = 0,
) -> None:
    """Raise ParameterError or MethodError for a patch that fits nowhere, or is to be rotated and is not square.

    `seams`: (rows, columns) px of the exemplar that a patch needs on every side of it.
    """
    rows, columns = extent(patch)
    down, across = extent(seams)
    whole = (rows + 2 * down, columns + 2 * across)
    described = f"patch={words((rows, columns))}"
    if any((down, across)):
        described += f" with its seams of {words((down, across))} px"
    if whole[0] != whole[1] and any(ISOMETRIES[p].swaps for p in isometry_ids(isometries)):
        raise ParameterError(f"{described} is not square; rotations need a square patch.")
    for e in sampled(exemplars):
        if (whole[0] > e.height or whole[1] > e.width) and not e.toroidal:
            most = max(min(e.width - 2 * across, e.height - 2 * down), 0)
            choose = f"choose at most {most}" if most else "choose narrower seams"
            raise ParameterError(
                f"{described} is larger than the exemplar ({e.width} x {e.height} px); {choose}, or a larger exemplar."
            )
    if not any(valid_windows((e.height, e.width), e.usable, e.toroidal, (rows, columns)).any() for e in exemplars):
        raise without_patch((rows, columns))
