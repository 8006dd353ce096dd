"""What a canvas holds is continued by its lattice: blocks in phase, fitted to it, cut against it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import intarsia as ia
from intarsia.foundation.geometry import Wrap
from intarsia.foundation.run import draw
from intarsia.model.canvas import Canvas
from intarsia.patches import Continuation, depth_of
from intarsia.tasks.completion import Margins, extension
from intarsia.testing.cases import noise

LATTICE = ((24.0, 0.0), (6.0, 20.0))
METHOD = ia.NearRegular(lattice=LATTICE)


def pattern(height: int, width: int, y0: int = 0, x0: int = 0) -> NDArray[np.uint8]:
    """A window of an endless pattern that repeats exactly by LATTICE."""
    y, x = np.mgrid[y0 : y0 + height, x0 : x0 + width]
    down = y // 20
    v, u = y - 20 * down, (x - 6 * down) % 24
    return ((noise(20, 24, 3) >> np.uint64(56)).astype(np.uint8))[v, u]


def spoiled(pixels: NDArray[np.uint8], seed: int = 1) -> NDArray[np.uint8]:
    """Every pixel a little brighter or darker, so that no two periods are equal."""
    grain = (noise(*pixels.shape, seed) % np.uint64(17)).astype(int) - 8
    return np.clip(pixels.astype(int) + grain, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("sides", [(37, 0, 0, 0), (0, 51, 0, 0), (0, 0, 29, 0), (41, 53, 27, 65)])
def test_an_exact_pattern_goes_on_exactly(sides: tuple[int, int, int, int]) -> None:
    left, right, top, bottom = sides
    made = ia.extend(pattern(110, 130), Margins(left, right, top, bottom), METHOD, seed=2)
    wanted = pattern(110 + top + bottom, 130 + left + right, -top, -left)
    assert (np.asarray(made.render()) == wanted).all()


@pytest.mark.parametrize("border", [6, 14])
def test_what_is_given_stays_deeper_than_the_border(border: int) -> None:
    pixels = spoiled(pattern(110, 130))
    method = ia.NearRegular(lattice=LATTICE, border=border)
    out = np.asarray(ia.extend(pixels, Margins(40, 40, 40, 40), method).render())
    inside = out[40:150, 40:170]
    assert (inside[border:-border, border:-border] == pixels[border:-border, border:-border]).all()
    assert (inside != pixels).any()  # the seam is cut within the border, not along it


def test_a_spoiled_pattern_goes_on_in_phase() -> None:
    pixels = spoiled(pattern(110, 130))
    out = np.asarray(ia.extend(pixels, Margins(61, 47, 33, 59), METHOD, seed=4).render()).astype(int)
    wanted = pattern(110 + 92, 130 + 108, -33, -61).astype(int)
    assert np.abs(out - wanted).max() <= 8


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


def test_the_piece_of_most_pixels_is_continued() -> None:
    e = ia.Exemplar.of(pattern(60, 70))
    scene = extension(e, Margins(left=10, top=4))
    held = Continuation.of(scene.canvas, 5)
    assert held.anchor == (-4, -10)
    depth = depth_of(~scene.canvas.start.holes, Wrap.NONE, 5)  # type: ignore[union-attr]
    assert (held.band == ((depth > 0) & (depth <= 5))).all()
    assert Continuation.of(Canvas(20, 20), 5) is None


def test_holes_are_filled_and_nothing_else_changes() -> None:
    pixels = spoiled(pattern(150, 170))
    hole = np.zeros(pixels.shape, bool)
    hole[50:81, 60:104] = True
    made = np.asarray(ia.heal(pixels, hole, METHOD, seed=int(draw(1, 2, 3, 4, 5) % 100)).render())
    assert (made[~hole] == pixels[~hole]).all()
    assert np.abs(made.astype(int) - pattern(150, 170).astype(int))[hole].max() <= 8


def test_a_start_of_holes_alone_is_no_start() -> None:
    pixels = spoiled(pattern(110, 130))
    e = ia.Exemplar.of(pixels)
    empty = ia.SourceMap(np.zeros((90, 95, 2), np.int32), np.full((90, 95), 255, np.uint8), None, (e.source,))
    one, two = ia.synthesize(e, (90, 95), METHOD, seed=3), ia.synthesize(e, None, METHOD, seed=3, start=empty)
    assert (one.map.yx == two.map.yx).all()


def test_wicker_goes_on_without_a_border(textures: dict[str, Path]) -> None:
    """Neighbours across the border of the picture differ no more than neighbours within it."""
    exemplar = ia.read(textures["near-regular_wicker_192"])
    made = ia.extend(exemplar, Margins(200, 200, 200, 200), ia.Auto())
    assert made.method.slug == "near-regular"
    out, old = np.asarray(made.render()).astype(int), np.asarray(exemplar.base).astype(int)
    assert (out[214:378, 214:378] == old[14:-14, 14:-14]).all()
    for new, own in ((out, old), (out.swapaxes(0, 1), old.swapaxes(0, 1))):
        steps, usual = (np.abs(np.diff(a, axis=0)).mean(axis=(1, 2)) for a in (new[:, 200:392], own))
        assert max(steps[185:214].max(), steps[377:406].max()) <= usual.max() * 1.1
