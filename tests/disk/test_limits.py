"""What a picture, a map or a stream may cost that nobody asked for, and how more is asked for."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import zipfile
from contextlib import suppress
from pathlib import Path
from unittest.mock import Mock

import corpus
import numpy as np
import pytest
from cli.commands import run
from corpus import chunk
from files.corpus_maps import lying, packed, source
from files.exrs import save_exr
from pictures import flat_png, many_scans
from PIL import Image

import intarsia as ia
from intarsia import disk, files
from intarsia.disk import DEFAULT_PIXELS
from intarsia.foundation import InputError, ParameterError, ResourceError
from intarsia.model.sourcemap import Source, SourceMap


def refused(data: bytes) -> str:
    with pytest.raises(InputError) as caught:
        files.read_plane(data)
    assert "damaged" not in str(caught.value)
    return str(caught.value)


def test_a_jpeg_of_a_thousand_scans_is_refused_before_it_is_unpacked() -> None:
    """Each scan goes over the whole picture: time grows with the area, and not with what the file holds."""
    progressive = corpus.pillow("jpeg", corpus.picture(8, 8), progressive=True)
    assert files.read_plane(many_scans(progressive, 300)).width == 8
    assert "scans" in refused(many_scans(progressive, 600))
    large = corpus.pillow("jpeg", Image.new("L", (2000, 2000)), progressive=True)
    began = time.process_time()
    assert "at most 268" in refused(many_scans(large, 300))  # 16 scans of 2**26 px, over 2000x2000
    assert time.process_time() - began < 1
    assert files.read_plane(large).width == 2000


def test_the_number_of_pixels_has_a_default_that_can_be_raised_and_lowered(monkeypatch: pytest.MonkeyPatch) -> None:
    tall = corpus.png(3, 5)
    assert "--max-pixels" in refused(flat_png(8193, 8192, 1, 0))
    assert DEFAULT_PIXELS == 1 << 26
    with files.allowing(14):
        assert "15" in refused(tall)
    with files.allowing(15):
        assert files.read_plane(tall).height == 5
    with files.allowing(8193 * 8192):
        assert files.read_plane(flat_png(8193, 8192, 1, 0)).width == 8193
    monkeypatch.setenv("INTARSIA_MAX_PIXELS", "14")
    assert "INTARSIA_MAX_PIXELS" in refused(tall)
    with pytest.raises(ParameterError, match="1 to 14"), files.allowing(15):
        pass
    for wrong in ("many", "0", "-3", "1e9", "9" * 5000, str((1 << 28) + 1)):
        monkeypatch.setenv("INTARSIA_MAX_PIXELS", wrong)
        with pytest.raises(ParameterError, match="INTARSIA_MAX_PIXELS"):
            files.read_plane(tall)


def test_every_command_that_reads_pictures_takes_max_pixels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import roles

    monkeypatch.chdir(tmp_path)
    roles.make_sound(tmp_path)
    for command in roles.READERS:
        unwritten = command in ("analyze", "score")
        words = [*roles.line(command, **({} if unwritten else {"out": f"new_{roles.GIANT}"}))]
        few = run(*words, "--max-pixels", 479, code=3).stderr
        assert len(few.splitlines()) == 1
        assert "--max-pixels" in few
        for wrong in (0, (1 << 28) + 1):
            run(*words, "--max-pixels", wrong, code=2)
    run("analyze a.png --json --max-pixels 480")
    monkeypatch.setenv("INTARSIA_MAX_PIXELS", "480")
    assert "INTARSIA_MAX_PIXELS" in run("analyze a.png --json --max-pixels 481", code=2).stderr


PALETTE = chunk(b"PLTE", bytes(range(9))) + chunk(b"tRNS", b"\x10\x20\x30")
SIDE = 3000
WORTH = {
    "rgb16.png": lambda: flat_png(SIDE, SIDE, 16, 2),
    "rgba16.png": lambda: flat_png(SIDE, SIDE, 16, 6),
    "palette.png": lambda: flat_png(SIDE, SIDE, 8, 3, PALETTE),
    "flat.webp": lambda: corpus.pillow("webp", Image.new("RGB", (SIDE, SIDE)), lossless=True, method=0),
    "flat.gif": lambda: corpus.pillow("gif", Image.new("P", (SIDE, SIDE))),
    "inks.jpg": lambda: corpus.pillow("jpeg", Image.new("CMYK", (SIDE, SIDE)), progressive=True),
    "bomb.gif": lambda: corpus.whole("gif")[:6] + b"\x88\x13\x88\x13" + corpus.whole("gif")[10:],
    "flat.tif": lambda: corpus.pillow("tiff", Image.new("RGB", (SIDE, SIDE)), compression="tiff_adobe_deflate"),
}

MEASURE = """
import resource, sys, time
import numpy, OpenImageIO, PIL.Image, PIL.GifImagePlugin, PIL.JpegImagePlugin, PIL.PngImagePlugin
from intarsia import disk, files
before, began = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
plane = files.read_plane(sys.argv[1])
grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
print(plane.height * plane.width, grown * 1024, time.process_time() - began)
"""


@pytest.mark.parametrize("name", WORTH)
def test_what_small_files_take_stays_what_is_said_of_them(name: str, tmp_path: Path) -> None:
    """A picture within the limit takes the memory that its format is reckoned with, at most; else it is refused."""
    (tmp_path / name).write_bytes(WORTH[name]())
    words = [sys.executable, "-c", MEASURE, name]
    done = subprocess.run(words, capture_output=True, text=True, check=True, cwd=tmp_path)
    pixels, grown = map(int, done.stdout.split()[:2])
    unasked = True
    with files.allowing(pixels), suppress(InputError):
        unasked = False
        files.read_plane(tmp_path / name)
        unasked = True
    room = 24 << 20  # buffers that do not grow with the picture
    assert grown - room <= (6 if unasked else 16) * pixels, grown / pixels


def test_small_files_may_not_take_much_memory_but_large_ones_may() -> None:
    """16 bit RGBA of 8192x8192 px: half a gigabyte. With real pixels in it, it is read; of nothing, it is a bomb."""
    empty = flat_png(6000, 6000, 16, 6)
    told = refused(empty)
    needed = int(told.partition("--max-pixels ")[2].split()[0])
    disk.check_decoding_cost("x", 6000 * 6000 * 16, 40 << 20)
    with files.allowing(needed):
        disk.check_decoding_cost("x", 6000 * 6000 * 16, len(empty))
    with files.allowing(needed - 1), pytest.raises(InputError):
        disk.check_decoding_cost("x", 6000 * 6000 * 16, len(empty))


def test_sides_that_a_library_does_not_take_are_told_as_such(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """libpng stops at 1,000,000 px a side, and so does every check."""
    monkeypatch.chdir(tmp_path)
    assert "1000000 px a side" in refused(flat_png(1, 1_000_001, 8, 0))
    assert files.read_plane(flat_png(1, 1_000_000, 8, 0)).height == 1_000_000
    files.write("a.png", corpus.picture())
    said = run("grow a.png -o x.png -m random-tiling --size 1x1048576 --dry-run", code=2).stderr
    assert "at most 1000000 px a side" in said
    assert "png" not in said.partition("; write ")[2]


def test_a_webp_of_the_largest_size_is_not_called_damaged() -> None:
    head = b"\x2f" + (16382 | 16382 << 14).to_bytes(4, "little") + bytes(20)
    data = b"RIFF" + (len(head) + 12).to_bytes(4, "little") + b"WEBPVP8L" + len(head).to_bytes(4, "little") + head
    assert "16383x16383 px" in refused(data)


def test_maps_are_measured_before_they_are_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half a gigabyte of zeros is half a megabyte of file."""
    (tmp_path / "m.npz").write_bytes(lying("(8000, 8000, 2)", bytes(512_000_000), zipfile.ZIP_DEFLATED))
    read = np.load
    monkeypatch.setattr(np, "load", lambda *_, **__: pytest.fail("it was unpacked"))
    with pytest.raises(InputError, match="of memory"):
        SourceMap.load(tmp_path / "m.npz")
    monkeypatch.setattr(np, "load", read)
    with files.allowing(1 << 27):
        assert SourceMap.load(tmp_path / "m.npz").height == 8000


