"""Built-in exemplars: the shipped files are what the script paints; maps of the material belong together, and wrap."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import make_samples
import numpy as np
import pytest
from cli.commands import run
from paint_setts import DEEP, SIDE
from PIL import Image

from intarsia import read
from intarsia.files import FOLDER, group, read_plane, sample
from intarsia.foundation import MATERIALS, PAINTED, InputError
from intarsia.model.image import Kind
from intarsia.rendering.blending import off_unit

FILES = [*PAINTED, *(f"setts_{name}" for name in MATERIALS["setts"])]
painted = cache(make_samples.painted)


@pytest.mark.parametrize("name", FILES)
def test_the_shipped_files_are_what_the_script_paints(name: str) -> None:
    shipped: Any = sample(name.replace("_", "::")).pixels
    assert shipped.dtype == painted()[name].dtype
    np.testing.assert_array_equal(shipped, painted()[name])


def test_the_script_writes_the_files_that_are_shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without loss, whatever version of a library packs them; all of them together are small."""
    few = {name: pixels[:8, :8] for name, pixels in painted().items()}
    monkeypatch.setattr(make_samples, "painted", lambda: few)
    make_samples.write(tmp_path)
    assert make_samples.FOLDER.parts[-4:] == FOLDER.parts[-4:]
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in FOLDER.iterdir()}
    for path in tmp_path.iterdir():
        np.testing.assert_array_equal(read_plane(path).pixels, few[path.stem])
    assert sum(path.stat().st_size for path in FOLDER.iterdir()) < 1_800_000


def test_a_material_is_read_as_a_set() -> None:
    setts = read("sample:setts")
    assert setts.name == "sample:setts"
    assert tuple(setts.planes) == MATERIALS["setts"]
    assert {name: plane.kind for name, plane in setts.planes.items()} == {
        "albedo": Kind.COLOUR, "normal": Kind.NORMAL, "roughness": Kind.DATA, "height": Kind.DATA,
    }  # fmt: skip
    assert group(["sample:setts"]) == [{name: f"sample:setts::{name}" for name in MATERIALS["setts"]}]
    alone = read("sample:setts::height")
    assert tuple(alone.planes) == ("albedo",)
    assert alone.name == "sample:setts::height"
    np.testing.assert_array_equal(alone.base.pixels, sample("setts::height").pixels)
    assert read_plane("sample:setts::normal").kind is Kind.NORMAL


def test_unknown_planes_name_the_known() -> None:
    with pytest.raises(InputError, match=r"no plane 'moon'.*albedo, normal, roughness, height"):
        read("sample:setts::moon")
    with pytest.raises(InputError, match=r"brick.*tiles"):
        read("sample:moon")
    with pytest.raises(InputError, match="there is no sample"):
        read("sample:tiles::normal")


def test_normals_are_the_slopes_of_the_height() -> None:
    height = sample("setts::height").pixels.astype(np.float64) * (DEEP / 65535)
    assert off_unit(sample("setts::normal")) < 0.01
    n = sample("setts::normal").pixels / 127.5 - 1.0
    across = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / 2
    down = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) / 2
    np.testing.assert_allclose(-n[..., 0] / n[..., 2], across, atol=0.06)
    np.testing.assert_allclose(n[..., 1] / n[..., 2], down, atol=0.06)


@pytest.mark.parametrize("name", MATERIALS["setts"])
def test_it_wraps_around(name: str) -> None:
    pixels = sample(f"setts::{name}").pixels.astype(np.float64)
    pixels = pixels.reshape(SIDE, SIDE, -1)
    for axis in (0, 1):
        steps = np.abs(np.diff(pixels, axis=axis)).mean(axis=(1 - axis, 2))
        closing = np.abs(pixels.take(0, axis) - pixels.take(-1, axis)).mean()
        assert closing <= steps.max()


def test_it_is_grown_with_all_its_maps_and_replayed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run("grow", "sample:setts", "-o", "yard.png", "--size", "96", "--method", "image-quilting", "--patch", "24")
    run("replay", "yard.png", "-o", "again.png")
    for end in ("", "_normal", "_roughness", "_height"):
        with Image.open(f"yard{end}.png") as first, Image.open(f"again{end}.png") as second:
            np.testing.assert_array_equal(np.asarray(first), np.asarray(second))
