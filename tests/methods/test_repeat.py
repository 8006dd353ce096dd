"""Plain repetition: positions modulo the exemplar."""

from __future__ import annotations

import numpy as np
import pytest

import intarsia as ia
from intarsia.testing import texture


@pytest.mark.parametrize("size", [(1, 1), (7, 90), (40, 26), (20, 13), (5, 5)])
def test_it_is_numpys_tile(size: tuple[int, int]) -> None:
    pixels = texture(20, 13, 3)
    out = ia.synthesize(pixels, size, ia.Repeat()).render().pixels
    np.testing.assert_array_equal(out, np.tile(pixels, (90, 90, 1))[: size[0], : size[1]])
