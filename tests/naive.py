"""Slow and obvious truth, written without regard to speed: what the package must agree with.

The seams have their own file, naive_cuts.py; the rendering has naive_votes.py.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from intarsia.analysis.features import Features, features
from intarsia.foundation.geometry import ISOMETRIES, Wrap, spread
from intarsia.foundation.run import below, draw
from intarsia.kernels.cuts import PLAIN, min_cut, seam_costs
from intarsia.model import Exemplar
from intarsia.model.sourcemap import SourceMap

OLD, FREE, NEW = 0, 1, 2


def lay_down(block: NDArray, isometry: int) -> NDArray:
    """Lay a block (H, W, ...) down in an isometry, by the table of Multrus 2003, 4.1.1, pixel by pixel."""
    height, width = block.shape[:2]
    swaps = isometry in (3, 4, 5, 7)
    out = np.empty((width, height, *block.shape[2:]) if swaps else block.shape, block.dtype)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = block[shown_pixel(isometry, height, width, i, j)]
    return out


def shown_pixel(isometry: int, height: int, width: int, i: int, j: int) -> tuple[int, int]:
    """Return the pixel of a height x width block that is shown at (i, j) when it is laid down."""
    return (
        (i, j),
        (i, width - 1 - j),
        (height - 1 - i, j),
        (j, i),
        (height - 1 - j, width - 1 - i),
        (j, width - 1 - i),
        (height - 1 - i, width - 1 - j),
        (height - 1 - j, i),
    )[isometry]


@dataclass(frozen=True)
class Posed:
    """An exemplar in one isometry: its features, and which of its pixels may be used."""

    number: int
    isometry: int
    picture: NDArray[np.int16]
    usable: NDArray[np.bool_]
    toroidal: bool
    size: tuple[int, int]

    def windows(self, patch: tuple[int, int]) -> Iterator[tuple[int, int, NDArray[np.int16]]]:
        """Yield (row, column, features) of every window of usable pixels."""
        height, width = self.picture.shape[:2]
        rows, columns = (height, width) if self.toroidal else (height - patch[0] + 1, width - patch[1] + 1)
        for y in range(rows):
            for x in range(columns):
                index = np.ix_((y + np.arange(patch[0])) % height, (x + np.arange(patch[1])) % width)
                if self.usable[index].all():
                    yield y, x, self.picture[index]

    def pixel(self, y: int, x: int) -> tuple[int, int]:
        """Return the exemplar pixel that is (y, x) of the posed picture."""
        height, width = self.picture.shape[:2]
        return shown_pixel(self.isometry, *self.size, y % height, x % width)


def posed(exemplars: Sequence[Exemplar], isometries: Sequence[int], feats: Features | None = None) -> list[Posed]:
    """Lay every exemplar down in every isometry (colours only: vectors would turn)."""
    feats = feats or features(exemplars)
    return [
        Posed(
            n, k, lay_down(feats.pictures[n], k),
            lay_down(np.ones((e.height, e.width), bool) if e.usable is None else e.usable, k),
            e.toroidal, (e.height, e.width),
        )
        for n, e in enumerate(exemplars)
        for k in sorted(isometries)
    ]  # fmt: skip


def all_distances(
    window: NDArray[np.int16], known: NDArray[np.bool_], variants: Sequence[Posed]
) -> list[tuple[int, int, int, int]]:
    """Return (squared distance over the known pixels, variant, row, column) of every usable patch."""
    found = []
    for v, variant in enumerate(variants):
        for y, x, patch in variant.windows(known.shape):
            difference = window[known].astype(np.int64) - patch[known]
            found.append((int((difference**2).sum()), v, y, x))
    return found


def neighbours(y: int, x: int) -> tuple[tuple[int, int], ...]:
    return (y + 1, x), (y - 1, x), (y, x + 1), (y, x - 1)


class NaiveQuilting:
    """Image quilting patch by patch in raster order: the best patch of all, cut along the cheapest seam.

    Only what decides at tolerance 0 and without a price on repetition; equal patches are drawn among. The draws
    are those of the package, and so the map must be the same.
    """

    def __init__(
        self, exemplars: Sequence[Exemplar], size: tuple[int, int], patch: int, overlap: int, seed: int,
        wrap: Wrap = Wrap.NONE, isometries: Sequence[int] = (0,),
    ) -> None:  # fmt: skip
        self.exemplars, self.size, self.seed, self.wrap = exemplars, size, seed, wrap
        self.variants = posed(exemplars, isometries)
        self.rows, height = spread(size[0], patch, overlap, wrap.y)
        self.columns, width = spread(size[1], patch, overlap, wrap.x)
        self.patch = height, width
        self.known = np.zeros(size, bool)
        self.feats = np.zeros((*size, self.variants[0].picture.shape[2]), np.int16)
        self.shown = np.zeros((*size, 4), int)  # exemplar, isometry, row, column

    def run(self, order: Sequence[tuple[int, int]] | None = None) -> NDArray[np.int_]:
        """Return, for every pixel, exemplar, isometry, row and column: (H, W, 4). Raster order by default."""
        for r, c in order or itertools.product(range(len(self.rows)), range(len(self.columns))):
            self.lay(self.rows[r], self.columns[c], draw(self.seed, 2002, 0, r, c))
        return self.shown

    def lay(self, y: int, x: int, bits: int) -> None:
        index = np.ix_(*((a + np.arange(p)) % n for a, p, n in zip((y, x), self.patch, self.size, strict=True)))
        known, old = self.known[index], self.feats[index]
        found = all_distances(old, known, self.variants)
        if known.any():
            best = min(found)[0]
            found = sorted(f for f in found if f[0] == best)
        _, v, row, column = found[below(len(found), bits)]
        variant = self.variants[v]
        new = next(p for a, b, p in variant.windows(self.patch) if (a, b) == (row, column))
        take = np.ones(self.patch, np.uint8)
        if known.any():
            right, down = seam_costs(np.where(known[:, :, None], old, new), np.ascontiguousarray(new), PLAIN)
            min_cut(self.state(y, x, known), right, down, take)
        for i, j in zip(*np.nonzero(take), strict=True):
            at = (y + i) % self.size[0], (x + j) % self.size[1]
            self.known[at], self.feats[at] = True, new[i, j]
            self.shown[at] = variant.number, variant.isometry, *variant.pixel(row + i, column + j)

    def state(self, y: int, x: int, known: NDArray[np.bool_]) -> NDArray[np.uint8]:
        """Old pixels with known neighbours outside the window stay, those beside unknown ones in it go."""
        state = np.full(self.patch, FREE, np.uint8)
        for i in range(self.patch[0]):
            for j in range(self.patch[1]):
                near = list(neighbours(i, j))
                if not known[i, j] or any(self._unknown(known, a, b) for a, b in near):
                    state[i, j] = NEW
                if known[i, j] and any(self._known_outside(y, x, a, b) for a, b in near):
                    state[i, j] = OLD
        return state

    def _unknown(self, known: NDArray[np.bool_], a: int, b: int) -> bool:
        return self._inside(a, b) and not known[a, b]

    def _inside(self, a: int, b: int) -> bool:
        return 0 <= a < self.patch[0] and 0 <= b < self.patch[1]

    def _known_outside(self, y: int, x: int, a: int, b: int) -> bool:
        if self._inside(a, b):
            return False
        height, width = self.size
        if (not self.wrap.y and not 0 <= y + a < height) or (not self.wrap.x and not 0 <= x + b < width):
            return False
        # A window as long as the canvas meets itself across the border: that is not outside.
        if (self.patch[0] == height and not 0 <= a < height) or (self.patch[1] == width and not 0 <= b < width):
            return False
        return bool(self.known[(y + a) % height, (x + b) % width])


def shares(smap: SourceMap, exemplars: Sequence[Exemplar]) -> float:
    """Return which share of all exemplar pixels is shown at least once."""
    which = np.zeros((smap.height, smap.width), int) if smap.which is None else smap.which
    shown = {(int(n), int(y), int(x)) for n, (y, x) in zip(which.ravel(), smap.yx.reshape(-1, 2), strict=True)}
    return len(shown) / sum(e.height * e.width for e in exemplars)


def joins(smap: SourceMap, axis: int) -> NDArray[np.bool_]:
    """Return where a pixel and its next along an axis do not continue one another, the last with the first."""
    which = np.zeros((smap.height, smap.width), int) if smap.which is None else smap.which
    pose = np.zeros((smap.height, smap.width), int) if smap.pose is None else smap.pose
    out = np.empty((smap.height, smap.width), bool)
    for y in range(smap.height):
        for x in range(smap.width):
            b, a = ((y + 1) % smap.height, x) if axis == 0 else (y, (x + 1) % smap.width)
            j = ISOMETRIES[pose[y, x]].j
            step = smap.yx[y, x] + (j[0][axis], j[1][axis])
            same = which[y, x] == which[b, a] and pose[y, x] == pose[b, a]
            out[y, x] = not same or tuple(step) != tuple(smap.yx[b, a])
    return out


def edge_pixels(
    locked: NDArray[np.bool_], at: tuple[int, int], wrap: tuple[bool, bool], known: NDArray[np.uint8]
) -> list[tuple[int, int]]:
    """List the known pixels of a window that must stay and lie within 3 px, corners included, of an unknown one."""
    out = []
    for i, j in np.argwhere(known).tolist():
        y, x = at[0] + i, at[1] + j
        y, x = y % locked.shape[0] if wrap[0] else y, x % locked.shape[1] if wrap[1] else x
        inside = 0 <= y < locked.shape[0] and 0 <= x < locked.shape[1]
        beside = (known[max(i - 3, 0) : i + 4, max(j - 3, 0) : j + 4] == 0).any()
        if inside and locked[y, x] and beside:
            out.append((i, j))
    return out


def edge_difference(old: NDArray[np.int16], new: NDArray[np.int16], edge: Sequence[tuple[int, int]]) -> int:
    """How badly two windows (h, w, C) agree at edge pixels: plainly, in tone, and in grain, by cells of 8 px."""
    cells: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for i, j in edge:
        cells.setdefault((i // 8, j // 8), []).append((i, j))
    plain, tone, grains = 0, 0, [0, 0]
    for c in range(old.shape[2]):
        for pixels in cells.values():
            apart = [int(old[p][c]) - int(new[p][c]) for p in pixels]
            plain += sum(d * d for d in apart)
            tone += 8 * sum(apart) ** 2 // len(apart)
            for k, picture in enumerate((old, new)):
                values = [int(picture[p][c]) for p in pixels]
                grains[k] += sum(v * v for v in values) - sum(values) ** 2 // len(values)
    rough = np.sqrt(grains[0]) - np.sqrt(grains[1])
    return plain + tone + int(4 * rough * rough)


def unbroken(smap: SourceMap, axis: int) -> NDArray[np.bool_]:
    """Say where a pixel and the next along an axis (the first after the last) continue one another."""
    which, pose = smap.numbers, smap.turns
    step = np.array([(i.j[0][axis], i.j[1][axis]) for i in ISOMETRIES])[pose]
    yx, other, turned = (np.roll(a, -1, axis) for a in (smap.yx, which, pose))
    return np.asarray((yx == smap.yx + step).all(axis=2) & (other == which) & (turned == pose))
