"""In the process beside: what came in is looked at, and seen. Whatever can go wrong with a file goes wrong here."""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import InputError
from .worker import Answer, Tell

if TYPE_CHECKING:
    from ...exemplar import Exemplar
    from ...image import Plane
    from .pictures import Pixels

def look(said: dict[str, Any], tell: Tell) -> Answer:
    """Read the files of one exemplar, or an image of numbers; return what they are."""
    return _labels(said["paths"][0]) if said.get("labels") else _exemplar(said["paths"])


def see(said: dict[str, Any], tell: Tell) -> Answer:
    """Return a plane as PNG, of 8 bits and at most `side` px, or a part of it, pixel for pixel."""
    from .pictures import png, reduced

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
    """What can be seen of a plane; the last one is kept, as large ones are asked for part by part."""
    from ... import files
    from .pictures import seen

    found = _group(list(paths))
    if name not in found:
        raise InputError(f"there is no plane {name}.")
    plane = files.read_plane(found[name]) if name == "mask" else files.read_set(found).planes[name]
    return seen(plane)


def _group(paths: list[str]) -> dict[str, str]:
    """The files of one exemplar by plane."""
    from ... import files

    if paths[0].startswith("sample:"):
        own = {name: os.fspath(path) for name, path in files.sets.layered(paths[0]).items()}
        return own or {"albedo": paths[0]}
    sets = files.group(paths)
    if len(sets) != 1:
        raise InputError(f"these are {len(sets)} exemplars by their names; send the files of one at a time.")
    layers = files.sets.layered(next(iter(sets[0].values()))) if len(sets[0]) == 1 else {}
    return {name: os.fspath(path) for name, path in (layers or sets[0]).items()}


def exemplar_of(paths: list[str]) -> Exemplar:
    """Read the files of one exemplar."""
    from ... import files

    return files.read_set(_group(paths))


def _exemplar(paths: list[str]) -> Answer:
    exemplar = exemplar_of(paths)
    planes = [_told(name, plane) for name, plane in exemplar.planes.items()]
    if exemplar.usable is not None:
        planes.append({"name": "mask", "width": exemplar.width, "height": exemplar.height, "depth": 8, "channels": 1})
    base = exemplar.base
    own = {"name": exemplar.name.rpartition(":")[2] or Path(paths[0]).stem, "width": base.width, "height": base.height}
    return {**own, "depth": planes[0]["depth"], "channels": base.channels, "planes": planes}, b""


def _told(name: str, plane: Plane) -> dict[str, Any]:
    depth = {"bool": 1}.get(plane.pixels.dtype.name, 8 * plane.pixels.dtype.itemsize)
    sizes = {"width": plane.width, "height": plane.height, "depth": depth, "channels": plane.channels}
    green = {"normals": plane.meta["normals"]} if "normals" in plane.meta else {}
    return {"name": name, "kind": plane.kind.value, **sizes, **green}


def _labels(path: str) -> Answer:
    """Check a picture of numbers: one channel, 8 bits; return its size and which numbers are in it."""
    import numpy as np

    from ... import files

    plane = files.read_plane(path, "label")
    if plane.channels != 1 or plane.pixels.dtype != np.uint8:
        raise InputError("the image is no PNG of one channel and 8 bits; save it so.")
    values = [int(v) for v in np.unique(plane.pixels)]
    return {"width": plane.width, "height": plane.height, "values": values}, b""
