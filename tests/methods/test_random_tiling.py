"""Random tiling: the baseline of Robinson 2004, patches side by side and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from naive import unbroken

import intarsia as ia
from intarsia.foundation.geometry import spread
from intarsia.model import Exemplar
from intarsia.testing import texture


def test_every_cell_is_one_patch() -> None:
    """Robinson 2004: whole patches at multiples of their size, from anywhere in the exemplar."""
    e = Exemplar.of(texture(40, 30, 3))
    out = ia.synthesize(e, (36, 48), ia.RandomTiling(patch=12), seed=3).map
    corners = []
    for y, x in np.ndindex(3, 4):
        block = out.yx[12 * y : 12 * y + 12, 12 * x : 12 * x + 12]
        np.testing.assert_array_equal(block - block[0, 0], np.stack(np.mgrid[:12, :12], axis=2))
        corners.append(tuple(block[0, 0].tolist()))
    assert len(set(corners)) > 9


@pytest.mark.parametrize("wrap", ["none", "both"])
def test_uneven_sizes_lay_later_patches_over_earlier_ones(wrap: str) -> None:
    """Robinson 2004: nothing is cropped at the border; only the lines between patches are broken."""
    out = ia.synthesize(Exemplar.of(texture(40, 40)), (33, 50), ia.RandomTiling(patch=(8, 12)), wrap=wrap).map
    for axis, (length, patch) in enumerate(((33, 8), (50, 12))):
        starts, size = spread(length, patch, 0, wrap == "both")
        lines = set(np.flatnonzero((~unbroken(out, axis)).any(axis=1 - axis)).tolist())
        borders = {(s - 1) % length for s in starts} | {(s + size - 1) % length for s in starts}
        assert lines <= borders


def test_all_patches_are_equally_likely() -> None:
    """The first corner is spread evenly over the exemplar, and over two exemplars by their size."""
    one, two = Exemplar.of(texture(20, 20, 3)), Exemplar.of(texture(38, 20, 3, 1))
    out = ia.synthesize([one, two], (200, 400), ia.RandomTiling(patch=8)).map
    which, yx = out.which[::8, ::8].ravel(), out.yx[::8, ::8].reshape(-1, 2)
    assert which.mean() == pytest.approx(31 / (31 + 13), abs=0.05)
    assert yx[which == 0, 0].mean() == pytest.approx(6, abs=0.8)
    assert set(yx[which == 0, 1].tolist()) == set(range(13))


def test_it_looks_at_no_pixel() -> None:
    """Two pictures of one size give the same map: nothing is matched."""
    maps = [ia.synthesize(Exemplar.of(texture(30, 30, 3, k)), 50, ia.RandomTiling(patch=10)).map for k in (1, 2)]
    assert maps[0].digest == maps[1].digest


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"patch": 31}, r"^patch=31 is larger than the exemplar \(30 x 40 px\); choose at most 30"),
        ({"patch": (6, 8), "isometries": "90"}, "^patch=8x6 is not square"), ({"patch": 0}, "^patch=0 is not allowed"),
    ],
)  # fmt: skip
def test_what_cannot_work_is_refused(parameters: dict, message: str) -> None:
    with pytest.raises(ia.ParameterError, match=message):
        ia.synthesize(Exemplar.of(texture(40, 30, 3)), 50, ia.RandomTiling(**parameters))
