"""Planes become files, whole or not at all, in the depth that is asked for; the recipe of one is found again."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np

from ..arguments import called, expect, expect_path
from ..arrays import Pair, pixels_of
from ..disk.depth import converted, dtype_of, looked_at
from ..disk.whole import PathLike, check_writable, put_all, write_bytes
from ..errors import InputError, ParameterError, printable
from ..image import Kind, Plane, Transfer
from . import png
from .decode import opened, pillow_opened
from .encode import MARK, check_holds, check_layers, encode, encode_layers, holds_recipe
from .formats import PictureFile, damaged, format_of, look


def write(
    path: PathLike, picture: Any, *, depth: int | str | None = None, recipe: str | None = None, force: bool = False
) -> None:
    """Write a picture; its ending names the format, and its depth stays as it is unless another is asked for.

    Parameters
    ----------
    path : path, or "-" for the standard output (PNG, or EXR for floats)
    picture : Plane, Synthesis or array, or a dict of them, which become layers of one EXR file
    depth : 8, 16, "half" or "float", optional
        Convert to this depth, rounding to the nearest value.
    recipe : str, optional
        JSON to embed; it lies beside as ``OUT.recipe.json`` where the format holds no text.
    force : bool
        Replace a file that exists.

    Raises
    ------
    ParameterError
        where the format cannot hold the picture, or the file exists.
    InputError, ResourceError
        where the folder does not exist, cannot be written, or is full. An existing file is then untouched.
    """
    expect_path(path)
    expect(recipe, (str, NoneType), "recipe", "JSON, as text")
    if isinstance(picture, Mapping):
        _write_layers(path, picture, depth, recipe, force)
        return
    plane = plane_of(picture)
    if depth is not None:
        plane = convert(plane, depth)
    if os.fspath(path) == "-":
        data = encode(plane, "exr" if plane.is_float else "png", recipe)
        write_bytes("-", data)
        return
    target = format_of(path)
    check_depth(path, plane)
    check_writable(path, force)
    beside = recipe_path(path)
    inside = recipe is not None and holds_recipe(target, recipe)
    if recipe is not None and not inside:
        check_writable(beside, force)
    files: list[tuple[PathLike, bytes]] = [(path, encode(plane, target.name, recipe))]
    if recipe is not None and not inside:
        files.append((beside, recipe.encode()))
    put_all(files, force)
    if force and (recipe is None or inside):
        with suppress(OSError):  # the recipe of what was here before
            os.unlink(beside)


def _write_layers(
    path: PathLike, pictures: Mapping[str, Any], depth: int | str | None, recipe: str | None, force: bool
) -> None:
    planes = {name: plane_of(picture) for name, picture in pictures.items()}
    check_layered(path, planes, depth)
    if depth is not None:
        planes = {name: convert(plane, depth) for name, plane in planes.items()}
    check_writable(path, force)
    put_all([(path, encode_layers(planes, recipe))], force)


def check_layered(path: PathLike, planes: Mapping[str, Plane], depth: int | str | None = None) -> None:
    """Refuse, before any work, planes that cannot be layers of one file."""
    text = printable(path)
    if os.path.splitext(path)[1].lower() != ".exr":
        raise ParameterError(f"{text}: layers are written as OpenEXR; end the name in .exr.")
    if not planes:
        raise ParameterError(f"{text}: no layer is given; name at least one plane.")
    check_layers(text, planes, None if depth is None else dtype_of(depth))


def check_depth(
    path: PathLike, picture: Any, depth: int | str | None = None, size: Pair | None = None
) -> None:  # fmt: skip
    """Refuse, before any work, a picture that the format of a file cannot hold, in that `size` (width, height)."""
    if os.fspath(path) == "-":
        return
    check_holds(format_of(path), plane_of(picture), None if depth is None else dtype_of(depth), size)


def plane_of(picture: Any) -> Plane:
    """Take a plane, anything that renders one, or an array."""
    if isinstance(picture, Plane):
        return picture
    if hasattr(picture, "render") and not isinstance(picture, type):
        return plane_of(picture.render())
    if picture is None or isinstance(picture, (type, str)):
        raise InputError(f"what is to be written is {called(picture)}; give a Plane, a Synthesis or an array.")
    array = pixels_of(picture)
    return Plane(array, Kind.LABEL if array.dtype.name in ("bool", "uint32") else Kind.COLOUR)


def convert(plane: Plane, depth: int | str) -> Plane:
    """Return a plane in another depth; colour keeps its look, so linear floats gain or lose the sRGB curve.

    Whole numbers clip to 0..1, NaN becomes 0. Labels keep their numbers, and are refused where these do not fit.
    """
    dtype = np.dtype(dtype_of(depth))
    if plane.pixels.dtype == dtype:
        return plane
    pixels = converted(plane.pixels, plane.kind, plane.transfer is Transfer.LINEAR, dtype)
    if plane.kind is Kind.LABEL or plane.is_float == (dtype.kind == "f"):
        return Plane(pixels, plane.kind, plane.transfer, plane.meta)
    about = {k: v for k, v in plane.meta.items() if k != "icc"}  # a colour profile describes the old curve
    return Plane(pixels, plane.kind, Transfer.SRGB if plane.is_float else Transfer.LINEAR, about)


def preview(plane: Plane) -> Plane:
    """Return a picture of 8 bits to look at: floats clipped, heights stretched to their range, labels in colours."""
    return Plane(looked_at(plane.pixels, plane.kind, plane.transfer is Transfer.LINEAR))


LONGEST = 1 << 24


def recipe_path(path: PathLike) -> Path:
    """Return where the recipe of a file lies if its format holds no text: ``out.bmp.recipe.json``."""
    return Path(os.fspath(path) + ".recipe.json")


def read_recipe(path: PathLike) -> dict[str, Any] | None:
    """Find the recipe that a picture was made by; None where it has none.

    The file may be the picture, or a recipe saved as .json. Raises InputError where it cannot be read.
    """
    if os.fspath(path).lower().endswith(".json"):
        return _from_file(Path(path))
    text = _description(look(path))
    start = text.find(MARK)
    if start >= 0:
        return _parse(text[start + len(MARK) :], printable(path))
    beside = recipe_path(path)
    return _from_file(beside) if os.path.isfile(beside) else None


def _from_file(path: Path) -> dict[str, Any]:
    name = printable(path)
    if not os.path.isfile(path):
        raise InputError(f"{name} does not exist, or is no ordinary file; name a recipe.")
    try:
        with path.open("rb") as file:
            return _parse(file.read(LONGEST).decode("utf-8"), name)
    except (OSError, UnicodeDecodeError) as e:
        raise InputError(f"{name} cannot be read as a recipe ({type(e).__name__}); save it again.") from None


def _parse(text: str, name: str) -> dict[str, Any]:
    try:
        found = json.JSONDecoder().raw_decode(text)[0]
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise InputError(f"the recipe of {name} is damaged; save it again.")
    return found


def _description(picture: PictureFile) -> str:
    """Return the texts that a file holds, joined."""
    try:
        if picture.format == "png":
            return "\n".join(png.png(picture.data(), picture.name).texts.values())
        if picture.format in ("jpeg", "webp"):
            return _text_by_pillow(picture)
        if picture.format in ("tiff", "exr"):
            with opened(picture) as (file, _):
                return str(file.spec().get_string_attribute("ImageDescription"))
    except InputError:
        raise
    except Exception as e:  # a damaged file can fail in any way
        raise damaged(picture.name, str(e) or type(e).__name__) from None
    return ""


def _text_by_pillow(picture: PictureFile) -> str:
    from PIL import Image

    with pillow_opened(picture.format, picture.data()) as image:
        if picture.format == "jpeg":
            return bytes(image.info.get("comment", b"")).decode("utf-8", "replace")
        facts = Image.Exif()
        facts.load(image.info.get("exif", b""))
        return str(facts.get(0x010E, ""))
