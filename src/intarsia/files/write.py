"""Encoding and atomic writing of picture files with an embedded recipe; recipes read back from files.

Equal pixels and recipes give equal bytes. Also: text rendered as pixels.
"""

from __future__ import annotations

import io
import json
import os
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np

from ..disk import MAX_CHANNELS
from ..disk.atomic import PathLike, check_writable, replace_files, working_folder, write_bytes
from ..foundation import InputError, ParameterError, ResourceError, called, expect, expect_path, printable
from ..foundation.arrays import Array, Pair, pixels_of
from ..foundation.run import Run
from ..model.image import Kind, Plane, Transfer, converted, dtype_of, to_display
from . import png
from .decode import opened, pillow_opened
from .formats import FORMATS, SUFFIXES, Format, PictureFile, channel_names, damaged_error, format_of, open_picture

Depth = int | str | None
"""8, 16, "half" or "float"; None: as it is."""

MARK = "intarsia recipe: "
"""Prefix of an embedded recipe."""

RECIPE = ".recipe.json"
"""Suffix of the file that holds the recipe of a picture."""

MAX_EMBEDDED = {"jpeg": 60000, "tiff": 60000, "webp": 1 << 20}
"""Format -> most bytes of an embedded recipe; longer ones lie beside. OpenImageIO reads no more of a TIFF."""

_WORDS = {
    "uint8": "8 bit", "uint16": "16 bit", "uint32": "32 bit", "float16": "half", "float32": "float", "float64": "double"
}


def encode(plane: Plane, fmt: str, recipe: str | None = None, run: Run | None = None) -> bytes:
    """Return the bytes of a picture file, such as ``encode(plane, "png")``; the threads of `run` share a PNG.

    Raises ParameterError where the format cannot hold the plane, ResourceError where the temporary folder is full.
    """
    target = SUFFIXES.get("." + fmt.lower().lstrip("."))
    if target is None:
        raise ParameterError(f"{fmt} is no format; choose one of {', '.join(SUFFIXES)}.")
    check_holds(target, plane)
    pixels = np.ascontiguousarray(plane.samples * np.uint8(255) if plane.pixels.dtype == bool else plane.samples)
    text = _text(target, recipe)
    icc = plane.meta.get("icc") if target.icc else None
    if target.name == "png":
        return png.encode_png(pixels, icc, text, run=run)
    if target.name in ("jpeg", "webp", "tga", "bmp"):
        return _bytes_by_pillow(target.name, pixels, text, icc)
    return _bytes_by_oiio(target.name, pixels, text, icc)


def holds_recipe(target: Format, recipe: str) -> bool:
    """Return whether a recipe fits into a file of this format."""
    return target.text and len(recipe.encode()) <= MAX_EMBEDDED.get(target.name, 1 << 22)


def check_holds(target: Format, plane: Plane, depth: Depth = None, size: Pair | None = None) -> None:
    """Raise ParameterError if a format cannot hold a plane, in another depth or `size` (width, height) if given."""
    name, dtype = target.name, _dtype(plane, depth)
    dtype = "uint8" if dtype == "bool" else dtype
    choices = [f.suffixes[0] for f in FORMATS if dtype in f.dtypes and plane.channels in f.channels]
    if dtype not in target.dtypes:
        remedy = f"write {_any_of(choices)}, or ask" if choices else "ask"
        other = "float" if "float32" in target.dtypes else "16" if "uint16" in target.dtypes else "8"
        held = _any_of([_WORDS[d] for d in target.dtypes])
        raise ParameterError(f"{name} holds {held}, not {_WORDS[dtype]}; {remedy} for --depth {other}.")
    if plane.channels not in target.channels:
        alpha = " (alpha among them)" if plane.alpha else ""
        many = f"1 to {MAX_CHANNELS}" if len(target.channels) > 4 else _any_of([str(c) for c in target.channels])
        raise ParameterError(f"{name} holds {many} channels, not {plane.channels}{alpha}; write {_any_of(choices)}.")
    width, height = size or (plane.width, plane.height)
    if max(width, height) > target.side:
        raise ParameterError(
            f"{name} holds at most {target.side} px a side, not {width}x{height}; write .tif, .exr or .pfm."
        )
    if dtype == "uint32" and name == "exr" and plane.kind is not Kind.LABEL:
        raise ParameterError("exr holds 32-bit whole numbers as labels only; ask for --depth float.")


def _any_of(words: list[str]) -> str:
    *others, last = words[:4]
    return f"{', '.join(others)} or {last}" if others else last


def _dtype(plane: Plane, depth: Depth) -> str:
    return plane.pixels.dtype.name if depth is None else dtype_of(depth)


def _text(target: Format, recipe: str | None) -> str | None:
    """Return the text that embeds a recipe; None if it does not fit."""
    return MARK + recipe if recipe is not None and holds_recipe(target, recipe) else None


