"""Picture formats: what each can hold, how it is recognised by its first bytes, and files opened safely.

An EXR file may hold several planes as layers, each in channels such as normal.X; FILE.exr::normal is one of them.
"""

from __future__ import annotations

import os
import shutil
import stat
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..disk import MAX_CHANNELS, no_room, reason_of
from ..disk.atomic import PathLike, file_size, working_folder
from ..foundation import InputError, ParameterError, ResourceError, printable

PNG_SIDE = 1_000_000
"""libpng reads and writes no longer sides."""

READABLE = "PNG, JPEG, TIFF, EXR, Radiance HDR, WebP, TGA, BMP, GIF, PPM, PGM or PFM"


@dataclass(frozen=True)
class Format:
    """What a file format can hold: types of pixels, numbers of channels, longest side, a recipe (text), a profile."""

    name: str
    suffixes: tuple[str, ...]
    dtypes: tuple[str, ...]
    channels: tuple[int, ...]
    side: int = 1 << 20
    text: bool = False  # holds a recipe inside
    icc: bool = False
    lossless: bool = True


ANY = tuple(range(1, MAX_CHANNELS + 1))
FORMATS = (
    Format("png", (".png",), ("uint8", "uint16"), (1, 2, 3, 4), PNG_SIDE, text=True, icc=True),
    Format("jpeg", (".jpg", ".jpeg"), ("uint8",), (1, 3), 65500, text=True, icc=True, lossless=False),
    Format("tiff", (".tif", ".tiff"), ("uint8", "uint16", "uint32", "float32", "float64"), ANY, text=True, icc=True),
    Format("tga", (".tga",), ("uint8",), (1, 2, 3, 4), 65535),
    Format("bmp", (".bmp",), ("uint8",), (1, 3, 4), 1 << 15),
    Format("ppm", (".ppm",), ("uint8", "uint16"), (3,), 65535),
    Format("pgm", (".pgm",), ("uint8", "uint16"), (1,), 65535),
    Format("pfm", (".pfm",), ("float32",), (1, 3), 65535),
    Format("webp", (".webp",), ("uint8",), (3, 4), 16383, text=True, icc=True),
    Format("exr", (".exr",), ("float16", "float32", "uint32"), ANY, text=True),
    Format("hdr", (".hdr",), ("float32",), (3,), lossless=False),  # 8 bits and an exponent of three floats
)
SUFFIXES = {suffix: f for f in FORMATS for suffix in f.suffixes}


def format_of(path: PathLike) -> Format:
    """Return the format that the ending of a name means; ParameterError for others."""
    text = os.fspath(path)
    suffix = os.path.splitext(text)[1].lower()
    if suffix not in SUFFIXES:
        was = f"the ending {suffix}" if suffix else "a name without ending"
        raise ParameterError(f"{printable(text)}: {printable(was)} names no format; end it in {', '.join(SUFFIXES)}.")
    return SUFFIXES[suffix]


_MAGIC: dict[str, bytes | tuple[bytes, ...]] = {
    "png": b"\x89PNG\r\n\x1a\n",
    "jpeg": b"\xff\xd8\xff",
    "tiff": (b"II*\x00", b"MM\x00*", b"II+\x00\x08\x00", b"MM\x00+\x00\x08"),
    "exr": b"v/1\x01",
    "hdr": (b"#?RADIANCE", b"#?RGBE"),
    "gif": (b"GIF87a", b"GIF89a"),
    "a zip archive": (b"PK\x03\x04", b"PK\x05\x06"),
    "a PDF": b"%PDF",
    "PostScript": (b"%!PS", b"\xc5\xd0\xd3\xc6"),
    "a Photoshop file": b"8BPS",
    "a gzip archive": b"\x1f\x8b",
    "a 7z archive": b"7z\xbc\xaf",
    "JPEG 2000": (b"\x00\x00\x00\x0cjP", b"\xffO\xffQ"),
    "JPEG XL": (b"\x00\x00\x00\x0cJXL", b"\xff\n"),
    "a DDS texture": b"DDS ",
    "a GIMP file": b"gimp xcf",
    "a NumPy array": b"\x93NUMPY",
    "a program": (b"\x7fELF", b"MZ"),
}
_READ = frozenset({"png", "jpeg", "tiff", "exr", "hdr", "gif", "webp", "pnm", "bmp", "tga"})
"""What :func:`sniff` returns for files that can be read."""


