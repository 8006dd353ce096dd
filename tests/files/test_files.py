"""Pictures come back exactly as they were written, or are refused before anything is lost."""

from __future__ import annotations

import errno
import io
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from cli.commands import full_disk
from corpus import picture, pillow, tiff
from files.exrs import save_exr
from PIL import Image, ImageCms, ImageOps

import intarsia as ia
from intarsia.files import (
    check_depth,
    check_writable,
    describe,
    encode,
    group,
    read,
    read_plane,
    read_recipe,
    read_set,
    recipe_path,
    sample,
    sample_names,
    write,
    write_bytes,
)
from intarsia.files.formats import FORMATS, Format
from intarsia.files.write import convert
from intarsia.foundation import InputError, ParameterError, ResourceError
from intarsia.model.image import Kind, Plane, Transfer

RECIPE = json.dumps({"seed": 7, "method": "image-quilting", "note": 'ä \U0001f9f6 \\ "x"'})
LOSSY = ("jpeg", "hdr")
MATRIX = [(f, d, c) for f in FORMATS for d in f.dtypes for c in dict.fromkeys((*f.channels[:5], f.channels[-1]))]


def some(dtype: str, channels: int, height: int = 9, width: int = 14) -> np.ndarray:
    rng = np.random.default_rng(channels)
    shape = (height, width) if channels == 1 else (height, width, channels)
    if np.dtype(dtype).kind == "u":
        return rng.integers(0, np.iinfo(dtype).max, shape, dtype=dtype, endpoint=True)
    return (rng.random(shape) * 8 - 2).astype(dtype)


@pytest.mark.parametrize(
    ("format", "dtype", "channels"), MATRIX, ids=lambda v: v.name if isinstance(v, Format) else str(v)
)
def test_what_is_written_comes_back(format: Format, dtype: str, channels: int, tmp_path: Path) -> None:
    pixels = some(dtype, channels)
    if channels in (2, 4) and dtype != "uint32":
        pixels[:4, :, -1] = 0  # colour under alpha 0 stays
    plane = Plane(pixels, Kind.LABEL if dtype == "uint32" else Kind.COLOUR)
    path = tmp_path / f"out{format.suffixes[-1]}"
    write(path, plane, recipe=RECIPE)
    back = read_plane(path, plane.kind)
    assert back.pixels.shape == pixels.shape
    assert back.pixels.dtype == pixels.dtype
    if format.name not in LOSSY:
        np.testing.assert_array_equal(back.pixels, pixels)
    assert back.transfer is (Transfer.LINEAR if back.is_float else Transfer.SRGB)
    assert read_recipe(path) == json.loads(RECIPE)
    assert recipe_path(path).exists() is not format.text
    assert encode(plane, format.name, RECIPE) == path.read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir() if p.name.startswith(".")) == []


def test_nan_and_infinity_come_back_in_floats(tmp_path: Path) -> None:
    odd = np.array([[np.nan, np.inf, -np.inf, 1e-40, -0.0]], np.float32)
    for name in ("a.exr", "a.tif", "a.pfm"):
        write(tmp_path / name, odd)
        assert read_plane(tmp_path / name).pixels.tobytes() == odd.tobytes()


@pytest.mark.parametrize(("dtype", "channels", "name", "words"), [
    ("uint16", 3, "a.jpg", "16 bit.*--depth 8"), ("uint16", 3, "a.bmp", "bmp holds 8 bit.*.png.*--depth 8"),
    ("float32", 3, "a.png", "--depth 16"), ("uint8", 3, "a.exr", "--depth float"),
    ("float16", 3, "a.tif", ".exr.*--depth"), ("uint8", 4, "a.jpg", "alpha among them.*.png"),
    ("uint8", 2, "a.bmp", "2 .alpha"), ("uint8", 1, "a.webp", "3 or 4"),
    ("uint8", 1, "a.ppm", "3 channels"), ("uint8", 5, "a.png", ".tif"), ("float64", 3, "a.exr", "double"),
    ("uint8", 3, "a.xyz", "names no format"), ("uint8", 3, "a", "without ending"),
])  # fmt: skip
def test_what_a_format_cannot_hold_is_refused(dtype: str, channels: int, name: str, words: str, tmp_path: Path) -> None:
    plane = Plane(some(dtype, channels))
    for act in (lambda: write(tmp_path / name, plane), lambda: check_depth(tmp_path / name, plane)):
        with pytest.raises(ParameterError, match=words):
            act()
    with pytest.raises(ParameterError, match="16383"):
        write(tmp_path / "a.webp", np.zeros((1, 20000, 3), np.uint8))
    assert list(tmp_path.iterdir()) == []


