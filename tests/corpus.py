"""Files that break readers, made by small code when a test asks for them.

``CASES`` maps a name to how the file is made and what must become of it: it reads (``ok``), it is refused by an
InputError (``refused``), or one of the two, but never anything else (``either``).
"""

from __future__ import annotations

import io
import os
import struct
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageCms

OK, REFUSED, EITHER = "ok", "refused", "either"


@dataclass(frozen=True)
class Case:
    """How a file is made in a folder, and what must become of it."""

    make: Callable[[Path], Path]
    outcome: str


CASES: dict[str, Case] = {}


def picture(height: int = 20, width: int = 24, channels: int = 3) -> np.ndarray:
    """Smooth and a little noisy, the same at every call."""
    y, x = np.mgrid[:height, :width]
    planes = [(x * 7 + y * (3 + k) + (x * y * (k + 5)) % 31) % 256 for k in range(channels)]
    out = np.stack(planes, axis=2).astype(np.uint8)
    return out[:, :, 0] if channels == 1 else out


def pillow(format: str, pixels: np.ndarray | Image.Image, **options: Any) -> bytes:
    image = pixels if isinstance(pixels, Image.Image) else Image.fromarray(pixels)
    buffer = io.BytesIO()
    image.save(buffer, format, **options)
    return buffer.getvalue()


def chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(width: int, height: int, *, extra: bytes = b"", body: bytes | None = None) -> bytes:
    rows = (b"\0" + bytes(width)) * height if body is None else body
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + extra + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    )


def tiff(
    pixels: np.ndarray, *, order: str = "<", big: bool = False, planar: bool = False, tags: dict[int, int] | None = None
) -> bytes:
    """Write an uncompressed TIFF, classic or Big, of either byte order; tags may be overruled."""
    data = pixels.reshape(pixels.shape[0], pixels.shape[1], -1)
    height, width, channels = data.shape
    dtype = data.dtype.newbyteorder(order)
    planes = [data[:, :, c] for c in range(channels)] if planar else [data]
    strips = [np.ascontiguousarray(p).astype(dtype).tobytes() for p in planes]
    start = 16 if big else 8
    offsets = [start + sum(map(len, strips[:i])) for i in range(len(strips))]
    kind = {"u": 1, "i": 2, "f": 3}[data.dtype.kind]
    fields: dict[int, list[int]] = {
        256: [width], 257: [height], 258: [data.dtype.itemsize * 8] * channels, 259: [1],
        262: [2 if channels >= 3 else 1], 273: offsets, 277: [channels], 278: [height],
        279: [len(s) for s in strips], 284: [2 if planar else 1],
        339: [kind] * channels,
    }  # fmt: skip
    if channels not in (1, 3):
        fields[338] = [0] * (channels - (3 if channels > 3 else 1))
    fields |= {k: [v] for k, v in (tags or {}).items()}
    body = b"".join(strips)
    where, n, word = start + len(body), len(fields), "Q" if big else "I"
    table, tail = struct.pack(order + ("Q" if big else "H"), n), b""
    size, room = (20, 8) if big else (12, 4)
    behind = where + len(table) + n * size + room
    for tag in sorted(fields):
        values = struct.pack(f"{order}{len(fields[tag])}I", *fields[tag])
        table += struct.pack(f"{order}HH{word}", tag, 4, len(fields[tag]))
        if len(values) <= room:
            table += values.ljust(room, b"\0")
        else:
            table += struct.pack(order + word, behind + len(tail))
            tail += values
    mark = b"II" if order == "<" else b"MM"
    head = mark + (struct.pack(order + "HHHQ", 43, 8, 0, where) if big else struct.pack(order + "HI", 42, where))
    return head + body + table + bytes(room) + tail


