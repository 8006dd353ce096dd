"""Looking at a result on the page: zoom and pan, what is laid over it, where a pixel came from, the score."""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image
from studio.browser import Desk, desk
from studio.served import Served, opened, pixels, png

import intarsia as ia
from intarsia.rendering.render import render

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


@pytest.fixture
def look(page: Desk) -> Desk:
    """A small result on the stage."""
    page.sample("tiles")
    page.quick()
    page.button("Grow").click()
    page.result = page.grown()
    return page


def test_wheel_keys_and_drag_move_the_view(look: Desk) -> None:
    how = look.told()
    x, y = look.at(30, 20)
    look.page.mouse.move(x, y)
    look.page.mouse.wheel(0, -300)
    look.page.wait_for_timeout(200)
    zoomed = look.told()
    assert zoomed["scale"] > 1.5 * how["scale"]
    assert look.at(30, 20) == (pytest.approx(x, abs=1), pytest.approx(y, abs=1))
    look.page.mouse.down()
    look.page.mouse.move(x + 40, y - 25)
    look.page.mouse.up()
    moved = look.told()
    assert (moved["x"] - zoomed["x"], moved["y"] - zoomed["y"]) == (40, -25)
    look.page.keyboard.press("ArrowRight")
    assert look.told()["x"] == moved["x"] - 50
    look.page.keyboard.press("1")
    assert look.told()["scale"] == 1
    look.page.keyboard.press("0")
    assert look.told() == how


def test_every_look_is_laid_over_the_picture(look: Desk) -> None:
    plain = look.seen()
    for name in ("Pieces", "Seams", "How often", "Where from"):
        look.radio(name).click()
        expect(look.page.locator(".corner.low.left")).not_to_have_text("…", timeout=30_000)
        assert look.told()["layers"] == 1, name
        assert not np.array_equal(look.seen(), plain), name
    look.radio("Picture").click()
    assert look.told()["layers"] == 0
    assert np.array_equal(look.seen(), plain)


def test_looks_stay_below_the_stage_of_a_narrow_page(look: Desk) -> None:
    look.page.set_viewport_size({"width": 820, "height": 1180})
    expect(look.radio("Seams")).to_be_visible()
    bar, looks = (look.page.locator(f"{place}:visible").bounding_box() for place in (".stage-bar", ".looks"))
    assert bar is not None
    assert looks is not None
    assert looks["x"] + looks["width"] <= bar["x"] + bar["width"]


def test_the_pointer_shows_where_a_pixel_came_from(look: Desk) -> None:
    came = np.frombuffer(look.served.bytes(f"/api/results/{look.result}/map.bin"), "<u2").reshape(80, 96, 3)
    look.page.mouse.move(*look.at(10.5, 10.5))
    look.page.wait_for_timeout(500)
    look.page.mouse.move(*look.at(50.5, 33.5))
    _, row, column = came[33, 50]
    expect(look.page.locator(".corner.low.right")).to_have_text(f"50, 33  from  {column}, {row}")
    mark = look.page.locator(".source-mark").bounding_box()
    picture = look.page.get_by_role("img", name="Example tiles").last.bounding_box()
    assert mark is not None
    assert picture is not None
    assert mark["x"] + 8.5 == pytest.approx(picture["x"] + (column + 0.5) / 256 * picture["width"], abs=1.5)
    assert mark["y"] + 8.5 == pytest.approx(picture["y"] + (row + 0.5) / 256 * picture["height"], abs=1.5)
    look.page.mouse.move(5, 5)
    expect(look.page.locator(".source-mark")).to_be_hidden()


def test_the_score_tells_its_parts(look: Desk) -> None:
    look.page.get_by_role("button", name="score").click(timeout=60_000)
    score = look.served.get(f"/api/results/{look.result}")["score"]
    parts = look.page.get_by_role("group", name="What takes most away")
    losses = sorted((part["loss"] for part in score["parts"].values() if part["loss"] >= 0.5), reverse=True)
    expect(parts.locator("li .number")).to_have_text([f"−{round(loss)}" for loss in losses])
    expect(look.page.get_by_role("button", name=f"score {score['total']:.0f}")).to_be_visible()
    look.page.keyboard.press("Escape")
    expect(parts).to_be_hidden()