def sniff(head: bytes, size: int) -> str:
    """Return what a file is by its first bytes: the name of a format that is read, or words for anything else."""
    for words, magic in _MAGIC.items():
        if head.startswith(magic):
            return words
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return "webp"
    if len(head) > 2 and head[:1] == b"P" and (head[1:2] in b"123456Ff") and (head[2:3].isspace() or head[2:3] == b"#"):
        return "pnm"
    if head[:2] == b"BM" and head[14:18] in (n.to_bytes(4, "little") for n in (12, 16, 40, 52, 56, 64, 108, 124)):
        return "bmp"
    if head[4:8] == b"ftyp":
        return "AVIF or HEIC" if head[8:12] in (b"avif", b"avis", b"heic", b"mif1", b"heix") else "a video"
    text = head.lstrip(b"\xef\xbb\xbf \t\r\n").lower()
    if text.startswith((b"<svg", b"<?xml", b"<!doctype svg")):
        return "SVG or other XML"
    if text.startswith((b"<html", b"<!doctype html")):
        return "a web page"
    if _is_tga(head, size):
        return "tga"
    return "text" if all(32 <= b < 127 or b in b"\t\r\n" or b > 127 for b in head[:256]) else "no picture that is known"


def _is_tga(head: bytes, size: int) -> bool:
    """Return whether this is a Targa header; without magic bytes, every field must be possible."""
    if len(head) < 18 or size < 19:
        return False
    mapped, kind, depth, flags = head[1], head[2], head[16], head[17]
    depths = {1: (8, 16), 2: (15, 16, 24, 32), 3: (8, 16)}.get(kind & 7, ())
    return (
        kind in (1, 2, 3, 9, 10, 11)
        and mapped in (0, 1)
        and (mapped == 1 or kind & 7 != 1)
        and depth in depths
        and flags & 0xC0 == 0
        and flags & 15 <= 8
        and head[12:14] != b"\0\0"
        and head[14:16] != b"\0\0"
    )


HEAD = 1 << 16
MAX_WHOLE = 1 << 32
"""Formats that are read into memory whole may have this many bytes."""

_RECEIVED: dict[str, Any] = {}  # what came of the standard input, and which object that was


@dataclass(frozen=True)
class PictureFile:
    """A picture file or its bytes: the name for messages, the format, where the bytes are, and how many.

    ``head`` are the first 64 KiB.
    """

    name: str
    format: str
    source: Path | bytes
    size: int
    head: bytes

    def data(self) -> bytes:
        """Return all bytes."""
        data = _first_bytes(self.source, self.name, MAX_WHOLE + 1)
        if len(data) > MAX_WHOLE:
            raise InputError(f"{self.name} is larger than {MAX_WHOLE >> 30} GiB; crop it, or save it as TIFF or EXR.")
        return data

    @contextmanager
    def plain_path(self) -> Iterator[str]:
        """Make a temporary link or copy with the true ending and a plain name, for libraries that go by the name."""
        with working_folder() as folder:
            target = Path(folder, "picture" + {"jpeg": ".jpg", "tiff": ".tif"}.get(self.format, "." + self.format))
            if isinstance(self.source, Path):
                try:
                    target.symlink_to(self.source.absolute())
                except OSError:  # no links here, as on some Windows machines
                    shutil.copyfile(self.source, target)
            else:
                try:
                    target.write_bytes(self.source)
                except OSError as e:
                    raise ResourceError(
                        f"there is no room for a copy of {self.name} in {folder} ({reason_of(e)}); free some, or set "
                        "TMPDIR."
                    ) from None
            yield str(target)


def damaged_error(name: str, why: str) -> InputError:
    """Return the error for a file that cannot be decoded."""
    why = " ".join(str(why).split())[:160].rstrip(".")
    return InputError(f"{name} is damaged or cut off ({why}); copy or save it again.")


