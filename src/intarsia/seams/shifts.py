"""Which pieces of a map lie about a window, as placements for it: a piece may grow over its neighbours.

A window of one piece that grows as far as a cut says is an expansion move (Boykov, Veksler and Zabih, "Fast Approximate
Energy Minimization via Graph Cuts", IEEE PAMI 23, 2001), kept to the surroundings of a bad place. No search is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..sourcemap import HOLE

Array = NDArray[Any]
Pick = tuple[int, int, int]


def shifts_around(
    variant: Array, yx: Array, places: Sequence[Array], at: tuple[int, int], table: Array, torus: Array
) -> list[Pick]:
    """List the pieces that part of a map shows, those that cover most of it first.

    Parameters
    ----------
    variant, yx : arrays, shape (h, w) and (h, w, 2)
        What is shown there: variants, HOLE where none is, and their rows and columns.
    places : two arrays, shapes (h,) and (w,)
        Rows and columns on the canvas, px, that go on where the canvas wraps.
    at : (row, column)
        The pixel of the canvas that placements are told by.
    table, torus
        Of the variants: columns 1 and 2 of the table are rows and columns, and whether they continue in themselves.

    Returns
    -------
    list of (variant, row, column)
        What each piece shows, or would show, at that pixel; of equally large pieces the first in this order.
    """
    there = variant != HOLE
    number = variant[there].astype(np.int64)
    ends = table[number, 1:3]
    away = np.stack(np.meshgrid(places[0] - at[0], places[1] - at[1], indexing="ij"), axis=2)[there]
    first = yx[there].astype(np.int64) - away
    first = np.where(torus[number][:, None], first % ends, first)
    if not len(first):
        return []
    least, (rows, columns) = first.min(axis=0), np.ptp(first, axis=0) + 1
    code = (number * rows + first[:, 0] - least[0]) * columns + first[:, 1] - least[1]
    found, count = np.unique(code, return_counts=True)
    found = found[np.argsort(-count, kind="stable")]
    y, x = found // columns % rows + least[0], found % columns + least[1]
    return list(zip((found // columns // rows).tolist(), y.tolist(), x.tolist(), strict=True))
