"""Many pages of one browser: each opens, each hears what happens, whichever of them are closed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from studio.browser import DESK, Desk, desk
from studio.served import QUICK, Served, pixels, png

if TYPE_CHECKING:
    from playwright.sync_api import Browser, expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect

MANY = 20


def opened(context: Any, served: Served) -> Any:
    page = context.new_page()
    page.goto(f"{served.address}#gallery", timeout=20_000)
    expect(page.get_by_role("heading", name="Gallery")).to_be_visible(timeout=20_000)
    return page


def test_twenty_pages_open_and_each_hears_of_a_new_job(browser: Browser, served: Served, small: str) -> None:
    context = browser.new_context(viewport=DESK)
    first = context.new_page()
    first.goto(served.entrance())
    served.done("grow", [small], **QUICK)  # so that there is a gallery
    pages = [opened(context, served) for _ in range(MANY)]
    first.close()
    there = sum(job["verb"] not in ("analyze", "score") for job in served.get("/api/jobs"))
    for page in pages:
        expect(page.get_by_text(f"{there} made", exact=True)).to_be_visible()
    job = served.ended(served.job("grow", [small], **QUICK, seed=1234))
    for page in pages:
        new = page.locator(f".made [data-job='{job['id']}']")
        expect(new).to_have_attribute("aria-label", "Square pieces, seed 1234, Done", timeout=10_000)
    for page in pages[1:]:
        page.close()
    served.client.delete(f"/api/jobs/{job['id']}").raise_for_status()
    expect(pages[0].locator(f".made [data-job='{job['id']}']")).to_have_count(0)
    context.close()


def test_every_page_hears_of_a_new_exemplar_and_lists_the_newest_first(page: Desk) -> None:
    beside = opened(page.page.context, page.served)
    beside.get_by_role("link", name="intarsia studio: begin").click()
    page.drop(sooner=png(pixels(40, 44, seed=11)))
    page.page.get_by_role("heading", name="sooner").wait_for()
    page.drop(later=png(pixels(40, 44, seed=12)))
    cards = beside.get_by_role("region", name="Opened before").locator(".card")
    expect(cards.nth(0)).to_have_text("later")
    expect(cards.nth(1)).to_have_text("sooner")
    beside.reload()
    expect(cards.nth(0)).to_have_text("later")
    expect(cards.nth(1)).to_have_text("sooner")
    beside.get_by_role("button", name="Delete later").click()
    expect(page.page.get_by_role("heading", name="later")).to_have_count(0)
    beside.get_by_role("button", name="Undo").click()
    expect(page.page.get_by_role("region", name="Opened before").locator(".card").first).to_have_text("later")


def test_a_page_that_comes_late_is_told_how_things_are_by_a_line_of_its_own(page: Desk) -> None:
    """What is said to all at once may be said before the newest is among them: it would wait for ever."""
    page.sample("tiles")
    asked = """() => new Promise(told => {
      const ear = new SharedWorker(new URL("core/ear.js", document.scripts[0].src));
      ear.port.onmessage = e => e.data.kind === "here" && told(e.data.told);
      setTimeout(() => told("nothing"), 20000);
    })"""
    assert page.page.evaluate(asked) is True


def test_a_page_tells_when_the_studio_is_gone(browser: Browser, tmp_path: Path) -> None:
    alone = Served(tmp_path / "folder")
    with desk(browser, alone) as page:
        page.sample("tiles")
        alone.kill()
        page.page.get_by_text("The studio does not answer", exact=True).wait_for()
        page.wrong.clear()  # a browser says of each try that nobody answers
