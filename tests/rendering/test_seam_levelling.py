"""Tests of levelling: against the direct sum of potentials, where it must do nothing, and how it is kept."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from rendering.naive_finish import NaiveLeveller
from rendering.test_render import cut_map, laid, noise_map, pixels_of
from rendering.test_votes import scene

import intarsia as ia
from intarsia.cli import cli
from intarsia.foundation.blend import Blend, Levelling
from intarsia.foundation.geometry import ISOMETRIES, Box, Wrap
from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.model.image import Kind, Plane
from intarsia.model.sourcemap import HOLE, SourceMap
from intarsia.rendering.render import render
from intarsia.testing.cases import texture

ONE = Run(1)
DTYPES = ("uint8", "uint16", "float16", "float32", "float64")


def levels(radius: int, strength: float = 1.0, feather: int = 0) -> Blend:
    return Blend(feather, finish=(Levelling(radius, strength),))


def halves(dtype: str, step: float = 0.2) -> tuple[Exemplar, SourceMap]:
    """Two halves of one picture, the right one lighter by a step throughout, and a map that joins them."""
    flat = np.full((64, 150, 3), 0.3)
    flat[:, 60:] += step
    flat[:, 128:139], flat[:, 139:] = 0.0, 1.0  # what it is like elsewhere: steps are usual
    top = 1 if dtype[0] == "f" else np.iinfo(dtype).max
    yx = np.stack(np.mgrid[0:64, 5:65], axis=2).astype(np.int32)
    yx[:, 30:, 1] += 60
    return Exemplar.of(Plane((flat * top).astype(dtype), Kind.DATA)), SourceMap(yx)


def lit(dtype: str) -> Exemplar:
    """A fine grain, lighter from left to right."""
    grain = np.random.default_rng(5).random((80, 140, 3))
    top = 1 if dtype[0] == "f" else np.iinfo(dtype).max
    slope = 0.2 + 0.6 * np.arange(140)[:, None] / 140
    return Exemplar.of(Plane(((slope + 0.05 * grain) * top).astype(dtype), Kind.DATA))


@settings(max_examples=24, deadline=None, derandomize=True)
@given(
    st.integers(0, 1 << 20),
    st.sampled_from([1, 2, 4, 9]),
    st.sampled_from([("uint8", 3), ("uint8", 4), ("uint16", 2), ("uint16", 1)]),
    st.sampled_from([Kind.COLOUR, Kind.DATA]),
    st.sampled_from([1.0, 0.5]),
)
def test_integers_equal_the_direct_sum_of_potentials(
    seed: int, radius: int, depth: tuple[str, int], kind: Kind, strength: float
) -> None:
    """Poses, masks, several exemplars, tori on either side, potentials wider than the picture."""
    exemplars, smap = scene(seed, *depth, kind=kind)
    for feather in (0, 3):
        plain = render(exemplars, smap, blend=Blend(feather), run=ONE).samples
        got = render(exemplars, smap, blend=levels(radius, strength, feather), run=ONE).samples
        assert (got == NaiveLeveller(exemplars, smap, plain, radius).levelled(strength)).all()


@settings(max_examples=12, deadline=None, derandomize=True)
@given(
    st.integers(0, 1 << 20),
    st.sampled_from([1, 3, 9]),
    st.sampled_from([("float16", 1), ("float32", 3), ("float32", 4), ("float64", 2)]),
    st.sampled_from([Kind.COLOUR, Kind.DATA]),
)
def test_floats_equal_the_direct_sum_of_potentials(seed: int, radius: int, depth: tuple[str, int], kind: Kind) -> None:
    exemplars, smap = scene(seed, *depth, kind=kind)
    plain = render(exemplars, smap, run=ONE).samples
    got = render(exemplars, smap, blend=levels(radius), run=ONE).samples
    want = NaiveLeveller(exemplars, smap, plain, radius).levelled(1.0)
    assert got.dtype == np.dtype(depth[0])
    np.testing.assert_allclose(got, want, rtol=2e-3 if depth[0] == "float16" else 1e-6, atol=1e-6)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("channels", [1, 3, 4, 9])
def test_one_piece_stays_as_it_is_in_every_pose(dtype: str, channels: int) -> None:
    """Byte for byte, boxes beyond the borders included."""
    exemplar = Exemplar.of(pixels_of(dtype, (23, 31, channels)))
    for isometry in ISOMETRIES:
        smap = laid(isometry, 23, 31)
        plain = render([exemplar], smap, run=ONE).pixels.tobytes()
        for radius in (1, 5, 40):
            assert render([exemplar], smap, blend=levels(radius), run=ONE).pixels.tobytes() == plain


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("radius", [1, 7, 12])
def test_nothing_changes_further_than_the_radius_from_a_seam(dtype: str, radius: int) -> None:
    exemplar, smap = lit(dtype), cut_map(40, 60, 30, 37)
    plain, got = (render([exemplar], smap, blend=b, run=ONE).samples for b in (Blend(0), levels(radius)))
    changed = np.flatnonzero((plain != got).any(axis=(0, 2)))
    assert 30 - radius <= changed.min() <= 30 - (radius + 1) // 2
    assert 29 + (radius + 1) // 2 <= changed.max() <= 29 + radius


def test_a_step_counts_as_far_as_it_is_the_same_all_around() -> None:
    """A stone and the joint beside it differ, too, but are meant to: there, nothing is evened out."""
    tone = np.full((40, 150, 1), 90, np.uint8)
    tone[:, 130:140], tone[:, 140:] = 0, 255
    other = tone.copy()
    tone[:, 60:130] += 40  # the same surface, lighter
    stripes = np.where(np.arange(40) // 10 % 2 == 0, 80, 0).astype(np.uint8)
    other[:, 60:130] += stripes[:, None, None]  # as light on average
    yx = np.stack(np.mgrid[0:40, 10:70], axis=2).astype(np.int32)
    yx[:, 30:, 1] += 41
    calm = tone[:, :130]  # a step of twice the usual difference
    for pixels, low, high in ((tone, 0.95, 1.05), (other, -0.05, 0.4), (calm, 0.2, 0.6)):
        exemplar, smap = Exemplar.of(Plane(pixels, Kind.DATA)), SourceMap(yx)
        plain, got = (render([exemplar], smap, blend=b, run=ONE).samples.astype(float) for b in (Blend(0), levels(24)))
        middle = (plain - got)[10:30, :, 0].mean(axis=0)
        gone = (middle[30] - middle[29]) / (plain[:, 30].mean() - plain[:, 29].mean())
        assert low <= gone <= high


@pytest.mark.parametrize("dtype", DTYPES)
def test_the_step_between_two_halves_vanishes(dtype: str) -> None:
    exemplar, smap = halves(dtype)
    for strength, left in ((1.0, 0.0), (0.5, 0.5)):
        plain, got = (
            render([exemplar], smap, blend=b, run=ONE).samples.astype(float)[..., 0]
            for b in (Blend(0), levels(20, strength))
        )
        steps = [np.diff(p, axis=1)[:, 29] for p in (plain, got)]
        assert (np.abs(steps[1] - left * steps[0]) < 0.05 * steps[0]).all()
        np.testing.assert_allclose(got.mean(), plain.mean(), rtol=0.01)


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float32", "float64"])
@pytest.mark.parametrize("wrap", list(Wrap))
@pytest.mark.parametrize("feather", [0, 3])
def test_a_window_is_that_window_of_the_whole(dtype: str, wrap: Wrap, feather: int) -> None:
    """Of the base, of an opaque plane, of one twice as large and one half as large; and around a torus."""
    planes = {
        "albedo": pixels_of(dtype, (36, 40, 4)), "height": Plane(pixels_of(dtype, (36, 40)), Kind.DATA),
        "fine": pixels_of(dtype, (72, 80, 3)), "coarse": pixels_of(dtype, (18, 20, 3)),
    }  # fmt: skip
    exemplar = Exemplar.of(planes, usable=np.arange(40) != 7 * np.ones((36, 1)))
    smap = replace(noise_map((9, 11), (36, 40), 1), wrap=wrap)
    blocks = np.repeat(np.repeat(smap.yx, 6, 0), 4, 1)
    yx = np.minimum(blocks + np.stack(np.mgrid[:54, :44], 2) % 6, [35, 39])
    smap = SourceMap(yx.astype(np.int32), wrap=wrap)
    boxes = [Box(8, 6, 10, 44), Box(20, 0, 54, 22), Box(30, 30, 32, 32)]
    boxes += [Box(8, -60, 20, -10)] if wrap.x else []
    boxes += [Box(40, 4, 120, 10)] if wrap.y else []
    for radius in (3, 30):
        finish = (Levelling(radius, 0.7),)
        for name, scale in (("albedo", 1.0), ("height", 1.0), ("fine", 2.0), ("coarse", 0.5)):
            blend = Blend(feather, finish=finish)
            whole = render([exemplar], smap, name, blend, run=ONE).samples
            for box in boxes:
                y0, x0, y1, x1 = (int(v * scale) for v in (box.y0, box.x0, box.y1, box.x1))
                part = render([exemplar], smap, name, blend, box, Run(2)).samples
                crop = whole[np.ix_(np.arange(y0, y1) % len(whole), np.arange(x0, x1) % whole.shape[1])]
                assert part.tobytes() == crop.tobytes(), (name, box, radius)


def test_a_picture_of_many_cells_is_the_same_in_windows_and_with_any_threads() -> None:
    exemplar = Exemplar.of(Plane(texture(70, 80, 3), Kind.DATA))
    smap = ia.synthesize(exemplar, (300, 1100), ia.RandomTiling(patch=25), run=ONE).map
    whole = render([exemplar], smap, blend=levels(11), run=ONE).pixels
    assert whole.tobytes() == render([exemplar], smap, blend=levels(11), run=Run(2)).pixels.tobytes()
    part = render([exemplar], smap, blend=levels(11), box=Box(200, 900, 290, 1090), run=ONE).pixels
    assert (part == whole[200:290, 900:1090]).all()
    plain = render([exemplar], smap, run=ONE).pixels
    assert abs(whole.mean() - plain.mean()) < 0.01 * plain.mean()
    assert plain.min() <= whole.min()
    assert whole.max() <= plain.max()


@pytest.mark.parametrize("kind", [Kind.NORMAL, Kind.LABEL])
def test_normals_and_labels_are_drawn_as_without(kind: Kind) -> None:
    exemplar = Exemplar.of(Plane(pixels_of("uint8", (30, 30, 3)), kind))
    for feather in (0, 4):
        plain, got = (
            render([exemplar], noise_map((20, 20), (30, 30)), blend=b).pixels
            for b in (Blend(feather), levels(5, feather=feather))
        )
        assert (plain == got).all()


@pytest.mark.parametrize("dtype", DTYPES)
def test_a_uniform_exemplar_stays_uniform(dtype: str) -> None:
    for channels in (1, 3, 4):
        value = pixels_of(dtype, (1, 1, channels), 3)
        exemplar = Exemplar.of(np.broadcast_to(value, (9, 8, channels)))
        assert (render([exemplar], noise_map((15, 16), (9, 8)), blend=levels(4)).samples == value).all()


def test_opacity_stays_and_what_is_clear_tints_nothing() -> None:
    pixels = np.concatenate([lit("uint8").base.pixels[:40, 40:80], np.zeros((40, 40, 1), np.uint8)], axis=2)
    pixels[..., 3] = np.where(np.arange(40) % 5 < 2, 0, 255)
    loud = pixels.copy()
    loud[pixels[..., 3] == 0, :3] = 255 - loud[pixels[..., 3] == 0, :3]
    smap = cut_map(20, 20, 9, -12)
    a, b = (render([Exemplar.of(p)], smap, blend=levels(6)).pixels for p in (pixels, loud))
    plain = render([Exemplar.of(pixels)], smap).pixels
    assert (a[..., 3] == plain[..., 3]).all()
    assert (a != plain).any()
    seen = plain[..., 3] > 0
    assert (a[seen] == b[seen]).all()


def test_masked_pixels_are_never_read() -> None:
    usable = np.random.default_rng(1).random((30, 30)) < 0.7
    spots = np.argwhere(usable)
    smap = SourceMap(spots[np.random.default_rng(2).integers(0, len(spots), (20, 20))].astype(np.int32))
    pictures = []
    for junk in (np.nan, 1e30, -5.0):
        pixels = np.random.default_rng(0).random((30, 30, 3))
        pixels[~usable] = junk
        pictures.append(render([Exemplar.of(pixels, usable=usable)], smap, blend=levels(6)).pixels)
    assert np.isfinite(pictures[0]).all()
    assert (pictures[0] == pictures[1]).all()
    assert (pictures[0] == pictures[2]).all()


def test_what_cannot_be_is_refused_in_one_line() -> None:
    exemplar = Exemplar.of({"albedo": pixels_of("uint8", (6, 6)), "fine": pixels_of("uint8", (24, 24))})
    which = np.zeros((9, 9), np.uint8)
    which[4, 8] = HOLE
    holed = SourceMap(np.zeros((9, 9, 2), np.int32), which)
    cases = [
        (ia.ParameterError, lambda: Levelling(0), "radius=0 is not allowed; give 1 to 1024 px"),
        (ia.ParameterError, lambda: Levelling(2000), "radius=2000"),
        (ia.ParameterError, lambda: Levelling(4, 1.5), "strength=1.5 is not allowed; give 0 to 1"),
        (ia.ParameterError, lambda: Levelling(True), "radius=True"),
        (ia.ParameterError, lambda: Blend(0, finish=(32,)), "finish="),  # type: ignore[arg-type]
        (ia.ParameterError, lambda: Blend(0, finish=Levelling(32)), "finish="),  # type: ignore[arg-type]
        (ia.ParameterError, lambda: Blend(0, finish=(Levelling(6), Levelling(9))), "two of a kind"),
        (ia.ParameterError, lambda: render([exemplar], SourceMap(holed.yx), "fine", levels(300)), "at most 256 px"),
        (ia.ParameterError, lambda: render([exemplar], SourceMap(holed.yx), None, levels(3), Box(0, 0, 10, 4)), "0..9"),
        (ia.InputError, lambda: render([exemplar], holed, None, levels(3)), "1 holes"),
    ]
    for error, call, words in cases:
        with pytest.raises(error, match=words) as caught:
            call()
        assert "\n" not in str(caught.value)
    assert render([exemplar], holed, None, levels(3), Box(0, 0, 9, 8)).pixels.shape == (9, 8)


def test_maps_and_recipes_keep_it_and_old_ones_have_none(tmp_path: Path) -> None:
    finish = (Levelling(7, 0.25),)
    assert tuple(Levelling.read(f.as_recipe) for f in finish) == finish
    smap = SourceMap(np.zeros((4, 5, 2), np.int32), blend=Blend(2, finish=finish))
    smap.save(tmp_path / "m.npz")
    assert SourceMap.load(tmp_path / "m.npz").blend == smap.blend
    assert "finish" not in Blend(3).as_recipe  # maps without one stay as they always were
    assert Blend.of({"feather": 3, "mixing": "mean"}) == Blend(3)
    made = ia.synthesize(texture(30, 30, 3), 40, ia.RandomTiling(patch=10), blend=Blend(1, finish=finish))
    told = json.loads(made.recipe_text)["blend"]
    assert told["finish"][0] == {"name": "levelling", "radius": 7, "strength": 0.25}
    assert Blend.of(told) == made.blend
    assert (made.render(finish=()).pixels == render(made.exemplars, made.map, blend=Blend(1)).pixels).all()
    assert (made.render(feather=0).pixels == made.render(feather=0, finish=finish).pixels).all()


def test_the_command_line_levels_draws_again_and_replays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    ia.write("a.png", texture(40, 40, 3))

    def run(line: str, code: int = 0) -> str:
        done = CliRunner().invoke(cli, line.split(), prog_name="intarsia")
        assert done.exit_code == code, done.output
        return done.output

    grow = "grow a.png --method random-tiling --patch 12 --size 60 "
    run(grow + "-o plain.png")
    run(grow + "--even-tone 9 -o level.png --save-map m.npz")
    run(grow + "--even-tone 0 -o none.png")
    run("render m.npz -e a.png -o again.png")
    run("render m.npz -e a.png --even-tone 0 -o off.png")
    run("render m.npz -e a.png --even-tone 4 -o less.png")
    run("replay level.png -e a.png -o replayed.png")
    pixels = {p.stem: np.asarray(ia.read(p).base.pixels) for p in tmp_path.glob("*.png")}
    assert (pixels["level"] != pixels["plain"]).any()
    assert (pixels["less"] != pixels["level"]).any()
    for same, other in (("none", "plain"), ("off", "plain"), ("again", "level"), ("replayed", "level")):
        assert (pixels[same] == pixels[other]).all(), same
    assert (tmp_path / "none.png").read_bytes() == (tmp_path / "plain.png").read_bytes()
    run(grow + "--even-tone -1 -o x.png", 2)
    run(grow + "--even-tone 2000 -o x.png", 2)
    assert "No such option" in run("extend a.png --even-tone 3 -o x.png", 2)  # there, known pixels stay
    assert "No such option" in run("heal a.png --mask a.png --even-tone 3 -o x.png", 2)


LIES = (
    None, 3, [3], [{}], [[]], ["x"], [{"name": "shine"}], [{"name": []}], [{"name": "levelling", "radius": 0}],
    [{"name": "levelling", "colour": 1}],
)  # fmt: skip


@pytest.mark.parametrize("finish", LIES)
def test_a_saved_finish_that_lies_is_refused(finish: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    smap = SourceMap(np.zeros((4, 5, 2), np.int32))
    recipe = smap.blend.as_recipe | {"finish": finish}
    monkeypatch.setattr(Blend, "as_recipe", property(lambda _: recipe))
    smap.save(tmp_path / "m.npz")
    with pytest.raises(ia.InputError, match=r"m\.npz is no map of intarsia"):
        SourceMap.load(tmp_path / "m.npz")