WORDS = {
    "Clean": (94, {"joins": 6}),
    "Some seams": (72, {"joins": 20, "repeats": 8}),
    "Strong repeats": (50, {"joins": 20, "repeats": 30}),
    "Very strong blur": (12, {"blurred": 50, "joins": 38}),
    "Another texture": (3, {"texture": 97}),
}


@pytest.mark.parametrize("words", WORDS)
def test_a_score_is_told_in_words(look: Desk, words: str) -> None:
    total, losses = WORDS[words]
    parts = {name: {"worth": 0.0, "loss": loss, "weight": 0.1} for name, loss in losses.items()}
    row = look.served.get(f"/api/results/{look.result}") | {"score": {"total": total, "verdict": "", "parts": parts}}
    look.page.route(f"**/api/results/{look.result}", lambda route: route.fulfill(json=row))
    look.page.reload()
    expect(look.page.get_by_role("button", name=f"{words}, score {total}", exact=True)).to_be_visible(timeout=60_000)


def test_places_are_marked_gone_to_and_repaired(page: Desk) -> None:
    page.sample("stones")
    page.quick()
    page.page.get_by_role("spinbutton", name="Width in px").fill("128")
    page.page.get_by_role("spinbutton", name="Height in px").fill("112")
    page.button("Grow").click()
    result = page.grown()
    places = [*page.served.get(f"/api/results/{result}/places")["joins"], [70, 60, 40]]
    page.page.route("**/places", lambda route: route.fulfill(json={"joins": places}))
    page.page.get_by_role("button", name="score").click(timeout=60_000)
    page.page.get_by_role("button", name="Show: Seams show").click(timeout=60_000)
    bar = page.page.get_by_role("group", name="Marked places")
    expect(bar).to_contain_text(re.compile(f"in {len(places)} place"))
    expect(bar.locator(".segments button")).to_have_count(len(places))
    expect(page.button("Repair here")).to_be_disabled()
    x, y, side = places[0]
    how = page.told()
    left, top = round(how["x"] + x * how["scale"]), round(how["y"] + y * how["scale"])
    marked = page.seen()
    assert (marked[top + 5 : top + 15, left + 4 : left + 6] == (0, 0, 0, 255)).all()  # the ground of its number
    page.page.mouse.click(*page.at(x + side / 2, y + side / 2))
    expect(page.button("Place 1")).to_have_attribute("aria-pressed", "true")
    seen, size = page.told(), page.seen().shape
    assert seen["scale"] == pytest.approx(min(size[:2]) / (4 * side), rel=1e-3)
    assert seen["x"] + (x + side / 2) * seen["scale"] == pytest.approx(size[1] / 2, abs=1)
    assert seen["y"] + (y + side / 2) * seen["scale"] == pytest.approx(size[0] / 2, abs=1)
    page.button("Repair here").click()
    hole = page.sent("mask", 2) > 0
    expect(page.page.get_by_role("heading", name="Healed")).to_be_visible(timeout=60_000)
    page.page.get_by_role("link", name="Download", exact=True).wait_for(timeout=60_000)
    mended = page.grown()
    assert mended != result
    first, last = page.jobs
    assert (last["verb"], last["options"]["from"]) == ("heal", first["exemplars"])
    assert hole[round(y + side / 2), round(x + side / 2)]
    before, after = (whole(page.served, name) for name in (result, mended))
    assert np.array_equal(before[~hole], after[~hole])
    steps = page.page.get_by_role("navigation", name="Steps").get_by_role("button")
    expect(steps).to_have_text(["stones", "Square pieces, seed 0", "Healed, seed 0"])
    expect(bar.locator(".segments button")).to_have_count(len(places) - 1)  # repairing goes on
    page.button("Compare").click()  # with the step before
    expect(page.page.get_by_text("before: Square pieces")).to_be_visible()


def whole(served: Served, result: str) -> np.ndarray:
    """The picture of a result."""
    row = served.get(f"/api/results/{result}")
    return opened(served.files(row)[row["pictures"][0]])


