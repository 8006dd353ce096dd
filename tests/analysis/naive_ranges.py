"""How data are stretched to features, in fractions: the plain truth that units and whole numbers must agree with."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray


def stretched(values: NDArray, highest: int = 1023) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return floor((v - low) highest / (high - low) + 1/2), and where the fraction is clear of rounding up or down."""
    exact = [Fraction(float(v)) for v in values.ravel()]
    low, high = min(exact), max(exact)
    out, clear = [], []
    for v in exact:
        place = (v - low) * highest / (high - low) + Fraction(1, 2) if high > low else Fraction(0)
        out.append(place.__floor__())
        size = max(abs(low), abs(high)) / (high - low) if high > low else 0
        clear.append(min(place - out[-1], out[-1] + 1 - place) > size * Fraction(1, 2**11))
    return np.array(out).reshape(values.shape), np.array(clear).reshape(values.shape)
