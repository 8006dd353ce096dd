"""Which way of mixing a plane needs, and planes averaged to smaller ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..image import Array, Kind, Plane
from ..lazy import lazy
from ..sourcemap import Mixing
from .colour import Curve
from .mixing import Floats, Integers, LabelMixer, Mixer, Normals, Spread
from .normals import NormalCoding

if TYPE_CHECKING:
    from . import translucent
else:  # only some textures need it
    translucent = lazy("intarsia.rendering.translucent")


def coding_of(planes: Sequence[Plane]) -> NormalCoding | None:
    """Tell how the vectors of one plane of all exemplars are coded; None where it holds none."""
    if planes[0].kind is not Kind.NORMAL:
        return None
    signed = any(p.is_float and bool((p.pixels < 0).any()) for p in planes)
    return NormalCoding(planes[0].pixels.dtype, signed, planes[0].meta.get("normals", "gl") == "dx")


def mixer_of(
    plane: Plane, samples: Array, coding: NormalCoding | None, curve: Curve, mixing: Mixing,
    usable: NDArray[np.bool_] | None,
) -> Mixer:  # fmt: skip
    """Choose how the votes for a plane become one pixel; `usable` says which samples count for its contrast."""
    if coding is not None:
        return Normals(samples, coding.vectors(samples), coding)
    if plane.kind is Kind.LABEL:
        return LabelMixer.of(samples)
    light = curve.linear(samples) if plane.is_float else samples
    spread = None
    if mixing is Mixing.VARIANCE:
        seen = slice(None) if usable is None else np.flatnonzero(usable)
        values = curve.linear(samples[seen])
        spread = Spread.of(values[:, :-1], values[:, -1]) if plane.alpha else Spread.of(values)
    if plane.is_float:
        return (translucent.TranslucentFloats if plane.alpha else Floats)(samples, light, curve, spread)
    return (translucent.TranslucentIntegers if plane.alpha else Integers)(samples, curve, spread)


def averaged(plane: Plane, n: int) -> Array:
    """Return blocks of n x n pixels as one each, by the kind of the plane."""
    mixer = mixer_of(plane, plane.samples[:1, 0], coding_of([plane]), Curve.of(plane), Mixing.MEAN, None)
    with np.errstate(invalid="ignore", over="ignore"):  # masked pixels may be NaN
        return mixer.average(plane.samples, n)
