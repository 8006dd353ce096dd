"""Efros-Leung against a plain version of itself, and what else it promises."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from published.pixels.naive_pixels import NaiveEfrosLeung

import intarsia as ia
from intarsia.model import Exemplar
from intarsia.model.sourcemap import HOLE, identity
from intarsia.published.pixels.efros_leung_engine import _taps

RNG = np.random.default_rng(5)
GRAY = RNG.integers(0, 256, (14, 16), dtype=np.uint8)
COLOUR = RNG.integers(0, 256, (13, 12, 3), dtype=np.uint8)
TWO = RNG.integers(0, 2, (14, 15), dtype=np.uint8) * 255
USABLE = np.ones((14, 16), bool)
USABLE[3, 5] = USABLE[:, 15] = False


def shown(out: ia.Synthesis) -> dict[tuple[int, int], tuple[int, ...]]:
    """Every pixel's (exemplar, pose, row, column)."""
    m = out.map
    which = np.zeros((m.height, m.width), int) if m.which is None else m.which
    pose = np.zeros((m.height, m.width), int) if m.pose is None else m.pose
    return {(y, x): (int(which[y, x]), int(pose[y, x]), *m.yx[y, x].tolist()) for y, x in np.ndindex(which.shape)}


CASES: dict[str, dict[str, Any]] = {
    "gray": {"exemplars": [Exemplar.of(GRAY)], "window": 5},
    "wrapped": {"exemplars": [Exemplar.of(GRAY)], "window": 5, "wrap": "both"},
    "wrapped along x": {"exemplars": [Exemplar.of(GRAY)], "window": (3, 7), "wrap": "x"},
    "colour": {"exemplars": [Exemplar.of(COLOUR)], "window": 5, "wrap": "y"},
    "two values": {"exemplars": [Exemplar.of(TWO)], "window": 3, "wrap": "both"},
    "masked": {"exemplars": [Exemplar.of(GRAY, usable=USABLE)], "window": (5, 3)},
    "toroidal": {"exemplars": [Exemplar.of(GRAY, usable=USABLE, toroidal=True)], "window": 5},
    "several": {"exemplars": [Exemplar.of(COLOUR), Exemplar.of(COLOUR[::-1].copy(), toroidal=True)], "window": 3},
    "turned": {"exemplars": [Exemplar.of(GRAY)], "window": 5, "isometries": (0, 3, 6), "tolerance": 0.5},
    "tiny": {"exemplars": [Exemplar.of(GRAY)], "window": 7, "wrap": "both", "size": (2, 3)},
    "one pixel": {"exemplars": [Exemplar.of(GRAY)], "window": 3, "size": (1, 1)},
}


@pytest.mark.parametrize("name", CASES)
def test_it_draws_what_the_plain_version_draws(name: str, thorough: bool) -> None:
    """Multrus 2003, 2.2: every pixel of the map is the same."""
    case = {"size": (9, 11), "isometries": (0,), "tolerance": 0.1, "wrap": "none"} | CASES[name]
    for seed in (0, 77) if thorough else (77,):
        method = ia.EfrosLeung(window=case["window"], tolerance=case["tolerance"], isometries=case["isometries"])
        out = ia.synthesize(case["exemplars"], case["size"], method, seed=seed, wrap=case["wrap"])
        window = case["window"] if isinstance(case["window"], tuple) else (case["window"],) * 2
        plain = NaiveEfrosLeung(
            case["exemplars"], case["size"], window, seed, ia.Wrap(case["wrap"]), case["isometries"], case["tolerance"]
        )
        expected = {at: pixel_of(plain, *p) for at, p in plain.run().items()}
        assert shown(out) == expected


def pixel_of(plain: NaiveEfrosLeung, v: int, y: int, x: int) -> tuple[int, ...]:
    one = plain.variants[v]
    return (one.number, one.isometry, *one.pixel(y, x))


def test_weights_fall_off_as_a_gaussian() -> None:
    """Sigma is the window over 6.4; the heaviest come first, and what weighs nothing is left out."""
    taps = _taps((11, 11))
    weights = {(y, x): w for y, x, w in taps}
    assert weights[0, 1] == weights[1, 0] == round(4096 * np.exp(-0.5 * (6.4 / 11) ** 2))
    assert [w for _, _, w in taps] == sorted((w for _, _, w in taps), reverse=True)
    assert min(weights.values()) > 0


def test_a_start_stays_and_is_continued() -> None:
    """A stripe picture with its right part missing is continued without a break (law 7: the rim is 0)."""
    stripes = np.repeat((np.arange(30) // 3 % 2 * 255).astype(np.uint8)[:, None], 30, axis=1)
    e = Exemplar.of(stripes)
    start = identity([e.source], 0)
    which = np.array(start.which)
    which[:, 14:] = HOLE
    hole = ia.SourceMap(np.where((which == HOLE)[:, :, None], 0, start.yx), which, sources=start.sources)
    out = ia.synthesize(e, None, ia.EfrosLeung(window=9), start=hole)
    assert (out.map.yx[:, :14] == start.yx[:, :14]).all()
    assert (out.render().pixels == stripes)[4:-4].all()


def test_windows_without_a_middle_or_room_are_refused() -> None:
    with pytest.raises(ia.ParameterError, match="odd"):
        ia.EfrosLeung(window=8)
    with pytest.raises(ia.ParameterError, match="larger exemplar"):
        ia.synthesize(GRAY, 20, ia.EfrosLeung(window=17))
    speckled = Exemplar.of(np.zeros((20, 20), np.uint8), usable=np.indices((20, 20)).sum(axis=0) % 4 > 0)
    with pytest.raises(ia.MethodError, match="masked"):
        ia.synthesize(speckled, 20, ia.EfrosLeung(window=9))


def test_the_automatic_window_shrinks_until_it_finds_room() -> None:
    out = ia.synthesize(GRAY, 8, ia.EfrosLeung())
    assert isinstance(out.method, ia.EfrosLeung)
    assert out.method.window in range(3, 15, 2)
