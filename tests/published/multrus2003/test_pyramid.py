"""The pyramid search: levels, windows and counters; sections are those of Multrus 2003."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from naive import all_distances, posed
from torture import TORTURE

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.foundation import ParameterError
from intarsia.kernels.maps import PartialMap
from intarsia.model import Exemplar
from intarsia.model.sourcemap import HOLE
from intarsia.published.multrus2003.pyramid import FILTERS, LEVELS, PyramidSearch, level_size
from intarsia.search import Prices, isometry_ids, posed_exemplars
from intarsia.testing import noise


def smooth(height: int, width: int, seed: int = 0) -> np.ndarray:
    """Noise that still says something at a quarter of its resolution."""
    from scipy.ndimage import gaussian_filter

    field = gaussian_filter((noise(height, width, seed) >> np.uint64(40)).astype(float), 2, mode="wrap")
    return np.rint(255 * (field - field.min()) / (field.max() - field.min())).astype(np.uint8)


def search_of(e: Exemplar, patch: int, seam: int, isometries: str = "none", **more) -> PyramidSearch:
    layout = posed_exemplars([e], features([e]), isometry_ids(isometries), (patch + 2 * seam,) * 2)
    return PyramidSearch(layout, (patch + 2 * seam,) * 2, (seam, seam), **more)


def free(search: PyramidSearch) -> Prices:
    return Prices([np.zeros(v.shape, np.int32) for v in search.valid], 0)


def corner(search: PyramidSearch, seam: int, place: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """A canvas whose window at (8, 8) knows the upper and left seam of a patch, and what lies beyond."""
    h, w = search.patch
    v, y, x = place
    variant = np.full((h + 16, w + 16), HOLE, np.uint8)
    variant[: 8 + seam] = v
    variant[:, : 8 + seam] = v
    _, rows, columns, _ = search.variants.table[v].tolist()
    yx = np.stack(np.mgrid[y - 8 : y + h + 8, x - 8 : x + w + 8], axis=2)
    return variant, np.clip(yx, 0, (rows - 1, columns - 1)).astype(np.int32)


@pytest.mark.parametrize(("patch", "seam"), list(product((4, 5, 6, 7, 12, 13), (4, 5, 6, 7))))
def test_a_patch_of_the_exemplar_is_found_from_any_place(patch: int, seam: int) -> None:
    """Section 4.3.1: all odd and even sizes; the exact continuation is found, at odd places and borders, too."""
    for height, width in ((61, 64), (64, 63)):
        e = Exemplar.of(smooth(height, width))
        search = search_of(e, patch, seam, kept=8)
        side = patch + 2 * seam
        places = [(0, 0), (height - side, width - side), (height - side, 0), (13, 8), (8, 13), (9, 11)]
        missed = 0
        for y, x in places:
            variant, yx = corner(search, seam, (0, y, x))
            found = search.find(PartialMap(variant, yx, (False, False)), np.array([[8, 8]]), free(search))[0]
            missed += found.rows[0, 0] != 0
        assert missed <= (patch + seam == 8)  # the smallest size keeps an L of 5 px at the coarsest level


@pytest.mark.parametrize("isometries", ["none", "both"])
@pytest.mark.parametrize("smoothing", FILTERS)
def test_candidates_are_allowed_patches_with_exact_distances(smoothing: str, isometries: str) -> None:
    """Sections 4.3.1 and 4.3.2: with every filter; masks are kept, rows are sorted and without doubles."""
    usable = np.ones((50, 47), bool)
    usable[20:22, 5] = usable[44, 40] = False
    e = Exemplar.of(smooth(50, 47), usable=usable)
    search = search_of(e, 8, 4, isometries, smoothing=smoothing, kept=3, listed=20)
    naive = posed([e], isometry_ids(isometries))
    rng = np.random.default_rng(1)
    variant = np.where(rng.random((60, 60)) < 0.4, HOLE, 0).astype(np.uint8)
    yx = np.stack([rng.integers(0, 50, (60, 60)), rng.integers(0, 47, (60, 60))], axis=2).astype(np.int32)
    variant[:20, :20] = HOLE
    at = np.array([[0, 0], [20, 20], [-3, 30], [50, 44]])
    together = search.find(PartialMap(variant, yx, (False, False)), at, free(search))
    assert not len(together[0].rows)
    for k, found in enumerate(together[1:], 1):
        truth = {(v, y, x): d for d, v, y, x in all_distances(found.feats, found.known.astype(bool), naive)}
        rows = [tuple(r) for r in found.rows.tolist()]
        assert rows
        assert rows == sorted(set(rows))
        assert [truth[v, y, x] for _, v, y, x in rows] == [d for d, *_ in rows]
        alone = search.find(PartialMap(variant, yx, (False, False)), at[k : k + 1], free(search))[0]
        np.testing.assert_array_equal(alone.rows, found.rows)


def test_a_tiny_known_part_is_not_lost_at_the_coarse_levels() -> None:
    """A single known pixel, between the grid of the coarse levels, still says which patches fit."""
    e = Exemplar.of(smooth(40, 40))
    search = search_of(e, 8, 4, kept=8)
    variant, yx = np.full((16, 16), HOLE, np.uint8), np.zeros((16, 16, 2), np.int32)
    variant[5, 7], yx[5, 7] = 0, (20, 21)
    found = search.find(PartialMap(variant, yx, (False, False)), np.array([[0, 0]]), free(search))[0]
    every = [d for d, *_ in all_distances(found.feats, found.known > 0, posed([e], (0,)))]
    assert found.rows[0, 0] <= np.quantile(every, 0.1)


def test_levels_have_the_source_s_sizes() -> None:
    """Section 4.3.1: floor(w_b / 2^l) and floor(w_e / 2^l); a square of twice the side is searched, 1 px more."""
    search = search_of(Exemplar.of(smooth(103, 90)), 25, 5)
    assert [level.window for level in search.levels] == [(35, 35), (16, 16), (8, 8)]
    assert [level.reach.tolist() for level in search.levels] == [[18, 18], [9, 9], [5, 5]]
    assert [tuple(level.posed.table[0, 1:3]) for level in search.levels] == [(103, 90), (51, 45), (25, 22)]
    assert all(level_size(4 + 2 * 4, 4, level) >= 3 for level in range(LEVELS + 1))


@pytest.mark.parametrize(("patch", "overlap"), [(3, 4), (25, 3), (3, 1)])
def test_patches_and_seams_below_4_px_are_refused(patch: int, overlap: int) -> None:
    """Section 4.3.1: in one line, before any work."""
    with pytest.raises(ParameterError, match="at least 4 px"):
        ia.synthesize(smooth(60, 60), 80, ia.PatchSampling(patch=patch, overlap=overlap, pyramid="mean"))


def test_counters_count_at_the_coarsest_level() -> None:
    """Section 4.3: where all that finer levels reach from the best place is used, the coarsest leads elsewhere."""
    e = Exemplar.of(smooth(88, 88))
    search = search_of(e, 8, 4, kept=1)
    variant, yx = corner(search, 4, (0, 36, 36))
    args = (PartialMap(variant, yx, (False, False)), np.array([[8, 8]]))
    used = free(search).counts[0]
    reach = sum(int(level.reach[0]) << number for number, level in enumerate(search.levels[:2]))
    y, x = search.find(*args, free(search))[0].rows[0, 2:]
    far = reach + 8
    used[max(y - far, 0) : y + far + 1, max(x - far, 0) : x + far + 1] = 256
    assert 0 < (used == 0).mean() < 0.5
    priced = search.find(*args, Prices([used], 64 << 16))[0]
    assert (used[priced.rows[:, 2], priced.rows[:, 3]] == 0).any()


def test_more_kept_places_find_better_patches_on_regular_textures() -> None:
    """The best of 8 places is at least as good as that of 1, and near the best of all."""
    e = Exemplar.of(TORTURE["brick_colours"](size=120))
    one, many = search_of(e, 17, 5, kept=1), search_of(e, 17, 5, kept=16)
    naive, total = posed([e], (0,)), np.zeros(3)
    rng = np.random.default_rng(2)
    for _ in range(6):
        y, x, b, a = rng.integers(0, 80, 4)
        variant, yx = corner(one, 5, (0, y, x))
        yx[:, :13] = corner(one, 5, (0, b, a))[1][:, :13]
        found = [s.find(PartialMap(variant, yx, (False, False)), np.array([[8, 8]]), free(s))[0] for s in (one, many)]
        least = min(all_distances(found[0].feats, found[0].known > 0, naive))[0]
        total += np.sqrt([found[0].rows[0, 0], found[1].rows[0, 0], least])
    assert total[2] <= total[1] <= total[0]
    assert total[1] <= 1.15 * total[2]


@pytest.mark.parametrize("wrap", ["none", "both"])
def test_a_map_grows_with_it(wrap: str) -> None:
    """With isometries, repetition counters and wrapping; one thread or two, the same map."""
    m = ia.PatchSampling(patch=9, overlap=5, isometries="both", pyramid="mean", pyramid_kept=2, repetition="counter")
    outs = [ia.synthesize(smooth(48, 50), (70, 75), m, seed=3, wrap=wrap, run=ia.Run(n)).map for n in (1, 2)]
    assert outs[0].digest == outs[1].digest
