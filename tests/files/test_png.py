"""PNG of every kind: read as it was written, and nothing but our line on the terminal where it is damaged."""

from __future__ import annotations

import io
import struct
import tempfile
import zlib
from contextlib import suppress

import numpy as np
import pytest
from corpus import chunk
from pictures import CHANNELS, flat_png, png_of, samples_of
from PIL import Image

import intarsia as ia
from intarsia import files
from intarsia.files import png
from intarsia.foundation import InputError

KINDS = [
    *((0, depth) for depth in (1, 2, 4, 8, 16)), *((3, depth) for depth in (1, 4, 8)),
    *((colour, depth) for colour in (2, 4, 6) for depth in (8, 16)),
]  # fmt: skip
PALETTE = chunk(b"PLTE", bytes(range(48)))


def expected(samples: np.ndarray, depth: int, colour: int) -> np.ndarray:
    if colour == 3:
        table = np.vstack([np.arange(48, dtype=np.uint8).reshape(16, 3), np.zeros((240, 3), np.uint8)])
        return table[samples[:, :, 0]]
    values = samples * ((65535 if depth == 16 else 255) // ((1 << depth) - 1))
    values = values.astype(np.uint16 if depth == 16 else np.uint8)
    return values[:, :, 0] if colour == 0 else values


@pytest.mark.parametrize("interlaced", [False, True])
@pytest.mark.parametrize(("colour", "depth"), KINDS)
def test_a_png_of_every_kind_reads_as_it_was_written(colour: int, depth: int, interlaced: bool) -> None:
    for kind, (height, width) in enumerate(((1, 1), (3, 5), (9, 8), (13, 11), (2, 17))):
        samples = samples_of(height, width, depth, colour)
        samples = np.minimum(samples, 15) if colour == 3 else samples
        extra = chunk(b"PLTE", bytes(range(min(48, 3 << depth)))) if colour == 3 else b""
        data = png_of(samples, depth, colour, interlaced=interlaced, kind=kind, extra=extra)
        np.testing.assert_array_equal(files.read_plane(data).pixels, expected(samples, depth, colour))


@pytest.mark.parametrize(("colour", "depth"), [(0, 2), (0, 8), (0, 16), (2, 8), (2, 16)])
def test_a_colour_that_means_transparent_becomes_alpha(colour: int, depth: int) -> None:
    samples = samples_of(9, 8, depth, colour)
    key = samples[3, 4]
    data = png_of(samples, depth, colour, extra=chunk(b"tRNS", struct.pack(f">{len(key)}H", *key)))
    read = files.read_plane(data).samples
    np.testing.assert_array_equal(read[:, :, -1] == 0, (samples == key).all(axis=2))
    np.testing.assert_array_equal(read[:, :, :-1], expected(samples, depth, colour).reshape(9, 8, -1))


@pytest.mark.parametrize("interlaced", [False, True])
@pytest.mark.parametrize(("colour", "depth"), KINDS)
def test_a_damaged_png_says_our_line_alone(
    colour: int, depth: int, interlaced: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    """A wrong filter, streams that are cut, also of black; nothing is said by libraries. All of black is sound."""
    samples = samples_of(9, 8, depth, colour)
    extra = chunk(b"PLTE", bytes(min(768, 3 << depth))) if colour == 3 else b""
    assert files.read_plane(png_of(0 * samples, depth, colour, interlaced=interlaced, extra=extra)).height == 9
    sound = png_of(samples, depth, colour, interlaced=interlaced, kind=0, extra=extra)
    at = sound.index(b"IDAT")
    rows = zlib.decompress(sound[at + 4 : at + 4 + int.from_bytes(sound[at - 4 : at], "big")])
    for body in (b"\x05" + rows[1:], b"\xff" + rows[1:], rows[:-1], rows[: len(rows) // 2], bytes(len(rows) - 1), b""):
        with pytest.raises(InputError, match="damaged"):
            files.read_plane(png_of(samples, depth, colour, interlaced=interlaced, body=body, extra=extra))
        assert capfd.readouterr() == ("", "")
    tail = sound.index(b"IEND") - 4
    more = sound[:tail] + chunk(b"IDAT", b"more") + sound[tail:]
    for bent in (sound[: at + 6] + b"\xff" * 5 + sound[at + 11 :], more):
        length = int.from_bytes(bent[at - 4 : at], "big")
        mended = struct.pack(">I", zlib.crc32(bent[at : at + 4 + length]))
        with suppress(InputError):
            files.read_plane(bent[: at + 4 + length] + mended + bent[at + 8 + length :])
        assert capfd.readouterr() == ("", "")


def test_a_header_that_no_png_can_have_is_damage(capfd: pytest.CaptureFixture[str]) -> None:
    sound = png_of(samples_of(4, 4, 8, 0), 8, 0)
    for colour, depth in ((7, 8), (2, 4), (3, 16), (1, 8), (6, 1)):
        head = struct.pack(">IIBBBBB", 4, 4, depth, colour, 0, 0, 0)
        with pytest.raises(InputError, match="damaged"):
            files.read_plane(sound[:8] + chunk(b"IHDR", head) + sound[33:])
    assert capfd.readouterr() == ("", "")


def test_large_pictures_are_converted_in_bands() -> None:
    """More pixels than a band, in every way that a band is packed or converted."""
    for colour, depth in ((0, 1), (0, 8), (0, 16), (2, 8), (3, 8), (4, 8), (6, 8)):
        samples = np.zeros((1300, 900, CHANNELS[colour]), int)
        samples[1295, 7], samples[1160:1170, 890] = (1 << depth) - 1 if colour != 3 else 5, 1
        extra = PALETTE if colour == 3 else b""
        data = png_of(samples, depth, colour, kind=0, extra=extra)
        np.testing.assert_array_equal(files.read_plane(data).pixels, expected(samples, depth, colour))
    assert files.read_plane(flat_png(1, 70000, 8, 2)).height == 70000


def by_the_book(data: bytes) -> np.ndarray:
    """The pixels of a PNG without interlace, as ISO/IEC 15948 says, row by row; each of its checksums is right."""
    assert data[:8] == bytes([137, 80, 78, 71, 13, 10, 26, 10])
    packed, at, kinds = b"", 8, []
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack_from(">I", data, at + 8 + length)[0]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack_from(">IIBB", body)
        packed += body if kind == b"IDAT" else b""
        kinds.append(kind)
        at += 12 + length
    assert (kinds[0], kinds[-1]) == (b"IHDR", b"IEND")
    channels = {0: 1, 4: 2, 2: 3, 6: 4}[colour]
    step, rows = channels * depth // 8, np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, -1)
    out = np.zeros((height, rows.shape[1] - 1), np.uint8)
    for y, (way, *steps) in enumerate(rows.tolist()):
        for x, n in enumerate(steps):
            before = int(out[y, x - step]) if x >= step else 0
            above = int(out[y - 1, x]) if y else 0
            out[y, x] = (n + {0: 0, 1: before, 2: above}[way]) % 256
    return out.view(">u2" if depth == 16 else np.uint8).reshape(height, width, channels)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize(("height", "width"), [(1, 1), (1, 40), (40, 1), (23, 17)])
@pytest.mark.parametrize("band", [1, 64, 300, 1 << 18])
def test_bands_make_one_picture_whoever_packs_them(
    band: int, height: int, width: int, channels: int, dtype: type, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(png, "BAND", band)
    draws = np.random.default_rng([height, width, channels])
    top = np.iinfo(dtype).max
    noise = draws.integers(0, top, (height, width, channels), dtype, endpoint=True)
    stripes = np.broadcast_to(noise[:, :1], noise.shape).copy()
    for pixels in (noise, stripes, stripes[::-1], np.zeros_like(noise)):
        once = png.encode_png(pixels, run=ia.Run(threads=1))
        np.testing.assert_array_equal(by_the_book(once), pixels)
        np.testing.assert_array_equal(files.read_plane(once).samples, pixels)
        for threads in (2, 3):
            assert png.encode_png(pixels, run=ia.Run(threads=threads)) == once


def test_of_two_filters_a_band_has_that_which_leaves_less() -> None:
    lines = np.broadcast_to(np.random.default_rng(3).integers(0, 256, (64, 1, 3), np.uint8), (64, 64, 3))
    for pixels, way in ((lines, 1), (np.swapaxes(lines, 0, 1), 2)):
        data = png.encode_png(pixels)
        packed = zlib.decompress(data[data.index(b"IDAT") + 4 : -16])
        assert set(np.frombuffer(packed, np.uint8).reshape(64, -1)[:, 0]) == {way}


@pytest.mark.parametrize(("colour", "depth"), [(2, 8), (2, 16), (6, 16)])
@pytest.mark.parametrize("many", [1, 9, 20_000])
@pytest.mark.parametrize("apart", [False, True])
def test_what_lies_behind_the_packed_pixels_is_passed_over(
    colour: int, depth: int, apart: bool, many: int, capfd: pytest.CaptureFixture[str]
) -> None:
    samples = samples_of(9, 8, depth, colour)
    data = png_of(samples, depth, colour)
    at = data.index(b"IDAT")
    body = data[at + 4 : at + 4 + int.from_bytes(data[at - 4 : at], "big")]
    packed = chunk(b"IDAT", body) + chunk(b"IDAT", b"more" * many) if apart else chunk(b"IDAT", body + b"more" * many)
    read = files.read_plane(data[: at - 4] + packed + data[at + 8 + len(body) :])
    np.testing.assert_array_equal(read.pixels, expected(samples, depth, colour))
    assert "".join(capfd.readouterr()) == ""


@pytest.mark.parametrize("text", ['{"seed": 1}', "Stra\u00dfe \u77f3 \u2728"])
def test_a_text_of_any_letters_and_a_profile_are_read_again(text: str) -> None:
    data = png.encode_png(np.zeros((3, 4, 3), np.uint8), icc=b"p" * 200, text=text)
    with Image.open(io.BytesIO(data)) as image:
        assert image.text == {"Description": text}
        assert image.info["icc_profile"] == b"p" * 200


def test_nothing_lies_in_the_temporary_folder_while_a_png_is_packed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "gettempdir", lambda: "/nowhere")
    files.encode(ia.Plane(np.zeros((3, 4, 3), np.uint8)), "png")