def open_picture(source: PathLike | bytes) -> PictureFile:
    """Return the picture file at a path or of some bytes; InputError if it is none. Never blocks on a pipe."""
    if isinstance(source, bytes | bytearray | memoryview):
        return _known_picture("the data", bytes(source), len(source))
    text = os.fspath(source)
    if text == "-":
        data = _standard_input()
        return _known_picture("the standard input", data, len(data))
    if not text:
        raise InputError("an empty file name was given; name a picture, or a sample such as sample:brick.")
    path, name = Path(text), printable(text)
    return _known_picture(name, path, file_size(path, name))


def _standard_input() -> bytes:
    """Return the bytes of the standard input; they are read once and kept, as planning and work both need them."""
    if sys.stdin is None:
        raise InputError("the standard input is closed; name a file.")
    if _RECEIVED.get("from") is not sys.stdin:
        _RECEIVED.update({"from": sys.stdin, "data": sys.stdin.buffer.read(MAX_WHOLE + 1)})
    data: bytes = _RECEIVED["data"]
    return data


def _known_picture(name: str, source: Path | bytes, size: int) -> PictureFile:
    if size == 0:
        raise InputError(f"{name} is empty (0 bytes); copy or save it again.")
    head = _first_bytes(source, name, HEAD)
    kind = sniff(head[:4096], size)
    if kind not in _READ:
        raise InputError(f"{name} seems to be {kind}; only {READABLE} are read, so convert it first.")
    return PictureFile(name, kind, source, size, head)


def _first_bytes(source: Path | bytes, name: str, limit: int) -> bytes:
    if isinstance(source, bytes):
        return source[:limit]
    try:
        # Not blocking: should the file have become a pipe since it was looked at, this returns at once.
        number = os.open(source, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        with os.fdopen(number, "rb") as file:
            if not stat.S_ISREG(os.fstat(number).st_mode):
                raise InputError(f"{name} is no ordinary file; name a picture file.")
            return file.read(min(limit, os.fstat(number).st_size))
    except MemoryError:
        raise no_room(name) from None
    except OSError as e:
        raise InputError(f"{name} cannot be read ({reason_of(e)}); check the permissions.") from None


LAYER = "::"
"""What stands between the name of a file and that of a layer."""

_PLAIN = "RGBAXYZ"
"""Channels that have no names of their own, in their order; those of one letter only are a picture without a name."""


def split_layer(path: PathLike) -> tuple[PathLike, str | None]:
    """Split FILE.exr::LAYER into file and layer; the layer is None if none is named."""
    file, mark, layer = os.fspath(path).rpartition(LAYER)
    return (file, layer) if mark and file.lower().endswith(".exr") else (path, None)


def channels_in(names: Sequence[str], layer: str, file: str) -> list[int]:
    """Return the indices of the channels of a layer, red before green, x before y; InputError if there are none."""
    own = [i for i, name in enumerate(names) if layer_of(name) == layer]
    if not own:
        known = ", ".join(dict.fromkeys(filter(None, map(layer_of, names)))) or "none"
        raise InputError(f"{file}: the file has no such layer; its layers are {known}.")
    last = [names[i].rpartition(".")[2].upper() for i in own]
    if not all(len(letter) == 1 and letter in _PLAIN for letter in last):
        return own
    if sorted(last) == ["A", "Y"]:
        return [own[last.index("Y")], own[last.index("A")]]
    return [i for _, i in sorted(zip(map(_PLAIN.index, last), own, strict=True))]


def channel_names(channels: int) -> list[str]:
    """Return names of the channels of a picture; EXR sorts by name, so more than four are numbered with two digits."""
    if channels > 4:
        return [f"c{i:02d}" for i in range(channels)]
    return [["Y"], ["Y", "A"], ["R", "G", "B"], ["R", "G", "B", "A"]][channels - 1]


def layer_of(channel: str) -> str:
    """Return the layer of a channel; a channel without a dot is a layer of its own if its name is a word."""
    layer, dot, own = channel.rpartition(".")
    return layer if dot else "" if len(own) == 1 else own
