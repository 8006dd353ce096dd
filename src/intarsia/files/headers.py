"""What can be learnt of a file without decoding it: its size, and whether it is whole."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field

from ..errors import InputError
from .formats import check_size

PNG_END = b"\0\0\0\0IEND\xaeB`\x82"

MAX_UNPACKED = 1 << 26
"""Compressed texts and profiles inside a PNG may unpack to this many bytes together."""


@dataclass
class PngFacts:
    """What a PNG states, and the same file without texts and profiles."""

    palette: bool = False
    icc: bytes | None = None
    exif: bytes | None = None
    clean: bytes | None = None  # None: the file is clean as it is
    texts: dict[str, str] = field(default_factory=dict)


def damaged(name: str, why: str) -> InputError:
    """Say in one line that a file cannot be decoded."""
    why = " ".join(str(why).split())[:160].rstrip(".")
    return InputError(f"{name} is damaged or cut off ({why}); copy or save it again.")


def png(data: bytes, name: str) -> PngFacts:
    """Check every chunk of a PNG by its checksum, and that the file has an end."""
    facts, kept, pos, budget = PngFacts(), [data[:8]], 8, MAX_UNPACKED
    seen_pixels = dirty = False
    while True:
        head = data[pos : pos + 8]
        if len(head) < 8:
            raise damaged(name, "it has no end")
        length, kind = int.from_bytes(head[:4], "big"), head[4:]
        end = pos + 12 + length
        if end > len(data):
            raise damaged(name, "it has no end")
        if zlib.crc32(memoryview(data)[pos + 4 : end - 4]) != int.from_bytes(data[end - 4 : end], "big"):
            raise damaged(name, f"the checksum of its part {kind.decode('latin-1')!r} is wrong")
        body = memoryview(data)[pos + 8 : end - 4]
        if pos == 8:
            facts.palette = _ihdr(kind, bytes(body), name)
        if kind in (b"iCCP", b"zTXt", b"iTXt", b"tEXt"):
            budget -= _text(facts, kind, bytes(body), name, budget)
        if kind == b"eXIf":
            facts.exif = bytes(body)
        if kind in (b"IHDR", b"PLTE", b"IDAT", b"IEND", b"tRNS"):
            kept.append(data[pos:end])
        else:
            dirty = True
        seen_pixels |= kind == b"IDAT"
        pos = end
        if kind == b"IEND":
            break
    if not seen_pixels:
        raise damaged(name, "it holds no pixels")
    facts.clean = b"".join(kept) if dirty else None
    return facts


def _ihdr(kind: bytes, body: bytes, name: str) -> bool:
    if kind != b"IHDR" or len(body) != 13:
        raise damaged(name, "it has no header")
    width, height, _, colour = struct.unpack(">IIBB", body[:10])
    check_size(name, width, height)
    return bool(colour == 3)


def _text(facts: PngFacts, kind: bytes, body: bytes, name: str, budget: int) -> int:
    """Keep a text or a profile; return how many bytes it unpacked to."""
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
            rest = unpacker.decompress(rest, budget)
        except zlib.error:
            return 0
        if unpacker.unconsumed_tail:
            raise InputError(f"{name} unpacks to over {MAX_UNPACKED >> 20} MiB of text; save it without metadata.")
    if kind == b"iCCP":
        facts.icc = rest
    else:
        facts.texts.setdefault(word, rest.decode("utf-8", "replace"))
    return len(rest)


def jpeg(data: bytes, name: str) -> None:
    """Check the size that a JPEG states, and that its picture has an end."""
    pos, sized = 2, False
    while True:
        while data[pos : pos + 2] == b"\xff\xff":
            pos += 1
        if pos + 4 > len(data) or data[pos] != 0xFF:
            raise damaged(name, "it ends before the picture starts")
        marker, length = data[pos + 1], int.from_bytes(data[pos + 2 : pos + 4], "big")
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            if pos + 10 > len(data):
                raise damaged(name, "it ends before the picture starts")
            bits, height, width, channels = struct.unpack(">BHHB", data[pos + 4 : pos + 10])
            check_size(name, width, height, channels)
            if bits != 8:
                raise InputError(f"{name} is a JPEG of {bits} bit; only 8 bit is read, so save it as PNG or TIFF.")
            sized = True
        pos += 2 + length
        if marker == 0xDA:
            break
    if not sized:
        raise damaged(name, "it states no size")
    if data.rfind(b"\xff\xd9") < pos:
        raise damaged(name, "it has no end")


def exr(data: bytes, name: str) -> None:
    """Check the sizes that the parts of an EXR state; `data` is the start of the file."""
    parts = bool(int.from_bytes(data[4:8], "little") & 0x1000)
    pos = 8
    while pos < len(data):
        if data[pos] == 0:
            pos += 1
            if not parts or data[pos : pos + 1] in (b"\0", b""):
                return
            continue
        end = data.find(b"\0", pos, pos + 256)
        stop = data.find(b"\0", end + 1, end + 257)
        if end < 0 or stop < 0 or stop + 5 > len(data):
            raise damaged(name, "its header is broken")
        size = int.from_bytes(data[stop + 1 : stop + 5], "little", signed=True)
        if size < 0:
            raise damaged(name, "its header is broken")
        value = data[stop + 5 : stop + 5 + size]
        if data[pos:end] in (b"dataWindow", b"displayWindow") and len(value) == 16:
            x0, y0, x1, y1 = struct.unpack("<4i", value)
            check_size(name, x1 - x0 + 1, y1 - y0 + 1)
        if data[pos:end] == b"tiles" and len(value) == 9:
            check_size(name, *struct.unpack("<II", value[:8]))
        pos = stop + 5 + size
