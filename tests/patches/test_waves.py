"""Windows that are worked on at the same time never touch what another one reads or writes."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from intarsia.foundation.geometry import apart, patch_starts
from intarsia.patches import WindowGrid, window_batches

PATCH, OVERLAP = (9, 14), (2, 5)


def grid(height: int, width: int, wraps: tuple[bool, bool]) -> WindowGrid:
    (rows, high), (columns, wide) = (
        patch_starts(*axis) for axis in zip((height, width), PATCH, OVERLAP, wraps, strict=True)
    )
    return WindowGrid(tuple(rows), tuple(columns), (high, wide), (height, width), wraps)


@pytest.mark.parametrize("around", [0, 4, 15])
@pytest.mark.parametrize("wraps", list(itertools.product([False, True], repeat=2)))
def test_windows_of_a_wave_lie_apart_on_canvases_of_any_width(wraps: tuple[bool, bool], around: int) -> None:
    """Where the last window is moved in from the border it may overlap the one before the last, too."""
    for height, width in itertools.product((9, 13, 22, 40), range(14, 90)):
        layout = grid(height, width, wraps)
        found = window_batches(layout, np.ones(layout.shape, bool), around)
        assert sorted(itertools.chain(*found)) == sorted(np.ndindex(*layout.shape))
        for a, b in itertools.chain(*(itertools.combinations(wave, 2) for wave in found)):
            away = [
                apart(p, q, length, wrap)
                for p, q, length, wrap in zip(layout.at(*a), layout.at(*b), (height, width), wraps, strict=True)
            ]
            assert any(n >= side + around for n, side in zip(away, layout.patch, strict=True)), (height, width, a, b)
