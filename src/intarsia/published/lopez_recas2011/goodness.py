"""Lattice detection of Lopez Recas 2011: the pair of autocorrelation peaks with the best goodness.

Good at printed patterns; but it returns a lattice for every texture, even for one without any, and prefers large
cells of which few points are seen.

Source: Lopez Recas 2011, section 3.3 and 3.3.1, eq. 3.22. Departures: a negative sum has goodness 0 instead of
an undefined power; flat pairs are left out; visible tile pixels are counted in closed form, not one by one.
"""

from __future__ import annotations

import numpy as np

from ...analysis import factor_for, reduced
from ...analysis.elements import autocorrelation
from ...analysis.features import features
from ...foundation import MethodError, ndimage
from ...foundation.arrays import Floats, Int16, Int32, Int64
from ...model import Exemplar
from .goodness_kernels import MILLION, best_pair


def lattice_by_goodness(exemplar: Exemplar, weights: tuple[float, ...] | None) -> tuple[tuple[float, float], ...]:
    """Return the vectors (x, y) px of the lattice of best goodness; MethodError where there is no peak."""
    found = goodness_lattice(features([exemplar], weights).pictures[0])
    if found is None:
        raise MethodError("the exemplar has no peak of correlation; give the lattice vectors, or detector=contrast.")
    return tuple((float(x), float(y)) for y, x in found)


def goodness_lattice(picture: Int16) -> Floats | None:
    """Return the lattice of best goodness, rows (dy, dx) in px; of equals the shortest. None if there are no peaks."""
    factor = factor_for(picture.shape)
    small, _ = reduced(picture, None, factor)
    correlation, _ = autocorrelation(small)
    values = np.rint(MILLION * correlation).astype(np.int32)
    found, goodness = best_pair(values, _peaks(values), *small.shape[:2])
    return found.astype(np.float64) * factor if goodness > 0 else None


def _peaks(values: Int32) -> Int64:
    """Return all local maxima of the right half plane (n, 2), shortest first."""
    above = np.array([[1, 1, 1], [1, 0, 0], [0, 0, 0]])
    first, last = (
        ndimage.maximum_filter(values, footprint=half, mode="constant", cval=-MILLION)
        for half in (above, above[::-1, ::-1])
    )
    top = (values >= first) & (values > last)
    at = np.argwhere(top) - np.array(values.shape) // 2
    at = at[(at[:, 1] > 0) | ((at[:, 1] == 0) & (at[:, 0] > 0))]
    square = (at * at).sum(axis=1)
    result: Int64 = at[np.lexsort((at[:, 1], at[:, 0], square))].astype(np.int64)
    return result
