"""Synthesis magnification: matching at reduced size, rendering at full size (Lefebvre and Hoppe 2005, section 5).

    wall = ia.synthesize(ia.magnified(ia.read("brick.png"), 4), 256)
    ia.write("wall.png", wall.render())     # 1024 x 1024 px

The map is synthesised from the exemplar reduced n times. Each pixel of the large picture is the bilinear blend of the
pixels that its four nearest map pixels, enlarged, copy there. These are the votes of a feather of one px of the map, n
px of the picture. Shares along an axis are k / (n + 1), k = 1 .. n,
where bilinear weights at the middles of pixels are (k - 1/2) / n: at most 1/12 off. With odd n the ramp lies half a px
of the picture to one side, as no feather of n px can be centred there: at most 1 / (n + 1) off.
"""

from __future__ import annotations

from dataclasses import replace
from math import lcm

import numpy as np

from ..foundation import TIMES, InputError, ParameterError, expect, whole_within
from ..foundation.arrays import Array
from ..model import REDUCED, Exemplar
from .blending import averaged, blocks


def magnified(exemplar: Exemplar, times: int) -> Exemplar:
    """Return an exemplar that is matched at a fraction of its size and rendered with all of its pixels.

    Parameters
    ----------
    exemplar : Exemplar
        Its sides are cut to multiples of `times`, unless it is toroidal.
    times : int
        1 to 64; sizes, patches and all other lengths of methods are then in px of the reduced exemplar.

    Returns
    -------
    Exemplar
        Its base is the given base averaged in blocks, in the way of its kind; renderings draw the given planes. A pixel
        of the base is usable if all of its block is.

    Raises
    ------
    ParameterError
        for other numbers, and if the reduced exemplar would be empty, or no longer toroidal.
    InputError
        if the mask leaves no whole block.
    """
    expect(exemplar, Exemplar, "the exemplar to magnify", "one of read(path) or Exemplar.of(array)", InputError)
    times = whole_within("magnify", times, 1, TIMES, "times")
    if times == 1:
        return exemplar
    if REDUCED in exemplar.planes:
        raise ParameterError(f"{exemplar.name} is magnified already; magnify the first exemplar by more.")
    for name, plane in exemplar.planes.items():
        smaller = exemplar.height // plane.height
        if smaller and smaller % times and times % smaller:
            raise ParameterError(
                f"magnify={times} does not suit the plane {name}, which is {smaller}x smaller than the first; "
                f"choose a number that {smaller} divides, or that divides it."
            )
    exemplar = trimmed(exemplar, times, f"magnify={times}")
    small = exemplar.base.like(averaged(exemplar.base, times))
    usable = _usable(exemplar, times)
    if usable is not None and not usable.any() and exemplar.usable is not None and exemplar.usable.any():
        raise InputError(
            f"the mask of {exemplar.name} leaves no whole block of {times}x{times} px to use; magnify by less."
        )
    return replace(exemplar, planes={REDUCED: small, **exemplar.planes}, usable=usable)


def reduced(exemplar: Exemplar, n: int, said: str = "the reduction", *remedies: str) -> Exemplar:
    """Return an exemplar with blocks of n x n px of every plane averaged; a block is usable if all of it is.

    Remainders of sides are cut off first, unless the exemplar is toroidal; `said`, `remedies`: see :func:`trimmed`.
    """
    smallest = max(exemplar.width // p.width for p in exemplar.planes.values()) or 1
    exemplar = trimmed(exemplar, n * smallest, said, *remedies)
    planes = {name: plane.like(averaged(plane, n)) for name, plane in exemplar.planes.items()}
    return replace(exemplar, planes=planes, usable=_usable(exemplar, n))


def trimmed(
    exemplar: Exemplar, n: int, said: str, less: str = "choose less",
    otherwise: str = "let it not be toroidal, or choose another number",
) -> Exemplar:  # fmt: skip
    """Cut columns at the right and rows at the bottom off, so that n divides the sides.

    Raise ParameterError, which begins with `said`, if nothing is left (it ends with `less`), or if a toroidal exemplar
    would no longer be one (`otherwise`).
    """
    unit = lcm(n, max(exemplar.width // p.width for p in exemplar.planes.values()) or 1)
    width, height = (side - side % unit for side in (exemplar.width, exemplar.height))
    described = f"{exemplar.name} ({exemplar.width}x{exemplar.height} px)"
    if not width or not height:
        raise ParameterError(f"{said} leaves nothing of {described}; {less}.")
    if (width, height) == (exemplar.width, exemplar.height):
        return exemplar
    if exemplar.toroidal:
        raise ParameterError(
            f"{said} does not divide {described}, which would no longer continue in itself; {otherwise}."
        )
    return cut_out(exemplar, 0, 0, width, height)


def cut_out(exemplar: Exemplar, x: int, y: int, width: int, height: int) -> Exemplar:
    """Return a rectangle of all planes, in px of the base; it must not split a pixel of a smaller plane."""
    planes = {}
    for name, plane in exemplar.planes.items():
        left, top, w, h = (v * plane.width // exemplar.width for v in (x, y, width, height))
        planes[name] = plane.like(plane.samples[top : top + h, left : left + w])
    usable = None if exemplar.usable is None else exemplar.usable[y : y + height, x : x + width]
    return replace(exemplar, planes=planes, usable=usable, toroidal=False)


def _usable(exemplar: Exemplar, n: int) -> Array | None:
    if exemplar.usable is None:
        return None
    return np.asarray(blocks(exemplar.usable[..., None], n).all(axis=(2, 3)))
