"""Outlines of an exemplar's features, and how far every pixel is from them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from intarsia.analysis.features import features
from intarsia.corrections.appearance import FAR, Outlines, outline_distances
from intarsia.foundation.field import Field
from intarsia.model import Exemplar
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
