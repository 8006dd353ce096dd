"""PNG (ISO/IEC 15948): a check of all checksums, and a parallel encoder.

The encoder works in memory: a kill leaves no file.
"""

from __future__ import annotations

import struct
import zlib
from functools import partial

import numpy as np

from ..foundation.arrays import Array
from ..foundation.run import Run, run_of
from .formats import damaged_error

PNG_START = b"\x89PNG\r\n\x1a\n"

LEVEL = 4
"""Of zlib, for PNGs: photos are as small as with 6, smooth ones 6 % larger, in a third to nine tenths of the time."""

BAND = 1 << 18
"""Bytes of pixels that are packed together: threads share even 512 x 512 px, and files of photographs grow by 1 %."""

ADLER, LAST = 65521, 0x0300
"""Modulus of Adler-32 (RFC 1950), and an empty block that ends a deflate stream (RFC 1951, 3.2.6)."""

ADAM7 = (
    (0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2),
)  # fmt: skip
"""The passes of interlaced pixels: the first column and row of each, and the steps to the next (ISO/IEC 15948, 8.2)."""


def chunk(kind: bytes, body: bytes) -> bytes:
    """Return a chunk of a PNG with its length and its checksum."""
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(body, zlib.crc32(kind)))


def check_chunks(data: bytes, name: str) -> list[memoryview]:
    """Return the packed pixels of a PNG; InputError if a checksum is wrong or a chunk is missing.

    Pillow checks none of the pixels'.
    """
    view, pos, kinds, packed = memoryview(data), 8, [b""], list[memoryview]()
    while kinds[-1] != b"IEND":
        head = data[pos : pos + 8]
        end = pos + 12 + int.from_bytes(head[:4], "big")
        if len(head) < 8 or end > len(data):
            raise damaged_error(name, "it has no end")
        if zlib.crc32(view[pos + 4 : end - 4]) != int.from_bytes(view[end - 4 : end], "big"):
            raise damaged_error(name, f"the checksum of its part {head[4:].decode('latin-1')!r} is wrong")
        kinds.append(head[4:])
        packed += [view[pos + 8 : end - 4]] * (kinds[-1] == b"IDAT")
        pos = end
    if kinds[1] != b"IHDR" or not packed:
        raise damaged_error(name, "it holds no pixels")
    return packed


def check_whole(header: bytes, packed: list[memoryview], name: str) -> None:
    """Raise InputError if fewer pixels are packed than the header of a PNG says: Pillow leaves the others black."""
    width, height, depth, colour, _, _, interlaced = struct.unpack(">IIBBBBB", header)
    bits, missing = depth * {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour], 0
    for x, y, across, down in ADAM7 if interlaced else ((0, 0, 1, 1),):
        columns, rows = -(-(width - x) // across), -(-(height - y) // down)
        missing += rows * (1 + -(-columns * bits // 8)) * (columns > 0 and rows > 0)
    unpacker = zlib.decompressobj()
    for part in packed:
        rest: bytes | memoryview = part
        while rest and missing > 0:
            missing -= len(unpacker.decompress(rest, BAND))
            rest = unpacker.unconsumed_tail
    if missing > 0:
        raise damaged_error(name, "it ends before all pixels are told")


def encode_png(
    pixels: Array, icc: bytes | None = None, text: str | None = None, level: int = LEVEL, run: Run | None = None
) -> bytes:
    """Return a picture (H, W, C) of uint8 or uint16 as PNG; the threads of `run` share its bands of rows.

    Bands have a fixed length and are compressed independently: the same bytes on any number of threads.
    """
    height, width, channels = pixels.shape
    rows = max(1, BAND // pixels[0].nbytes)
    with run_of(run).pool() as each:
        bands = each(partial(_band, pixels, rows, level), range(0, height, rows))
    colour = (0, 4, 2, 6)[channels - 1]  # gray, gray with alpha, RGB, RGBA
    head = struct.pack(">IIBBBBB", width, height, 8 * pixels.itemsize, colour, 0, 0, 0)
    chunks = [(b"IHDR", head)]
    if icc:
        chunks.append((b"iCCP", b"icc\0\0" + zlib.compress(icc)))
    if text is not None:
        kind, gap = (b"tEXt", b"\0") if text.isascii() else (b"iTXt", b"\0\0\0\0\0")  # fewer programs read the latter
        chunks.append((kind, b"Description" + gap + text.encode()))
    low, high, packed = 1, 0, list[bytes]()  # the halves of the checksum of all bands, from that of each (RFC 1950)
    for part, checksum, count in bands:
        high = (high + (checksum >> 16) + count * (low - 1)) % ADLER
        low = (low + (checksum & 0xFFFF) - 1) % ADLER
        packed.append(part)
    packed[-1] += struct.pack(">HHH", LAST, high, low)
    chunks += [*((b"IDAT", part) for part in packed), (b"IEND", b"")]
    return PNG_START + b"".join(chunk(name, data) for name, data in chunks)


def _band(pixels: Array, rows: int, level: int, top: int) -> tuple[bytes, int, int]:
    """Compress a band filtered by Sub or Up, whichever sums to less; return bytes, Adler-32 and length."""
    some = pixels[max(top - 1, 0) : top + rows]
    raw = np.ascontiguousarray(some.astype(some.dtype.newbyteorder(">"), copy=False)).view(np.uint8)
    raw = raw.reshape(len(some), -1)
    here, step = raw[min(top, 1) :], some[0, 0].nbytes
    before, above = here.copy(), here.copy()
    before[:, step:] -= here[:, :-step]
    above[1 - min(top, 1) :] -= raw[:-1]
    least = min((before, above), key=lambda steps: int(np.minimum(steps, -steps).sum()))
    data = np.insert(least, 0, 1 + (least is above), axis=1).tobytes()  # each row begins with its filter
    packer = zlib.compressobj(level, wbits=-zlib.MAX_WBITS if top else zlib.MAX_WBITS)  # the first has the header
    return packer.compress(data) + packer.flush(zlib.Z_SYNC_FLUSH), zlib.adler32(data), len(data)
