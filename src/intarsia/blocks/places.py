"""Where in the exemplar a mosaic's blocks may be read, and how often each place is to be: all of it equally often.

Where places overlap (blocks of half periods, periods completed from others) the middle of an exemplar lies in many
places, its edges in few: read equally often, they would show the edges less. So a place's share falls while its px are
shown more often than the mean, and rises while they are shown less: steps towards the least sum of squares of how
often px are shown. Shares are whole numbers; equal ones are left where places show the exemplar evenly enough.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..draws import below
from ..errors import MethodError
from ..lattice.vectors import UNIT
from .completed import Continued, continued
from .gap_table import MOST_PLACES
from .grid import BlockGrid, BlockSettings, Cell, block_places, block_vectors, phased
from .pose_sheet import Places, Sheet

SAMPLES = 16  # px of a block along each side that are looked at
BINS = 8  # of a block's side, in which shown px are counted
WHOLE = 1 << 16  # sum of the shares of the places that one block may be read from
EVEN = 5  # percent more or less often than the mean that px may be shown
MOST = 2  # times more or less often than the mean a place may be read
ROUNDS = 20
Shares = dict[tuple[int, int], NDArray[np.int64]]


class FewPlaces(MethodError):
    """The exemplar holds too little for a mosaic; its best tile can still be repeated."""


def grid_and_places(
    settings: BlockSettings, picture: NDArray[np.int16], usable: NDArray[np.bool_], cell: Cell, element: float
) -> tuple[BlockGrid, Continued, Places]:
    """Choose the blocks and complete the periods around them; smaller ones where there are too few places for large.

    Returns the grid as it lies in the exemplar, what blocks are read from, and their places there.
    """
    room = int(picture.shape[0]), int(picture.shape[1])
    wide = min(max(1.5 * element, 48.0), min(room) / 2.5)
    target = float(settings.block) if settings.block is not None else None
    down, across = block_vectors(*cell, 1.0, wide, room)  # one period
    periods = down[0] / UNIT, across[1] / UNIT
    for wanted in (target, 1.0):
        rows, columns = block_vectors(*cell, wanted, wide, room)
        grid, costs = phased(picture, rows, columns, cell, settings.border)
        ground = continued(picture, usable, grid, periods, costs, settings.border)
        placed = ground.placed(grid)
        places = {(i, j): block_places(placed, ground.usable, (i, j)) for i in (0, 1) for j in (0, 1)}
        if min(len(p) for p in places.values()) >= 2:
            return grid, ground, places
    raise FewPlaces("the exemplar holds fewer than two places for a block of one period; give a larger exemplar.")


def place_shares(grid: BlockGrid, sheet: Sheet, nearest: NDArray[np.intp] | None, places: Places) -> Shares:
    """Shares of the places by the parity of row and column, as `places`; equal ones where they are many.

    `grid`: the blocks as they lie on the sheet; `nearest`: for every px of it the nearest usable one, or None.
    """
    counts = {kind: len(some) for kind, some in places.items()}
    equal = {kind: np.full(n, WHOLE // n, np.int64) for kind, n in counts.items()}
    if max(counts.values()) > MOST_PLACES:
        return equal
    shown, size = _parts_shown(grid, sheet, nearest, np.concatenate(list(places.values())))
    ends = np.cumsum(list(counts.values()))
    evened = np.split(_even_shares(shown, size, np.split(np.arange(len(shown)), ends[:-1])), ends[:-1])
    return dict(zip(counts, evened, strict=True))


def dealt(shares: NDArray[np.int64], bits: int, order: list[int]) -> list[int]:
    """One place for each number of `order`, each place as often as its share says, rounded up or down by drawn bits."""
    if shares.min() == shares.max():
        return order
    ends = np.cumsum(shares)
    step = int(ends[-1]) // len(order)
    at = np.array(order, np.int64) * step + below(step, bits)
    found: list[int] = np.searchsorted(ends, at, side="right").tolist()
    return found


def _parts_shown(
    grid: BlockGrid, sheet: Sheet, nearest: NDArray[np.intp] | None, places: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The part of the exemplar that each of a block's px shows at each place, (n, px), and how many px it has."""
    half, parts = 2 * np.indices((SAMPLES, SAMPLES)).reshape(2, -1, 1) + 1, 2 * SAMPLES
    offsets = (half[0] * grid.rows + half[1] * grid.columns) // parts
    y, x = np.moveaxis((places[:, None] + offsets) // UNIT, 2, 0)
    y, x = np.clip(y, 0, sheet.usable.shape[0] - 1), np.clip(x, 0, sheet.usable.shape[1] - 1)
    if nearest is not None:
        y, x = nearest[0][y, x], nearest[1][y, x]
    yx, _ = sheet.to_exemplar(np.stack([y, x], axis=-1).astype(np.int32))
    side = max(1, round(grid.determinant**0.5 / UNIT / BINS))
    height, width = int(sheet.source[..., 0].max()) + 1, int(sheet.source[..., 1].max()) + 1
    across = -(-width // side)
    rows, columns = (np.bincount(np.arange(n) // side) for n in (height, width))
    parts_yx = np.asarray(yx, np.int64) // side
    return parts_yx[..., 0] * across + parts_yx[..., 1], np.outer(rows, columns).reshape(-1).astype(np.int64)


def _even_shares(shown: NDArray[np.int64], size: NDArray[np.int64], kinds: list[NDArray[np.intp]]) -> NDArray[np.int64]:
    """The shares of places that show parts of `size` px, those of one kind (numbers of places) equal where they may."""
    shares = np.empty(len(shown), np.int64)
    for own in kinds:
        shares[own] = WHOLE // len(own)
    least, most = shares // MOST, shares * MOST
    for _ in range(ROUNDS):
        weights = np.repeat(shares, shown.shape[1]).astype(np.float64)  # whole numbers, so that sums are exact
        often = np.bincount(shown.reshape(-1), weights, len(size)).astype(np.int64) * 256 // size
        seen, before = often[shown].sum(axis=1), shares.copy()
        for own in kinds:
            mean = int((seen[own] // 256 * shares[own]).sum()) // int(shares[own].sum())
            more = seen[own] // 256 - mean
            beyond = np.sign(more) * np.maximum(np.abs(more) - mean * EVEN // 100, 0)
            shares[own] -= shares[own] * beyond // max(mean, 1)
        shares = np.clip(shares, least, most)
        if (shares == before).all():
            break
    return shares
