"""Periods: which moves keep them, what an output loses of them, and that whole tiles may be dealt anew."""

from __future__ import annotations

import numpy as np
import pytest
from judging.naive_parts import off_lattice, unlike_itself
from judging.naive_windows import blobs
from numpy.typing import NDArray

import intarsia as ia
from intarsia.judging.parts import measured, sources_of
from intarsia.judging.sources import Periods, Reference

SQUARE = Periods(((24 * 256, 0), (0, 32 * 256)), 128)
SLANTED = Periods(((20 * 256 + 77, 5 * 256), (-3 * 256, 28 * 256 - 31)), 0)
ROWS = Periods(((21 * 256 + 100, 4 * 256),), 64)


@pytest.mark.parametrize("periods", [SQUARE, SLANTED, ROWS])
@pytest.mark.parametrize("slack", [2, 3])
def test_moves_that_keep_the_periods(periods: Periods, slack: int) -> None:
    moves = np.stack(np.meshgrid(np.arange(-70, 71, 5), np.arange(-90, 91, 7), indexing="ij"), axis=2)
    kept = periods.kept(moves, slack)
    vectors = [(y / 256, x / 256) for y, x in periods.vectors]
    shorter = min(np.hypot(*v) for v in vectors)
    within = min(slack + periods.loose / 256, shorter / 3)
    for place in np.ndindex(kept.shape):
        off = off_lattice(tuple(float(n) for n in moves[place]), vectors)
        if abs(off - within) > 0.05:  # vectors that are neither short nor square are rounded along them
            assert kept[place] == (off < within), moves[place]
    assert kept.any()
    assert not kept.all()


def test_short_periods_are_not_told_apart() -> None:
    assert not Periods(((4 * 256, 0), (0, 4 * 256)), 0).kept(np.zeros((3, 2)), 3).any()


def wall(tiles: list[NDArray[np.int16]], rows: int, columns: int, first: int = 0) -> NDArray[np.int16]:
    """Tiles with one frame and each its own face, laid in an order that begins somewhere."""
    order = [[(first + 5 * r * r + 3 * c + c * r) % len(tiles) for c in range(columns)] for r in range(rows)]
    return np.vstack([np.hstack([tiles[k] for k in row]) for row in order])


def tiles() -> list[NDArray[np.int16]]:
    """Eight tiles of 32 px: a dark frame around a face of one tone."""
    out = []
    for k in range(8):
        face = np.full((32, 32, 3), 300 + 60 * k, np.int16) + blobs(32, 32, 40 + k) // 16
        face[:3] = face[:, :3] = 40
        out.append(face.astype(np.int16))
    return out


def test_whole_tiles_dealt_anew_cost_nothing() -> None:
    """Each beside another than in the exemplar: the periods are kept. Slipped by half a tile they are not."""
    exemplar, dealt = wall(tiles(), 6, 6), wall(tiles(), 8, 8, 3)
    slipped = np.vstack([np.roll(dealt[32 * r : 32 * r + 32], 16 * (r % 2), 1) for r in range(8)])
    reference = Reference((exemplar,), (None,))
    assert reference.periods is not None
    kept, lost = (measured(reference, p, sources_of(reference, p)) for p in (dealt, slipped))
    assert kept["joins"] < lost["joins"] / 4
    assert lost["lattice"] > kept["lattice"] + 10


def test_what_is_lost_is_that_of_plain_loops() -> None:
    exemplar, output = wall(tiles(), 2, 2)[::2, ::2], blobs(40, 44, 7)
    periods = Periods(((16 * 256, 0), (40, 16 * 256 + 90)), 0)
    shifts = [(16, 0), (0, 16), (16, 16), (16, -16)]
    assert sorted(periods.shifts) == sorted(shifts)
    apart = [unlike_itself(output, s) - unlike_itself(exemplar, s) for s in shifts]
    assert periods.lost(output, exemplar, None) == pytest.approx(100 * np.mean(apart))


def test_unusable_pixels_say_nothing_of_periods() -> None:
    exemplar = wall(tiles(), 4, 4)
    usable = np.ones(exemplar.shape[:2], bool)
    usable[:32] = False
    marred = exemplar.copy()
    marred[:32] = 1000
    periods = Periods(((32 * 256, 0), (0, 32 * 256)), 0)
    assert periods.lost(exemplar, marred, usable) == pytest.approx(periods.lost(exemplar, exemplar[32:], None))


def test_without_a_lattice_nothing_is_lost() -> None:
    still = ia.score((blobs(128, 128, 1) // 4).astype(np.uint8), np.full((128, 128, 3), 90, np.uint8))
    free = np.random.default_rng(3).integers(0, 255, (96, 96, 3)).astype(np.int16)
    assert Reference((free, free), (None, None)).periods is None
    assert Reference((free,), (None,)).periods is None
    assert ia.score(free.astype(np.uint8), free[::-1].astype(np.uint8)).parts["lattice"].normalised == 1
    assert still.parts["blurred"].normalised == 0