def test_depths_round_to_the_nearest() -> None:
    eight, sixteen = np.arange(256, dtype=np.uint8)[None], np.arange(65536, dtype=np.uint16)[None]
    np.testing.assert_array_equal(convert(Plane(eight), 16).pixels, eight.astype(np.uint16) * 257)
    np.testing.assert_array_equal(convert(Plane(sixteen), 8).pixels[0], np.round(np.arange(65536) / 257))
    for depth in ("half", "float"):
        for kind in (Kind.COLOUR, Kind.DATA):
            there = convert(Plane(eight, kind), depth)
            assert there.transfer is Transfer.LINEAR
            np.testing.assert_array_equal(convert(there, 8).pixels, eight)
    there = convert(Plane(sixteen), "float")
    np.testing.assert_array_equal(convert(there, 16).pixels, sixteen)
    wild = Plane(np.array([[np.nan, -1.0, 2.0, np.inf, 0.5]], np.float32), Kind.DATA)
    assert convert(wild, 8).pixels.tolist() == [[0, 0, 255, 255, 128]]
    with pytest.raises(ParameterError, match="choose 8, 16, half or float"):
        convert(wild, 12)
    with pytest.raises(ParameterError, match="do not fit"):
        convert(Plane(np.array([[300]], np.uint32), Kind.LABEL), 8)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_pictures_are_turned_upright(orientation: int) -> None:
    exif = Image.Exif()
    exif[0x0112] = orientation
    for format, options in {"png": {}, "jpeg": {"subsampling": 0}, "webp": {"lossless": True}}.items():
        data = pillow(format, picture(), exif=exif, **options)
        with Image.open(io.BytesIO(data)) as image:
            np.testing.assert_array_equal(read_plane(data).pixels, np.array(ImageOps.exif_transpose(image)))
    upright = read_plane(pillow("png", picture(), exif=exif)).pixels
    np.testing.assert_array_equal(read_plane(tiff(picture(), tags={274: orientation})).pixels, upright)


def test_profiles_travel(tmp_path: Path) -> None:
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    (tmp_path / "in.png").write_bytes(pillow("png", picture(), icc_profile=profile))
    plane = read_plane(tmp_path / "in.png")
    assert plane.meta["icc"] == profile
    for name in ("a.png", "a.tif", "a.jpg", "a.webp"):
        write(tmp_path / name, plane)
        assert read_plane(tmp_path / name).meta["icc"] == profile
    write(tmp_path / "a.bmp", plane)
    assert "icc" not in read_plane(tmp_path / "a.bmp").meta


def test_netpbm_values() -> None:
    assert read_plane(b"P5 3 1 65535 \0\0\1\xf4\3\xe8").pixels.tolist() == [[0, 500, 1000]]
    assert read_plane(b"P5 2 1 255 ##").pixels.tolist() == [[35, 35]]
    assert read_plane(b"P6#a\n1 #b\n1\n255\n\1\2\3").pixels.tolist() == [[[1, 2, 3]]]
    rows = np.array([[1, 2], [3, 4]], "<f4")
    assert read_plane(b"Pf 2 2 -1.0\n" + rows[::-1].tobytes()).pixels.tolist() == rows.tolist()
    assert read_plane(b"Pf 2 2 1\n" + rows[::-1].astype(">f4").tobytes()).pixels.tolist() == rows.tolist()
    large = np.arange(2000 * 1500, dtype="<f4").reshape(2000, 1500)
    assert (read_plane(b"Pf 1500 2000 -1\n" + large[::-1].tobytes()).pixels == large).all()


