"""The gallery on the page: everything made, opened, made again, deleted; and still there after the page was closed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from studio.browser import Desk
from studio.served import QUICK

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


@pytest.fixture
def gallery(page: Desk, small: str) -> Desk:
    """A gallery in which the first is a small result, and the second is another thing; it has fewer than it shows."""
    for job in page.served.get("/api/jobs")[20:]:
        page.served.ended(job)
        page.served.client.delete(f"/api/jobs/{job['id']}").raise_for_status()
    page.served.ended(page.served.job("grow", [small], **QUICK))
    page.sample("tiles")
    page.quick()
    page.page.get_by_label("Seed", exact=True).fill("11")
    page.button("Grow").click()
    page.result = page.grown()
    page.room("Gallery")
    return page


def test_what_was_made_is_kept_and_opened(gallery: Desk) -> None:
    gallery.page.reload()
    first = gallery.page.locator(".made").first
    expect(first.get_by_role("heading", name="tiles")).to_be_visible()
    expect(first).to_contain_text("Square pieces, seed 11")
    first.get_by_role("button", name="Square pieces, seed 11").click()
    assert gallery.grown() == gallery.result


def test_it_is_made_again_with_another_seed(gallery: Desk) -> None:
    gallery.page.locator(".made").first.get_by_role("button", name="Again with another seed").click()
    first = gallery.page.locator(".made").first
    expect(first).not_to_contain_text("seed 11,")
    expect(first.get_by_role("button", name="Delete")).to_be_visible(timeout=60_000)
    old, new = gallery.jobs
    assert new["options"] == old["options"] | {"seed": new["options"]["seed"]}
    assert new["options"]["seed"] != 11


def test_its_settings_are_used_again(gallery: Desk) -> None:
    gallery.page.reload()
    gallery.page.locator(".made").first.get_by_role("button", name="Use these settings").click()
    expect(gallery.page.get_by_label("Seed", exact=True)).to_have_value("11")
    expect(gallery.page.get_by_role("spinbutton", name="Width in px")).to_have_value("96")
    expect(gallery.page.locator(".pick-head")).to_contain_text("image-quilting")


def test_it_is_deleted(gallery: Desk) -> None:
    before = {j["id"]: j["created"] for j in gallery.served.get("/api/jobs")}
    cards = gallery.page.locator(".made")
    count = cards.count()
    cards.first.get_by_role("button", name="Delete").click()
    expect(cards).to_have_count(count - 1)
    cards.first.get_by_role("button", name="Delete").click()
    expect(cards).to_have_count(count - 2)
    gallery.page.get_by_text("2 deleted", exact=True).wait_for()
    gallery.button("Undo").click()
    expect(cards).to_have_count(count)
    expect(gallery.button("Undo")).to_have_count(0)
    cards.first.locator(".thumb img").wait_for()
    assert {j["id"] for j in gallery.served.get("/api/jobs")} == set(before)
    assert gallery.served.get(f"/api/results/{gallery.result}")["files"]
    cards.first.get_by_role("button", name="Delete").click()
    expect(cards).to_have_count(count - 1)
    after = {j["id"] for j in gallery.served.get("/api/jobs")}
    assert set(before) - after == {max(before, key=lambda job: before[job])}


def test_a_page_that_is_closed_after_deleting_brings_nothing_back(gallery: Desk) -> None:
    count = gallery.page.locator(".made").count()
    gallery.page.locator(".made").first.get_by_role("button", name="Delete").click()
    gallery.button("Undo").wait_for()
    gallery.page.reload()
    expect(gallery.page.locator(".made")).to_have_count(count - 1)
    gallery.page.get_by_role("heading", name="Gallery").wait_for()
    expect(gallery.button("Undo")).to_have_count(0)


def test_all_of_it_is_taken(gallery: Desk) -> None:
    with gallery.page.expect_download() as got:
        gallery.page.locator(".made").first.get_by_role("link", name="Download all").click()
    assert got.value.path().read_bytes()[:2] == b"PK"
    assert got.value.suggested_filename == "tiles_grown_image-quilting_s11.zip"  # others do not collide with it
    gallery.room("Grow")
    with gallery.page.expect_download() as got:
        gallery.page.get_by_role("link", name="Download", exact=True).click()
    assert got.value.suggested_filename == "tiles_grown_image-quilting_s11.png"


def test_what_was_softened_has_no_other_seed(gallery: Desk) -> None:
    gallery.room("Grow")
    gallery.page.get_by_role("slider", name="Soften seams").fill("7")
    gallery.page.get_by_role("heading", name="Seams 7 px soft").wait_for()
    gallery.room("Gallery")
    first, second = gallery.page.locator(".made").nth(0), gallery.page.locator(".made").nth(1)
    expect(first).to_contain_text("Seams 7 px soft")
    expect(second.get_by_role("button", name="Again with another seed")).to_have_count(1)
    expect(first.get_by_role("button", name="Again with another seed")).to_have_count(0)


def test_a_result_becomes_an_exemplar(gallery: Desk) -> None:
    gallery.page.locator(".made").first.get_by_role("button", name="Continue from this").click()
    expect(gallery.page.get_by_text("96 × 80", exact=False).first).to_be_visible()


def test_what_was_made_and_judged_before_has_its_score_at_once(gallery: Desk) -> None:
    says = gallery.page.locator(".made").first.locator(".says")
    expect(says).to_contain_text("score", timeout=60_000)
    gallery.room("Grow")
    gallery.button("Grow").click()
    gallery.until(lambda: gallery.grown() == gallery.result)
    gallery.room("Gallery")
    expect(says).to_contain_text("score")


def test_what_ends_with_the_result_that_is_shown_before_its_preview_comes_is_shown(gallery: Desk) -> None:
    """The same picture asked for again is there in a moment: sooner than a preview of it could be fetched."""
    says = gallery.page.locator(".made").first.locator(".says")
    expect(says).to_contain_text("score", timeout=60_000)
    gallery.room("Grow")
    assert gallery.grown() == gallery.result
    ended = """async job => {
      const { store } = await import(new URL("core/store.js", document.scripts[0].src));
      store.seen(job.id, 9);
      store.note({ ...job, state: "running", result: null, score: null });
      await new Promise(requestAnimationFrame);
      store.note(job);
    }"""
    job = gallery.page.url.rpartition("/")[2]
    gallery.page.evaluate(ended, gallery.served.get(f"/api/jobs/{job}"))
    gallery.until(lambda: gallery.grown() == gallery.result)
