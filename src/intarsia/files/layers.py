"""Layers: an EXR file may hold several planes, each in channels such as normal.X; FILE.exr::normal is one of them."""

from __future__ import annotations

import os
from collections.abc import Sequence

from ..errors import InputError

PathLike = str | os.PathLike[str]

MARK = "::"
"""What stands between the name of a file and that of a layer."""

_PLAIN = "RGBAXYZ"
"""Channels that have no names of their own, in their order; those of one letter only are a picture without a name."""


def split(path: PathLike) -> tuple[PathLike, str | None]:
    """Return the file that a path names, and the layer in it, None where none is named."""
    file, mark, layer = os.fspath(path).rpartition(MARK)
    return (file, layer) if mark and file.lower().endswith(".exr") else (path, None)


def channels_in(names: Sequence[str], layer: str, file: str) -> list[int]:
    """Return which channels of these names are a layer, red before green, x before y; InputError where none is."""
    own = [i for i, name in enumerate(names) if layer_of(name) == layer]
    if not own:
        known = ", ".join(dict.fromkeys(filter(None, map(layer_of, names)))) or "none"
        raise InputError(f"{file}: the file has no such layer; its layers are {known}.")
    last = [names[i].rpartition(".")[2].upper() for i in own]
    if not all(len(letter) == 1 and letter in _PLAIN for letter in last):
        return own
    if sorted(last) == ["A", "Y"]:
        return [own[last.index("Y")], own[last.index("A")]]
    return [i for _, i in sorted(zip(map(_PLAIN.index, last), own, strict=True))]


def channel_names(name: str, channels: int, vectors: bool) -> list[str]:
    """Name the channels of a plane that is to be a layer."""
    if vectors:
        letters = ["X", "Y", "Z"]
    elif channels > 4:
        letters = [f"c{i:02d}" for i in range(channels)]
    else:
        letters = [["Y"], ["Y", "A"], ["R", "G", "B"], ["R", "G", "B", "A"]][channels - 1]
    return [f"{name}.{letter}" for letter in letters]


def layer_of(channel: str) -> str:
    """The layer of a channel; one that has more than a letter for a name is a layer of its own."""
    layer, dot, own = channel.rpartition(".")
    return layer if dot else "" if len(own) == 1 else own
