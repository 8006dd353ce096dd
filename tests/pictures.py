"""Pictures written byte by byte, sound or hostile: PNG of every kind, JPEG of many scans, and what unpacks far."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from corpus import chunk

PASSES = ((0, 0, 8, 8), (0, 4, 8, 8), (4, 0, 8, 4), (0, 2, 4, 4), (2, 0, 4, 2), (0, 1, 2, 2), (1, 0, 2, 1))
CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}


def filtered(rows: list[bytes], step: int, kind: int) -> bytes:
    """Pack rows as PNG does before it compresses, all by one filter (0 to 4); `step` is the bytes of a pixel."""
    if kind == 0:
        return b"".join(b"\0" + row for row in rows)
    out, above = b"", bytes(len(rows[0]) if rows else 0)
    for row in rows:
        line = bytearray()
        for i, value in enumerate(row):
            a = row[i - step] if i >= step else 0
            b, c = above[i], above[i - step] if i >= step else 0
            p = a + b - c
            paeth = min((a, b, c), key=lambda v: abs(p - v))
            line.append((value - (0, a, b, (a + b) // 2, paeth)[kind]) & 255)
        out, above = out + bytes([kind]) + bytes(line), row
    return out


def packed_row(values: np.ndarray, depth: int) -> bytes:
    """A row of samples, (W * C,), as bytes of 1, 2, 4, 8 or 16 bit each."""
    if depth == 16:
        return values.astype(">u2").tobytes()
    if depth == 8:
        return values.astype(np.uint8).tobytes()
    bits = "".join(f"{int(v):0{depth}b}" for v in values)
    bits += "0" * (-len(bits) % 8)
    return bytes(int(bits[i : i + 8], 2) for i in range(0, len(bits), 8))


def png_of(
    samples: np.ndarray, depth: int, colour: int, *, interlaced: bool = False, kind: int = 4, extra: bytes = b"",
    body: bytes | None = None,
) -> bytes:  # fmt: skip
    """Write samples (H, W, C) as a PNG; `body` may say what is packed in their place, `extra` stands before it."""
    height, width = samples.shape[:2]
    step = max(1, CHANNELS[colour] * depth // 8)
    passes = PASSES if interlaced else ((0, 0, 1, 1),)
    rows = b""
    for y, x, dy, dx in passes:
        part = samples[y::dy, x::dx]
        if part.size:
            rows += filtered([packed_row(row.reshape(-1), depth) for row in part], step, kind)
    head = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, interlaced)
    packed = zlib.compress(rows if body is None else body)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + extra + chunk(b"IDAT", packed) + chunk(b"IEND", b"")
    )  # fmt: skip


def samples_of(height: int, width: int, depth: int, colour: int) -> np.ndarray:
    """Samples without any order, (H, W, C), the same at every call."""
    y, x, c = np.mgrid[:height, :width, : CHANNELS[colour]]
    return (y * 7919 + x * 104729 + c * 1299709 + y * x * 31) * 40503 // 8 % (1 << depth)


def many_scans(data: bytes, scans: int) -> bytes:
    """A progressive JPEG whose last scan comes again and again: each goes over the whole picture."""
    at = data.rfind(b"\xff\xda")
    return data[:at] + data[at:-2] * scans + data[-2:]


def flat_png(width: int, height: int, depth: int, colour: int, extra: bytes = b"") -> bytes:
    """A PNG of zeros, about a thousandth of what it unpacks to."""
    packer, row = zlib.compressobj(9), bytes(1 + (width * CHANNELS[colour] * depth + 7) // 8)
    body = b"".join(packer.compress(row) for _ in range(height)) + packer.flush()
    head = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + extra + chunk(b"IDAT", body) + chunk(b"IEND", b"")
