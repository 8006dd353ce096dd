"""A strict reader of PPM, PGM, PBM and PFM.

OpenImageIO reads them wrongly: it rounds down if the maximum is neither 255 nor 65535, takes the LF of a CR LF for a
pixel and the scale of a PFM for a factor, and cannot read plain bits without blanks between them.
"""

from __future__ import annotations

import re
from math import prod
from typing import Any

import numpy as np

from ..disk import check_size
from ..foundation import InputError
from ..foundation.arrays import Array

_TOKEN = re.compile(rb"(?:[ \t\r\n\v\f]|#[^\r\n]*(?:[\r\n]|\Z))*([^ \t\r\n\v\f#]+)")
_COMMENT = re.compile(rb"#[^\r\n]*")
_LAST_COMMENT = re.compile(rb"[ \t]*#[^\r\n]*(?=[\r\n])")
_NO_NUMBER = re.compile(rb"[^0-9 \t\r\n\v\f]")
HEADER = 1 << 20
"""A header, comments included, is at most this long."""


def decode_netpbm(data: bytes, name: str) -> Array:
    """Decode a netpbm picture; grey is (H, W), colour (H, W, 3), values are scaled to the full range of 8 or 16 bit."""
    kind, header, pos = data[1:2], list[int](), 2
    for what in ("width", "height", "maximum")[: 3 if kind in b"2356" else 2]:
        found = _TOKEN.match(data, pos, pos + HEADER)
        if not found or not re.fullmatch(rb"\+?[0-9]{1,10}", found[1]):
            raise InputError(f"{name} states no {what} in its header; it is damaged, save it again.")
        pos = found.end()
        header.append(int(found[1]))
    width, height, maxval = (*header, 1)[:3]
    check_size(name, width, height)
    if not 1 <= maxval <= 65535:
        raise InputError(f"{name} has the maximum value {maxval}; allowed are 1 to 65535, so save it again.")
    channels = 3 if kind in b"36F" else 1
    shape = (height, width, 3)[: 2 + channels // 3]
    if kind in b"Ff":
        return _float(data, pos, name, shape)
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
    top = 255 if maxval < 256 else 65535
    if maxval != top:
        values = (values.astype(np.uint32) * np.uint32(top) + np.uint32(maxval // 2)) // np.uint32(maxval)
    return values.astype(np.uint8 if top == 255 else np.uint16).reshape(shape)


def _raw(data: bytes, pos: int, count: int, dtype: np.dtype[Any], name: str) -> Array:
    """Return the binary pixels that follow the header after one blank; CR LF counts as one."""
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
    """Return the values of a plain (ASCII) picture; memory is taken for those that are there, not for those stated."""
    text = _COMMENT.sub(b" ", text) if b"#" in text else text
    if bits:
        text = text.translate(None, b" \t\r\n\v\f")
        if text.translate(None, b"01"):
            raise InputError(f"{name} holds something else than 0 and 1; it is damaged, save it again.")
        values: Array = np.frombuffer(text, np.uint8) - np.uint8(48)
    else:
        odd = _NO_NUMBER.search(text)
        values = np.fromstring(b"" if odd else text.strip(), np.int64, sep=" ")
        if odd or values.max(initial=0) >= 1 << 16:
            raise InputError(
                f"{name} holds something that is no number from 0 to 65535; it is damaged, save it again."
            )
    if len(values) < count:
        raise InputError(f"{name} ends too early ({len(values)} of {count} values); it is damaged, save it again.")
    return values[:count]


def _float(data: bytes, pos: int, name: str, shape: tuple[int, ...]) -> Array:
    """Return the pixels of a PFM, stored bottom up; the sign of the scale is the byte order, its size is ignored."""
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
