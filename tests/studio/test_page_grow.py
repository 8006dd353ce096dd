"""Growing on the page: an exemplar comes in, one button, the picture; settings, variants, two side by side."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np
import pytest
from studio.browser import Desk
from studio.served import opened, pixels, png

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


def test_a_sample_is_opened_and_one_button_grows_it(page: Desk) -> None:
    page.sample("tiles")
    page.button("Grow").click()
    result = page.served.get(f"/api/results/{page.grown()}")
    assert page.jobs == [{"verb": "grow", "exemplars": result["exemplars"], "options": {}}]
    assert [page.told()["width"], page.told()["height"]] == result["size"]
    with page.page.expect_download() as got:
        page.page.get_by_role("link", name="Download", exact=True).click()
    picture = next(e for e in result["files"] if e["holds"] == "albedo")
    assert got.value.path().read_bytes() == page.served.bytes(page.served.file(result, picture))


def test_the_stage_shows_the_very_pixels_of_the_result(page: Desk) -> None:
    page.sample("tiles")
    page.quick()
    page.button("Grow").click()
    result = page.served.get(f"/api/results/{page.grown()}")
    page.button("100 %").click()
    how, seen = page.told(), page.seen()
    assert how["scale"] == 1
    picture = next(e for e in result["files"] if e["holds"] == "albedo")
    whole = opened(page.served.bytes(page.served.file(result, picture)))
    assert whole.shape == (80, 96, 3)
    assert np.array_equal(seen[how["y"] : how["y"] + 80, how["x"] : how["x"] + 96, :3], whole)
    page.button("3 × 3").click()
    how, seen = page.told(), page.seen()
    assert (how["tiles"], how["scale"]) == (3, 1)
    assert np.array_equal(seen[how["y"] :, how["x"] :, :3][:240, :288], np.tile(whole, (3, 3, 1)))


def test_files_are_dropped_pasted_and_picked(page: Desk) -> None:
    page.drop(dropped=png(pixels(seed=1)))
    expect(page.page.get_by_role("heading", name="dropped")).to_be_visible()
    with page.page.expect_file_chooser() as asked:
        page.button("Open another").click()
    asked.value.set_files({"name": "picked.png", "mimeType": "image/png", "buffer": png(pixels(seed=2))})
    expect(page.page.get_by_role("heading", name="picked")).to_be_visible()
    page.page.evaluate(
        """bytes => {
          const data = new DataTransfer();
          data.items.add(new File([new Uint8Array(bytes)], "pasted.png", {type: "image/png"}));
          document.body.dispatchEvent(new ClipboardEvent("paste", {clipboardData: data, bubbles: true}));
        }""",
        list(png(pixels(seed=3))),
    )
    expect(page.page.get_by_role("heading", name="pasted")).to_be_visible()


def test_planes_that_are_dropped_together_are_one_exemplar(page: Desk) -> None:
    page.drop(wall_albedo=png(pixels()), wall_height=png(pixels()[..., 0]))
    expect(page.page.locator(".planes li")).to_have_text(["Albedo", "Height"])


def test_a_job_is_cancelled(page: Desk) -> None:
    page.sample("pebbles")
    page.button("8 times the example").click()
    page.button("Grow").click()
    expect(page.page.get_by_role("progressbar")).to_be_visible()
    page.button("Cancel").click()
    expect(page.page.get_by_role("alert")).to_have_text("Cancelled")
    expect(page.button("Again")).to_be_visible()


def test_settings_are_sent_undone_and_redone(page: Desk) -> None:
    page.sample("tiles")
    page.quick()
    page.page.get_by_role("group").filter(has_text="Options of").first.locator("summary").click()
    page.page.get_by_role("spinbutton", name="Tolerance", exact=True).fill("0.3")
    page.page.get_by_label("Search").select_option("exact")
    page.radio("Both").click()
    page.button("Another seed").click()
    seed = int(page.page.get_by_label("Seed", exact=True).input_value())
    page.button("Undo").click()
    assert page.page.get_by_label("Seed", exact=True).input_value() == ""
    page.button("Redo").click()
    page.button("Grow").click()
    page.grown()
    assert page.jobs[0]["options"] == {
        "method": "image-quilting", "size": "96x80", "tolerance": 0.3, "search": "exact", "wrap": "both", "seed": seed,
    }  # fmt: skip


def test_every_parameter_of_a_method_has_a_field(page: Desk) -> None:
    page.sample("tiles")
    page.quick()
    page.page.get_by_role("group").filter(has_text="Options of").first.locator("summary").click()
    methods = page.served.get("/api/schema")["methods"]
    for told in next(m["parameters"] for m in methods if m["slug"] == "image-quilting"):
        field = page.page.locator(f"#option-{told['name']}")
        expect(field).to_be_visible()
        if told["kind"] in ("int", "float") and told["high"] is not None:
            assert float(field.get_attribute("max") or "") == told["high"]
    field = page.page.get_by_label("Boundary patch")
    field.fill("65537")
    assert field.evaluate("f => f.matches(':invalid')")
    field.fill("64")
    page.button("Grow").click()
    page.grown()
    assert page.jobs[0]["options"]["boundary_patch"] == 64


def test_escape_closes_the_list_of_methods(page: Desk) -> None:
    page.sample("tiles")
    page.page.locator(".pick-head").click()
    methods = page.page.get_by_role("radiogroup", name="Method")
    expect(methods).to_be_visible()
    page.page.keyboard.press("Escape")
    expect(methods).to_be_hidden()


def test_a_refused_job_says_why(page: Desk) -> None:
    page.sample("tiles")
    page.quick()
    page.page.get_by_role("group").filter(has_text="Options of").first.locator("summary").click()
    page.page.locator("#option-patch").fill("1000")
    page.button("Grow").click()
    expect(page.page.get_by_role("alert")).to_contain_text("patch")
    page.wrong.clear()


def test_variants_make_a_contact_sheet(page: Desk) -> None:
    sheet = page.variants()
    expect(sheet.get_by_role("button", name=re.compile("seed . , Done|seed ., Done"))).to_have_count(4, timeout=120_000)
    assert [job["options"].get("seed", 0) for job in page.jobs] == [0, 1, 2, 3]
    sheet.get_by_role("button", name="seed 2").click()
    page.grown()
    expect(page.page.get_by_role("heading", name="Square pieces, seed 2")).to_be_visible()
    page.button("Sheet").click()
    expect(sheet).to_be_visible()


def test_two_results_are_compared(page: Desk) -> None:
    page.sample("tiles")
    page.quick()
    page.page.get_by_label("Seed", exact=True).fill("5")
    page.button("Grow").click()
    page.grown()
    page.page.get_by_label("Seed", exact=True).fill("6")
    page.button("Grow").click()
    page.page.get_by_role("heading", name="seed 6").wait_for()
    page.grown()
    page.button("Compare").click()
    slider = page.page.get_by_role("slider", name="Divider between A and B")
    expect(slider).to_be_visible()
    x, y = page.at(48, 40)
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    page.page.mouse.move(*page.at(24, 40))
    page.page.mouse.up()
    assert page.told()["divider"] == pytest.approx(0.25, abs=0.02)
    slider.press("ArrowRight")
    assert page.told()["divider"] == pytest.approx(0.27, abs=0.02)
    page.button("Compare").click()
    expect(slider).to_be_hidden()
    assert not page.told()["other"]


def test_the_command_is_copied(page: Desk) -> None:
    page.sample("tiles")
    page.quick()
    page.button("Grow").click()
    result = page.served.get(f"/api/results/{page.grown()}")
    page.button("Command").click()
    expect(page.page.get_by_role("status").filter(has_text="copied")).to_have_text("Command copied")
    assert page.page.evaluate("navigator.clipboard.readText()") == result["command"]


def test_growing_goes_on_from_a_result_with_all_its_planes(page: Desk) -> None:
    page.drop(wall_albedo=png(pixels()), wall_normal_dx=png(pixels(seed=3)))
    page.page.get_by_role("heading", name="wall").wait_for()
    page.quick()
    page.button("Grow").click()
    page.grown()
    page.button("Continue from this").click()
    expect(page.page.get_by_role("heading", name="wall_grown")).to_be_visible()
    expect(page.page.locator(".planes li")).to_have_text(["Albedo", "Normal"])
    expect(page.page.get_by_role("heading", name="Example", exact=True)).to_be_visible()
    assert (page.told()["width"], page.told()["height"]) == (96, 80)
    row = page.served.get("/api/exemplars")[-1]
    assert row["planes"][1]["normals"] == "dx"
    page.button("Grow").click()
    page.grown()
    assert page.jobs[-1]["exemplars"] == [row["id"]]


def test_the_stage_shows_what_belongs_to_the_exemplar(page: Desk) -> None:
    page.sample("stones")
    page.page.get_by_role("link", name="intarsia studio: begin").click()
    page.sample("tiles")
    page.quick()
    page.button("Grow").click()
    page.grown()
    page.button("Use stones").click()
    expect(page.stage().get_by_role("img")).to_have_attribute("aria-label", "Example stones")
    page.page.get_by_role("link", name="intarsia studio: begin").click()
    before = page.page.get_by_role("region", name="Opened before")
    before.get_by_role("button", name="tiles", exact=True).first.click()
    expect(page.page.get_by_role("heading", name="tiles", exact=True)).to_be_visible()
    expect(page.page.get_by_role("heading", name="Example", exact=True)).to_be_visible()
    expect(page.stage().get_by_role("img")).to_have_attribute("aria-label", "Example tiles")


def test_so_often_the_exemplar_stays_so_when_another_one_comes(page: Desk) -> None:
    page.drop(wide=png(pixels(32, 48)))
    page.page.get_by_role("heading", name="wide", exact=True).wait_for()
    width, height = (page.page.get_by_role("spinbutton", name=f"{side} in px") for side in ("Width", "Height"))
    expect(page.button("2 times the example")).to_have_attribute("aria-pressed", "true")
    page.button("3 times the example").click()
    expect(page.button("3 times the example")).to_have_attribute("aria-pressed", "true")
    assert [width.get_attribute("placeholder"), height.get_attribute("placeholder")] == ["144", "96"]
    page.drop(high=png(pixels(40, 20)))
    page.page.get_by_role("heading", name="high", exact=True).wait_for()
    expect(width).to_have_attribute("placeholder", "60")
    page.button("Grow").click()
    expect(page.page.locator(".strip .thumb")).to_have_count(1)
    assert page.jobs[-1]["options"] == {"size": "60x120"}
    width.fill("70")
    expect(page.button("3 times the example")).to_have_attribute("aria-pressed", "false")
    page.button("2 times the example").click()
    expect(width).to_have_value("")


def test_one_side_that_is_typed_is_a_square_and_the_other_is_typed_after_it(page: Desk) -> None:
    page.sample("tiles")
    page.quick()
    page.button("2 times the example").click()
    wide, high = (page.page.get_by_role("spinbutton", name=f"{side} in px") for side in ("Width", "Height"))
    wide.press_sequentially("96")
    expect(high).to_have_value("")
    expect(high).to_have_attribute("placeholder", "96")
    page.button("Grow").click()
    page.grown()
    high.press_sequentially("64")
    expect(wide).to_have_value("96")
    page.button("Grow").click()
    page.until(lambda: len(page.jobs) == 2)
    assert [job["options"]["size"] for job in page.jobs] == ["96x96", "96x64"]


def test_a_size_that_is_not_allowed_is_refused(page: Desk) -> None:
    page.sample("tiles")
    page.page.get_by_role("spinbutton", name="Width in px").fill("99999")
    page.button("Grow").click()
    said = "Width in px: 99999 is not allowed; give a whole number from 1 to 65536."
    expect(page.page.get_by_role("alert")).to_have_text(said)
    page.room("Paint")
    page.button("8 times the example").click()
    page.page.get_by_role("spinbutton", name="Width in px").fill("8200")
    page.button("Grow").click()
    expect(page.page.get_by_role("alert")).to_contain_text("8200x8200 cannot be painted")
    page.room("Mend")
    page.radio("Extend").click()
    page.page.get_by_label("Left", exact=True).fill("9000")
    page.button("Extend").click()
    expect(page.page.get_by_role("alert")).to_contain_text("Left: 9000 is not allowed")
    assert page.jobs == []
