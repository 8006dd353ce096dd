"""Small pictures for notebooks and the studio."""

from __future__ import annotations

import io

import numpy as np

from ..image import Array, Kind, Plane
from .depth import convert


def preview_png(plane: Plane) -> bytes:
    """Return an 8-bit PNG to look at: floats clipped, heights stretched to their range, labels in colours."""
    from PIL import Image

    pixels = _labels(plane) if plane.kind is Kind.LABEL else _look(plane)
    if pixels.shape[2] > 4:
        pixels = pixels[:, :, :3]
    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels[:, :, 0] if pixels.shape[2] == 1 else pixels)).save(buffer, "png")
    return buffer.getvalue()


def _look(plane: Plane) -> Array:
    if plane.kind is Kind.DATA and plane.is_float:
        values = plane.samples.astype(np.float64)
        known = values[np.isfinite(values)]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
        if low < 0.0 or high > 1.0:
            values = (values - low) / ((high - low) or 1.0)
        plane = Plane(values, plane.kind, plane.transfer)
    return convert(plane, 8).samples


def _labels(plane: Plane) -> Array:
    """Give every label a colour of its own; the colours of a coloured label map stay."""
    values = plane.samples
    if values.dtype == bool:
        return values.astype(np.uint8) * np.uint8(255)
    if values.shape[2] > 1:
        return (
            (values & 255).astype(np.uint8)
            if values.dtype == np.uint32
            else convert(Plane(values, Kind.DATA), 8).samples
        )
    if plane.is_float:
        values = values.astype(np.float32).view(np.uint32)
    mixed = values[:, :, 0].astype(np.uint32)
    mixed = (mixed ^ (mixed >> np.uint32(16))) * np.uint32(0x7FEB352D)
    mixed = (mixed ^ (mixed >> np.uint32(15))) * np.uint32(0x846CA68B)
    mixed ^= mixed >> np.uint32(16)
    colours = np.stack([(mixed >> np.uint32(s)) & np.uint32(255) for s in (0, 8, 16)], axis=2)
    colours = (colours * 3 // 4 + 48).astype(np.uint8)
    colours[values[:, :, 0] == 0] = 0
    return colours