@pytest.fixture
def pieced(page: Desk) -> Desk:
    """A result of several pieces on the stage."""
    page.sample("stones")
    page.quick()
    page.page.get_by_role("spinbutton", name="Width in px").fill("192")
    page.page.get_by_role("spinbutton", name="Height in px").fill("160")
    page.button("Grow").click()
    page.result = page.grown()
    return page


def softness(pieced: Desk) -> Locator:
    """The slider of softness."""
    return pieced.page.get_by_role("slider", name="Soften seams")


def softened(pieced: Desk, px: int) -> str:
    """Wait until what is on the stage is so soft; its id."""
    expect(pieced.page.get_by_role("heading", name=f"Seams {px} px soft" if px else "Exact copies")).to_be_visible()
    return pieced.grown()


def test_softness_only_draws_again(pieced: Desk) -> None:
    grown = pieced.served.get(f"/api/results/{pieced.result}")
    expect(softness(pieced)).to_have_value(str(grown["told"]["blend"]["feather"]))
    pieced.button("100 %").click()
    before, how = pieced.seen(), pieced.told()
    softness(pieced).fill("12")
    soft = softened(pieced, 12)
    expect(softness(pieced)).to_have_attribute("aria-valuetext", "12 px")
    first, job = pieced.jobs
    assert job == {"verb": "render", "exemplars": first["exemplars"], "options": {"map": pieced.result, "feather": 12}}
    assert pieced.told() == how
    assert not np.array_equal(pieced.seen(), before)
    made = pieced.served.get(f"/api/results/{soft}")
    assert {file["holds"] for file in made["files"]} == {"albedo"}
    seen = np.asarray(Image.open(pieced.served.folder / "results" / soft / made["files"][0]["name"]).convert("RGB"))
    smap = ia.SourceMap.load(pieced.served.folder / "results" / pieced.result / "map.npz")
    drawn = render([ia.read("sample:stones")], smap, blend=smap.blend.but(feather=12)).pixels
    assert np.array_equal(seen, drawn)
    pieced.button("Command").click()
    line = pieced.page.evaluate("navigator.clipboard.readText()")
    assert line == "intarsia render map.npz -o stones_rendered.png --feather=12 --exemplar=sample:stones"
    with pieced.page.expect_download() as got:
        pieced.page.get_by_role("link", name="Download", exact=True).click()
    assert got.value.path().read_bytes() == pieced.served.bytes(pieced.served.file(made, made["files"][0]))
    assert got.value.suggested_filename == "stones_rendered_f12.png"  # other softness, other name


def test_softness_goes_by_keys_to_exact_copies_and_back(pieced: Desk) -> None:
    softness(pieced).fill("1")
    softened(pieced, 1)
    softness(pieced).press("ArrowLeft")
    hard = softened(pieced, 0)
    came = np.frombuffer(pieced.served.bytes(f"/api/results/{pieced.result}/map.bin"), "<u2").reshape(160, 192, 3)
    exemplar = ia.read("sample:stones").base.pixels
    name = pieced.served.get(f"/api/results/{hard}")["files"][0]["name"]
    seen = np.asarray(Image.open(pieced.served.folder / "results" / hard / name).convert("RGB"))
    assert np.array_equal(seen, exemplar[came[..., 1], came[..., 2]])
    softness(pieced).press("ArrowRight")
    softened(pieced, 1)
    assert [job["verb"] for job in pieced.jobs] == ["grow", "render", "render"]  # what was drawn before is shown again


def test_what_was_softened_tells_whose_pieces_it_has(pieced: Desk) -> None:
    softness(pieced).fill("5")
    softened(pieced, 5)
    expect(pieced.page.get_by_role("radiogroup", name="Look at").get_by_role("radio")).to_have_text(
        ["Picture", "Pieces", "How often", "Where from"]
    )
    plain = pieced.seen()
    pieced.radio("Pieces").click()
    expect(pieced.page.locator(".corner.low.left")).to_have_text("Each colour is one piece, copied whole")
    assert not np.array_equal(pieced.seen(), plain)
    pieced.page.mouse.move(*pieced.at(10.5, 10.5))
    pieced.page.wait_for_timeout(300)
    pieced.page.mouse.move(*pieced.at(50.5, 33.5))
    expect(pieced.page.locator(".corner.low.right")).to_contain_text("50, 33  from  ")


