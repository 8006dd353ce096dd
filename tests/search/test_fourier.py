"""The fast search of patches beyond the promises of every search: how nearly it finds the best, and batches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from naive import all_distances, posed
from numpy.typing import NDArray
from torture import TORTURE

from intarsia.analysis.features import features
from intarsia.kernels.maps import PartialMap
from intarsia.model import Exemplar
from intarsia.model.sourcemap import HOLE
from intarsia.search import Candidates, Prices, posed_exemplars
from intarsia.search.fourier import PatchSearch


@dataclass
class Scene:
    """A growing map of one window's size, random as if laid by a bad method, and how to search it."""

    exemplar: Exemplar
    patch: tuple[int, int]
    exact: bool = True
    overlap: int = 3

    def __post_init__(self) -> None:
        feats = features([self.exemplar])
        layout = posed_exemplars([self.exemplar], feats, (0,), self.patch)
        self.search = PatchSearch(layout, self.patch, self.overlap, self.exact)
        self.naive = posed([self.exemplar], (0,), feats)
        self.free = Prices([np.zeros(v.shape, np.int32) for v in self.search.valid], 0)

    def window(self, rng: np.random.Generator) -> tuple[NDArray[np.uint8], NDArray[np.int32]]:
        """Fill a window with two random pieces; part of it stays unknown."""
        (h, w), (height, width) = self.patch, (self.exemplar.height, self.exemplar.width)
        yx, cut, unknown = np.zeros((h, w, 2), np.int32), int(rng.integers(0, w + 1)), np.ones((h, w), bool)
        for columns in (slice(0, cut), slice(cut, w)):
            piece = np.moveaxis(np.indices((h, w)), 0, 2) + rng.integers(0, (height, width))
            yx[:, columns] = (piece % (height, width))[:, columns]
        unknown[: int(rng.integers(0, h // 2 + 1))] = False
        unknown[:, : int(rng.integers(1, w // 2 + 1))] = False
        unknown |= rng.random((h, w)) < 0.1 * rng.integers(0, 2)
        unknown[-1, 0] = False
        return np.where(unknown, HOLE, 0).astype(np.uint8), yx

    def find(self, variant: NDArray[np.uint8], yx: NDArray[np.int32]) -> Candidates:
        return self.search.find(PartialMap(variant, yx, (False, False)), np.zeros((1, 2), np.int64), self.free)[0]


@pytest.mark.parametrize("name", ["grapes", "brick_colours", "weave", "cracks", "pebbles_black", "wood_knot"])
def test_the_fast_search_is_nearly_as_good_on_textures(name: str) -> None:
    """Over windows of two joined pieces, the fast search's best costs a few per cent more on average."""
    fast = Scene(Exemplar.of(TORTURE[name](size=72)), (24, 24), exact=False, overlap=8)
    assert fast.search.factor > 1
    rng = np.random.default_rng(5)
    total, least = 0.0, 0.0
    for _ in range(12):
        found = fast.find(*fast.window(rng))
        total += found.rows[0, 0] ** 0.5
        least += min(row[0] for row in all_distances(found.feats, found.known.astype(bool), fast.naive)) ** 0.5
    assert total <= 1.06 * least


def test_a_patch_of_the_exemplar_finds_itself() -> None:
    for exact in (True, False):
        scene = Scene(Exemplar.of(TORTURE["pebbles_black"](size=64)), (16, 16), exact=exact)
        y, x = np.mgrid[21:37, 30:46]
        variant = np.zeros((16, 16), np.uint8)
        variant[6:, 6:] = HOLE
        found = scene.find(variant, np.stack([y, x], axis=2).astype(np.int32))
        assert found.rows[0].tolist() == [0, 0, 21, 30]


def test_several_windows_together_give_the_same_as_one_by_one() -> None:
    """Batches save time and change nothing, also beyond the number of masks that are remembered."""
    rng = np.random.default_rng(3)
    scene = Scene(Exemplar.of(rng.integers(0, 256, (40, 44), np.uint8)), (9, 9), exact=False)
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
