"""Which waves a picture is made of: how strong they are by length and direction, against those of the exemplar."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from .windows import smaller

REDUCED = 2  # times; of 1 and 4 one named the better as often
SIDE = 64  # px of a block, in the reduced picture; blocks overlap by half
RINGS = (1.5, 3, 5, 8, 12, 18, 26, 33)  # waves in a block: ends of bands
WAYS = 6  # directions
FAINT = 1e-4  # of all power: less than this is nothing
DIGITS = 6  # libraries differ in the last digits of a transform


def bands(pictures: Sequence[Array]) -> NDArray[np.float64] | None:
    """The power of pictures (H, W, C) in every band of lengths and directions, added up; None where they are small."""
    total, count = np.zeros((SIDE, SIDE // 2 + 1)), 0
    hann = np.hanning(SIDE)
    for picture in pictures:
        gray = smaller(picture, REDUCED).sum(axis=2).astype(np.float64)
        if min(gray.shape) < SIDE:
            continue
        held = np.lib.stride_tricks.sliding_window_view(gray, (SIDE, SIDE))[:: SIDE // 2, :: SIDE // 2]
        held = held.reshape(-1, SIDE, SIDE)
        waves = np.fft.rfft2((held - held.mean(axis=(1, 2), keepdims=True)) * np.multiply.outer(hann, hann))
        total, count = total + (waves.real**2 + waves.imag**2).sum(axis=0), count + len(held)
    if not count:
        return None
    y, x = np.fft.fftfreq(SIDE, 1 / SIDE)[:, None], np.arange(SIDE // 2 + 1)
    ring = np.digitize(np.hypot(y, x), RINGS)
    way = np.rint(np.arctan2(y, x) % np.pi * WAYS / np.pi).astype(int) % WAYS
    inside = (ring > 0) & (ring < len(RINGS))
    return np.bincount((WAYS * (ring - 1) + way)[inside], total[inside], WAYS * (len(RINGS) - 1)) / count


def unlike(bands_of: NDArray[np.float64] | None, picture: Array) -> float:
    """By how much the power of an output differs, in percent: the mean over all bands, of the logarithm."""
    mine = bands([picture])
    if bands_of is None or mine is None:
        return 0.0
    least = FAINT * float(bands_of.sum()) + 1
    return round(100 * float(np.abs(np.log((mine + least) / (bands_of + least))).mean()), DIGITS)
