"""Automatic isometries: light and direction are kept, isotropic textures may be turned."""

from __future__ import annotations

import numpy as np
import pytest
from naive import lay_down
from torture import TORTURE

import intarsia as ia
from intarsia.analysis import symmetry
from intarsia.analysis.symmetry import (
    LOTS,
    SAMPLES,
    SUBGROUPS,
    _directions,
    _gradients,
    _subset,
    allowed_isometries,
    pose_distances,
)
from intarsia.model import Exemplar
from intarsia.testing import noise

ALL = tuple(range(8))


def round_bumps(size: int = 144, seed: int = 5) -> np.ndarray:
    """Heights (size, size) of round bumps on a plane."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:size, :size].astype(float)
    height = np.zeros((size, size))
    for _ in range(160):
        cy, cx, r = rng.random() * size, rng.random() * size, 5 + 4 * rng.random()
        dy, dx = (y - cy + size / 2) % size - size / 2, (x - cx + size / 2) % size - size / 2
        height = np.maximum(height, np.sqrt(np.maximum(r * r - dy * dy - dx * dx, 0)))
    return height


def bumps(light: tuple[float, float] | None, size: int = 144) -> np.ndarray:
    """Round bumps, lit from (down, right), or from straight above."""
    down, right = np.gradient(round_bumps(size))
    up = 1 / np.sqrt(1 + down**2 + right**2)
    shade = up if light is None else up * (1 + 0.7 * (light[0] * down + light[1] * right)) / 2
    return np.clip(255 * shade, 0, 255).astype(np.uint8)


def auto(picture: np.ndarray) -> tuple[int, ...]:
    return allowed_isometries([Exemplar.of(picture)])


def test_a_bump_texture_lit_from_the_side_keeps_its_light() -> None:
    """Lit from a general direction nothing but the identity; lit from above-left at 45 degrees the transpose
    moves no light; lit from straight above everything is allowed."""
    assert auto(bumps((-0.9, -0.3))) == (0,)
    assert set(auto(bumps((-0.7, -0.7)))) <= {0, 3}
    assert auto(bumps((-1.0, 0.0))) in ((0,), (0, 1))
    assert auto(bumps(None)) == ALL


@pytest.mark.parametrize("name", ["noise_white", "noise_pink", "noise_band", "constant", "two_level", "maze", "cracks"])
def test_isotropic_textures_may_be_laid_in_any_way(name: str) -> None:
    assert auto(TORTURE[name]()) == ALL


@pytest.mark.parametrize("name", ["fur", "grapes", "brick_colours", "planks", "wood_knot", "text_lines", "scales"])
def test_textures_with_a_direction_or_a_light_refuse_what_would_show(name: str) -> None:
    """Torture 29: no quarter turns where rows are no columns; fur refuses to be turned upside down, too."""
    allowed = set(auto(np.asarray(ia.read("sample:planks").base) if name == "planks" else TORTURE[name]()))
    refused = {
        "fur": {1, 2, 3, 5, 6, 7}, "grapes": {1, 2, 4, 5, 6, 7}, "brick_colours": {2, 3, 4, 5, 6, 7},
        "planks": {1, 3, 4, 5, 6, 7}, "wood_knot": {1, 2, 3, 4, 5, 7}, "text_lines": {1, 2, 3, 4, 5, 6, 7},
        "scales": {1, 2, 3, 4, 5, 6, 7},
    }  # fmt: skip
    assert not allowed & refused[name]


def test_the_answer_is_a_group_and_turns_with_the_exemplar() -> None:
    """What is allowed is closed under composition; a turned exemplar allows the conjugated set."""
    for group in SUBGROUPS:
        block = np.arange(9).reshape(3, 3)
        seen = {lay_down(block, k).tobytes() for k in group}
        assert {lay_down(lay_down(block, a), b).tobytes() for a in group for b in group} == seen
    planks = np.asarray(ia.read("sample:planks").base)
    assert auto(planks) == (0, 2)
    assert auto(np.ascontiguousarray(np.rot90(planks))) == (0, 1)


def test_lots_hold_other_patches_of_both_halves_equally_many() -> None:
    """Of small halves all hold all; at most SAMPLES each, evenly."""
    halves = (np.arange(9 * SAMPLES)[:, None] * (1, 2), np.arange(5 * SAMPLES)[:, None] * (1, 2))
    lots = [_subset(halves, k) for k in range(LOTS)]
    for side in (0, 1):
        taken = np.concatenate([lot[side][:, 0] for lot in lots])
        assert len(set(taken.tolist())) == LOTS * SAMPLES == len(taken)
        steps = np.diff(lots[1][side][:, 0])
        assert steps.max() - steps.min() <= 1
    few = _subset((halves[0][:7], halves[1][:3]), 2)
    assert [len(half) for half in few] == [3, 3]
    assert all((half == _subset((half, half), 3)[0]).all() for half in few)


def test_gradients_are_those_in_the_middle_of_patches() -> None:
    tone = (noise(12, 13, 4) >> np.uint64(50)).astype(np.int64)
    at = np.array([[0, 0], [3, 5], [7, 8]])
    down, right = _gradients(tone, at)
    for k, (y, x) in enumerate(at.tolist()):
        patch = tone[y : y + 5, x : x + 5]
        assert (down[k], right[k]) == (patch[3, 2] - patch[1, 2], patch[2, 3] - patch[2, 1])


def test_weights_of_the_inverse_measure_the_transformed_patch() -> None:
    """The plain form: lay a patch down, and measure it with the upright weights."""
    patch = noise(5, 5, 3).astype(np.int64).reshape(5, 5, 1) % 1000
    axes = _directions(1, ()).reshape(8, -1, 25)
    for pose in range(8):
        plain = axes[0] @ lay_down(patch, pose).ravel()
        np.testing.assert_array_equal(axes[pose] @ patch.ravel(), plain)


def test_a_normal_map_is_compared_with_its_vectors_turned() -> None:
    """Normals of round bumps may be laid in any way, because their vectors turn with them."""
    height = round_bumps(128, 3)
    down, right = (np.roll(height, -1, a) - np.roll(height, 1, a) for a in (0, 1))
    n = np.dstack([-right, down, np.full_like(right, 2.0)])
    n = (127.5 + 127.5 * n / np.linalg.norm(n, axis=2, keepdims=True)).round().astype(np.uint8)
    assert allowed_isometries([Exemplar.of({"normal": n})]) == ALL
    assert allowed_isometries([Exemplar.of(n)]) != ALL


def test_masks_several_exemplars_and_oblong_patches() -> None:
    """What lies under a mask does not count; all exemplars must agree; oblong patches are never turned."""
    white = TORTURE["noise_white"]()
    spoilt = white.copy()
    spoilt[:40] = np.arange(96) * 2
    usable = np.ones(white.shape[:2], bool)
    usable[:40] = False
    lit, masked = Exemplar.of(bumps((-0.9, -0.3))), Exemplar.of(spoilt, usable=usable)
    assert allowed_isometries([masked]) == ALL
    assert allowed_isometries([masked, lit]) == (0,)
    assert allowed_isometries([masked], square=False) == (0, 1, 2, 6)


def test_what_one_measure_refuses_or_no_group_holds_together_is_not_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two mirrors that both keep the look, where half a turn does not, one is left out."""
    far, one = np.full((4, 8), 3), [Exemplar.of(np.zeros((8, 8), np.uint8))]
    monkeypatch.setattr(symmetry, "pose_distances", lambda exemplar: far)
    for number in range(4):
        far[number, 3:5] = 5, 4
        assert allowed_isometries(one) == (0, 1, 2, 6), "4 of 3 is still alike, 5 is not"
        far[number] = 3
    assert allowed_isometries(one) == ALL
    far[:] = (10, 11, 12, 99, 99, 99, 99, 99)
    assert allowed_isometries(one) == (0, 1)


