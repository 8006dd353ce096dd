"""EXR files as other programs write them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


def save_exr(path: str | Path, channels: dict[str, NDArray[Any]], types: tuple[str, ...] = (), tile: int = 0) -> None:
    """Write an EXR file with these channels in this order, in tiles where a side of them is given."""
    import OpenImageIO as oiio

    values = np.dstack(list(channels.values())).astype(np.float32)
    spec = oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], "float")
    spec.channelnames = tuple(channels)
    if types:
        spec.channelformats = tuple(map(oiio.TypeDesc, types))
    if tile:
        spec.tile_width = spec.tile_height = tile
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec)
    assert file.write_image(values)
    file.close()
