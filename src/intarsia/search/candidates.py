"""What a search for patches is asked, and what it answers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from ..arrays import Array, Int64, Pair
from ..kernels.windows import Grown
from .fourier_kernels import Correlated, Fee
from .posed import PosedExemplars


@dataclass(frozen=True)
class WindowGrid:
    """The windows of a canvas: first rows, first columns, their size, and the canvas they lie on.

    Windows are a grid, named by row and column of it; or they lie freely at `places`, named by (number, 0).
    """

    rows: tuple[int, ...]
    columns: tuple[int, ...]
    patch: Pair
    height: int
    width: int
    wrap_y: bool
    wrap_x: bool
    places: tuple[Pair, ...] | None = None

    @property
    def shape(self) -> Pair:
        """Rows and columns of windows."""
        return (len(self.rows), len(self.columns)) if self.places is None else (len(self.places), 1)

    def at(self, row: int, column: int) -> Pair:
        """First pixel of a window on the canvas."""
        return (self.rows[row], self.columns[column]) if self.places is None else self.places[row]

    @property
    def wraps(self) -> tuple[bool, bool]:
        """Whether rows and columns continue in themselves."""
        return self.wrap_y, self.wrap_x

    def widened(self, picture: Array, outside: int) -> Array:
        """A picture of the canvas with a window's size more on all sides: around the torus, or `outside`."""
        for axis, (size, wrap) in enumerate(zip(self.patch, self.wraps, strict=True)):
            pad = [(size, size) if a == axis else (0, 0) for a in (0, 1)]
            picture = np.pad(picture, pad, mode="wrap") if wrap else np.pad(picture, pad, constant_values=outside)
        return picture

    def of_windows(self, every: Array) -> Array:
        """Of what is known of all windows of a :meth:`widened` picture, that of the grid's own: (rows, columns)."""
        return np.asarray(every[np.ix_(np.array(self.rows) + self.patch[0], np.array(self.columns) + self.patch[1])])

    def within(self, radius: int, places: Array, at: Pair) -> Array:
        """Which of the places (n, 2) lie within a radius of one, along each axis."""
        gaps = np.abs(places - at)
        for axis, (length, wrap) in enumerate(zip((self.height, self.width), self.wraps, strict=True)):
            if wrap:
                gaps[:, axis] = np.minimum(gaps[:, axis], length - gaps[:, axis])
        return np.asarray((gaps <= radius).all(axis=1))


SHORT_LIST = 16  # candidates kept of every search, where a method does not ask for more


@dataclass(frozen=True, eq=False)
class Candidates:
    """What fits one window: rows of (distance, variant, row, column), best first, and the usual distance.

    ``usual`` is the 5 % quantile of the distance over all positions, in units of the exact distance; ``feats``
    and ``known`` are what the window holds; ``free`` says that nothing is known in it yet: any patch fits;
    ``permitted`` that none of the rows returns too near.
    """

    rows: Int64
    usual: int
    feats: Array
    known: Array
    free: bool = False
    permitted: bool = False

    @classmethod
    def of_all(cls, rows: Array, counts: Array, usual: Sequence[int], feats: Array, known: Array) -> list[Candidates]:
        """Take what kernels found for n windows apart: `counts` (n,) of the `rows` (n, K, 4), -1 where any fits."""
        each = enumerate(zip(counts.tolist(), usual, strict=True))
        return [cls(rows[k, : max(c, 0)], u, feats[k], known[k], free=c < 0) for k, (c, u) in each]


def nearest(rows: Array) -> Array:
    """Return rows of candidates (n, 4) in the order of their distances; of those as far the first comes first."""
    return rows[np.argsort(rows[:, 0], kind="stable")]


@dataclass(frozen=True, eq=False)
class Reduced:
    """Windows as the search compares them: energies, spectra by shape, and the exemplars' energy under their masks.

    ``slots`` says which of the ``squares`` of every variant belongs to which window.
    """

    energies: Array
    slots: Array
    squares: list[Array]
    spectra: dict[Pair, Array]

    def only(self, which: Any) -> Reduced:
        """Return some of the windows, by an index of NumPy; the spectra stay those of all."""
        return replace(self, energies=self.energies[which], slots=self.slots[which])

    def correlated(self, v: int, values: Array, valid: Array) -> Correlated:
        """Put correlations with a variant, `values` (n, rows, columns), beside what turns them into distances."""
        return Correlated(values, self.squares[v], self.slots, self.energies, valid, v)


@dataclass(frozen=True, eq=False)
class Prices:
    """The prices of repeats, as the short-list takes them into account.

    ``counts``: for every variant an int32 map over its coarse positions, 256 = one full repeat. Such a repeat
    costs ``weight`` / 65536 of the usual distance.
    """

    counts: list[Array]
    weight: int

    def of(self, v: int) -> Fee:
        """Return the prices of one variant."""
        return Fee(self.counts[v], self.weight)


class Search(Protocol):
    """A way to find patches: what growing a map needs of it.

    ``valid``: for every variant the positions that can be found, each for `factor` x `factor` px of it; ``cells``:
    the patch in such units.
    """

    variants: PosedExemplars
    patch: Pair
    valid: list[Array]
    factor: int
    cells: Pair

    def batch(self) -> int:
        """How many windows are best searched together."""

    def find(self, grown: Grown, at: Array, prices: Prices) -> list[Candidates]:
        """Return the candidates for the windows that begin at `at` (n, 2) of a growing map."""
