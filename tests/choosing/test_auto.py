"""The automatic choice: which rule fires on which class, what is told of it, and what restricts it."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torture
from tasks.lines import run

import intarsia as ia
from intarsia.analysis.structure import border_steps, edge_coherence
from intarsia.choosing.auto import GENERAL, LEAST_GAIN, trial_methods
from intarsia.choosing.facts import JOINTED, OUTLINED, STEPPED, Facts, measurements
from intarsia.choosing.rules import RULES
from intarsia.files import sample
from intarsia.judging import score_map
from intarsia.lattice import vectors_of
from intarsia.lattice.decision import Lattice
from intarsia.methods import METHODS, method_class
from intarsia.model import Exemplar
from intarsia.model.sourcemap import HOLE, identity
from intarsia.request import Request, parameter_words, values_of
from intarsia.testing import noise, texture

CANVAS = ia.Canvas(200, 200)


def choice_of(pixels: Any, canvas: ia.Canvas = CANVAS, **asked: Any) -> Any:
    return ia.Auto(**asked).choose([pixels if isinstance(pixels, Exemplar) else Exemplar.of(pixels)], canvas)


def speckle(height: int, width: int, seed: int = 3) -> np.ndarray:
    """Noise without any element: whole numbers only."""
    return (noise(height, width, seed) >> np.uint64(56)).astype(np.uint8)


def picture(name: str) -> np.ndarray:
    return np.asarray(getattr(torture, name)())


def cells(size: int = 128, seed: int = 5) -> np.ndarray:
    """Plates of about 30 px with dark joints between them, and a little grain."""
    rng = np.random.default_rng(seed)
    y, x = np.indices((size, size))
    points = rng.integers(0, size, (16, 2))
    far = np.sort([np.hypot(y - a, x - b) for a, b in points], axis=0)
    return np.where(far[1] - far[0] < 5, 40, 180 + rng.integers(0, 30, (size, size))).astype(np.uint8)


def tiles(size: int = 160, seed: int = 8) -> np.ndarray:
    """Tiles of 32 px, each of its own gray, with light joints of 4 px between them."""
    rng = np.random.default_rng(seed)
    y, x = np.indices((size, size))
    own = rng.integers(20, 160, (size // 32 + 1, size // 32 + 1))[(y + 16) // 32, (x + 16) // 32]
    joint = ((y + 16) % 32 < 4) | ((x + 16) % 32 < 4)
    shades = np.where(joint, 230, own) + rng.integers(0, 20, (size, size))
    return shades.astype(np.uint8)


def lines_of_text(height: int = 192, width: int = 200, seed: int = 6) -> np.ndarray:
    """Words of random letters, black on white, in lines 16 px apart."""
    rng = np.random.default_rng(seed)
    page = np.full((height, width), 250, np.uint8)
    for y in range(3, height - 12, 16):
        x = int(rng.integers(0, 9))
        while x < width - 8:
            for _ in range(int(rng.integers(2, 8))):
                if x < width - 8:
                    page[y + 3 * (rng.random() < 0.6) : y + 10, x : x + int(rng.integers(1, 3))] = 20
                    page[y + int(rng.integers(3, 9)), x : x + 5] = 20
                    x += int(rng.integers(5, 8))
            x += 6
    return page


def letters(size: int = 200, seed: int = 4) -> np.ndarray:
    """Random black letters on white paper, as a typewriter sets them: 20 px apart in lines 32 px apart."""
    rng = np.random.default_rng(seed)
    page = np.full((size, size), 235, np.uint8)
    for y in range(8, size - 16, 32):
        for x in range(4, size - 12, 20):
            page[y : y + 16, x : x + 12] -= 190 * np.kron(rng.random((4, 3)) < 0.55, np.ones((4, 4), np.uint8))
    return page


CLASSES = {
    "brick_colours": "in-step",
    "weave": "equal-periods",
    "checkerboard": "equal-periods",
    "constant": "one-colour",
    "stripes": "in-step",  # rows without joints
    "noise_pink": "elements",
    "pebbles_black": "in-step",  # they lie about a grid of 14 px
    "noise_white": "elements",
}


def with_lattices(facts: Facts, **change: Any) -> Facts:
    """The same facts of an exemplar of which other lattices are found."""
    known = Facts(facts.exemplars, CANVAS)
    vars(known)["lattices"] = replace(facts.lattices, **change)
    return known


class TestRules:
    def test_every_rule_names_a_method_and_says_why(self) -> None:
        assert len({r.name for r in RULES}) == len(RULES)
        assert {r.method for r in RULES} <= set(METHODS)
        methods = {"near-regular", "best-tile", "image-quilting", "graphcut", "parallel-controllable"}
        assert methods <= {r.method for r in RULES}
        assert all(r.when for r in RULES)
        assert [r.name for r in RULES[-2:]] == ["patches", "endless"]  # these hold for everything

    @pytest.mark.parametrize("name", list(CLASSES))
    def test_classes_are_told_apart(self, name: str) -> None:
        found = choice_of(picture(name))
        assert found.rule == CLASSES[name], found.why
        assert found.why

    def test_a_brick_wall_is_laid_in_step_with_its_lattice(self) -> None:
        found = choice_of(picture("brick_colours"))
        assert found.method.slug == "graphcut"
        assert found.method.lattice == found.decided["lattice"] == vectors_of(found.facts.lattice)
        assert found.warnings == ()
        assert not {"masonry", "outlines"} & set(vars(found.facts)), "what no rule before asks for is not measured"

    def test_blocks_lead_where_joints_part_them_or_patches_cannot_be_laid(self) -> None:
        clear = choice_of(tiles())
        assert (clear.rule, clear.method.slug) == ("periods", "near-regular")
        assert clear.facts.joints < JOINTED < choice_of(picture("brick_colours")).facts.joints
        assert choice_of(picture("brick_colours"), ia.Canvas(4097, 4096)).rule == "periods"

    def test_on_canvases_that_wrap_patches_are_laid_in_step_whatever_parts_their_periods(self) -> None:
        """Blocks of whole periods would have to close around them."""
        for exemplar in (tiles(), picture("brick_colours")):
            assert choice_of(exemplar, ia.Canvas(256, 256, "both")).rule == "in-step"

    def test_what_bare_ground_parts_is_laid_in_step(self) -> None:
        """As between letters: nothing there has an outline that a block would keep."""
        found = choice_of(letters())
        assert found.facts.joints < JOINTED
        assert found.facts.outlines < OUTLINED
        assert found.rule == "in-step"

    def test_a_lattice_that_only_its_peaks_tell_keeps_patches_in_step(self) -> None:
        found = choice_of(picture("pebbles_black"))
        assert found.facts.lattice is None
        assert found.facts.about is not None
        assert found.facts.about.verdict == "refused"
        assert found.method.lattice == vectors_of(found.facts.about)
        assert choice_of(cells()).facts.about is None

    def test_lines_of_text_are_no_courses(self) -> None:
        found = choice_of(lines_of_text())
        assert found.facts.lattices.accepted.kind == "1-D"
        assert found.facts.lattice is None
        assert found.facts.ordered
        assert found.rule == "in-step"
        assert found.method.lattice == vectors_of(found.facts.lattices.accepted)

    @pytest.mark.parametrize(("share", "laid"), [(0.28, False), (0.49, False), (0.5, True), (0.62, True)])
    def test_rows_are_courses_where_half_of_them_is_whole_bricks(
        self, monkeypatch: pytest.MonkeyPatch, share: float, laid: bool
    ) -> None:
        """Of photographs of text 0.28 look like bricks, of courses 0.62 and more; in painted letters none do."""
        monkeypatch.setattr("intarsia.choosing.facts.wall.brick_share", lambda lattice, exemplar: share)
        found = Facts([Exemplar.of(lines_of_text())], ia.Canvas(96, 96))
        assert found.lattices.accepted is not None
        assert found.lattice is (found.lattices.accepted if laid else None)
        assert found.ordered is not laid

    def test_a_canvas_that_is_vast_is_quilted(self) -> None:
        found = choice_of(speckle(96, 96), ia.Canvas(4096, 4097))
        assert (found.rule, found.method.slug) == ("patches", "image-quilting")
        assert any("minutes" in why for why in found.why)
        assert choice_of(speckle(96, 96), ia.Canvas(4096, 4096)).rule == "elements"

    def test_elements_that_lie_loosely_are_not_cut_by_a_lattice(self) -> None:
        facts = Facts([Exemplar.of(picture("brick_colours"))], CANVAS)
        sure = facts.lattices.accepted
        assert sure is not None
        two = replace(sure, vectors=((0, 8 * 256), (20 * 256, 0)), residual=1.5)
        for share, kind in ((0.5, None), (0.7, "2-D")):
            known = with_lattices(facts, accepted=replace(two, repeats=share))
            assert (known.lattice and known.lattice.kind) == kind
            assert known.ordered == (kind is None)

    def test_a_hint_of_rows_is_order(self) -> None:
        """Three rows that agree 0.045 better than what lies between them, accepted or not."""
        facts = Facts([Exemplar.of(speckle(96, 96))], CANVAS)
        row = Lattice(((20 * 256, 0),), 0.1, 0.1, 5, 0.1)
        for contrast, points, ordered in ((0.05, 3, True), (0.04, 3, False), (0.05, 2, False)):
            ranked = (replace(row, contrast=contrast, points=points),)
            assert with_lattices(facts, accepted=None, ranked=ranked).ordered == ordered

    def test_two_vectors_are_taken_where_rows_are_surer_and_hold_them(self) -> None:
        facts = Facts([Exemplar.of(picture("brick_colours"))], CANVAS)
        sure = facts.lattices.accepted
        assert sure is not None
        rows = replace(sure, vectors=((20 * 256, 0),))
        for vectors, kind in ((((0, 16 * 256), (20 * 256, 100)), "2-D"), (((0, 16 * 256), (30 * 256, 0)), "1-D")):
            for verdict in ("sure", "refused"):
                two = replace(sure, vectors=vectors, verdict=verdict, residual=0.1)
                known = with_lattices(facts, accepted=rows, ranked=(rows, two))
                assert known.lattice is not None
                assert known.lattice.kind == (kind if verdict == "sure" else "1-D")

    def test_8_bit_16_bit_and_float_give_the_same_choice(self) -> None:
        pixels = texture(90, 80, 3)
        deep = choice_of(pixels.astype(np.uint16) * 257)
        assert deep.method == choice_of(pixels).method


class TestAsked:
    def test_a_parameter_restricts_the_choice(self) -> None:
        wall = picture("brick_colours")
        for pixels, name, value, slug in (
            (wall, "patch", 20, "graphcut"), (speckle(96, 96), "patch", 20, "graphcut"),
            (wall, "tolerance", 0.2, "image-quilting"), (wall, "candidates", 3, "patch-sampling"),
            (wall, "border", 8, "near-regular"),
        ):  # fmt: skip
            method = choice_of(pixels, given={name: value}).method
            assert (method.slug, getattr(method, name)) == (slug, value)

    def test_what_no_method_has_or_allows_is_refused(self) -> None:
        with pytest.raises(ia.ParameterError, match="no method has all of"):
            ia.Auto(given={"hits": 1, "candidates": 2})
        for trials in (0, -1, 65, True, 2.5):
            with pytest.raises(ia.ParameterError, match="trials="):
                ia.Auto(trials=trials)
        with pytest.raises(ia.ParameterError, match="tolerance=-1"):
            ia.Auto(given={"tolerance": -1})
        with pytest.raises(ia.ParameterError, match="patch=700 is larger"):
            choice_of(texture(60, 60, 3), given={"patch": 700})

    def test_a_start_map_a_guide_and_several_exemplars_lead_to_methods_that_can(self) -> None:
        e = Exemplar.of(picture("brick_colours"))
        held = np.zeros((e.height, e.width), np.uint8)
        held[:20] = HOLE
        started = ia.Canvas(e.height, e.width, start=replace(identity([e.source], 0), which=held))
        begun = choice_of(e, started)
        assert (begun.rule, begun.method.slug, begun.method.evenness) == ("begun-lattice", "graphcut", STEPPED)
        healed = choice_of(e, replace(started, rim=0))
        assert healed.rule == "begun"
        assert "lattices" not in vars(healed.facts)
        both = ia.Auto().choose([e, Exemplar.of(picture("brick_colours"))], CANVAS)
        assert (both.rule, both.method.slug) == ("several", "image-quilting")

    def test_a_picture_to_look_like_is_followed_pixel_by_pixel(self) -> None:
        pixels = picture("brick_colours")
        e, gray = Exemplar.of(pixels), np.ascontiguousarray(np.asarray(pixels)[:, :, 0])
        for kind, rule, slug in (
            (ia.Kind.DATA, "transfer", "parallel-controllable"), (ia.Kind.LABEL, "guided", "graphcut")
        ):  # fmt: skip
            beside = ia.Plane(gray // 128 if kind is ia.Kind.LABEL else gray, kind)
            found = choice_of(e, ia.Canvas(e.height, e.width, guide=ia.Guide(beside, beside)))
            assert (found.rule, found.method.slug) == (rule, slug)
        guide = ia.Guide([ia.Plane(gray, ia.Kind.DATA)] * 2, ia.Plane(gray, ia.Kind.DATA))
        several = ia.Auto().choose([e, Exemplar.of(pixels)], ia.Canvas(e.height, e.width, guide=guide))
        assert several.rule == "guided"

    def test_a_wrapped_canvas_that_no_period_fits_falls_to_the_next_method(self) -> None:
        tile = np.tile(np.kron(speckle(5, 6), np.ones((4, 4), np.uint8)), (5, 5))
        made = ia.synthesize(tile, (101, 101), "auto", wrap="both")
        assert made.map.yx.shape == (101, 101, 2)
        assert not made.map.holes.any()


class TestSynthesis:
    def test_the_recipe_names_the_method_and_replays_without_auto(self) -> None:
        pixels = texture(70, 64, 3)
        made = ia.synthesize(pixels, 100, "auto", seed=4)
        assert made.recipe["method"] == made.method.slug != "auto"
        assert made.recipe["auto"]["rule"] == made.choice.rule
        again = ia.synthesize(pixels, 100, made.method, seed=4)
        assert again.map.digest == made.map.digest
        assert again.choice is None
        assert "auto" not in again.recipe

    def test_extending_and_healing_choose_what_they_chose_before(self) -> None:
        pixels = texture(60, 60, 3)
        hole = np.zeros((60, 60), bool)
        hole[20:30, 25:40] = True
        assert ia.heal(pixels, hole, "auto").map.digest == ia.heal(pixels, hole, "image-quilting").map.digest
        margins = ia.Margins(right=20)
        plain = ia.extend(pixels, margins, ia.ImageQuilting())
        assert ia.extend(pixels, margins, "auto").map.digest == plain.map.digest

    def test_warnings_are_notes_of_the_run(self) -> None:
        run = ia.Run()
        ia.synthesize(texture(20, 20, 3), 40, "auto", run=run)
        assert any("only 20 px" in note for note in run.notes)
        assert any("only 20 px" in warning for warning in choice_of(texture(20, 24, 3)).warnings)


class TestTrials:
    def test_the_best_score_is_kept_and_can_be_repeated(self) -> None:
        pixels = texture(70, 64, 3)
        made = ia.synthesize(pixels, 120, ia.Auto(trials=5), seed=1)
        totals = [s.total for s in made.trials]
        assert len(totals) == 5
        kept = score_map(made.exemplars, made.map).total
        assert kept == (max(totals) if max(totals) > totals[0] + LEAST_GAIN else totals[0])
        again = ia.synthesize(pixels, 120, made.method, seed=made.recipe["seed"])
        assert again.map.digest == made.map.digest

    def test_what_was_asked_for_is_never_varied(self) -> None:
        found = choice_of(texture(70, 64, 3), given={"patch": 20, "tolerance": 0.5}, trials=8)
        tried = trial_methods(found, CANVAS, 3)
        assert {m.patch for m, _ in tried} == {20}
        assert {m.tolerance for m, _ in tried} == {0.5}
        assert len({seed for _, seed in tried}) == 8
        assert tried[0] == (found.method, 3)

    def test_patches_of_several_sizes_follow(self) -> None:
        stones = np.ascontiguousarray(sample("stones").pixels[:160, :160])
        tried = trial_methods(choice_of(stones, given={"isometries": "none"}, trials=4), CANVAS, 3)
        sides = [m.patch for m, _ in tried]
        assert len({(m.patch, seed) for m, seed in tried}) == 4
        assert {m.slug for m, _ in tried} == {"graphcut"}
        assert sides[0] == min(sides) < max(sides)

    def test_a_method_without_chance_is_made_once(self) -> None:
        tile = np.tile(np.kron(speckle(5, 6), np.ones((4, 4), np.uint8)), (6, 6))
        found = choice_of(tile, trials=5)
        assert found.method.slug == "best-tile"
        assert len(trial_methods(found, CANVAS, 0)) == 1


class TestMeasurements:
    def test_edges_of_one_direction_are_coherent(self) -> None:
        x = np.mgrid[:64, :64][1]
        assert edge_coherence(((x % 8) * 20).astype(np.int16)[:, :, None], None) == pytest.approx(1)
        assert edge_coherence(speckle(64, 64).astype(np.int16)[:, :, None], None) < 0.1
        assert edge_coherence(np.zeros((64, 64, 1), np.int16), None) == 0

    def test_a_step_over_the_border_is_measured(self) -> None:
        y, x = np.mgrid[:64, :64]
        assert max(border_steps(speckle(64, 64).astype(np.int16)[:, :, None], None)) < 1.3
        assert min(border_steps((x + y).astype(np.int16)[:, :, None], None)) > 30
        assert border_steps((x + y)[:2].astype(np.int16)[:, :, None], None)[0] == np.inf

    def test_every_measurement_has_words(self) -> None:
        for pixels in (picture("brick_colours"), texture(60, 64, 3), picture("constant"), picture("tiny")):
            told = measurements(Facts([Exemplar.of(pixels)], CANVAS))
            assert set(told) == {"lattice", "variation", "elements", "outlines", "courses", "light"}
            assert all(told.values())

    def test_a_large_exemplar_is_measured_reduced(self) -> None:
        facts = Facts([Exemplar.of(np.tile(texture(128, 128, 3), (9, 9, 1)))], CANVAS)
        assert facts.reduction == 3
        assert facts.small.height == 384


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    ia.write("wall.png", picture("brick_colours"))
    ia.write("blobs.png", texture(90, 80, 3))
    return tmp_path


@pytest.mark.usefixtures("folder")
class TestCommands:
    def test_explain_tells_measurements_rule_method_and_command(self) -> None:
        said = run("grow", "wall.png", "-mauto", "-o", "out.png", "--explain", "--dry-run").stderr
        for word in ("lattice", "elements", "rule", "method", "parameters", "command"):
            assert f"\n{word} " in said
        assert "in-step" in said
        assert not Path("out.png").exists()

    @pytest.mark.parametrize("exemplar", ["wall.png", "blobs.png"])
    def test_the_command_repeats_the_picture_without_auto(self, exemplar: str) -> None:
        asked = ("-mauto", "--size", "150x140", "--trials", 3, "--wrap", "x")
        done = run("grow", exemplar, *asked, "-o", "out.png", "--json")
        told = json.loads(done.stdout)
        words = shlex.split(told["auto"]["command"])
        assert words[:2] == ["intarsia", "grow"]
        assert words[words.index("--method") + 1] == told["method"]
        run(*words[1:], "--force")
        first = np.asarray(ia.read("out.png").base.pixels)
        run("grow", exemplar, "-mauto", "-o", "auto.png", "--size", "150x140", "--trials", 3, "--wrap", "x")
        assert (np.asarray(ia.read("auto.png").base.pixels) == first).all()

    def test_json_holds_the_choice_and_measurements_if_asked(self) -> None:
        done = run("grow", "wall.png", "-mauto", "-o", "{method}.png", "--json", "--size", 140)
        plain = json.loads(done.stdout)["auto"]
        assert Path("graphcut.png").exists()
        assert set(plain) == {"rule", "why", "command"}
        told = run("grow", "wall.png", "-mauto", "-o", "b.png", "--json", "--explain", "--trials", 2).stdout
        full = json.loads(told)["auto"]
        assert set(full) == {"rule", "why", "command", "measurements", "scores"}
        assert len(full["scores"]) == 2
        assert "confidence" in full["measurements"]["lattice"]

    @pytest.mark.parametrize("args", [
        "--hits 1 --candidates 2", "--trials 0", "--method image-quilting --trials 2", "--method repeat --explain",
        "--tolerance -1", "--patch 700",
    ])  # fmt: skip
    def test_errors_are_one_line(self, args: str) -> None:
        result = run("grow", "wall.png", "-o", "out.png", *args.split(), code=2)
        assert result.stderr.startswith("intarsia: ")
        assert result.stderr.count("\n") == 1
        assert not Path("out.png").exists()

    def test_analyze_suggests_what_auto_chooses(self) -> None:
        for name in ("wall.png", "blobs.png"):
            found = json.loads(run("analyze", name, "--json").stdout)["suggested"]
            made = json.loads(run("grow", name, "-mauto", "-o", f"grown_{name}", "--json").stdout)
            assert (found["rule"], found["method"]) == (made["auto"]["rule"], made["method"])


def test_steps_of_tone_are_evened_out_where_the_method_is_chosen() -> None:
    """But not where it is named, nor where what is there must stay, nor where it is asked otherwise."""
    exemplar, level = Exemplar.of(cells(64)), (ia.Levelling(96),)
    made = ia.synthesize(exemplar, 80, seed=1)
    assert made.blend.finish == level
    assert made.recipe["blend"]["finish"] == [level[0].as_recipe]
    assert ia.synthesize(exemplar, 80, made.method, seed=1).blend.finish == ()
    assert ia.synthesize(exemplar, 80, blend=ia.Blend(), seed=1).blend.finish == ()
    held = np.where(np.arange(64)[:, None] < 40, 0, HOLE) * np.ones((1, 64), int)
    start = replace(identity([exemplar.source], 0), which=held.astype(np.uint8))
    assert ia.synthesize(exemplar, start=start, seed=1).blend.finish == ()
    assert ia.Auto().choose([exemplar], ia.Canvas(64, 64, endless=True)).blend.finish == ()
    large = Exemplar.of({"albedo": cells(16), "fine": cells(16 * 32)})
    assert ia.synthesize(large, 20, seed=1).blend.finish == (ia.Levelling(32),)


def test_the_page_lists_every_rule() -> None:
    text = (Path(__file__).parents[2] / "docs" / "auto.md").read_text(encoding="utf-8")
    for rule in RULES:
        assert f"| `{rule.name}` | {rule.when} | `{rule.method}` |" in text


def test_options_give_the_same_method() -> None:
    from intarsia.foundation.params import parameters, parse

    for slug in METHODS:
        cls = method_class(slug)
        names = {p.name: p for p in parameters(cls)}
        given = {"lattice": ((12.5, 0.25), (3.0, 9.75))} if "lattice" in names else {}
        given |= {"keep_lattice": "on", "angle": 12.5, "zoom": 2} if "keep_lattice" in names else {}
        given |= {"neighbourhood": "appearance"} if "neighbourhood" in names else {}  # colours cannot be turned
        given |= {"patch": (20, 30)} if names.get("patch") and names["patch"].kind == "extent" else {}
        method = cls(**given)
        words = parameter_words(Request("grow", method=cls.slug, parameters=values_of(method)))
        said = zip((option[2:].replace("-", "_") for option in words[::2]), words[1::2], strict=True)
        assert cls(**{name: parse(names[name], text) for name, text in said}) == method


def test_what_comes_next_is_measured_once_it_is_asked() -> None:
    """Rules after the one that leads ask for facts of their own: stones in courses here, which take a fifth of all."""
    choice = ia.Auto().choose([ia.read("sample:brick")], CANVAS)
    assert choice.rule == "bent-courses"
    assert "masonry" not in vars(choice.facts)
    others = choice.others()
    assert "masonry" in vars(choice.facts)
    assert others[-1].rule in GENERAL
    assert choice.others() is others
