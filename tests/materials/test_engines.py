"""Materials for engines: names, packing and green, pixel by pixel; nothing is written by halves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli.commands import full_disk, run, told

import intarsia as ia
from intarsia.materials.engines import turned

RNG = np.random.default_rng(3)
SHAPE = (24, 30)


def noise(*more: int, dtype: Any = np.uint8) -> np.ndarray:
    return RNG.integers(0, np.iinfo(dtype).max, (*SHAPE, *more), dtype, endpoint=True)


ALBEDO, NORMAL, ROUGH, METAL, AO = noise(3), noise(3), noise(), noise(), noise()
HEIGHT = noise(dtype=np.uint16)
WHOLE = {"albedo": ALBEDO, "normal": NORMAL, "roughness": ROUGH, "metallic": METAL, "ao": AO, "height": HEIGHT}


def package(engine: str, **planes: Any) -> dict[str, np.ndarray]:
    found, _ = ia.for_engine(ia.Exemplar.of(planes or WHOLE, name="stone"), engine)
    return {name: plane.pixels for name, plane in found.items()}


def test_unreal_has_green_down_and_orm() -> None:
    made = package("unreal")
    assert made.keys() == {"T_stone_BC.png", "T_stone_N.png", "T_stone_ORM.png", "T_stone_H.png"}
    assert np.array_equal(made["T_stone_BC.png"], ALBEDO)
    assert np.array_equal(made["T_stone_ORM.png"], np.dstack([AO, ROUGH, METAL]))
    assert np.array_equal(made["T_stone_H.png"], HEIGHT)
    assert np.array_equal(made["T_stone_N.png"][..., 1], 255 - NORMAL[..., 1])
    assert np.array_equal(made["T_stone_N.png"][..., ::2], NORMAL[..., ::2])


def test_unity_has_a_mask_map_with_smoothness() -> None:
    made = package("unity")
    assert made.keys() == {"stone_BaseMap.png", "stone_Normal.png", "stone_MaskMap.png", "stone_Height.png"}
    assert np.array_equal(made["stone_MaskMap.png"], np.dstack([METAL, AO, np.full(SHAPE, 255, np.uint8), 255 - ROUGH]))
    assert np.array_equal(made["stone_Normal.png"], NORMAL)


def test_godot_blender_and_gltf() -> None:
    orm = np.dstack([AO, ROUGH, METAL])
    godot, gltf = package("godot"), package("gltf")
    assert godot.keys() == {f"stone_{n}.png" for n in ("albedo", "normal", "orm", "height")}
    assert gltf.keys() == {f"stone_{n}.png" for n in ("baseColor", "normal", "occlusionRoughnessMetallic", "height")}
    assert np.array_equal(godot["stone_orm.png"], orm)
    assert np.array_equal(gltf["stone_occlusionRoughnessMetallic.png"], orm)
    assert np.array_equal(godot["stone_normal.png"], NORMAL)
    blender = package("blender")
    names = {"albedo": "base_color"}
    assert blender.keys() == {f"stone_{names.get(n, n)}.png" for n in WHOLE}
    for name, pixels in WHOLE.items():
        assert np.array_equal(blender[f"stone_{names.get(name, name)}.png"], pixels)


def test_what_is_missing_is_filled_as_usual_and_told() -> None:
    given = ia.Exemplar.of({"albedo": ALBEDO, "roughness": ROUGH}, name="x")
    found, told_of = ia.for_engine(given, "unreal")
    assert found.keys() == {"T_x_BC.png", "T_x_ORM.png"}
    orm = found["T_x_ORM.png"].pixels
    assert [np.unique(orm[..., k]).tolist() for k in (0, 2)] == [[255], [0]]
    assert "missing: normal, height, ao, metallic" in told_of
    assert any(line.endswith("without a map metallic and smoothness are black, others white") for line in told_of)
    assert list(package("unity", albedo=ALBEDO)) == ["stone_BaseMap.png"]
    metal = package("unity", albedo=ALBEDO, metallic=METAL)["stone_MaskMap.png"]
    assert (metal[..., 3] == 0).all(), "without roughness it is matt"


def test_packed_maps_have_the_largest_depth_and_size_among_theirs() -> None:
    fine = RNG.integers(0, 65535, (2 * SHAPE[0], 2 * SHAPE[1])).astype(np.uint16)
    made = package("godot", albedo=ALBEDO, roughness=fine, ao=AO)["stone_orm.png"]
    assert made.dtype == np.uint16
    assert np.array_equal(made[..., 1], fine)
    assert np.array_equal(made[::2, ::2, 0], AO.astype(np.uint16) * 257)
    assert np.array_equal(made[1::2, 1::2, 0], AO.astype(np.uint16) * 257)
    share = (ROUGH / 255).astype(np.float32)
    floats = package("unity", albedo=ALBEDO, roughness=share)
    assert np.array_equal(floats["stone_MaskMap.exr"][..., 3], 1 - share)
    assert (floats["stone_MaskMap.exr"][..., 1] == 1).all()


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_green_is_turned_exactly_and_back(dtype: Any) -> None:
    codes = noise(3, dtype=np.uint16) if dtype == np.uint16 else noise(3)
    given = ia.Plane(codes / np.float32(256) if dtype == np.float32 else codes, "normal")
    made = turned(given, "dx")
    top = 1 if dtype == np.float32 else np.iinfo(dtype).max
    assert np.array_equal(made.pixels[..., 1], top - given.pixels[..., 1])
    assert np.array_equal(made.pixels[..., ::2], given.pixels[..., ::2])
    assert made.meta["normals"] == "dx"
    assert np.array_equal(turned(made, "gl").pixels, given.pixels)
    signed = ia.Plane(codes.astype(np.float32) - 100, "normal")
    assert np.array_equal(turned(signed, "dx").pixels[..., 1], -signed.pixels[..., 1])


def test_normals_that_are_directx_are_turned_for_all_but_unreal() -> None:
    down = ia.Plane(NORMAL, "normal", meta={"normals": "dx"})
    given = ia.Exemplar.of({"albedo": ALBEDO, "normal": down}, name="x")
    assert np.array_equal(ia.for_engine(given, "unreal")[0]["T_x_N.png"].pixels, NORMAL)
    found, told_of = ia.for_engine(given, "blender")
    assert np.array_equal(found["x_normal.png"].pixels[..., 1], 255 - NORMAL[..., 1])
    assert "green of the normals was turned: Blender reads OpenGL" in told_of


def test_what_cannot_be_is_refused_in_one_line() -> None:
    with pytest.raises(ia.ParameterError, match="choose one of unreal, unity, godot, blender, gltf"):
        ia.for_engine(ia.Exemplar.of(ALBEDO), "lego")
    assert list(package("gltf", albedo=ALBEDO / np.float32(255))) == ["stone_baseColor.exr"]


def test_the_command_writes_it_and_the_folder_is_made(tmp_path: Path) -> None:
    for name, pixels in WHOLE.items():
        ia.write(tmp_path / f"stone_{name}{'_dx' * (name == 'normal')}.png", pixels)
    said = told("export", *tmp_path.iterdir(), "--for", "unreal", "-o", tmp_path / "game" / "stones")
    made = {p.name: np.asarray(ia.read(p).base.pixels) for p in (tmp_path / "game" / "stones").iterdir()}
    assert {Path(path).name for path in said["files"]} == made.keys()
    assert np.array_equal(made["T_stone_N.png"], NORMAL), "it was DirectX already"
    assert np.array_equal(made["T_stone_ORM.png"], np.dstack([AO, ROUGH, METAL]))
    assert made["T_stone_H.png"].dtype == np.uint16
    assert said["told"][0].startswith("ORM holds R ao, G roughness, B metallic")


def test_a_grown_set_keeps_its_green_down(tmp_path: Path) -> None:
    for name, pixels in (("albedo", ALBEDO), ("normal_dx", NORMAL)):
        ia.write(tmp_path / f"stone_{name}.png", pixels)
    run("grow", *tmp_path.iterdir(), "-o", tmp_path / "big.png", "--size", "32", "-m", "repeat")
    run("export", tmp_path / "big.png", tmp_path / "big_normal_dx.png", "--for", "godot", "-o", tmp_path / "game")
    made, own = (np.asarray(ia.read(tmp_path / p).base.pixels) for p in ("game/big_normal.png", "big_normal_dx.png"))
    assert np.array_equal(made[..., 1], 255 - own[..., 1])


@pytest.mark.parametrize("verb", ["grow", "tile"])
@pytest.mark.parametrize("engine", ["unreal", "unity", "gltf"])
def test_what_is_grown_for_an_engine_is_what_export_makes_of_what_is_grown(
    verb: str, engine: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, plane in ia.Exemplar.of({n: WHOLE[n] for n in ("albedo", "normal", "roughness")}).planes.items():
        ia.write(f"s_{name}.png", plane)
    words = [verb, "s_albedo.png", "s_normal.png", "s_roughness.png", "--seed", 2]
    words += ["--size", 50, "--method", "image-quilting", "--patch", 10] if verb == "grow" else ["--band", 8]
    plain = told(*words, "-o", "wall.png")
    files = [file["path"] for file in plain["files"]]
    told("export", *files, "--for", engine, "-o", "plain/")
    Path("out").mkdir()
    at_once = told(*words, "-o", "out/wall.png", "--for", engine)
    made = sorted(p.name for p in Path("plain").iterdir())
    assert sorted(p.name for p in Path("out").iterdir()) == made
    assert sorted(file["path"] for file in at_once["files"]) == [f"out/{name}" for name in made]
    assert {file["holds"] for file in at_once["files"]} == {"export"}
    for name in made:
        assert np.array_equal(ia.read(f"out/{name}").base.pixels, ia.read(f"plain/{name}").base.pixels), name
    assert at_once["told"]
    run(*words, "-o", "out/wall.png", "--for", engine, code=2)  # they exist
    assert "several" in run("grow", "s_albedo.png", "-o", "-", "--for", engine, code=2).stderr


def test_a_built_in_set_is_grown_into_a_folder_for_an_engine(tmp_path: Path) -> None:
    told("grow", "sample:setts", "-o", f"{tmp_path}/", "--for", "unreal", "--size", 96, "--method", "repeat")
    names = {p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*.png")}
    assert names == {f"T_setts_{word}.png" for word in ("BC", "N", "ORM", "H")}


def test_nothing_half_is_written(tmp_path: Path) -> None:
    ia.write(tmp_path / "stone_albedo.png", ALBEDO)
    ia.write(tmp_path / "stone_normal.png", noise(3) // 8 + 224)
    files, out = sorted(tmp_path.iterdir()), tmp_path / "game"
    with full_disk(1500):
        said = run("export", *files, "--for", "blender", "-o", out, code=1).stderr.splitlines()
    assert "there is no room" in said[-1]
    assert not out.exists()
    out.mkdir()
    (out / "stone_normal.png").write_bytes(b"mine")
    assert "stone_normal.png" in run("export", *files, "--for", "blender", "-o", out, code=2).stderr
    assert [p.name for p in out.iterdir()] == ["stone_normal.png"]
    for place, code in {"/proc/self/o": 1, out / "stone_normal.png": 3, out / "stone_normal.png" / "x": 2}.items():
        for words in (("export", *files, "--for", "blender", "-o", place), ("maps", files[0], "-o", f"{place}/")):
            assert "folder" in run(*words, "-q", code=code).stderr
    said = run("export", *files, "--for", "lego", "-o", out, code=2).stderr.splitlines()
    assert len(said) == 1
    assert "'unreal', 'unity', 'godot', 'blender', 'gltf'" in said[0]
