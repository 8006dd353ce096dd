"""Decoding of picture files into arrays, by OpenImageIO, and by Pillow for PNG, JPEG and GIF.

Pillow decodes straight into the memory of an array; conversions are made band by band.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from ..disk import check_decoding_cost, check_size, most_pixels, no_room
from ..foundation import InputError, IntarsiaError
from ..foundation.arrays import Array
from . import png
from .formats import PNG_SIDE, PictureFile, channels_in, damaged_error

READ = 1 << 24
"""Bytes that are read of a file at a time, at least."""

COSTS = {"exr": 1.5, "tiff": 1.5, "hdr": 1.5, "tga": 2.0}
"""Format -> cost of decoding in time and memory, as a multiple of the memory of the pixels, if it is more than 1."""

DTYPES = {"uint8": 1, "uint16": 2, "uint": 4, "uint32": 4, "half": 2, "float": 4, "double": 8}
"""OpenImageIO's names of the pixel types that are read -> bytes."""

MOST_SCANS = 500
"""Most scans of a progressive JPEG; each of them goes over the whole picture again."""

WEBP_BYTES_PER_PIXEL = 10
"""Bytes per pixel that libwebp takes to decode."""

SCANS = 16
"""Most scans of a JPEG of the largest size that is allowed; smaller ones may have more."""

_SIDES = 2 * rb"(?:\s|#[^\n]*\n)+\d+" + rb"(?:\s|#[^\n]*\n)+"
PNM = re.compile(rb"(?:P[56]" + _SIDES + rb"(?:255|65535)|P[Ff]" + _SIDES + rb"-?1(?:\.0*)?)[ \t\n]")
"""Headers of netpbm pictures that OpenImageIO reads rightly: it rounds other maxima down, and multiplies by a scale."""

BAND = 1 << 20
"""Pixels that are converted at a time."""

_STORED = {"L": 1, "P": 1, "LA": 4, "RGB": 4, "RGBA": 4, "CMYK": 4, "I;16": 2}
"""Mode -> bytes that Pillow stores a pixel in."""

DEEP = {"RGB;16B": ("RGB;16B", "RGB;16L"), "RGBA;16B": ("RGBA;16B", "RGBA;16L"), "LA;16B": ("RGBA",)}
"""How Pillow unpacks 16-bit colours of a PNG -> ways that keep all their bytes: high and low ones, or both at once."""

_DENSE = ("L", "RGBA")
"""Modes whose memory layout is that of an array."""


@dataclass
class Decoded:
    """The pixels of a file, upright, and its colour profile."""

    pixels: Array
    icc: bytes | None = None


