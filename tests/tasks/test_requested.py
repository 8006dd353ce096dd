"""A recipe makes its map again on its exemplars."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from laws import replayed

import intarsia as ia
from intarsia.cli import cli
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
    again = replayed(made.recipe_text, made.exemplars)
    assert again.map.digest == made.map.digest
    assert again.recipe_text == made.recipe_text or how == "chosen"
    assert np.array_equal(again.render().pixels, made.render().pixels)


def test_donors_stand_behind_the_picture() -> None:
    donor = texture(64, 64, seed=5)
    made = ia.extend(STONES, ia.Margins(right=12), ia.ImageQuilting(patch=12), sources=[donor])
    assert replayed(made.recipe_text, [ia.Exemplar.of(e) for e in (STONES, donor)]).map.digest == made.map.digest


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
