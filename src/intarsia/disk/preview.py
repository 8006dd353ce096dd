"""Small pictures of pixels, for notebooks and pages."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .depth import converted

Array = NDArray[Any]
EIGHT = np.dtype(np.uint8)


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


def preview_png(pixels: Array, kind: str, linear: bool) -> bytes:
    """Return the same as the bytes of a PNG."""
    return encoded(looked_at(pixels, kind, linear))


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
