"""A plane in another depth, or as a small picture to look at."""

from __future__ import annotations

import numpy as np

from ..disk.depth import converted, dtype_of
from ..disk.preview import looked_at
from ..image import Kind, Plane, Transfer


def convert(plane: Plane, depth: int | str) -> Plane:
    """Return a plane in another depth; colour keeps its look, so linear floats gain or lose the sRGB curve.

    Whole numbers clip to 0..1, NaN becomes 0. Labels keep their numbers, and are refused where these do not fit.
    """
    dtype = np.dtype(dtype_of(depth))
    if plane.pixels.dtype == dtype:
        return plane
    pixels = converted(plane.pixels, plane.kind, plane.transfer is Transfer.LINEAR, dtype)
    if plane.kind is Kind.LABEL or plane.is_float == (dtype.kind == "f"):
        return Plane(pixels, plane.kind, plane.transfer, plane.meta)
    about = {k: v for k, v in plane.meta.items() if k != "icc"}  # a colour profile describes the old curve
    return Plane(pixels, plane.kind, Transfer.SRGB if plane.is_float else Transfer.LINEAR, about)


def preview(plane: Plane) -> Plane:
    """Return a picture of 8 bits to look at: floats clipped, heights stretched to their range, labels in colours."""
    return Plane(looked_at(plane.pixels, plane.kind, plane.transfer is Transfer.LINEAR))