def decode(picture: PictureFile, layer: str | None = None) -> Decoded:
    """Return the pixels of a file exactly as stored, turned upright; InputError for whatever fails.

    Of an EXR `layer` may be read, by default one that looks like a picture. Nobody else can write to the pixels.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            decoded = _by_format(picture, layer)
    except IntarsiaError:
        raise
    except MemoryError:
        raise no_room(picture.name) from None
    except Exception as e:  # a damaged file can fail in any way
        raise damaged_error(picture.name, str(e) or type(e).__name__) from None
    pixels = decoded.pixels
    if pixels.ndim == 3 and pixels.shape[2] == 1:
        pixels = pixels[:, :, 0]
    pixels = np.ascontiguousarray(pixels)
    for array in (pixels, pixels.base):
        if isinstance(array, np.ndarray):
            array.flags.writeable = False
    return Decoded(pixels, _profile(decoded.icc, pixels))


def _by_format(picture: PictureFile, layer: str | None) -> Decoded:
    if layer is not None and picture.format != "exr":
        raise InputError(f"{picture.name}: only EXR files have layers, and this is {picture.format}.")
    if picture.format == "pnm" and not PNM.match(picture.head):
        raise InputError(
            f"{picture.name} is a netpbm picture that is not read: plain text, bits, a maximum other than 255 and "
            "65535, a scale other than 1, or a header that is damaged; save it as PNG."
        )
    if picture.format == "png":
        return _png(picture)
    if picture.format in ("jpeg", "gif"):
        return _by_pillow(picture, picture.data())
    if picture.format == "webp":
        _check_webp(picture)
    return _by_oiio(picture, layer)


def _png(picture: PictureFile) -> Decoded:
    """Decode a PNG; a colour that stands for transparency becomes an alpha."""
    data = picture.data()
    packed = png.check_chunks(data, picture.name)
    with pillow_opened("png", data) as image:
        (width, height), packing, info = image.size, image.tile[0].args, image.info
        check_size(picture.name, width, height, side=PNG_SIDE)
        clear = None if image.mode == "P" else info.pop("transparency", None)
        cost = 4 + 12 * (packing in DEEP) + 8 * (clear is not None)
        check_decoding_cost(picture.name, cost * width * height, len(data))
        pixels = _deep(data, packing) if packing in DEEP else _loaded(image)
        if image.mode == "P" or "interlace" in info or not pixels[-1].any():  # else nothing is missing
            png.check_whole(data[16:29], packed, picture.name)
    if clear is not None:
        key = np.multiply(clear, {"1": 255, "L;2": 85, "L;4": 17}.get(packing, 1))
        opaque = (np.atleast_3d(pixels) != key).any(axis=2)
        pixels = np.dstack([pixels, opaque * pixels.dtype.type(np.iinfo(pixels.dtype).max)])
    return Decoded(upright(pixels, _exif_orientation(info.get("exif"))), info.get("icc_profile"))


def _deep(data: bytes, packing: str) -> Array:
    """Decode a PNG of 16-bit colours, of which Pillow keeps one byte at a time."""
    parts = []
    for way in DEEP[packing]:
        with pillow_opened("png", data) as image:
            image.tile = [image.tile[0]._replace(args=way)]
            image.info.pop("transparency", None)
            parts.append(_loaded(image))
    return parts[0].view(">u2").astype(np.uint16) if len(parts) == 1 else parts[0].astype(np.uint16) << 8 | parts[1]


def pillow_opened(format: str, data: bytes) -> Any:
    """Open a picture by Pillow's plugin of its format, which alone is imported; unlike Image.open it tries no other."""
    name = {"webp": "WebP"}.get(format, format.capitalize())
    return getattr(import_module(f"PIL.{name}ImagePlugin"), f"{name}ImageFile")(io.BytesIO(data))


def _by_pillow(picture: PictureFile, data: bytes) -> Decoded:
    from PIL import Image

    try:
        with pillow_opened(picture.format, data) as image:
            check_size(picture.name, *image.size)
            if picture.format == "jpeg":
                _check_jpeg(image, data, picture.name)
            inks = image.mode == "CMYK"
            pixels = _loaded(image)
            icc = None if inks else image.info.get("icc_profile")  # it describes the inks, which are gone
            exif = image.info.get("exif") if picture.format != "gif" else None
    except Image.DecompressionBombError:
        most = 2 * (Image.MAX_IMAGE_PIXELS or 0)
        raise InputError(f"{picture.name} has more pixels than Pillow reads ({most}); save it as TIFF.") from None
    return Decoded(upright(pixels, _exif_orientation(exif)), icc)


