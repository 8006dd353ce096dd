"""Outlines of an exemplar's features, and how far every pixel is from them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from intarsia.analysis.features import features
from intarsia.corrections.appearance import FAR, Outlines, outline_distances
from intarsia.foundation.field import Field
from intarsia.model import Exemplar
from intarsia.testing.cases import texture


def naive_distances(there: Any, toroidal: bool) -> list[int]:
    """1 / 16 px from every pixel to the nearest that is there, looked for among all."""
    out = []
    for place in np.ndindex(*there.shape):
        gaps = abs(np.argwhere(there) - place)
        gaps = np.minimum(gaps, there.shape - gaps) if toroidal else gaps
        out.append(round(16 * min(FAR, np.hypot(*gaps.T).min())))
    return out


@pytest.mark.parametrize("toroidal", [False, True])
def test_distances_are_those_to_the_nearest_pixel(toroidal: bool) -> None:
    for seed, share in ((1, 0.02), (2, 0.2), (3, 0.99)):
        there = np.random.default_rng(seed).random((23, 41)) < share
        assert outline_distances(there, toroidal).ravel().tolist() == naive_distances(there, toroidal)
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
