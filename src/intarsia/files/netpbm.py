"""PPM, PGM, PBM and PFM: read strictly, written plainly."""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import prod
from typing import Any

import numpy as np

from ..disk.limits import check_size
from ..errors import InputError
from ..image import Array

_TOKEN = re.compile(rb"(?:[ \t\r\n\v\f]|#[^\r\n]*(?:[\r\n]|\Z))*([^ \t\r\n\v\f#]+)")
_COMMENT = re.compile(rb"#[^\r\n]*")
_LAST_COMMENT = re.compile(rb"[ \t]*#[^\r\n]*(?=[\r\n])")
_BLANK = re.compile(rb"[ \t\r\n\v\f]")
BLANKS, PART = b" \t\r\n\v\f", 1 << 20
_IS_BLANK = np.isin(np.arange(256), np.frombuffer(BLANKS, np.uint8))
_IS_FINE = _IS_BLANK | np.isin(np.arange(256), np.arange(48, 58))
HEADER = 1 << 20
"""A header, comments included, is at most this long."""


def decode_netpbm(data: bytes, name: str) -> Array:
    """Read any netpbm picture; grey is (H, W), colour (H, W, 3), pixels are scaled to the full range."""
    kind = data[1:2]
    channels = 3 if kind in b"36F" else 1
    width, pos = _header_number(data, 2, name, "width")
    height, pos = _header_number(data, pos, name, "height")
    check_size(name, width, height)
    shape = (height, width) if channels == 1 else (height, width, 3)
    if kind in b"Ff":
        return _float(data, pos, name, shape)
    maxval = 1
    if kind not in b"14":
        maxval, pos = _header_number(data, pos, name, "maximum")
        if not 1 <= maxval <= 65535:
            raise InputError(f"{name} has the maximum value {maxval}; allowed are 1 to 65535, so save it again.")
    if kind in b"123":
        values = _written_out(data[pos:], height * width * channels, name, bits=kind == b"1")
    elif kind == b"4":
        row = (width + 7) // 8
        packed = _raw(data, pos, row * height, np.dtype(np.uint8), name).reshape(height, row)
        values = np.unpackbits(packed, axis=1)[:, :width].reshape(-1)
    else:
        values = _raw(data, pos, height * width * channels, np.dtype(np.uint8 if maxval < 256 else ">u2"), name)
    if int(values.max()) > maxval:
        raise InputError(f"{name} holds values above its maximum of {maxval}; it is damaged, save it again.")
    if kind in b"14":
        values = 1 - values  # netpbm: 1 is black
    return _full_range(values, maxval).reshape(shape)


def encode_netpbm(pixels: Array, name: str) -> bytes:
    """Write P5, P6 or PFM; `name` is ppm, pgm or pfm."""
    height, width = pixels.shape[:2]
    colour = pixels.ndim == 3 and pixels.shape[2] == 3
    if name == "pfm":
        head = f"{'PF' if colour else 'Pf'}\n{width} {height}\n-1.0\n"
        return head.encode() + pixels[::-1].astype("<f4").tobytes()
    head = f"{'P6' if colour else 'P5'}\n{width} {height}\n{65535 if pixels.dtype == np.uint16 else 255}\n"
    return head.encode() + pixels.astype(pixels.dtype.newbyteorder(">")).tobytes()


def _header_number(data: bytes, pos: int, name: str, what: str) -> tuple[int, int]:
    found = _TOKEN.match(data, pos, pos + HEADER)
    if not found or not re.fullmatch(rb"\+?[0-9]{1,10}", found[1]):
        raise InputError(f"{name} states no {what} in its header; it is damaged, save it again.")
    return int(found[1]), found.end()


def _raw(data: bytes, pos: int, count: int, dtype: np.dtype[Any], name: str) -> Array:
    """Read the pixels that follow the header: after one blank, where CR LF counts as one."""
    need = count * dtype.itemsize
    if comment := _LAST_COMMENT.match(data, pos, pos + HEADER):
        # "255 #..." may also be a pixel of value 35: the length of the file decides.
        touching = data[pos : pos + 1] == b"#"
        if touching or (len(data) - pos - 1 > need and len(data) - comment.end() - 1 >= need):
            pos = comment.end()
    if data[pos : pos + 1] not in (b" ", b"\t", b"\r", b"\n", b"\v", b"\f"):
        raise InputError(f"{name} ends within its header; it is damaged, save it again.")
    pos += 1
    if data[pos - 1 : pos + 1] == b"\r\n" and len(data) - pos > need:
        pos += 1
    if len(data) - pos < need:
        have = max(0, len(data) - pos)
        raise InputError(f"{name} ends too early ({have} of {need} bytes); it is damaged, copy or save it again.")
    return np.frombuffer(data, dtype, count, pos).astype(dtype.newbyteorder("="))


