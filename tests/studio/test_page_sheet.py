"""Several at once, side by side: each can be stopped by itself, and each tells its score."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from studio.browser import Desk

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


def test_one_cell_is_cancelled_alone_and_scores_are_seen_whole_on_narrow_cells(page: Desk, small: str) -> None:
    page.page.set_viewport_size({"width": 880, "height": 600})
    held = page.served.held(small)
    page.sample("tiles")
    page.quick()
    page.page.get_by_label("Seed", exact=True).fill("123456")
    page.radio("4").click()
    page.button("Grow").click()
    cells = page.page.locator(".sheet .cell")
    expect(cells).to_have_count(4)
    cells.nth(1).get_by_role("button", name="Cancel", exact=True).click()
    expect(cells.nth(1).get_by_role("button", name="Cancel", exact=True)).to_be_hidden()
    jobs = [page.served.get(f"/api/jobs/{cells.nth(n).locator('.thumb').get_attribute('data-job')}") for n in range(4)]
    assert [job["state"] for job in jobs] == ["queued", "cancelled", "queued", "queued"]
    page.served.let(held)
    for job in jobs[0], *jobs[2:]:
        cell = page.page.locator(f".sheet .cell:has([data-job='{job['id']}'])")
        score = cell.locator(".caption strong")
        expect(score).to_have_text(str(round(_score(page, job["id"]))), timeout=60_000)
        own, box = score.bounding_box(), cell.bounding_box()
        assert own is not None
        assert box is not None
        assert own["width"] > 5
        assert own["x"] + own["width"] <= box["x"] + box["width"]
        assert score.evaluate("s => s.scrollWidth <= s.clientWidth || s.clientWidth === 0")


def _score(page: Desk, job: str) -> float:
    page.until(lambda: page.served.get(f"/api/jobs/{job}")["score"] is not None)
    return float(page.served.get(f"/api/jobs/{job}")["score"])
