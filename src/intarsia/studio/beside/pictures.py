"""In the process beside: planes as pictures of 8 bits for a page, reduced, as the bytes of a PNG."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...disk.depth import looked_at
from ...image import Kind, Plane, Transfer

Pixels = NDArray[np.uint8]


def seen(plane: Plane) -> Pixels:
    """Return what can be seen of a plane: (H, W, 3 or 4) of 8 bits; normals with a sign become (n + 1) / 2."""
    pixels = plane.pixels
    if plane.kind is Kind.NORMAL and plane.is_float and bool((pixels < 0).any()):
        pixels = (pixels + 1) / 2
    return _colours(looked_at(pixels, plane.kind, plane.transfer is Transfer.LINEAR))


def coloured(plane: Plane, ys: NDArray[Any], xs: NDArray[Any]) -> Pixels:
    """Return the colours of some pixels of a plane: (n, 3)."""
    picked = plane.samples[ys, xs][None]
    return _colours(looked_at(picked, plane.kind, plane.transfer is Transfer.LINEAR))[0, :, :3]


def reduced(pixels: Pixels, side: int) -> Pixels:
    """Return pixels (H, W, C), averaged over blocks until no side is longer than `side`."""
    step = -(-max(pixels.shape[:2]) // side)
    if step <= 1:
        return pixels
    height, width = max(pixels.shape[0] // step, 1), max(pixels.shape[1] // step, 1)
    whole = pixels[: height * step, : width * step]
    if whole.shape[0] < height * step or whole.shape[1] < width * step:  # thinner than one block
        return pixels[::step, ::step]
    blocks = whole.reshape(height, step, width, step, -1)
    mean: Pixels = (blocks.mean(axis=(1, 3), dtype=np.float32) + 0.5).astype(np.uint8)
    return mean


def png(pixels: Pixels) -> bytes:
    """Return the bytes of a PNG, made quickly: (H, W, C), C 1, 3 or 4, each row as its difference to the one above."""
    height, width, channels = pixels.shape
    flat = np.ascontiguousarray(pixels).reshape(height, width * channels)
    rows = np.empty((height, 1 + width * channels), np.uint8)
    rows[:, 0] = 2
    rows[0, 1:] = flat[0]
    rows[1:, 1:] = flat[1:] - flat[:-1]
    kind = {1: 0, 3: 2, 4: 6}[channels]
    head = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    parts = ((b"IHDR", head), (b"IDAT", zlib.compress(rows.tobytes(), 1)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)) for name, data in parts
    )


def _colours(pixels: NDArray[Any]) -> Pixels:
    """One or two channels become three or four."""
    whole = pixels.reshape(*pixels.shape[:2], -1)
    if whole.shape[2] < 3:
        gray, rest = whole[:, :, :1], whole[:, :, 1:]
        whole = np.concatenate([gray, gray, gray, rest], axis=2)
    return np.ascontiguousarray(whole, np.uint8)
