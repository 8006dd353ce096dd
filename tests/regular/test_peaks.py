"""Peaks are those that SciPy finds."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import find_peaks

from intarsia.regular.masonry import peaks


@given(st.lists(st.integers(0, 9), min_size=3, max_size=60), st.integers(0, 8), st.integers(1, 8))
def test_peaks_are_those_of_scipy(levels: list[int], height: int, prominence: int) -> None:
    profile = np.array(levels, float)
    expected, _ = find_peaks(profile, height=height, prominence=prominence)
    assert peaks(profile, height, prominence, 1) == expected.tolist()


@given(st.permutations(range(40)), st.integers(1, 12), st.integers(0, 20))
def test_the_higher_of_two_that_are_near_stays(levels: list[int], distance: int, prominence: int) -> None:
    profile = np.array(levels, float)
    expected, _ = find_peaks(profile, height=0, prominence=prominence, distance=distance)
    assert peaks(profile, 0, prominence, distance) == expected.tolist()
    assert peaks(np.array([0.0, 5, 0, 5, 0]), 1, 1, 3) == [3], "of two as high the later"
