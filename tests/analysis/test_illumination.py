"""Light on an exemplar: found, told apart from the texture, taken off in any depth, and replayed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

import intarsia as ia
from intarsia import files
from intarsia.analysis.illumination import Illumination, clipped, illumination_of
from intarsia.cli import cli
from intarsia.lattice import lattice_of
from intarsia.model.image import Transfer
from intarsia.rendering import from_linear, to_linear
from intarsia.search import elements
from intarsia.testing import texture
from intarsia.testing.cases import as_depth


def light_on(plane: ia.Plane, factor: float = 2.5) -> ia.Plane:
    """A picture lit from the left, in linear light: the right side is `factor` times darker."""
    x = np.arange(plane.width) / (plane.width - 1)
    lit = to_linear(plane).astype(np.float64) * np.power(factor, -x)[None, :, None]
    return plane.like(from_linear(lit, plane))


def brick(side: int = 256) -> ia.Plane:
    return ia.Plane(np.asarray(ia.read("sample:brick").base.pixels)[:side, :side])


def dotted(side: int) -> ia.Plane:
    """Lit from the left, with a spot on the dark side that is nearly white all the same."""
    pixels = light_on(brick(side), 8.0).pixels.copy()
    spot = side // 7
    pixels[spot : 2 * spot, -2 * spot : -spot] = 245
    return ia.Plane(pixels)


def sides(plane: ia.Plane) -> float:
    """How many times brighter the left third is than the right, in linear light."""
    light = to_linear(plane).astype(float).sum(axis=2)
    third = plane.width // 3
    return float(light[:, :third].mean() / light[:, -third:].mean())


def test_a_slope_is_found_and_taken_off() -> None:
    lit = ia.Exemplar.of(light_on(brick()))
    assert illumination_of(lit, 20).strong
    assert illumination_of(lit, 20).factor == pytest.approx(2.4, abs=0.35)
    even = ia.flattened(lit)
    assert sides(lit.base) > 1.7
    assert sides(even.base) == pytest.approx(1, abs=0.06)
    assert not illumination_of(even, 20).strong


def test_light_is_told_of_only_where_it_is_most_of_what_parts_differ_by() -> None:
    """At least 30 % of their differences are one slope, which is half a stop or more."""
    for share, factor, strong in ((0.29, 3, False), (0.31, 1.5, True), (0.9, 1.39, False), (0.9, 1.41, True)):
        assert Illumination(share, factor).strong == strong
    patchy = brick().samples.astype(float)
    y, x = np.mgrid[:256, :256] // 32
    patchy *= np.where((5 * y + 3 * x + y * x) % 7 < 3, 0.35, 1)[..., None]  # parts that are dark of themselves
    found = illumination_of(ia.Exemplar.of(light_on(brick().like(patchy.astype(np.uint8)), 4.0)), 20)
    assert 0.05 < found.share < 0.3
    assert found.factor > 1.4
    assert not found.strong


@pytest.mark.parametrize("name", ["brick", "gravel", "pebbles", "stones", "tiles"])
def test_even_exemplars_have_no_strong_slope(name: str) -> None:
    e = ia.read(f"sample:{name}")
    assert not illumination_of(e, elements(e).size).strong


def test_too_few_elements_say_nothing() -> None:
    lit = ia.Exemplar.of(light_on(brick(64)))
    assert illumination_of(lit, 30).factor == 1
    assert illumination_of(ia.Exemplar.of(np.full((3, 3), 9, np.uint8)), 1).factor == 1


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float16", "float32", "float64"])
@pytest.mark.parametrize("transfer", list(Transfer))
@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_depth_size_opacity_and_other_planes_stay(dtype: str, transfer: Transfer, channels: int) -> None:
    base = ia.Plane(as_depth(texture(40, 60, channels, 2), dtype), ia.Kind.COLOUR, transfer, {"name": "png"})
    height = ia.Plane(texture(80, 120, 1, 3), ia.Kind.DATA)
    usable = np.ones((40, 60), bool)
    usable[:9] = False
    given = ia.Exemplar({"albedo": base, "height": height}, usable, name="moss")
    made = ia.flattened(given)
    assert (made.base.pixels.dtype, made.base.pixels.shape) == (base.pixels.dtype, base.pixels.shape)
    assert (made.base.transfer, made.base.meta, made.name) == (transfer, base.meta, "moss")
    assert made.planes["height"] is height
    assert (made.usable == usable).all()
    if base.alpha:
        assert (made.base.samples[..., -1] == base.samples[..., -1]).all()
    assert not np.array_equal(made.base.pixels, base.pixels)


def test_colours_keep_their_hue() -> None:
    """All channels are divided by the same light, in linear light."""
    given = ia.Plane(as_depth(texture(50, 70, 3, 4), "float32"), ia.Kind.COLOUR, Transfer.LINEAR)
    even = ia.flattened(ia.Exemplar.of(light_on(given))).base.pixels
    ratio = even / np.maximum(given.pixels, 1e-6)
    assert np.ptp(ratio[given.pixels.min(axis=2) > 0.1], axis=1).max() < 1e-5


def test_masked_pixels_neither_count_nor_break() -> None:
    pixels = as_depth(texture(40, 60, 3, 5), "float32")
    pixels[3:9, 4:30] = np.nan
    usable = np.isfinite(pixels).all(axis=2)
    one = ia.flattened(ia.Exemplar.of(pixels, usable=usable)).base.pixels
    pixels[3:9, 4:30] = 77.0
    other = ia.flattened(ia.Exemplar.of(pixels, usable=usable)).base.pixels
    assert np.array_equal(one[usable], other[usable])


def test_what_is_cut_off_at_white_is_told() -> None:
    lit = dotted(256)
    even = ia.flattened(ia.Exemplar.of(lit)).base
    assert 0.01 < clipped(lit, even) < 1
    assert clipped(lit, lit) == 0


def test_what_has_no_light_is_refused() -> None:
    height = ia.Exemplar({"height": ia.Plane(texture(20, 20), ia.Kind.DATA)})
    with pytest.raises(ia.ParameterError, match="the plane height holds data, not colours"):
        ia.flattened(height)
    with pytest.raises(ia.ParameterError, match="continues across its borders"):
        ia.flattened(ia.Exemplar.of(texture(20, 20), toroidal=True))
    assert illumination_of(height, 5).factor == 1


@pytest.mark.parametrize("name", ["brick", "tiles"])
def test_flattening_brings_back_the_lattice(name: str) -> None:
    """Light turns the courses of the bricks by a degree; without it they lie as in the even picture."""
    base = ia.read(f"sample:{name}").base
    plain = base.like(base.samples[:256, :256])
    lit = ia.Exemplar.of(light_on(plain, 4.0))
    truth, off, even = (np.array(lattice_of(e, "x")) for e in (ia.Exemplar.of(plain), lit, ia.flattened(lit)))
    assert np.abs(off - truth).max() < 1
    assert np.abs(even - truth).max() < 0.05
    assert np.abs(even - truth).max() <= np.abs(off - truth).max()


def grow(*args: object, code: int = 0) -> Any:
    result = CliRunner().invoke(cli, [str(a) for a in args])
    assert result.exit_code == code, result.stderr
    return result


def bytes_of(path: str) -> bytes:
    return Path(path).read_bytes()


def pixels_of(path: str) -> NDArray[Any]:
    return files.read_plane(path).pixels


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_replay_follows_the_recipe_to_the_byte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dtype: str) -> None:
    monkeypatch.chdir(tmp_path)
    lit = light_on(ia.Plane(as_depth(np.asarray(brick(120).pixels), dtype)))
    ia.write("lit.png", lit)
    size = ("--size", "150x140", "--patch", 30, "--even-tone", 0, "-q")
    grow("grow", "lit.png", "-o", "a.png", "--flatten", *size, "--save-map", "a.npz")
    recipe = files.read_recipe("a.png")
    assert recipe["inputs"] == {"flatten": True}
    grow("replay", "a.png", "--exemplar", "lit.png", "-o", "b.png", "-q")
    assert bytes_of("a.png") == bytes_of("b.png")
    grow("render", "a.npz", "--exemplar", "lit.png", "--flatten", "-o", "c.png", "-q")
    assert np.array_equal(pixels_of("a.png"), pixels_of("c.png"))
    even = ia.flattened(ia.read("lit.png"))
    made = ia.synthesize(even, (140, 150), ia.ImageQuilting(patch=30))
    assert np.array_equal(made.render().pixels, pixels_of("a.png"))
    assert pixels_of("a.png").dtype == dtype
    grow("grow", "lit.png", "-o", "plain.png", *size)
    assert "inputs" not in files.read_recipe("plain.png")
    assert not np.array_equal(pixels_of("plain.png"), pixels_of("a.png"))


def test_what_does_not_go_together_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    told = grow("grow", "sample:brick", "-o", "a.png", "--flatten", "--toroidal", code=2).stderr
    assert told.startswith("intarsia: --flatten does not go with --toroidal")
    assert told.count("\n") == 1
    assert "No such option" in grow("extend", "sample:brick", "-o", "a.png", "--flatten", code=2).stderr
    assert "No such option" in grow("heal", "sample:brick", "-o", "a.png", "--flatten", code=2).stderr
    assert list(tmp_path.iterdir()) == []


def test_a_warning_tells_what_became_white(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    ia.write("bright.png", dotted(96))
    done = grow("grow", "bright.png", "-o", "a.png", "--flatten", "--size", 99, "--patch", 24, "--json")
    told = json.loads(done.stdout)
    assert len(told["warnings"]) == 1
    assert "became brighter than white" in told["warnings"][0]
