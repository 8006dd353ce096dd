"""Take uneven light off an exemplar: a photograph that is brighter on one side makes blocks of it visible.

A smooth surface, a polynomial of low order, is fitted to the logarithm of the luminance and divided out; the
mean stays. The gain that was divided by is returned, so that nothing is lost: multiplied by it the exemplar
is what it was, and a result can be given the same light again.

Source: no paper; Lopez Recas 2011 names uneven light as future work. Departures: none.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ..errors import ParameterError

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

LUMINANCE = (0.30, 0.59, 0.11)
DARK = 1e-3  # of the largest luminance: darker px count as this dark
MOST_ORDER = 4
COARSE = 1 << 20  # factors of the polynomial are whole multiples of 1 / COARSE,
STEPS = 1 << 20  # gains are whole multiples of 1 / STEPS: logarithms differ by a bit between machines


@dataclass(frozen=True)
class Flattened:
    """An exemplar without its uneven light.

    Attributes
    ----------
    pixels : float64 array, shape (H, W) or (H, W, C)
        What was given, divided by the gain. Whole-number planes come back as floats too: rounding them would
        lose what the gain cannot give back. Round them yourself where a plane of the same depth is needed.
    gain : float64 array, shape (H, W)
        The light, 1 on average; see `restored`.
    strength : float
        R^2, 0 to 1: how much of the variance of log luminance is light. Below about 0.1 there is none to
        speak of, and flattening removes real differences of the texture; see `worthwhile`.
    """

    pixels: Floats
    gain: Floats
    strength: float

    @property
    def worthwhile(self) -> bool:
        """Whether the light is strong enough to be light, and not the texture's own mottling."""
        return self.strength >= 0.1


    def restored(self, dtype: DTypeLike = np.float64) -> NDArray[Any]:
        """Put the light back: what was given, exactly for whole numbers up to 32 bit, float16 and float32.

        A float64 comes back to the last bit but one.
        """
        lit = self.pixels * (self.gain if self.pixels.ndim == 2 else self.gain[..., None])
        return (np.rint(lit) if np.issubdtype(dtype, np.integer) else lit).astype(dtype)


def flatten(pixels: NDArray[Any], usable: Mask | None = None, order: int = 2, parts: int | None = None) -> Flattened:
    """Divide slow changes of light out of an exemplar.

    Parameters
    ----------
    pixels : array, shape (H, W) or (H, W, C)
        Samples of any depth, not negative; best scene-linear, where light is a factor. Three or more channels:
        the first three are red, green and blue. All are divided by the same gain; pass no alpha.
    usable : bool array, shape (H, W), optional
        False where pixels do not count; the gain is known there as well.
    order : int
        Of the polynomial, 1 to 4: 1 is a slope, 2 a slope and a vignette.
    parts : int, optional
        Fit to the mean luminance of so many parts along each side, at most one a px, in place of every px: the dark
        px of joints and shadows, which light hardly changes in most photographs, then do not hold the surface back.
        `strength` is that of the parts.

    Raises
    ------
    ParameterError
        where the order or the shape does not fit.
    """
    if not 1 <= order <= MOST_ORDER:
        raise ParameterError(f"order={order} is out of range; choose 1 to {MOST_ORDER}.")
    if pixels.ndim not in (2, 3) or not pixels.size:
        raise ParameterError(f"an array of shape {pixels.shape} is no picture; give (height, width, channels).")
    if usable is not None and usable.shape != pixels.shape[:2]:
        raise ParameterError(f"the mask has shape {usable.shape}, the picture {pixels.shape[:2]}; make them equal.")
    values = pixels.astype(np.float64)
    luminance = _luminance(values.reshape(*values.shape[:2], -1))
    if usable is not None:
        luminance = np.where(usable, luminance, 0.0)
    top = float(luminance.max())
    if top <= 0:
        return Flattened(values, np.ones(values.shape[:2]), 0.0)
    surface, strength = _surface(luminance, usable, order, parts)
    gain = np.exp(surface)
    gain /= gain.mean() if usable is None else gain[usable].mean()
    gain = np.maximum(np.rint(gain * STEPS), 1.0) / STEPS
    divided = values / (gain if values.ndim == 2 else gain[..., None])
    return Flattened(divided, gain, strength)


def _luminance(values: Floats) -> Floats:
    weights = LUMINANCE if values.shape[2] >= 3 else (1.0,)
    result: Floats = values[..., : len(weights)] @ np.array(weights)
    return result


def _surface(luminance: Floats, usable: Mask | None, order: int, parts: int | None) -> tuple[Floats, float]:
    """Fit a polynomial of x and y of total degree `order` to the logarithm: the surface around its mean, and R^2.

    Legendre polynomials keep the normal equations well behaved on sides of any length.
    """
    height, width = luminance.shape
    rows, columns = (np.polynomial.legendre.legvander(_ends(n), order) for n in (height, width))
    terms = [(i, j) for i in range(order + 1) for j in range(order + 1 - i) if (i, j) != (0, 0)]
    basis = np.stack([np.multiply.outer(rows[:, i], columns[:, j]) for i, j in terms])
    known = np.ones(luminance.shape, bool) if usable is None else usable
    if parts is None:
        chosen, wanted = basis[:, known], luminance[known]
    else:
        chosen, wanted = _averaged(np.concatenate([basis, luminance[None]]), known, parts)
    if not len(wanted):
        return np.zeros(luminance.shape), 0.0
    wanted = np.log(np.maximum(wanted, DARK * luminance.max()))
    middle = chosen.mean(axis=1, keepdims=True)
    centred, target = chosen - middle, wanted - wanted.mean()
    total = float(target @ target)
    if total <= 1e-12 * len(target):
        return np.zeros(luminance.shape), 0.0
    factors = np.linalg.lstsq(centred @ centred.T, centred @ target, rcond=1e-10)[0]
    left = target - factors @ centred
    # From here on one after the other, in whole multiples of 1 / COARSE: sums of products differ between machines.
    surface = np.zeros(luminance.shape)
    for factor, term, mean in zip(np.rint(factors * COARSE) / COARSE, basis, middle[:, 0], strict=True):
        surface += factor * (term - np.rint(mean * COARSE) / COARSE)
    return surface, max(0.0, 1.0 - float(left @ left) / total)


def _averaged(layers: Floats, known: Mask, parts: int) -> tuple[Floats, Floats]:
    """Means over parts of which most is known: of all layers but the last (n, parts), and of the last."""
    height, width = known.shape
    down, across = min(parts, height), min(parts, width)
    means = []
    for i in range(down):
        for j in range(across):
            box = np.s_[i * height // down : (i + 1) * height // down, j * width // across : (j + 1) * width // across]
            if 2 * np.count_nonzero(known[box]) > known[box].size:
                means.append(layers[:, *box][:, known[box]].mean(axis=1))
    found = np.array(means).reshape(len(means), len(layers)).T
    return found[:-1], found[-1]


def _ends(n: int) -> Floats:
    """Pixel centres from -1 to 1."""
    return (2 * np.arange(n) + 1.0) / n - 1
