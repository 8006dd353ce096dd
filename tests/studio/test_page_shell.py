"""The page around all rooms: light and dark, rooms by keyboard, names for all controls, two tabs, sizes of screens."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from studio.browser import Desk, desk
from studio.served import Served

if TYPE_CHECKING:
    from playwright.sync_api import Browser, expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect

ROOMS = ("Grow", "Inspect", "Paint", "Mend", "Endless", "Gallery")


def ground(page: Desk) -> str:
    return str(page.page.evaluate("getComputedStyle(document.body).backgroundColor"))


def test_light_and_dark_follow_the_system_and_the_switch(page: Desk) -> None:
    dark = ground(page)
    page.button("Light or dark").click()
    light = ground(page)
    assert dark != light
    page.page.reload()
    page.button("Light or dark").wait_for()
    assert ground(page) == light
    page.served.client.post("/api/kept/page", json={})
    page.page.evaluate("localStorage.clear()")
    page.page.emulate_media(color_scheme="light")
    page.page.reload()
    page.button("Light or dark").wait_for()
    assert ground(page) == light


def test_grays_have_no_tint(page: Desk) -> None:
    for scheme in ("dark", "light"):
        page.page.emulate_media(color_scheme=scheme)
        for name in ("--stage", "--ground", "--raised", "--line", "--ink"):
            colour = page.page.evaluate(f"getComputedStyle(document.documentElement).getPropertyValue('{name}')")
            assert colour[1:3] == colour[3:5] == colour[5:7], (scheme, name)


@pytest.mark.parametrize(
    "how",
    [
        {"viewport": {"width": 1280, "height": 720}},
        {"viewport": {"width": 1024, "height": 768}, "has_touch": True},
        {"viewport": {"width": 1920, "height": 1080}, "color_scheme": "light"},
        {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True},
        {"viewport": {"width": 820, "height": 1180}, "has_touch": True},
        {"viewport": {"width": 2560, "height": 1440}},
    ],
    ids=["desk", "tablet", "large", "phone", "upright", "wall"],
)
def test_every_room_fits_and_every_control_has_a_name(browser: Browser, served: Served, how: Any) -> None:
    pebbles = served.post("/api/exemplars", {"sample": "pebbles"})["id"]
    assert served.ended(served.job("grow", [pebbles], method="best-tile", wrap="both"))["state"] == "failed"
    with desk(browser, served, **how) as page:
        page.sample("tiles")
        page.quick()
        page.button("Grow").click()
        page.grown()
        for room in ROOMS:
            page.room(room)
            page.page.wait_for_timeout(300)
            assert page.page.evaluate("document.documentElement.scrollWidth <= innerWidth"), room
            nameless = page.page.evaluate(
                """() => [...document.querySelectorAll("button, a, input, select, summary, [role=slider]")]
                  .filter(e => e.checkVisibility() && !(e.ariaLabel || e.textContent.trim() || e.labels?.length))
                  .filter(e => !e.querySelector("img[alt]:not([alt=''])"))
                  .map(e => e.outerHTML)"""
            )
            assert nameless == [], room
            wide = page.page.evaluate(
                """() => [...document.querySelectorAll("button, input, select")]
                  .filter(e => e.checkVisibility() && !e.closest(".strip, .others, .unseen, .sheet"))
                  .filter(e => { const b = e.getBoundingClientRect(); return b.right > innerWidth + 1 || b.left < -1; })
                  .map(e => e.outerHTML)"""
            )
            assert wide == [], room
            fits = "[...document.querySelectorAll('.made')].every(e => e.scrollWidth <= e.clientWidth)"
            assert page.page.evaluate(fits), room
            if how.get("has_touch"):
                low = page.page.evaluate(
                    """() => [...document.querySelectorAll(".button, .thumb")]
                      .filter(e => e.checkVisibility() && matchMedia("(pointer: coarse)").matches)
                      .filter(e => e.getBoundingClientRect().height < 40).map(e => e.outerHTML)"""
                )
                assert low == [], room


def test_a_low_screen_gives_a_result_most_of_its_height(page: Desk) -> None:
    page.sample("setts")  # a material, which has the most to choose from
    page.page.get_by_role("spinbutton", name="Width in px").fill("96")
    page.button("Grow").click()
    page.grown()
    assert page.stage().evaluate("s => s.clientHeight / innerHeight") >= 0.6


def test_on_a_phone_all_stands_below_and_the_button_stays_in_sight(browser: Browser, served: Served) -> None:
    with desk(browser, served, viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True) as page:
        page.sample("tiles")
        stage, grow = page.stage().bounding_box(), page.button("Grow")
        assert stage is not None
        assert (stage["x"], stage["width"]) == (0, 390)
        page.page.get_by_label("Seed", exact=True).scroll_into_view_if_needed()
        page.page.locator(".fold > summary").last.scroll_into_view_if_needed()
        expect(grow).to_be_in_viewport()
        expect(page.page.locator(".fold > summary").last).to_be_in_viewport()


def test_a_picture_is_grown_by_keys_alone(page: Desk) -> None:
    for _ in range(400):  # what was opened before stands before the samples
        page.page.keyboard.press("Tab")
        now = page.page.evaluate("(a => a.matches('.card') && a.textContent)(document.activeElement)")
        if now == "tiles":
            break
    else:
        pytest.fail("no key leads to the tiles")
    ring = page.page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
    assert ring == "solid"
    page.page.keyboard.press("Enter")
    page.page.get_by_role("heading", name="tiles").wait_for()
    page.page.keyboard.press("Control+Enter")
    page.grown()


def test_two_tabs_see_the_same_jobs(browser: Browser, served: Served, page: Desk) -> None:
    with desk(browser, served) as other:
        other.sample("tiles")
        other.room("Gallery")
        count = other.page.locator(".made").count()
        page.sample("tiles")
        page.quick()
        page.button("Grow").click()
        page.grown()
        expect(other.page.locator(".made")).to_have_count(min(count + 1, 60))


def test_nothing_comes_from_elsewhere_and_nothing_is_inline(page: Desk) -> None:
    answer = page.served.client.get("/")
    assert "default-src 'self'" in answer.headers["content-security-policy"]
    assert "<style" not in answer.text
    assert " style=" not in answer.text
    assert answer.text.count("<script") == answer.text.count('<script type="module" src="/static/')
