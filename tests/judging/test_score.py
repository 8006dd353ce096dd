"""The score: anchors at their ends, worse is lower, nothing but the pixels counts, and the command says the same."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from judging.naive_windows import blobs
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

import intarsia as ia
from intarsia.cli import cli
from intarsia.judging import PartScore, Score
from intarsia.judging.parts import PARTS, TEXTURE
from intarsia.judging.sources import Reference
from intarsia.model.sourcemap import HOLE
from intarsia.seams import energy
from intarsia.tasks.scoring import outcome_of
from unweighed import beside, meeting, of_picture

Pixels = NDArray[np.uint8]


def stones(side: int = 128, seed: int = 1) -> Pixels:
    """Blobs that do not return."""
    return (blobs(side, side, seed) // 4).astype(np.uint8)


STONES = stones()


def tiled(pixels: Pixels, square: int, side: int = 256) -> Pixels:
    """Squares of a picture, side by side, from places in no order."""
    out = np.empty((side, side, pixels.shape[2]), pixels.dtype)
    for k, (y, x) in enumerate(np.ndindex(side // square, side // square)):
        i, j = (k * 37) % (len(pixels) - square), (k * 53) % (len(pixels) - square)
        out[y * square : (y + 1) * square, x * square : (x + 1) * square] = pixels[i : i + square, j : j + square]
    return out


def test_the_exemplar_itself_lacks_nothing() -> None:
    found = ia.score(STONES, STONES)
    assert found.parts["joins"].measured == found.parts["blurred"].measured == 0
    exemplar = ia.Exemplar.of(STONES)
    assert of_picture(exemplar, exemplar)["strange"] == 0
    assert of_picture(exemplar, exemplar)["lost"] <= 10
    assert found.total > 90


def test_tiles_are_the_bad_end_of_joins() -> None:
    reference = Reference(((blobs(128, 128, 1)),), (None,))
    found = ia.score((reference.pictures[0]).astype(np.uint16), reference.tiles.astype(np.uint16))
    assert found.parts["joins"].normalised < 0.1
    assert found.parts["joins"].bad > 5


def test_smaller_pieces_are_worse() -> None:
    joins = [ia.score(STONES, tiled(STONES, square)).parts["joins"].measured for square in (64, 32, 16)]
    assert joins == sorted(joins)
    assert joins[0] < joins[1] < joins[2]


def test_what_is_shown_again_and_again_is_worse() -> None:
    even = np.tile(STONES, (2, 2, 1))
    often = np.tile(STONES[:32, :32], (8, 8, 1))
    few, many = ia.score(STONES, even), ia.score(STONES, often)
    assert few.parts["overused"].measured < many.parts["overused"].measured
    exemplar, *pictures = (ia.Exemplar.of(p) for p in (STONES, even, often))
    lost = [of_picture(exemplar, picture)["lost"] for picture in pictures]
    assert lost[0] < lost[1]
    assert many.total < few.total


def test_what_strikes_is_seen_to_return() -> None:
    """One red pebble in noise: shown as often as area asks, or nine times where four are due."""
    grain = np.random.default_rng(4).integers(90, 160, (128, 128, 3)).astype(np.uint8)
    grain[40:56, 70:86] = (250, 20, 20)
    due = np.tile(grain, (2, 2, 1))
    often = due.copy()
    for y, x in ((8, 8), (8, 120), (120, 20), (110, 110), (200, 130)):
        often[y : y + 48, x : x + 48] = grain[24:72, 54:102]
    few, many = (ia.score(grain, picture).parts["salient"].measured for picture in (due, often))
    assert few < 1.2
    assert many > 1.5 * few


def test_what_strikes_counts_in_the_exemplar_that_it_is_in() -> None:
    grain = np.random.default_rng(5).integers(90, 160, (2, 112, 144, 3)).astype(np.uint8)
    grain[1, 40:56, 70:86] = (250, 20, 20)
    both = [ia.Exemplar.of(part) for part in grain]
    often = np.tile(grain[1, 24:72, 54:102], (5, 5, 1))
    assert ia.score(both, ia.Exemplar.of(often)).parts["salient"].measured > 4
    assert ia.score(both[:1], ia.Exemplar.of(grain[0])).parts["salient"].measured < 1.5


def test_repeats_count_by_the_grain_alone() -> None:
    """Where every window of the exemplar returns, nobody sees that one was shown often."""
    wall = np.tile(stones(16, 4), (8, 8, 1))
    found = ia.score(wall, wall)
    assert found.grain == 0
    assert found.loss("overused") == found.loss("repeats") == 0
    assert ia.score(STONES, STONES).grain > 0.5


def test_a_blur_is_seen_and_sharper_is_no_better() -> None:
    soft = gaussian_filter(STONES.astype(float), (1.5, 1.5, 0)).astype(np.uint8)
    assert ia.score(STONES, soft).parts["blurred"].measured > 10
    assert ia.score(soft, STONES).parts["blurred"].measured == 0


def test_total_is_the_formula_of_the_page() -> None:
    parts = {p.name: PartScore(p, 0.25 * p.good + 0.75 * (p.bad or 8.0), p.good, p.bad or 8.0) for p in PARTS}
    found = Score(parts, 0.5)
    lost = sum(p.weight * (0.5 if p.grainy else 1) * 0.75**0.5 for p in PARTS if p is not TEXTURE)
    assert found.total == pytest.approx(0.25 * 100 * (1 - lost))
    assert sum(found.loss(name) for name in parts) == pytest.approx(1 - found.total / 100)
    assert sum(p.weight for p in PARTS if p is not TEXTURE) == pytest.approx(1)
    assert {p.name for p in PARTS if p.grainy} == {"overused", "salient", "repeats"}


def test_depth_and_form_count_nothing() -> None:
    output = tiled(STONES, 32)
    first = ia.score(STONES, output).as_dict()
    assert ia.score(STONES.astype(np.uint16) * 257, output.astype(np.uint16) * 257).as_dict() == first
    assert ia.score([ia.Exemplar.of(STONES)], ia.Exemplar.of(output)).as_dict() == first


def test_unusable_pixels_are_no_source() -> None:
    usable = np.ones(STONES.shape[:2], bool)
    usable[:, 64:] = False
    masked = ia.Exemplar.of(STONES, usable=usable)
    inside, outside = (ia.score(masked, STONES[:, part]) for part in (slice(0, 64), slice(64, 128)))
    assert inside.parts["joins"].measured == 0
    assert outside.parts["joins"].measured > 5
    halves = [of_picture(masked, ia.Exemplar.of(STONES[:, part])) for part in (slice(64, 128), slice(0, 64))]
    assert halves[0]["strange"] > halves[1]["strange"]


def test_borders_that_meet() -> None:
    y, x = np.mgrid[:96, :96]
    wave = (128 + 60 * np.sin(2 * np.pi * x / 32) + 40 * np.sin(2 * np.pi * y / 24)).astype(np.uint8)[..., None]
    assert meeting(wave, ia.Wrap.BOTH) < 98
    assert meeting(wave[:83, :83], ia.Wrap.BOTH) == 100


def test_a_map_changes_no_part() -> None:
    made = ia.synthesize(STONES, 160, "random-tiling", seed=2)
    assert ia.score(STONES, made).as_dict() == ia.score(STONES, made.render()).as_dict()
    usage = made.map.usage()[0]
    found = beside([ia.Exemplar.of(STONES)], made.map)
    assert found["unshown"] == pytest.approx(100 * (usage == 0).mean())
    assert found["seams"] > 0


@pytest.mark.parametrize("side", [1, 7, 15, 33])
def test_small_pictures_have_a_score(side: int) -> None:
    small = STONES[:side, :side]
    for a, b in ((small, STONES), (STONES, small), (small, small)):
        assert 0 <= ia.score(a, b).total <= 100


def test_one_colour_lacks_nothing() -> None:
    flat = np.full((64, 64, 3), 90, np.uint8)
    assert ia.score(flat, flat).total == 100


def test_large_pictures_are_looked_at_in_part() -> None:
    """Of an output its corners, of 512 px each: here all of them are alike. And a reduced copy of an exemplar."""
    large = np.tile(STONES, (16, 16, 1))
    whole, corner = ia.score(STONES, large).as_dict(), ia.score(STONES, large[:512, :512]).as_dict()
    del whole["parts"]["blurred"], corner["parts"]["blurred"]
    assert whole["parts"] == corner["parts"]
    twice = np.kron(STONES, np.ones((8, 8, 1), np.uint8))
    assert ia.score(twice, twice).parts["joins"].measured == 0


def test_an_output_of_another_make_up_is_refused() -> None:
    with pytest.raises(ia.InputError, match=r"1 channels of colour.*3 of colour"):
        ia.score(STONES, STONES[..., 0])


@pytest.mark.parametrize(
    ("exemplar", "output", "holes", "why"),
    [
        (STONES, STONES, None, "the map is 64x64 px"),
        (STONES[:100], STONES[:64, :64], None, "other sizes"),
        (STONES, STONES[:64, :64], np.where(np.eye(64), HOLE, 0).astype(np.uint8), "holes"),
    ],
)
def test_maps_that_do_not_fit_are_refused(exemplar: Pixels, output: Pixels, holes: Pixels | None, why: str) -> None:
    made = ia.synthesize(STONES, 64, "repeat")
    with pytest.raises(ia.InputError, match=why):
        outcome_of(exemplar, output, map=replace(made.map, which=holes))


class TestCommand:
    @pytest.fixture
    def here(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        monkeypatch.chdir(tmp_path)
        ia.write("stones.png", ia.Plane(STONES))
        made = ia.synthesize(STONES, 128, "random-tiling", seed=1)
        ia.write("grown.png", made.render())
        made.map.save("grown.npz")
        return tmp_path

    def run(self, *args: str) -> tuple[int, str]:
        result = CliRunner().invoke(cli, ["score", *args])
        return result.exit_code, result.output

    def test_says_what_the_library_says(self, here: Path) -> None:
        code, said = self.run("stones.png", "grown.png", "--map", "grown.npz", "--json")
        answer = json.loads(said)
        assert code == 0
        found = ia.score("stones.png", "grown.png")
        assert {k: answer[k] for k in ("total", "verdict", "grain", "parts")} == found.as_dict()
        assert answer["energy"] == energy([ia.Exemplar.of(STONES)], ia.SourceMap.load("grown.npz")) > 0

    def test_a_gate_that_is_missed_exits_with_4(self, here: Path) -> None:
        code, said = self.run("stones.png", "grown.png", "-q", "--gate", "joins=0.99", "--gate", "total=99")
        assert code == 4
        assert "joins" in said
        assert "total" in said
        assert said.count("\n") == 1
        assert self.run("stones.png", "grown.png", "-q", "--gate", "joins=0") == (0, "")

    @pytest.mark.parametrize("gate", ["joins", "joins=2", "nothing=0.5", "joins=x", "=1", "seams=0.5", "total=101"])
    def test_a_gate_that_cannot_be_is_refused(self, here: Path, gate: str) -> None:
        code, said = self.run("stones.png", "grown.png", "--gate", gate)
        assert code == 2
        assert "Traceback" not in said
