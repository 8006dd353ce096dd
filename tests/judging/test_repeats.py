"""The same neighbours again: as plain loops find them; a chunk that returns counts, single places do not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from judging.naive_parts import shown_again as plain
from judging.naive_windows import blobs

from intarsia.judging.parts import recurring_windows, seen_again
from intarsia.judging.sources import Reference, Sources


def told(at: np.ndarray) -> Any:
    """Sources that show the places `at`, (rows, columns, 2)."""
    windows = SimpleNamespace(at=at.reshape(-1, 2), stride=1)
    number = np.arange(at[..., 0].size).reshape(at.shape[:2])
    return SimpleNamespace(level=SimpleNamespace(windows=windows), number=number)


def test_it_is_what_plain_loops_find() -> None:
    rng = np.random.default_rng(5)
    at = np.stack(np.mgrid[:14, :16], axis=2) * 4
    at[7:13, 8:15] = at[0:6, 1:8] + rng.integers(-1, 2, (6, 7, 2))
    at[rng.random(at.shape[:2]) < 0.15] += 60
    for reach in (5, 9, 20):
        assert (recurring_windows(told(at), reach) == plain(at, reach)).all()
    assert recurring_windows(told(at), 20).any()
    assert not recurring_windows(told(at), 5).all()


def test_a_chunk_that_returns_counts_and_its_pieces_do_not() -> None:
    """Four times the same quarter; then the same places as often, in squares of 16 px in another order each time."""
    exemplar = blobs(128, 128, 1)
    reference = Reference((exemplar,), (None,))
    chunk = exemplar[32:96, 32:96]
    squares = chunk.reshape(4, 16, 4, 16, 3).swapaxes(1, 2).reshape(16, 16, 16, 3)
    orders = [np.random.default_rng(k).permutation(16) for k in range(4)]
    mixed = [squares[o].reshape(4, 4, 16, 16, 3).swapaxes(1, 2).reshape(64, 64, 3) for o in orders]
    whole = np.tile(chunk, (2, 2, 1))
    dealt = np.vstack([np.hstack(mixed[:2]), np.hstack(mixed[2:])])
    found = [100 * seen_again(reference, Sources.of(reference.levels[0], p)).mean() for p in (exemplar, whole, dealt)]
    assert found[0] == 0
    assert found[1] > 80
    assert found[2] < found[1] / 4
