"""How plainly steps are seen: most where nothing changes, least in grain; what is masked says nothing."""

from __future__ import annotations

import numpy as np
import pytest
from analysis import naive_masking

from intarsia.analysis.contrast_masking import FULL, MOST, visibility
from intarsia.analysis.features import features
from intarsia.model import Exemplar
from intarsia.testing import noise, texture

KNEE = 120


def picture(height: int = 21, width: int = 18, seed: int = 3) -> np.ndarray:
    return features([Exemplar.of(texture(height, width, 3, seed))]).pictures[0]


def holes(height: int = 21, width: int = 18) -> np.ndarray:
    usable = np.ones((height, width), bool)
    usable[4:9, 10:] = usable[15, 3] = usable[:, 0] = False
    return usable


@pytest.mark.parametrize("toroidal", [False, True])
@pytest.mark.parametrize("masked", [False, True])
def test_it_is_what_the_plain_twin_says(toroidal: bool, masked: bool) -> None:
    seen, usable = picture(), holes() if masked else None
    assert (visibility(seen, KNEE, usable, toroidal) == naive_masking.visibility(seen, KNEE, usable, toroidal)).all()
    assert len(np.unique(visibility(seen, KNEE, usable, toroidal))) > 20


def test_a_step_is_seen_where_nothing_changes_and_hidden_by_grain() -> None:
    seen = np.full((40, 60, 1), 500, np.int16)
    seen[:, 30:, 0] += (noise(40, 30, 1) >> np.uint64(55)).astype(np.int16)
    found = visibility(seen, KNEE)
    assert (found[:, :27] == FULL * MOST).all()
    assert FULL // MOST < found[:, 34:].mean() < FULL
    assert (visibility(seen, 4 * KNEE) >= found).all()


def test_what_is_masked_says_nothing() -> None:
    seen, usable = picture(), holes()
    other = seen.copy()
    other[~usable] = 1000
    assert (visibility(seen, KNEE, usable) == visibility(other, KNEE, usable))[usable].all()
    assert not (visibility(seen, KNEE) == visibility(other, KNEE))[usable].all()
