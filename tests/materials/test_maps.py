"""Proposed maps: heights come back from normals, what tiles goes on tiling, what is flat stays flat."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli.commands import run, told

import intarsia as ia
from intarsia.files import group, read_set

TEXTURES = os.environ.get("INTARSIA_TEXTURES", "")


def hills(wrap: bool, height: int = 48, width: int = 64) -> np.ndarray:
    """A smooth surface from 0.2 to 0.8, without a slope from border to border."""
    y, x = np.mgrid[:height, :width]
    y, x = (y + 0.5) / height, (x + 0.5) / width
    turn = 2 * np.pi if wrap else np.pi
    surface = np.cos(2 * turn * y + 0.4 * wrap) * np.cos(4 * turn * x) + 0.5 * np.cos(2 * turn * (x + y) * wrap)
    found: np.ndarray = 0.5 + 0.3 * surface / np.abs(surface).max()
    return found


def photograph(height: int = 64, width: int = 80, dtype: Any = np.uint8) -> np.ndarray:
    """Noise of all widths, which wraps."""
    rng = np.random.default_rng(5)
    waves = np.fft.fft2(rng.standard_normal((height, width, 3)), axes=(0, 1))
    far = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width)) + 0.02
    noise = np.fft.ifft2(waves / far[..., None], axes=(0, 1)).real
    noise = (noise - noise.min()) / np.ptp(noise)
    return (noise * np.iinfo(dtype).max).astype(dtype)


def bricks(joint: int, brick: int) -> np.ndarray:
    y, x = np.mgrid[:96, :96]
    here = (y % 16 < 3) | ((x + 12 * (y // 16 % 2)) % 24 < 3)
    return np.where(here, joint, brick + (7 * x + 13 * y) % 9).astype(np.uint8)


def lengths(normal: ia.Plane) -> np.ndarray:
    top = np.iinfo(normal.pixels.dtype).max
    found: np.ndarray = np.linalg.norm(normal.pixels / top * 2 - 1, axis=2)
    return found


@pytest.mark.parametrize("wrap", [True, False])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_heights_come_back_from_their_normals(wrap: bool, dtype: Any) -> None:
    """But for a constant and an overall slope; also of floats, and of normals whose green points down."""
    given = hills(wrap) * (1 if dtype == np.float32 else np.iinfo(dtype).max)
    height = ia.Plane(given.astype(dtype), "data")
    normal = ia.normal_of(height, wrap=wrap)
    assert np.abs(lengths(normal) - 1).max() < 1e-4
    flipped = normal.pixels.copy()
    flipped[..., 1] = 65535 - flipped[..., 1]
    for plane in (normal, ia.Plane(flipped, "normal", meta={"normals": "dx"})):
        off = ia.height_of(plane, wrap=wrap).pixels / 65535 - hills(wrap)
        assert np.abs(off - off.mean()).max() < (0.004 if dtype == np.uint8 else 3e-4)


def test_slopes_point_as_opengl_has_them() -> None:
    """What rises to the right faces left; what rises upwards in the picture faces down, and green points up."""
    rise = np.tile(np.linspace(0, 1, 64), (64, 1))
    right = ia.normal_of(ia.Plane(rise, "data")).pixels[32, 32].astype(int) - 32768
    up = ia.normal_of(ia.Plane(np.rot90(rise), "data")).pixels[32, 32].astype(int) - 32768
    assert right[0] < -900
    assert up[1] < -900
    assert abs(right[1]) <= 1
    steep = ia.normal_of(ia.Plane(rise, "data"), strength=4).pixels[32, 32].astype(int) - 32768
    slope = [-n[0] / n[2] for n in (right, steep)]
    assert math.isclose(slope[1], 4 * slope[0], rel_tol=0.01)
    assert math.isclose(slope[0], 64 / 32 / 63, rel_tol=0.01), "white lies 1/32 of the side above black"


def test_a_tall_surface_is_lowered_into_the_range() -> None:
    tall = ia.normal_of(ia.Plane(hills(True), "data"), strength=5, wrap=True)
    found = ia.height_of(tall, wrap=True).pixels.astype(int)
    assert found.min() <= 1
    assert found.max() == 65535
    off = found / 65535 - (hills(True) - 0.5) / 0.6
    assert np.abs(off - off.mean()).max() < 0.02


def test_what_tiles_is_proposed_as_the_same_wherever_it_is_cut() -> None:
    """Maps of a toroidal picture that is rolled are the maps, rolled; so all are continuous across the borders."""
    given = photograph()
    made = ia.proposed(ia.Exemplar.of(given, toroidal=True)).planes
    rolled = ia.proposed(ia.Exemplar.of(np.roll(given, (13, 29), (0, 1)), toroidal=True)).planes
    assert list(made) == ["albedo", "height", "normal", "roughness"]
    for name, plane in made.items():
        assert np.array_equal(np.roll(plane.pixels, (13, 29), (0, 1)), rolled[name].pixels), name
    mirrored = ia.proposed(ia.Exemplar.of(given)).planes["height"].pixels
    assert not np.array_equal(mirrored, made["height"].pixels)


@pytest.mark.parametrize("shape", [(40, 50, 3), (40, 50), (1, 1, 3), (3, 200), (40, 50, 4)])
def test_a_flat_picture_gives_flat_maps(shape: tuple[int, ...]) -> None:
    made = ia.proposed(ia.Exemplar.of(np.full(shape, 77, np.uint8))).planes
    assert (made["height"].pixels == 32768).all()
    assert (made["normal"].pixels == (128, 128, 255)).all()
    assert np.ptp(made["roughness"].pixels) == 0


@pytest.mark.parametrize(("dtype", "kept"), [(np.uint8, np.uint8), (np.uint16, np.uint16), (np.float32, np.uint16)])
def test_depth_is_kept_and_heights_have_16_bits(dtype: Any, kept: Any) -> None:
    whole = photograph(dtype=np.uint16)
    given = whole / np.float32(65535) if dtype == np.float32 else (whole >> (8 * (dtype == np.uint8))).astype(dtype)
    made = ia.proposed(ia.Exemplar.of(ia.Plane(given.astype(dtype), "colour"))).planes
    assert made["height"].pixels.dtype == np.uint16
    assert {made[n].pixels.dtype for n in ("normal", "roughness")} == {np.dtype(kept)}
    assert all("proposed" in made[n].meta for n in ("height", "normal", "roughness"))
    assert "proposed" not in made["albedo"].meta
    assert np.abs(lengths(made["normal"]) - 1).max() < 0.02
    assert len(np.unique(made["height"].pixels)) > 1000


@pytest.mark.parametrize(("joint", "brick", "words"), [(40, 150, "dark lies deep"), (220, 90, "light lies deep")])
def test_joints_lie_deep_dark_ones_and_light_ones(joint: int, brick: int, words: str) -> None:
    given = bricks(joint, brick)
    made = ia.proposed(ia.Exemplar.of(given)).planes["height"]
    assert words in made.meta["proposed"]
    joints, faces = made.pixels[1::16], made.pixels[9::16, 14:22]
    assert joints.mean() < faces.mean() - 6000
    turned = ia.proposed(ia.Exemplar.of(given), strength=-1).planes
    assert np.array_equal(65535 - turned["height"].pixels, made.pixels)
    usual = ia.proposed(ia.Exemplar.of(given)).planes["normal"].pixels[..., :2].astype(int)
    assert np.abs(256 - usual - turned["normal"].pixels[..., :2]).max() <= 1


def test_what_is_dark_or_uneven_is_rough() -> None:
    given = np.full((64, 96), 200, np.uint8)
    given[:, 32:64] = 60
    given[:, 64:] = np.where(np.indices((64, 32)).sum(0) % 2, 255, 145)
    rough = ia.proposed(ia.Exemplar.of(given, toroidal=True)).planes["roughness"].pixels
    light, dark, uneven = (int(np.median(rough[:, k + 8 : k + 24])) for k in (0, 32, 64))
    assert light < dark
    assert light < uneven


def test_only_what_is_missing_is_proposed() -> None:
    base, height = photograph(), (hills(True, 64, 80) * 255).astype(np.uint8)
    normal = ia.normal_of(ia.Plane(height, "data")).pixels
    with_height = ia.proposed(ia.Exemplar.of({"albedo": base, "height": height}))
    assert list(with_height.planes) == ["albedo", "height", "normal"]
    assert np.array_equal(with_height.base.pixels, base), "its light stays"
    with_normal = ia.proposed(ia.Exemplar.of({"albedo": base, "normal": normal}))
    assert list(with_normal.planes) == ["albedo", "normal", "height"]
    both = ia.proposed(ia.Exemplar.of({"albedo": base, "normal": normal, "height": height}))
    assert list(both.planes) == ["albedo", "normal", "height", "roughness"]
    with pytest.raises(ia.InputError, match="lacks no map"):
        ia.proposed(both)
    with pytest.raises(ia.InputError, match="another kind"):
        ia.height_of(ia.Plane(base))
    with pytest.raises(ia.ParameterError, match="give -100 to 100"):
        ia.proposed(ia.Exemplar.of(base), strength=math.nan)


def test_a_slope_of_light_is_taken_out_of_a_lone_photograph() -> None:
    lit = (photograph() * np.linspace(0.4, 1, 80)[None, :, None]).astype(np.uint8)
    made = ia.proposed(ia.Exemplar.of(lit))
    assert np.array_equal(made.base.pixels, ia.flattened(ia.Exemplar.of(lit)).base.pixels)


def test_even_light_stays_as_it_is() -> None:
    """What a surface fits to it by chance is texture."""
    even = photograph()
    assert np.array_equal(ia.proposed(ia.Exemplar.of(even)).base.pixels, even)


def test_proposed_maps_are_drawn_but_not_compared(tmp_path: Path) -> None:
    """They tell nothing that the photograph does not: the same pieces are taken with and without them."""
    made = ia.proposed(ia.Exemplar.of(photograph()))
    assert made.compared == ("albedo",)
    assert replace(made, weights={"height": 1.0}).compared == ("albedo", "height")
    grown, alone = (ia.synthesize(e, 96, "image-quilting", seed=3) for e in (made, ia.Exemplar.of(photograph())))
    assert np.array_equal(grown.map.yx, alone.map.yx)
    assert grown.recipe["exemplars"][0]["weights"] == {"height": 0.0, "normal": 0.0, "roughness": 0.0}
    for name, plane in made.planes.items():
        ia.write(tmp_path / f"x_{name}{'_proposed' * (name != 'albedo')}.png", plane)
    (found,) = group([tmp_path])
    assert read_set(found).compared == ("albedo",)


def test_the_command_writes_a_set_that_is_read_as_one_material(tmp_path: Path) -> None:
    ia.write(tmp_path / "moss.png", photograph(dtype=np.uint16))
    said = told("maps", tmp_path / "moss.png", "-o", f"{tmp_path}/set/")
    names = {f"moss_{n}.png" for n in ("albedo", "height_proposed", "normal_proposed", "roughness_proposed")}
    assert {Path(path).name for path in said["files"]} == names == {p.name for p in (tmp_path / "set").iterdir()}
    assert any("height: proposed, bands of brightness" in line for line in said["told"])
    (found,) = group([tmp_path / "set"])
    read = read_set(found)
    assert list(read.planes) == ["albedo", "normal", "roughness", "height"]
    assert [n for n, plane in read.planes.items() if "proposed" in plane.meta] == ["normal", "roughness", "height"]
    assert {str(plane.pixels.dtype) for plane in read.planes.values()} == {"uint16"}
    grown = tmp_path / "big.png"
    run("grow", tmp_path / "set", "-o", grown, "--size", "96", "--method", "image-quilting", "--patch", "16")
    assert (tmp_path / "big_height_proposed.png").is_file(), "the mark is kept"


def test_a_result_that_tiles_has_maps_that_tile(tmp_path: Path) -> None:
    """By its recipe; the option says it of any other picture."""
    ia.write(tmp_path / "moss.png", photograph())
    quilted = "--size", "96", "--wrap", "both", "--method", "image-quilting", "--patch", "16"
    run("grow", tmp_path / "moss.png", "-o", tmp_path / "big.png", *quilted)
    run("maps", tmp_path / "big.png", "-o", tmp_path / "a")
    ia.write(tmp_path / "bare.png", ia.read(tmp_path / "big.png").base.pixels)
    run("maps", tmp_path / "bare.png", "-o", tmp_path / "b", "--toroidal")
    run("maps", tmp_path / "bare.png", "-o", tmp_path / "c")
    a, b, c = (ia.read(tmp_path / f"{n}_normal_proposed.png").base.pixels for n in "abc")
    assert np.array_equal(a, b)
    assert not np.array_equal(a, c)


def test_nothing_half_is_written_and_refusals_are_one_line(tmp_path: Path) -> None:
    ia.write(tmp_path / "moss.png", photograph())
    (tmp_path / "set").mkdir()
    (tmp_path / "set" / "moss_normal_proposed.png").write_bytes(b"mine")
    said = run("maps", tmp_path / "moss.png", "-o", f"{tmp_path}/set/", code=2).stderr
    assert "moss_normal_proposed.png" in said
    assert len(said.splitlines()) == 1
    assert [p.name for p in (tmp_path / "set").iterdir()] == ["moss_normal_proposed.png"]
    run("maps", tmp_path / "moss.png", "-o", f"{tmp_path}/set/", "--force")
    assert len(list((tmp_path / "set").iterdir())) == 4
    assert "a set does not fit into a pipe" in run("maps", tmp_path / "moss.png", "-o", "-", code=2).stderr
    assert "lacks no map" in run("maps", tmp_path / "set", "-o", f"{tmp_path}/again/", code=3).stderr


PHOTOGRAPHS = {
    "near-regular_brick-large_256": "light", "near-regular_brick-gray_192": "light", "irregular_flagstone_320": "light",
    "near-regular_brick-wall_256": "light", "near-regular_fan-cobble_384": "dark", "irregular_pebbles_256": "dark",
    "near-regular_stone-blocks_416": "dark", "near-stochastic_bark_256": "dark",
    "near-regular_burlap-cloth_256": "dark", "stochastic_grass-gray_192": "dark", "near-stochastic_rock_320": "dark",
}  # fmt: skip


@pytest.mark.skipif(not TEXTURES, reason="INTARSIA_TEXTURES names no folder of photographs")
@pytest.mark.parametrize("name", PHOTOGRAPHS)
def test_photographs_are_plausible(name: str) -> None:
    """Joints lie deep, light ones too; half of the surface leans less than 25 degrees, hardly any more than 65."""
    made = ia.proposed(ia.read(f"{TEXTURES}/{name}.png")).planes
    assert f"{PHOTOGRAPHS[name]} lies deep" in made["height"].meta["proposed"]
    up = made["normal"].pixels[..., 2] / np.iinfo(made["normal"].pixels.dtype).max * 2 - 1
    lean = np.degrees(np.arccos(np.clip(up, -1, 1)))
    assert np.median(lean) < 25
    assert np.quantile(lean, 0.9) > 3
    assert np.quantile(lean, 0.99) < 65
    assert 0.1 < np.ptp(made["height"].pixels.astype(float)) / 65535 <= 1
