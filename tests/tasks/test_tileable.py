"""Tiling: the inside stays bit for bit, borders meet as inner lines do, and what cannot be tiled is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from numpy.typing import NDArray

import intarsia as ia
from intarsia import files
from intarsia.cli import cli
from intarsia.foundation.geometry import Wrap
from intarsia.methods import METHODS, Ability, method_class
from intarsia.tasks.tileable import _fine_grained, periodic_size, scene_to_tile
from intarsia.testing.cases import as_depth, looked_up, texture
from unweighed import meeting

ONE = ia.Run(1)


def inside(shape: tuple[int, ...], axes: str, band: int) -> NDArray[np.bool_]:
    """The pixels that must stay: half a band away from every border that meets another, pixel by pixel."""
    out = np.ones(shape[:2], bool)
    for axis, closed in ((0, axes in ("y", "both")), (1, axes in ("x", "both"))):
        for k in range(shape[axis]):
            if closed and (k < band // 2 or k >= shape[axis] - (band - band // 2)):
                out[(k, slice(None)) if axis == 0 else (slice(None), k)] = False
    return out


@pytest.mark.parametrize("axes", ["x", "y", "both"])
@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float32", "float16"])
def test_the_inside_stays_bit_for_bit(dtype: str, axes: str) -> None:
    pixels = as_depth(texture(56, 62, 3, 4), dtype)
    made = ia.tile(pixels, axes=axes, band=18, seed=2, run=ONE)
    shown = made.render().pixels
    kept = inside(pixels.shape, axes, 18)
    assert shown.dtype == pixels.dtype
    assert shown.shape == pixels.shape
    assert shown[kept].tobytes() == pixels[kept].tobytes()
    assert made.map.wrap is Wrap(axes)
    assert not made.map.holes.any()
    assert (made.map.yx[kept] == np.argwhere(kept)).all()
    assert made.render(finish=()).pixels.tobytes() == looked_up(made.exemplars, made.map).tobytes()
    assert ia.tile(pixels, axes=axes, band=18, seed=2, run=ia.Run(3)).map.digest == made.map.digest


def strands(height: int, width: int) -> NDArray[np.uint8]:
    """A grain of strands along rows, darker to the right: no single elements, no lattice."""
    grain = np.repeat(texture(height, -(-width // 8), 3, 3), 8, axis=1)[:, :width]
    return (grain // 2 + np.linspace(80, 0, width)[None, :, None]).astype(np.uint8)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float32", "float16"])
@pytest.mark.parametrize("band", [None, 9, 40])
def test_steps_of_tone_are_levelled_within_the_band(dtype: str, band: int | None) -> None:
    planes = {"albedo": as_depth(strands(96, 100), dtype), "ao": as_depth(texture(48, 50, 1, 6), dtype)}
    made = ia.tile(planes, axes="x", band=band, seed=2, run=ONE)
    assert [f.name for f in made.blend.finish] == ["levelling"]
    assert made.recipe["blend"] == made.blend.as_recipe
    for name, pixels in planes.items():
        level, plain = made.render(name).pixels, made.render(name, finish=()).pixels
        kept = inside(pixels.shape, "x", made.recipe["tile"]["band"] * pixels.shape[0] // 96)
        assert level[kept].tobytes() == plain[kept].tobytes() == pixels[kept].tobytes()
        assert (level != plain).any()
    shown = ia.tile(strands(96, 100), axes="x", seed=2, run=ONE)
    steps = [np.abs(np.diff(a.mean(axis=(0, 2)), append=0)[:-1]).max() for a in (
        np.roll(p.pixels.astype(float), 50, 1) for p in (shown.render(), shown.render(finish=())))]  # fmt: skip
    assert steps[0] < steps[1]


def test_single_elements_are_not_levelled() -> None:
    """But for fine grain, whose pixels differ more than squares of it."""
    assert ia.tile("sample:pebbles", run=ONE).blend.finish == ()
    grain = texture(96, 96, 3, 5) % 16
    found = [_fine_grained(p.astype(np.int16)) for p in (grain, np.kron(grain, np.ones((8, 8, 1), np.uint8)))]
    assert found == [True, False]


@pytest.mark.parametrize("slug", [s for s in METHODS if {Ability.START, Ability.WRAP} <= method_class(s).supports])
def test_every_method_that_can_keeps_the_inside(slug: str) -> None:
    pixels = np.tile(texture(16, 12, 3, 7), (4, 12, 1))
    made = ia.tile(pixels, slug, band=14, run=ONE)
    kept = inside(pixels.shape, "both", 14)
    assert made.method.slug == slug
    assert (made.render().pixels[kept] == pixels[kept]).all()
    assert not made.map.holes.any()


@pytest.mark.parametrize("band", [4, 5, 11, 24])
def test_the_band_is_half_at_either_border_and_grown_from_the_middle(band: int) -> None:
    scene = scene_to_tile(ia.Exemplar.of(texture(48, 52)), (), Wrap.X, band, None)
    assert scene.canvas.start is not None
    holes = scene.canvas.start.holes
    wide = int(holes[0].sum())
    assert holes[0, [0, -1]].all()
    assert wide + 2 * (scene.canvas.rim or 0) == band
    assert (holes == holes[0]).all()
    assert scene.recipe == {"tile": {"axes": "x", "band": band}}


@pytest.mark.parametrize("name", ["stones", "gravel", "brick", "pebbles"])
def test_borders_meet_as_inner_lines_do(name: str) -> None:
    """Before they did not; the step over the borders stands among those between inner lines."""
    e = ia.Exemplar.of(ia.read(f"sample:{name}").base.samples[:200, :210])
    made = ia.tile(e, seed=1, run=ONE)
    assert meeting(e.base.samples, Wrap.BOTH) == 100
    assert meeting(made.render().samples, Wrap.BOTH) <= 98


def test_where_a_lattice_closes_nothing_is_seen() -> None:
    cell = texture(20, 24, 3, 9)
    whole = np.tile(cell, (6, 5, 1))
    made = ia.tile(whole, seed=1, run=ONE)
    assert np.array_equal(made.render().pixels, whole)


def test_a_picture_that_continues_in_itself_is_told_of() -> None:
    run = ia.Run(1)
    ia.tile("sample:pebbles", axes="x", run=run)
    assert run.notes == ["sample:pebbles looks as if it continued in itself already; then it can stay as it is."]


def test_a_wall_is_cut_to_whole_periods_unless_a_size_is_given() -> None:
    cell = texture(20, 24, 3, 9)
    cut = ia.Exemplar.of(np.tile(cell, (6, 5, 1))[:110, :107], name="cut")
    run = ia.Run(1)
    made = ia.tile(cut, run=run)
    told = "cut (107x110 px) was cut to 96x100 px, where its periods or courses close; --size 107x110 keeps all."
    assert run.notes == [told]
    assert np.array_equal(made.render().pixels, cut.base.samples[5:105, 5:101])
    assert made.recipe["size"] == [96, 100]
    for size in ((110, 107), (48, 50)):
        run = ia.Run(1)
        assert ia.tile(cut, size=size, run=run).recipe["size"] == list(size[::-1])
        assert run.notes == []


def test_what_is_cut_holds_whole_periods_along_the_axes_that_continue() -> None:
    cut = ia.Exemplar.of(np.tile(texture(20, 24, 3, 9), (6, 5, 1))[:110, :107])
    assert periodic_size(cut, Wrap.X) == (110, 96)
    assert periodic_size(cut, Wrap.Y) == (100, 107)
    assert periodic_size(ia.Exemplar.of(texture(60, 60)), Wrap.BOTH) == (60, 60)
    whole = ia.Exemplar.of(np.tile(texture(20, 24, 3, 9), (6, 5, 1)))
    assert periodic_size(whole, Wrap.BOTH) == (120, 120)


def test_courses_of_unequal_heights_are_cut_to_whole_ones() -> None:
    """But not where the rest, 18 px, is as high as a course."""
    wall = texture(150, 170, 1, 4) // 4 + 150
    wall[[y + k for y in (10, 24, 62, 80, 107, 138) for k in (0, 1, 2)]] = 20
    assert periodic_size(ia.Exemplar.of(wall), Wrap.BOTH) == (128, 170)
    assert periodic_size(ia.Exemplar.of(wall.swapaxes(0, 1)), Wrap.BOTH) == (170, 128)
    assert periodic_size(ia.Exemplar.of(wall), Wrap.X) == (150, 170)
    assert periodic_size(ia.Exemplar.of(wall[:146]), Wrap.BOTH) == (146, 170)


def test_a_wall_that_continues_in_itself_is_not_cut() -> None:
    """Its periods do not close, but its borders are lines that were neighbours."""
    wall = ia.read("sample:tiles").base.samples[:, :-10]
    assert periodic_size(ia.Exemplar.of(wall), Wrap.X) == (256, 193)
    assert periodic_size(ia.Exemplar.of(np.roll(wall, 70, axis=1)), Wrap.X) == (256, 246)


def test_sources_and_masks_are_kept_to() -> None:
    pixels, other = texture(48, 52, 3, 4), texture(48, 52, 3, 5)
    made = ia.tile(pixels, sources=[other], band=16, run=ONE)
    assert made.map.which is not None
    kept = inside(pixels.shape, "both", 16)
    assert (made.map.which[kept] == 0).all()
    assert (made.map.which[scene_holes(pixels, 16)] == 1).all()
    usable = np.ones((48, 52), bool)
    usable[20:30, 10:40] = False
    masked = ia.tile(ia.Exemplar.of(pixels, usable=usable), band=16, run=ONE)
    at = masked.map.yx[scene_holes(pixels, 16)]
    assert usable[at[:, 0], at[:, 1]].all()


def scene_holes(pixels: NDArray[Any], band: int) -> NDArray[np.bool_]:
    start = scene_to_tile(ia.Exemplar.of(pixels), (), Wrap.BOTH, band, None).canvas.start
    assert start is not None
    return start.holes


HALVES = {"albedo": texture(40, 40), "ao": texture(20, 20)}
REFUSED: dict[str, tuple[dict[str, Any], type[Exception], str]] = {
    "too small": ({"image": texture(40, 15)}, ia.InputError, "is too small to be tiled"),
    "toroidal": ({"image": ia.Exemplar.of(texture(40, 40), toroidal=True)}, ia.InputError, "already"),
    "no axes": ({"axes": "none"}, ia.ParameterError, "axes=none"),
    "other axes": ({"axes": "z"}, ia.ParameterError, "axes="),
    "narrow": ({"band": 3}, ia.ParameterError, "band=3"),
    "wide": ({"band": 27}, ia.ParameterError, "band=27 is not allowed; give 4 to 26 px"),
    "a larger size": ({"size": (41, 40)}, ia.ParameterError, "size=40x41 cannot be cut out"),
    "a small size": ({"size": (10, 40)}, ia.InputError, "too small"),
    "no size": ({"size": "40"}, ia.ParameterError, "size="),
    "a size of halves": ({"image": HALVES, "size": (31, 32)}, ia.ParameterError, "multiples of 2"),
    "another method": ({"method": "repeat"}, ia.ParameterError, "repeat"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_tiled_is_refused_in_one_line(name: str) -> None:
    given, error, message = REFUSED[name]
    with pytest.raises(error, match=message) as told:
        ia.tile(**({"image": texture(40, 40)} | given))
    assert "\n" not in str(told.value)


def test_what_is_small_along_the_other_axis_may_be() -> None:
    assert ia.tile(texture(15, 60, 3, 2), axes="x", band=12, run=ONE).render().pixels.shape == (15, 60, 3)


class TestCommand:
    @pytest.fixture(autouse=True)
    def _in_a_folder(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        files.write("a.png", ia.Plane(texture(48, 52, 3, 4)))

    def run(self, line: str, code: int = 0) -> Result:
        result = CliRunner().invoke(cli, line.split())
        assert result.exit_code == code, result.stderr
        return result

    def test_it_writes_all_that_it_is_asked_for(self) -> None:
        told = self.run("tile a.png -o o.png --preview p.png --axes x --json")
        made = ia.tile("a.png", axes="x").render()
        assert np.array_equal(files.read_plane("o.png").pixels, made.pixels)
        assert np.array_equal(files.read_plane("p.png").pixels, np.tile(made.pixels, (1, 3, 1)))
        answer = json.loads(told.stdout)
        assert [f["holds"] for f in answer["files"]] == ["albedo", "preview"]
        assert answer["wrap"] == "x"

    def test_a_wall_is_cut_to_whole_periods_and_that_is_told_once(self) -> None:
        files.write("t.png", ia.Plane(np.tile(texture(20, 24, 3, 9), (6, 5, 1))[:110, :107]))
        for more in ("", " --dry-run --force", " --seeds 1..2"):
            lines = self.run(f"tile t.png{more}").stderr.splitlines()
            assert len([line for line in lines if "--size 107x110 keeps all" in line]) == 1
            assert lines[-1].startswith("t_tiled")
            assert ".png: 96x100 px of 107x110 px, " in lines[-1]
        answer = json.loads(self.run("tile t.png --json --force").stdout)
        assert (answer["size"], answer["cut_from"]) == ([96, 100], [107, 110])
        told = self.run("tile t.png --size 107x110 -o whole.png")
        assert "--size" not in told.stderr
        assert "whole.png: 107x110 px, " in told.stderr
        assert "--size" not in self.run("replay t_tiled.png -e t.png -o again.png").stderr
        assert np.array_equal(files.read_plane("again.png").pixels, files.read_plane("t_tiled.png").pixels)

    @pytest.mark.parametrize(
        ("more", "code", "message"),
        [
            ("--size 60x40", 2, "size=60x40 cannot be cut out of a (52x48 px)"),
            ("--patch 100", 2, "patch=100 is larger than the exemplar"),
            ("--preview -", 2, "--preview needs the name of a file"),
            ("--preview p.gif", 2, "p.gif"),
            ("--preview o.png", 2, "o.png would be written twice"),
        ],
    )
    def test_bad_input_is_refused_before_anything_is_written(self, more: str, code: int, message: str) -> None:
        told = self.run(f"tile a.png -o o.png {more}", code).stderr
        assert message in told
        assert not Path("o.png").exists()


def test_the_rule_holds_where_borders_are_empty_and_beside_them_may_change() -> None:
    scene = scene_to_tile(ia.Exemplar.of(texture(60, 60, 3, 2)), (), Wrap.BOTH, None, None)

    def rule(canvas: ia.Canvas) -> str:
        return ia.Auto().choose(scene.exemplars, canvas).rule

    assert rule(scene.canvas) == "closing"
    assert ia.Auto().choose(scene.exemplars, scene.canvas).method.evenness == 0, "nearly all is shown once, as it lies"
    assert rule(replace(scene.canvas, rim=0)) == "begun"
    one = scene_to_tile(scene.exemplars[0], (), Wrap.X, None, None).canvas
    assert rule(one) == "closing"
    assert one.start is not None
    assert rule(replace(one, wrap=Wrap.Y, start=replace(one.start, wrap=Wrap.Y))) != "closing"
