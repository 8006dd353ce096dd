"""A plane becomes the bytes of a file; equal pixels and recipes give equal bytes. And short words become pixels."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import Array, Pair, UInt8
from ..disk.limits import MAX_CHANNELS
from ..disk.whole import working_folder
from ..errors import ParameterError, ResourceError, legible
from ..image import Kind, Plane
from .formats import FORMATS, SUFFIXES, Format, channel_names
from .png import PNG_END

MARK = "intarsia recipe: "
"""What an embedded recipe starts with."""

LONGEST = {"jpeg": 60000, "tiff": 60000, "webp": 1 << 20}
"""Longer recipes lie beside; a TIFF holds more, but OpenImageIO reads only so much of it."""

_WORDS = {
    "uint8": "8 bit", "uint16": "16 bit", "uint32": "32 bit", "float16": "half", "float32": "float", "float64": "double"
}


def encode(plane: Plane, fmt: str, recipe: str | None = None) -> bytes:
    """Return the bytes of a picture file, such as ``encode(plane, "png")``.

    Raises ParameterError where the format cannot hold the plane, ResourceError where the temporary folder is full.
    """
    known, word = {f.name: f for f in FORMATS}, fmt.lower().lstrip(".")
    target = known.get(word) or SUFFIXES.get(f".{word}")
    if target is None:
        raise ParameterError(f"{fmt} is no format; choose one of {', '.join(known)}.")
    check_holds(target, plane)
    bits = plane.pixels.dtype == bool
    pixels = np.ascontiguousarray(plane.samples * np.uint8(255) if bits else plane.samples)
    text = MARK + recipe if recipe is not None and holds_recipe(target, recipe) else None
    icc = plane.meta.get("icc") if target.icc else None
    if target.name in ("jpeg", "webp", "tga", "bmp"):
        return _bytes_by_pillow(target.name, pixels, text, icc)
    return _bytes_by_oiio(target.name, pixels, text, icc)


def holds_recipe(target: Format, recipe: str) -> bool:
    """Tell whether a recipe of this length finds room inside the file."""
    return target.text and len(recipe.encode()) <= LONGEST.get(target.name, 1 << 22)


def check_holds(target: Format, plane: Plane, dtype: str | None = None, size: Pair | None = None) -> None:
    """Refuse a plane that a format cannot hold, and say what to do; `size` (width, height) is that of the output."""
    name, dtype = target.name, dtype or plane.pixels.dtype.name
    dtype = "uint8" if dtype == "bool" else dtype
    if dtype not in target.dtypes:
        choices = [f.suffixes[0] for f in FORMATS if dtype in f.dtypes and plane.channels in f.channels]
        remedy = f"write {_any_of(choices)}, or ask" if choices else "ask"
        depth = "float" if "float32" in target.dtypes else "16" if "uint16" in target.dtypes else "8"
        raise ParameterError(f"{name} holds {target.depths}, not {_WORDS[dtype]}; {remedy} for --depth {depth}.")
    if plane.channels not in target.channels:
        choices = [f.suffixes[0] for f in FORMATS if plane.channels in f.channels and dtype in f.dtypes]
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
    words = words[:4]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"


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


def encode_layers(planes: Mapping[str, Plane], recipe: str | None = None) -> bytes:
    """Return the bytes of an EXR file whose layers are planes of one size, each half or float.

    Raises ParameterError where they cannot be.
    """
    check_layers("the file", planes)
    text = MARK + recipe if recipe is not None and holds_recipe(SUFFIXES[".exr"], recipe) else None
    own = {n: "XYZ" if p.kind is Kind.NORMAL else channel_names(p.channels) for n, p in planes.items()}
    names = [f"{name}.{letter}" for name, letters in own.items() for letter in letters]
    types = [_OIIO[p.pixels.dtype.name] for p in planes.values() for _ in range(p.channels)]
    pixels = np.concatenate([p.samples.astype(np.float32, copy=False) for p in planes.values()], axis=2)
    return _bytes_by_oiio("exr", pixels, text, None, (names, types))


def check_layers(path: str, planes: Mapping[str, Plane], dtype: str | None = None) -> None:
    """Refuse planes that cannot be layers of one file, in the pixels of type `dtype` where that is another."""
    base = next(iter(planes.values()))
    for name, plane in planes.items():
        if (plane.height, plane.width) != (base.height, base.width):
            size, other = f"{plane.width}x{plane.height} px", f"{base.width}x{base.height}"
            raise ParameterError(f"{path}: the layer {name} would have {size}, the first {other}; write files.")
        held = dtype or plane.pixels.dtype.name
        if held not in ("float16", "float32"):
            raise ParameterError(
                f"{path}: layers hold half or float, not {_WORDS.get(held, held)} as the {name}; ask for --depth half."
            )


def _bytes_by_oiio(
    name: str, pixels: Array, text: str | None, icc: bytes | None, layers: tuple[list[str], list[str]] | None = None
) -> bytes:
    """Encode pixels (H, W, C); `layers` are the names and types of channels, where these are several planes."""
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
            data = made.read()
    if name == "png" and not data.endswith(PNG_END):  # libpng tells nobody that the disk is full
        raise ResourceError(f"{tempfile.gettempdir()} is full; make room there, or set TMPDIR.")
    return data


def lettered(text: str, size: int) -> UInt8:
    """Return a line of text, letters about `size` px high, as coverage: (height, width), 255 where ink is."""
    from PIL import Image, ImageDraw, ImageFont

    font, line = ImageFont.load_default(size), legible(text).encode("latin-1", "replace").decode("latin-1")
    left, _, right, _ = (int(n) for n in font.getbbox(line))
    paper = Image.new("L", (max(right - min(left, 0), 1), size + size // 2))
    ImageDraw.Draw(paper).text((-min(left, 0), 0), line, fill=255, font=font)
    return np.array(paper)
