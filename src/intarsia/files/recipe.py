"""The recipe of a picture, found again: inside the file, or beside it."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from ..errors import InputError, printable
from . import png
from .decode import opened
from .encode import MARK
from .source import PictureFile, damaged, look

LONGEST = 1 << 24


def recipe_path(path: str | os.PathLike[str]) -> Path:
    """Return where the recipe of a file lies if its format holds no text: ``out.bmp.recipe.json``."""
    return Path(os.fspath(path) + ".recipe.json")


def read_recipe(path: str | os.PathLike[str]) -> dict[str, Any] | None:
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
            return _text_by_oiio(picture)
    except InputError:
        raise
    except Exception as e:  # a damaged file can fail in any way
        raise damaged(picture.name, str(e) or type(e).__name__) from None
    return ""


def _text_by_pillow(picture: PictureFile) -> str:
    import io

    from PIL import Image, JpegImagePlugin, WebPImagePlugin

    if picture.format == "jpeg":
        with JpegImagePlugin.JpegImageFile(io.BytesIO(picture.data())) as image:
            return bytes(image.info.get("comment", b"")).decode("utf-8", "replace")
    with WebPImagePlugin.WebPImageFile(io.BytesIO(picture.data())) as image:
        facts = Image.Exif()
        facts.load(image.info.get("exif", b""))
        return str(facts.get(0x010E, ""))


def _text_by_oiio(picture: PictureFile) -> str:
    with opened(picture) as (file, _):
        return str(file.spec().get_string_attribute("ImageDescription"))
