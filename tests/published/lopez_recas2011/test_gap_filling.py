"""Random sampling and gap filling: the method of Lopez Recas 2011, whose sections are named, and its promises."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from analysis.naive_correlation import gncc
from hypothesis import given, settings
from hypothesis import strategies as st
from published.lopez_recas2011 import naive_gap_filling as naive_rsgf

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.lattice.correlation_peaks import lattice_points
from intarsia.model import Exemplar
from intarsia.model.canvas import Canvas
from intarsia.published.lopez_recas2011.engine import FourierMatcher, mitred_border
from intarsia.testing import texture

PLAIN = ia.GapFilling(lattice=((9.5, 0.25), (-2.25, 7.75)), block=8, border=4, lattice_tolerance=1)


def changed(**parameters: object) -> ia.GapFilling:
    return replace(PLAIN, **parameters)


@pytest.mark.parametrize("fit", ["difference", "correlation"])
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("anywhere", [False, True])
def test_it_is_the_method_of_the_source(fit: str, channels: int, anywhere: bool) -> None:
    """Sections 4.2.1 and 4.2.2, pixel for pixel; 5.2: with vectors 1,0 0,1, too."""
    shape, size = ((25, 27), (20, 19)) if anywhere else ((31, 34), (37, 41))
    e = Exemplar.of(texture(*shape, channels, 5))
    method = changed(fit=fit, **({"lattice": ((1, 0), (0, 1)), "lattice_tolerance": 2} if anywhere else {}))
    vectors = [(round(y * 256), round(x * 256)) for x, y in method.lattice]
    picture = features([e], None).pictures[0]
    want = naive_rsgf.synthesized(picture, *vectors, 8, 4, method.lattice_tolerance, size, 11, fit)
    np.testing.assert_array_equal(ia.synthesize(e, size, method, seed=11).map.yx, want)


@given(st.integers(0, 9999))
@settings(max_examples=60)
def test_points_of_a_lattice_are_all_found(seed: int) -> None:
    rng = np.random.default_rng(seed)
    v1, v2 = rng.integers(-2500, 2500, (2, 2))
    if abs(int(v1[0] * v2[1] - v1[1] * v2[0])) < 256 * 256 * 4 or min(np.hypot(*v1), np.hypot(*v2)) < 700:
        return
    first, low, high = rng.integers(-3000, 9000, 2), rng.integers(-5, 5, 2), rng.integers(5, 40, 2)
    exact = lattice_points(first, v1, v2, low, high)
    found = (exact + 128) // 256
    reduced = {(y, x) for y, x, _, _ in naive_rsgf.lattice_places(first, v1, v2, low, high)}
    assert reduced <= {(int(y), int(x)) for y, x in found}  # the naive one looks at 121 x 121 multiples only
    assert (found >= low).all()
    assert (found <= high).all()
    times = (exact - first) @ np.linalg.inv(np.array([v1, v2], float))
    np.testing.assert_allclose(times, np.rint(times), atol=1e-6)


@pytest.mark.parametrize(("block", "border"), [(8, 4), (9, 2), (5, 4), (4, 4)])
def test_wedges_meet_in_mitres_and_do_not_overlap(block: int, border: int) -> None:
    """Section 4.2.2: together they are the whole border, each pixel once; sides are mirrored but for the diagonals."""
    ring = mitred_border(block, border)
    want = [(*at, naive_rsgf.side_of(*at, block, border)) for at in np.ndindex(block + border, block + border)]
    assert [tuple(r) for r in ring.tolist()] == [w for w in want if w[2] is not None]
    assert len(ring) == (block + border) ** 2 - max(0, block - border) ** 2


@pytest.mark.parametrize("correlate", [False, True])
def test_borders_are_compared_as_by_gncc_with_a_hole(correlate: bool) -> None:
    """Section 4.2.2: the best place is that of the GNCC, or of the squared differences, of a template with a hole."""
    picture = texture(40, 44, 3, 8).astype(np.int16)
    ring = mitred_border(11, 4)
    hole = np.zeros((15, 15), bool)
    hole[ring[:, 0], ring[:, 1]] = True
    other = texture(15, 15, 3, 9).astype(np.int16)
    border = other[ring[:, 0], ring[:, 1]].T.astype(np.int64)
    places = np.argwhere(np.ones((26, 30)))
    windows = np.lib.stride_tricks.sliding_window_view(picture.astype(np.int64), (15, 15), (0, 1))
    if correlate:
        want = gncc(picture, other, None, hole)[14:40, 14:44].argmax()
    else:
        want = ((windows - np.moveaxis(other, 2, 0))[..., hole] ** 2).sum(axis=(-1, -2)).argmin()
    made = FourierMatcher(picture, ring)
    assert made.best(border, places, correlate) == want
    np.testing.assert_array_equal(np.moveaxis(made.sums, 0, 2), windows[..., hole].sum(axis=-1))
    np.testing.assert_array_equal(np.moveaxis(made.squares, 0, 2), (windows[..., hole] ** 2).sum(axis=-1))


@pytest.mark.parametrize("correlate", [False, True])
@pytest.mark.parametrize("colour", [0, 3, 40])
def test_of_equally_good_places_the_first_is_found(correlate: bool, colour: int, thorough: bool) -> None:
    """By transforms as one by one: what rounding errors are left decides nothing."""
    shades = np.tile(texture(17, 18, 1, 3).astype(np.int16), (3, 3, 1))  # each border is there twice or more
    tint = np.tile(texture(17, 18, 3, 4).astype(np.int16), (3, 3, 1)) % (colour + 1)
    picture = shades * np.array((3, 5, 2), np.int16) + tint
    ring = mitred_border(11, 4)
    places = np.argwhere(np.ones((51 - 14, 54 - 14)))
    made = FourierMatcher(picture, ring)
    for n in range(12) if thorough else (1, 2, 5, 11):
        y, x = 2 * n, (7 * n) % 23
        noise = texture(15, 15, 3, n).astype(np.int16) % (1 if n < 4 else 40)
        border = (picture[y : y + 15, x : x + 15] + noise)[ring[:, 0], ring[:, 1]]
        there = [picture[ring[:, 0] + py, ring[:, 1] + px] for py, px in places]
        fits = [-naive_rsgf.correlation(t, border) if correlate else naive_rsgf.difference(t, border) for t in there]
        assert fits.count(min(fits)) >= 2
        assert made.best(border.T.astype(np.int64), places, correlate) == fits.index(min(fits))


def test_defaults_of_the_source() -> None:
    """Section 5.2."""
    e = Exemplar.of(texture(128, 128, 3, 1))
    method = ia.GapFilling(lattice=((20, 0), (0, 20))).resolved([e], Canvas(256, 256))
    assert (method.block, method.border, method.lattice_tolerance, method.blend.feather) == (40, 10, 3, 4)
    assert ia.NearRegular(lattice=((20, 0), (0, 20))).resolved([e], Canvas(9, 9)).border == 14


def test_the_error_between_neighbours_does_not_grow() -> None:
    """Section 4.2: the mean step across block edges is the same near the first and the last block."""
    e = Exemplar.of(texture(60, 64, 1, 6))
    out = ia.synthesize(e, (40, 1600), changed(), seed=5).render(feather=0).pixels.astype(int)
    step = np.abs(np.diff(out.reshape(40, 1600), axis=1))[:, 7::8]
    assert step[:, 150:].mean() < 1.15 * step[:, :50].mean()


@pytest.mark.parametrize(
    ("parameters", "size", "message"),
    [
        ({"border": 5}, 30, "border=5: gap-filling needs an even border"),
        ({"border": 10}, 30, "border=10: gap-filling needs an even border that is no wider than a block"),
        ({"lattice": ((0, 9),)}, 30, "gap-filling needs two lattice vectors"),
        ({"block": 30}, 60, "no patch of 30x30 px with a border of 4 px fits"),
    ],
)
def test_what_cannot_work_is_refused(parameters: dict, size: object, message: str) -> None:
    with pytest.raises((ia.ParameterError, ia.MethodError), match=message) as caught:
        ia.synthesize(texture(36, 36), size, changed(**parameters))
    assert "\n" not in str(caught.value)