def test_a_map_that_does_not_fit_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "m.npz").write_bytes(packed())
    monkeypatch.setattr(np, "load", Mock(side_effect=MemoryError))
    with pytest.raises(ResourceError, match="memory"):
        SourceMap.load(tmp_path / "m.npz")


@pytest.mark.parametrize(("height", "width"), [(1 << 31, 64), (1 << 63, 1), (1 << 16, (1 << 15) + 1), (64, 1 << 31)])
def test_sizes_of_exemplars_that_cannot_be_are_refused(height: int, width: int, tmp_path: Path) -> None:
    (tmp_path / "m.npz").write_bytes(source(height=height, width=width))
    with pytest.raises(InputError, match="no map"):
        SourceMap.load(tmp_path / "m.npz")


def test_counting_uses_never_ends_in_a_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    yx = np.zeros((2, 3, 2), np.int32)
    for size in ((1 << 31, 64), (1 << 63, 1), (1 << 40, 1 << 40)):
        with pytest.raises(ResourceError, match="too large to count"):
            SourceMap(yx, sources=(Source("a", *size, "0"),)).usage()
    with pytest.raises(InputError, match="outside"):
        SourceMap(yx + 5, sources=(Source("a", 3, 3, "0"),)).usage()
    assert SourceMap(yx, sources=(Source("a", 2, 2, "0"),)).usage()[0].tolist() == [[6, 0], [0, 0]]


def test_a_frozen_array_becomes_a_plane_as_it_is() -> None:
    """Pictures are read once into memory; an array that anybody can write to is copied."""
    pixels = np.zeros((4, 5, 3), np.uint8)
    assert not np.shares_memory(ia.Plane(pixels).pixels, pixels)
    view = pixels[1:]
    view.flags.writeable = False
    assert not np.shares_memory(ia.Plane(view).pixels, pixels)
    pixels.flags.writeable = False
    assert np.shares_memory(ia.Plane(pixels).pixels, pixels)
    assert os.environ.get("INTARSIA_MAX_PIXELS") is None


def test_a_tile_of_an_exr_is_no_larger_than_a_picture_may_be(tmp_path: Path) -> None:
    """A header of a tile of 30000 px a side, in a picture of 8 px and a file of nothing else."""
    path = tmp_path / "tiled.exr"
    save_exr(path, {"Y": np.zeros((8, 8))}, ("half",), tile=16)
    assert files.read_plane(path).pixels.shape == (8, 8)
    data = path.read_bytes()
    at = data.index(b"tiles\0tiledesc\0") + 19
    path.write_bytes(data[:at] + (30000).to_bytes(4, "little") * 2 + data[at + 8 :])
    with pytest.raises(InputError, match="claims 30000x30000"):
        files.read_plane(path)
