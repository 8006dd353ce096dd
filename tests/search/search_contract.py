"""The promises of a search for patches, as tests of whatever makes one: see `intarsia.search.Search`."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache, cached_property
from typing import ClassVar

import numpy as np

from intarsia.analysis.features import features
from intarsia.foundation.arrays import Array
from intarsia.kernels.maps import PartialMap
from intarsia.model import Exemplar
from intarsia.model.sourcemap import HOLE
from intarsia.search import Candidates, PosedExemplars, Prices, Search, posed_exemplars
from intarsia.testing.cases import noise, texture

Patch = tuple[int, int, int]
"""Variant, first row and first column."""

HEIGHT, WIDTH = 47, 52  # of the growing map, px
PIECE = 11  # px: side of the pieces that it shows
DEAR = 64 << 16  # a repeat costs 64 times the usual distance


@dataclass(frozen=True)
class SearchScene:
    """Exemplars, and a map that grows from them: pieces laid regardless of one another, holes, single lost pixels."""

    exemplars: tuple[Exemplar, ...]
    poses: tuple[int, ...] = (0,)  # isometries
    patch: tuple[int, int] = (13, 12)  # rows and columns of the windows, px
    wrap: tuple[bool, bool] = (False, False)  # whether rows and columns of the map continue in themselves

    @cached_property
    def variants(self) -> PosedExemplars:
        """The exemplars, posed and laid out for the windows."""
        return posed_exemplars(self.exemplars, features(self.exemplars), self.poses, self.patch)

    @cached_property
    def map(self) -> tuple[Array, Array]:
        """The growing map: variant (H, W) uint8, HOLE where nothing is known, and its pixel (H, W, 2) int32."""
        y, x = np.mgrid[:HEIGHT, :WIDTH]
        draws = (noise(HEIGHT // PIECE + 1, WIDTH // PIECE + 1, 7) >> np.uint64(20)).astype(np.int64)
        drawn = draws[y // PIECE, x // PIECE]
        variant = drawn % len(self.variants)
        sides = self.variants.table[:, 1:3]
        yx = (np.stack([y + drawn // 7, x + drawn // 1009], axis=2)) % sides[variant]
        lost = (drawn // 31 % 4 == 0) | (noise(HEIGHT, WIDTH, 9) % np.uint64(11) == 0)
        lost[: self.patch[0], : self.patch[1]] = True
        return np.where(lost, HOLE, variant).astype(np.uint8), yx.astype(np.int32)

    @cached_property
    def windows(self) -> Array:
        """First pixels of windows (n, 2): the first shows nothing, some hang over the border."""
        inner = [(0, 0), (3, 5), (PIECE, PIECE), (17, 20), (20, 3), (30, 31)]
        return np.array([*inner, (-4, 18), (HEIGHT - 9, 7), (21, -5), (HEIGHT - 8, WIDTH - 7)], np.int64)

    def shown(self, at: tuple[int, int]) -> tuple[Array, Array]:
        """What a window shows, read pixel by pixel: features (h, w, C), and where there are any (h, w)."""
        (h, w), (variant, yx) = self.patch, self.map
        feats, known = np.zeros((h, w, self.variants.channels), np.int16), np.zeros((h, w), np.uint8)
        for i, j in np.ndindex(h, w):
            y, x = at[0] + i, at[1] + j
            y, x = y % HEIGHT if self.wrap[0] else y, x % WIDTH if self.wrap[1] else x
            if 0 <= y < HEIGHT and 0 <= x < WIDTH and variant[y, x] != HOLE:
                feats[i, j], known[i, j] = self.variants.picture(int(variant[y, x]))[tuple(yx[y, x])], 1
        return feats, known

    def distances(self, at: tuple[int, int]) -> dict[Patch, int]:
        """The squared distance of every patch that may be taken to what a window shows, by measuring them all."""
        feats, known = self.shown(at)
        where, found = known > 0, dict[Patch, int]()
        for v, valid in enumerate(self.variants.valid):
            held = np.lib.stride_tricks.sliding_window_view(self.variants.picture(v), self.patch, axis=(0, 1))
            steps = np.moveaxis(held[valid], 1, 3)[:, where].astype(np.int64) - feats[where]
            every = (steps * steps).sum(axis=(1, 2)).tolist()
            found |= {(v, y, x): cost for (y, x), cost in zip(np.argwhere(valid).tolist(), every, strict=True)}
        return found


def _masked(height: int, width: int) -> Array:
    usable = np.ones((height, width), bool)
    usable[9, 21] = usable[25:27, 4] = False
    return usable


SCENES: dict[str, Callable[[], SearchScene]] = {
    "gray": lambda: SearchScene((Exemplar.of(texture(36, 40, 1, 1)),)),
    "masked": lambda: SearchScene((Exemplar.of(texture(37, 41, 3, 2), usable=_masked(37, 41)),), wrap=(True, False)),
    "toroidal": lambda: SearchScene((Exemplar.of(texture(31, 33, 3, 3), toroidal=True),), wrap=(True, True)),
    "turned": lambda: SearchScene((Exemplar.of(texture(29, 34, 1, 4)),), tuple(range(8)), wrap=(False, True)),
    "many": lambda: SearchScene(
        (Exemplar.of(texture(27, 30, 5, 7), usable=_masked(27, 30), toroidal=True),), (0, 3, 6), (13, 13)
    ),
    "two": lambda: SearchScene((Exemplar.of(texture(33, 30, 3, 5)), Exemplar.of(texture(30, 36, 3, 6)))),
}
"""What searches are tested on, by name."""


def unpriced(search: Search) -> Prices:
    """Prices of which none is more than 0."""
    return Prices([np.zeros(v.shape, np.int32) for v in search.valid], 0)


@cache
def scene_of(name: str) -> SearchScene:
    """One of the scenes, made once."""
    return SCENES[name]()


class SearchContract:
    """The promises of :class:`intarsia.search.Search`; subclass it and say how a search is made."""

    scenes: ClassVar[tuple[str, ...]] = tuple(SCENES)  # those it can serve: not all can turn, or read several exemplars
    nearness: ClassVar[float] = 1.0  # how much farther than the best of all its best may be, in the mean; 1: nowhere
    rounding: ClassVar[float] = 0.0  # by which share its distances may differ from the truth; 0: whole numbers
    guided: ClassVar[bool] = False  # whether more than pixels counts: a window that shows nothing has candidates, too
    priced: ClassVar[bool] = True  # whether prices of repeats move it elsewhere
    usual: ClassVar[tuple[float, float]] = (0.6, 1.2)  # its usual distance over the true 5 % quantile; (0, 0): none

    def make(self, scene: SearchScene) -> Search:
        """Make the search for the windows of a scene."""
        raise NotImplementedError

    def truth(self, search: Search, scene: SearchScene, at: tuple[int, int]) -> dict[Patch, float]:
        """Return what every patch costs that a window may take; replaced where more than its pixels counts."""
        return dict(scene.distances(at))

    def test_what_it_says_of_itself_fits_its_variants(self) -> None:
        """For every variant a table of positions, each for `factor` px; `cells`: the patch in such units."""
        for scene, search in self._each():
            assert search.patch == scene.patch
            assert search.factor >= 1
            assert search.cells == tuple(side // search.factor for side in scene.patch)
            assert search.batch() >= 1
            assert len(search.valid) == len(scene.variants)
            for mine, all_of_them in zip(search.valid, scene.variants.valid, strict=True):
                assert mine.dtype == bool
                assert mine.any() <= all_of_them.any()
                assert not mine.size or (np.array(mine.shape) * search.factor >= all_of_them.shape).all()

    def test_candidates_are_patches_that_may_be_taken_at_their_true_distance(self) -> None:
        """Best first, equal ones by variant, row and column, none twice; masks, poses and borders included."""
        for scene, search in self._each():
            for at, found in self._found(search, scene)[1:]:
                truth, rows = self.truth(search, scene, at), [tuple(row) for row in found.rows.tolist()]
                assert len(rows) > 0 or not truth, at
                assert rows == sorted(set(rows)), at
                for cost, v, y, x in rows:
                    assert (v, y, x) in truth, (at, v, y, x)
                    assert abs(cost - truth[v, y, x]) <= (1 + self.rounding * cost if self.rounding else 0), at

    def test_candidates_come_with_what_their_window_shows(self) -> None:
        """Read across the border where the map wraps, unknown beyond it where it does not."""
        for scene, search in self._each():
            for at, found in self._found(search, scene):
                feats, known = scene.shown(at)
                np.testing.assert_array_equal(found.known, known)
                np.testing.assert_array_equal(found.feats * known[:, :, None], feats)
                assert self.guided or known.any() or not len(found.rows)

    def test_the_best_patch_is_among_them_or_nearly(self) -> None:
        """As near as `nearness` says."""
        mine, best = 0.0, 0.0
        for scene, search in self._each():
            for at, found in self._found(search, scene)[1:]:
                least = min(self.truth(search, scene, at).values(), default=None)
                if least is None:
                    continue
                assert self.nearness > 1 or found.rows[0, 0] <= least + 1 + self.rounding * least, at
                mine, best = mine + float(found.rows[0, 0]) ** 0.5, best + least**0.5
        assert mine <= self.nearness * best + 1

    def test_windows_searched_together_are_found_as_alone(self) -> None:
        """Batches and their order save time, and change nothing."""
        for scene, search in self._each():
            together = self._found(search, scene)
            for k, (_, found) in enumerate(together):
                alone = self.find(search, scene, scene.windows[k : k + 1])[0]
                self._same(alone, found)
            for found, (_, before) in zip(self.find(search, scene, scene.windows[::-1]), together[::-1], strict=True):
                self._same(found, before)

    def test_several_threads_may_search_at_the_same_time(self) -> None:
        """The windows of a wave are searched by several, with one search."""
        for scene, search in self._each():
            alone = self._found(self.make(scene), scene)
            with ThreadPoolExecutor(4) as pool:
                every = list(pool.map(lambda n, of=(search, scene): self._found(*of), range(4)))
            for found in every:
                for (_, mine), (_, before) in zip(found, alone, strict=True):
                    self._same(mine, before)

    def test_nothing_that_is_given_is_written_to(self) -> None:
        """Neither the map nor the windows nor the prices."""
        for scene, search in self._each():
            prices = Prices([np.full(v.shape, 30, np.int32) for v in search.valid], 100)
            given = [*scene.map, scene.windows, *prices.counts]
            before = [array.copy() for array in given]
            self.find(search, scene, scene.windows, prices)
            assert all((a == b).all() for a, b in zip(given, before, strict=True))

    def test_a_price_moves_it_elsewhere(self) -> None:
        """Where all of the left was shown often, more candidates come from the right; no weight, no change."""
        for scene, search in self._each():
            used: list[Array] = [np.zeros(v.shape, np.int32) for v in search.valid]
            for counts in used:
                counts[:, : counts.shape[1] // 2] = 256
            shares = []
            for weight in (0, DEAR):
                fresh = [
                    x // search.factor >= used[v].shape[1] // 2
                    for _, found in self._found(search, scene, Prices(used, weight))[1:]
                    for _, v, _, x in found.rows.tolist()
                ]
                shares.append(sum(fresh) / len(fresh))
            plain = [tuple(f.rows.ravel()) for _, f in self._found(search, scene)]
            assert plain == [tuple(f.rows.ravel()) for _, f in self._found(search, scene, Prices(used, 0))]
            assert shares[1] > shares[0] if self.priced else shares[1] == shares[0]

    def test_the_usual_distance_is_that_of_a_good_patch(self) -> None:
        """About the 5 % quantile of all distances to what is known, in their unit; how nearly, `usual` says."""
        for scene, search in self._each():
            mine, true = 0.0, 0.0
            if scene.variants.channels > 3:
                continue  # only the axes that vary most are looked at
            for at, found in self._found(search, scene)[1:]:
                assert found.usual >= 0
                mine, true = mine + found.usual, true + float(np.quantile(list(scene.distances(at).values()), 0.05))
            assert self.usual[0] * true <= mine <= self.usual[1] * true

    def find(self, search: Search, scene: SearchScene, at: Array, prices: Prices | None = None) -> list[Candidates]:
        """Search some windows of a scene."""
        return search.find(PartialMap(*scene.map, scene.wrap), at, prices or unpriced(search))

    def _each(self) -> list[tuple[SearchScene, Search]]:
        return [(scene, self.make(scene)) for scene in map(scene_of, self.scenes)]

    def _found(
        self, search: Search, scene: SearchScene, prices: Prices | None = None
    ) -> list[tuple[tuple[int, int], Candidates]]:
        """All windows with what is found for them; the first shows nothing."""
        found = self.find(search, scene, scene.windows, prices)
        assert len(found) == len(scene.windows)
        return [((y, x), of) for (y, x), of in zip(scene.windows.tolist(), found, strict=True)]

    @staticmethod
    def _same(one: Candidates, two: Candidates) -> None:
        np.testing.assert_array_equal(one.rows, two.rows)
        assert one.usual == two.usual
