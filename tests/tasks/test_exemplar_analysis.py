"""What is found in an exemplar is told, drawn and written; what is not found is said in one line."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.cli import cli
from intarsia.foundation import OVERLAYS
from intarsia.regular.block_grid import phase_of
from intarsia.regular.tile_search import period_difference
from intarsia.segments import segments
from intarsia.tasks.drawings import segment_overlay
from intarsia.testing import texture
from intarsia.testing.cases import noise


def weave(height: int = 120, width: int = 132, rows: float = 20, columns: float = 24, grain: int = 40) -> Any:
    """Tiles of different grey with dark joints at whole multiples."""
    y, x = np.mgrid[:height, :width].astype(float)
    joint = (y % rows < 3) | (x % columns < 3)
    face = (noise(64, 64, 5)[(y // rows).astype(int), (x // columns).astype(int)] % np.uint64(grain)).astype(int)
    speck = (noise(height, width, 7) % np.uint64(9)).astype(int)
    return np.where(joint, 20, 140 + face + speck).astype(np.uint8)


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    ia.write("weave.png", weave())
    ia.write("blobs.png", texture(90, 80, 3))


def run(*args: object, code: int = 0, data: bytes | None = None) -> Result:
    result = CliRunner().invoke(cli, ["analyze", *(str(a) for a in args)], input=data)
    assert result.exit_code == code, result.stderr
    return result


def told(*args: object) -> dict[str, Any]:
    answer: dict[str, Any] = json.loads(run(*args, "--json").stdout)
    return answer


def refused(*args: object, code: int) -> str:
    """One line on stderr, and nothing written."""
    before = sorted(Path().iterdir())
    line = run(*args, code=code).stderr
    assert line.startswith("intarsia: ")
    assert line.count("\n") == 1
    assert sorted(Path().iterdir()) == before
    return line


class TestTold:
    def test_two_vectors_with_reasons(self) -> None:
        found = told("weave.png")
        vectors = found["lattice"]["vectors"]
        assert sorted(abs(round(x)) + abs(round(y)) for x, y in vectors) == [20, 24]
        assert sorted(found["lattice"]["periods"]) == pytest.approx([20, 24], abs=0.2)
        assert found["lattice"]["reasons"][-1].startswith("Accepted")
        assert found["file"] == "weave.png"
        assert found["exemplar"]["size"] == [132, 120]
        assert found["suggested"]["why"]
        assert found["suggested"] | {"why": 0, "rule": 0} == {
            "method": "near-regular", "parameters": {"lattice": vectors}, "flatten": False, "why": 0, "rule": 0,
        }  # fmt: skip

    def test_one_vector_across_the_rows(self) -> None:
        y, _ = np.mgrid[:128, :150]
        grain = (noise(128, 150, 3) % np.uint64(60)).astype(int)
        ia.write("rows.png", np.where(y % 16 < 3, 10, 120 + grain).astype(np.uint8))
        found = told("rows.png")
        ((x, y),) = found["lattice"]["vectors"]
        assert abs(x) < 1
        assert abs(y) == pytest.approx(16, abs=0.3)
        assert "nothing returns along them" in run("rows.png").stdout

    def test_no_lattice_lists_candidates(self) -> None:
        ia.write("blobs.png", texture(200, 210, 3), force=True)
        found = told("blobs.png")
        assert found["lattice"] is None
        assert len(found["candidates"]) >= 3
        assert all("confidence" in one and len(one["vectors"]) in (1, 2) for one in found["candidates"])
        assert found["suggested"]["method"] == "graphcut"
        text = run("blobs.png").stdout
        assert "lattice      none. " in text
        assert text.count("\ncandidate ") == 3
        assert "--method graphcut" in text

    def test_equal_periods_suggest_the_best_tile_and_one_colour_repetition(self) -> None:
        tile = weave(20, 24)
        ia.write("same.png", np.tile(tile, (6, 5)))
        assert told("same.png")["suggested"]["method"] == "best-tile"
        ia.write("flat.png", np.full((40, 40, 3), 90, np.uint8))
        assert told("flat.png")["suggested"] == {
            "method": "repeat", "parameters": {}, "flatten": False, "why": ["All of it has one colour."],
            "rule": "one-colour",
        }  # fmt: skip

    @pytest.mark.parametrize("name", ["weave.png", "blobs.png"])
    def test_the_printed_options_are_those_of_grow(self, name: str) -> None:
        line = next(s for s in run(name).stdout.splitlines() if s.startswith("suggested"))
        words = shlex.split(line)[1:]
        done = CliRunner().invoke(cli, ["grow", name, "-o", "out.png", "-q", "--size", "80", *words])
        assert done.exit_code == 0, done.stderr

    def test_a_slope_of_light_suggests_to_flatten(self) -> None:
        ramp = np.linspace(1.0, 0.45, 264)[None, :]
        ia.write("lit.png", (weave(240, 264) * ramp).astype(np.uint8))
        found = told("lit.png")
        assert found["light"]["strong"]
        assert found["light"]["factor"] > 2
        assert found["suggested"]["flatten"]
        text = run("lit.png").stdout
        assert "a strong slope" in text
        assert " --flatten\n" in text
        even = told("lit.png", "--flatten")
        assert not even["light"]["strong"]
        assert even["suggested"]["flatten"], "it was asked for, so the suggestion needs it"
        assert not told("weave.png")["light"]["strong"]

    def test_several_are_told_one_after_the_other(self) -> None:
        found = told("weave.png", "blobs.png", "--several")
        assert [one["file"] for one in found["results"]] == ["weave.png", "blobs.png"]
        text = run("weave.png", "blobs.png", "--several").stdout
        assert text.startswith("weave.png: 132x120 px\n")
        assert "\n\nblobs.png: 80x90 px\n" in text

    def test_library_and_command_say_the_same(self) -> None:
        found = told("weave.png")
        assert {k: v for k, v in found.items() if k not in ("file", "warnings")} == ia.analyze("weave.png").as_dict()

    def test_a_mask_and_a_crop_are_heeded(self) -> None:
        assert told("weave.png", "--crop", "0,0,100,90")["exemplar"]["size"] == [100, 90]
        mask = np.full((120, 132), 255, np.uint8)
        mask[:70, :60] = 0
        ia.write("mask.png", mask)
        found = told("weave.png", "--mask", "mask.png")
        assert found["lattice"] is not None
        assert sum(g["share"] for g in found["segments"]["groups"]) == pytest.approx(1, abs=1e-3)


class TestSegments:
    def test_groups_patch_zone_and_rule_are_told(self) -> None:
        """What is told is what the method segment-based goes by, and which rule it came from."""
        seen, found = told("weave.png")["segments"], segments(ia.read("weave.png"))
        assert (seen["patch"], seen["zone"], seen["rule"], seen["why"]) == (
            found.patch, found.zone, "segments", found.why)  # fmt: skip
        assert seen["count"] == len(found.groups) == sum(g["segments"] for g in seen["groups"])
        assert seen["chosen"] == found.chosen
        assert seen["groups"][found.chosen]["segments"] == int((found.groups == found.chosen).sum())
        assert seen["groups"][found.chosen]["share"] == pytest.approx(float((found.group_map == found.chosen).mean()),
                                                                      abs=1e-4)  # fmt: skip
        assert sum(g["share"] for g in seen["groups"]) == pytest.approx(1, abs=1e-3)
        page = run("weave.png").stdout
        assert f"group {found.chosen} is chosen: {seen['groups'][found.chosen]['segments']} of them" in page
        assert f"patch {found.patch} px, boundary zone {found.zone} px, by rule segments: " in page

    def test_without_a_group_the_rule_is_the_autocorrelation(self) -> None:
        ia.write("gray.png", np.full((40, 50), 90, np.uint8))
        seen = told("gray.png")["segments"]
        assert (seen["chosen"], seen["rule"]) == (None, "autocorrelation")
        page = run("gray.png").stdout
        assert "1 in 1 group; none is chosen" in page
        assert "by rule autocorrelation: the exemplar is constant." in page


class TestDrawn:
    def test_the_overlay_lies_on_the_joints(self) -> None:
        """Its points lie a lattice vector apart, where blocks begin; beside the lines the picture stays."""
        found, plain = ia.analyze("weave.png"), weave()
        drawn = found.overlay().pixels.astype(int)
        assert drawn.shape == (120, 132, 3)
        changed = (drawn != plain[..., None]).any(axis=2)
        assert 0.1 < changed.mean() < 0.45
        cell = found.lattice.vectors
        y, x = phase_of(features([found.exemplar]).pictures[0], cell)
        assert y % 20 < 3.1
        assert x % 24 < 3.1
        for i in range(1, 5):
            for j in range(1, 5):
                at = drawn[int(y % 20 + 20 * i), int(x % 24 + 24 * j)]
                assert at.min() > 200, "a white point"

    def test_lines_show_on_white_and_on_black(self) -> None:
        for value in (0, 255):
            pixels = np.where(weave(grain=1) < 100, value, abs(value - 12)).astype(np.uint8)
            drawn = ia.analyze(pixels).overlay().pixels.astype(int)
            apart = np.abs(drawn - value).max(axis=2)
            lines = (drawn[..., 0] != drawn[..., 2]) | (drawn[..., 0] > 240)
            assert lines.any()
            assert apart[drawn[..., 0] != drawn[..., 2]].max() > 100

    @pytest.mark.parametrize("depth", ["uint8", "uint16", "float32"])
    def test_pictures_of_any_depth_and_opacity_are_drawn_over(self, depth: str) -> None:
        top = 1.0 if depth == "float32" else np.iinfo(depth).max
        pixels = (weave() / 255 * top).astype(depth)
        clear = np.dstack([pixels, np.full(pixels.shape, top, depth)])
        for one in (ia.analyze(pixels), ia.analyze(clear)):
            for drawn in map(one.overlay, OVERLAYS):
                assert (drawn.pixels.dtype, drawn.pixels.shape) == (np.uint8, (120, 132, 3))
        with pytest.raises(ia.ParameterError, match="overlay=magic is unknown"):
            one.overlay("magic")

    def test_segments_are_drawn_with_or_without_a_lattice(self) -> None:
        exemplar = ia.read("blobs.png")
        assert (ia.analyze("blobs.png").overlay("segments").pixels == segment_overlay(exemplar)).all()


class TestTile:
    def test_it_is_one_period_of_the_exemplar_upright(self) -> None:
        tile = ia.analyze("weave.png").best_tile()
        x, y = tile.corner
        assert np.array_equal(tile.planes["albedo"].pixels, weave()[y : y + 20, x : x + 24])

    def test_depth_and_all_planes_are_kept(self) -> None:
        deep = weave().astype(np.uint16) * 257
        planes = ia.analyze(ia.Exemplar.of({"albedo": np.dstack([deep] * 3), "height": deep})).best_tile().planes
        colour, height = planes["albedo"].pixels, planes["height"].pixels
        assert colour.dtype == height.dtype == np.uint16
        assert np.array_equal(colour[..., 0], height)

    def test_an_oblique_lattice_has_no_such_tile(self) -> None:
        y, x = np.mgrid[:200, :220].astype(float)
        a, b = (x * 23.3 - y * 7.9) / 640.0, (x * 6.1 + y * 25.4) / 640.0
        waves = 127 + 60 * np.cos(2 * np.pi * a) + 60 * np.cos(2 * np.pi * b)
        found = ia.analyze(np.dstack([waves.astype(np.uint8)] * 3))
        assert found.lattice is not None
        with pytest.raises(ia.MethodError, match="no rectangle of at most 8 periods of exemplar 1 repeats"):
            found.best_tile()

    def test_unlikeness_is_its_plain_form(self) -> None:
        picture = features([ia.Exemplar.of(texture(30, 40, 3, 1))]).pictures[0]
        usable = np.ones((30, 40), bool)
        usable[3, 4] = False
        total, count = 0, 0
        for dy, dx in ((9, 2), (-3, 11)):
            for y in range(30):
                for x in range(40):
                    i, j = y + dy, x + dx
                    if 0 <= i < 30 and 0 <= j < 40 and usable[y, x] and usable[i, j]:
                        total += ((picture[y, x].astype(int) - picture[i, j]) ** 2).sum()
                        count += 1
        spread = 2 * picture[usable].astype(float).var(axis=0).sum()
        found = period_difference(picture, ((9 * 256, 2 * 256), (-3 * 256, 11 * 256)), usable)
        assert found == pytest.approx(np.sqrt(total / count / spread))


class TestRefused:
    @pytest.mark.parametrize("asked", ["best_tile", "overlay"])
    def test_no_lattice_no_picture(self, asked: str) -> None:
        with pytest.raises(ia.MethodError, match=r"has no lattice \(confidence 0\..*grow it with method graphcut"):
            getattr(ia.analyze("blobs.png"), asked)()

    @pytest.mark.parametrize(
        ("args", "code", "message"),
        [
            (("weave.png", "--crop", "0,0,999,9"), 2, "--crop 0,0,999,9 does not lie in"),
            (("weave.png", "--toroidal", "--flatten"), 2, "--flatten does not go with --toroidal"),
        ],
    )
    def test_what_cannot_be_done_is_said_in_one_line(self, args: tuple[str, ...], code: int, message: str) -> None:
        result = run(*args, code=code)
        assert message in result.stderr.splitlines()[-1]
        assert not result.stdout
