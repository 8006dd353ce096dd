"""Another texture is worth nothing, however well it joins; whatever is grown of the exemplar is of its texture."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from judging.naive_windows import ORDERS, all_windows, blobs, waves
from numpy.typing import NDArray

import intarsia as ia
from intarsia.analysis.features import in_isometry
from intarsia.cli import cli
from intarsia.files import sample
from intarsia.judging.parts import texture_distance
from intarsia.judging.sources import STEP, Reference, Sources
from intarsia.judging.windows import poses
from intarsia.synthesis import as_exemplars

Pixels = NDArray[np.uint8]

# Walls, cobbles, wood, leaves and stones of several kinds, so that many are alike; and what is gray.
ALIKE = (
    "near-regular_brick-large_256", "near-stochastic_rock_320", "irregular_drystone-wall_384",
    "near-regular_planks_256",
)  # fmt: skip
TEXTURES = (
    *ALIKE, "irregular_autumn-leaves_256", "irregular_daisies_320", "irregular_flagstone_320", "irregular_pebbles_256",
    "near-stochastic_rust-paint_256", "near-regular_bamboo-diagonal_256", "near-regular_brick-wall_256",
    "near-regular_burlap-cloth_256", "near-regular_cobble-moss_320", "near-regular_fan-cobble_384",
    "near-regular_stone-blocks_416", "near-regular_tile-floor-broken_320", "near-stochastic_marble_256",
    "near-stochastic_sand-ripples_320", "near-stochastic_wood-chips_256", "near-stochastic_wood-knots_256",
    "regular_clay-roof_256", "stochastic_granite-concrete_256", "stochastic_hedge_256", "stochastic_carpet_256",
)  # fmt: skip
GRAY = (
    "near-regular_brick-gray_192", "near-stochastic_bark_256", "stochastic_gravel-gray_192",
    "stochastic_grass-gray_192", "regular_metal-grid-tiny_64",
)  # fmt: skip


def told_apart(exemplars: dict[str, ia.Exemplar], size: int) -> None:
    """Grow each with no option given, and judge each by each: the least of the rightful lies far above all others."""
    made = {name: ia.synthesize(e, size, seed=1).render() for name, e in exemplars.items()}
    found = {(a, b): ia.score(e, made[b]) for a, e in exemplars.items() for b in made}
    right = {pair[0]: one for pair, one in found.items() if pair[0] == pair[1]}
    wrong = {pair: one for pair, one in found.items() if pair[0] != pair[1]}
    assert {a: one.parts["texture"].normalised for a, one in right.items()} == dict.fromkeys(exemplars, 1.0)
    assert {pair: one.total for pair, one in wrong.items() if one.total > 10} == {}
    assert {pair for pair, one in wrong.items() if one.verdict != "not this texture"} == set()
    assert min(one.total for one in right.values()) - max(one.total for one in wrong.values()) >= 30


def test_samples_are_told_apart(thorough: bool) -> None:
    names = ("pebbles", "stones", "tiles", "planks", "moss") if thorough else ("pebbles", "stones", "planks")
    told_apart({name: ia.Exemplar.of(sample(name)) for name in names}, 320)


@pytest.mark.timeout(3600)  # 576 scores in `make test-long`
@pytest.mark.parametrize(("some", "every"), [(ALIKE, TEXTURES), (GRAY[2:], GRAY)], ids=["colour", "gray"])
def test_textures_are_told_apart(
    textures: dict[str, Path], thorough: bool, some: tuple[str, ...], every: tuple[str, ...]
) -> None:
    """Made with no option at all, as large as the command makes them; in `make test` those most alike."""
    told_apart({name: as_exemplars(str(textures[name]))[0] for name in (every if thorough else some)}, 512)


def test_a_wrong_texture_misses_a_gate_and_the_page_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    ia.write("bed.png", ia.synthesize("sample:pebbles", 300, seed=1).render())
    run = CliRunner()
    wrong = run.invoke(cli, ["score", "sample:planks", "bed.png", "--gate", "total=50"])
    assert wrong.exit_code == 4
    assert "bed.png: 0 of 100, not this texture" in wrong.output
    assert wrong.output.splitlines()[1].split()[0] == "texture"
    told = json.loads(run.invoke(cli, ["score", "sample:planks", "bed.png", "--json"]).output)
    assert told["verdict"] == "not this texture"
    assert run.invoke(cli, ["score", "sample:pebbles", "bed.png", "--gate", "total=50"]).exit_code == 0


def cut(name: str, side: int) -> ia.Exemplar:
    return ia.Exemplar.of(np.ascontiguousarray(sample(name).pixels[:side, :side]), name=name)


@pytest.mark.parametrize(
    ("exemplars", "how"),
    [
        ([cut("pebbles", 256)], {"isometries": "both"}), ([cut("planks", 256)], {"isometries": "90"}),
        ([cut("gravel", 64)], {}), ([cut("gravel", 256)], {}), ([cut("stones", 256)], {"wrap": "both"}),
        ([cut("pebbles", 200), cut("stones", 200)], {}), ([cut("planks", 256)], {"size": 700}),
    ],
    ids=["mirrored", "turned", "tiny", "gray", "wrapped", "several", "large"],
)  # fmt: skip
def test_whatever_is_grown_is_of_its_texture(exemplars: list[ia.Exemplar], how: dict[str, str | int]) -> None:
    """Pieces in every pose, exemplars of 64 px, gray ones and several, canvases that wrap and large ones."""
    size, wrap, poses_of = (how.get(k, v) for k, v in (("size", 300), ("wrap", "none"), ("isometries", None)))
    method = ia.Graphcut(isometries=poses_of) if poses_of else ia.Auto()
    made = ia.synthesize(exemplars, size, method, wrap=wrap, seed=2)
    assert ia.score(exemplars, made.render()).parts["texture"].normalised == 1


def test_a_large_exemplar_is_told_from_another() -> None:
    """Above 512 px both are looked at reduced."""
    large = (np.kron(sample(n).pixels[:200, :200], np.ones((3, 3, 1), np.uint8)) for n in ("stones", "pebbles"))
    stones, pebbles = large
    assert ia.score(stones, np.roll(stones, 90, 0)).parts["texture"].normalised == 1
    assert ia.score(stones, pebbles).total <= 10


def test_the_same_with_a_defect_is_the_same_texture() -> None:
    clean = sample("pebbles").pixels
    marred = clean.copy()
    marred[60:110, 60:110] = 20
    for exemplar, other in ((clean, marred), (marred, clean)):
        made = ia.synthesize(other, 300, seed=1)
        assert ia.score(exemplar, made.render()).parts["texture"].normalised == 1


def test_poses_are_those_of_pictures() -> None:
    """The cosines of a window that is mirrored or turned, without looking at it again."""
    window = blobs(8, 8, 4)
    middle = np.array([300, 500, 700])
    flat = np.array(waves(window, middle, 1), np.float32)[None]
    plain = {tuple(waves(in_isometry(window, pose), middle, 1)) for pose in range(8)}
    assert {tuple(laid[0].astype(int).tolist()) for laid in poses(flat)} == plain
    assert len(plain) == 8


def test_it_is_the_product_of_three_plain_answers() -> None:
    exemplar, output = blobs(48, 48, 1), blobs(40, 40, 2)[::-1] * 3 // 4
    (level,) = Reference((exemplar,), (None,)).levels[:1]
    found = Sources.of(level, output)
    known = all_windows(exemplar, 2, level.windows.middle, level.windows.shorten)
    shown = all_windows(output, 2, level.windows.middle, level.windows.shorten)
    shown = {at: w for at, w in shown.items() if at[0] % (STEP // 2) == at[1] % (STEP // 2) == 0}
    far = np.mean([min(round(16 * np.linalg.norm(np.subtract(w, k))) for k in known.values()) for w in shown.values()])
    at = {at: tuple(level.windows.at[n]) for at, n in zip(shown, found.number.ravel(), strict=True)}
    steps = [(a, (a[0] + y, a[1] + x)) for a in at for y, x in ((0, 4), (4, 0)) if (a[0] + y, a[1] + x) in at]
    begun = np.mean([np.subtract(at[b], at[a]).tolist() != np.subtract(b, a).tolist() for a, b in steps])
    mine, theirs = np.array([*shown.values()]), np.array([*known.values()])
    wide = theirs.std(axis=0)
    off = np.abs(mine.mean(axis=0) - theirs.mean(axis=0)) + np.abs(mine.std(axis=0) - wide)
    differs = (off / (mine.std(axis=0) + wide + max(0.04 * wide.max(), 1))).mean()
    usual = level.own.mean() + 0.2 * level.unrelated
    assert mine.shape[1] == 3 * len(ORDERS)
    assert texture_distance([found], 100) == pytest.approx(100 * far / usual * begun * differs)
    assert texture_distance([], 0) == 0
