"""The exit code with which a command must end when it is given a file in a role: what is promised, not what it does.

2: the options do not fit (the output's format cannot hold the picture, an exemplar without labels); 3: the file is
missing, broken, or of the wrong size or kind; 0: it is fine. Other files of the line are those of `make_sound`, 24x20
px of 8 bit colour, and the output is a PNG.
"""

from __future__ import annotations

import os

import corpus
import numpy as np
from roles import GRAY, OVER_OUTPUT, Role

from intarsia import files
from intarsia.foundation import InputError
from intarsia.model.image import Kind, Plane

SIZE = (24, 20)  # of all sound pictures
LEAST_TILED = 16  # px a side; of less nothing is left beside the band

LONGEST_NAME = 255 - len("_tiles_field")  # bytes, of files whose names are continued

AS_USAGE = {"recipe patch=700", "recipe start", "recipe guide", "recipe extend far"}
"""Recipes that are sound, but not for this line: refused like options."""

FLOAT_FORMATS = (".exr", ".tif", ".tiff", ".pfm", ".hdr")


def sort_of(name: str) -> str:
    """What a case holds: a picture, a map or a recipe."""
    return name.split()[0] if name.startswith(("map ", "recipe ")) else "picture"


def read(path: str, kind: Kind | None = None) -> Plane | None:
    """The picture in a file, None where it cannot be read."""
    try:
        return files.read_plane(path, kind)
    except InputError:
        return None


def codes(role: Role, name: str, outcome: str, plane: Plane | None, path: str) -> set[int]:
    """The exit codes that are right; more than one only where damage may or may not show."""
    if role.sort == "map" and role.how == "stdin":
        return {2}  # maps are read from files
    if role.sort != sort_of(name):
        return {3}
    if role.sort == "picture":
        if role.field in ("masks", "usable", "holes", "labels", "target") and name == "whole-32.tif":
            return {_as_numbers(role, read(path, Kind.LABEL))}
        if role.field in GRAY:
            return {3 if plane is None else _as_gray(role, plane)}
        return {3 if plane is None else _as_numbers(role, plane) if _numbers(role) else _as_colours(role, plane, path)}
    if role.how == "stdin" or role.field == "start":
        return {3}  # a recipe is no picture; and the hash of the map is another
    if name in AS_USAGE:
        return {2}
    return {corpus.OK: {0}, corpus.REFUSED: {3}, corpus.EITHER: {0, 3}}[outcome]


def _numbers(role: Role) -> bool:
    return role.field in ("masks", "usable", "holes", "labels", "target")


def _as_colours(role: Role, plane: Plane, path: str) -> int:
    size = (plane.width, plane.height)
    channels = plane.samples.shape[2]
    scales = any(size == (24 * k, 20 * k) or (size[0] * k, size[1] * k) == SIZE for k in (1, 2, 4))
    if role.field == "maps" and not scales:
        return 3
    if role.command == "replay":
        return 3  # the hash is another
    if plane.is_float and not np.isfinite(plane.samples).all():
        return 3
    if role.command == "analyze":
        return 0
    if role.command == "export":
        return 2 if channels > 4 else 0
    if role.command == "maps":
        return 2 if role.how == "second" else 0  # both would be called out_albedo.png
    if role.command == "tileset" and role.field == "files":  # in its own format, or one that holds it
        too_long = role.how == "path" and len(os.path.basename(path)) > LONGEST_NAME
        return 3 if min(size) < LEAST_TILED or too_long else 2 if channels > 4 else 0
    if role.command == "score":
        base = files.read(path).base
        return 0 if base.kind is Kind.COLOUR and base.channels == 3 else 3
    if role.field == "donors" or (role.how == "second" and role.command != "paint"):
        return 0 if _like_the_first(path) else 3
    if role.command == "tile" and role.field == "files" and min(size) < LEAST_TILED:
        return 3
    if role.command in ("paint", "heal", "render") and role.field == "files" and role.how != "second" and size != SIZE:
        return 3
    if role.how == "second":
        return 2  # one label picture is given
    if role.command == "weave":  # a TIFF holds them all; the method of the line takes no masks, as of footprints
        return 2 if role.field == "files" and files.read(path).usable is not None else 0
    return 0 if _fits(path if role.field == "maps" and role.how == "path" else "out.png", plane, channels) else 2


