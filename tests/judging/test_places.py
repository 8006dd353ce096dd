"""Where an output loses: joins lie where pieces meet."""

from __future__ import annotations

import numpy as np
import pytest
from judging.naive_windows import blobs

import intarsia as ia
from intarsia.judging import Judged, judge, local_join_costs
from intarsia.judging.places import MOST, places
from intarsia.model import Exemplar

STONES = (blobs(128, 128, 1) // 4).astype(np.uint8)
SIZE = STONES.shape[:2]


def judged(*exemplars: np.ndarray, output: np.ndarray) -> Judged:
    return judge([Exemplar.of(e) for e in exemplars], Exemplar.of(output))


def test_joins_lie_where_pieces_meet() -> None:
    halves = np.concatenate([STONES[:, :64], STONES[:, 16:80]], axis=1)
    cost = local_join_costs(judged(STONES, output=halves), SIZE)
    assert cost.shape == (16, 16)
    assert cost[:, 7:9].mean() > 5 * cost[:, :4].mean()
    assert cost[:, 7:9].mean() > 5 * cost[:, 12:].mean()
    below = local_join_costs(judged(STONES, output=halves.swapaxes(0, 1)[:, ::-1]), SIZE)
    assert 0 <= below.min() <= below.max() <= 1


def test_the_exemplar_has_no_joins() -> None:
    assert local_join_costs(judged(STONES, output=STONES), SIZE).max() == 0


def test_joins_of_reduced_pictures_have_their_place() -> None:
    halves = np.concatenate([STONES[:, :64], STONES[:, 16:80]], axis=1)
    found = judged(*(a.repeat(5, 0).repeat(5, 1) for a in (STONES, STONES)), output=halves.repeat(5, 0).repeat(5, 1))
    assert found.factor == 2
    cost = local_join_costs(found, (640, 640))
    assert cost.shape == (40, 40)
    assert cost[:, 18:22].mean() > 5 * cost[:, :10].mean()


def test_nothing_is_told_of_what_is_too_small() -> None:
    tiny = STONES[:12, :12]
    found = judged(tiny, output=STONES)
    assert local_join_costs(found, SIZE).max() == 0
    assert ia.score(tiny, STONES).total == found.score.total


def test_squares_are_where_the_worst_joins_are() -> None:
    halves = np.concatenate([STONES[:, :64], STONES[:, 16:80]], axis=1)
    found = places(judged(STONES, output=halves))["joins"]
    assert 1 <= len(found) <= MOST
    assert all(x < 64 < x + side and 0 <= y < 128 for x, y, side in found)
    assert not places(judged(STONES, output=STONES))["joins"]


@pytest.mark.parametrize("times", [1, 5])
def test_squares_are_wherever_the_place_is_that_is_shown_too_often(times: int) -> None:
    output, spots = STONES.copy(), [(0, 0), (0, 80), (80, 0), (80, 80)]  # as it is, but for what is copied
    for y, x in spots:
        output[y : y + 48, x : x + 48] = STONES[40:88, 40:88]
    large, shows = (a.repeat(times, 0).repeat(times, 1) for a in (STONES, output))
    found = judged(large, output=shows)
    for part in ("overused", "repeats"):
        shown = [(x / times, y / times) for x, y, _ in places(found)[part]]
        far = [min(abs(x - u) + abs(y - v) for v, u in spots) for x, y in shown]
        assert len(shown) >= 4, part
        assert np.mean([one < 32 for one in far]) >= 0.75, (part, shown)
