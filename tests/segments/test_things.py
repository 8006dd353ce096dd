"""Things are what strikes: found where they were planted, few, and the same for every view of an exemplar."""

from __future__ import annotations

import numpy as np

from intarsia.exemplar import Exemplar
from intarsia.segments.wholes import BOUNDS, things
from intarsia.testing import texture


def grain(height: int = 160, width: int = 150, seed: int = 3) -> np.ndarray:
    return np.asarray(texture(height, width, 3, seed) // 3 + 60, np.uint8)


def test_planted_things_are_found() -> None:
    """Two blots of another colour: each is one thing, about where it was planted, the larger one first."""
    pixels = grain()
    pixels[20:30, 10:24] = (240, 40, 20)
    pixels[60:67, 60:68] = (20, 30, 240)
    found = things(Exemplar.of(pixels))
    assert found.labels.shape == (160, 150)
    assert set(found.labels[22:28, 12:22].ravel()) == {1}
    assert set(found.labels[62:65, 62:66].ravel()) == {2}
    assert found.areas.tolist() == [int((found.labels == k + 1).sum()) for k in range(len(found.areas))]


def test_things_are_few_and_compact() -> None:
    """At most a tenth of the pixels; nothing that reaches over a quarter of the side; nothing of one colour strikes."""
    pixels = grain()
    pixels[:, 40:44] = 255  # a line all across
    found = things(Exemplar.of(pixels))
    assert not found.labels[10:150, 41:43].any()
    rng = np.random.default_rng(1)
    for y, x in rng.integers(0, 84, (14, 2)).tolist():
        pixels[y : y + 9, x : x + 9] = rng.integers(0, 256, 3)
    found = things(Exemplar.of(pixels))
    assert (found.labels > 0).mean() <= BOUNDS.share / 100
    assert len(things(Exemplar.of(np.full((64, 64, 3), 90, np.uint8))).areas) == 0
    start = Exemplar.of(pixels, usable=np.zeros((160, 150), bool))  # the picture under a start, of which nothing is cut
    assert len(things(start).areas) == 0


def test_a_thing_over_the_border_of_a_torus_is_one() -> None:
    pixels = grain(160, 160)
    blot = np.zeros((160, 160), bool)
    blot[:10, :10] = True
    blot = np.roll(blot, (-5, -5), (0, 1))
    pixels[blot] = (240, 40, 20)
    found = things(Exemplar.of(pixels, toroidal=True))
    assert set(found.labels[np.ix_((-3, 0, 3), (-3, 0, 3))].ravel()) == {1}
    assert len(things(Exemplar.of(pixels)).areas) != len(found.areas) or (found.labels == 1).sum() > 60
