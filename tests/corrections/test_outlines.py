"""Outlines of an exemplar's features, and how far every pixel is from them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from intarsia.analysis.features import features
from intarsia.corrections.appearance import FAR, Outlines, edges, outline_distances
from intarsia.foundation.field import Field
from intarsia.model.exemplar import Exemplar
from intarsia.testing.cases import texture


def naive_distances(there: Any, toroidal: bool) -> list[list[int]]:
    """1 / 16 px to the nearest pixel that is there, looked for among all."""
    height, width = there.shape
    found = [(int(a), int(b)) for a, b in np.argwhere(there)]
    out = []
    for y in range(height):
        row = []
        for x in range(width):
            best = float(FAR)
            for a, b in found:
                dy, dx = abs(a - y), abs(b - x)
                if toroidal:
                    dy, dx = min(dy, height - dy), min(dx, width - dx)
                best = min(best, math.hypot(dy, dx))
            row.append(round(16 * best))
        out.append(row)
    return out


@pytest.mark.parametrize("toroidal", [False, True])
def test_distances_are_those_to_the_nearest_pixel(toroidal: bool) -> None:
    for seed, share in ((1, 0.02), (2, 0.2), (3, 0.99)):
        there = np.random.default_rng(seed).random((23, 41)) < share
        assert outline_distances(there, toroidal).tolist() == naive_distances(there, toroidal)
    assert (outline_distances(np.zeros((4, 5), bool), toroidal) == 16 * FAR).all()


def square(shift: int = 0) -> Any:
    picture = np.full((64, 64, 2), 200, np.int16)
    picture[16:48, 20:52, 1] = 800
    return np.roll(picture, shift, (0, 1))


def test_edges_run_where_the_features_change() -> None:
    """Around a square, closed, thin, and nowhere else."""
    found = edges(square(), False)
    y, x = np.nonzero(found)
    near = np.minimum(abs(y - 15.5), abs(y - 47.5)), np.minimum(abs(x - 19.5), abs(x - 51.5))
    assert (np.minimum(*near) <= 2).all()
    assert 100 < found.sum() < 160
    for row in range(24, 40):
        assert found[row].sum() == 2
        assert found[:, row + 4].sum() == 2
    assert (edges(square(), True) == found).all()
    assert (np.roll(edges(square(40), True), -40, (0, 1)) == found).all()


def test_edges_do_not_depend_on_contrast_and_flat_pictures_have_none() -> None:
    picture = features([Exemplar.of(texture(64, 70, 3, 5))]).pictures[0]
    found = edges(picture, False)
    assert 0.01 < found.mean() < 0.12
    assert (edges(square() - 150, False) == edges(square(), False)).all()
    faint, strong = edges(square() // 4, False), edges(square(), False)
    found = outline_distances(faint, False)[strong]
    assert found.max() <= 16, "rounding decides ties between the two sides, 1 px apart"
    assert outline_distances(strong, False)[faint].max() <= 16
    for shape in ((1, 1), (3, 40), (20, 20)):
        assert not edges(np.full((*shape, 1), 300, np.int16), False).any()
        assert edges(texture(*shape, 2, 1).astype(np.int16), True).shape == shape


@pytest.mark.parametrize("weight", [0.25, 1.0])
def test_the_channel_counts_as_much_as_the_colours(weight: float) -> None:
    """Its variance is `weight` times that of all channels; positive inside a mask, and for edges away from them."""
    e = Exemplar.of(texture(60, 80, 3, 5))
    picture = features([e]).pictures[0]
    inside = np.zeros((60, 80), bool)
    inside[20:45, 10:50] = True
    colours = picture.reshape(-1, 3).astype(float).var(axis=0).sum()
    for drawn in (None, Field(inside)):
        channel = Outlines(drawn, weight).channel(e, picture)
        assert channel.dtype == np.int16
        assert channel.shape == (60, 80, 1)
        assert abs(channel.astype(float).var() / (weight * colours) - 1) < 0.02
    assert channel[32, 30, 0] > channel[22, 30, 0] > channel[17, 30, 0] > channel[5, 70, 0]
    assert (Outlines(None, 0.0).channel(e, picture) == 0).all()