def _bytes_by_pillow(name: str, pixels: Array, text: str | None, icc: bytes | None) -> bytes:
    from PIL import Image

    buffer = io.BytesIO()
    image = Image.fromarray(pixels[:, :, 0] if pixels.shape[2] == 1 else pixels)
    options: dict[str, Any] = {}
    if name == "jpeg":
        options = {"quality": 95, "subsampling": 0}
        if text is not None:
            options["comment"] = text.encode()
    if name == "webp":
        options = {"lossless": True, "exact": True, "quality": 80, "method": 4}
        if text is not None:
            facts = Image.Exif()
            facts[0x010E] = text
            options["exif"] = facts.tobytes()
    if icc:
        options["icc_profile"] = icc
    try:
        image.save(buffer, name, **options)
    except OSError as e:
        raise ResourceError(f"the {name} could not be made ({e}); write .png instead.") from None
    return buffer.getvalue()


_OIIO = {"float16": "half", "float32": "float", "float64": "double", "uint32": "uint"}


def _bytes_by_oiio(
    name: str, pixels: Array, text: str | None, icc: bytes | None, layers: tuple[list[str], list[str]] | None = None
) -> bytes:
    """Encode pixels (H, W, C); `layers` are the names and types of channels of several planes."""
    import OpenImageIO as oiio

    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, _OIIO.get(pixels.dtype.name, pixels.dtype.name))
    spec.attribute("oiio:UnassociatedAlpha", 1)  # pixels are stored as they are
    spec.attribute("DateTime", "")  # equal pixels, equal bytes
    if name in ("tiff", "exr"):
        spec.attribute("compression", "zip")
    if name == "exr":
        spec.channelnames = tuple(channel_names(channels))
    if layers is not None:
        spec.channelnames, spec.channelformats = tuple(layers[0]), tuple(map(oiio.TypeDesc, layers[1]))
    if text is not None:
        spec.attribute("ImageDescription", text)
    if icc:
        spec.attribute("ICCProfile", oiio.TypeDesc(f"uint8[{len(icc)}]"), np.frombuffer(icc, np.uint8))
    with working_folder() as folder:
        path = os.path.join(folder, "picture." + {"tiff": "tif"}.get(name, name))
        file = oiio.ImageOutput.create(path)
        done = file is not None and file.open(path, spec) and file.write_image(pixels)
        error = oiio.geterror() if file is None else file.geterror()
        done = file is not None and file.close() and done
        if not done:
            reason = " ".join(error.replace(path, "file").split())[:160]
            room = f"make room in {tempfile.gettempdir()}, or write another format"
            raise ResourceError(f"the {name} could not be made ({reason}); {room}.")
        with open(path, "rb") as made:
            return made.read()


def write(
    path: PathLike, picture: Any, *, depth: Depth = None, recipe: str | None = None, force: bool = False,
    run: Run | None = None,
) -> None:  # fmt: skip
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
    run : Run, optional
        Whose threads share the packing of a PNG; by default one for each core. Never changes a byte.

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
    plane = convert(plane_of(picture), depth)
    if os.fspath(path) == "-":
        write_bytes("-", encode(plane, "exr" if plane.is_float else "png", recipe, run))
        return
    target, beside = format_of(path), recipe_path(path)
    check_holds(target, plane)
    aside = () if recipe is None or holds_recipe(target, recipe) else ((beside, recipe.encode()),)
    for place in (path, *(place for place, _ in aside)):
        check_writable(place, force)
    replace_files([(path, encode(plane, target.name, recipe, run)), *aside], force)
    if force and not aside:
        with suppress(OSError):  # the recipe of what was here before
            os.unlink(beside)


def _write_layers(
    path: PathLike, pictures: Mapping[str, Any], depth: Depth, recipe: str | None, force: bool
) -> None:
    """Write planes as layers of an EXR file."""
    planes = {name: plane_of(picture) for name, picture in pictures.items()}
    check_layered(path, planes, depth)
    check_writable(path, force)
    made = {name: convert(plane, depth) for name, plane in planes.items()}
    own = {n: "XYZ" if p.kind is Kind.NORMAL else channel_names(p.channels) for n, p in made.items()}
    names = [f"{name}.{letter}" for name, letters in own.items() for letter in letters]
    types = [_OIIO[p.pixels.dtype.name] for p in made.values() for _ in range(p.channels)]
    pixels = np.concatenate([p.samples.astype(np.float32, copy=False) for p in made.values()], axis=2)
    text = _text(SUFFIXES[".exr"], recipe)
    replace_files([(path, _bytes_by_oiio("exr", pixels, text, None, (names, types)))], force)