def test_an_exemplar_has_no_softness(page: Desk) -> None:
    page.sample("tiles")
    page.stage().wait_for()
    expect(softness(page)).to_be_hidden()


def test_the_report_is_taken(look: Desk) -> None:
    look.button("More to take").click()  # it stays open when the score comes
    look.page.get_by_role("button", name="score").wait_for(timeout=60_000)
    with look.page.expect_download(timeout=60_000) as got:
        look.button("Report").click()
    assert got.value.suggested_filename == "tiles_grown_image-quilting_report.html"
    text = got.value.path().read_text("utf-8")
    assert text.encode() == look.served.bytes(f"/api/results/{look.result}/report.html")
    assert text.startswith("<!DOCTYPE html>")
    assert "exemplars/" not in text
    assert "sample:tiles" in text
    expect(look.button("Report")).to_be_visible()


def test_a_preview_that_is_gone_when_it_is_asked_for_is_no_error(page: Desk) -> None:
    page.page.route("**/preview.png?*", lambda route: route.fulfill(status=204))
    page.sample("pebbles")
    page.button("3 times the example").click()
    page.button("Grow").click()
    page.grown()
    expect(page.page.locator(".toast")).to_have_count(0)


@pytest.fixture(scope="module")
def long(served: Served) -> Served:
    """A result that is longer than what a page loads at once."""
    name = served.exemplar(grain=png(pixels(96, 128)))["id"]
    served.long = served.done("grow", [name], method="random-tiling", size="6000x1200")
    return served


@pytest.mark.parametrize("ratio", [1, 2])
def test_a_large_result_is_seen_pixel_for_pixel(browser: Browser, long: Served, ratio: int) -> None:
    whole = opened(long.files(long.long)["grain_grown.png"])
    assert whole.shape == (1200, 6000, 3)
    with desk(browser, long, device_scale_factor=ratio) as page:
        page.page.get_by_role("button", name="grain").first.click()
        page.page.locator(".strip .thumb").first.click()
        page.grown()
        assert (page.told()["width"], page.told()["height"]) == (6000, 1200)
        page.button("100 %").click()
        expect(page.page.locator(".zoom:visible")).to_have_text("100 %")
        box = page.stage().bounding_box()
        assert box is not None
        place = page.page.locator(".corner.low.right")
        for n in range(2):
            x, y = round(box["x"] + box["width"] / 2) + 37 * n, round(box["y"] + box["height"] / 2) + 21 * n
            page.page.mouse.move(x, y)
            expect(place).to_contain_text("from", timeout=30_000)
            frames = "for (let n = 0; n < 900 && !s.parts[0].settled; n += 1) await new Promise(requestAnimationFrame);"
            page.stage().evaluate(f"async s => {{ {frames} }}")
            column, row, b, a = map(int, re.findall(r"\d+", place.inner_text()))
            clip = {"x": x, "y": y, "width": 1, "height": 1}
            seen = np.asarray(Image.open(io.BytesIO(page.page.screenshot(clip=clip))).convert("RGB"))
            assert np.array_equal(seen[0, 0], whole[row, column])
            assert np.array_equal(pixels(96, 128)[a, b], whole[row, column])
            page.page.mouse.down()
            page.page.mouse.move(x - 311, y + 53)
            page.page.mouse.up()


def test_what_is_of_another_size_is_not_compared(look: Desk) -> None:
    look.page.get_by_role("spinbutton", name="Width in px").fill("90")
    look.button("Grow").click()
    expect(look.page.locator(".names p")).to_contain_text("90 × 80")
    look.button("Compare").click()
    same = look.page.get_by_role("alert")
    if look.told()["other"]:  # another test has grown one of this size
        look.page.locator(".strip .thumb").nth(1).click()
        expect(same).to_contain_text("compare two of the same size")
    else:
        expect(same).to_have_text("Grow another one of this size first, to compare with.")
        assert not look.told()["other"]
