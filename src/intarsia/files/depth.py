"""Other depths: 8 and 16 bit, half and float, each rounded to the nearest value."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ParameterError
from ..image import Array, Kind, Plane, Transfer

DTYPE_OF_DEPTH = {"8": "uint8", "16": "uint16", "half": "float16", "float": "float32"}


def dtype_of(depth: int | str) -> str:
    """Return the type of pixel that a depth means."""
    word = str(depth).lower()
    if isinstance(depth, bool) or word not in DTYPE_OF_DEPTH:
        raise ParameterError(f"depth={depth} is not allowed; choose 8, 16, half or float.")
    return DTYPE_OF_DEPTH[word]


def convert(plane: Plane, depth: int | str) -> Plane:
    """Return a plane in another depth; colour keeps its look, so linear floats gain or lose the sRGB curve.

    Whole numbers clip to 0..1, NaN becomes 0. Labels keep their numbers, and are refused where these do not fit.
    """
    dtype = np.dtype(dtype_of(depth))
    pixels = plane.pixels
    if pixels.dtype == dtype:
        return plane
    if plane.kind is Kind.LABEL:
        return Plane(_labels(pixels, dtype), plane.kind, plane.transfer, plane.meta)
    if plane.is_float and dtype.kind == "f":
        with np.errstate(over="ignore"):
            return Plane(pixels.astype(dtype), plane.kind, plane.transfer, plane.meta)
    if not plane.is_float and dtype.kind == "u":
        return Plane(_steps(pixels, dtype), plane.kind, plane.transfer, plane.meta)
    if plane.is_float:
        values = pixels.astype(np.float64)
        if plane.transfer is Transfer.LINEAR:
            values = _on_colour(plane, values, to_srgb)
        top = np.iinfo(dtype).max
        values = np.clip(np.nan_to_num(values, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
        return Plane(np.floor(values * top + 0.5).astype(dtype), plane.kind, Transfer.SRGB, _facts(plane))
    values = pixels / np.float64(np.iinfo(pixels.dtype).max)
    values = _on_colour(plane, values, from_srgb)
    return Plane(values.astype(dtype), plane.kind, Transfer.LINEAR, _facts(plane))


def _facts(plane: Plane) -> dict[str, Any]:
    """A colour profile describes the old curve: it stays behind."""
    return {k: v for k, v in plane.meta.items() if k != "icc"}


def to_srgb(linear: Array) -> NDArray[np.float64]:
    """Encode linear light by the sRGB curve (IEC 61966-2-1)."""
    v = np.clip(np.nan_to_num(linear, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    code: NDArray[np.float64] = np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.power(v, 1 / 2.4) - 0.055)
    return code


def from_srgb(code: Array) -> NDArray[np.float64]:
    """Decode the sRGB curve to linear light."""
    v = np.asarray(code, np.float64)
    light: NDArray[np.float64] = np.where(v <= 0.04045, v / 12.92, np.power((v + 0.055) / 1.055, 2.4))
    return light


def _on_colour(plane: Plane, values: Array, curve: Callable[[Array], Array]) -> Array:
    if plane.kind is not Kind.COLOUR:
        return values
    if not plane.alpha:
        return curve(values)
    return np.concatenate([curve(values[..., :-1]), values[..., -1:]], axis=-1)


def _steps(pixels: Array, dtype: np.dtype[Any]) -> Array:
    if pixels.dtype == np.uint8:
        return pixels.astype(np.uint16) * np.uint16(257)
    return ((pixels.astype(np.uint32) + 128) // 257).astype(np.uint8)


def _labels(pixels: Array, dtype: np.dtype[Any]) -> Array:
    if pixels.dtype == bool:
        return pixels.astype(dtype)
    converted = pixels.astype(dtype)
    if not np.array_equal(converted.astype(pixels.dtype), pixels):
        raise ParameterError(f"labels up to {pixels.max()} do not fit {dtype}; choose a larger depth, or .tif.")
    return converted
