"""Worker process: decode uploads, and show planes and maps. Errors of files arise here."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from ... import files
from ...files.decode import pillow_opened
from ...files.png import encode_png
from ...foundation import InputError
from ...foundation.arrays import UInt8
from ...model import Exemplar
from ...model.image import Kind, Plane, Transfer, to_display
from ...model.sourcemap import SourceMap
from .worker import Answer, Json, Tell

Pixels = UInt8
PILLOWS = {".gif": "gif", ".webp": "webp", ".jpg": "jpeg", ".jpeg": "jpeg"}
"""Endings of files that may hold more than is used, and their formats."""

FEW = 32  # px a side: less is hardly a texture


def seen(plane: Plane) -> Pixels:
    """Return a plane as displayed: (H, W, 3 or 4) of 8 bits; signed normals become (n + 1) / 2."""
    pixels = plane.pixels
    if plane.kind is Kind.NORMAL and plane.is_float and bool((pixels < 0).any()):
        pixels = (pixels + 1) / 2
    found = np.atleast_3d(to_display(pixels, plane.kind, plane.transfer is Transfer.LINEAR))
    gray = found[:, :, [0, 0, 0, 1][: found.shape[2] + 2]] if found.shape[2] < 3 else found
    return np.ascontiguousarray(gray, np.uint8)


def reduced(pixels: Pixels, side: int) -> Pixels:
    """Return pixels (H, W, C), averaged over blocks until no side is longer than `side`."""
    step = -(-max(pixels.shape[:2]) // side)
    if step <= 1:
        return pixels
    down, across = (min(step, side) for side in pixels.shape[:2])
    height, width = pixels.shape[0] // down, pixels.shape[1] // across
    total = np.zeros((height, width, pixels.shape[2]), np.float32)
    for y, x in np.ndindex(down, across):  # seven times as fast as the mean of blocks, and the same
        total += pixels[y : height * down : down, x : width * across : across]
    mean: Pixels = (total / (down * across) + np.float32(0.5)).astype(np.uint8)
    return mean


png = partial(encode_png, level=1)
"""Return pixels (H, W, C) as PNG, compressed quickly."""


def coloured(smap: SourceMap, first: int, step: int, colours: Callable[[int, Any, Any], Any]) -> Pixels:
    """Return every `step`-th pixel of a map in a colour of its exemplar, rows and columns; clear in holes: RGBA."""
    which, yx = smap.numbers[first::step, first::step], smap.yx[first::step, first::step]
    out = np.zeros((*which.shape, 4), np.uint8)
    for number, source in enumerate(smap.sources):
        here = (which == number) & ((yx >= 0) & (yx < (source.height, source.width))).all(axis=2)
        if here.any():
            out[here, :3] = colours(number, *yx[here].T)
            out[here, 3] = 255
    return out


def see(said: Json, tell: Tell) -> Answer:
    """Return a plane as PNG of 8 bits, at most `side` px, or a box at full size."""
    pixels = _seen(tuple(said["paths"]), said["plane"])
    if "side" in said:
        return {}, png(reduced(pixels, said["side"]))
    x, y, width, height = said["box"]
    part = pixels[y : y + height, x : x + width]
    if not part.size:
        raise InputError(f"box: nothing lies there; the picture has {pixels.shape[1]}x{pixels.shape[0]} px.")
    return {}, png(part)


@lru_cache(maxsize=1)
def _seen(paths: tuple[str, ...], name: str) -> Pixels:
    """Return a plane as displayed; the last one is cached, as large ones are requested part by part."""
    found = _group(list(paths))
    if name not in found:
        raise InputError(f"there is no plane {name}.")
    plane = files.read_plane(found[name]) if name == "mask" else files.read_set(found).planes[name]
    return seen(plane)


def _group(paths: list[str]) -> dict[str, str]:
    """Return the files of one exemplar by plane; InputError if they are several."""
    if paths[0].startswith("sample:"):
        own = {name: os.fspath(path) for name, path in files.material_sets.layered(paths[0]).items()}
        return own or {"albedo": paths[0]}
    sets = files.group(paths)
    if len(sets) != 1:
        raise InputError(f"these are {len(sets)} exemplars by their names; send the files of one at a time.")
    layers = files.material_sets.layered(next(iter(sets[0].values()))) if len(sets[0]) == 1 else {}
    return {name: os.fspath(path) for name, path in (layers or sets[0]).items()}


def exemplar_of(paths: list[str]) -> Exemplar:
    """Read the files of one exemplar."""
    return files.read_set(_group(paths))


def sets(said: Json, tell: Tell) -> Answer:
    """Sort names of files into exemplars."""
    return {"sets": [list(found.values()) for found in files.group(said["names"])]}, b""


def look(said: Json, tell: Tell) -> Answer:
    """Read the files of one exemplar; return its name, size, depth and planes."""
    paths = said["paths"]
    exemplar = exemplar_of(paths)
    base = exemplar.base
    planes = [
        {"name": n, "normals": p.meta.get("normals"), "proposed": "proposed" in p.meta}
        for n, p in exemplar.planes.items()
    ]
    if exemplar.usable is not None:
        planes.append({"name": "mask", "normals": None, "proposed": False})
    name = exemplar.name.rpartition(":")[2] if len(paths) > 1 or ":" in exemplar.name else ""  # one file keeps its own
    own = {"name": name or Path(paths[0]).stem, "width": base.width, "height": base.height}
    told = [line for path in paths if Path(path).suffix in PILLOWS for line in _lost(Path(path))]
    if min(base.width, base.height) < FEW:
        told.append(f"{own['name']} has {base.width}x{base.height} px: below {FEW} there is hardly a texture.")
    depth = 1 if base.pixels.dtype == bool else 8 * base.pixels.dtype.itemsize
    return {**own, "depth": depth, "planes": planes, **({"told": told} if told else {})}, b""


def _lost(path: Path) -> Iterator[str]:
    """Yield what of a file is not used, in words."""
    with pillow_opened(PILLOWS[path.suffix], path.read_bytes()) as image:
        if getattr(image, "is_animated", False):
            yield f"{path.name} is animated: its first picture is used."
        if image.mode == "CMYK":
            yield f"{path.name} is made for print (CMYK): its colours were turned into RGB, and may look different."


def labels(said: Json, tell: Tell) -> Answer:
    """Check a picture of numbers: one channel, 8 bits."""
    plane = files.read_plane(said["path"], "label")
    if plane.channels != 1 or plane.pixels.dtype != np.uint8:
        raise InputError("the image is no PNG of one channel and 8 bits; save it so.")
    return {}, b""


def origins(said: Json, tell: Tell) -> Answer:
    """Return where every pixel of a box comes from: uint16, little-endian, (H, W, 3): exemplar, row, column.

    65535: from nowhere. What of the box lies outside of the map is left out.
    """
    smap = _map(said["map"])
    x, y, width, height = said["box"]
    part = np.s_[y : y + height, x : x + width]
    which = smap.numbers[part]
    out = np.empty((*which.shape, 3), "<u2")
    out[..., 0], out[..., 1:] = which, np.clip(smap.yx[part], 0, 65534)
    out[which == 255] = 65535
    return {"width": smap.width, "height": smap.height}, out.tobytes()


@lru_cache(maxsize=1)
def _map(path: str) -> SourceMap:
    """Return a map; the last one is cached, as it is requested part by part."""
    return SourceMap.load(path)


