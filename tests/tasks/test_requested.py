"""A recipe makes its map again on its exemplars, and says why where it cannot; `score` takes the map from there."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import intarsia as ia
from intarsia.cli import cli
from intarsia.tasks import recipe_map, replayed
from intarsia.testing import texture

STONES = texture(48, 64)
MADE: dict[str, Callable[[], ia.Synthesis]] = {
    "grown": lambda: ia.synthesize(STONES, (40, 56), ia.ImageQuilting(patch=16), seed=3, wrap="x"),
    "chosen": lambda: ia.synthesize(STONES, 40, ia.Auto(trials=2)),
    "repaired": lambda: ia.repair(ia.synthesize(STONES, 56, ia.PatchSampling(patch=12), seed=1), 2),
    "extended": lambda: ia.extend(STONES, ia.Margins(left=9, bottom=14), ia.Graphcut(patch=16), seed=2),
    "levelled": lambda: ia.tile(np.repeat(texture(64, 12), 6, axis=1), axes="y"),
    "tiled": lambda: ia.tile(STONES, axes="y", size=(40, 60), seed=4),
}


@pytest.mark.parametrize("how", MADE)
def test_the_same_map_is_made_again(how: str) -> None:
    made = MADE[how]()
    again = replayed(json.loads(made.recipe_text), made.exemplars)
    assert again.map.digest == made.map.digest
    assert again.recipe_text == made.recipe_text or how == "chosen"
    assert np.array_equal(again.render().pixels, made.render().pixels)


def test_donors_stand_behind_the_picture() -> None:
    donor = texture(64, 64, seed=5)
    made = ia.extend(STONES, ia.Margins(right=12), ia.ImageQuilting(patch=12), sources=[donor])
    assert replayed(made.recipe, [ia.Exemplar.of(e) for e in (STONES, donor)]).map.digest == made.map.digest


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"heal": {"grow": 0}}, "made with a mask of holes"),
        ({"guide": {}}, "made with labels"),
        ({"start": "0"}, "made with a map to continue"),
        ({"exemplars": [{"sha256": "0"}]}, "of another exemplar"),
        ({"exemplars": [{"sha256": "0"}], "inputs": {"crop": [0, 0, 9, 9]}}, "it was made with --crop"),
        ({"method": "nothing"}, "cannot be followed"),
        ({"parameters": {"patch": -1}}, "cannot be followed"),
        ({"blend": 3}, "damaged"),
        ({"size": 7}, "damaged"),
        ({"seed": "x"}, "damaged"),
        ({"repair": "x"}, "damaged"),
        ({"tile": {}}, "damaged"),
        ({"extend": [1, "x"]}, "damaged"),
    ],
)
def test_what_cannot_be_made_again_says_why(change: dict[str, Any], why: str) -> None:
    made = ia.synthesize(STONES, 40, "repeat")
    with pytest.raises(ia.InputError, match=why):
        replayed(made.recipe | change, [ia.Exemplar.of(STONES)])


class TestScore:
    @pytest.fixture(autouse=True)
    def here(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        ia.write("stones.png", ia.Plane(STONES))
        made = ia.synthesize("stones.png", 56, "random-tiling", seed=1, wrap="both")
        made.map.save("grown.npz")
        for name, depth in (("grown.png", None), ("deep.png", 16), ("grown.bmp", None)):
            ia.write(name, made.render(), depth=depth, recipe=made.recipe_text)
        ia.write("other.png", 255 - made.render().pixels, recipe=made.recipe_text)
        ia.write("bare.png", made.render())

    @pytest.mark.parametrize("name", ["grown.png", "deep.png", "grown.bmp"])
    def test_the_recipe_gives_it_the_map(self, name: str) -> None:
        words = [[name, "--map", "recipe"], ["bare.png", "--map", "grown.npz"]]
        said = [CliRunner().invoke(cli, ["score", "stones.png", *w, "--json"]) for w in words]
        made, saved = (json.loads(s.stdout) for s in said)
        assert made | {"file": ""} == saved | {"file": ""}
        assert made["energy"] > 0
        assert said[0].stderr == ""

    @pytest.mark.parametrize(
        ("exemplar", "name", "why"),
        [
            ("stones.png", "bare.png", "no recipe"),
            ("stones.png", "other.png", "other pixels"),
            ("bare.png", "grown.png", "another exemplar"),
        ],
    )
    def test_else_the_picture_alone_is_judged_and_a_line_says_so(self, exemplar: str, name: str, why: str) -> None:
        said = CliRunner().invoke(cli, ["score", exemplar, name, "--map", "recipe", "--json"])
        assert said.exit_code == 0
        assert why in said.stderr
        assert "picture alone" in said.stderr
        assert said.stderr.count("\n") == 1
        told = json.loads(said.stdout)
        assert told["parts"] == ia.score(exemplar, name).as_dict()["parts"]
        assert "energy" not in told

    def test_a_recipe_of_another_size_is_not_followed(self) -> None:
        recipe = ia.synthesize("stones.png", 20, "repeat").recipe_text
        ia.write("large.png", np.zeros((30, 30, 3), np.uint8), recipe=recipe)
        with pytest.raises(ia.InputError, match="another size"):
            recipe_map("large.png", ia.read("large.png").base, [ia.read("stones.png")], ia.Run())


@pytest.mark.parametrize(("rows", "warned"), [(40, True), (10, False)])
def test_a_mask_that_covers_most_of_a_picture_is_probably_inverted(rows: int, warned: bool, tmp_path: Path) -> None:
    ia.write(tmp_path / "a.png", ia.Plane(STONES))
    mask = np.zeros(STONES.shape[:2], np.uint8)
    mask[:rows] = 255
    ia.write(tmp_path / "m.png", ia.Plane(mask))
    named = {name: str(tmp_path / f"{name}.png") for name in "amo"}
    words = ["heal", named["a"], "--mask", named["m"], "-o", named["o"], "--dry-run"]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 0, done.output
    assert ("is the mask inverted?" in done.stderr) == warned
