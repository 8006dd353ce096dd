"""Grown small, drawn large (Lefebvre and Hoppe 2005): against the plain twin, and what the command line makes of it."""

from __future__ import annotations

import json
from fractions import Fraction
from itertools import product
from math import floor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from numpy.typing import NDArray
from rendering.naive_votes import clearance

import intarsia as ia
from intarsia import files
from intarsia.cli import cli
from intarsia.foundation.blend import Blend
from intarsia.model import REDUCED, Exemplar
from intarsia.model.image import Kind, Plane
from intarsia.model.sourcemap import SourceMap
from intarsia.rendering import from_linear, to_linear
from intarsia.rendering.blending import averaged
from intarsia.rendering.magnification import magnified, reduced
from intarsia.rendering.render import render
from intarsia.testing import as_depth, texture


def nearest(n: int, d: int) -> list[tuple[int, Fraction]]:
    """The two map pixels nearest to sub-pixel d of a map pixel along an axis, and their shares, in steps of 1/(n+1)."""
    before, after = max(0, n // 2 - d), max(0, d + 1 - n // 2)
    shares = [(-1, before), (0, n + 1 - before - after), (1, after)]
    return [(step, Fraction(share, n + 1)) for step, share in shares if share]


def twin(exemplar: Exemplar, smap: SourceMap, plane: Plane, light: NDArray[Any]) -> list[list[list[Fraction]]]:
    """Every pixel of the large picture from its four nearest map pixels: sum w E(n S(m) + p - n m) / sum w."""
    n = plane.height // exemplar.height
    usable = np.ones((exemplar.height, exemplar.width), bool) if exemplar.usable is None else exemplar.usable
    large = Exemplar.of(light, usable=usable.repeat(n, 0).repeat(n, 1), toroidal=exemplar.toroidal)
    cap, out = (n + 1) // 2 + 1, []
    for y in range(n * smap.height):
        out.append([])
        for x in range(n * smap.width):
            total, weight = [Fraction(0)] * light.shape[2], Fraction(0)
            for (i, wy), (j, wx) in product(nearest(n, y % n), nearest(n, x % n)):
                my, mx = y // n + i, x // n + j
                if smap.wrap.y:
                    my %= smap.height
                if smap.wrap.x:
                    mx %= smap.width
                if not (0 <= my < smap.height and 0 <= mx < smap.width):
                    continue
                u = n * int(smap.yx[my, mx, 0]) + y % n - n * i, n * int(smap.yx[my, mx, 1]) + x % n - n * j
                if exemplar.toroidal:
                    u = u[0] % plane.height, u[1] % plane.width
                if 0 <= u[0] < plane.height and 0 <= u[1] < plane.width:
                    w = wy * wx * clearance(large, *u, cap)
                    total = [t + w * Fraction(float(v)) for t, v in zip(total, light[u], strict=True)]
                    weight += w
            out[-1].append([t / weight for t in total])
    return out


def scattered(size: tuple[int, int], exemplar: Exemplar, wrap: str) -> SourceMap:
    draws = np.random.default_rng(4)
    ys, xs = np.nonzero(np.ones((exemplar.height, exemplar.width)) if exemplar.usable is None else exemplar.usable)
    at = draws.integers(0, len(ys), size)
    return SourceMap(np.stack([ys[at], xs[at]], axis=2).astype(np.int32), wrap=ia.Wrap(wrap))


@pytest.mark.parametrize("n", [2, 3, 4])
@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
@pytest.mark.parametrize("toroidal", [False, True])
def test_a_large_picture_blends_the_four_nearest_map_pixels(n: int, dtype: str, toroidal: bool) -> None:
    """Exactly: planes of whole numbers, borders and masked pixels included."""
    plane = Plane(as_depth(texture(6 * n, 5 * n, 2, 7), dtype), Kind.DATA)
    mask = np.ones((6 * n, 5 * n), bool)
    mask[0, 2 * n] = toroidal  # one pixel that must not be read closes its block
    e = magnified(Exemplar.of({"height": plane}, usable=mask, toroidal=toroidal), n)
    smap = scattered((4, 5), e, "x")
    made = render([e], smap, blend=Blend(1)).samples
    expected = twin(e, smap, plane, plane.samples.astype(np.float64))
    assert made.tolist() == [[[floor(v + Fraction(1, 2)) for v in px] for px in row] for row in expected]


@pytest.mark.parametrize("dtype", ["uint8", "float32"])
def test_colours_blend_in_linear_light(dtype: str) -> None:
    plane = Plane(as_depth(texture(16, 12, 3, 8), dtype))
    e = magnified(Exemplar.of(plane), 4)
    smap = scattered((3, 4), e, "both")
    made = render([e], smap, blend=Blend(1))
    light = np.array(twin(e, smap, plane, to_linear(plane).astype(np.float64)), np.float64)
    wanted = from_linear(light, plane)
    assert np.abs(made.samples.astype(np.float64) - wanted).max() <= (1 if dtype == "uint8" else 1e-5)


@pytest.mark.parametrize("method", [ia.ImageQuilting(patch=10), ia.ParallelControllable(), ia.WeiLevoy(window=5)])
def test_the_map_is_that_of_the_reduced_exemplar(method: Any) -> None:
    e = Exemplar.of(texture(96, 80, 3, 3))
    large, small = ia.synthesize(magnified(e, 4), (30, 25), method), ia.synthesize(reduced(e, 4), (30, 25), method)
    assert (large.map.yx == small.map.yx).all()
    assert large.blend.feather == 1
    assert large.render().pixels.shape == (120, 100, 3)
    assert (large.render(REDUCED).pixels == small.render(feather=1).pixels).all()
    blocks = large.render(feather=0).pixels[::4, ::4]
    assert (blocks == e.base.pixels[4 * large.map.yx[..., 0], 4 * large.map.yx[..., 1]]).all()


def test_a_material_set_keeps_its_planes_and_their_sizes() -> None:
    rgb, height = texture(48, 36, 3, 1), as_depth(texture(24, 18, 1, 2), "uint16")
    normal = np.dstack([texture(96, 72, 2, 3) // 4 + 96, np.full((96, 72), 250, np.uint8)])
    e = magnified(Exemplar.of({"albedo": rgb, "height": height, "normal": normal}, toroidal=True), 3 * 2)
    assert (e.drawn, e.compared) == (("albedo", "height", "normal"), (REDUCED, "height", "normal"))
    assert (e.height, e.width, e.toroidal, e.times) == (8, 6, True, 6)
    assert (e.base.pixels == averaged(Plane(rgb), 6)).all()
    made = ia.synthesize(e, (10, 12), ia.ParallelControllable(), wrap="both")
    shapes = {name: made.render(name).pixels.shape[:2] for name in e.drawn}
    assert shapes == {"albedo": (60, 72), "height": (30, 36), "normal": (120, 144)}
    assert made.render("height").pixels.dtype == np.uint16
    woven = ia.weave(e, ia.ParallelControllable())
    assert woven.planes == e.drawn
    assert woven[-7:20, 5:30].shape == (27, 25, 3)
    assert (woven[0:24, 0:24][5:9, 7:20] == woven[5:9, 7:20]).all()


def test_a_small_pixel_is_usable_if_all_of_its_block_is() -> None:
    mask = np.ones((20, 20), bool)
    mask[7, 13] = False
    pixels = as_depth(texture(20, 20, 1, 1), "float32").copy()
    pixels[7, 13] = np.nan  # masked, so allowed
    e = magnified(Exemplar.of(pixels, usable=mask), 4)
    assert e.usable is not None
    assert np.argwhere(~e.usable).tolist() == [[1, 3]]
    made = ia.synthesize(e, 15, ia.ParallelControllable())
    assert np.isfinite(made.render().pixels).all()


def test_sides_are_cut_to_multiples_but_a_torus_is_refused() -> None:
    e = Exemplar.of(texture(30, 41, 3, 1))
    assert magnified(e, 1) is e
    made = magnified(e, 4)
    assert made.planes["albedo"].pixels.shape == (28, 40, 3)
    planes = Exemplar.of({"a": texture(24, 24), "height": texture(6, 6)})
    for exemplar, n, told in (
        (Exemplar.of(texture(30, 41, 3, 1), toroidal=True), 4, "no longer continue in itself"),
        (made, 2, "magnified already"), (e, 31, "leaves nothing of"), (e, 0, "give 1 to 64"),
        (e, 2.5, "give 1 to 64"), (planes, 6, "does not suit the plane height"),
    ):  # fmt: skip
        with pytest.raises(ia.ParameterError, match=told) as caught:
            magnified(exemplar, n)  # type: ignore[arg-type]
        assert "\n" not in str(caught.value)
    holes = np.ones((8, 8), bool)
    holes[::4, ::4] = False
    with pytest.raises(ia.InputError, match="no whole block of 4x4 px"):
        magnified(Exemplar.of(texture(8, 8), usable=holes), 4)


def run(line: str, code: int = 0) -> Result:
    result = CliRunner().invoke(cli, line.split())
    assert result.exit_code == code, result.stderr
    return result


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    ia.write("a.png", texture(96, 82, 3, 3))
    ia.write("h.png", as_depth(texture(96, 82, 1, 4), "uint16"))
    return tmp_path


GROW = "grow a.png --map height=h.png -o o.png --magnify 4 --method image-quilting --patch 8 --seed 2 "


def test_grow_writes_the_large_planes_only(here: Path) -> None:
    told = json.loads(run(GROW + "--size 120x88 --json --save-map m.npz").stdout)
    assert sorted(p.name for p in here.glob("o*")) == ["o.png", "o_height.png"]
    assert (told["size"], told["magnify"], told["blend"]["feather"]) == ([120, 88], 4, 1)
    assert told["parameters"]["patch"] in (8, [8, 8])
    assert "was cut to 80x96 px" in told["warnings"][0]
    e = magnified(ia.read("a.png", height="h.png"), 4)
    made = ia.synthesize(e, (22, 30), ia.ImageQuilting(patch=8), seed=2)
    for name, path in (("albedo", "o.png"), ("height", "o_height.png")):
        assert (files.read_plane(path).samples == made.render(name).samples).all()
    assert files.read_plane("o_height.png").pixels.dtype == np.uint16
    run("replay o.png -e a.png --map height=h.png -o again.png -q")
    for ending in ("", "_height"):
        assert Path(f"again{ending}.png").read_bytes() == Path(f"o{ending}.png").read_bytes()
    run("render m.npz -e a.png -o part.png --magnify 4 --window 8,4,60,40 -q")
    assert (files.read_plane("part.png").pixels == files.read_plane("o.png").pixels[4:44, 8:68]).all()


def test_plans_tell_true_sizes_and_a_feather_can_be_given(here: Path) -> None:
    told = json.loads(run(GROW + "--dry-run --json").stdout)
    assert (told["size"], told["magnify"]) == ([160, 192], 4)
    assert json.loads(run(GROW + "--size 40 --feather 0 --json").stdout)["blend"]["feather"] == 0
    run("grow a.png -o {w}.png --magnify 2 --size 60 --trials 2 --sheet s.png -q")
    assert files.read_plane("60.png").pixels.shape == (60, 60, 3)
    mixed = "grow a.png -o f.png --magnify 2 --method patch-sampling --patch 8 --overlap 4 --size 60 --json"
    assert json.loads(run(mixed).stdout)["blend"]["feather"] == 4


def test_the_command_that_repeats_a_choice_holds_it(here: Path) -> None:
    told = json.loads(run("grow a.png -o x.png --magnify 2 --size 64x48 --json").stdout)
    words = told["auto"]["command"].replace("-o x.png", "-o y.png").removeprefix("intarsia ")
    assert "--magnify 2" in words
    run(words)
    assert (files.read_plane("x.png").pixels == files.read_plane("y.png").pixels).all()


def test_weaving_is_what_the_library_draws(here: Path) -> None:
    line = "weave a.png -o w.tif --magnify 4 --method parallel-controllable --size 100x60 --origin -40,88 --json"
    told = json.loads(run(line).stdout)
    assert (told["size"], told["origin"], told["magnify"]) == ([100, 60], [-40, 88], 4)
    woven = ia.weave(magnified(ia.read("a.png"), 4), ia.ParallelControllable())
    assert (files.read_plane("w.tif").pixels == woven[88:148, -40:60]).all()


@pytest.mark.parametrize(
    ("line", "code", "told"),
    [
        ("grow a.png -o o.png --magnify 4 --size 121x88", 2, "--size 121x88 is no multiple of --magnify 4"),
        ("grow a.png -o o.png --magnify 0", 2, "1<=x<=64"),
        ("grow a.png -o o.png --magnify 64 --toroidal", 2, "no longer continue in itself"),
        ("grow h.png -o o.png --magnify 4 --crop 0,0,3,3", 2, "magnify=4 leaves nothing"),
        ("weave a.png -o w.tif --magnify 4 --size 64 --origin 2,0", 2, "do not suit --magnify 4"),
        ("weave a.png -o w.tif --magnify 4 --size 66", 2, "do not suit --magnify 4"),
    ],
)
def test_bad_input_is_one_line(line: str, code: int, told: str, here: Path) -> None:
    lines = run(line, code).stderr.strip().splitlines()
    assert told in lines[-1]
    assert not list(here.glob("o*"))
