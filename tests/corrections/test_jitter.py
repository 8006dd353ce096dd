"""parallel-controllable with numbers for every pixel: where it jitters, what of the exemplar stays as it is."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from methods.test_parallel_controllable import naive, toy
from scipy.ndimage import label

import intarsia as ia
from intarsia import files
from intarsia.cli import cli
from intarsia.corrections.coordinate_pyramid import local_jitter
from intarsia.foundation.geometry import Box
from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.testing.cases import texture

ONE = Run(threads=1)
FREE = ia.ParallelControllable(jitter=(0.3, 0.2, 0.5), passes=1)
COLOUR = ia.Correction2008(jitter=(0.3, 0.2, 0.5), passes=1, rule="near")


def waves(y: Any, x: Any) -> Any:  # sixteenths, so that shares of the jitter are whole numbers
    return (y + 2 * x) % 16 / 16


def spots(y: Any, x: Any) -> Any:
    return (3 * y + x) % 8 / 8


TWINS = {
    "output": replace(FREE, jitter_output=waves), "exemplar": replace(COLOUR, jitter_exemplar=spots),
    "both": replace(FREE, jitter_output=waves, jitter_exemplar=spots), "number": replace(FREE, jitter_output=0.25),
    "edges": replace(FREE, feature="edges"), "mask": replace(COLOUR, feature=spots, feature_weight=3.0),
}  # fmt: skip


def picture(height: int, width: int, deep: bool = False) -> Any:
    y, x = np.mgrid[:height, :width]
    return ((7 * y + 13 * x) % 256).astype(np.uint16) * 257 if deep else ((7 * y + 13 * x) % 256).astype(np.uint8)


@pytest.mark.parametrize("toroidal", [False, True])
@pytest.mark.parametrize("name", TWINS)
def test_the_controls_do_what_the_plain_twin_says(name: str, toroidal: bool) -> None:
    e, method = toy(toroidal=toroidal), TWINS[name]
    twin = naive(method, e, 11)
    twin.share = lambda p, u: _of(method.jitter_output, p) * _of(method.jitter_exemplar, u)
    box = Box(-3, 1 << 33, 1, (1 << 33) + 5)
    got = method.window([e], box, 11, ONE).yx
    expected = [[twin.final(y, x) for x in range(box.x0, box.x1)] for y in range(box.y0, box.y1)]
    assert got.tolist() == [[list(u) for u in row] for row in expected]


def _of(given: Any, at: tuple[int, int]) -> float:
    if given is None or isinstance(given, float):
        return 1.0 if given is None else given
    return float(given.value(*at))


def halves(y: Any, x: Any) -> Any:
    return (x + 0 * y) // 16 % 2


@pytest.mark.parametrize("name", ["jitter_output", "jitter_exemplar"])
def test_coarse_levels_are_corrected_where_some_of_the_jitter_holds(name: str) -> None:
    """An exemplar of four such levels: the coarsest is left alone where the share is black."""
    e, method = toy(36, 40), replace(FREE, **{name: halves})
    twin = naive(method, e, 11)
    twin.share = lambda p, u: float(halves(*(p if name == "jitter_output" else u)))
    got = method.window([e], Box(3, 7, 5, 11), 11, ONE).yx
    assert got.tolist() == [[list(twin.final(y, x)) for x in range(7, 11)] for y in range(3, 5)]


def test_shares_are_multiplied_and_rounded_to_the_nearest() -> None:
    """Half of 3 / 4096 px is 2; as far as the map is wide, with coordinates of any size."""
    coords = np.array([[[a + s, b] for b in (0, 2)] for a, s in ((0, -1), (0, 1), (3, 9))])
    exemplar = np.arange(12).reshape(4, 3) * 300
    output = np.array([[4096, 2048]] * 3)
    got = local_jitter(1 << 30, output, exemplar, coords)
    read = [[exemplar[y % 4, x] for y, x in row] for row in coords.tolist()]
    assert got.tolist() == [[(near << 30) // 4096, (far << 29) // 4096] for near, far in read]
    assert local_jitter(3, np.array([[2048]]), np.array([[4096]]), coords).tolist() == [[2, 2]] * 3


CONTROLS: dict[str, dict[str, Any]] = {
    "function": {"jitter_output": waves}, "picture": {"jitter_output": picture(61, 53)},
    "exemplar": {"jitter_exemplar": picture(70, 90, deep=True)},
    "both": {"jitter_output": picture(61, 53), "jitter_exemplar": spots},
    "edges": {"feature": "edges", "feature_weight": 2}, "mask": {"feature": picture(70, 90)},
}  # fmt: skip


@pytest.mark.parametrize("name", CONTROLS)
def test_windows_are_crops(name: str) -> None:
    """Across 0 and far away, where a picture's border goes on; threads change nothing."""
    e, method = Exemplar.of(texture(70, 90, 3, 8)), ia.ParallelControllable(**CONTROLS[name])
    for y, x in ((-20, -31), (2**31 - 33, -(2**31) - 17)):
        whole = method.window([e], Box(y, x, y + 90, x + 70), 5, ONE)
        for part in (Box(11, 13, 75, 70), Box(0, 40, 33, 41), Box(89, 0, 90, 70)):
            alone = method.window([e], Box(y + part.y0, x + part.x0, y + part.y1, x + part.x1), 5, ONE)
            assert alone.digest == whole.window(part).digest
        assert method.window([e], Box(y, x, y + 90, x + 70), 5, Run(threads=3)).digest == whole.digest
    texture_ = ia.weave(e, method, 5)
    assert (texture_[-20:70, -31:39] == texture_[-40:90, -60:60][20:110, 29:99]).all()
    assert (pickle.loads(pickle.dumps(texture_))[0:40, 0:30] == texture_[0:40, 0:30]).all()