@pytest.mark.parametrize("data", [
    b"P2 3 1 255 0 3 9", b"P5 3 1 1000 \0\0\1\xf4\3\xe8", b"P1 3 1 101", b"P4 9 1 \x80\x80", b"P5 1 1 1 \1",
    b"P5 2 1 255\r\n\1\2", b"P5 2 1 255#c\n\1\2", b"Pf 1 1 2.5\n" + bytes(4),
])  # fmt: skip
def test_netpbm_that_would_be_read_wrongly_is_refused(data: bytes) -> None:
    """Rather than read with other values than it has."""
    with pytest.raises(InputError, match=r"is a netpbm picture that is not read: .*; save it as PNG"):
        read_plane(data)


def test_one_bit_palettes_and_inks_become_full_pixels() -> None:
    base = Image.fromarray(picture())
    assert set(np.unique(read_plane(pillow("png", base.convert("1"))).pixels)) == {0, 255}
    palette = base.quantize(16)
    np.testing.assert_array_equal(read_plane(pillow("png", palette)).pixels, np.array(palette.convert("RGB")))
    assert read_plane(pillow("png", palette, transparency=0)).channels == 4
    data = pillow("jpeg", base.convert("CMYK"))
    with Image.open(io.BytesIO(data)) as image:
        np.testing.assert_array_equal(read_plane(data).pixels, np.array(image.convert("RGB")))


def test_channels_of_an_exr_are_found_by_name(tmp_path: Path) -> None:
    for names, order in (
        (("Z", "A", "B", "G", "R"), [4, 3, 2, 1]), (("Z", "Y", "A"), [1, 2]), (("v1", "v2", "v3"), [0, 1, 2]),
        (("diff.B", "diff.G", "diff.R", "N.X", "N.Y", "N.Z"), [2, 1, 0]),
    ):  # fmt: skip
        values = some("float32", len(names))
        save_exr(tmp_path / "a.exr", dict(zip(names, np.moveaxis(values, 2, 0), strict=True)))
        np.testing.assert_array_equal(read_plane(tmp_path / "a.exr").pixels, values[:, :, order])


def test_standard_output_and_input(tmp_path: Path) -> None:
    code = "import sys, numpy as np; from intarsia.files import read_plane, write;p = read_plane('-'); write('-', p)"
    data = pillow("png", picture())
    done = subprocess.run([sys.executable, "-c", code], input=data, capture_output=True, check=True)
    assert done.stderr == b""
    np.testing.assert_array_equal(read_plane(done.stdout).pixels, picture())


# --- writing whole or not at all


