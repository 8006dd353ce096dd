"""What can be learnt of a file without decoding it: its size, what it will cost, and whether it is whole."""

from __future__ import annotations

import struct

from ..disk.limits import check_cost, check_size, most_pixels
from ..errors import InputError

MOST_SCANS = 500
"""A progressive JPEG may have as many scans; each of them goes over the whole picture again."""

WEBP = 10
"""Bytes that libwebp takes for a pixel."""

SCANS = 16
"""As many may go over the largest picture that is allowed, and more over smaller ones."""

def damaged(name: str, why: str) -> InputError:
    """Say in one line that a file cannot be decoded."""
    why = " ".join(str(why).split())[:160].rstrip(".")
    return InputError(f"{name} is damaged or cut off ({why}); copy or save it again.")


def jpeg(data: bytes, name: str) -> None:
    """Check the size that a JPEG states, what it will cost, and that its picture has an end."""
    pos, frame, progressive, samples = 2, None, False, 0.0
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
            frame, progressive = (width, height), marker in (0xC2, 0xC6, 0xCA, 0xCE)
            samples = _samples(data[pos + 11 : pos + 2 + length : 3])
        pos += 2 + length
        if marker == 0xDA:
            break
    if frame is None:
        raise damaged(name, "it states no size")
    if data.rfind(b"\xff\xd9") < pos:
        raise damaged(name, "it has no end")
    pixels, scans = frame[0] * frame[1], 1 + data.count(b"\xff\xda", pos)
    # With several scans all coefficients are kept, 16 bit each.
    check_cost(name, pixels * (4 + 2 * samples * (progressive or scans > 1)), len(data))
    _check_scans(name, scans, pixels)


def _samples(factors: bytes) -> float:
    """How many samples a pixel has, of the sampling factors of the channels: 3 for full colour, 1.5 for 4:2:0."""
    sizes = [max(f >> 4, 1) * max(f & 15, 1) for f in factors] or [1]
    return sum(sizes) / max(sizes)


def _check_scans(name: str, scans: int, pixels: int) -> None:
    """Refuse more passes over a picture than any encoder makes: each takes time however little it holds."""
    most = min(MOST_SCANS, max(SCANS, SCANS * most_pixels() // max(pixels, 1)))
    if scans > most:
        raise InputError(
            f"{name} is a JPEG of {scans} scans; at most {most} are read at its size; save it anew, not progressive."
        )


def webp(data: bytes, name: str, held: int) -> None:
    """Check the size that a WebP states, and what it will cost; `data` is the start of a file of `held` bytes."""
    kind, body = data[12:16], data[20:30]
    if len(body) < 10 or kind not in (b"VP8X", b"VP8L", b"VP8 "):
        raise damaged(name, "it has no header")
    if kind == b"VP8X":
        width, height = (1 + int.from_bytes(body[k : k + 3], "little") for k in (4, 7))
    elif kind == b"VP8L":
        bits = int.from_bytes(body[1:5], "little")
        width, height = (1 + (bits >> k & 0x3FFF) for k in (0, 14))
    else:
        width, height = (int.from_bytes(body[k : k + 2], "little") & 0x3FFF for k in (6, 8))
    check_size(name, width, height)
    check_cost(name, WEBP * width * height, held)


def exr_channels(data: bytes) -> list[str]:
    """List the channels of an EXR of one part, of which `data` is the start; none where its header ends beyond."""
    if int.from_bytes(data[4:8], "little") & 0x1000:
        return []
    pos = data.find(b"channels\0chlist\0")
    size = int.from_bytes(data[pos + 16 : pos + 20], "little") if pos >= 0 else 0
    left, names = data[pos + 20 : pos + 20 + size], list[str]()
    while left[:1] not in (b"", b"\0"):
        end = left.find(b"\0")
        if end < 0 or len(left) < end + 17:
            return []
        names.append(left[:end].decode("utf-8", "replace"))
        left = left[end + 17 :]  # type, linearity and sampling
    return names if left else []


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