@pytest.mark.parametrize("field", ["jitter_output", "jitter_exemplar"])
def test_none_of_the_jitter_tiles_and_all_of_it_changes_nothing(field: str) -> None:
    e, tiled = Exemplar.of(texture(37, 50, 3, 5), toroidal=True), np.mgrid[:80, :110].transpose(1, 2, 0) % (37, 50)
    size = (80, 110) if field == "jitter_output" else (37, 50)

    def grown(**given: Any) -> Any:
        return ia.synthesize(e, (80, 110), ia.ParallelControllable(**given), seed=3, run=ONE).map

    for none in (0, np.zeros(size), np.zeros(size, np.uint8), lambda y, x: 0 * y * x):
        assert (grown(**{field: none}).yx == tiled).all()
    for every in (1, np.ones(size), np.full(size, 65535, np.uint16), lambda y, x: 1):
        assert grown(**{field: every}).digest == grown().digest


@pytest.mark.parametrize("jitter", [None, 0.6])
def test_a_share_of_none_is_no_jitter(jitter: float | None) -> None:
    """Byte for byte, also on an exemplar that is no torus; no seam of its copies is mended on coarse levels."""
    e, still = Exemplar.of(texture(70, 90, 3, 8)), ia.ParallelControllable(jitter=0)
    wanted = ia.synthesize(e, (120, 200), still, seed=3, run=ONE).map.digest
    for name, black in (("jitter_output", np.zeros((120, 200))), ("jitter_exemplar", np.zeros((70, 90)))):
        for none in (0, black):
            method = ia.ParallelControllable(jitter=jitter, **{name: none})
            assert ia.synthesize(e, (120, 200), method, seed=3, run=ONE).map.digest == wanted


@pytest.mark.parametrize("edge", [256, 320])
def test_the_black_side_stays_as_it_is_without_jitter(edge: int) -> None:
    """Up to 40 px from the white side, and half a piece of the coarsest level where the edge runs through it."""
    e, light = Exemplar.of(texture(128, 128, 3, 8)), np.zeros((256, 512))
    light[:, edge:] = 1
    kept = edge - 40 - edge % 128
    calm, half = (
        ia.synthesize(e, (256, 512), ia.ParallelControllable(jitter=j, jitter_output=s), seed=3, run=ONE).map.yx
        for j, s in ((0, None), (0.6, light))
    )
    assert (half[:, :kept] == calm[:, :kept]).all()
    assert (half[:, edge:] != calm[:, edge:]).any(axis=2).mean() > 0.9


