"""Pictures in and out: the only place that knows file formats, OpenImageIO and Pillow."""

from __future__ import annotations

from .encode import encode
from .formats import MAX_PIXELS, Format, format_of
from .preview import preview_png
from .read import read, read_mask, read_plane, read_set
from .recipe import read_recipe, recipe_path
from .samples import sample, sample_names
from .sets import describe, group
from .write import check_depth, check_writable, write, write_bytes

__all__ = [
    "MAX_PIXELS",
    "Format",
    "check_depth",
    "check_writable",
    "describe",
    "encode",
    "format_of",
    "group",
    "preview_png",
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