def test_tiny_exemplars_allow_everything_they_cannot_refuse() -> None:
    assert auto(TORTURE["tiny"]()) == ALL
    assert not pose_distances(Exemplar.of(TORTURE["tiny"]())).any()


@pytest.mark.parametrize("method", [ia.ImageQuilting, ia.PatchSampling, ia.RandomTiling])
def test_methods_settle_auto_and_the_recipe_holds_the_list(method) -> None:
    """The recipe names the isometries themselves, so that replaying it measures nothing again."""
    out = ia.synthesize(bumps((-0.9, -0.3), 64), 50, method(patch=12, isometries="auto"), run=ia.Run(1))
    assert out.recipe["parameters"]["isometries"] == [0]
    free = ia.synthesize(TORTURE["noise_white"](), 50, method(patch=12, isometries="auto"), run=ia.Run(1))
    assert free.recipe["parameters"]["isometries"] == list(ALL)
    oblong = ia.synthesize(TORTURE["noise_white"](), 50, method(patch=(12, 9), isometries="auto"), run=ia.Run(1))
    assert oblong.recipe["parameters"]["isometries"] == [0, 1, 2, 6]


@pytest.mark.parametrize("size", [96, (97, 110), (130, 91)])
def test_a_picture_in_a_mirror_is_measured_alike(size) -> None:
    """Left to right, upside down and both: each distance is found again, that of the isometry in the mirror."""
    h, w = (size, size) if isinstance(size, int) else size
    picture = np.random.default_rng(h).integers(0, 256, (h, w, 3)).astype(np.uint8)
    picture[:, : w // 3] //= 2
    usable = np.ones((h, w), bool)
    usable[5:20, 8:30] = False

    def found(pose: int) -> np.ndarray:
        laid = [np.ascontiguousarray(lay_down(a, pose)) for a in (picture, usable)]
        return pose_distances(Exemplar.of(laid[0], usable=laid[1]))

    plain = found(0)
    np.testing.assert_array_equal(found(6), plain)
    for pose in (1, 2):
        np.testing.assert_array_equal(found(pose), plain[:, [0, 1, 2, 4, 3, 7, 6, 5]])
