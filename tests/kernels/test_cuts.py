"""Tests of the pair cost, of the cuts by shortest paths and of the maximum flow behind the other shapes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kernels.naive_cuts import exhaustive_cost, mask_cost, scipy_flow_cost, two_path_mask
from numpy.typing import NDArray

from intarsia.kernels.cuts import FLAT, GRADIENT_UNIT, PLAIN, SeamPrice, min_cut, seam_costs
from intarsia.kernels.maxflow import grid_min_cut

State = NDArray[np.uint8]
Costs = tuple[NDArray[np.int32], NDArray[np.int32]]


def costs_for(rng: np.random.Generator, height: int, width: int, most: int) -> Costs:
    """Draw costs from 0 to `most`."""
    return (
        rng.integers(0, most + 1, (height, width - 1)).astype(np.int32),
        rng.integers(0, most + 1, (height - 1, width)).astype(np.int32),
    )


def overlap_state(height: int, width: int, overlap: int, sides: str) -> State:
    """Make the state of a patch that overlaps old pixels along some of the sides l, r, t and b."""
    state = np.full((height, width), 2, np.uint8)
    views = {"l": state, "r": state[:, ::-1], "t": state.T, "b": state[::-1].T}
    for side in sides:
        views[side][:, :overlap] = 1
    for side in sides:
        views[side][:, 0] = 0
    return state


def blob_state(rng: np.random.Generator, height: int, width: int, blobs: int) -> State:
    """Make a state of random forced rectangles, many of them against the border."""
    state = np.ones((height, width), np.uint8)
    for _ in range(blobs):
        y, x = int(rng.integers(-1, height)), int(rng.integers(-1, width))
        h, w = int(rng.integers(1, 4)), int(rng.integers(1, 4))
        state[max(y, 0) : y + h, max(x, 0) : x + w] = rng.choice([0, 0, 1, 2, 2])
    return state


def check(state: State, right: NDArray[np.int32], down: NDArray[np.int32], want: int) -> None:
    """Both solvers reach the wanted cost, their masks cost just that, and what is forced stays so."""
    for solve in (min_cut, grid_min_cut):
        out = np.full(state.shape, 7, np.uint8)
        solve(state, right, down, out)
        assert mask_cost(out, right, down) == want
        assert set(np.unique(out)) <= {0, 1}
        if (state == 0).any() and (state == 2).any():
            assert (out[state == 0] == 0).all()
            assert (out[state == 2] == 1).all()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(1, 4), st.sampled_from([0, 1, 3, 1000]))
def test_tiny_windows_reach_the_exhaustive_minimum(seed: int, height: int, width: int, most: int) -> None:
    """On tiny windows with any state no mask costs less."""
    rng = np.random.default_rng(seed)
    state = rng.choice(3, (height, width), p=[0.2, 0.6, 0.2]).astype(np.uint8)
    for y, x in np.argwhere(state == 1)[11:]:
        state[y, x] = 2
    right, down = costs_for(rng, height, width, most)
    check(state, right, down, exhaustive_cost(state, right, down))


@settings(max_examples=80, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 14), st.integers(2, 14), st.integers(2, 9))
def test_windows_of_any_shape_reach_the_flow_value(seed: int, height: int, width: int, blobs: int) -> None:
    """Windows with random forced pieces cost what scipy's maximum flow carries."""
    rng = np.random.default_rng(seed)
    state = blob_state(rng, height, width, blobs)
    right, down = costs_for(rng, height, width, int(rng.choice([1, 5, 1000, 2**20])))
    check(state, right, down, scipy_flow_cost(state, right, down))


@pytest.mark.parametrize("sides", ["l", "t", "lt", "rb", "ltr", "tlb", "lr", "tb", "ltrb"])
@pytest.mark.parametrize("overlap", [2, 5])
def test_the_overlaps_of_quilting_reach_the_flow_value(sides: str, overlap: int) -> None:
    """Strips, Ls, Us, opposite strips and the ring around a hole are cut at the cost of the maximum flow."""
    rng = np.random.default_rng(len(sides) * 10 + overlap)
    state = overlap_state(17, 21, overlap, sides)
    heavy = np.exp(rng.normal(3, 3, (17, 20))).astype(np.int32), np.exp(rng.normal(3, 3, (16, 21))).astype(np.int32)
    for right, down in (*(costs_for(rng, 17, 21, most) for most in (1, 300, 2**20)), heavy):
        check(state, right, down, scipy_flow_cost(state, right, down))


def test_a_seam_may_leave_the_window_between_two_new_pieces() -> None:
    """Free pixels at the border between two new pieces go to the old side where that is cheaper."""
    state = np.array([[2, 2], [0, 1], [0, 1], [1, 2]], np.uint8)
    right = np.array([[2], [9], [9], [9]], np.int32)
    down = np.array([[5, 1], [5, 5], [4, 4]], np.int32)
    for _ in range(4):
        check(state, right, down, 14)
        state, right, down = (np.rot90(a).copy() for a in (state, down, right))


