"""What ``--avoid``, ``--crop``, ``--scale``, ``--flatten`` and ``--magnify`` make of an exemplar, all planes alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError, ParameterError
from ..exemplar import Exemplar
from ..lazy import lazy
from ..rendering.magnification import cut_out, magnified, reduced
from ..request.request import Request

if TYPE_CHECKING:
    from ..analysis import light
else:  # only some exemplars need it
    light = lazy("intarsia.analysis.light")

Warn = Callable[[str], None]

MUCH = 0.01  # of the pixels


def adapted(exemplar: Exemplar, asked: Request, warn: Warn) -> Exemplar:
    """Return the exemplar as it is to be used: without the avoided colour, cropped, reduced, evenly lit, magnified."""
    exemplar = replace(exemplar, toroidal=asked.toroidal)
    if asked.avoid is not None:
        exemplar = avoiding(exemplar, asked.avoid, warn)
    if asked.crop is not None:
        exemplar = cropped(exemplar, asked.crop)
    if asked.scale != 1:
        said = f"--scale 1/{asked.scale}", "scale less", "drop --toroidal, or scale otherwise"
        exemplar = reduced(exemplar, asked.scale, *said)
    if asked.flatten:
        exemplar = even(exemplar, warn)
    if asked.magnify != 1:
        exemplar = enlarging(exemplar, asked.magnify, warn)
    return exemplar


def avoiding(exemplar: Exemplar, colour: tuple[int, int, int], warn: Warn) -> Exemplar:
    """Make the pixels of exactly this colour unusable."""
    base = exemplar.base
    if base.is_float:
        raise ParameterError(f"--avoid: {exemplar.name} has float pixels; mark what to avoid in a --mask instead.")
    wide = 257 if base.pixels.dtype == np.uint16 else 1
    written = "#" + bytes(colour).hex()
    colours = base.samples[:, :, :-1] if base.alpha else base.samples
    if colours.shape[2] not in (1, 3):
        raise ParameterError(f"--avoid: {exemplar.name} has {colours.shape[2]} channels; it needs 1 or 3.")
    found = (colours == np.array(colour, np.int64) * wide).all(axis=2)
    if not found.any():
        warn(f"{exemplar.name} has no pixel of the colour {written}; nothing is avoided.")
        return exemplar
    usable = ~found if exemplar.usable is None else exemplar.usable & ~found
    if not usable.any():
        raise InputError(f"{exemplar.name} has no pixel left to use without the colour {written}; choose another.")
    return replace(exemplar, usable=usable)


def cropped(exemplar: Exemplar, crop: tuple[int, int, int, int]) -> Exemplar:
    """Cut out x, y, width, height, in px of the base plane."""
    x, y, width, height = crop
    if min(x, y) < 0 or x + width > exemplar.width or y + height > exemplar.height:
        raise ParameterError(
            f"--crop {','.join(map(str, crop))} does not lie in {_named(exemplar)}; give X,Y,WIDTH,HEIGHT inside it."
        )
    for name, plane in exemplar.planes.items():
        if any(v * plane.width % exemplar.width for v in crop):
            raise ParameterError(f"--crop cuts pixels of the smaller plane {name}; use multiples of its pixels.")
    return cut_out(exemplar, x, y, width, height)


def enlarging(exemplar: Exemplar, n: int, warn: Warn) -> Exemplar:
    """Grow at 1/n of the size and draw all pixels; tell what is cut off for it."""
    made = magnified(exemplar, n)
    width, height = made.width * n, made.height * n
    if (width, height) != (exemplar.width, exemplar.height):
        warn(f"--magnify {n}: {_named(exemplar)} was cut to {width}x{height} px, which {n} divides.")
    return made


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


def _named(exemplar: Exemplar) -> str:
    return f"{exemplar.name} ({exemplar.width}x{exemplar.height} px)"
