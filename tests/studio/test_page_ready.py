"""The first minute on a fresh computer: a picture comes before all is compiled, and the page says why it takes."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from studio.browser import Desk, desk
from studio.served import studio

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Route, expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect

READY = re.compile(r"^Getting ready, once on this computer: (about \d+ (s|min)|a little longer)$")


def test_with_nothing_compiled_the_first_result_waits_for_its_own_kernels_alone(
    browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("INTARSIA_CACHE", str(tmp_path / "cache"))
    with studio(tmp_path / "folder") as cold, desk(browser, cold) as page:
        page.sample("tiles")
        page.quick()
        page.button("Grow").click()
        page.page.get_by_role("heading", name="Growing ...").wait_for()
        expect(page.page.locator(".awaited")).to_have_text(READY, timeout=60_000)
        assert grey(page) == (96, 80)
        page.grown()
        expect(page.page.locator(".awaited")).to_have_text("")
        kind, warm = next(cold.events())
        assert kind == "warm"
        assert warm["done"] < warm["total"]


def test_a_job_that_waits_tells_for_what_and_shows_no_exemplar(page: Desk, small: str) -> None:
    page.page.route("**/preview.png*", lambda route: route.abort())
    held = page.served.held(small)
    page.sample("tiles")
    page.quick()
    page.button("Grow").click()
    expect(page.page.locator(".awaited")).to_have_text("Waiting for 2 other jobs")
    page.page.get_by_role("heading", name="Growing ...").wait_for()
    assert grey(page) == (96, 80)
    page.page.locator(".progress").get_by_role("button", name="Cancel").click()
    page.page.get_by_role("heading", name="Cancelled").wait_for()
    assert grey(page) == (96, 80)
    page.served.let(held)
    page.wrong.clear()  # previews that were held back


def test_a_draft_is_seen_of_a_job_that_waits_and_what_it_waits_for(page: Desk, small: str) -> None:
    held = page.served.held(small)
    page.sample("tiles")
    page.quick()
    page.button("Grow").click()
    expect(page.page.locator(".awaited")).to_have_text("Waiting for 2 other jobs")
    page.until(lambda: len(np.unique(page.seen().reshape(-1, 4), axis=0)) > 500)
    (job,) = (job for job in page.served.get("/api/jobs") if job["state"] == "queued")
    expect(page.page.locator(".awaited")).to_have_text("Waiting for 2 other jobs")
    page.served.let(held)
    page.grown()
    expect(page.page.locator(".awaited")).to_be_hidden()
    assert page.served.get(f"/api/jobs/{job['id']}")["state"] == "done"


@pytest.mark.parametrize(
    ("verb", "stage", "said"),
    [
        ("heal", None, "Looking at the example"), ("heal", "grow", "Healing"), ("tile", "grow", "Tiling"),
        ("grow", "render", "Drawing"), ("render", None, "Drawing"),
    ],
)
def test_what_a_job_is_at_is_said_as_people_say_it(page: Desk, verb: str, stage: str | None, said: str) -> None:
    script = "async job => (await import(new URL('core/words.js', document.scripts[0].src))).state(job)"
    assert page.page.evaluate(script, {"verb": verb, "stage": stage, "state": "running"}) == said


def test_no_scale_is_told_while_no_picture_is_there(page: Desk) -> None:
    held: list[Route] = []
    page.page.route("**/albedo.png?side=4096", lambda route: held.append(route))
    page.sample("tiles")
    zoom = page.page.get_by_label("Zoom", exact=True)
    expect(zoom).to_have_text("")
    while not held:
        page.page.wait_for_timeout(20)
    for route in held:
        route.continue_()
    expect(zoom).to_have_text(re.compile(r"^\d+ %$"))


def grey(page: Desk) -> tuple[int, int]:
    """The size of what the stage shows, which is one grey all over."""
    how, seen = page.told(), page.seen()
    left, top = round(how["x"]) + 2, round(how["y"]) + 2
    shown = seen[top : top + int(how["height"] * how["scale"]) - 4, left : left + int(how["width"] * how["scale"]) - 4]
    (colour,) = np.unique(shown.reshape(-1, 4), axis=0)
    assert colour[0] == colour[1] == colour[2]
    assert colour[3] == 255
    return how["width"], how["height"]
