"""Where windows come from: whole pieces change nothing, and where two meet the change is that of the exemplar."""

from __future__ import annotations

import numpy as np
import pytest
from judging.naive_windows import blobs
from numpy.typing import NDArray

from intarsia.judging.sources import STEP, Level, Reference, Sources

EXEMPLAR = blobs(96, 96, 3)


@pytest.fixture(scope="module")
def level() -> Level:
    return Reference((EXEMPLAR,), (None,)).levels[0]


def sources(level: Level, output: NDArray[np.int16]) -> Sources:
    return Sources.of(level, np.ascontiguousarray(output))


def test_a_piece_is_found_where_it_was_cut(level: Level) -> None:
    found = sources(level, EXEMPLAR[10:74, 20:84])
    rows, columns = np.indices(found.number.shape)
    at = level.windows.at[found.number]
    assert (at[..., 0] == rows * STEP // 2 + 5).all()
    assert (at[..., 1] == columns * STEP // 2 + 10).all()
    assert (found.distance == 0).all()
    assert (found.join_costs == 0).all()


def test_two_pieces_change_where_they_meet_and_nowhere_else(level: Level) -> None:
    found = sources(level, np.hstack([EXEMPLAR[:64, :32], EXEMPLAR[30:94, 60:92]]))
    down, right = found.join_costs[1], found.join_costs[0]
    assert found.join_costs.shape == (2, *found.number.shape)
    across = np.flatnonzero(right.any(axis=0))
    assert across.min() >= 3
    assert across.max() <= 5  # windows of 16 px that reach over column 32
    assert (down[:, :3] == 0).all()
    assert (down[:, 5:] == 0).all()
    assert 0 < right.max() <= 1024


def test_what_goes_on_as_the_exemplar_does_is_no_change() -> None:
    """A lattice kept is a lattice seen: tiles that lie at whole periods change nothing, though each is another copy."""
    tile = blobs(16, 16, 5)
    wall = np.tile(tile, (6, 6, 1))
    level = Reference((wall,), (None,)).levels[0]
    kept = np.hstack([wall[:64, :40], wall[32:96, 40:80]])
    slipped = np.hstack([wall[:64, :40], wall[6:70, 45:85]])
    assert (sources(level, kept).join_costs == 0).all()
    assert sources(level, slipped).join_costs.sum() > 0


def test_a_step_of_tone_is_seen_by_its_tone_alone() -> None:
    """Two halves of one slope, of the same grain, laid side by side: the windows look alike but for their tone."""
    x = np.mgrid[:192, :192][1]
    slope = (blobs(192, 192, 3) // 8 + (4 * x)[..., None]).astype(np.int16)
    level = Reference((slope,), (None,)).levels[1]
    even, stepped = (sources(level, p) for p in (slope[:128, :128], np.hstack([slope[:128, 128:], slope[:128, :64]])))
    assert even.steps.sum() == 0
    assert stepped.steps.max() >= 1000
    assert stepped.steps.sum() > stepped.join_costs.sum()


def test_neighbours_agree_where_two_windows_are_alike() -> None:
    """Of the copies of a tile each window shows one, and neighbours mostly show the same."""
    wall = np.tile(blobs(16, 16, 5), (6, 6, 1))
    found = sources(Reference((wall,), (None,)).levels[0], wall[:64, :64])
    rows, columns = np.indices(found.number.shape)
    at = found.level.windows.at[found.number]
    offsets = at - np.dstack([rows, columns]) * STEP // 2
    assert (found.distance == 0).all()
    assert len(np.unique(offsets[1:, 1:].reshape(-1, 2), axis=0)) < 16


def test_usage_counts_every_window(level: Level) -> None:
    found = sources(level, np.vstack([EXEMPLAR[:32, :64]] * 2))
    assert found.usage.sum() == found.number.size
    at = level.windows.at[found.number]
    for y, x in np.unique(at.reshape(-1, 2), axis=0):
        assert found.usage[y, x] == int(((at[..., 0] == y) & (at[..., 1] == x)).sum())
