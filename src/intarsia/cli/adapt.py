"""What ``--avoid``, ``--crop``, ``--scale`` and ``--flatten`` make of an exemplar, for all of its planes alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..colour import Curve
from ..errors import InputError, ParameterError
from ..exemplar import Exemplar
from ..image import Array, Kind, Plane
from ..lazy import lazy
from ..mixing import Floats, Integers, Labels, Mixer, Normals
from ..normals import NormalCoding
from .request import Inputs

if TYPE_CHECKING:
    from .. import translucent
    from ..analysis import light
else:  # only some exemplars need them
    light, translucent = lazy("intarsia.analysis.light"), lazy("intarsia.translucent")

Warn = Callable[[str], None]

MUCH = 0.01  # of the pixels


def adapted(exemplar: Exemplar, inputs: Inputs, warn: Warn) -> Exemplar:
    """Return the exemplar as it is to be used: without the avoided colour, cropped, reduced, then evenly lit."""
    if inputs.avoid is not None:
        exemplar = avoiding(exemplar, inputs.avoid, warn)
    if inputs.crop is not None:
        exemplar = cropped(exemplar, inputs.crop)
    if inputs.scale != 1:
        exemplar = reduced(exemplar, inputs.scale, inputs.toroidal)
    if inputs.flatten:
        exemplar = even(exemplar, warn)
    if inputs.toroidal:
        exemplar = Exemplar(exemplar.planes, exemplar.usable, True, exemplar.name)
    return exemplar


def avoiding(exemplar: Exemplar, colour: tuple[int, int, int], warn: Warn) -> Exemplar:
    """Make the pixels of exactly this colour unusable."""
    base = exemplar.base
    if base.is_float:
        raise ParameterError(f"--avoid: {exemplar.name} has float pixels; mark what to avoid in a --mask instead.")
    wide = 257 if base.pixels.dtype == np.uint16 else 1
    shown = "#" + bytes(colour).hex()
    colours = base.samples[:, :, :-1] if base.alpha else base.samples
    if colours.shape[2] not in (1, 3):
        raise ParameterError(f"--avoid: {exemplar.name} has {colours.shape[2]} channels; it needs 1 or 3.")
    found = (colours == np.array(colour, np.int64) * wide).all(axis=2)
    if not found.any():
        warn(f"{exemplar.name} has no pixel of the colour {shown}; nothing is avoided.")
        return exemplar
    usable = ~found if exemplar.usable is None else exemplar.usable & ~found
    if not usable.any():
        raise InputError(f"{exemplar.name} has no pixel left to use without the colour {shown}; choose another.")
    return Exemplar(exemplar.planes, usable, exemplar.toroidal, exemplar.name)


def cropped(exemplar: Exemplar, crop: tuple[int, int, int, int]) -> Exemplar:
    """Cut out x, y, width, height, in px of the base plane."""
    x, y, width, height = crop
    if min(x, y) < 0 or x + width > exemplar.width or y + height > exemplar.height:
        raise ParameterError(
            f"--crop {','.join(map(str, crop))} does not lie in {_told(exemplar)}; give X,Y,WIDTH,HEIGHT inside it."
        )
    planes = {}
    for name, plane in exemplar.planes.items():
        box = [v * plane.width for v in crop]
        if any(v % exemplar.width for v in box):
            raise ParameterError(f"--crop cuts pixels of the smaller plane {name}; use multiples of its pixels.")
        left, top, w, h = (v // exemplar.width for v in box)
        planes[name] = plane.like(plane.samples[top : top + h, left : left + w])
    usable = None if exemplar.usable is None else exemplar.usable[y : y + height, x : x + width]
    return Exemplar(planes, usable, False, exemplar.name)


def reduced(exemplar: Exemplar, n: int, toroidal: bool) -> Exemplar:
    """Average blocks of n x n px by the kind of each plane; a block is usable if all of it is."""
    small = max(exemplar.width // p.width for p in exemplar.planes.values()) or 1
    width, height = (side - side % (n * small) for side in (exemplar.width, exemplar.height))
    if not width or not height:
        raise ParameterError(f"--scale 1/{n} leaves nothing of {_told(exemplar)}; scale less.")
    if (width, height) != (exemplar.width, exemplar.height):
        if toroidal:
            raise ParameterError(
                f"--scale 1/{n} does not divide {_told(exemplar)}, which would no longer continue in itself; "
                "drop --toroidal, or scale otherwise."
            )
        exemplar = cropped(exemplar, (0, 0, width, height))
    planes = {name: plane.like(averaged(plane, n)) for name, plane in exemplar.planes.items()}
    usable = None
    if exemplar.usable is not None:
        usable = np.asarray(exemplar.usable.reshape(height // n, n, width // n, n).all(axis=(1, 3)))
    return Exemplar(planes, usable, False, exemplar.name)


def even(exemplar: Exemplar, warn: Warn) -> Exemplar:
    """Take the slope of light off; warn where much of the picture becomes white by it."""
    made = light.flattened(exemplar)
    share = light.clipped(exemplar.base, made.base)
    if share > MUCH:
        warn(
            f"--flatten: {100 * share:.0f} % of {exemplar.name} became brighter than white and was cut off there; "
            "an exemplar of floats (.exr) keeps it."
        )
    return made


def _told(exemplar: Exemplar) -> str:
    return f"{exemplar.name} ({exemplar.width}x{exemplar.height} px)"


def averaged(plane: Plane, n: int) -> Array:
    """Return blocks of n x n pixels as one each, by the kind of the plane."""
    with np.errstate(invalid="ignore", over="ignore"):  # masked pixels may be NaN
        return _mixer(plane).average(plane.samples, n)


def _mixer(plane: Plane) -> Mixer:
    samples = plane.samples.reshape(-1, plane.channels)
    if plane.kind is Kind.NORMAL:
        signed = plane.is_float and bool((plane.pixels < 0).any())
        coding = NormalCoding(plane.pixels.dtype, signed, plane.meta.get("normals", "gl") == "dx")
        return Normals(samples, coding.vectors(samples), coding)
    if plane.kind is Kind.LABEL:
        return Labels.of(samples)
    curve = Curve.of(plane)
    if plane.is_float:
        return (translucent.TranslucentFloats if plane.alpha else Floats)(samples, samples, curve, None)
    return (translucent.TranslucentIntegers if plane.alpha else Integers)(samples, curve, None)
