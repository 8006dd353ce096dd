"""The head and the directory of a BigTIFF: what describes its tiles, and the recipe of the texture.

TIFF 6.0 (Adobe 1992) and the BigTIFF extension: 64-bit offsets.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..files.encode import MARK
from ..image import Kind, Plane
from .cells import Grid

START = 16  # bytes before the first tile
SIZES = 325  # the tag of the bytes of tiles


def head(where: int) -> bytes:
    """The first bytes of a file whose directory lies at `where`."""
    return struct.pack("<2sHHHQ", b"II", 43, 8, 0, where)


def directory(like: Plane, grid: Grid, recipe: dict[str, Any], ends: Sequence[int], where: int) -> bytes:
    """The image file directory, and what does not fit into it, as it lies at `where`.

    `grid`: the tiles; `ends`: where the first begins, and where each of them ends.
    """
    count, bits = like.channels, 8 if like.pixels.dtype == bool else 8 * like.pixels.dtype.itemsize
    colours = 3 if count >= 3 and like.kind is not Kind.DATA else 1
    integral = like.pixels.dtype.kind in "bu"
    text = (MARK + json.dumps(recipe, sort_keys=True, separators=(",", ":"))).encode() + b"\0"
    fields: list[tuple[int, str, Any]] = [
        (256, "I", [grid.width]),
        (257, "I", [grid.height]),
        (258, "H", [bits] * count),
        (259, "H", [8]),
        (262, "H", [2 if colours == 3 else 1]),
        (270, "s", text),
        (277, "H", [count]),
        (284, "H", [1]),
        (317, "H", [2 if integral else 1]),
        (322, "I", [grid.columns]),
        (323, "I", [grid.rows]),
        (324, "Q", ends[:-1]),
        (SIZES, "Q", np.diff(ends).tolist()),
        *([(338, "H", [2 if like.alpha else 0] * (count - colours))] if count > colours else []),
        (339, "H", [1 if integral else 3] * count),
        *([(34675, "B", list(like.meta["icc"]))] if like.meta.get("icc") else []),
    ]
    return _packed(fields, where)


def sizes_in(data: bytes, where: int, tiles: int) -> list[int] | None:
    """Read the bytes of each tile from a directory that lies at `where`; None where it does not tell."""
    try:
        for at in range(8, 8 + 20 * struct.unpack_from("<Q", data)[0], 20):
            tag, kind, count = struct.unpack_from("<HHQ", data, at)
            if (tag, kind, count) == (SIZES, 16, tiles):
                begin = at + 12 if tiles == 1 else struct.unpack_from("<Q", data, at + 12)[0] - where
                return list(struct.unpack_from(f"<{tiles}Q", data, begin))
    except struct.error:
        pass
    return None


def _packed(fields: list[tuple[int, str, Any]], where: int) -> bytes:
    """A directory of tags: entries of 20 bytes, then the values that are longer than 8."""
    types = {"s": 2, "B": 1, "H": 3, "I": 4, "Q": 16}
    entries, more = b"", b""
    after = where + 8 + 20 * len(fields) + 8
    for tag, kind, values in fields:
        data = values if kind == "s" else struct.pack(f"<{len(values)}{kind}", *values)
        if len(data) > 8:
            more += b"\0" * (-len(more) % 8)
            place = struct.pack("<Q", after + len(more))
            more += data
        else:
            place = data.ljust(8, b"\0")
        entries += struct.pack("<HHQ", tag, types[kind], len(values)) + place
    return struct.pack("<Q", len(fields)) + entries + struct.pack("<Q", 0) + more
