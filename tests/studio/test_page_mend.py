"""Mending on the page: what is brushed over is healed, the frame is dragged, the picture is made to tile."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from studio.browser import Desk
from studio.test_page_paint import drawn

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


@pytest.fixture
def mend(page: Desk) -> Desk:
    """The room to mend in."""
    page.sample("tiles")
    page.room("Mend")
    return page


def test_what_is_brushed_over_is_healed(mend: Desk) -> None:
    places = mend.stroke((100, 100), (140, 120))
    mend.button("Heal").click()
    result = mend.served.get(f"/api/results/{mend.grown()}")
    assert (result["verb"], result["size"]) == ("heal", [256, 256])
    assert np.array_equal(mend.sent("mask"), drawn((256, 256), places, 32, 255))
    assert set(mend.jobs[0]["options"]) == {"mask"}


def test_nothing_brushed_over_is_said_so(mend: Desk) -> None:
    mend.button("Heal").click()
    expect(mend.page.get_by_role("alert")).to_contain_text("Brush over what must go")
    assert not mend.jobs


def test_the_frame_is_dragged_outwards(mend: Desk) -> None:
    mend.radio("Extend").click()
    mend.stroke((256, 128), (300, 128))
    mend.stroke((0, 0), (-20, -30))
    sides = [mend.page.get_by_label(name, exact=True) for name in ("Right", "Left", "Top")]
    right, left, top = (int(side.input_value()) for side in sides)
    assert (right, left, top) == (pytest.approx(44, abs=1), pytest.approx(20, abs=1), pytest.approx(30, abs=1))
    mend.page.get_by_label("Bottom").fill("12")
    mend.page.get_by_label("Top").fill("0")
    mend.button("Extend").click()
    result = mend.served.get(f"/api/results/{mend.grown()}")
    assert result["size"] == [256 + left + right, 256 + 12]
    assert mend.jobs[0]["options"] == {"left": left, "right": right, "bottom": 12}
    mend.button("Mend on").click()
    expect(mend.page.get_by_label("Right", exact=True)).to_be_visible()


def test_a_picture_is_made_to_tile(mend: Desk) -> None:
    mend.radio("Tile").click()
    mend.radio("Across").click()
    mend.button("Make it tile").click()
    result = mend.served.get(f"/api/results/{mend.grown()}")
    assert (result["verb"], mend.jobs[0]["options"]) == ("tile", {"axes": "x"})
