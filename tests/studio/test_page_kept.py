"""What the page keeps: a reload, the way back and a new start of the studio lose nothing that was set or marked."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from studio.browser import Desk, desk
from studio.served import QUICK, studio

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Route, expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


def test_what_the_studio_does_not_hear_is_sent_later(page: Desk) -> None:
    page.sample("tiles")
    page.page.route("**/api/kept/*", lambda route: route.abort())
    with page.page.expect_event("requestfailed"):
        page.radio("4").click()
    page.page.unroute("**/api/kept/*")
    page.page.reload()
    expect(page.radio("4")).to_have_attribute("aria-checked", "true")
    page.wrong.clear()


def test_a_reload_and_the_way_back_lead_to_what_was_looked_at(page: Desk) -> None:
    sheet = page.variants()
    cells = sheet.get_by_role("button", name=re.compile("Square pieces, seed ., "))  # under way or done
    expect(cells).to_have_count(4)
    page.page.reload()
    expect(cells).to_have_count(4)
    expect(page.radio("4")).to_have_attribute("aria-checked", "true")
    expect(page.page.get_by_role("spinbutton", name="Width in px")).to_have_value("96")
    expect(page.page.locator(".pick-head")).to_contain_text("image-quilting")
    sheet.get_by_role("button", name="seed 2").click()
    one = page.page.locator(".names").filter(has_text="seed 2")
    expect(one).to_be_visible()
    page.page.go_back()
    expect(sheet).to_be_visible()
    page.page.go_forward()
    expect(sheet).to_be_hidden()
    page.page.reload()
    expect(one).to_be_visible()
    page.room("Gallery")
    page.room("Grow")
    expect(one).to_be_visible()


HEARD = """async job => {
  (await import(new URL("core/store.js", document.scripts[0].src))).store.note(job);
  await new Promise(done => setTimeout(done, 300));
}"""
"""What the page does when it hears of a job: no message that comes before all is loaded makes it forget its address."""


def test_a_job_that_is_heard_of_before_the_page_has_all_leaves_the_address_as_it_is(page: Desk) -> None:
    """A score comes seconds after its job: a reload may just have had the exemplars then, and not yet the jobs."""
    page.sample("tiles")
    page.quick()
    page.button("Grow").click()
    page.grown()
    job = page.page.url.rpartition("/")[2]

    def late(route: Route) -> None:
        page.page.evaluate(HEARD, page.served.get(f"/api/jobs/{job}"))
        route.continue_()

    page.page.route("**/api/jobs", late)
    with page.page.expect_response("**/api/jobs"):
        page.page.reload()
    expect(page.page.locator(".names")).to_contain_text("seed 0")
    assert page.page.url.endswith(f"#grow/{job}")


def test_a_job_that_goes_while_the_list_is_on_its_way_stays_away(page: Desk, small: str) -> None:
    job = page.served.ended(page.served.job("grow", [small], **QUICK))

    def late(route: Route) -> None:
        told = page.served.get("/api/jobs")
        page.served.client.delete(f"/api/jobs/{job['id']}")
        page.page.evaluate("() => new Promise(done => setTimeout(done, 300))")  # until it has heard
        route.fulfill(json=told)

    page.room("Gallery")
    expect(page.page.locator(f".made [data-job='{job['id']}']")).to_have_count(1)
    page.page.route("**/api/jobs", late)
    with page.page.expect_response("**/api/jobs"):
        page.page.reload()
    page.page.get_by_role("heading", name="Gallery").wait_for()
    expect(page.page.locator(f".made [data-job='{job['id']}']")).to_have_count(0)


def test_a_job_that_the_address_names_is_looked_at_as_soon_as_it_is_heard_of(page: Desk) -> None:
    page.sample("tiles")
    page.quick()
    page.button("Grow").click()
    page.grown()
    job = page.page.url.rpartition("/")[2]
    page.page.route("**/api/jobs", lambda route: route.fulfill(json=[]))
    page.page.reload()
    expect(page.page.locator(".names")).to_contain_text("Example")
    page.page.evaluate(HEARD, page.served.get(f"/api/jobs/{job}"))
    expect(page.page.locator(".names")).to_contain_text("seed 0")


def painted(page: Desk, once: list[np.ndarray] | None = None) -> list[np.ndarray]:
    """What is seen in the rooms that one paints in; what was seen once may take its time to be drawn again."""
    seen: list[np.ndarray] = []
    for room, count in (("Paint", 2), ("Mend", 1), ("Inspect", 1)):
        page.room(room)
        page.page.mouse.move(5, 5)
        expect(page.stage(count - 1)).to_be_visible()
        for number in range(count):
            if once:
                page.until(lambda number=number: page.same(once[len(seen)], number))
            seen.append(page.still(number))
    return seen


def test_a_new_start_brings_back_what_was_set_and_painted(browser: Browser, tmp_path: Path) -> None:
    with studio(tmp_path / "folder") as served, desk(browser, served) as page:
        page.button("Light or dark").click()
        page.sample("tiles")
        page.room("Mend")
        page.radio("Extend").click()
        page.page.get_by_label("Right", exact=True).fill("12")
        page.radio("Heal").click()
        plain = painted(page)
        page.page.get_by_role("radio", name="Avoid").click()
        page.stroke((50, 50), (90, 60))
        page.room("Mend")
        page.still()
        page.stroke((100, 100), (140, 120))
        page.room("Paint")
        page.still()
        page.button("Label 2").click()
        page.stroke((60, 60), (200, 200))
        page.stroke((40, 200), (240, 60), number=1)
        before = painted(page)
        theme = page.page.evaluate("getComputedStyle(document.body).backgroundColor")
        exemplar = served.get("/api/exemplars")[0]["id"]
        page.until(lambda: "avoid" in served.get("/api/kept").get(exemplar, {}).get("marks", {}))
        mask = served.get("/api/kept")[exemplar]["marks"]["avoid"]
    assert all(not np.array_equal(a, b) for a, b in zip(plain, before, strict=True))
    with studio(tmp_path / "folder") as served, desk(browser, served, fresh=False) as page:
        page.page.get_by_role("heading", name="tiles", exact=True).wait_for()
        expect(page.page.locator("body")).to_have_css("background-color", theme)
        expect(page.page.get_by_text("Parts are marked as avoided.")).to_be_visible()
        for a, b in zip(before, painted(page, before), strict=True):
            assert np.array_equal(a, b)
        page.room("Mend")
        page.radio("Extend").click()
        expect(page.page.get_by_label("Right", exact=True)).to_have_value("12")
        page.room("Grow")
        page.quick()
        page.button("Grow").click()
        expect(page.page.locator(".strip .thumb")).to_have_count(1)
        assert page.jobs[-1]["options"]["mask"] == [mask]
