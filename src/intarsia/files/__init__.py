"""Pictures in and out: the only place that knows file formats, OpenImageIO and what Pillow reads."""

from __future__ import annotations

from ..disk.limits import DEFAULT_PIXELS, MAX_PIXELS, allowing
from ..disk.whole import check_writable, write_bytes
from .formats import Format, format_of
from .read import read, read_mask, read_plane, read_set, sample, sample_names
from .sets import describe, group, materials
from .write import check_depth, check_layered, encode, preview, read_recipe, recipe_path, write

__all__ = [
    "DEFAULT_PIXELS",
    "MAX_PIXELS",
    "Format",
    "allowing",
    "check_depth",
    "check_layered",
    "check_writable",
    "describe",
    "encode",
    "format_of",
    "group",
    "materials",
    "preview",
    "read",
    "read_mask",
    "read_plane",
    "read_recipe",
    "read_set",
    "recipe_path",
    "sample",
    "sample_names",
    "write",
    "write_bytes",
]
