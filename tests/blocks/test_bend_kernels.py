"""Gaps that are bent so that lines meet."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import torture
from blocks import naive_bend

import intarsia as ia
from intarsia.blocks import bend_kernels
from intarsia.testing import texture


@pytest.mark.parametrize("seed", range(4))
def test_costs_of_nodes_are_those_of_the_pixels_around_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    picture = texture(30, 34, 3, seed).astype(np.int16)
    usable = rng.random((30, 34)) > 0.1
    places = rng.integers(0, 20, (60, 2))
    values = rng.integers(0, 255, (60, 3)).astype(np.int16)
    cost = np.zeros((6, 6, 5, 5), np.int64)
    bend_kernels.node_costs(picture, usable, places, values, 4, 7, 2, 5, cost)
    np.testing.assert_array_equal(
        cost, naive_bend.node_costs(picture, usable, places, values, (4, 7), 2, 5, (20, 20))
    )


@pytest.mark.parametrize("seed", range(4))
def test_no_single_node_could_move_for_the_better(seed: int) -> None:
    cost = np.random.default_rng(seed).integers(0, 4000, (3, 4, 3, 3))
    moves = np.empty((3, 4, 2), np.int64)
    bend_kernels.choose_moves(cost, bend_kernels.STIFF, bend_kernels.PULL, moves)
    scale = int(np.mean([cost[n].sum() // 9 - cost[n].min() for n in np.ndindex(3, 4)]))

    def energy(some: np.ndarray) -> int:
        return naive_bend.energy(cost, some, bend_kernels.STIFF, bend_kernels.PULL, scale, bend_kernels.WEIGHT)

    for node in np.ndindex(3, 4):
        for move in itertools.product((-1, 0, 1), (-1, 0, 1)):
            other = moves.copy()
            other[node] = move
            assert energy(other) >= energy(moves)


def test_what_fits_nowhere_better_stays() -> None:
    moves = np.full((3, 3, 2), 9, np.int64)
    bend_kernels.choose_moves(np.zeros((3, 3, 5, 5), np.int64), bend_kernels.STIFF, bend_kernels.PULL, moves)
    assert not moves.any()
    bend_kernels.choose_moves(np.full((3, 3, 5, 5), 77, np.int64), bend_kernels.STIFF, bend_kernels.PULL, moves)
    assert not moves.any()


def test_pixels_move_as_the_nodes_around_them() -> None:
    moves = np.random.default_rng(1).integers(-2, 3, (4, 5, 2))
    field = np.empty((17, 23, 2), np.int64)
    bend_kernels.spread_moves(moves, 6, field)
    np.testing.assert_array_equal(field, naive_bend.field_of(moves, 6, (17, 23)))


def test_a_block_follows_a_neighbour_that_is_shifted() -> None:
    """The neighbours show the block's own surroundings, 1 px lower: so does the block, then."""
    picture = texture(60, 60, 3, 2).astype(np.int16)
    places = np.array([(y, x) for y in range(24) for x in range(24) if min(y, x, 23 - y, 23 - x) < 6])
    values = np.array([picture[y + 11, x + 10] for y, x in places])
    shift = np.full((24, 24, 2), 10, np.int64)
    bend_kernels.bend(picture, np.ones((60, 60), bool), places, values, 2, 6, np.ones((24, 24), np.uint8), shift)
    assert (shift[:, :, 0] == 11).mean() > 0.9
    assert (shift[:, :, 1] == 10).mean() > 0.9


def warped(size: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Torture case 5, larger: a wall warped by up to 2 px, and every pixel's place in the straight wall."""
    rng = np.random.default_rng(seed)
    y, x = torture.grid(size) + np.clip([torture.smooth(rng, size, 14), torture.smooth(rng, size, 14)], -2, 2)
    return torture.byte(torture.wall(y, x, rng)), y, x


def misses(made: ia.Synthesis, y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """By how much lines miss each other at the cuts between blocks, px: beds across, joints along."""
    yx, found = made.map.yx.astype(int), []
    for before, after, step, place in (
        (yx[:-1], yx[1:], (1, 0), x), (yx[:, :-1], yx[:, 1:], (0, 1), y),
    ):  # fmt: skip
        cut = np.abs(after - before - step).max(axis=-1) > 4  # more than a bend
        gap = place[after[cut][:, 0], after[cut][:, 1]] - place[before[cut][:, 0], before[cut][:, 1]]
        found.append(np.abs((gap + 6) % 12 - 6))  # courses of 12 px, joints every 24 px, offset by half
    return np.concatenate(found)


def test_mortar_lines_of_a_warped_wall_meet() -> None:
    """Torture case 5: the median miss is at most half a pixel, also where blocks stay stiff, and less if they bend."""
    stiff, bent = [], []
    for seed in (5, 6, 7):
        picture, y, x = warped(192, seed)
        lattice = ((12.0, 12.0), (24.0, 0.0))
        for reach, found in ((0, stiff), (1, bent)):
            made = ia.synthesize(picture, 360, ia.NearRegular(lattice=lattice, bend=reach), seed=1)
            found.append(misses(made, y, x))
    assert all(np.median(m) <= 0.45 for m in bent)
    assert np.median(np.concatenate(stiff)) <= 0.5
    assert np.median(np.concatenate(bent)) < 0.85 * np.median(np.concatenate(stiff))
