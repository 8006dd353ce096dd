"""A texture as a dask array: every block is a window, drawn when it is asked for."""

from __future__ import annotations

import uuid
from typing import Any

import numpy as np

from ..corrections.asked import functions_of
from ..errors import ParameterError
from ..geometry import Box
from ..image import Array
from .extras import extra
from .picture import Picture, checked


def array_of(texture: Picture, sides: tuple[int, int], chunks: Any, origin: Any) -> Any:
    """Return a window of a texture as a dask array; the texture is one entry of its graph, sent once to a worker."""
    dask, arrays = extra("dask"), extra("dask.array")
    y, x = checked(texture, sides, origin)
    shape = texture.shape_of(*sides)
    wanted = chunks if isinstance(chunks, (tuple, list)) else (chunks, chunks)
    try:
        cut = arrays.core.normalize_chunks((*wanted[:2], *shape[2:]), shape, dtype=texture.dtype)
    except (ValueError, TypeError, NotImplementedError) as e:  # the last: dask's own word for chunks it cannot size
        raise ParameterError(f"chunks={chunks!r} do not suit {shape} ({e}); give a number of px.") from None
    name = f"weave-{texture.digest[:32]}"
    if functions_of(texture.method):  # a recipe without a box does not tell them apart: no block is another's
        name += f"-{uuid.uuid4().hex}"
    return arrays.map_blocks(
        block, dask.delayed(texture, name=name, traverse=False), y, x,
        name=f"{name}-{y}-{x}-{dask.base.tokenize(cut)[:16]}", chunks=cut, dtype=texture.dtype,
        meta=np.empty((0,) * len(shape), texture.dtype),
    )  # fmt: skip


def block(texture: Picture, y: int, x: int, block_info: Any = None) -> Array:
    """Draw the block of a dask array that begins at (y, x) of the endless plane."""
    rows, columns = block_info[None]["array-location"][:2]
    return texture.draw(Box(rows[0], columns[0], rows[1], columns[1]).moved(y, x))