def check_layered(path: PathLike, planes: Mapping[str, Plane], depth: Depth = None) -> None:
    """Raise ParameterError if planes cannot be layers of one file, in another `depth` if one is given."""
    text = printable(path)
    if os.path.splitext(path)[1].lower() != ".exr":
        raise ParameterError(f"{text}: layers are written as OpenEXR; end the name in .exr.")
    if not planes:
        raise ParameterError(f"{text}: no layer is given; name at least one plane.")
    base = next(iter(planes.values()))
    for name, plane in planes.items():
        if (plane.height, plane.width) != (base.height, base.width):
            size, other = f"{plane.width}x{plane.height} px", f"{base.width}x{base.height}"
            raise ParameterError(f"{text}: the layer {name} would have {size}, the first {other}; write files.")
        held = _dtype(plane, depth)
        if held not in ("float16", "float32"):
            raise ParameterError(
                f"{text}: layers hold half or float, not {_WORDS.get(held, held)} as the {name}; ask for --depth half."
            )


def check_depth(
    path: PathLike, picture: Any, depth: Depth = None, size: Pair | None = None
) -> None:  # fmt: skip
    """Raise ParameterError if the format of a file cannot hold a picture, in this `size` (width, height) if given."""
    if os.fspath(path) != "-":
        check_holds(format_of(path), plane_of(picture), depth, size)


def plane_of(picture: Any) -> Plane:
    """Return a plane, of anything that renders one, or of an array."""
    if isinstance(picture, Plane):
        return picture
    if hasattr(picture, "render") and not isinstance(picture, type):
        return plane_of(picture.render())
    if picture is None or isinstance(picture, (type, str)):
        raise InputError(f"what is to be written is {called(picture)}; give a Plane, a Synthesis or an array.")
    array = pixels_of(picture)
    return Plane(array, Kind.LABEL if array.dtype.name in ("bool", "uint32") else Kind.COLOUR)


def convert(plane: Plane, depth: Depth) -> Plane:
    """Return a plane in another depth; colour keeps its look, so linear floats gain or lose the sRGB curve.

    Whole numbers clip to 0..1, NaN becomes 0. Labels keep their numbers, and are refused where these do not fit.
    """
    if depth is None or plane.pixels.dtype == (dtype := np.dtype(dtype_of(depth))):
        return plane
    pixels = converted(plane.pixels, plane.kind, plane.transfer is Transfer.LINEAR, dtype)
    if plane.kind is Kind.LABEL or plane.is_float == (dtype.kind == "f"):
        return Plane(pixels, plane.kind, plane.transfer, plane.meta)
    about = {k: v for k, v in plane.meta.items() if k != "icc"}  # a colour profile describes the old curve
    return Plane(pixels, plane.kind, Transfer.SRGB if plane.is_float else Transfer.LINEAR, about)


def preview(plane: Plane) -> Plane:
    """Return a picture of 8 bits to look at: floats clipped, heights stretched to their range, labels in colours."""
    return Plane(to_display(plane.pixels, plane.kind, plane.transfer is Transfer.LINEAR))


MOST = 1 << 24  # bytes of a recipe that is read


def recipe_path(path: PathLike) -> Path:
    """Return the path of the recipe of a file whose format holds no text: ``out.bmp.recipe.json``."""
    return Path(os.fspath(path) + RECIPE)


def read_recipe(path: PathLike) -> dict[str, Any] | None:
    """Return the recipe of a picture; None if it has none.

    The file may be the picture, or a recipe saved as .json. Raises InputError if it cannot be read.
    """
    if os.fspath(path).lower().endswith(".json"):
        return _from_file(Path(path))
    _, mark, text = _description(open_picture(path)).partition(MARK)
    if mark:
        return _parse(text, printable(path))
    beside = recipe_path(path)
    return _from_file(beside) if os.path.isfile(beside) else None


def tiles(path: PathLike) -> bool:
    """Return whether the recipe of a picture says that it continues across all its borders."""
    with suppress(InputError):
        return path != "-" and (read_recipe(path) or {}).get("wrap") == "both"
    return False


def _from_file(path: Path) -> dict[str, Any]:
    name = printable(path)
    if not os.path.isfile(path):
        raise InputError(f"{name} does not exist, or is no ordinary file; name a recipe.")
    try:
        with path.open("rb") as file:
            return _parse(file.read(MOST).decode("utf-8"), name)
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
        if picture.format in ("png", "jpeg", "webp"):
            with pillow_opened(picture.format, picture.data()) as image:
                if picture.format == "png":
                    return "\n".join(map(str, image.text.values()))
                if picture.format == "jpeg":
                    return bytes(image.info.get("comment", b"")).decode("utf-8", "replace")
                return str(image.getexif().get(0x010E, ""))
        if picture.format in ("tiff", "exr"):
            with opened(picture) as (file, _):
                return str(file.spec().get_string_attribute("ImageDescription"))
    except InputError:
        raise
    except Exception as e:  # a damaged file can fail in any way
        raise damaged_error(picture.name, str(e) or type(e).__name__) from None
    return ""