@pytest.mark.parametrize("where", ["os.fsync", "os.replace"])
@pytest.mark.parametrize(
    "error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt(), PermissionError(1, "no")]
)
@pytest.mark.parametrize("name", ["a.png", "a.bmp"])
def test_a_failed_write_changes_nothing(
    where: str, error: BaseException, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / name).write_bytes(b"old")
    monkeypatch.setattr(where, Mock(side_effect=error))
    with pytest.raises(ResourceError if isinstance(error, OSError) else KeyboardInterrupt):
        write(tmp_path / name, picture(), recipe=RECIPE, force=True)
    assert [p.name for p in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_bytes() == b"old"


@pytest.mark.parametrize("format", FORMATS, ids=lambda f: f.name)
def test_a_full_disk_is_told(format: Format, tmp_path: Path) -> None:
    channels = format.channels[-1] if len(format.channels) < 9 else 3
    plane = Plane(some(format.dtypes[-1], channels, 200, 200), Kind.LABEL)
    (tmp_path / f"a{format.suffixes[0]}").write_bytes(b"old")
    with full_disk(8192), pytest.raises(ResourceError, match="room") as caught:
        write(tmp_path / f"a{format.suffixes[0]}", plane, force=True)
    assert "\n" not in str(caught.value)
    assert [p.read_bytes() for p in tmp_path.iterdir()] == [b"old"]


def test_nothing_is_overwritten_unless_asked(tmp_path: Path) -> None:
    path = tmp_path / "a.bmp"
    write(path, picture(), recipe=RECIPE)
    before = path.read_bytes()
    with pytest.raises(ParameterError, match="--force"):
        write(path, picture() // 2)
    assert path.read_bytes() == before
    write(path, picture() // 2, force=True)
    assert path.read_bytes() != before
    assert read_recipe(path) is None  # that of the former picture is gone
    path.unlink()
    recipe_path(path).write_text("{}")
    with pytest.raises(ParameterError, match=r"recipe.json exists"):
        write(path, picture(), recipe=RECIPE)
    assert not path.exists()


def test_places_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for path, error, words in (
        (tmp_path / "no" / "a.png", InputError, "does not exist"), (tmp_path, ParameterError, "is a folder"),
        ("/dev/null", ParameterError, "no ordinary file"), (tmp_path / ("x" * 300 + ".png"), InputError, None),
        (tmp_path / "a\0.png", InputError, None), ("", ParameterError, None),
    ):  # fmt: skip
        with pytest.raises(error, match=words):
            check_writable(path, path in (tmp_path, "/dev/null"))
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(ResourceError, match="cannot be written"):
        check_writable(tmp_path / "a.png")


def test_links_are_followed_and_modes_kept(tmp_path: Path) -> None:
    real = tmp_path / "real.json"
    real.write_bytes(b"old")
    real.chmod(0o640)
    (tmp_path / "link.json").symlink_to(real)
    write_bytes(tmp_path / "link.json", b"new", force=True)
    assert real.read_bytes() == b"new"
    assert (tmp_path / "link.json").is_symlink()
    assert real.stat().st_mode & 0o777 == 0o640


def test_nothing_embedded_tells_time_or_place(tmp_path: Path) -> None:
    for format in FORMATS:
        if format.text:
            data = encode(Plane(some(format.dtypes[0], 3)), format.name, RECIPE)
            for word in (b"OpenImageIO", b"Software", b"DateTime", b"/tmp", str(tmp_path).encode()):
                assert word not in data, (format.name, word)


def test_long_recipes_and_damaged_ones(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).integers(0, 256, (500, 700, 3), dtype=np.uint8)
    fits, long = (json.dumps({"x": "y" * count}) for count in (59_000, 200_000))
    for name, pixels, recipe in (("n.jpg", noise, fits), *((f"a.{e}", picture(), long) for e in ("jpg", "png", "tif"))):
        write(tmp_path / name, pixels, recipe=recipe)
        assert read_recipe(tmp_path / name) == json.loads(recipe)
    assert [recipe_path(tmp_path / name).exists() for name in ("n.jpg", "a.jpg")] == [False, True]
    assert read_recipe(recipe_path(tmp_path / "a.jpg")) == json.loads(long)
    (tmp_path / "b.recipe.json").write_text("[1")
    with pytest.raises(InputError, match="damaged"):
        read_recipe(tmp_path / "b.recipe.json")
    with pytest.raises(InputError, match="does not exist"):
        read_recipe(tmp_path / "c.json")


# --- exemplars


def put(folder: Path, name: str, pixels: np.ndarray) -> Path:
    (folder / name).write_bytes(pillow("png", pixels))
    return folder / name


def test_an_exemplar_of_several_maps(tmp_path: Path) -> None:
    base = put(tmp_path, "moss_albedo.png", picture())
    normal = put(tmp_path, "moss_nor_dx.png", np.dstack([picture(), np.full((20, 24), 255, np.uint8)]))
    write(tmp_path / "moss_height.exr", some("float32", 1, 40, 48))
    moss = read(base, height=tmp_path / "moss_height.exr", normal=normal)
    assert list(moss.planes) == ["albedo", "height", "normal"]
    assert moss.planes["height"].kind is Kind.DATA
    assert moss.planes["height"].pixels.dtype == np.float32
    assert moss.planes["normal"].kind is Kind.NORMAL
    assert moss.planes["normal"].meta["normals"] == "dx"
    assert moss.name == "moss"


@pytest.mark.parametrize("make", [
    lambda m: m.astype(np.uint8) * 255, lambda m: m.astype(np.uint8), lambda m: Image.fromarray(m),
    lambda m: np.dstack([m.astype(np.uint8) * 255] * 3), lambda m: m.astype(np.uint16) * 65535,
    lambda m: np.dstack([np.full(m.shape, 255, np.uint8), m.astype(np.uint8) * 255]),
])  # fmt: skip
def test_masks_of_any_kind(make: Any, tmp_path: Path) -> None:
    wanted = np.indices((20, 24)).sum(0) % 3 > 0
    exemplar = read(put(tmp_path, "a.png", picture()), mask=put(tmp_path, "m.png", make(wanted)))
    assert exemplar.usable is not None
    np.testing.assert_array_equal(exemplar.usable, wanted)


def test_float_masks_and_masks_in_sets(tmp_path: Path) -> None:
    wanted = np.indices((20, 24)).sum(0) % 3 > 0
    write(tmp_path / "a_mask.tif", np.where(wanted, np.float32(0.8), np.float32(np.nan)))
    exemplar = read_set({"albedo": put(tmp_path, "a.png", picture()), "mask": tmp_path / "a_mask.tif"})
    assert exemplar.usable is not None
    np.testing.assert_array_equal(exemplar.usable, wanted)
    with pytest.raises(InputError, match="alone"):
        read_set({"mask": tmp_path / "a_mask.tif"})


def test_alpha_is_a_channel_or_a_mask(tmp_path: Path) -> None:
    pixels = picture(channels=4)
    pixels[..., 3] = 255
    pixels[:5, :, 3] = 0
    path = put(tmp_path, "a.png", pixels)
    for alpha in ("auto", "mask"):
        exemplar = read(path, alpha=alpha)
        assert exemplar.base.channels == 3
        assert exemplar.usable is not None
        np.testing.assert_array_equal(exemplar.usable, pixels[..., 3] == 255)
    kept = read(path, alpha="channel")
    assert kept.usable is None
    np.testing.assert_array_equal(kept.base.pixels, pixels)
    pixels[:12, :, 3] = 0  # opaque in less than half
    assert read(put(tmp_path, "b.png", pixels)).base.channels == 4
    pixels[..., 3] = 255
    pixels[0, 0, 3] = 128  # partly transparent
    assert read(put(tmp_path, "c.png", pixels)).base.channels == 4
    pixels[..., 3] = 255
    assert read(put(tmp_path, "d.png", pixels)).base.channels == 4
    with pytest.raises(ParameterError, match="auto, channel, mask"):
        read(path, alpha="yes")
    with pytest.raises(InputError, match="no alpha"):
        read(put(tmp_path, "e.png", picture()), alpha="mask")


def test_a_normal_map_of_two_channels_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="needs 3"):
        read(put(tmp_path, "a.png", picture()), normal=put(tmp_path, "n.png", picture(channels=2)))


# --- sets


def names(sets: list[dict[str, Any]]) -> list[dict[str, str]]:
    return [{k: Path(v).name for k, v in s.items()} for s in sets]


@pytest.mark.parametrize(("files", "expected"), [
    ("moss_albedo.png moss_nor_gl.png moss_rough.png moss_disp.exr", "albedo normal roughness height"),
    ("moss_diff_2k.png moss_nor_gl_2k.exr moss_arm_2k.png", "albedo normal arm"),
    ("Bricks7_1K-JPG_Color.jpg Bricks7_1K-JPG_NormalGL.jpg Bricks7_1K-JPG_AmbientOcclusion.jpg", "albedo normal ao"),
    ("a.albedo.png a.normal.png a.mask.png", "albedo normal mask"),
    ("wood.png wood_normal.png wood-Metalness.png wood_emissive.png wood_gloss.png wood_opacity.png",
     "albedo normal metallic opacity emission specular"),
    ("albedo.png height.png", "albedo height"),
])  # fmt: skip
def test_sets_are_recognised(files: str, expected: str) -> None:
    found = group(reversed(files.split()))
    assert len(found) == 1
    assert list(found[0]) == expected.split()


@pytest.mark.parametrize(("how", "files", "sets"), [
    ("auto", "a.png b.png", [{"albedo": "a.png"}, {"albedo": "b.png"}]),
    ("auto", "a/x.png b/x.png", [{"albedo": "x.png"}, {"albedo": "x.png"}]),
    ("set", "a_albedo.png b_height.png", [{"albedo": "a_albedo.png", "height": "b_height.png"}]),
    ("several", "a_albedo.png a_height.png", [{"albedo": "a_albedo.png"}, {"albedo": "a_height.png"}]),
    ("auto", "old_metal.png", [{"albedo": "old_metal.png"}]),
    ("auto", "old_normal.png", [{"normal": "old_normal.png"}]),
    ("auto", "sample:brick sample:tiles -", [{"albedo": name} for name in ("sample:brick", "sample:tiles", "-")]),
    ("auto", "a_col.png a_NormalDX.png a_NormalGL.png", [{"albedo": "a_col.png", "normal": "a_NormalGL.png"}]),
])  # fmt: skip
def test_stems_and_ways_to_read(how: str, files: str, sets: list[dict[str, str]]) -> None:
    assert names(group(files.split(), how)) == sets


def test_two_files_of_a_plane_and_unknown_ways_are_refused() -> None:
    with pytest.raises(InputError, match="both are the height"):
        group(["a_height.png", "a_disp.png"])
    with pytest.raises(ParameterError, match="auto, set or several"):
        group([], "all")


def test_a_folder_is_one_set(tmp_path: Path) -> None:
    for name in ("x_albedo.png", "x_nrm_dx.png", "preview.png"):
        put(tmp_path, name, picture())
    (tmp_path / "readme.txt").write_text("x")
    found = group([tmp_path])
    assert names(found) == [{"albedo": "x_albedo.png", "normal": "x_nrm_dx.png"}]
    said = "exemplar 1: one set of 2 maps: albedo x_albedo.png, normal x_nrm_dx.png (DirectX normals)"
    assert describe(found) == said
    assert read_set(found[0]).planes["normal"].meta["normals"] == "dx"
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="no picture"):
        group([tmp_path / "empty"])


# --- samples and previews


@pytest.mark.parametrize("name", sample_names())
def test_samples(name: str) -> None:
    plane = read_plane(f"sample:{name}")
    assert plane.pixels.dtype == np.uint8
    assert min(plane.pixels.shape[:2]) >= 256
    assert plane.pixels.std() > 15
    np.testing.assert_array_equal(read(f"sample:{name}").base.pixels, sample(name).pixels)
    assert read(f"sample:{name}").name == f"sample:{name}"


@pytest.mark.parametrize("plane", [
    Plane(picture()), Plane(picture(channels=2)), Plane(picture(channels=7), Kind.DATA), Plane(some("uint16", 3)),
    Plane(some("float32", 3), transfer=Transfer.LINEAR), Plane(some("float16", 1), Kind.DATA),
    Plane(some("float64", 4)),
    Plane(np.array([[np.nan, 1, 5]], np.float32), Kind.DATA), Plane(np.array([[True, False]]), Kind.LABEL),
    Plane(some("uint32", 1), Kind.LABEL), Plane(some("uint32", 3), Kind.LABEL), Plane(picture(channels=1), Kind.LABEL),
    Plane(picture(), Kind.NORMAL), Plane(some("float32", 1), Kind.LABEL),
])  # fmt: skip
def test_previews(plane: Plane) -> None:
    with Image.open(io.BytesIO(plane._repr_png_())) as image:
        assert image.size == (plane.width, plane.height)


def test_a_notebook_shows_a_synthesis_as_its_picture() -> None:
    made = ia.synthesize(picture(), 40, ia.ImageQuilting(patch=8))
    with Image.open(io.BytesIO(made._repr_png_())) as image:
        assert np.array_equal(np.asarray(image), made.render().pixels)


def test_importing_files_is_cheap() -> None:
    code = "import sys, intarsia.files; print([m for m in ('OpenImageIO', 'PIL', 'skimage') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
