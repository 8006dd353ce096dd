"""The first page at a later start: cards of what was opened before keep their places, whatever the names are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from studio.browser import Desk
from studio.served import pixels, png

if TYPE_CHECKING:
    from playwright.sync_api import Route, expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


def test_a_name_of_80_letters_is_cut_and_the_cards_keep_their_grid(page: Desk) -> None:
    name = "near_stochastic_plaster_" + "defect_" * 8
    assert len(name) == 80
    page.drop(**{name: png(pixels(48, 64, seed=5))})
    page.page.get_by_role("heading", name=name[:60]).wait_for()
    page.page.get_by_role("link", name="intarsia studio: begin").click()
    before = page.page.get_by_role("region", name="Opened before")
    card = before.get_by_role("button", name=name[:60]).first
    expect(card).to_be_visible()
    assert str(card.locator("span").get_attribute("title")).startswith(name[:60])
    cut = "s => s.scrollWidth > s.clientWidth && getComputedStyle(s).textOverflow"
    assert card.locator("span").evaluate(cut) == "ellipsis"
    boxes = before.locator("li").evaluate_all(
        """all => all.map(li => {
          const [own, picture] = [li, li.querySelector("img")].map(e => e.getBoundingClientRect());
          return [own.width, picture.width, picture.height];
        })"""
    )
    widths = {round(own) for own, _, _ in boxes}
    assert len(widths) == 1
    assert all(round(width) in widths and abs(width - height) < 1 for _, width, height in boxes)


def test_an_exemplar_is_taken_away_and_comes_back(page: Desk) -> None:
    page.drop(unwanted=png(pixels(40, 44, seed=8)))
    page.page.get_by_role("heading", name="unwanted").wait_for()
    page.page.get_by_role("link", name="intarsia studio: begin").click()
    before = page.page.get_by_role("region", name="Opened before")
    for done in ("Undo", "Dismiss"):
        before.get_by_role("button", name="unwanted", exact=True).hover()
        before.get_by_role("button", name="Delete unwanted").click()
        expect(before.get_by_role("button", name="unwanted", exact=True)).to_have_count(0)
        assert "unwanted" not in {row["name"] for row in page.served.get("/api/exemplars")}
        page.button(done).click()
        expect(before.get_by_role("button", name="unwanted", exact=True)).to_have_count(int(done == "Undo"))
        assert ("unwanted" in {row["name"] for row in page.served.get("/api/exemplars")}) == (done == "Undo")


def test_what_is_dropped_before_the_page_has_heard_all_is_worked_with(page: Desk) -> None:
    asked: list[Route] = []
    listing = "**/api/exemplars"
    page.page.route(listing, lambda r: asked.append(r) if r.request.method == "GET" else r.fallback())
    page.page.reload()
    while not asked:
        page.page.wait_for_timeout(20)
    before = page.served.get("/api/exemplars")
    page.drop(early=png(pixels(40, 44, seed=9)))
    while "early" not in {row["name"] for row in page.served.get("/api/exemplars")}:
        page.page.wait_for_timeout(20)
    for route in asked:
        route.fulfill(json=before)
    page.page.unroute(listing)
    page.page.get_by_role("heading", name="early").wait_for()
    page.quick()
