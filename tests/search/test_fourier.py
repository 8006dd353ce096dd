"""The patch search against a search of every position: the best is found, distances are exact, masks are kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from naive import Posed, all_distances, posed
from numpy.typing import NDArray
from torture import TORTURE

from intarsia.analysis import principal_axes
from intarsia.analysis.features import features
from intarsia.kernels.maps import PartialMap
from intarsia.model import Exemplar
from intarsia.model.image import Kind, Plane
from intarsia.model.sourcemap import HOLE
from intarsia.search import Candidates, PosedExemplars, Prices, isometry_ids, posed_exemplars
from intarsia.search.fourier import PatchSearch


@dataclass
class Scene:
    """A growing map of one window's size, random as if laid by a bad method, and how to search it."""

    exemplars: list[Exemplar]
    patch: tuple[int, int]
    isometries: str = "none"
    exact: bool = True
    overlap: int = 3

    def __post_init__(self) -> None:
        feats = features(self.exemplars)
        ids = isometry_ids(self.isometries)
        self.layout: PosedExemplars = posed_exemplars(self.exemplars, feats, ids, self.patch)
        self.search = PatchSearch(self.layout, self.patch, self.overlap, self.exact)
        self.naive: list[Posed] = posed(self.exemplars, ids, feats)
        self.free = Prices([np.zeros(v.shape, np.int32) for v in self.search.valid], 0)

    def window(self, rng: np.random.Generator, mixed: bool) -> tuple[NDArray[np.uint8], NDArray[np.int32]]:
        """Fill a window with random pixels, or with two random pieces; part of it stays unknown."""
        h, w = self.patch
        variant = np.zeros((h, w), np.uint8)
        yx = np.zeros((h, w, 2), np.int32)
        cut = int(rng.integers(0, w + 1))
        for columns in (slice(0, cut), slice(cut, w)):
            v = int(rng.integers(len(self.layout)))
            _, height, width, _ = self.layout.table[v].tolist()
            y, x = rng.integers(0, height, (h, w)), rng.integers(0, width, (h, w))
            if not mixed:
                y = (int(rng.integers(height)) + np.arange(h)[:, None] + np.zeros((h, w), int)) % height
                x = (int(rng.integers(width)) + np.arange(w)[None, :] + np.zeros((h, w), int)) % width
            variant[:, columns] = v
            yx[:, columns] = np.stack([y, x], axis=2)[:, columns]
        unknown = np.ones((h, w), bool)
        unknown[: int(rng.integers(0, h // 2 + 1))] = False
        unknown[:, : int(rng.integers(1, w // 2 + 1))] = False
        unknown |= rng.random((h, w)) < 0.1 * rng.integers(0, 2)
        unknown[-1, 0] = False
        variant[unknown] = HOLE
        return variant, yx

    def find(self, variant: NDArray[np.uint8], yx: NDArray[np.int32]) -> Candidates:
        return self.search.find(PartialMap(variant, yx, (False, False)), np.zeros((1, 2), np.int64), self.free)[0]

    def truth(self, found: Candidates) -> dict[tuple[int, int, int], int]:
        """Measure every usable patch against what the search saw in the window."""
        every = all_distances(found.feats, found.known.astype(bool), self.naive)
        return {(v, y, x): d for d, v, y, x in every}


def noise(seed: int, *shape: int) -> NDArray[np.uint8]:
    return np.random.default_rng(seed).integers(0, 256, shape, dtype=np.uint8)


def speckled(seed: int, height: int, width: int) -> NDArray[np.bool_]:
    usable = np.ones((height, width), bool)
    y, x = np.random.default_rng(seed).integers(0, (height, width), (3, 2)).T
    usable[y, x] = False
    return usable


SCENES = {
    "noise": lambda: Scene([Exemplar.of(noise(1, 31, 26))], (9, 7)),
    "colour noise": lambda: Scene([Exemplar.of(noise(2, 27, 30, 3))], (8, 8)),
    "five channels": lambda: Scene([Exemplar.of(noise(3, 24, 25, 5))], (7, 6)),
    "two exemplars": lambda: Scene([Exemplar.of(noise(4, 20, 23, 3)), Exemplar.of(noise(5, 17, 28, 3))], (6, 9)),
    "a mask": lambda: Scene([Exemplar.of(noise(6, 30, 30), usable=speckled(6, 30, 30))], (8, 7)),
    "all isometries": lambda: Scene([Exemplar.of(noise(7, 17, 22))], (6, 6), "both"),
    "turned and masked": lambda: Scene([Exemplar.of(noise(8, 20, 27), usable=speckled(8, 20, 27))], (7, 7), "90"),
    "a toroidal exemplar": lambda: Scene([Exemplar.of(noise(9, 21, 19, 3), toroidal=True)], (7, 8)),
    "toroidal, masked, turned": lambda: Scene(
        [Exemplar.of(noise(10, 18, 23), usable=speckled(10, 18, 23), toroidal=True)], (7, 7), "both"
    ),
    "a height beside a colour": lambda: Scene(
        [Exemplar.of({"albedo": noise(11, 24, 24, 3), "height": noise(12, 24, 24)})], (8, 8)
    ),
    "balls": lambda: Scene([Exemplar.of(TORTURE["grapes"](size=40))], (12, 11)),
    "bricks": lambda: Scene([Exemplar.of(TORTURE["brick_colours"](size=40))], (11, 12)),
    "16 bits": lambda: Scene([Exemplar.of(TORTURE["ramp_16bit"](size=40))], (9, 9)),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_exact_search_finds_the_best_patch_of_all(name: str) -> None:
    """The best candidate has the least distance that any usable patch has, in every window."""
    scene = SCENES[name]()
    rng = np.random.default_rng(len(name))
    missed = []
    for k in range(30):
        found = scene.find(*scene.window(rng, mixed=k % 2 == 0))
        truth = scene.truth(found)
        if found.rows[0, 0] != min(truth.values()):
            missed.append((k, int(found.rows[0, 0]), min(truth.values())))
    assert not missed


@pytest.mark.parametrize("exact", [True, False])
@pytest.mark.parametrize("name", SCENES)
def test_candidates_are_usable_patches_with_their_exact_distances(name: str, exact: bool) -> None:
    """Whatever the short-list was made of: what comes out is allowed, exact, sorted, and without doubles."""
    scene = SCENES[name]()
    scene = Scene(scene.exemplars, scene.patch, scene.isometries, exact)
    rng = np.random.default_rng(len(name))
    for k in range(8):
        found = scene.find(*scene.window(rng, mixed=k % 2 == 0))
        truth = scene.truth(found)
        rows = [tuple(row) for row in found.rows.tolist()]
        assert rows
        assert rows == sorted(set(rows))
        assert [truth[v, y, x] for _, v, y, x in rows] == [d for d, _, _, _ in rows]


@pytest.mark.parametrize("name", ["grapes", "brick_colours", "weave", "cracks", "pebbles_black", "wood_knot"])
def test_the_fast_search_is_nearly_as_good_on_textures(name: str) -> None:
    """Over windows of two joined pieces, the fast search's best costs a few per cent more on average."""
    exemplars = [Exemplar.of(TORTURE[name](size=72))]
    fast = Scene(exemplars, (24, 24), exact=False, overlap=8)
    assert fast.search.factor > 1
    rng = np.random.default_rng(5)
    total, least = 0.0, 0.0
    for _ in range(12):
        variant, yx = fast.window(rng, mixed=False)
        found = fast.find(variant, yx)
        total += found.rows[0, 0] ** 0.5
        least += min(fast.truth(found).values()) ** 0.5
    assert total <= 1.06 * least


def test_a_window_of_which_nothing_is_known_is_free() -> None:
    scene = SCENES["noise"]()
    found = scene.find(np.full(scene.patch, HOLE, np.uint8), np.zeros((*scene.patch, 2), np.int32))
    assert found.free
    assert len(found.rows) == 0


def test_a_patch_of_the_exemplar_finds_itself() -> None:
    """An exact continuation has distance 0 and is the first candidate."""
    for exact in (True, False):
        scene = Scene([Exemplar.of(TORTURE["pebbles_black"](size=64))], (16, 16), exact=exact)
        y, x = np.mgrid[21:37, 30:46]
        variant = np.zeros((16, 16), np.uint8)
        variant[6:, 6:] = HOLE
        found = scene.find(variant, np.stack([y, x], axis=2).astype(np.int32))
        assert found.rows[0].tolist() == [0, 0, 21, 30]


def test_several_windows_together_give_the_same_as_one_by_one() -> None:
    """Batches save time and change nothing, also beyond the number of masks that are remembered."""
    scene = Scene([Exemplar.of(noise(14, 40, 44))], (9, 9), exact=False)
    rng = np.random.default_rng(3)
    variant = np.where(rng.random((60, 60)) < 0.5, HOLE, 0).astype(np.uint8)
    yx = np.stack([rng.integers(0, 40, (60, 60)), rng.integers(0, 44, (60, 60))], axis=2).astype(np.int32)
    at = rng.integers(0, 51, (90, 2))

    def find(begin: int, count: int) -> list[Candidates]:
        return scene.search.find(PartialMap(variant, yx, (False, False)), at[begin : begin + count], scene.free)

    alone = [find(k, 1)[0] for k in range(len(at))]
    together = [f for k in range(0, len(at), 16) for f in find(k, 16)]
    for a, b in zip(alone, together, strict=True):
        np.testing.assert_array_equal(a.rows, b.rows)
        assert a.usual == b.usual


def test_the_usual_distance_is_in_the_units_of_the_exact_one() -> None:
    """The 5 % quantile of the reduced distances, scaled, lies near that of the exact distances."""
    for name in ("grapes", "pebbles_black", "noise_white"):
        scene = Scene([Exemplar.of(TORTURE[name](size=64))], (16, 16), exact=True)
        found = scene.find(*scene.window(np.random.default_rng(1), mixed=False))
        exact = np.quantile(list(scene.truth(found).values()), 0.05)
        assert 0.5 * exact <= found.usual <= 1.6 * exact, name


def test_a_price_moves_the_short_list_elsewhere() -> None:
    """Positions that were used often come after others, so that the short-list holds fresh ones."""
    scene = Scene([Exemplar.of(TORTURE["stripes"](size=60))], (10, 10), exact=True)
    variant, yx = scene.window(np.random.default_rng(0), mixed=False)
    before = scene.find(variant, yx)
    used = np.zeros_like(scene.free.counts[0])
    used[before.rows[:, 2], before.rows[:, 3]] = 256
    after = scene.search.find(
        PartialMap(variant, yx, (False, False)), np.zeros((1, 2), np.int64), Prices([used], 65536)
    )[0]
    assert not {(y, x) for _, _, y, x in before.rows.tolist()} & {(y, x) for _, _, y, x in after.rows.tolist()}


def test_the_principal_axes_of_equal_channels_are_the_same_on_every_machine() -> None:
    """Equal eigenvalues are split by a ramp, and signs are fixed."""
    variance, axes = principal_axes(np.eye(3) * 100.0, 2)
    np.testing.assert_allclose(axes, [[0, 0, 1], [0, 1, 0]], atol=1e-12)
    assert variance == pytest.approx(200, rel=1e-4)


def test_pixels_under_the_mask_do_not_matter() -> None:
    """Whatever lies under the mask, even NaN, no candidate shows it and no distance knows of it."""
    usable = np.ones((26, 24), bool)
    usable[4:7, 5:9] = False
    picture = noise(15, 26, 24).astype(np.float32) / 255
    hidden = picture.copy()
    hidden[~usable] = np.nan
    for a, b in ((picture, hidden),):
        one, two = (Scene([Exemplar.of(Plane(p, Kind.DATA), usable=usable)], (6, 6)) for p in (a, b))
        variant, yx = one.window(np.random.default_rng(2), mixed=False)
        np.testing.assert_array_equal(one.find(variant, yx).rows, two.find(variant, yx).rows)
