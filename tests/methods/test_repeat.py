"""Plain repetition: positions modulo the exemplar."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import intarsia as ia
from intarsia.model import Exemplar
from intarsia.model.sourcemap import HOLE, identity
from intarsia.testing import texture


@pytest.mark.parametrize("size", [(1, 1), (7, 90), (40, 26), (20, 13), (5, 5)])
def test_it_is_numpys_tile(size: tuple[int, int]) -> None:
    pixels = texture(20, 13, 3)
    out = ia.synthesize(pixels, size, ia.Repeat()).render().pixels
    np.testing.assert_array_equal(out, np.tile(pixels, (90, 90, 1))[: size[0], : size[1]])


def test_holes_of_a_start_are_repeated_into() -> None:
    """Law 7 with a rim of 0: known pixels stay, mirrored ones too; holes show what repetition has there."""
    e = Exemplar.of(texture(20, 13, 3))
    start = identity([e.source], 0)
    which, pose, yx = np.array(start.which), np.zeros((20, 13), np.uint8), np.array(start.yx)
    which[5:9] = HOLE
    pose[:5] = 1
    yx[:5, :, 1] = 12 - yx[:5, :, 1]
    out = ia.synthesize(e, None, ia.Repeat(), start=replace(start, which=which, pose=pose, yx=yx)).map
    np.testing.assert_array_equal(out.yx[:5], yx[:5])
    np.testing.assert_array_equal(out.yx[5:], start.yx[5:])
    assert (out.pose[:5] == 1).all()
    assert not out.pose[5:].any()
