"""Ashikhmin against a plain version of itself, and what else it promises."""

from __future__ import annotations

import numpy as np
import pytest
from published.pixels.naive_pixels import NaiveScan
from published.pixels.test_wei_levoy import CASES, GRAY, shown, smooth, with_hole

import intarsia as ia
from intarsia.model import Exemplar

STAGE = ia.Ashikhmin.stage


@pytest.mark.parametrize("name", [name for name in CASES if "levels" not in name])
def test_it_takes_what_the_plain_version_takes(name: str) -> None:
    """Every pixel of the map is the same."""
    case = {"size": (17, 14), "window": (3, 5), "wrap": "none"} | CASES[name]
    for seed in (0, 79):
        method = ia.Ashikhmin(window=case["window"])
        out = ia.synthesize(case["exemplars"], case["size"], method, seed=seed, wrap=case["wrap"])
        plain = NaiveScan(
            case["exemplars"], case["size"], case["window"], seed, STAGE, ia.Wrap(case["wrap"]), coherent=True
        )
        assert shown(out) == plain.run()


def test_a_start_is_continued_as_the_plain_version_does() -> None:
    e = Exemplar.of(smooth(4, 20, 19))
    start, holes = with_hole(e)
    out = ia.synthesize(e, None, ia.Ashikhmin(window=(2, 5)), start=start, wrap="y", seed=3)
    known = {(int(y), int(x)): (0, int(y), int(x)) for y, x in np.argwhere(~holes)}
    assert shown(out) == NaiveScan([e], (20, 19), (2, 5), 3, STAGE, ia.Wrap.Y, coherent=True, start=known).run()


def test_what_cannot_be_compared_is_refused() -> None:
    for window in (1, 6, (3, 4)):
        with pytest.raises(ia.ParameterError, match="odd"):
            ia.Ashikhmin(window=window)
    with pytest.raises(ia.ParameterError, match="larger exemplar"):
        ia.synthesize(GRAY, 20, ia.Ashikhmin(window=(3, 19)))
