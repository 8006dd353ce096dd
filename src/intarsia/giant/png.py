"""Tiles as PNG, made in memory: a kill leaves no temporary file, and what was made here is read here again.

PNG (ISO/IEC 15948), 8 and 16 bit, every row filtered by differences to the pixel before.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np

from ..files.png import PNG_START, chunk
from ..image import Array

TYPES = {1: 0, 2: 4, 3: 2, 4: 6}  # channels -> colour type
LEVEL = 6


def encode_png(pixels: Array, icc: bytes | None = None) -> bytes:
    """Return a picture (H, W, C) of uint8, uint16 or bool as PNG."""
    height, width, channels = pixels.shape
    pixels = pixels.astype(np.uint8) * np.uint8(255) if pixels.dtype == bool else pixels
    size = pixels.dtype.itemsize
    raw = np.ascontiguousarray(pixels.astype(pixels.dtype.newbyteorder(">"), copy=False)).view(np.uint8)
    raw = raw.reshape(height, width, channels * size)
    rows = np.ones((height, 1 + width * channels * size), np.uint8)  # the filter's number comes first
    steps = rows[:, 1:].reshape(height, width, channels * size)
    steps[:, 0] = raw[:, 0]
    steps[:, 1:] = raw[:, 1:] - raw[:, :-1]
    rows[:, 1:] = steps.reshape(height, -1)
    head = struct.pack(">IIBBBBB", width, height, 8 * size, TYPES[channels], 0, 0, 0)
    chunks = [(b"IHDR", head)]
    if icc:
        chunks.append((b"iCCP", b"icc\0\0" + zlib.compress(icc, LEVEL)))
    chunks += [(b"IDAT", zlib.compress(rows.tobytes(), LEVEL)), (b"IEND", b"")]
    return PNG_START + b"".join(chunk(name, data) for name, data in chunks)


def decode_png(data: bytes) -> Array:
    """Return the pixels (H, W, C) of a picture that :func:`encode_png` made."""
    found: dict[bytes, bytes] = {}
    at = len(PNG_START)
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        found[data[at + 4 : at + 8]] = data[at + 8 : at + 8 + length]
        at += 12 + length
    width, height, bits, kind = struct.unpack_from(">IIBB", found[b"IHDR"])
    channels, size = {t: c for c, t in TYPES.items()}[kind], bits // 8
    rows = np.frombuffer(zlib.decompress(found[b"IDAT"]), np.uint8).reshape(height, -1)[:, 1:]
    raw = np.cumsum(rows.reshape(height, width, channels * size), axis=1, dtype=np.uint8)
    return raw.view(">u2").astype(np.uint16) if size == 2 else raw
