"""Uneven illumination of an exemplar: a low-order polynomial is fitted to log luminance, measured and divided out.

If a photograph is brighter on one side, its patches become visible in the result. The gain divided out is 1 on average.

Source: no paper of its own; Lopez Recas 2011 names uneven light as future work (chapter 6). Departures: none.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..foundation import InputError, ParameterError, expect
from ..foundation.arrays import Floats, Mask
from ..model import Exemplar
from ..model.image import Kind, Plane
from ..rendering import from_linear, to_linear
from .features import LUMINANCE

PARTS = 8  # parts along each side, over which luminance is averaged, so that only slow variation is measured
ORDER = 2  # of the polynomial, for a gradient and a vignette; higher orders fit the texture
TERMS = 5  # coefficients of such a polynomial, without the constant
# Of 92 textures one is reported: with half the share four, with double none; with a factor of 1.2 two, with 1.8 none.
LEAST_SHARE = 0.3  # share of the variance of parts from which illumination is reported as uneven,
LEAST_FACTOR = 1.4  # if the brightest parts are also this many times as bright as the darkest: half a stop
EXTREMES = (2, 98)  # percentiles that stand for darkest and brightest, which leaves out corners of the polynomial
DARK = 1e-3  # relative to the largest luminance: smaller means are raised to this before the logarithm
COARSE = 1 << 20  # coefficients are rounded to multiples of 1 / COARSE, as solvers differ in the last bits
EVEN = 1e-12  # variance of log luminance below which a picture is constant but for rounding
ALIKE = 1e-10  # relative size of singular values taken as 0, of terms that few parts cannot separate; rounding: 1e-15
GAIN_STEPS = 1 << 20  # gains are rounded to multiples of 1 / GAIN_STEPS, as logarithms differ between machines


@dataclass(frozen=True)
class Illumination:
    """Strength of uneven illumination.

    Attributes
    ----------
    share : float
        0 to 1: R^2 of the surface for the log mean luminance of parts, adjusted for the number of elements.
    factor : float
        Ratio of the brightest to the darkest parts of the surface, in linear light.
    """

    share: float
    factor: float

    @property
    def strong(self) -> bool:
        """Whether patches from both sides differ visibly side by side, so that flattening may help."""
        return self.share >= LEAST_SHARE and self.factor >= LEAST_FACTOR


def illumination_of(exemplar: Exemplar, element: float) -> Illumination:
    """Return the illumination of an exemplar with elements of `element` px; even if it lacks colours or elements."""
    if exemplar.base.kind is not Kind.COLOUR:
        return Illumination(0.0, 1.0)
    light, visible = _visible_light(exemplar)
    apart = min(PARTS * PARTS, visible.sum() / max(element, 1.0) ** 2)  # independent samples: elements or parts
    if apart <= TERMS + 1:
        return Illumination(0.0, 1.0)
    found = fit_illumination(light, visible)
    low, high = np.percentile(found.gain[visible], EXTREMES)
    share = 1.0 - (1.0 - found.strength) * (apart - 1) / (apart - 1 - TERMS)
    return Illumination(max(0.0, float(share)), float(high / low))


def flattened(exemplar: Exemplar) -> Exemplar:
    """Return an exemplar of even illumination; everything else stays.

    A gradient and a vignette are fitted to the base plane in linear light and divided out; depth, size, opacity, mask
    and all other planes stay, so that a map of the one is a map of the other. Integer pixels that would become brighter
    than white are clipped.

    Raises
    ------
    ParameterError
        if the base plane holds no colours, or the exemplar is toroidal, which it then would not be.
    """
    expect(exemplar, Exemplar, "the exemplar to flatten", "one of read(path) or Exemplar.of(array)", InputError)
    name, base = next(iter(exemplar.planes.items()))
    if base.kind is not Kind.COLOUR:
        raise ParameterError(f"flatten: the plane {name} holds {base.kind.value}, not colours; only those have light.")
    if exemplar.toroidal:
        raise ParameterError("flatten: the exemplar continues across its borders, so its light does, too; drop one.")
    light, visible = _visible_light(exemplar)
    if not visible.any():
        return exemplar
    gain = fit_illumination(light, visible).gain[..., None]
    even = to_linear(base).astype(np.float64)
    with np.errstate(all="ignore"):  # what is masked out may hold anything
        even[..., : base.channels - base.alpha] /= gain
        plane = base.like(from_linear(even, base))
    return replace(exemplar, planes={**exemplar.planes, name: plane})


def clipped(before: Plane, after: Plane) -> float:
    """Return the share of pixels that flattening clipped to white: 0 for floats."""
    if after.is_float:
        return 0.0
    colours = after.channels - after.alpha
    top = np.iinfo(after.pixels.dtype).max
    white = [(p.samples[..., :colours] == top).any(axis=2) for p in (before, after)]
    return float((white[1] & ~white[0]).mean())


def _visible_light(exemplar: Exemplar) -> tuple[Floats, Mask]:
    """Return the linear light of the colours (H, W, 1 or 3), and which px are usable, finite and not transparent."""
    base = exemplar.base
    samples = to_linear(base)
    colours = samples.shape[2] - base.alpha
    light = samples[..., : 3 if colours >= 3 else 1].astype(np.float64)
    visible = np.asarray(np.isfinite(light).all(axis=2))
    if exemplar.usable is not None:
        visible &= exemplar.usable
    if base.alpha:
        visible &= samples[..., -1] > 0
    return np.where(visible[..., None], light, 0.0), visible


class FittedIllumination(NamedTuple):
    """Illumination as a gain: a picture divided by it is evenly lit."""

    gain: Floats  # (H, W), 1 on average
    strength: float  # R^2, 0 to 1: share of the variance of the parts' log luminance; below 0.1 negligible


def fit_illumination(light: Floats, visible: Mask) -> FittedIllumination:
    """Return the illumination of scene-linear colours (H, W, 1 or 3), which are 0 where not visible.

    The surface is fitted to the mean luminance of PARTS parts along each side, fewer if it has fewer px. In these means
    the dark pixels of joints and shadows, which illumination hardly changes in most photographs, have little weight.
    The gain is extrapolated where nothing is visible.
    """
    luminance = light @ np.array(LUMINANCE if light.shape[2] == 3 else (1.0,))
    if luminance.max() <= 0:
        return FittedIllumination(np.ones(luminance.shape), 0.0)
    surface, strength = _surface(luminance, visible)
    gain = np.exp(surface)
    gain /= gain[visible].mean()
    gain = np.maximum(np.rint(gain * GAIN_STEPS), 1.0) / GAIN_STEPS
    return FittedIllumination(gain, strength)


def _surface(luminance: Floats, visible: Mask) -> tuple[Floats, float]:
    """Return a polynomial of x and y without constant fitted to the log luminance of parts, and its R^2.

    Legendre polynomials keep the normal equations well conditioned on sides of any length.
    """
    rows, columns = (
        np.polynomial.legendre.legvander((2 * np.arange(n) + 1.0) / n - 1, ORDER) for n in luminance.shape
    )  # at pixel centres from -1 to 1
    terms = [(i, j) for i in range(ORDER + 1) for j in range(ORDER + 1 - i) if (i, j) != (0, 0)]
    basis = np.stack([np.multiply.outer(rows[:, i], columns[:, j]) for i, j in terms])
    chosen, wanted = _averaged(np.concatenate([basis, luminance[None]]), visible)
    if not len(wanted):
        return np.zeros(luminance.shape), 0.0
    wanted = np.log(np.maximum(wanted, DARK * luminance.max()))
    middle = chosen.mean(axis=1, keepdims=True)
    centred, target = chosen - middle, wanted - wanted.mean()
    total = float(target @ target)
    if total <= EVEN * len(target):
        return np.zeros(luminance.shape), 0.0
    factors = np.linalg.lstsq(centred @ centred.T, centred @ target, rcond=ALIKE)[0]
    left = target - factors @ centred
    # Terms are added one by one, with rounded coefficients, as sums of products differ between machines.
    surface = np.zeros(luminance.shape)
    for factor, term, mean in zip(np.rint(factors * COARSE) / COARSE, basis, middle[:, 0], strict=True):
        surface += factor * (term - np.rint(mean * COARSE) / COARSE)
    return surface, max(0.0, 1.0 - float(left @ left) / total)


def _averaged(layers: Floats, known: Mask) -> tuple[Floats, Floats]:
    """Return the means of layers over parts of which more than half is known: all but the last (n, parts), the last."""
    height, width = known.shape
    down, across = min(PARTS, height), min(PARTS, width)
    means = []
    for i in range(down):
        for j in range(across):
            box = np.s_[i * height // down : (i + 1) * height // down, j * width // across : (j + 1) * width // across]
            if 2 * np.count_nonzero(known[box]) > known[box].size:
                means.append(layers[:, *box][:, known[box]].mean(axis=1))
    found = np.array(means).reshape(len(means), len(layers)).T
    return found[:-1], found[-1]
