"""Other depths, each rounded to the nearest value, and 8 bits to look at. Pixels alone, without their plane."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ParameterError, said

Array = NDArray[Any]
EIGHT = np.dtype(np.uint8)


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


def looked_at(pixels: Array, kind: str, linear: bool) -> Array:
    """Return 8 bits to look at: floats clipped, heights stretched to their range, labels in colours.

    `pixels`: (H, W) or (H, W, C), as is what comes back. `kind` is "colour", "data" or "label"; `linear`: whether
    colours are linear light.
    """
    samples = pixels.reshape(*pixels.shape[:2], -1)
    if kind == "label":
        seen = _in_colours(samples)
    else:
        seen = converted(_to_its_range(samples) if kind == "data" else samples, kind, linear, EIGHT)
    if seen.shape[2] > 4:
        seen = seen[:, :, :3]
    return seen[:, :, 0] if seen.shape[2] == 1 else seen


def encoded(pixels: Array, quality: int | None = None) -> bytes:
    """Return 8 bits (H, W) or (H, W, C) as the bytes of a PNG, or, where a quality of 1 to 95 is named, of a JPEG."""
    from PIL import Image

    buffer = io.BytesIO()
    whole = pixels[:, :, 0] if pixels.ndim == 3 and pixels.shape[2] == 1 else pixels
    lossy = {} if quality is None else {"quality": quality}
    Image.fromarray(np.ascontiguousarray(whole)).save(buffer, "png" if quality is None else "jpeg", **lossy)
    return buffer.getvalue()


def _to_its_range(samples: Array) -> Array:
    if samples.dtype.kind != "f":
        return samples
    values = samples.astype(np.float64)
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    return (values - low) / ((high - low) or 1.0) if low < 0.0 or high > 1.0 else values


def _in_colours(values: Array) -> Array:
    """Give every label a colour of its own; the colours of a coloured label map stay."""
    if values.dtype == bool:
        return values.astype(np.uint8) * np.uint8(255)
    if values.shape[2] > 1:
        return (
            (values & 255).astype(np.uint8)
            if values.dtype == np.uint32
            else converted(values, "data", False, EIGHT)
        )
    if values.dtype.kind == "f":
        values = values.astype(np.float32).view(np.uint32)
    mixed = values[:, :, 0].astype(np.uint32)
    mixed = (mixed ^ (mixed >> np.uint32(16))) * np.uint32(0x7FEB352D)
    mixed = (mixed ^ (mixed >> np.uint32(15))) * np.uint32(0x846CA68B)
    mixed ^= mixed >> np.uint32(16)
    colours = np.stack([(mixed >> np.uint32(s)) & np.uint32(255) for s in (0, 8, 16)], axis=2)
    colours = (colours * 3 // 4 + 48).astype(np.uint8)
    colours[values[:, :, 0] == 0] = 0
    return colours
