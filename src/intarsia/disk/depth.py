"""Other depths: 8 and 16 bit, half and float, each rounded to the nearest value. Pixels alone, without their plane."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ParameterError, said

Array = NDArray[Any]

_TOGETHER = 1 << 18  # samples
DTYPE_OF_DEPTH = {"8": "uint8", "16": "uint16", "half": "float16", "float": "float32"}


def dtype_of(depth: int | str) -> str:
    """Return the type of pixel that a depth means."""
    word = str(depth).lower() if isinstance(depth, (int, str)) else ""
    if isinstance(depth, bool) or word not in DTYPE_OF_DEPTH:
        raise ParameterError(f"depth={said(depth)} is not allowed; choose 8, 16, half or float.")
    return DTYPE_OF_DEPTH[word]


def converted(pixels: Array, kind: str, linear: bool, dtype: np.dtype[Any]) -> Array:
    """Return pixels (H, W) or (H, W, C) in another type; `kind` is "colour", "data" or "label".

    Colour keeps its look: where floats become whole numbers, linear light gets the sRGB curve, and where whole numbers
    become floats it is taken off. Whole numbers clip to 0..1, NaN becomes 0. Labels keep their numbers, and are refused
    where these do not fit.
    """
    floats = pixels.dtype.kind == "f"
    if pixels.dtype == dtype:
        return pixels
    if kind == "label":
        return _numbers_kept(pixels, dtype)
    if floats and dtype.kind == "f":
        with np.errstate(over="ignore"):
            return pixels.astype(dtype)
    if not floats and dtype.kind == "u":
        return _by_rows(pixels, dtype, lambda p: _other_codes(p, dtype))
    if floats:
        return _by_rows(pixels, dtype, lambda p: _to_codes(p, kind, linear, dtype))
    top = np.float64(np.iinfo(pixels.dtype).max)
    return _by_rows(pixels, dtype, lambda p: _on_colour(p / top, kind, from_srgb).astype(dtype))


def _by_rows(pixels: Array, dtype: np.dtype[Any], change: Callable[[Array], Array]) -> Array:
    """Change some rows at a time: on the way a sample takes 40 bytes."""
    made = np.empty(pixels.shape, dtype)
    rows = max(1, _TOGETHER // max(1, pixels[:1].size))
    for y in range(0, len(pixels), rows):
        made[y : y + rows] = change(pixels[y : y + rows])
    return made


def _to_codes(pixels: Array, kind: str, linear: bool, dtype: np.dtype[Any]) -> Array:
    values = pixels.astype(np.float64)
    if linear:
        values = _on_colour(values, kind, to_srgb)
    values = np.clip(np.nan_to_num(values, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    return np.floor(values * np.iinfo(dtype).max + 0.5).astype(dtype)


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


def _on_colour(values: Array, kind: str, curve: Callable[[Array], Array]) -> Array:
    if kind != "colour":
        return values
    if values.ndim == 2 or values.shape[2] not in (2, 4):
        return curve(values)
    return np.concatenate([curve(values[..., :-1]), values[..., -1:]], axis=-1)


def _other_codes(pixels: Array, dtype: np.dtype[Any]) -> Array:
    if pixels.dtype == np.uint8:
        return pixels.astype(np.uint16) * np.uint16(257)
    return ((pixels.astype(np.uint32) + 128) // 257).astype(np.uint8)


def _numbers_kept(pixels: Array, dtype: np.dtype[Any]) -> Array:
    if pixels.dtype == bool:
        return pixels.astype(dtype)
    converted = pixels.astype(dtype)
    if not np.array_equal(converted.astype(pixels.dtype), pixels):
        raise ParameterError(f"labels up to {pixels.max()} do not fit {dtype}; choose a larger depth, or .tif.")
    return converted
