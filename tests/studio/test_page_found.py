"""What was found, on the page: overlays are switched, the exemplar is cropped, parts are avoided."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np
import pytest
from studio.browser import Desk
from studio.served import opened
from studio.test_page_paint import drawn

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


@pytest.fixture
def found(page: Desk) -> Desk:
    """The room that tells what was found."""
    page.sample("tiles")
    page.room("Inspect")
    page.page.get_by_role("heading", name="Automatic takes").wait_for(timeout=60_000)
    return page


def test_what_was_found_is_told_and_drawn(found: Desk) -> None:
    exemplar = next(e for e in found.served.get("/api/exemplars") if e["name"] == "tiles")
    told = found.served.get(f"/api/exemplars/{exemplar['id']}/found")
    panel = found.page.get_by_role("complementary", name="Seen in the example")
    expect(panel).not_to_contain_text("lattice")
    expect(panel).not_to_contain_text("exemplar")
    expect(panel.get_by_text("It repeats every 64 × 64 px.", exact=True)).to_be_visible()
    panel.get_by_text("How it was measured").click()
    for line in told["suggested"]["why"] + told["lattice"]["reasons"]:
        plain_line = line.replace("exemplar", "example").replace("lattice", "grid").replace("periods", "tiles")
        expect(panel.get_by_text(plain_line, exact=True)).to_be_visible()
    plain = found.seen()
    found.page.get_by_role("switch", name="Repeating grid").click()
    expect(panel.get_by_text("64 × 64 px", exact=True)).to_be_visible()
    found.until(lambda: found.told()["layers"] == 1 and not found.same(plain))
    found.page.get_by_role("switch", name="Repeating grid").click()
    found.until(lambda: found.same(plain))
    found.page.get_by_role("button", name=re.compile("^Grow with ")).click()
    expect(found.page.locator(".pick-head")).to_contain_text(told["suggested"]["method"])


def test_the_exemplar_is_cropped(found: Desk) -> None:
    found.radio("Crop").click()
    (ax, ay), (bx, by) = (tuple(round(v) for v in place) for place in found.stroke((30, 40), (130, 104)))
    before = found.served.get("/api/exemplars")
    told = found.page.locator(".stage:visible canvas")
    expect(told).to_have_attribute("aria-label", "Example tiles")
    found.button("Crop").click()
    found.until(lambda: len(found.served.get("/api/exemplars")) > len(before))
    after = found.served.get("/api/exemplars")
    new = next(e for e in after if e["id"] not in [b["id"] for b in before])
    old = next(e for e in before if e.get("sample") == "tiles")
    whole, part = (opened(found.served.plane(e)) for e in (old, new))
    assert np.array_equal(part, whole[ay:by, ax:bx])
    found.until(lambda: (found.told()["width"], found.told()["height"]) == (bx - ax, by - ay))


def test_what_is_avoided_is_never_shown(found: Desk) -> None:
    found.radio("Avoid").click()
    places = found.stroke((64, 64), (128, 64))
    usable = drawn((256, 256), places, 32, 255) == 0
    found.room("Grow")
    found.quick()
    found.button("Grow").click()
    result = found.grown()
    assert np.array_equal(found.sent("mask"), np.where(usable, 255, 0))
    came = np.frombuffer(found.served.bytes(f"/api/results/{result}/map.bin"), "<u2").reshape(80, 96, 3)
    assert usable[came[..., 1], came[..., 2]].all()
