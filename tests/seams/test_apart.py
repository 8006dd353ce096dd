"""What would lie beside itself in another pose: where pixels lie in other poses, and that such placements are left."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from seams.sewing import empty

from intarsia.foundation.geometry import Wrap
from intarsia.foundation.run import Run
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.model.sourcemap import HOLE
from intarsia.seams import graphcut_moves, graphcut_textures, placement_kernels
from intarsia.seams.graphcut_textures import GraphcutSettings
from intarsia.seams.occurrence_kernels import count_map
from intarsia.seams.placement_kernels import ONE
from intarsia.search import Candidates
from intarsia.testing import texture

Box = tuple[int, int, int, int]


def sewing_of(
    wrap: Wrap = Wrap.NONE, poses: tuple[int, ...] = tuple(range(8)), toroidal: bool = False, two: bool = False
) -> graphcut_textures.GraphcutMap:
    """An empty map of one exemplar or two, wider than high."""
    exemplars = [Exemplar.of(texture(40, 52, 1, seed), toroidal=toroidal) for seed in range(1 + two)]
    return empty(exemplars, Canvas(48, 56, wrap), GraphcutSettings(usage=0.1, margin=4), isometries=poses)


def scattered(sewing: graphcut_textures.GraphcutMap, seed: int) -> None:
    """Pixels of all variants, drawn, and holes."""
    rng = np.random.default_rng(seed)
    shape = sewing.variant.shape
    sewing.variant[:] = rng.integers(0, len(sewing.variants), shape)
    sizes = sewing.variants.table[sewing.variant, 1:3]
    sewing.yx[:] = rng.integers(0, 1 << 20, (*shape, 2)) % sizes
    sewing.variant[rng.random(shape) < 0.2] = HOLE


def test_a_pixel_is_the_same_exemplar_pixel_in_every_pose() -> None:
    variants = sewing_of(two=True).variants
    for v, k in product(range(len(variants)), repeat=2):
        a, b, c, d, e, f, known = variants.turns[v, k].tolist()
        assert known == (v != k and variants.exemplar[v] == variants.exemplar[k])
        y, x = np.indices(variants.table[v, 1:3])
        there = np.stack([a * y + b * x + e, c * y + d * x + f], axis=2).astype(np.int32)
        if known:
            mine = variants.to_exemplars(np.stack([y, x], axis=2).astype(np.int32), np.full(y.shape, v, np.uint8))
            its = variants.to_exemplars(there, np.full(y.shape, k, np.uint8))
            assert (mine[0] == its[0]).all()


def naive_twins(sewing: graphcut_textures.GraphcutMap, box: Box, row: tuple[int, ...], step: int) -> int:
    """Pixel by pixel of the canvas: does the placement show it less than half a window away in another pose?"""
    _, k, u, s = row
    size, near, count = sewing.variant.shape, max(box[2:]) // 2, 0
    shown, which, _ = sewing.variants.to_exemplars(sewing.yx, sewing.variant)
    for a, b in product(range(-near, box[2] + near, step), range(-near, box[3] + near, step)):
        at = [box[0] + a, box[1] + b]
        if any(not sewing.wraps[i] and not 0 <= at[i] < size[i] for i in (0, 1)):
            continue
        y, x = (n % m for n, m in zip(at, size, strict=True))
        if sewing.variant[y, x] in (HOLE, k) or which[y, x] != sewing.variants.exemplar[k]:
            continue
        down, across = (range(max(n - near + 1, 0), min(n + near, m)) for n, m in ((a, box[2]), (b, box[3])))
        for i, j in product(down, across):
            place = np.array([[[u + i, s + j]]], np.int32)
            tall, wide = sewing.variants.table[k, 1:3].tolist()
            if sewing.variants.toroidal[k]:
                place %= (tall, wide)
            elif not (0 <= u + i < tall and 0 <= s + j < wide):
                continue
            patch = sewing.variants.to_exemplars(place, np.array([[k]], np.uint8))[0]
            count += bool((patch[0, 0] == shown[y, x]).all())
    return count * step * step


@pytest.mark.parametrize(("seed", "toroidal"), [(0, False), (1, True), (2, False)])
def test_what_lies_beside_itself_is_counted(seed: int, toroidal: bool) -> None:
    sewing = sewing_of((Wrap.BOTH, Wrap.NONE, Wrap.X)[seed], (0, 1, 5, 6), toroidal, two=seed == 0)
    scattered(sewing, seed)
    sewing.variant[4:20, 10:30], sewing.yx[4:20, 10:30] = 0, np.moveaxis(np.indices((16, 20)) + 5, 0, 2)
    rng = np.random.default_rng(seed)
    rows = np.array([(0, v, *(int(n) for n in rng.integers(0, 24, 2))) for v in (0, 1, 2, 3, 1, 3)], np.int64)
    for box, step in (((0, 2, 16, 16), 3), ((38, 46, 8, 8), 1)):
        out = np.empty(len(rows), np.int64)
        placement_kernels.mirrored_pixels(sewing.grown, sewing.pieces, sewing.variants.turns, box, rows, step, out)
        assert out.tolist() == [naive_twins(sewing, box, tuple(row), step) for row in rows.tolist()]


def halves() -> graphcut_textures.GraphcutMap:
    """A map whose left half shows the exemplar as it is, and whose right half is empty."""
    sewing = sewing_of(poses=(0, 1, 6))
    sewing.variant[:40, :26], sewing.yx[:40, :26] = 0, np.moveaxis(np.indices((40, 26)), 0, 2)
    return sewing


def test_a_mirror_is_left_aside() -> None:
    """The mirrored exemplar goes on where column 25 is at the mirror: it fits best, and is no placement."""
    sewing, box = halves(), (10, 20, 16, 16)
    rows = np.array([(0, 1, 10, 52 - 32), (5, 1, 20, 0), (6, 0, 10, 20)], np.int64)  # column 32 - x at column x
    assert sewing.apart(box, rows).tolist() == [False, True, True]
    every, one = (Candidates(some, 100, np.empty(0), np.ones((16, 16), bool)) for some in (rows, rows[:1]))
    assert (1, 10, 20) not in sewing.placements(box, every, 7, 12)
    assert sewing.placements(box, one, 7, 12) == [(1, 10, 20)]  # nothing else is there


def test_no_piece_grows_beside_its_mirror(monkeypatch: pytest.MonkeyPatch) -> None:
    grown = list[int]()
    for column in (26, 0):  # of the mirrored exemplar, at column 26 of the map
        sewing = halves()
        rows, columns = np.indices((40, 26))
        sewing.variant[:40, 26:52] = 1
        sewing.yx[:40, 26:52, 0], sewing.yx[:40, 26:52, 1] = rows, columns + column
        grown.append(0)

        def best(self: object, piece: graphcut_textures.Piece, found: object) -> None:
            grown[-1] += 1

        monkeypatch.setattr(graphcut_moves.ExpansionMove, "best", best)
        graphcut_moves.expand(sewing, Run(1), 1)
    assert grown == [0, 2]


def posed_alike(sewing: graphcut_textures.GraphcutMap, y: int, x: int, k: int) -> tuple[int, int] | None:
    """Where variant k shows what the map shows at (y, x): found among all its pixels; None: nowhere."""
    if sewing.variant[y, x] == HOLE:
        return None
    here = np.s_[y : y + 1, x : x + 1]
    shown, which, _ = sewing.variants.to_exemplars(sewing.yx[here], sewing.variant[here])
    if which[0, 0] != sewing.variants.exemplar[k]:
        return None
    tall, wide = sewing.variants.table[k, 1:3].tolist()
    own = np.moveaxis(np.indices((tall, wide)), 0, 2).astype(np.int32)
    its = sewing.variants.to_exemplars(own, np.full((tall, wide), k, np.uint8))[0]
    ((i, j),) = np.argwhere((its == shown[0, 0]).all(axis=2)).tolist()
    return i, j


@pytest.mark.parametrize(("seed", "toroidal"), [(0, False), (1, True)])
def test_what_is_shown_in_another_pose_is_a_repeat(seed: int, toroidal: bool) -> None:
    """As pixel by pixel: near by it counts as much as in the same pose; only in the same one it may go on."""
    sewing = sewing_of((Wrap.NONE, Wrap.X)[seed], (0, 1, 5, 6), toroidal, two=not seed)
    scattered(sewing, seed)
    rng, step, (height, width) = np.random.default_rng(seed), 7, sewing.variant.shape
    least = -6 if toroidal else 0  # over the border of what goes on
    rows = np.array([(0, v % 4, *(int(n) for n in rng.integers(least, 24, 2))) for v in range(8)], np.int64)
    look = placement_kernels.Look(0, 0, height, width, step)
    out = np.empty(len(rows), np.int64)
    how = (sewing.variants.turns, look, (9, 20, 16, 16), rows, ONE // 2)
    placement_kernels.repeats(sewing.grown, sewing.pieces, *how, out)
    for total, (_, k, u, s) in zip(out.tolist(), rows.tolist(), strict=True):
        want, reach, (tall, wide) = 0, 3 * 16 // 2 + 1, sewing.variants.table[k, 1:3].tolist()
        for y, x in product(range(step // 2, height, step), range(step // 2, width, step)):
            place = posed_alike(sewing, y, x, k)
            if place is None:
                continue
            dy, dx = y - 17, x - 28
            if sewing.wraps[1]:
                dx = (dx + width // 2) % width - width // 2
            i, j = place[0] - u, place[1] - s
            i, j = (i % tall, j % wide) if sewing.variants.toroidal[k] else (i, j)
            goes_on = sewing.variant[y, x] == k and (i, j) == (dy + 8, dx + 8)
            if 0 <= i < 16 and 0 <= j < 16:
                far = max(abs(dy), abs(dx))
                want += -ONE // 2 if goes_on else 3 * ONE * (reach - far) // reach if far < reach else 0
        assert total == want * step * step // 256


@pytest.mark.parametrize("nearby", [1000, 20])
def test_how_often_every_patch_is_shown(nearby: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """As pixel by pixel, in every pose, by the cells of the search; of a large map as much as of what is near."""
    monkeypatch.setattr(graphcut_textures, "NEARBY", nearby)
    exemplars = [Exemplar.of(texture(20, 24, 1, seed)) for seed in range(2)]
    sewing = empty(exemplars, Canvas(60, 70), GraphcutSettings(usage=0.1), 8, 3, isometries=(0, 5))
    scattered(sewing, 4)
    count_map(sewing.grown, sewing.pieces, sewing.usage)
    once = ONE * min(max(nearby, 48), 60) * min(max(nearby, 48), 70) // (60 * 70)
    f, (h, w) = sewing._search.factor, sewing._search.cells
    for v, (valid, counts) in enumerate(zip(sewing._search.valid, sewing.told.counts, strict=True)):
        cells = np.zeros((valid.shape[0] + h - 1, valid.shape[1] + w - 1), np.int64)
        for y, x in np.ndindex(*sewing.variant.shape):
            place = posed_alike(sewing, y, x, v)
            if place is not None and all(n // f < m for n, m in zip(place, cells.shape, strict=True)):
                cells[place[0] // f, place[1] // f] += 1
        for i, j in np.ndindex(*valid.shape):
            assert counts[i, j] == int(cells[i : i + h, j : j + w].sum()) * once // (h * w * f * f)


def test_patches_are_counted_again_once_one_is_laid() -> None:
    sewing = empty([Exemplar.of(texture(40, 40, 3, 9))], Canvas(30, 30))
    before, box = sewing.told, (0, 0, 16, 16)
    assert not any(counts.any() for counts in before.counts)
    cut = sewing.best(box, [(0, 8, 12)])
    assert sewing.told is before
    sewing.write(cut)
    sewing.note(cut)
    assert sewing.told.counts[0][8 // sewing._search.factor, 12 // sewing._search.factor] == ONE
    rows = np.array([(0, 0, 8, 12), (0, 0, 24, 0)], np.int64)
    known = np.ones((16, 16), bool)
    prices = sewing.priced((14, 14, 16, 16), Candidates(rows, 1000, np.empty(0), known))
    assert prices[0] > 1000 * graphcut_textures.REPEAT * sewing.stitch.usage > prices[1] == 0
