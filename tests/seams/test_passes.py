"""What both passes over finished maps keep: bytes on any number of threads, masks, depths and alpha."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from seams.test_striking import spotted

import intarsia as ia
from intarsia.exemplar import Exemplar
from intarsia.seams import passes
from intarsia.testing import looked_up

ONE = ia.Run(1)
both_passes = pytest.mark.parametrize("goes_over", [{"spread": 8}, {"striking": 0}], ids=lambda kind: next(iter(kind)))


@both_passes
@pytest.mark.parametrize("isometries", ["none", "both"])
def test_threads_change_no_byte(goes_over: dict[str, Any], isometries: str) -> None:
    """Law 4, in all poses and over wrapped borders, too."""
    method = ia.ImageQuilting(patch=20, overlap=6, isometries=isometries, **goes_over)
    exemplars = [Exemplar.of(spotted(), toroidal=True), Exemplar.of(spotted(80, 96, 5))]
    made = [ia.synthesize(exemplars, (190, 180), method, seed=2, wrap="both", run=ia.Run(n)) for n in (1, 2, 4)]
    assert len({m.map.digest for m in made}) == 1
    plain = ia.ImageQuilting(patch=20, overlap=6, isometries=isometries)
    assert ia.synthesize(exemplars, (190, 180), plain, seed=2, wrap="both", run=ONE).map.digest != made[0].map.digest
    assert made[0].render(feather=0).pixels.tobytes() == looked_up(made[0].exemplars, made[0].map).tobytes()


@both_passes
def test_masked_and_translucent_and_deep_exemplars(goes_over: dict[str, Any]) -> None:
    """No masked pixel is shown; alpha and 16 bits make the map that 8 bits make."""
    usable = np.ones((96, 90), bool)
    usable[60:80, 50:80] = False
    pixels = spotted()
    deep = pixels.astype(np.uint16) * 257
    method = ia.Graphcut(patch=24, overlap=10, refinements=2, **goes_over)
    out = ia.synthesize(Exemplar.of(pixels, usable=usable), (180, 180), method, seed=1, run=ONE).map
    assert usable[out.yx[..., 0], out.yx[..., 1]].all()
    assert out.digest == ia.synthesize(Exemplar.of(deep, usable=usable), (180, 180), method, seed=1, run=ONE).map.digest
    alpha = np.dstack([pixels, (pixels[..., 1] > 70) * np.uint8(255)])
    made = ia.synthesize(Exemplar.of(alpha), (180, 180), method, seed=1, run=ONE)
    assert made.render(feather=0).pixels.tobytes() == looked_up(made.exemplars, made.map).tobytes()


def test_where_elements_are_known_nothing_is_covered(monkeypatch: pytest.MonkeyPatch) -> None:
    """To cover one of packed stones would fuse two others: with `whole`, striking ones of known outlines are left."""
    monkeypatch.setattr("intarsia.seams.graphcut.TRIES", 1)
    few, plain = (ia.Graphcut(patch=24, overlap=10, refinements=2, whole=n, striking=0) for n in (1, 0))
    covered = [ia.synthesize(spotted(), (180, 180), method, seed=1, run=ONE).map.digest for method in (few, plain)]
    monkeypatch.setattr(passes, "wholes", lambda e: e)
    known = [ia.synthesize(spotted(), (180, 180), method, seed=1, run=ONE).map.digest for method in (few, plain)]
    assert covered == [known[1]] * 2
    assert known[0] != known[1]
