"""Nobody is shut out: what axe-core finds in every room, contrast of colours, everything by keyboard and in sight."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from studio.browser import Desk, desk
from studio.served import Served

import intarsia.studio

if TYPE_CHECKING:
    from playwright.sync_api import Browser, expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect

STYLE = Path(intarsia.studio.__file__).parent / "static" / "style"
ROOMS = ("Grow", "Inspect", "Paint", "Mend", "Endless", "Gallery")
SERIOUS = ("serious", "critical")


@pytest.fixture(scope="module")
def axe() -> Any:
    """The audit, which lies on this disk; without it the test is left out, or fails if INTARSIA_BROWSER=required."""
    if find_spec("axe_playwright_python") is None:
        line = "no axe-playwright-python: the page is not audited"
        if os.environ.get("INTARSIA_BROWSER") == "required":
            pytest.fail(line)
        pytest.skip(line)
    from axe_playwright_python.sync_playwright import Axe

    return Axe()


@pytest.fixture(scope="module", params=["dark", pytest.param("light", marks=pytest.mark.long)])
def filled(request: pytest.FixtureRequest, browser: Browser, served: Served) -> Iterator[Desk]:
    """A page on which something was made: a material, a result with its score, a job that failed."""
    setts = served.post("/api/exemplars", {"sample": "setts"})["id"]
    for job in served.get("/api/jobs"):  # what other files made of it has other sizes, which cannot be compared
        if setts in job["exemplars"]:
            served.client.delete(f"/api/jobs/{job['id']}").raise_for_status()
    quick: dict[str, Any] = {"method": "image-quilting", "patch": "32", "size": "96x80"}
    served.done("grow", [setts], **quick)
    served.done("grow", [setts], **quick, seed=1)
    served.ended(served.job("grow", [setts], method="best-tile", wrap="both"))
    with desk(browser, served, color_scheme=request.param) as page:
        page.sample("setts")
        page.page.locator(".strip .thumb").first.wait_for()
        yield page


def states(page: Desk) -> Iterator[str]:
    """Go through all that can be seen, one after another."""
    page.page.get_by_role("link", name="intarsia studio: begin").click()
    yield "Start"
    page.drop(nothing=b"")
    page.page.get_by_role("alert").filter(has_text="nothing.png is empty").wait_for()
    page.wrong.clear()
    yield "Start, a file was refused"
    for room in ROOMS:
        page.room(room)
        page.page.wait_for_timeout(400)
        if room == "Inspect":
            page.page.get_by_role("heading", name="Automatic takes").wait_for(timeout=60_000)
        yield room
        for mode in {"Inspect": ("Crop", "Avoid"), "Mend": ("Extend", "Tile")}.get(room, ()):
            page.radio(mode).click()
            yield f"{room}, {mode}"
    page.page.locator(".made h3").first.dblclick()
    yield "Gallery, a name is given"
    page.page.keyboard.press("Escape")
    page.room("Grow")
    for fold in page.page.locator(".fold > summary").all():
        fold.click()
    page.page.locator(".pick-head").click()
    yield "Grow, all unfolded"
    page.page.locator(".pick-head").click()
    page.page.locator(".strip .thumb").last.click()
    page.page.get_by_role("link", name=re.compile("^Download( this map)?$")).wait_for()
    page.page.get_by_role("button", name=re.compile("score")).click(timeout=60_000)
    shows = page.page.get_by_role("button", name=re.compile("^Show: "))
    shows.first.wait_for()
    yield "A result with its score"
    shows.first.click()
    page.button("Place 1").click()
    yield "Marked places"
    page.button("Hide the marks").click()
    page.button("More to take").click()
    yield "A result with its files"
    page.page.keyboard.press("Escape")
    page.radio("Lit").click()
    page.page.get_by_role("slider", name="Lamp").wait_for()
    yield "Lit"
    page.radio("Pieces").click()
    page.button("Compare").click()
    page.page.get_by_role("slider", name="Divider between A and B").wait_for()
    yield "Compared"
    page.button("Compare").click()
    page.radio("4").click()
    page.button("Grow").click()
    page.page.get_by_role("heading", name="Contact sheet").wait_for()
    yield "A contact sheet"
    page.page.locator(".sheet .caption .number:empty").first.wait_for(state="detached", timeout=120_000)


SETTLED = """Promise.all(document.getAnimations().filter(each => each.effect.getTiming().iterations < Infinity)
  .map(each => each.finished.catch(() => {})))"""
"""Waits until no colour is on its way to another."""


def test_an_audit_finds_nothing_serious(filled: Desk, axe: Any) -> None:
    found = []
    for state in states(filled):
        filled.page.evaluate(SETTLED)
        for each in axe.run(filled.page).response["violations"]:
            if each["impact"] in SERIOUS:
                found += [(state, each["id"], node["html"][:150]) for node in each["nodes"]]
    assert found == []


def luminance(colour: str) -> float:
    channels = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(a: str, b: str) -> float:
    high, low = sorted((luminance(a), luminance(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def test_colours_stand_out_from_every_ground() -> None:
    text = (STYLE / "tokens.css").read_text()
    themes = [dict(re.findall(r"(--[a-z-]+): (#[0-9a-f]{6});", block)) for block in re.findall(r"\{([^{}]*)\}", text)]
    dark, *light = [theme for theme in themes if "--ink" in theme]
    assert len(light) == 2
    assert light[0] == light[1]
    for theme in (dark, light[0]):
        for ground in ("--ground", "--raised", "--field", "--hover"):
            assert contrast(theme["--ink"], theme[ground]) >= 7
            assert contrast(theme["--ink-quiet"], theme[ground]) >= 4.5
        for ground in ("--ground", "--field"):
            assert contrast(theme["--ink-faint"], theme[ground]) >= 4.5
            assert contrast(theme["--line-strong"], theme[ground]) >= 3
            assert contrast(theme["--bad"], theme[ground]) >= 4.5
        for ground in ("--ground", "--raised", "--field", "--stage"):
            assert contrast(theme["--focus"], theme[ground]) >= 3
        assert contrast(theme["--on-strong"], theme["--strong"]) >= 7


WALK = """() => {
  const now = document.activeElement;
  const style = (e) => getComputedStyle(e);
  const ringed = (e) => style(e).outlineStyle !== "none" && parseFloat(style(e).outlineWidth) >= 2;
  const box = now.getBoundingClientRect();
  return {
    body: now === document.body,
    number: [...document.querySelectorAll("*")].indexOf(now),
    ringed: ringed(now) || ringed(now.parentElement),
    inside: box.right > 0 && box.bottom > 0 && box.left < innerWidth && box.top < innerHeight,
    html: now.outerHTML.slice(0, 120),
  };
}"""
REACHABLE = """() => [...document.querySelectorAll("a[href], button, input, select, summary, [tabindex='0']")]
  .filter(e => e.checkVisibility({checkVisibilityCSS: true}) && !e.disabled && e.tabIndex >= 0)
  .filter(e => !(e.type === "radio" && e.name && !e.checked)).map(e => e.outerHTML.slice(0, 120))"""


def test_the_keyboard_reaches_every_control_in_order_and_shows_where_it_is(filled: Desk) -> None:
    filled.page.get_by_role("link", name="intarsia studio: begin").click()
    for room in ("Start", *ROOMS):
        if room != "Start":
            filled.room(room)
        filled.page.wait_for_timeout(800)
        assert filled.page.locator("[tabindex]:not([tabindex='0'], [tabindex='-1'])").count() == 0
        wanted, body = filled.page.evaluate(REACHABLE), filled.page.locator("body").element_handle()
        filled.page.evaluate("b => { b.tabIndex = -1; b.focus(); b.removeAttribute('tabindex'); }", body)
        seen, last = [], -1
        for _ in range(len(wanted) + 40):
            filled.page.keyboard.press("Tab")
            now = filled.page.evaluate(WALK)
            if now["body"]:
                break
            assert now["ringed"], (room, now["html"])
            assert now["inside"], (room, now["html"])
            if now["number"] < last:
                break
            last = now["number"]
            seen.append(now["html"])
        assert [each for each in wanted if each not in seen] == [], room


def test_the_focus_stays_where_it_is_while_a_job_goes_on(page: Desk) -> None:
    page.sample("pebbles")
    page.button("8 times the example").click()
    page.button("Grow").click()
    cancel = page.button("Cancel")
    cancel.focus()
    said = page.page.locator(".progress .number")
    first = said.text_content()
    changed = "first => document.querySelector('.progress .number')?.textContent !== first"
    page.page.wait_for_function(changed, arg=first)
    assert cancel.evaluate("b => b === document.activeElement")
    page.page.keyboard.press("Enter")
    expect(page.page.get_by_role("alert")).to_have_text("Cancelled")
    link = page.page.get_by_role("link", name="Inspect", exact=True)
    link.focus()
    page.page.keyboard.press("Enter")
    page.page.get_by_role("heading", name="Repeating grid").wait_for(timeout=60_000)
    assert link.evaluate("a => a === document.activeElement")


def test_the_focus_stays_when_cells_change_their_order(page: Desk) -> None:
    assert page.page.evaluate("""async () => {
      const { arrange } = await import(new URL("parts/cell.js", document.scripts[0].src));
      const place = document.body.appendChild(document.createElement("div")), cells = new Map();
      const order = ids => arrange(place, cells, ids, id => ({
        place: Object.assign(document.createElement("button"), { textContent: id }), show() {},
      }));
      order(["a", "b", "c"]);
      cells.get("b").place.focus();
      order(["c", "b", "a"]);
      return [place.textContent, document.activeElement.textContent];
    }""") == ["cba", "b"]