def test_dark_parts_of_the_exemplar_stay_as_they_are() -> None:
    """Pieces are jittered, on the levels of 16 and 32 px, but the pixels of what comes from the dark half are not."""
    e = Exemplar.of(texture(96, 96, 3, 5), toroidal=True)
    light = np.ones((96, 96))
    light[:, :48] = 0
    fine = ia.ParallelControllable(jitter=(1, 1, 0), passes=0, jitter_exemplar=light)
    yx = ia.synthesize(e, (192, 192), fine, seed=3, run=ONE).map.yx
    y, x = np.mgrid[:192, :192] % 96
    assert (yx[x < 48] == np.stack([y, x], axis=2)[x < 48]).all()
    assert (yx[x >= 51] == np.stack([y, x], axis=2)[x >= 51]).all(axis=1).mean() < 0.1
    pieces = replace(fine, jitter=(1, 1, 0, 0, 0.5, 0.5, 0))
    yx = ia.synthesize(e, (192, 192), pieces, seed=3, run=ONE).map.yx
    on = (yx[:, 1:] == yx[:, :-1] + (0, 1)).all(axis=2)
    dark = (yx[:, 1:, 1] < 48) & (yx[:, :-1, 1] < 48)
    assert on[dark].mean() > 0.9
    assert on[~dark].mean() < 0.2


def test_pictures_of_the_wrong_size_are_refused_before_work() -> None:
    e = toy()
    cases: list[tuple[dict[str, Any], str]] = [
        ({"jitter_output": np.ones((30, 41))}, r"^the picture jitter_output is 41x30 px, the output 40x30; make them"),
        ({"feature": picture(30, 40)}, r"^the picture feature is 40x30 px, the exemplar 18x21; make them equal"),
        ({"feature": np.ones((21, 18))}, r"^feature is light everywhere, and so has no outline; paint white what"),
        ({"feature": np.zeros((21, 18))}, r"^feature is dark everywhere, and so has no outline"),
        ({"jitter_exemplar": np.ones((30, 40))}, r"^the picture jitter_exemplar is 40x30 px, the exemplar 18x21; make"),
    ]
    for values, message in cases:
        method = ia.ParallelControllable(**values)
        for chosen in (method, ia.Auto(given=values)):
            with pytest.raises(ia.InputError, match=message):
                ia.synthesize(e, (30, 40), chosen)
        if "jitter_output" in values:
            assert ia.weave(e, method)[0:50, 0:60].shape == (50, 60, 3)
        else:
            with pytest.raises(ia.InputError, match=message):
                ia.weave(e, method)


def test_a_number_is_no_feature() -> None:
    for value in (0.5, 1, ia.Field(0.5), "lines", True):
        with pytest.raises(ia.ParameterError, match=r"^feature=.* is not allowed; give edges, or a gray picture over"):
            ia.ParallelControllable(feature=value)


def test_a_feature_is_part_of_what_is_remembered() -> None:
    e = Exemplar.of(texture(48, 48, 3, 8))
    kinds: list[dict[str, Any]] = [
        {}, {"feature": "edges"}, {"feature": "edges", "feature_weight": 3}, {"feature": picture(48, 48)},
        {"feature": picture(48, 48).T},
    ]  # fmt: skip
    kinds += [*kinds, {"feature": "edges", "feature_weight": 0}]
    maps = [ia.synthesize(e, 120, ia.ParallelControllable(**k), seed=2, run=ONE).map.digest for k in kinds]
    assert len(set(maps)) == 5
    assert maps[5:] == [*maps[:5], maps[0]]


def test_a_mask_keeps_together_what_colours_do_not_tell_apart() -> None:
    """Discs of the same grain as the ground: with their mask fewer are cut to shreds."""
    y, x = np.mgrid[:96, :96]
    inside = (y % 32 - 15.5) ** 2 + (x % 32 - 15.5) ** 2 < 110
    e = Exemplar.of(np.random.default_rng(1).integers(0, 256, (96, 96), np.uint8), toroidal=True)
    shreds = []
    for values in ({}, {"feature": inside}):
        yx = ia.synthesize(e, 256, ia.ParallelControllable(jitter=0.5, **values), seed=1, run=ONE).map.yx
        areas = np.bincount(label(inside[yx[..., 0], yx[..., 1]])[0].ravel())[1:]
        shreds.append(int((areas < 100).sum()))
    assert shreds[1] < 0.7 * shreds[0]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    gray = picture(40, 50)
    for name, pixels in {
        "e": texture(30, 34, 3, 5), "map": gray, "deep": picture(40, 50, deep=True), "rgb": np.dstack([gray] * 3),
        "other": gray[::-1], "clear": texture(40, 50, 2, 5), "small": picture(30, 34),
    }.items():  # fmt: skip
        files.write(f"{name}.png", ia.Plane(pixels))
    files.write("wild.exr", ia.Plane(gray.astype(np.float32), transfer="linear"))


