"""The least distance of repeats: what it forbids, what it costs, and that it can be cancelled."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from naive import least_return
from patches.naive_repeats import permitted

import intarsia as ia
from intarsia.analysis.features import features
from intarsia.foundation.geometry import spread
from intarsia.model import Exemplar
from intarsia.patches.repetition import Repetition
from intarsia.search import Candidates, WindowGrid, isometry_ids, posed_exemplars
from intarsia.search.fourier import PatchSearch
from intarsia.testing import texture


@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize("toroidal", [False, True])
@pytest.mark.parametrize("isometries", ["none", "90", "both"])
@pytest.mark.parametrize("patch", [(6, 6), (5, 9)])
def test_what_is_forbidden_is_what_every_pair_says(
    patch: tuple[int, int], isometries: str, toroidal: bool, wrap: bool
) -> None:
    """The rectangles painted are those in which a patch would show a pixel again within the distance."""
    pixels = texture(20, 17, 1)
    usable = None if toroidal else np.arange(17) > np.zeros((20, 1))
    e = Exemplar.of(pixels, usable=usable, toroidal=toroidal)
    square = max(patch) if isometries != "none" else None
    patch = (square, square) if square else patch
    laid_out = posed_exemplars([e], features([e]), isometry_ids(isometries), patch)
    rows, columns = (spread(n, p, 2, wrap)[0] for n, p in zip((40, 44), patch, strict=True))
    layout = WindowGrid(tuple(rows), tuple(columns), patch, (40, 44), (wrap, wrap))
    rng = np.random.default_rng(sum(patch))
    for distance in (1, 5, 14, 60):
        control = Repetition(PatchSearch(laid_out, patch, 2), layout, 0.05, distance)
        for _ in range(5):
            row, column = int(rng.integers(len(rows))), int(rng.integers(len(columns)))
            v = int(rng.integers(len(laid_out)))
            u, s = rng.integers(0, laid_out.valid[v].shape).tolist()
            control.add(row, column, (v, u, s))
        row, column = len(rows) // 2, len(columns) // 2
        truth = permitted(control, row, column, control._around(row, column))
        found = control.permitted(row, column)
        np.testing.assert_array_equal(found, np.concatenate([t.ravel() for t in truth]))


def test_the_least_distance_is_kept_by_every_search(monkeypatch) -> None:
    """By the pyramid and the exact search, too, also where most windows must be searched again."""
    monkeypatch.setattr("intarsia.patches.repetition.LITTLE", 0)
    e = Exemplar.of(texture(70, 66, 3))
    fast, coarse = ia.ImageQuilting(patch=12, overlap=4), ia.PatchSampling(patch=4, overlap=4, pyramid="mean")
    for one, farthest in ((fast, 30), (replace(fast, search="exact"), 30), (coarse, 24)):
        for distance, isometries in ((20, "none"), (farthest, "180")):
            method = replace(one, min_repeat_distance=distance, isometries=isometries)
            out = ia.synthesize(e, 72, method, seed=3, run=ia.Run(1)).map
            assert least_return(out) >= distance


def test_the_exact_search_among_what_is_left_finds_the_best(monkeypatch) -> None:
    monkeypatch.setattr("intarsia.patches.repetition.LITTLE", 0)
    e = Exemplar.of(texture(50, 46, 3, 2))
    laid_out = posed_exemplars([e], features([e]), (0, 6), (10, 10))
    rows = tuple(spread(60, 10, 3, False)[0])
    layout = WindowGrid(rows, rows, (10, 10), (60, 60), (False, False))
    search = PatchSearch(laid_out, (10, 10), 3, True)
    control = Repetition(search, layout, 0.0, 25)
    rng = np.random.default_rng(4)
    for row, column in ((2, 2), (2, 3), (3, 2), (3, 4)):
        control.add(row, column, (int(rng.integers(2)), int(rng.integers(41)), int(rng.integers(37))))
    feats = rng.integers(0, 1024, (10, 10, 3)).astype(np.int16)
    known = np.ones((10, 10), np.uint8)
    empty = Candidates(np.empty((0, 4), np.int64), 1000, feats, known)
    best = control.allowed(3, 3, empty, laid_out.valid, lambda: None)
    every = control._table.rows(control.permitted(3, 3))
    least = min(
        int(((laid_out.picture(v)[u : u + 10, s : s + 10].astype(int) - feats) ** 2).sum())
        for _, v, u, s in every.tolist()
    )
    assert best.rows[0, 0] == least


def test_a_least_distance_can_be_cancelled_between_the_windows_of_a_wave(monkeypatch) -> None:
    """A wave of windows may take long: each asks whether to stop, and after a stop none but the one at work goes on."""
    cancel, searched = threading.Event(), []
    allowed = Repetition.allowed

    def counted(self: Repetition, *given: Any) -> Any:
        searched.append(cancel.is_set())
        if len(searched) == 5:
            cancel.set()
        return allowed(self, *given)

    monkeypatch.setattr(Repetition, "allowed", counted)
    method = ia.ImageQuilting(patch=32, min_repeat_distance=100, isometries="both")
    with pytest.raises(ia.CancelledError):
        ia.synthesize("sample:stones", 1024, method, seed=1, run=ia.Run(1, cancel=cancel))
    assert len(searched) >= 5
    assert sum(searched) <= 1
