"""The depth of known pixels, and what goes on by a lattice."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import intarsia as ia
from intarsia.foundation.geometry import Wrap
from intarsia.patches import depth_of
from intarsia.tasks.completion import Margins
from intarsia.testing.cases import noise


def test_a_slow_and_obvious_depth_agrees() -> None:
    for k in range(6):
        known = noise(9, 11, k) % np.uint64(7) > 0
        holes = np.argwhere(~known)
        for wrap in Wrap:
            wanted = np.zeros(known.shape, int)
            for y, x in np.argwhere(known):
                dy, dx = np.abs(holes - (y, x)).T
                dy = np.minimum(dy, 9 - dy) if wrap.y else dy
                dx = np.minimum(dx, 11 - dx) if wrap.x else dx
                wanted[y, x] = np.maximum(dy, dx).min()
            assert (depth_of(known, wrap, 11) == wanted).all()
    assert (depth_of(np.ones((3, 4), bool), Wrap.NONE, 5) > 5).all()


def test_wicker_goes_on_without_a_border(textures: dict[str, Path]) -> None:
    """Neighbours across the border of the picture differ no more than neighbours within it."""
    exemplar = ia.read(textures["near-regular_wicker_192"])
    made = ia.extend(exemplar, Margins(200, 200, 200, 200), ia.Auto())
    assert made.method.slug == "graphcut"
    assert made.method.lattice is not None
    rim = made.method.overlap
    out, old = np.asarray(made.render()).astype(int), np.asarray(exemplar.base).astype(int)
    assert (out[200 + rim : 392 - rim, 200 + rim : 392 - rim] == old[rim:-rim, rim:-rim]).all()
    for new, own in ((out, old), (out.swapaxes(0, 1), old.swapaxes(0, 1))):
        steps, usual = (np.abs(np.diff(a, axis=0)).mean(axis=(1, 2)) for a in (new[:, 200:392], own))
        assert max(steps[185:214].max(), steps[377:406].max()) <= usual.max() * 1.1