def exr(
    width: int, height: int, *, window: tuple[int, int, int, int] | None = None, value: np.ndarray | None = None
) -> bytes:
    """Write an uncompressed scan-line EXR of one float channel; the data window may lie."""
    box = window or (0, 0, width - 1, height - 1)
    pixels = np.zeros((height, width), "<f4") if value is None else value.astype("<f4")

    def field(name: bytes, kind: bytes, body: bytes) -> bytes:
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(body)) + body

    channels = b"Y\0" + struct.pack("<IIII", 2, 0, 1, 1) + b"\0"
    head = b"v/1\x01\x02\0\0\0" + field(b"channels", b"chlist", channels) + field(b"compression", b"compression", b"\0")
    head += field(b"dataWindow", b"box2i", struct.pack("<4i", *box)) + field(
        b"displayWindow", b"box2i", struct.pack("<4i", *box)
    )
    head += field(b"lineOrder", b"lineOrder", b"\0") + field(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
    head += field(b"screenWindowCenter", b"v2f", struct.pack("<ff", 0, 0))
    head += field(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0"
    first = len(head) + 8 * height
    rows = [struct.pack("<ii", box[1] + y, width * 4) + pixels[y].tobytes() for y in range(height)]
    table = b"".join(struct.pack("<Q", first + y * (8 + width * 4)) for y in range(height))
    return head + table + b"".join(rows)


def whole(format: str) -> bytes:
    """A sound file of a format, to be cut and bent."""
    from intarsia.files import encode
    from intarsia.model.image import Plane

    if format == "gif":
        return pillow("gif", Image.fromarray(picture(40, 48)).quantize(64))
    pixels = picture(40, 48)
    return encode(Plane(pixels / np.float32(255) if format in ("exr", "hdr", "pfm") else pixels), format)


def add(name: str, outcome: str, data: Callable[[], bytes] | bytes, file: str | None = None) -> None:
    """Keep a case whose file is these bytes; its ending is that of `name` unless `file` says otherwise."""

    def make(folder: Path) -> Path:
        path = folder / (file or name.replace(" ", "_"))
        path.write_bytes(data() if callable(data) else data)
        return path

    assert name not in CASES
    CASES[name] = Case(make, outcome)


def _sizes_and_numbers() -> None:
    for h, w in ((1, 1), (1, 17), (17, 1), (2, 2)):
        for format in ("png", "tiff", "bmp", "tga", "ppm", "webp", "jpeg"):
            add(f"{w}x{h}.{format}", OK, lambda h=h, w=w, f=format: pillow(f, picture(h, w)))
    add("0x5.png", REFUSED, png(0, 5))
    add("0x0.ppm", REFUSED, b"P6 0 0 255 ")
    odd = np.array([[np.nan, np.inf, -np.inf], [-1.5, 1e-40, 70000.0]], np.float32)
    add("odd-floats.exr", OK, exr(3, 2, value=odd))
    add("odd-floats.tif", OK, tiff(odd))
    add("double.tif", OK, tiff(odd.astype(np.float64)))
    light = picture().astype(np.float32)[:, :, 0] / 64
    add("light.exr", OK, exr(24, 20, value=light))
    for name, value in (("nan", np.nan), ("inf", np.inf)):
        add(f"one-{name}.exr", OK, exr(24, 20, value=np.where(np.indices((20, 24)).sum(0) == 9, value, light)))
    add("all-nan.exr", OK, exr(24, 20, value=light * np.nan))
    add("65536x1.png", OK, lambda: pillow("png", picture(1, 65536)))
    add("1x65536.png", OK, lambda: pillow("png", picture(65536, 1)))
    add("256-labels.png", OK, lambda: pillow("png", (np.arange(480).reshape(20, 24) % 256).astype(np.uint8)))
    one = picture()
    one[7, 5] ^= 255
    add("one-pixel.png", OK, pillow("png", one))
    add("constant.png", OK, pillow("png", np.full((5, 5, 3), 7, np.uint8)))
    add("two-level.png", OK, pillow("png", np.indices((8, 8)).sum(0).astype(np.uint8) % 2 * 255))


def _modes() -> None:
    rgb = Image.fromarray(picture())
    palette = rgb.quantize(16)
    hidden = picture(channels=4)
    hidden[:8, :, 3] = 0
    add("palette.png", OK, lambda: pillow("png", palette))
    add("palette-transparent.png", OK, lambda: pillow("png", palette, transparency=3))
    add("palette-bad-index.png", OK, _bad_index)
    add("clear.png", OK, lambda: pillow("png", picture(channels=4) * np.array([1, 1, 1, 0], np.uint8)))
    add("16-bit.tga", OK, _tga_16)
    add("gamma.png", OK, lambda: png(24, 20, extra=chunk(b"gAMA", struct.pack(">I", 1))))
    add("palette-alphas.png", OK, lambda: pillow("png", palette, transparency=bytes(range(0, 160, 10))))
    add("la.png", OK, lambda: pillow("png", picture(channels=2)))
    add("hidden-colour.png", OK, lambda: pillow("png", hidden))
    add("hidden-colour.webp", OK, lambda: pillow("webp", hidden, lossless=True, exact=True))
    add("hidden-colour.tga", OK, lambda: pillow("tga", hidden))
    add("one-bit.png", OK, lambda: pillow("png", rgb.convert("1")))
    add("one-bit.tif", OK, lambda: pillow("tiff", rgb.convert("1")))
    add("one-bit.bmp", OK, lambda: pillow("bmp", rgb.convert("1")))
    add("palette.bmp", OK, lambda: pillow("bmp", palette))
    add("palette.tga", OK, lambda: pillow("tga", palette))
    add("palette.tif", OK, lambda: pillow("tiff", palette))
    add("rle.tga", OK, lambda: pillow("tga", rgb, compression="tga_rle"))
    add("cmyk.jpg", OK, lambda: pillow("jpeg", rgb.convert("CMYK")))
    add("cmyk-adobe.jpg", OK, _adobe)
    add("cmyk.tif", OK, lambda: pillow("tiff", rgb.convert("CMYK")))
    add("lab.tif", EITHER, lambda: pillow("tiff", rgb.convert("LAB")))
    add("progressive.jpg", OK, lambda: pillow("jpeg", rgb, progressive=True))
    deep = (picture(channels=1).astype(np.uint16) << 8) + 77
    for order, name in (("<", "little"), (">", "big")):
        add(f"16-{name}.tif", OK, tiff(deep, order=order))
        add(f"bigtiff-{name}.tif", OK, tiff(deep, order=order, big=True))
    add("planar.tif", OK, tiff(picture(), planar=True))
    add("seven-channels.tif", OK, tiff(picture(channels=7)))
    add("65-channels.tif", REFUSED, tiff(picture(4, 4, 65)))
    add("signed.tif", REFUSED, tiff(picture().astype(np.int16)))
    add("whole-32.tif", REFUSED, tiff(picture(channels=1).astype(np.uint32)))
    frames = [Image.fromarray(picture(20, 24) // k) for k in (1, 2, 3)]
    add("pages.tif", OK, lambda: pillow("tiff", frames[0], save_all=True, append_images=frames[1:]))
    for format in ("gif", "webp", "png"):
        add(f"animated.{format}", OK, lambda f=format: pillow(f, frames[0], save_all=True, append_images=frames[1:]))
    for orientation in range(10):
        add(f"orientation-{orientation}.jpg", OK, lambda o=orientation: pillow("jpeg", rgb, exif=_exif(o)))
        add(f"orientation-{orientation}.png", OK, lambda o=orientation: pillow("png", rgb, exif=_exif(o)))
        outcome = EITHER if orientation in (0, 9) else OK
        add(f"orientation-{orientation}.tif", outcome, tiff(picture(), tags={274: orientation}))
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    grey, noise = profile[:16] + b"GRAY" + profile[20:], bytes(range(256)) * 3
    for what, icc in (("sound", profile), ("broken", profile[:100]), ("noise", noise), ("grey", grey)):
        for format in ("png", "jpeg", "tiff", "webp"):
            add(f"icc-{what}.{format}", OK, lambda f=format, i=icc: pillow(f, rgb, icc_profile=i))


def _bad_index() -> bytes:
    """Pixels of number 5 in a palette of two colours: read as black, as the standard proposes."""
    head = struct.pack(">IIBBBBB", 24, 20, 8, 3, 0, 0, 0)
    rows = (b"\0" + bytes([0, 1, 5] * 8)) * 20
    parts = chunk(b"IHDR", head) + chunk(b"PLTE", bytes([9, 8, 7, 250, 240, 230]))
    return b"\x89PNG\r\n\x1a\n" + parts + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def _tga_16() -> bytes:
    pixels = np.arange(480, dtype="<u2") * 67 & 0x7FFF
    return struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, 24, 20, 16, 0x20) + pixels.tobytes()


def _exif(orientation: int) -> Image.Exif:
    exif = Image.Exif()
    exif[0x0112] = orientation
    return exif


def _adobe() -> bytes:
    data = pillow("jpeg", Image.fromarray(255 - np.array(Image.fromarray(picture()).convert("CMYK"), np.uint8), "CMYK"))
    assert b"Adobe" in data
    return data.replace(b"Adobe\0\x64\0\0\0\0\0", b"Adobe\0\x64\0\0\0\0\2")  # declared as YCCK


def _damage() -> None:
    formats = ("png", "jpeg", "tiff", "exr", "ppm", "webp", "tga", "bmp", "hdr", "pfm", "gif")
    for format in formats:
        for part in range(1, 16):
            # A GIF may lose its last byte, and TGA nothing but its footer: that is still the whole picture.
            outcome = EITHER if format in ("gif", "tga") and part == 15 else REFUSED
            add(f"cut-{part}-of-16.{format}", outcome, lambda f=format, p=part: whole(f)[: len(whole(f)) * p // 16])
        for flip in range(12):
            add(f"flip-{flip}.{format}", EITHER, lambda f=format, k=flip: _flipped(whole(f), k))
    add(
        "no-idat.png",
        REFUSED,
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 4, 8, 0, 0, 0, 0)) + chunk(b"IEND", b""),
    )
    add("short-idat.png", REFUSED, png(9, 9, body=b"\0" + bytes(9)))
    add("bad-idat.png", REFUSED, png(9, 9).replace(b"IDAT", b"IDAX"))
    add("thumbnail-only.jpg", REFUSED, _cut_after_thumbnail)
    add("zero-bytes.png", REFUSED, b"")
    add("one-byte.png", REFUSED, b"\x89")
    add("noise.tga", REFUSED, bytes(range(7, 200)))
    add("text.png", REFUSED, b"This is not a picture.\n")
    add("png-as.exr", OK, lambda: whole("png"))
    add("exr-as.jpg", OK, lambda: whole("exr"))
    add("tga-as.png", OK, lambda: whole("tga"))
    add("ppm-without-ending", OK, lambda: whole("ppm"))
    add("trailing.png", OK, lambda: whole("png") + b"more")
    add("polyglot.png", OK, lambda: whole("png") + _zip())
    add("trailing.jpg", OK, lambda: whole("jpeg") + b"more")


def _flipped(data: bytes, k: int) -> bytes:
    bent = bytearray(data)
    for i in range(3):
        z = (k * 3 + i + 1) * 2654435761 & 0xFFFFFFFF
        bent[z % len(bent)] ^= 1 << (z >> 29)
    return bytes(bent)


def _cut_after_thumbnail() -> bytes:
    small, large = pillow("jpeg", picture(8, 8)), pillow("jpeg", picture(40, 48))
    part = large[:2] + b"\xff\xe1" + struct.pack(">H", len(small) + 2) + small + large[2:]
    return part[: len(part) * 3 // 4]


def _netpbm() -> None:
    rows = bytes(range(12))
    add("comments.ppm", OK, b"P6# a\n#b\n 2 # c\n#d\n\t2\r\n#e\n255\n" + rows)
    add("comment-behind.ppm", REFUSED, b"P6 2 2 255# note\n" + rows)
    add("crlf.ppm", REFUSED, b"P6\r\n2 2\r\n255\r\n" + rows)
    add("tabs.ppm", OK, b"P6\t2\t2\t255\t" + rows)
    add("hash-pixel.ppm", OK, b"P6 2 2 255 ##\n" + rows[3:])
    add("trailing-blank.ppm", OK, b"P6 2 2 255\n" + rows + b" \n ")
    add("missing.ppm", REFUSED, b"P6 2 2 255\n" + rows[:-1])
    add("header-only.ppm", REFUSED, b"P6 2 2 255")
    for maxval, outcome in ((1, REFUSED), (100, REFUSED), (255, OK), (0, REFUSED), (70000, REFUSED), (-1, REFUSED)):
        add(f"maxval-{maxval}.ppm", outcome, b"P6 2 2 %d\n" % maxval + bytes(12))
    add("maxval-65535.ppm", OK, b"P6 2 2 65535\n" + bytes(24))
    add("above-maxval.ppm", REFUSED, b"P5 2 1 7\n\x07\x08")
    add("wide.ppm", REFUSED, b"P6 1000000000 1 255\n" + rows)
    add("endless-number.ppm", REFUSED, b"P6 " + b"1" * 5000 + b" 2 255\n" + rows)
    add("plain.pgm", REFUSED, b"P2\n# x\n2 2 9\n0 3\n#y\n6 9\n")
    add("plain-missing.pgm", REFUSED, b"P2 2 2 9 0 3 6")
    add("plain-words.pgm", REFUSED, b"P2 2 2 9 0 3 x 6")
    add("plain.pbm", REFUSED, b"P1 3 2 101\n0 1 0")
    add("packed.pbm", REFUSED, b"P4 9 2\n\xff\x80\x00\x00")
    add("scale-0.pfm", REFUSED, b"Pf 1 1 0\n" + bytes(4))
    add("scale-nan.pfm", REFUSED, b"Pf 1 1 nan\n" + bytes(4))
    add("short.pfm", REFUSED, b"PF 1 1 -1\n" + bytes(8))
    add("pam.pam", REFUSED, b"P7\nWIDTH 1\nHEIGHT 1\nDEPTH 1\nMAXVAL 255\nENDHDR\n\0")


def _bombs() -> None:
    add("bomb.png", REFUSED, png(50000, 50000, body=bytes(1000)))
    bomb = chunk(b"zTXt", b"k\0\0" + zlib.compress(bytes(1 << 20)))
    add(
        "text.png-many",
        REFUSED,
        lambda: png(4, 4, extra=chunk(b"zTXt", b"k\0\0" + zlib.compress(bytes(70 << 20), 1))),
        "bomb2.png",
    )
    add("text-bombs.png", REFUSED, lambda: png(4, 4, extra=bomb * 70))
    add(
        "profile-bomb.png",
        REFUSED,
        lambda: png(4, 4, extra=chunk(b"iCCP", b"k\0\0" + zlib.compress(bytes(70 << 20), 1))),
    )
    add("text-sound.png", OK, png(4, 4, extra=bomb))
    add("bomb.exr", REFUSED, exr(4, 4, window=(-(1 << 30), -(1 << 30), 1 << 30, 1 << 30)))
    add("tall.exr", REFUSED, exr(4, 4, window=(0, 0, 3, (1 << 31) - 2)))
    add("lying.exr", REFUSED, exr(4, 4, window=(0, 0, 8000, 8000)))
    add("bomb.tif", REFUSED, tiff(picture(), tags={256: 1 << 30, 257: 1 << 30}))
    add("strips.tif", REFUSED, tiff(picture(), tags={257: 1000000000, 278: 1}))
    add("lying.tif", REFUSED, tiff(picture(), tags={256: 9000, 257: 9000}))
    add("bomb.gif", REFUSED, lambda: whole("gif")[:6] + struct.pack("<HH", 65535, 65535) + whole("gif")[10:])
    add("bomb.bmp", REFUSED, lambda: whole("bmp")[:18] + struct.pack("<ii", 1 << 30, 1 << 30) + whole("bmp")[26:])
    add("bomb.tga", REFUSED, lambda: whole("tga")[:12] + struct.pack("<HH", 65535, 65535) + whole("tga")[16:])
    add("bomb.hdr", REFUSED, b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000000 +X 1000000000\n")
    add("bomb.webp", REFUSED, lambda: b"RIFF\x1e\0\0\0WEBPVP8L\x11\0\0\0\x2f" + b"\xff" * 16)
    add("bomb.jpg", REFUSED, lambda: _jpeg_size(whole("jpeg"), 65500))
    add("entities.svg", REFUSED, b'<?xml version="1.0"?><!DOCTYPE s [<!ENTITY a "aa">]><svg>&a;</svg>')
    add("plain.svg", REFUSED, b"<svg xmlns='http://www.w3.org/2000/svg'/>")
    add("paper.pdf", REFUSED, b"%PDF-1.7\n")
    add("layers.psd", REFUSED, b"8BPS\0\1" + bytes(40))
    add("zip.png", REFUSED, _zip)
    for magic, name in (
        (b"\0\0\0\x20ftypavif", "a.avif"), (b"\x1f\x8b\x08", "a.gz"), (b"MZ\x90", "a.exe"), (b"DDS |", "a.dds")
    ):  # fmt: skip
        add(name, REFUSED, magic + bytes(60))


def _jpeg_size(data: bytes, side: int) -> bytes:
    at = data.find(b"\xff\xc0") + 5
    return data[:at] + struct.pack(">HH", side, side) + data[at + 4 :]


def _zip() -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("../up.png", bytes(1 << 20))
    return buffer.getvalue()


def _places() -> None:
    def linked(name: str, target: str) -> Callable[[Path], Path]:
        def make(folder: Path) -> Path:
            (folder / "real.png").write_bytes(png(4, 4))
            (folder / name).symlink_to(folder / target)
            return folder / name

        return make

    def made(name: str, make: Callable[[Path], None]) -> Callable[[Path], Path]:
        return lambda folder: make(folder / name) or folder / name  # type: ignore[func-returns-value]

    CASES["a folder"] = Case(made("dir.png", Path.mkdir), REFUSED)
    CASES["a pipe"] = Case(made("pipe.png", os.mkfifo), REFUSED)
    CASES["a broken link"] = Case(linked("link.png", "nothing.png"), REFUSED)
    CASES["a link to itself"] = Case(linked("loop.png", "loop.png"), REFUSED)
    CASES["a good link"] = Case(linked("good.png", "real.png"), OK)
    CASES["a device"] = Case(lambda _: Path("/dev/zero"), REFUSED)
    CASES["nothing"] = Case(lambda folder: folder / "nothing.png", REFUSED)
    CASES["below a file"] = Case(lambda folder: Path(__file__) / "x.png", REFUSED)
    CASES["a long name"] = Case(lambda folder: folder / ("x" * 5000 + ".png"), REFUSED)
    CASES["a zero in the name"] = Case(lambda folder: folder / "a\0b.png", REFUSED)
    for name in (
        "space in name.png", "-leading.png", "ünïcödé 木目.png", "percent%04d.png", "query?a=1.png", "x" * 250 + ".png",
    ):  # fmt: skip
        add(f"name {name[:20]}", OK, png(4, 4), name)
        add(f"name {name[:20]} tif", OK, tiff(picture()), name.replace(".png", ".tif"))


_sizes_and_numbers()
_modes()
_damage()
_netpbm()
_bombs()
_places()
