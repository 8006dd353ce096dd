"""Looking at a result on the page: zoom and pan, what is laid over it, where a pixel came from, the score."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from studio.browser import Desk

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


@pytest.fixture
def look(page: Desk) -> Desk:
    """A small result on the stage."""
    page.sample("tiles")
    page.quick()
    page.button("Grow").click()
    page.result = page.grown()
    return page


def test_wheel_keys_and_drag_move_the_view(look: Desk) -> None:
    how = look.told()
    x, y = look.at(30, 20)
    look.page.mouse.move(x, y)
    look.page.mouse.wheel(0, -300)
    look.page.wait_for_timeout(200)
    zoomed = look.told()
    assert zoomed["scale"] > 1.5 * how["scale"]
    assert look.at(30, 20) == (pytest.approx(x, abs=1), pytest.approx(y, abs=1))
    look.page.mouse.down()
    look.page.mouse.move(x + 40, y - 25)
    look.page.mouse.up()
    moved = look.told()
    assert (moved["x"] - zoomed["x"], moved["y"] - zoomed["y"]) == (40, -25)
    look.page.keyboard.press("ArrowRight")
    assert look.told()["x"] == moved["x"] - 50
    look.page.keyboard.press("1")
    assert look.told()["scale"] == 1
    look.page.keyboard.press("0")
    assert look.told() == how


def test_every_look_is_laid_over_the_picture(look: Desk) -> None:
    plain = look.seen()
    for name in ("Pieces", "Seams", "Usage", "Source", "Damage"):
        look.radio(name).click()
        expect(look.page.locator(".corner.low.left")).not_to_have_text("…", timeout=30_000)
        assert look.told()["layers"] == 1, name
        if name != "Damage":
            assert not np.array_equal(look.seen(), plain), name
    look.radio("Picture").click()
    assert look.told()["layers"] == 0
    assert np.array_equal(look.seen(), plain)


def test_the_pointer_shows_where_a_pixel_came_from(look: Desk) -> None:
    came = np.frombuffer(look.served.bytes(f"/api/results/{look.result}/map.bin"), "<u2").reshape(80, 96, 3)
    look.page.mouse.move(*look.at(10.5, 10.5))
    look.page.wait_for_timeout(500)
    look.page.mouse.move(*look.at(50.5, 33.5))
    _, row, column = came[33, 50]
    expect(look.page.locator(".corner.low.right")).to_have_text(f"50, 33  from  {column}, {row}")
    mark = look.page.locator(".source-mark").bounding_box()
    picture = look.page.get_by_role("img", name="Exemplar tiles").last.bounding_box()
    assert mark is not None
    assert picture is not None
    assert mark["x"] + 8.5 == pytest.approx(picture["x"] + (column + 0.5) / 256 * picture["width"], abs=1.5)
    assert mark["y"] + 8.5 == pytest.approx(picture["y"] + (row + 0.5) / 256 * picture["height"], abs=1.5)
    look.page.mouse.move(5, 5)
    expect(look.page.locator(".source-mark")).to_be_hidden()


def test_the_score_tells_its_parts(look: Desk) -> None:
    look.page.get_by_role("button", name="Score").click(timeout=60_000)
    score = look.served.get(f"/api/results/{look.result}")["score"]
    parts = look.page.get_by_role("group", name="Parts of the score")
    expect(parts.locator("dt")).to_have_count(len(score["parts"]))
    expect(look.page.get_by_role("button", name=f"Score {score['total']:.0f}")).to_be_visible()
    look.page.keyboard.press("Escape")
    expect(parts).to_be_hidden()


def test_a_preview_that_is_gone_when_it_is_asked_for_is_no_error(page: Desk) -> None:
    page.page.route("**/preview.png?*", lambda route: route.fulfill(status=204))
    page.sample("pebbles")
    page.button("3 times the exemplar").click()
    page.button("Grow").click()
    page.grown()
    expect(page.page.locator(".toast")).to_have_count(0)