def _written_out(text: bytes, count: int, name: str, bits: bool) -> Array:
    """Read numbers written out, one part of the text after the other, so that memory stays that of the pixels."""
    text = _COMMENT.sub(b" ", text) if b"#" in text else text
    if len(text) < (count if bits else 2 * count - 1):  # before any room is made for them
        raise InputError(f"{name} ends too early for {count} values; it is damaged, copy or save it again.")
    values, have = np.zeros(count, np.uint8 if bits else np.uint16), 0
    for part in _parts(text):
        if have == count:
            break
        found = _bits(part, name) if bits else _written_numbers(part, count - have, name)
        found = found[: count - have]
        values[have : have + len(found)] = found
        have += len(found)
    if have < count:
        raise InputError(f"{name} ends too early ({have} of {count} values); it is damaged, copy or save it again.")
    return values


def _parts(text: bytes) -> Iterator[bytes]:
    """Cut a text where it is blank."""
    start = 0
    while start < len(text):
        stop = start + PART
        found = _BLANK.search(text, stop) if stop < len(text) else None
        stop = len(text) if found is None else found.start()
        yield text[start:stop]
        start = stop


def _bits(part: bytes, name: str) -> Array:
    digits = part.translate(None, BLANKS)
    if digits.translate(None, b"01"):
        raise InputError(f"{name} holds something else than 0 and 1; it is damaged, save it again.")
    return np.frombuffer(digits, np.uint8) - np.uint8(48)


def _written_numbers(part: bytes, most: int, name: str) -> Array:
    """Read at most so many numbers of up to five digits."""
    codes = np.frombuffer(part + b"     ", np.uint8)
    inside = ~_IS_BLANK[codes]
    edges = np.flatnonzero(inside[1:] != inside[:-1]) + 1
    edges = np.concatenate(([0], edges)) if inside[0] else edges
    starts, lengths = edges[: 2 * most : 2], (edges[1::2] - edges[::2])[:most]
    if not len(starts):
        return np.zeros(0, np.uint16)
    digits = codes[starts[0] : starts[-1] + lengths[-1]]
    if lengths.max() > 5 or not _IS_FINE[digits].all():
        raise _no_numbers(name)
    total = np.zeros(len(starts), np.int32)
    for k in range(int(lengths.max())):
        total = np.where(lengths > k, total * 10 + (codes[starts + k].astype(np.int32) - 48), total)
    if total.max() >= 1 << 16:
        raise _no_numbers(name)
    return total.astype(np.uint16)


def _no_numbers(name: str) -> InputError:
    return InputError(f"{name} holds something that is no number from 0 to 65535; it is damaged, save it again.")


def _full_range(values: Array, maxval: int) -> Array:
    top = 255 if maxval < 256 else 65535
    dtype = np.uint8 if top == 255 else np.uint16
    if maxval == top:
        return values.astype(dtype)
    table = (np.arange(maxval + 1, dtype=np.int64) * top + maxval // 2) // maxval
    return np.asarray(table.astype(dtype)[values])


def _float(data: bytes, pos: int, name: str, shape: tuple[int, ...]) -> Array:
    """PFM: rows from the bottom up; the sign of the scale tells the byte order, its size is ignored."""
    found = _TOKEN.match(data, pos, pos + HEADER)
    try:
        scale = float(found[1]) if found else 0.0
    except ValueError:
        scale = 0.0
    if not found or not np.isfinite(scale) or scale == 0.0:
        raise InputError(f"{name} states no scale in its header; it is damaged, save it again.")
    dtype = np.dtype("<f4" if scale < 0 else ">f4")
    values = _raw(data, found.end(), prod(shape), dtype, name).astype(np.float32)
    return np.ascontiguousarray(values.reshape(shape)[::-1])