@pytest.mark.parametrize(("forced", "taken"), [(1, 1), (2, 1), (0, 0)])
def test_without_both_kinds_there_is_nothing_to_cut(forced: int, taken: int) -> None:
    """With nothing forced old all becomes new, and with only old pixels forced all stays old, at no cost."""
    rng = np.random.default_rng(3)
    state = np.ones((5, 6), np.uint8)
    state[1:3, 2:4] = forced
    right, down = costs_for(rng, 5, 6, 9)
    for solve in (min_cut, grid_min_cut):
        out = np.full((5, 6), 7, np.uint8)
        solve(state, right, down, out)
        assert (out == taken).all()


def test_free_cuts_take_the_shortest_seam() -> None:
    """Where every cut costs the same the seam is straight, not wherever the search came first."""
    state = overlap_state(9, 12, 12, "l")
    state[:, -1] = 2
    out = np.empty((9, 12), np.uint8)
    min_cut(state, np.zeros((9, 11), np.int32), np.zeros((8, 12), np.int32), out)
    assert (out == out[0]).all()


def test_the_flow_takes_the_fewest_old_pixels() -> None:
    """Among cuts of equal cost the maximum flow keeps the least of the old."""
    state = np.array([[0, 1, 1, 2]], np.uint8)
    out = np.empty((1, 4), np.uint8)
    grid_min_cut(state, np.full((1, 3), 4, np.int32), np.empty((0, 4), np.int32), out)
    assert out.tolist() == [[0, 1, 1, 1]]


def test_large_costs_do_not_overflow() -> None:
    """Costs just below the documented limit add up exactly, in a window where they cannot be shifted."""
    state = overlap_state(300, 6, 6, "l")
    state[:, -1] = 2
    right, down = (np.full(shape, 2**30 - 1, np.int32) for shape in ((300, 5), (299, 6)))
    for solve in (min_cut, grid_min_cut):
        out = np.empty((300, 6), np.uint8)
        solve(state, right, down, out)
        assert mask_cost(out, right, down) == 300 * (2**30 - 1)


def test_never_dearer_than_the_two_paths_of_quilting() -> None:
    """On L-shaped overlaps no cut by two monotone paths costs less, measured by the same pair cost."""
    rng = np.random.default_rng(5)
    state = overlap_state(42, 42, 7, "lt")
    out = np.empty((42, 42), np.uint8)
    cheaper = 0
    for _ in range(100):
        old, new = rng.integers(-1023, 1024, (2, 42, 42, 3)).astype(np.int16)
        right, down = seam_costs(old, new, PLAIN)
        squared = ((old.astype(np.int64) - new) ** 2).sum(axis=2)
        rule = two_path_mask(squared, 7)
        assert (rule[state == 0] == 0).all()
        assert (rule[state == 2] == 1).all()
        min_cut(state, right, down, out)
        cost = mask_cost(out, right, down)
        assert cost <= mask_cost(rule, right, down)
        cheaper += cost < mask_cost(rule, right, down)
    assert cheaper > 90


def test_the_same_window_gives_the_same_mask() -> None:
    """Ties are broken alike in every call, and a mask of truth values serves as well as one of bytes."""
    rng = np.random.default_rng(6)
    for sides in ("lt", "lr", "ltrb"):
        state = overlap_state(24, 24, 6, sides)
        right, down = costs_for(rng, 24, 24, 2)
        first, again = np.empty((24, 24), np.uint8), np.empty((24, 24), np.bool_)
        min_cut(state, right, down, first)
        min_cut(state.copy(), right.copy(), down.copy(), again)
        assert (first == again).all()


@pytest.mark.parametrize(("low", "high", "apart"), [(0, 1023, 1023), (-1023, 1023, 2046), (-2048, 2047, 4095)])
def test_opposite_values_are_their_real_distance_apart(low: int, high: int, apart: int) -> None:
    """Black against white neither wraps nor saturates, in one channel or in three."""
    for channels in (1, 3):
        old, new = (np.full((3, 4, channels), value, np.int16) for value in (low, high))
        for costs, shape in zip(seam_costs(old, new, PLAIN), ((3, 3), (2, 4)), strict=True):
            np.testing.assert_array_equal(costs, np.full(shape, 2 * int(np.sqrt(channels * apart**2))))


def test_seam_costs_follow_their_formula() -> None:
    """All kinds of cost are the documented ones, pixel for pixel."""
    rng = np.random.default_rng(8)
    old, new = rng.integers(-2048, 2048, (2, 6, 7, 4)).astype(np.int64)

    def norm(difference: NDArray[np.int64]) -> NDArray[np.int64]:
        return np.floor(np.sqrt((difference**2).sum(axis=2))).astype(np.int64)

    apart = norm(old - new)
    for price in (PLAIN, SeamPrice(gradient=True), SeamPrice(threshold=900)):
        right, down = seam_costs(old.astype(np.int16), new.astype(np.int16), price)
        for costs, axis in ((right, 1), (down, 0)):
            n = apart.shape[axis]
            want = apart.take(range(n - 1), axis) + apart.take(range(1, n), axis)
            if price.threshold:
                want = np.where(want < 3600, want * want // 900, 4 * want)
            if price.gradient:
                change = norm(np.diff(old, axis=axis)) + norm(np.diff(new, axis=axis))
                want = want * GRADIENT_UNIT // (FLAT + change)
            assert costs.dtype == np.int32
            assert (costs == want).all()
