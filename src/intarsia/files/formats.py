"""Which picture formats there are, how their first bytes look, and what each of them can hold."""

from __future__ import annotations

import os
from dataclasses import dataclass

from ..disk.limits import MAX_CHANNELS
from ..errors import ParameterError, printable

PNG_SIDE = 1_000_000
"""libpng reads and writes no longer sides."""

READABLE = "PNG, JPEG, TIFF, EXR, Radiance HDR, WebP, TGA, BMP, GIF, PPM, PGM, PBM or PFM"


@dataclass(frozen=True)
class Format:
    """What a file format can hold, and where it keeps a recipe."""

    name: str
    suffixes: tuple[str, ...]
    dtypes: tuple[str, ...]
    channels: tuple[int, ...]
    side: int = 1 << 20
    text: bool = False  # holds a recipe inside
    icc: bool = False
    lossless: bool = True

    @property
    def depths(self) -> str:
        """The depths it holds, in words."""
        words = {"uint8": "8", "uint16": "16", "float16": "half", "float32": "float"}
        held = [words[d] for d in self.dtypes if d in words]
        unit = " bit" if held[-1] in ("8", "16") else ""
        return " or ".join(held) + unit


ANY = tuple(range(1, MAX_CHANNELS + 1))
FORMATS = (
    Format("png", (".png",), ("uint8", "uint16"), (1, 2, 3, 4), PNG_SIDE, text=True, icc=True),
    Format("jpeg", (".jpg", ".jpeg"), ("uint8",), (1, 3), 65500, text=True, icc=True, lossless=False),
    Format("tiff", (".tif", ".tiff"), ("uint8", "uint16", "uint32", "float32", "float64"), ANY, text=True, icc=True),
    Format("tga", (".tga",), ("uint8",), (1, 2, 3, 4), 65535),
    Format("bmp", (".bmp",), ("uint8",), (1, 3, 4), 1 << 15),
    Format("ppm", (".ppm",), ("uint8", "uint16"), (3,)),
    Format("pgm", (".pgm",), ("uint8", "uint16"), (1,)),
    Format("pfm", (".pfm",), ("float32",), (1, 3)),
    Format("webp", (".webp",), ("uint8",), (3, 4), 16383, text=True, icc=True),
    Format("exr", (".exr",), ("float16", "float32", "uint32"), ANY, text=True),
    Format("hdr", (".hdr",), ("float32",), (3,), lossless=False),  # 8 bits and an exponent of three floats
)
SUFFIXES = {suffix: f for f in FORMATS for suffix in f.suffixes}


def format_of(path: str | os.PathLike[str]) -> Format:
    """Tell by its ending which format a file will be written in."""
    text = os.fspath(path)
    suffix = os.path.splitext(text)[1].lower()
    if suffix not in SUFFIXES:
        was = f"the ending {suffix}" if suffix else "a name without ending"
        raise ParameterError(f"{printable(text)}: {printable(was)} names no format; end it in {', '.join(SUFFIXES)}.")
    return SUFFIXES[suffix]


_MAGIC = (
    ("png", b"\x89PNG\r\n\x1a\n"),
    ("jpeg", b"\xff\xd8\xff"),
    ("tiff", b"II*\x00"),
    ("tiff", b"MM\x00*"),
    ("tiff", b"II+\x00\x08\x00"),
    ("tiff", b"MM\x00+\x00\x08"),
    ("exr", b"v/1\x01"),
    ("hdr", b"#?RADIANCE"),
    ("hdr", b"#?RGBE"),
    ("gif", b"GIF87a"),
    ("gif", b"GIF89a"),
)
_REFUSED = (
    (b"PK\x03\x04", "a zip archive"),
    (b"PK\x05\x06", "a zip archive"),
    (b"%PDF", "a PDF"),
    (b"%!PS", "PostScript"),
    (b"\xc5\xd0\xd3\xc6", "PostScript"),
    (b"8BPS", "a Photoshop file"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"7z\xbc\xaf", "a 7z archive"),
    (b"Rar!", "a RAR archive"),
    (b"BZh", "a bzip2 archive"),
    (b"\xfd7zXZ", "an xz archive"),
    (b"(\xb5/\xfd", "a zstd archive"),
    (b"\x00\x00\x00\x0cjP", "JPEG 2000"),
    (b"\xffO\xffQ", "JPEG 2000"),
    (b"\x00\x00\x00\x0cJXL", "JPEG XL"),
    (b"\xff\n", "JPEG XL"),
    (b"DDS ", "a DDS texture"),
    (b"\xabKTX", "a KTX texture"),
    (b"gimp xcf", "a GIMP file"),
    (b"SIMPLE  =", "FITS"),
    (b"SDPX", "DPX"),
    (b"XPDS", "DPX"),
    (b"qoif", "QOI"),
    (b"P7", "PAM"),
    (b"\x93NUMPY", "a NumPy array"),
    (b"\x7fELF", "a program"),
    (b"MZ", "a program"),
    (b"\x00\x00\x01\x00", "an icon"),
    (b"FORM", "IFF"),
    (b"BLENDER", "a Blender file"),
)


def sniff(head: bytes, size: int) -> tuple[str | None, str]:
    """Tell a format by the first bytes of a file: its name or None, and what the file seems to be in words."""
    for name, magic in _MAGIC:
        if head.startswith(magic):
            return name, name
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return "webp", "webp"
    if len(head) > 2 and head[:1] == b"P" and (head[1:2] in b"123456Ff") and (head[2:3].isspace() or head[2:3] == b"#"):
        return "pnm", "pnm"
    if head[:2] == b"BM" and head[14:18] in (n.to_bytes(4, "little") for n in (12, 16, 40, 52, 56, 64, 108, 124)):
        return "bmp", "bmp"
    for magic, words in _REFUSED:
        if head.startswith(magic):
            return None, words
    if head[4:8] == b"ftyp":
        return None, "AVIF or HEIC" if head[8:12] in (b"avif", b"avis", b"heic", b"mif1", b"heix") else "a video"
    text = head.lstrip(b"\xef\xbb\xbf \t\r\n").lower()
    if text.startswith((b"<svg", b"<?xml", b"<!doctype svg")):
        return None, "SVG or other XML"
    if text.startswith((b"<html", b"<!doctype html")):
        return None, "a web page"
    if _is_tga(head, size):
        return "tga", "tga"
    printable = sum(32 <= b < 127 or b in b"\t\r\n" or b > 127 for b in head[:256])
    return None, "text" if head and printable == len(head[:256]) else "no picture that is known"


def _is_tga(head: bytes, size: int) -> bool:
    """Targa has no magic bytes: accept only a header in which every field is possible."""
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
