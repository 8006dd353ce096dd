"""Files on the page: several at once, what was refused and why, what is not used of them; names, and what failed."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import pytest
from PIL import Image
from studio.browser import Desk
from studio.served import QUICK, pixels, png

if TYPE_CHECKING:
    from playwright.sync_api import Route, expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


def home(page: Desk) -> None:
    page.page.get_by_role("link", name="intarsia studio: begin").click()
    page.page.get_by_role("heading", name="Drop a picture").wait_for()


def test_several_pictures_open_as_several(page: Desk) -> None:
    page.drop(dunes=png(pixels(seed=41)), bark=png(pixels(seed=42)))
    expect(page.page.get_by_role("status").filter(has_text="2 examples opened.")).to_be_visible()
    page.page.get_by_role("heading", name="dunes").wait_for()
    page.page.get_by_role("button", name="Use bark").click()
    page.page.get_by_role("heading", name="bark").wait_for()


def test_a_picture_is_opened_from_every_room(page: Desk) -> None:
    page.sample("tiles")
    for room in ("Mend", "Gallery"):
        page.room(room)
        with page.page.expect_file_chooser() as chosen:
            page.button("Open").click()
        assert chosen.value.is_multiple()


def test_a_refusal_stands_large_beside_the_drop_and_names_the_file(page: Desk) -> None:
    page.drop(notes=b"")
    alert = page.page.get_by_role("region", name="Open a picture").get_by_role("alert")
    expect(alert).to_have_text("notes.png is empty; give the picture itself.")
    size = "e => parseFloat(getComputedStyle(e).fontSize)"
    assert alert.evaluate(size) > page.page.locator("body").evaluate(size)
    page.drop(words=b"these are words")
    expect(alert).to_contain_text("words.png is no picture")
    page.drop(good=png(pixels(seed=43)), bad=b"")
    page.page.get_by_role("heading", name="good").wait_for()
    expect(page.page.get_by_role("alert")).to_contain_text("bad.png is empty")
    page.drop(again=b"")
    expect(page.page.get_by_role("alert")).to_contain_text("again.png is empty")
    page.wrong.clear()


def test_what_is_not_used_of_a_file_is_said(page: Desk) -> None:
    ink = io.BytesIO()
    Image.fromarray(pixels(seed=44)).convert("CMYK").save(ink, "JPEG")
    page.drop(print=ink.getvalue())
    expect(page.page.get_by_role("status").filter(has_text="is made for print (CMYK)")).to_be_visible()
    page.drop(tiny=png(pixels(12, 12, seed=45)))
    expect(page.page.get_by_role("status").filter(has_text="tiny has 12x12 px")).to_be_visible()


def test_it_is_seen_that_a_file_is_on_its_way(page: Desk) -> None:
    held: list[Route] = []
    page.page.route("**/api/exemplars", lambda r: held.append(r) if r.request.method == "POST" else r.fallback())
    page.drop(large=png(pixels(seed=46)))
    sign = page.page.get_by_role("status").filter(has_text="Opening large.png …")
    expect(sign).to_be_visible()
    page.until(lambda: held)
    held[0].continue_()
    page.page.get_by_role("heading", name="large").wait_for()
    expect(sign).to_have_count(0)


def test_an_example_and_a_result_are_given_names(page: Desk) -> None:
    page.drop(scan=png(pixels(seed=47)))
    page.page.get_by_role("heading", name="scan").click()
    field = page.page.get_by_role("textbox", name="Name")
    field.fill("Old wall")
    field.press("Enter")
    page.page.get_by_role("heading", name="Old wall").wait_for()
    page.page.locator(".toast").get_by_role("button", name="Undo").click()
    page.page.get_by_role("heading", name="scan").wait_for()
    page.button("Rename scan").focus()
    page.page.keyboard.press("Enter")
    field.fill("Lost")
    field.press("Escape")
    expect(page.page.get_by_role("heading", name="scan")).to_be_visible()
    expect(page.button("Rename scan")).to_be_focused()
    scan = next(row["id"] for row in page.served.get("/api/exemplars") if row["name"] == "scan")
    job = page.served.ended(page.served.job("grow", [scan], **QUICK))["id"]
    page.room("Gallery")
    card = page.page.locator(".made").first
    card.get_by_role("heading", name="scan").dblclick()
    field.fill("The best one")
    page.until(lambda: page.served.get(f"/api/jobs/{job}")["score"] is not None)
    page.page.wait_for_timeout(500)  # what the score changes on the card
    expect(field).to_have_value("The best one")
    field.press("Enter")
    expect(card.get_by_role("heading", name="The best one")).to_be_visible()
    page.page.reload()
    expect(card.get_by_role("heading", name="The best one")).to_be_visible()
    card.locator(".thumb").click()
    page.grown()
    download = page.page.get_by_role("link", name="Download", exact=True)
    with page.page.expect_download() as coming:
        download.click()
    assert coming.value.suggested_filename == "The_best_one.png"


def test_what_failed_is_cleared_at_once_and_comes_back(page: Desk, small: str) -> None:
    for _ in range(2):
        job = page.served.ended(page.served.job("grow", [small], method="best-tile", wrap="both"))
        assert job["state"] == "failed"
    failed = [j for j in page.served.get("/api/jobs") if j["state"] in ("failed", "cancelled", "interrupted")]
    page.sample("tiles")
    page.room("Gallery")
    clear = page.page.get_by_role("button", name="Clear ").filter(has_text="failed")
    expect(clear).to_have_text(f"Clear {len(failed)} failed")
    clear.click()
    expect(clear).to_have_count(0)
    assert not [j for j in page.served.get("/api/jobs") if j["state"] == "failed"]
    page.button("Undo").click()
    expect(clear).to_have_text(f"Clear {len(failed)} failed")


def test_the_disk_is_told(page: Desk) -> None:
    page.sample("tiles")
    for where in ("Gallery", ""):
        page.room(where) if where else home(page)
        told = page.page.get_by_text("on disk")
        expect(told).to_have_attribute("title", str(page.served.folder))
