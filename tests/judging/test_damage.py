"""Damaged elements: the exemplar's own are whole, cut and merged and two-coloured ones are told."""

from __future__ import annotations

import numpy as np
import pytest
from judging.naive_parts import looks
from judging.naive_windows import blobs, smaller
from numpy.typing import NDArray

from intarsia.judging.damage import Elements, segments
from intarsia.segments.felzenszwalb import smoothed


def discs(side: int = 192, each: int = 32, seed: int = 0) -> NDArray[np.int16]:
    """Discs of several tones and sizes on dark ground, one in every cell, none at the border."""
    y, x = np.mgrid[:side, :side]
    cells = side // each
    rng = np.random.default_rng(seed)
    out = np.full((side, side, 3), 60, np.int16) + blobs(side, side, 9) // 64
    for i, j in np.ndindex(cells, cells):
        radius, tone = 9 + rng.integers(0, 4), 500 + 100 * rng.integers(0, 4)
        inside = (y - (i + 0.5) * each) ** 2 + (x - (j + 0.5) * each) ** 2 < radius**2
        out[inside] = np.array([tone, tone - 100, tone // 2]) + rng.integers(-8, 8)
    return out.astype(np.int16)


EXEMPLAR = discs()


@pytest.fixture(scope="module")
def elements() -> Elements:
    found = Elements.of([EXEMPLAR], [None])
    assert found is not None
    return found


def test_features_are_those_of_plain_loops(elements: Elements) -> None:
    small = smaller(discs(96, 24, 3), 2)
    labels, features = segments(small, elements.middle, elements.deviation, None)
    scaled = (small - elements.middle) * (256 * 64) // elements.deviation
    colours = smoothed(scaled.astype(np.int32), 1)
    assert len(features) == labels.max() >= 16
    for number in range(1, len(features) + 1):
        assert np.abs(features[number - 1] - looks(labels, colours, number)).max() <= 1
    for rim in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        assert (rim == 0).all()


def test_how_far_a_segment_is_from_those_known(elements: Elements) -> None:
    labels, far = elements.judged(discs(128, 32, 5))
    _, features = segments(smaller(discs(128, 32, 5), 2), elements.middle, elements.deviation, None)
    plain = [min(int(np.sqrt(((k - f) ** 2).sum())) for k in elements.known) for f in features]
    assert far.tolist() == plain
    assert labels.max() == len(far)
    own = sorted(
        min(int(np.sqrt(((k - f) ** 2).sum())) for j, k in enumerate(elements.known) if j != i)
        for i, f in enumerate(elements.known)
    )
    assert elements.usual == own[len(own) * 9 // 10]


def test_cut_merged_and_two_coloured_discs_are_damaged(elements: Elements) -> None:
    whole = discs(192, 32, 8)
    cut, merged, split = whole.copy(), whole.copy(), whole.copy()
    for i, j in np.ndindex(6, 6):
        cell = np.s_[32 * i : 32 * i + 32, 32 * j : 32 * j + 32]
        cut[cell][:15] = 60
        if j % 2 == 0:
            merged[32 * i + 8 : 32 * i + 24, 32 * j + 12 : 32 * j + 52] = whole[32 * i + 16, 32 * j + 16]
        split[cell][:, 16:] = np.minimum(split[cell][:, 16:], 300)
    found = [elements.outlined(p)[1] for p in (EXEMPLAR, whole, cut, merged, split)]
    assert found[0] == 0
    assert found[1] < 30
    assert min(found[2:]) > 60


def test_outlines_run_around_what_is_damaged_and_nothing_else(elements: Elements) -> None:
    """Pixel by pixel: those of a damaged segment with a neighbour outside of it, on half the px."""
    picture = discs(192, 32, seed=5)
    picture[64:96, 64:128] = picture[70, 70]  # a bar in place of two discs
    labels, far = elements.judged(picture)
    bad = {k + 1 for k in np.flatnonzero(far > elements.usual).tolist()}
    assert bad
    assert len(bad) < len(far)
    height, width = labels.shape
    want = np.zeros(labels.shape, bool)
    for y in range(height):
        for x in range(width):
            beside = [(y + a, x + b) for a, b in ((0, 1), (1, 0), (0, -1), (-1, 0))]
            inside = [labels[p] for p in beside if 0 <= p[0] < height and 0 <= p[1] < width]
            want[y, x] = labels[y, x] in bad and any(n != labels[y, x] for n in inside)
    found, share = elements.outlined(picture)
    assert share == pytest.approx(100 * len(bad) / len(far))
    assert found.shape == picture.shape[:2]
    assert np.array_equal(found, want.repeat(2, axis=0).repeat(2, axis=1))


def test_too_few_segments_say_nothing() -> None:
    assert Elements.of([np.full((64, 64, 3), 90, np.int16)], [None]) is None
    assert Elements.of([EXEMPLAR[:40, :40]], [None]) is None
    assert Elements.of([EXEMPLAR[:1, :1]], [None]) is None
    assert Elements.of([EXEMPLAR], [np.zeros(EXEMPLAR.shape[:2], bool)]) is None


def test_unusable_pixels_are_no_element() -> None:
    usable = np.ones(EXEMPLAR.shape[:2], bool)
    usable[:, 96:] = False
    marred = EXEMPLAR.copy()
    marred[:, 96:] = blobs(192, 96, 4)
    half, other = (Elements.of([p], [usable]) for p in (EXEMPLAR, marred))
    assert half is not None
    assert other is not None
    assert (half.known == other.known).all()
