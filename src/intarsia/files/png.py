"""PNG (ISO/IEC 15948): a strict check of every chunk before decoding, and a parallel encoder.

After the check libpng has nothing to complain of on the terminal. The encoder works in memory: a kill leaves no file.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ..disk import check_size
from ..foundation import InputError
from ..foundation.arrays import Array, Pair
from ..foundation.run import Run, run_of
from .formats import PNG_SIDE, damaged_error

PNG_START, PNG_END = b"\x89PNG\r\n\x1a\n", b"\0\0\0\0IEND\xaeB`\x82"

MAX_UNPACKED = 1 << 26
"""Compressed texts and profiles inside a PNG may unpack to this many bytes together."""

LEVEL = 4
"""Of zlib, for PNGs: photos are as small as with 6, smooth ones 6 % larger, in a third to nine tenths of the time."""

BAND = 1 << 18
"""Bytes of pixels that are packed together: threads share even 512 x 512 px, and files of photographs grow by 1 %."""

ADLER, LAST = 65521, 0x0300
"""Modulus of Adler-32 (RFC 1950), and an empty block that ends a deflate stream (RFC 1951, 3.2.6)."""

SLICE = 1 << 16
"""Packed bytes that are unpacked together."""

GRAY, RGB, PALETTE, GRAY_ALPHA, RGBA = 0, 2, 3, 4, 6
CHANNELS = {GRAY: 1, RGB: 3, PALETTE: 1, GRAY_ALPHA: 2, RGBA: 4}
_DEPTHS = {GRAY: (1, 2, 4, 8, 16), RGB: (8, 16), PALETTE: (1, 2, 4, 8), GRAY_ALPHA: (8, 16), RGBA: (8, 16)}
_KEYS = {GRAY: 2, RGB: 6}
"""Bytes of the transparent colour (tRNS); palettes have a list of opacities instead."""

_PASSES = ((0, 0, 8, 8), (0, 4, 8, 8), (4, 0, 8, 4), (0, 2, 4, 4), (2, 0, 4, 2), (0, 1, 2, 2), (1, 0, 2, 1))
"""Adam7: first row and column, steps between rows and between columns."""


@dataclass
class PngFacts:
    """Header, profile, texts and packed pixels of a PNG."""

    width: int = 0
    height: int = 0
    depth: int = 8
    colour: int = GRAY
    interlaced: bool = False
    key: bool = False
    icc: bytes | None = None
    exif: bytes | None = None
    texts: dict[str, str] = field(default_factory=dict)
    head: list[bytes] = field(default_factory=list)
    packed: list[memoryview] = field(default_factory=list)

    @property
    def channels(self) -> int:
        """Number of channels of the decoded pixels."""
        return (3 if self.colour == PALETTE else CHANNELS[self.colour]) + self.key

    def clean(self) -> bytes:
        """Return the file without texts and profiles: header, palette, transparency and pixels."""
        return b"".join([PNG_START, *self.head, *(chunk(b"IDAT", bytes(part)) for part in self.packed), PNG_END])


def chunk(kind: bytes, body: bytes) -> bytes:
    """Return a chunk of a PNG with its length and its checksum."""
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(body, zlib.crc32(kind)))


def parse_png(data: bytes, name: str) -> PngFacts:
    """Parse a PNG; InputError if a checksum is wrong, or a chunk is missing, misplaced or invalid."""
    facts, pos, budget, last = PngFacts(), 8, MAX_UNPACKED, b""
    view = memoryview(data)
    while last != b"IEND":
        head = data[pos : pos + 8]
        end = pos + 12 + int.from_bytes(head[:4], "big")
        if len(head) < 8 or end > len(data):
            raise damaged_error(name, "it has no end")
        kind, body = head[4:], view[pos + 8 : end - 4]
        if zlib.crc32(view[pos + 4 : end - 4]) != int.from_bytes(data[end - 4 : end], "big"):
            raise damaged_error(name, f"the checksum of its part {kind.decode('latin-1')!r} is wrong")
        if pos == 8:
            if kind != b"IHDR" or len(body) != 13:
                raise damaged_error(name, "it has no header")
            facts.width, facts.height, facts.depth, facts.colour, *ways = struct.unpack(">IIBBBBB", body)
            check_size(name, facts.width, facts.height, side=PNG_SIDE)
            if facts.depth not in _DEPTHS.get(facts.colour, ()) or ways not in ([0, 0, 0], [0, 0, 1]):
                raise damaged_error(name, "its header states what no PNG can be")
            facts.interlaced = ways[2] == 1
            facts.head = [chunk(kind, bytes(body))]
        if kind == b"IDAT":
            if facts.packed and last != b"IDAT":
                raise damaged_error(name, "its pixels are torn apart")
            facts.packed.append(body)
        elif kind in (b"iCCP", b"zTXt", b"iTXt", b"tEXt"):
            budget -= _keep_text(facts, kind, bytes(body), name, budget)
        elif kind == b"eXIf":
            facts.exif = bytes(body)
        elif pos > 8 and kind != b"IEND":
            _meaning(facts, kind, bytes(body), name)
        pos, last = end, kind
    if not facts.packed:
        raise damaged_error(name, "it holds no pixels")
    if facts.colour == PALETTE and len(facts.head) < 2:
        raise damaged_error(name, "it has no palette")
    return facts


def _meaning(facts: PngFacts, kind: bytes, body: bytes, name: str) -> None:
    """Keep a chunk if it is a palette or a transparent colour that bears on the pixels."""
    known = [part[4:8] for part in facts.head]
    if kind == b"IHDR":
        raise damaged_error(name, "it has two headers")
    if facts.packed or kind in known:
        return
    if kind == b"PLTE" and facts.colour == PALETTE:
        if not body or len(body) % 3 or len(body) > 3 << facts.depth:
            raise damaged_error(name, "its palette is broken")
    elif kind == b"tRNS":
        if facts.colour == PALETTE:  # an opacity for each colour, the last may be left out
            facts.key = len(facts.head) == 2 and 0 < len(body) <= (len(facts.head[1]) - 12) // 3
        else:
            facts.key = len(body) == _KEYS.get(facts.colour)
        if not facts.key:
            return
    else:
        return
    facts.head.append(chunk(kind, body))


def check_pixels(facts: PngFacts, name: str) -> None:
    """Unpack the pixels, keeping none; InputError for what libpng would complain of on the terminal."""
    unpacker, rows = zlib.decompressobj(), _packed_rows(facts)
    count, size = next(rows)  # rows that are left of a pass, and their bytes
    at = done = 0  # where the next row begins, and how much has come
    try:
        for part in facts.packed:
            for start in range(0, len(part), SLICE):
                packed: bytes | memoryview = part[start : start + SLICE]
                while packed and not unpacker.eof:
                    out = unpacker.decompress(packed, 1 << 20)
                    packed, stop = unpacker.unconsumed_tail, done + len(out)
                    while at < stop:
                        if not count:
                            raise damaged_error(name, "it holds more than its pixels")
                        here = min(count, -(-(stop - at) // size))
                        if max(out[at - done : stop - done : size][:here]) > 4:
                            raise damaged_error(name, "a row is packed in an unknown way")
                        count, at = count - here, at + here * size
                        if not count:
                            count, size = next(rows, (0, 1))
                    done = stop
    except zlib.error:
        raise damaged_error(name, "its pixels cannot be unpacked") from None
    if count or at != done or not unpacker.eof:
        raise damaged_error(name, "it ends within its pixels")


def _packed_rows(facts: PngFacts) -> Iterator[Pair]:
    """Yield number and bytes of the packed rows of each pass; a row begins with its filter type."""
    bits = CHANNELS[facts.colour] * facts.depth
    for y, x, dy, dx in _PASSES if facts.interlaced else ((0, 0, 1, 1),):
        height, width = -(-(facts.height - y) // dy), -(-(facts.width - x) // dx)
        if height > 0 and width > 0:
            yield height, 1 + (width * bits + 7) // 8


def _keep_text(facts: PngFacts, kind: bytes, body: bytes, name: str, budget: int) -> int:
    """Keep a text or a profile; return how many bytes it unpacks to."""
    key, _, rest = body.partition(b"\0")
    word = key.decode("latin-1")
    if kind == b"tEXt":
        facts.texts.setdefault(word, rest.decode("latin-1"))
        return len(rest)
    if kind == b"iTXt":
        packed, rest = rest[:1] == b"\1", rest[2:].partition(b"\0")[2].partition(b"\0")[2]
    else:
        packed, rest = True, rest[1:]
    if packed:
        unpacker = zlib.decompressobj()
        try:
            rest = unpacker.decompress(rest, max(budget, 1))  # 0 would be without a limit
        except zlib.error:
            return 0
        if unpacker.unconsumed_tail:
            raise InputError(f"{name} unpacks to over {MAX_UNPACKED >> 20} MiB of text; save it without metadata.")
    if kind == b"iCCP":
        facts.icc = rest
    else:
        facts.texts.setdefault(word, rest.decode("utf-8", "replace"))
    return len(rest)


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
    colour = (GRAY, GRAY_ALPHA, RGB, RGBA)[channels - 1]
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
