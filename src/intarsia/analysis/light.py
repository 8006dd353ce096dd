"""The light on an exemplar: how strongly it slopes, and the exemplar without the slope.

Source: no paper of its own; Lopez Recas 2011 names uneven light as future work (chapter 6). Departures: none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arguments import expect
from ..errors import InputError, ParameterError
from ..exemplar import Exemplar
from ..image import Kind, Plane
from ..rendering.colour import from_linear, to_linear
from .flatten import flatten

PARTS = 8  # along each side: parts are averaged, so that what is measured is slow
TERMS = 5  # of a polynomial of order 2, but for its mean
LEAST_SHARE = 0.3  # of the differences between parts that must be a slope,
LEAST_FACTOR = 1.4  # and how many times brighter it must be on one side than on the other: half a stop
EXTREMES = (2, 98)  # percent


@dataclass(frozen=True)
class Slope:
    """How unevenly an exemplar is lit.

    Attributes
    ----------
    share : float
        0 to 1: how much of the differences in brightness between parts of the exemplar is one smooth slope or vignette,
        less what chance would give it, as there are only so many elements.
    factor : float
        How many times brighter the brightest parts of that slope are than its darkest, in linear light.
    """

    share: float
    factor: float

    @property
    def strong(self) -> bool:
        """Whether blocks from both sides would show side by side, so that flattening is worth a try."""
        return self.share >= LEAST_SHARE and self.factor >= LEAST_FACTOR


def slope_of(exemplar: Exemplar, element: float) -> Slope:
    """Measure the light on an exemplar whose elements are `element` px large; none where it is no colour."""
    if exemplar.base.kind is not Kind.COLOUR:
        return Slope(0.0, 1.0)
    light, visible = _light(exemplar)
    apart = min(PARTS * PARTS, visible.sum() / max(element, 1.0) ** 2)  # elements, or parts, that are lit apart
    if apart <= TERMS + 1:
        return Slope(0.0, 1.0)
    found = flatten(light, visible, parts=PARTS)
    low, high = np.percentile(found.gain[visible], EXTREMES)
    share = 1.0 - (1.0 - found.strength) * (apart - 1) / (apart - 1 - TERMS)
    return Slope(max(0.0, float(share)), float(high / low))


def flattened(exemplar: Exemplar) -> Exemplar:
    """Take the slope of light off an exemplar: even brightness, everything else as it was.

    A slope and a vignette are fitted to the base plane in linear light and divided out; depth, size, opacity, mask and
    all other planes stay, so that a map of the one is a map of the other. What would become brighter than white in
    whole-number pixels is cut off there.

    Raises
    ------
    ParameterError
        where the base plane holds no colours, or the exemplar continues across its borders, which it then would not.
    """
    expect(exemplar, Exemplar, "the exemplar to flatten", "one of read(path) or Exemplar.of(array)", InputError)
    name, base = next(iter(exemplar.planes.items()))
    if base.kind is not Kind.COLOUR:
        raise ParameterError(f"flatten: the plane {name} holds {base.kind.value}, not colours; only those have light.")
    if exemplar.toroidal:
        raise ParameterError("flatten: the exemplar continues across its borders, so its light does, too; drop one.")
    light, visible = _light(exemplar)
    if not visible.any():
        return exemplar
    gain = flatten(light, visible, parts=PARTS).gain[..., None]
    even = to_linear(base).astype(np.float64)
    with np.errstate(all="ignore"):  # what is masked out may hold anything
        even[..., : base.channels - base.alpha] /= gain
        plane = base.like(from_linear(even, base))
    return Exemplar({**exemplar.planes, name: plane}, exemplar.usable, exemplar.toroidal, exemplar.name)


def clipped(before: Plane, after: Plane) -> float:
    """The share of pixels that flattening made white: 0 for floats."""
    if after.is_float:
        return 0.0
    colours = after.channels - after.alpha
    top = np.iinfo(after.pixels.dtype).max
    white = [(p.samples[..., :colours] == top).any(axis=2) for p in (before, after)]
    return float((white[1] & ~white[0]).mean())


def _light(exemplar: Exemplar) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Linear light of the colours (H, W, 1 or 3), and which px are there to be seen."""
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