def run(*words: str, data: bytes | None = None) -> tuple[int, str]:
    result = CliRunner().invoke(cli, [*words, "-q"], input=data)
    assert result.exit_code == 0 or len(result.stderr.splitlines()) == 1, result.stderr
    return result.exit_code, result.stderr


GROW = ("grow", "e.png", "--size", "50x40", "--force", "-o")


def test_the_command_line_reads_gray_pictures_of_any_depth(here: None) -> None:
    jitter = "--jitter-output", "map.png", "--jitter-exemplar", "small.png"
    assert run(*GROW, "a.png", "--even-tone", "0", *jitter) == (0, "")
    method = ia.ParallelControllable(jitter_output=picture(40, 50), jitter_exemplar=picture(30, 34))
    wanted = ia.synthesize("e.png", (40, 50), method)
    assert (files.read_plane("a.png").pixels == wanted.render().pixels).all()
    assert files.read_recipe("a.png")["parameters"] == wanted.recipe["parameters"]  # type: ignore[index]
    for name in ("map.png", "deep.png", "rgb.png", "-"):
        data = Path("map.png").read_bytes() if name == "-" else None
        assert run(*GROW, "b.png", "--jitter-output", name, data=data) == (0, "")
        again = run("replay", "b.png", "-e", "e.png", "-o", "c.png", "--force", "--picture", "jitter_output=map.png")
        assert again == (0, "")
        assert Path("b.png").read_bytes() == Path("c.png").read_bytes()
    size = "weave", "e.png", "-o", "w.tif", "--size", "90x70", "--jitter-output", "map.png"
    assert run(*size) == (0, "")


@pytest.mark.parametrize(
    ("value", "code", "told"),
    [("missing.png", 3, "missing.png does not exist"), ("e.png", 3, "e.png is a colour picture"),
     ("clear.png", 3, "clear.png is transparent in parts"), ("wild.exr", 3, "of wild.exr, it holds numbers"),
     ("small.png", 3, "the picture jitter_output is 34x30 px, the output 50x40"), ("", 3, "'' is no name of a file"),
     ("2", 2, "jitter_output=2.0 is not allowed"), ("nan", 2, "jitter_output=nan is not allowed")],
)  # fmt: skip
def test_what_is_no_gray_picture_is_refused_in_one_line(here: None, value: str, code: int, told: str) -> None:
    found = run(*GROW, "a.png", "--jitter-output", value)
    assert (found[0], told in found[1]) == (code, True), found
    assert not Path("a.png").exists()


def test_replay_wants_the_pictures_again(here: None) -> None:
    assert run(*GROW, "a.png", "--jitter-output", "map.png")[0] == 0
    replay = "replay", "a.png", "-e", "e.png", "-o", "b.png"
    for words, code, told in (
        ((), 2, "a.png was made with a picture as jitter_output; name it with --picture jitter_output=FILE."),
        (("jitter_output=other.png",), 3, "other.png is another picture than the recipe has as jitter_output"),
        (("jitter_output=small.png",), 3, "small.png is another picture than the recipe has as jitter_output"),
        (("jitter_output=missing.png",), 3, "missing.png does not exist"),
        (("jitter_output=map.png", "k=map.png"), 2, "a.png was made without a picture as k; drop --picture k=FILE."),
    ):
        found = run(*replay, *(part for w in words for part in ("--picture", w)))
        assert (found[0], told in found[1]) == (code, True), found
    assert not Path("b.png").exists()
    made = ia.synthesize("e.png", (40, 50), ia.ParallelControllable(jitter_output=waves))
    files.write("f.png", made.render(), recipe=made.recipe_text)
    found = run("replay", "f.png", "-e", "e.png", "-o", "b.png", "--picture", "jitter_output=map.png")
    assert found[0] == 3
    assert f"jitter_output of f.png is the function {__name__}.waves, which no recipe holds" in found[1]
