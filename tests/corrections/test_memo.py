"""The correction kernel against the memorandum's own words (S4-03 to S4-07)."""

from __future__ import annotations

import numpy as np
import pytest
from corrections.naive_memo import Memo

import intarsia as ia
from intarsia.corrections.correction_kernels import correct
from intarsia.corrections.coordinate_pyramid import CorrectionParameters
from intarsia.corrections.stack import ComparisonSettings, exemplar_stack
from intarsia.model import Exemplar
from intarsia.testing.cases import noise, texture

SIDE, MAP, STILL = 24, 20, 4
ROUNDING = 2.0  # of distances of some hundred: colours, up to 1020, are cut to whole numbers after they are weighed
OWN = tuple(float(w) for w in np.outer((0.25, 0.75, 1, 0.5, 0.1), (0.4, 0.6, 1, 0.9, 0.2)).ravel())
GAUSSIAN = tuple(4.0 ** -((dy * dy + dx * dx) / 4) for dy in range(-2, 3) for dx in range(-2, 3))


@pytest.mark.parametrize("penalty", [1, 2, "inf"])
@pytest.mark.parametrize("mask", [None, OWN], ids=["default", "own"])
def test_the_pixel_of_least_distance_by_the_memo_is_taken(mask: tuple[float, ...] | None, penalty: float) -> None:
    """The mask weighs squared differences: a quarter in 2 px by default, and as it is said else."""
    method = ia.Correction2008(kappa=penalty, neighbourhood_mask=mask, k=3, channel_weights=(1, 1, 1), jitter=0)
    e = Exemplar.of(texture(SIDE, SIDE, 3, 5), toroidal=True)
    level = exemplar_stack(e, ComparisonSettings.of(method)).levels[0].ready()
    border, stride = level.border, level.stride
    inner = slice(border, border + SIDE)
    source = level.values.reshape(-1, stride, 3)[inner, inner]
    named = {u: ((u[0] + border) * stride + u[1] + border) for u in np.ndindex(SIDE, SIDE)}
    place = {int(level.inner[n]): u for u, n in named.items()}
    similar = {u: [place[int(v)] for v in level.jumps[n] if v >= 0] for u, n in named.items()}
    memo = Memo(source, np.reshape(mask or GAUSSIAN, (5, 5)), float(penalty), similar)

    torn = noise(2, MAP * MAP, 7).reshape(2, MAP, MAP)
    often = noise(MAP, MAP, 9) % np.uint64(2) == 0
    moved = np.moveaxis((torn % np.uint64(9)).astype(int) - 4, 0, 2) * often[..., None]
    coords = (np.stack(np.mgrid[:MAP, :MAP], axis=2) + moved + (5, 11)) % SIDE
    work = ((coords[..., 0] + border) * stride + coords[..., 1] + border).astype(np.int32)
    at, rule = np.arange(STILL, MAP - STILL), np.array([2, 0, CorrectionParameters.of(method).factor])
    out = np.empty((len(at), len(at)), np.int32)
    correct(work, at, at, 0, len(at), level, rule, None, out)
    for i, y in enumerate(at):
        for j, x in enumerate(at):
            shown = [[tuple(map(int, u)) for u in row] for row in coords[y - 2 : y + 3, x - 2 : x + 3]]
            prices = memo.prices(shown)
            assert prices[place[int(out[i, j])]] <= min(prices.values()) + ROUNDING
