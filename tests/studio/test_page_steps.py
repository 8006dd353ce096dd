"""Steps: what led to a picture is a list, gone to and fro, branched, and made again after a change."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from studio.browser import Desk

if TYPE_CHECKING:
    from playwright.sync_api import Locator, expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


def steps(page: Desk) -> Locator:
    return page.page.get_by_role("navigation", name="Steps").get_by_role("button")


def grown(page: Desk, seed: int, before: int) -> Any:
    """Grow with a seed; the job when it is done."""
    page.page.get_by_role("spinbutton", name="Seed").fill(str(seed))
    page.button("Grow").click()
    page.until(lambda: len(page.jobs) == before + 1)
    page.grown()
    page.until(lambda: page.served.get("/api/jobs")[-1]["state"] == "done")
    return page.served.get("/api/jobs")[-1]


def onward(page: Desk) -> None:
    page.button("Continue from this").click()
    expect(page.page.get_by_role("heading", name="Example", exact=True)).to_be_visible()


def test_steps_are_gone_back_to_branched_and_made_again(page: Desk) -> None:
    page.sample("tiles")
    page.quick()
    first = grown(page, 1, 0)
    expect(steps(page)).to_have_count(0)
    one = page.still()
    onward(page)
    second = grown(page, 2, 1)
    two = page.still()
    expect(steps(page)).to_have_text(["tiles", "Square pieces, seed 1", "Square pieces, seed 2"])
    expect(steps(page).nth(2)).to_have_attribute("aria-current", "step")
    steps(page).nth(1).click()
    page.until(lambda: page.same(one))
    expect(steps(page)).to_have_count(3)
    page.page.reload()
    page.until(lambda: page.same(one))

    page.page.evaluate(f"location.hash = '#grow/{second['id']}'")
    page.until(lambda: page.same(two))
    steps(page).nth(1).click()
    page.until(lambda: page.same(one))
    other = grown(page, 5, 2)
    assert other["exemplars"] == first["exemplars"]
    before = len(page.served.get("/api/jobs"))
    page.button("Make the step after it again").click()
    page.until(lambda: len(page.served.get("/api/jobs")) == before + 1)
    page.until(lambda: page.served.get("/api/jobs")[-1]["state"] == "done")
    again = page.served.get("/api/jobs")[-1]
    assert again["options"] == second["options"]
    made_of = next(e for e in page.served.get("/api/exemplars") if e["id"] == again["exemplars"][0])
    assert made_of["from"] == other["result"]
    expect(steps(page)).to_have_text(["tiles", "Square pieces, seed 5", "Square pieces, seed 2"])
    assert not np.array_equal(page.still(), two)