def _like_the_first(path: str) -> bool:
    """Whether an exemplar can lie in one picture with 8 bit colour; an alpha of footprints is a mask."""
    base = files.read(path).base
    return base.pixels.dtype == np.uint8 and base.channels == 3


def _fits(path: str, plane: Plane, channels: int) -> bool:
    """Whether the format of a further plane (that of its file) or of the base (PNG) holds such pixels."""
    ending = os.path.splitext(path)[1].lower()
    if plane.is_float:
        return ending in FLOAT_FORMATS
    return ending not in (".exr", ".pfm") and (channels <= 4 or ending in (".tif", ".tiff"))


def _as_gray(role: Role, plane: Plane) -> int:
    """Whether a picture is gray, of the right size and in range; over an output without end any size will do."""
    values, (low, high) = plane.samples, GRAY[role.field]
    if plane.channels in (2, 4):
        if (values[:, :, -1] != values[0, 0, -1]).any():
            return 3
        values = values[:, :, :-1]
    if (values != values[:, :, :1]).any() or (plane.is_float and not ((values >= low) & (values <= high)).all()):
        return 3
    if role.command == "replay":
        return 3  # the hash is another
    if role.command not in ("grow", "weave", "paint"):
        return 2  # no method that begins with a picture jitters
    wanted = (26, 22) if role.field in OVER_OUTPUT and role.command == "grow" else SIZE
    endless = role.command == "weave" and role.field in OVER_OUTPUT
    if not endless and (plane.width, plane.height) != wanted:
        return 3
    return 3 if role.field == "feature" and len(set(_light_where(values).flat)) == 1 else 0


def _light_where(values: np.ndarray) -> np.ndarray:
    full = 1 if values.dtype.kind == "f" else np.iinfo(values.dtype).max
    return np.asarray(values[:, :, 0] > full / 2)


def _as_numbers(role: Role, plane: Plane | None) -> int:
    if plane is None or (role.field != "target" and (plane.width, plane.height) != SIZE):
        return 3
    if role.command == "replay":
        return 3  # the hash is another
    if role.field in ("labels", "target"):
        return _as_labels(role.field, plane)
    if role.command == "render":
        return 0  # which pixels may be used was settled when the map was made
    if role.command == "weave" and _light(plane):
        return 2  # the method of the line takes no masks
    return 0 if _light(plane) else 3


def _light(plane: Plane) -> bool:
    """Whether a mask has white pixels."""
    values = plane.samples.astype(np.float64)
    full = 1.0 if plane.is_float or values.max() <= 1 else float(np.iinfo(plane.samples.dtype).max)
    light = values[:, :, :3] @ [0.2126, 0.7152, 0.0722] if values.shape[2] > 2 else values[:, :, 0]
    opaque = values[:, :, -1] > full / 2 if values.shape[2] in (2, 4) else True
    with np.errstate(invalid="ignore"):
        return bool(((light > full / 2) & opaque).any())


def _as_labels(field: str, plane: Plane) -> int:
    """The sound label pictures are black and white; what is asked for must be there."""
    values = plane.samples
    if plane.is_float or values.dtype == np.uint32 or values.shape[2] > 4:
        return 3
    if values.shape[2] in (2, 4):
        if (values[:, :, -1] != values[0, 0, -1]).any():
            return 3
        values = values[:, :, :-1]
    found = {tuple(row) for row in values.reshape(-1, values.shape[2]).tolist()}
    full = int(np.iinfo(values.dtype).max)
    both = {(0,) * values.shape[2], (full,) * values.shape[2]}
    return 0 if (found == both if field == "labels" else found <= both) else 3