def _check_jpeg(image: Any, data: bytes, name: str) -> None:
    """Raise InputError if a JPEG that Pillow has opened costs too much to decode, or has no end.

    More scans than any encoder makes are refused: each takes time however few bytes it has.
    """
    start = image.fp.tell()  # behind the header of the first scan
    if data.rfind(b"\xff\xd9") < start:
        raise damaged_error(name, "it has no end")
    pixels, scans = image.size[0] * image.size[1], 1 + data.count(b"\xff\xda", start)
    sizes = [max(h, 1) * max(v, 1) for _, h, v, _ in image.layer]  # of channels: 3 samples a px, 1.5 where 4:2:0
    kept = "progressive" in image.info or scans > 1  # then all coefficients are, 16 bit each
    check_decoding_cost(name, pixels * (4 + 2 * kept * sum(sizes) / max(sizes)), len(data))
    most = min(MOST_SCANS, max(SCANS, SCANS * most_pixels() // max(pixels, 1)))
    if scans > most:
        raise InputError(
            f"{name} is a JPEG of {scans} scans; at most {most} are read at its size; save it anew, not progressive."
        )


def _check_webp(picture: PictureFile) -> None:
    """Raise InputError if a WebP is too large or costs too much, by its header (RFC 9649).

    Decoders allocate two pictures of its size when they open one, so it is checked before.
    """
    kind, body = picture.head[12:16], picture.head[20:30]
    if len(body) < 10 or kind not in (b"VP8X", b"VP8L", b"VP8 "):
        raise damaged_error(picture.name, "it has no header")
    if kind == b"VP8X":
        width, height = (1 + int.from_bytes(body[k : k + 3], "little") for k in (4, 7))
    elif kind == b"VP8L":
        bits = int.from_bytes(body[1:5], "little")
        width, height = (1 + (bits >> k & 0x3FFF) for k in (0, 14))
    else:
        width, height = (int.from_bytes(body[k : k + 2], "little") & 0x3FFF for k in (6, 8))
    check_size(picture.name, width, height)
    check_decoding_cost(picture.name, WEBP_BYTES_PER_PIXEL * width * height, picture.size)


def _loaded(image: Any) -> Array:
    """Return the pixels of an image that Pillow has opened, but not loaded: (H, W, C) of 8 bit, or (H, W) of 16.

    Palettes become colours, with opacity where they have some, CMYK becomes RGB, and a colour that stands for
    transparency an alpha. Only the returned array stays in memory.
    """
    from PIL import Image

    core: Any = Image.core  # type: ignore[attr-defined]
    (width, height), mode = image.size, image.mode
    held: Array | None = None
    if mode in _STORED and image.format != "GIF":  # which fills its memory by itself
        held = np.zeros((height, width, _STORED[mode]), np.uint8)
        image.im = core.map_buffer(held, image.size, "raw", 0, (mode, width * held.shape[2], 1))
    image.load()
    wanted = _full_mode(image)
    if held is not None and mode == wanted and mode in _DENSE:
        return held
    if held is not None and mode == "I;16":
        return held.view("<u2").reshape(height, width)
    channels = len(wanted)
    if held is not None and channels <= held.shape[2]:  # a band never reaches pixels that are still to come
        out = held.reshape(-1)[: height * width * channels].reshape(height, width, channels)
    else:
        out = np.empty((height, width, channels), np.uint8)
    rows = max(1, BAND // width)
    for top in range(0, height, rows):
        part = image.crop((0, top, width, min(top + rows, height)))
        part = part if part.mode == wanted else part.convert(wanted)
        out[top : top + rows] = np.frombuffer(part.tobytes(), np.uint8).reshape(-1, width, channels)
    return out


def _full_mode(image: Any) -> str:
    """Return the mode that holds all channels of an image, a letter for each."""
    mode, clear = str(image.mode), "transparency" in image.info
    if mode in ("1", "L", "RGB"):
        return {"1": "L"}.get(mode, mode) + "A" * clear
    return mode if mode in ("LA", "RGBA", "I;16") else "RGBA" if clear else "RGB"


@contextmanager
def opened(picture: PictureFile) -> Iterator[tuple[Any, str]]:
    """Open a picture by OpenImageIO; yield it and its path, which error messages contain."""
    import OpenImageIO as oiio

    with picture.plain_path() as path:
        hints = oiio.ImageSpec()
        hints.attribute("oiio:UnassociatedAlpha", 1)  # without it colours would be multiplied by alpha
        hints.attribute("pnm:pfmflip", 1)  # a PFM is stored bottom up
        file = oiio.ImageInput.open(path, hints)
        if file is None:
            raise damaged_error(picture.name, oiio.geterror().replace(path, "file"))
        try:
            yield file, path
        finally:
            file.close()


def _by_oiio(picture: PictureFile, layer: str | None = None) -> Decoded:
    with opened(picture) as (file, path):
        spec = file.spec()
        first, stop, chosen, dtype = _what_to_read(picture, spec, layer)
        pixels = _bands(file, spec, first, stop, dtype)
        error = file.geterror()
    if pixels is None or error:
        raise damaged_error(picture.name, error.replace(path, "file") or "no pixels came")
    if chosen != list(range(pixels.shape[2])):
        pixels = pixels[:, :, chosen]
    profile = spec.getattribute("ICCProfile")
    icc = None if profile is None else np.asarray(profile, np.uint8).tobytes()
    return Decoded(upright(pixels, spec.get_int_attribute("Orientation", 1)), icc)


def _bands(file: Any, spec: Any, first: int, stop: int, dtype: str) -> Array | None:
    """Read pixels band by band, as a whole picture at once takes its memory twice; None if pixels are missing."""
    width, height, channels = spec.width, spec.height, stop - first
    if spec.tile_width or width * height * channels * 8 <= READ:
        found = file.read_image(0, 0, first, stop, dtype)
        return None if found is None else np.asarray(found).reshape(height, width, channels)
    out: Array | None = None
    rows = -(-READ // (width * channels)) + 255 & ~255
    for y in range(spec.y, spec.y + height, rows):
        band = file.read_scanlines(y, min(y + rows, spec.y + height), 0, first, stop, dtype)
        if band is None:
            return None
        if out is None:
            out = np.empty((height, width, channels), band.dtype)
        out[y - spec.y : y - spec.y + rows] = band.reshape(-1, width, channels)
    return out


def _what_to_read(picture: PictureFile, spec: Any, layer: str | None) -> tuple[int, int, list[int], str]:
    """Return what to read of a file: first channel, end of channels, which of these, and as which type."""
    name = picture.name
    if spec.deep or spec.depth > 1:
        raise InputError(f"{name} holds deep or volume data; save a flat picture.")
    names = [str(n) for n in spec.channelnames]
    chosen = _exr_layer(names) if picture.format == "exr" else list(range(len(names)))
    if layer is not None:
        chosen = channels_in(names, layer, name)
    check_size(name, spec.width, spec.height, len(chosen))
    if spec.tile_width:  # one of which is unpacked, however small the picture is
        check_size(name, spec.tile_width, spec.tile_height)
    formats = {str(spec.channelformat(c)) for c in chosen}
    if len(formats) > 1 and "uint" in formats:
        raise InputError(f"{name} mixes whole numbers and floats in one layer; save them as separate files.")
    dtype = formats.pop() if len(formats) == 1 else "float"
    if dtype not in DTYPES:
        raise InputError(f"{name} holds {dtype} pixels; save it with 8 or 16 bit, half or float.")
    first = min(chosen)
    unpacked = spec.width * spec.height * (max(chosen) + 1 - first) * DTYPES[dtype]
    check_decoding_cost(name, unpacked * COSTS.get(picture.format, 1.0), picture.size)
    return first, max(chosen) + 1, [c - first for c in chosen], dtype


def _exr_layer(names: list[str]) -> list[int]:
    """Return the channels of the default layer of an EXR: RGB(A), else Y(A), else XYZ, else the first layer."""
    index = {n.upper(): i for i, n in reversed(list(enumerate(names)))}
    prefixes = dict.fromkeys([""] + [n.rpartition(".")[0] + "." for n in index if "." in n])
    for prefix in prefixes:
        for wanted in ("RGBA", "RGB", "YA", "Y", "XYZ"):
            keys = [prefix + letter for letter in wanted]
            if all(k in index for k in keys):
                return [index[k] for k in keys]
    first = names[0].rpartition(".")[0]
    return [i for i, n in enumerate(names) if n.rpartition(".")[0] == first]


def upright(pixels: Array, orientation: int) -> Array:
    """Apply an EXIF orientation, 1 to 8; anything else is taken as upright."""
    if orientation in (5, 6, 7, 8):
        pixels = np.swapaxes(pixels, 0, 1)
    if orientation in (3, 4, 7, 8):
        pixels = pixels[::-1]
    if orientation in (2, 3, 6, 7):
        pixels = pixels[:, ::-1]
    return pixels


def _exif_orientation(exif: bytes | None) -> int:
    if not exif:
        return 1
    from PIL import Image

    facts = Image.Exif()
    try:
        facts.load(exif)
        return int(facts.get(0x0112, 1))
    except Exception:  # broken EXIF: the picture is as it lies
        return 1


def _profile(icc: bytes | None, pixels: Array) -> bytes | None:
    """Return an ICC profile if it is valid and fits the number of channels, else None."""
    if not icc or len(icc) < 132 or icc[36:40] != b"acsp" or int.from_bytes(icc[:4], "big") > len(icc):
        return None
    gray = pixels.ndim == 2 or pixels.shape[2] == 2
    return icc if icc[16:20] == (b"GRAY" if gray else b"RGB ") else None
