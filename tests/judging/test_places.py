"""Where an output loses: joins lie where pieces meet, and the place that is shown again and again is found."""

from __future__ import annotations

import numpy as np
import pytest
from judging.naive_windows import blobs

import intarsia as ia
from intarsia.foundation.geometry import Wrap
from intarsia.judging import Judged, judge, local_join_costs, overused_places, usage_of
from intarsia.model import Exemplar

STONES = (blobs(128, 128, 1) // 4).astype(np.uint8)
SIZE = STONES.shape[:2]


def judged(*exemplars: np.ndarray, output: np.ndarray, wrap: Wrap = Wrap.NONE) -> Judged:
    return judge([Exemplar.of(e) for e in exemplars], Exemplar.of(output), wrap)


def test_joins_lie_where_pieces_meet() -> None:
    halves = np.concatenate([STONES[:, :64], STONES[:, 16:80]], axis=1)
    cost = local_join_costs(judged(STONES, output=halves), SIZE)
    assert cost.shape == (16, 16)
    assert cost[:, 7:9].mean() > 5 * cost[:, :4].mean()
    assert cost[:, 7:9].mean() > 5 * cost[:, 12:].mean()
    below = local_join_costs(judged(STONES, output=halves.swapaxes(0, 1)[:, ::-1]), SIZE)
    assert 0 <= below.min() <= below.max() <= 1


def test_the_exemplar_has_no_joins_and_nothing_too_often() -> None:
    found = judged(STONES, output=STONES)
    assert local_join_costs(found, SIZE).max() == 0
    assert overused_places(found, [SIZE], SIZE) == ()


@pytest.mark.parametrize("wrap", [Wrap.NONE, Wrap.BOTH])
def test_the_place_that_is_shown_again_and_again_is_found(wrap: Wrap) -> None:
    corner = np.tile(STONES[72:104, 40:72], (6, 6, 1))
    found = overused_places(judged(STONES, output=corner, wrap=wrap), [SIZE], (192, 192))
    first = found[0]
    assert first.number == 0
    assert 72 - 8 <= first.place.y <= 104 + 8
    assert 40 - 8 <= first.place.x <= 72 + 8
    assert 25 <= len(first.occurrences) <= 36
    assert all(0 <= s.y < 192 and 0 <= s.x < 192 for s in first.occurrences)
    assert first.times > 5


def test_it_is_found_in_the_second_exemplar_and_in_reduced_ones() -> None:
    other = (blobs(96, 128, 7) // 4).astype(np.uint8)
    corner = np.tile(other[40:72, 80:112], (6, 6, 1))
    sizes = [SIZE, other.shape[:2]]
    first = overused_places(judged(STONES, other, output=corner), sizes, (192, 192))[0]
    assert first.number == 1
    assert 32 <= first.place.y <= 80
    assert 72 <= first.place.x <= 120
    large, often = STONES.repeat(5, 0).repeat(5, 1), corner.repeat(5, 0).repeat(5, 1)
    found = judged(large, other.repeat(5, 0).repeat(5, 1), output=often)
    assert found.factor == 2
    first = overused_places(found, [(640, 640), (480, 640)], (960, 960))[0]
    assert first.number == 1
    assert 160 <= first.place.y <= 400
    assert local_join_costs(found, (960, 960)).shape == (60, 60)


def test_usage_is_that_of_the_windows() -> None:
    """A slow twin: every shown window counts for each of its pixels."""
    corner = np.tile(STONES[:48, :48], (3, 3, 1))
    found = judged(STONES, output=corner)
    (share,) = usage_of(found, [SIZE])
    sources = found.looks[0].sources[0]
    slow, most = np.zeros((64, 64)), np.zeros((64, 64))
    for number, (y, x) in enumerate(sources.level.windows.at):
        slow[y : y + 8, x : x + 8] += (sources.number == number).sum()
        most[y : y + 8, x : x + 8] += 1
    usual = sources.number.size / len(sources.level.windows.at)
    assert share[::2, ::2] == pytest.approx(slow / most / usual)
    assert share[:40, :40].mean() > 4 * share[64:, 64:].mean()


def test_nothing_is_told_of_what_is_too_small() -> None:
    tiny = STONES[:12, :12]
    found = judged(tiny, output=STONES)
    assert overused_places(found, [(12, 12)], SIZE) == ()
    assert local_join_costs(found, SIZE).max() == 0
    assert usage_of(found, [(12, 12)])[0].shape == (12, 12)
    assert ia.score(tiny, STONES).total == found.score.total
