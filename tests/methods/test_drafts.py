"""What methods show while they grow: maps of what is there, the last of them the result; nothing changes by it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import intarsia as ia
from intarsia.methods import make
from intarsia.model.sourcemap import SourceMap

CASES = [
    ("near-regular", "brick", {}, "none"), ("near-regular", "brick", {}, "both"),
    ("near-regular", "tiles", {}, "none"),
    ("gap-filling", "tiles", {}, "none"), ("parallel-controllable", "tiles", {}, "none"),
    ("parallel-controllable", "grass", {}, "both"), ("parallel-controllable", "stones", {"angle": 20}, "none"),
    ("wei-levoy", "stones", {}, "none"), ("ashikhmin", "stones", {}, "x"), ("efros-leung", "stones", {}, "none"),
]  # fmt: skip


def drafts_of(exemplar: ia.Exemplar, size: Any, method: Any, **how: Any) -> tuple[list[SourceMap], SourceMap]:
    """All drafts of a synthesis, one a unit of work at most, and its map."""
    found = list[SourceMap]()

    def step(done: int, total: int, draft: Any) -> None:
        if (draft is not None and len(found) < 200) or (draft is not None and done == total):
            found.append(draft())

    return found, ia.synthesize(exemplar, size, method, run=ia.Run(2, step), **how).map


@pytest.mark.parametrize(("slug", "name", "given", "wrap"), CASES)
def test_drafts_grow_into_the_result(slug: str, name: str, given: dict[str, Any], wrap: str) -> None:
    exemplar, small = ia.read(f"sample:{name}"), slug in ("wei-levoy", "ashikhmin", "efros-leung")
    if small:
        exemplar = ia.Exemplar.of(exemplar.base.pixels[:40, :44])
    method, size = make(slug, given), (52, 60) if small else (255, 257) if name == "tiles" else (200, 247)
    drafts, made = drafts_of(exemplar, size, method, wrap=wrap, seed=3)
    plain = ia.synthesize(exemplar, size, method, wrap=wrap, seed=3)
    assert made.digest == plain.map.digest
    there = [int((~d.holes).sum()) for d in drafts]
    assert there == sorted(there)
    assert len(drafts) > 1
    for d in drafts:
        assert d.yx.shape == made.yx.shape
        known = d.yx[~d.holes]
        assert ((known >= 0) & (known < (exemplar.height, exemplar.width))).all()
    assert not drafts[-1].holes.any()
    if not given.get("angle"):
        assert np.array_equal(drafts[-1].yx, made.yx)


def test_a_picture_that_is_continued_is_in_every_draft() -> None:
    exemplar = ia.read("sample:tiles")
    height, width = exemplar.height, exemplar.width
    yx, which = np.zeros((height + 70, width + 50, 2), np.int32), np.full((height + 70, width + 50), 255, np.uint8)
    yx[:height, :width] = np.moveaxis(np.indices((height, width)), 0, 2)
    which[:height, :width] = 0
    start = SourceMap(yx, which, None, (exemplar.source,))
    drafts, _ = drafts_of(exemplar, None, ia.ImageQuilting(patch=60, overlap=20), start=start)
    assert len(drafts) > 1
    for d in drafts:
        assert not d.holes[:height, :width].any()
        deep = slice(height - 20), slice(width - 20)
        assert np.array_equal(d.yx[deep], yx[deep])
