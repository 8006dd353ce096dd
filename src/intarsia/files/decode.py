"""Bytes become an array: OpenImageIO for pixels, Pillow where it alone can."""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InputError, ResourceError
from ..image import Array
from . import headers, netpbm
from .formats import check_size
from .source import Picture


@dataclass
class Decoded:
    """The pixels of a file as it stores them, upright, and its colour profile."""

    pixels: Array
    icc: bytes | None = None


def decode(picture: Picture) -> Decoded:
    """Read the pixels of a file exactly as stored, turned upright; everything that fails is an InputError."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            decoded = _by_format(picture)
    except (InputError, ResourceError):
        raise
    except MemoryError:
        raise ResourceError(f"{picture.name} does not fit into memory; crop it first.") from None
    except Exception as e:  # a damaged file can fail in any way
        raise headers.damaged(picture.name, str(e) or type(e).__name__) from None
    pixels = decoded.pixels
    if pixels.ndim == 3 and pixels.shape[2] == 1:
        pixels = pixels[:, :, 0]
    if pixels.dtype == bool:
        pixels = pixels.astype(np.uint8) * np.uint8(255)
    return Decoded(np.ascontiguousarray(pixels), _profile(decoded.icc, pixels))


def _by_format(picture: Picture) -> Decoded:
    if picture.format == "pnm":
        return Decoded(netpbm.decode(picture.data(), picture.name))
    if picture.format == "png":
        return _png(picture)
    if picture.format in ("jpeg", "gif", "webp"):
        return _pillow(picture, picture.data())
    if picture.format == "exr":
        headers.exr(picture.head(), picture.name)
    return _oiio(picture)


def _png(picture: Picture) -> Decoded:
    data = picture.data()
    facts = headers.png(data, picture.name)
    # Texts and profiles are taken out first: libpng would complain of broken ones on the terminal.
    found = _pillow(picture, facts.clean or data) if facts.palette else _oiio(picture, facts.clean)
    found.icc = facts.icc
    if facts.exif:
        found.pixels = upright(found.pixels, _exif_orientation(facts.exif))
    return found


def _pillow(picture: Picture, data: bytes) -> Decoded:
    # The classes of the formats, not Image.open: nothing else is ever tried.
    from PIL import GifImagePlugin, JpegImagePlugin, PngImagePlugin, WebPImagePlugin

    if picture.format == "jpeg":
        headers.jpeg(data, picture.name)
    kinds: dict[str, Any] = {
        "png": PngImagePlugin.PngImageFile,
        "jpeg": JpegImagePlugin.JpegImageFile,
        "gif": GifImagePlugin.GifImageFile,
        "webp": WebPImagePlugin.WebPImageFile,
    }
    with kinds[picture.format](io.BytesIO(data)) as image:
        check_size(picture.name, *image.size)
        image.load()
        icc = image.info.get("icc_profile")
        exif = image.info.get("exif") if picture.format != "gif" else None
        if image.mode == "CMYK":
            icc = None  # it describes the inks, which are gone
        if image.mode not in ("L", "LA", "RGB", "RGBA"):
            image = image.convert("RGBA" if "transparency" in image.info else "RGB")
        elif "transparency" in image.info and image.mode in ("L", "RGB"):
            image = image.convert(image.mode + "A")
        pixels = np.array(image)
    return Decoded(upright(pixels, _exif_orientation(exif) if exif else 1), icc)


def _oiio(picture: Picture, data: bytes | None = None) -> Decoded:
    import OpenImageIO as oiio

    with picture.plain_path(data) as path:
        hints = oiio.ImageSpec()
        hints.attribute("oiio:UnassociatedAlpha", 1)  # without it colours would be multiplied by alpha
        file = oiio.ImageInput.open(path, hints)
        if file is None:
            raise headers.damaged(picture.name, oiio.geterror().replace(path, "file"))
        try:
            spec = file.spec()
            first, stop, chosen, dtype = _layout(picture, spec)
            pixels = file.read_image(0, 0, first, stop, dtype)
            error = file.geterror()
        finally:
            file.close()
    if pixels is None or error:
        raise headers.damaged(picture.name, error.replace(path, "file") or "no pixels came")
    pixels = np.asarray(pixels)
    if chosen != list(range(pixels.shape[2])):
        pixels = pixels[:, :, chosen]
    profile = spec.getattribute("ICCProfile")
    icc = None if profile is None else np.asarray(profile, np.uint8).tobytes()
    return Decoded(upright(pixels, spec.get_int_attribute("Orientation", 1)), icc)


def _layout(picture: Picture, spec: Any) -> tuple[int, int, list[int], str]:
    """Choose what to read of a file: first and last channel, which of these, and as which type."""
    name = picture.name
    if spec.deep or spec.depth > 1:
        raise InputError(f"{name} holds deep or volume data; save a flat picture.")
    names = [str(n) for n in spec.channelnames]
    chosen = _layer(names) if picture.format == "exr" else list(range(len(names)))
    check_size(name, spec.width, spec.height, len(chosen))
    formats = {str(spec.channelformat(c)) for c in chosen}
    if len(formats) > 1:
        formats = {"uint"} if "uint" in formats else {"float"}
        if "uint" in formats:
            raise InputError(f"{name} mixes whole numbers and floats in one layer; save them as separate files.")
    dtype = formats.pop()
    if dtype not in ("uint8", "uint16", "uint", "uint32", "half", "float", "double"):
        raise InputError(f"{name} holds {dtype} pixels; save it with 8 or 16 bit, half or float.")
    first = min(chosen)
    return first, max(chosen) + 1, [c - first for c in chosen], dtype


def _layer(names: list[str]) -> list[int]:
    """Choose one layer of an EXR: RGB(A), else Y(A), else the first named layer, else all channels."""
    index = {n.upper(): i for i, n in reversed(list(enumerate(names)))}
    prefixes = dict.fromkeys([""] + [n.rpartition(".")[0] + "." for n in index if "." in n])
    for prefix in prefixes:
        for wanted in ("RGBA", "RGB", "YA", "Y", "XYZ"):
            keys = [prefix + letter for letter in wanted]
            if all(k in index for k in keys):
                return [index[k] for k in keys]
    layers = {n.rpartition(".")[0] for n in names}
    if len(layers) > 1:
        first = names[0].rpartition(".")[0]
        return [i for i, n in enumerate(names) if n.rpartition(".")[0] == first]
    return list(range(len(names)))


def upright(pixels: Array, orientation: int) -> Array:
    """Apply an EXIF orientation, 1 to 8; anything else is taken as upright."""
    if orientation in (5, 6, 7, 8):
        pixels = np.swapaxes(pixels, 0, 1)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    return pixels


def _exif_orientation(exif: bytes) -> int:
    if b"\x01\x12" not in exif and b"\x12\x01" not in exif:  # the tag, in either order of bytes
        return 1
    from PIL import Image

    facts = Image.Exif()
    try:
        facts.load(exif)
        return int(facts.get(0x0112, 1))
    except Exception:  # broken EXIF: the picture is as it lies
        return 1


def _profile(icc: bytes | None, pixels: Array) -> bytes | None:
    """Keep a colour profile that is one, and that belongs to this number of channels."""
    if not icc or len(icc) < 132 or icc[36:40] != b"acsp" or int.from_bytes(icc[:4], "big") > len(icc):
        return None
    channels = 1 if pixels.ndim == 2 else pixels.shape[2]
    return icc if icc[16:20] == (b"GRAY" if channels <= 2 else b"RGB ") else None
