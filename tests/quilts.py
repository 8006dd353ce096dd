"""What tests of patches share: white noise, quilts of it as maps, and maps with holes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import intarsia as ia
from intarsia.model.sourcemap import HOLE, SourceMap
from intarsia.testing import noise


def bytes_of(height: int, width: int, channels: int = 1, seed: int = 0) -> NDArray[np.uint8]:
    """White noise: nothing in it is alike, so every match is by intent."""
    layers = [noise(height, width, 7 * seed + c) >> np.uint64(56) for c in range(channels)]
    return np.stack(layers, axis=2).astype(np.uint8)


def grow(
    exemplar: Any, size: Any, seed: int = 0, wrap: str = "none", start: Any = None, **parameters: Any
) -> SourceMap:  # fmt: skip
    """The map of image quilting on one thread."""
    method = ia.ImageQuilting(**parameters)
    return ia.synthesize(exemplar, size, method, seed=seed, wrap=wrap, start=start, run=ia.Run(1)).map


def holed(smap: SourceMap, holes: NDArray[np.bool_]) -> SourceMap:
    """A map with holes where there are to be some."""
    which = np.zeros(holes.shape, np.uint8) if smap.which is None else smap.which
    return replace(smap, which=np.where(holes, HOLE, which))
