"""Painting on the page: labels are exactly those that the pointer drew, and are sent as they are."""

from __future__ import annotations

import base64
import re
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.ndimage import binary_fill_holes, label
from studio.browser import Desk
from studio.served import opened

from intarsia.files.png import encode_png

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect

Places = list[tuple[float, float]]
GREEN = (10, 240, 20, 255)


def drawn(
    shape: tuple[int, int], places: Places, size: int, value: int = 1, on: np.ndarray | None = None
) -> np.ndarray:
    """What a round, hard brush leaves: all pixels whose middle is within half its size of the line."""
    out = np.zeros(shape, np.uint8) if on is None else on.copy()
    middles = [((np.floor(x) + 0.5, np.floor(y) + 0.5) if size % 2 else half_up(x, y)) for x, y in places]
    y, x = np.mgrid[: shape[0], : shape[1]] + 0.5
    for (ax, ay), (bx, by) in pairwise([middles[0], *middles]):
        dx, dy = bx - ax, by - ay
        share = np.clip(((x - ax) * dx + (y - ay) * dy) / max(dx * dx + dy * dy, 1e-12), 0, 1)
        out[(x - ax - share * dx) ** 2 + (y - ay - share * dy) ** 2 <= size * size / 4 + 1e-6] = value
    return out


def half_up(x: float, y: float) -> tuple[float, float]:
    return float(np.floor(x + 0.5)), float(np.floor(y + 0.5))


def labels(page: Desk, number: int) -> np.ndarray:
    """The numbers that are painted on a stage."""
    shown = page.stage(number).evaluate(
        """s => { const {width, height, data} = s.tool.labels();
          let text = ""; for (const value of data) text += String.fromCharCode(value);
          return [width, height, btoa(text)]; }"""
    )
    return np.frombuffer(base64.b64decode(shown[2]), np.uint8).reshape(shown[1], shown[0])


def looks(page: Desk) -> np.ndarray:
    """How the labels that are wanted are drawn, where they are: (H, W, 4)."""
    shown = page.stage(1).evaluate(
        """s => { const {width, height, canvas} = s.tool.labels();
          const pixels = canvas.getContext("2d").getImageData(0, 0, width, height).data;
          let text = ""; for (const byte of pixels) text += String.fromCharCode(byte);
          return [width, height, btoa(text)]; }"""
    )
    return np.frombuffer(base64.b64decode(shown[2]), np.uint8).reshape(shown[1], shown[0], 4)


def two_things() -> np.ndarray:
    """Above what is dark and smooth, below what is bright and rough, and a wavy border between them."""
    rng = np.random.default_rng(5)
    y, x = np.mgrid[:192, :160]
    smooth = 70 + rng.integers(-6, 7, (192, 160, 3)) + np.array([0, 5, 25])
    rough = 150 + 70 * np.sign(np.sin(x / 3) * np.sin(y / 3))[..., None] + rng.integers(-20, 21, (192, 160, 3))
    return np.where(below()[..., None], rough, smooth).clip(0, 255).astype(np.uint8)


def below() -> np.ndarray:
    y, x = np.mgrid[:192, :160]
    return np.asarray(y > 110 + 12 * np.sin(x / 20))


def count(page: Desk, asked: int) -> None:
    page.page.get_by_role("spinbutton", name="How many things").fill(str(asked))


@pytest.fixture
def paint(page: Desk) -> Desk:
    """The room to paint in, with a small target."""
    page.sample("tiles")
    page.room("Paint")
    page.page.get_by_role("spinbutton", name="Width in px").fill("160")
    page.page.get_by_role("spinbutton", name="Height in px").fill("120")
    page.page.get_by_role("heading", name="Wanted").click()
    return page


def brush(page: Desk, size: int) -> None:
    """Make the brush so large: by the slider, then by keys, as a person would."""
    slider = page.page.get_by_role("slider", name="Size of the brush")
    slider.fill(str(round(100 * np.log(size) / np.log(512))))
    page.page.get_by_role("heading", name="Wanted").click()


def size_of(page: Desk) -> int:
    return int((page.page.locator(".brush-size").text_content() or "").split()[0])


def test_what_is_painted_is_sent_exactly_and_grown(paint: Desk) -> None:
    brush(paint, 40)
    size = size_of(paint)
    left = paint.stroke((40, 40), (200, 60), (180, 200), number=0)
    right = paint.stroke((30, 30), (120, 90), number=1)
    paint.page.keyboard.press("3")
    far = paint.stroke((200, 220), (240, 240), number=0)
    paint.button("Grow").click()
    source, target = paint.sent("labels"), paint.sent("target")
    assert np.array_equal(source, drawn((256, 256), far, size, 2, drawn((256, 256), left, size)))
    assert np.array_equal(target, drawn((120, 160), right, size))


def test_a_painting_is_grown(paint: Desk) -> None:
    brush(paint, 120)
    paint.stroke((0, 0), (255, 0), (255, 80), (0, 80), number=0)
    paint.stroke((80, 60), number=1)
    paint.button("Grow").click()
    result = paint.served.get(f"/api/results/{paint.grown()}")
    assert (result["verb"], result["size"]) == ("paint", [160, 120])
    assert set(paint.jobs[0]["options"]) == {"labels", "target"}
    paint.button("Paint on").click()
    expect(paint.page.get_by_role("heading", name="Wanted")).to_be_visible()


def test_another_picture_is_painted_with(page: Desk) -> None:
    """All of it is one label more; undone it is offered again, and a reload keeps it."""
    rng = np.random.default_rng(4)
    moss, sand = (rng.integers(0, 40, (64, 80, 3)) + np.array(c) for c in ((20, 120, 30), (200, 170, 120)))
    page.drop(sand=encode_png(sand.astype(np.uint8)))
    page.page.get_by_role("heading", name="sand").wait_for()
    page.drop(moss=encode_png(moss.astype(np.uint8)))
    page.page.get_by_role("heading", name="moss").wait_for()
    page.room("Paint")
    page.page.get_by_role("spinbutton", name="Width in px").fill("120")
    page.page.get_by_role("spinbutton", name="Height in px").fill("90")
    page.page.get_by_role("heading", name="Wanted").click()
    another = page.page.get_by_label("Add a picture")
    offered = another.locator("option")
    assert {"sand"} <= set(offered.all_text_contents()) - {"moss"}
    hint = page.page.get_by_text("Mark what is what on the left", exact=False)
    expect(hint).to_be_visible()
    another.select_option(label="sand")
    expect(hint).to_have_count(0)
    expect(offered.filter(has_text="sand")).to_have_count(0)
    expect(page.page.get_by_role("button", name="Label 2", exact=True)).to_have_attribute("aria-pressed", "true")
    page.page.keyboard.press("Control+z")
    expect(offered.filter(has_text="sand")).to_have_count(1)
    page.page.keyboard.press("Control+y")
    brush(page, 60)
    page.stroke((60, 45), number=1)
    page.until(lambda: looks(page)[45, 60, 0] > 180)  # it looks like sand
    moss_id = next(row["id"] for row in page.served.get("/api/exemplars") if row["name"] == "moss")
    page.until(lambda: "target" in page.served.get("/api/kept").get(moss_id, {}).get("marks", {}))
    page.page.reload()
    expect(offered.filter(has_text="sand")).to_have_count(0)
    page.button("Grow").click()
    result = page.served.get(f"/api/results/{page.grown()}")
    names = {row["id"]: row["name"] for row in page.served.get("/api/exemplars")}
    assert [names[each] for each in page.jobs[-1]["exemplars"]] == ["moss", "sand"]
    seen = opened(page.served.bytes(page.served.file(result, result["files"][-1]))).astype(int)
    assert seen.shape == (90, 120, 3)
    assert (seen[40:50, 55:65, 0] > 180).all()
    assert (seen[:10, :10, 0] < 80).all()


@pytest.mark.parametrize("steps", [0, 1, 4])
def test_small_brushes_are_exact(paint: Desk, steps: int) -> None:
    slider = paint.page.get_by_role("slider", name="Size of the brush")
    slider.fill("0")
    paint.page.get_by_role("heading", name="Wanted").click()
    for _ in range(steps):
        paint.page.keyboard.press("]")
    assert size_of(paint) == [1, 2, 3, 5, 7][steps]
    places = paint.stroke((20, 20), (90, 47), (31, 100), number=1)
    seen = labels(paint, 1)
    assert np.array_equal(seen > 0, drawn((120, 160), places, size_of(paint)) > 0)
    assert len(np.unique(seen)) == 2


def test_strokes_are_undone_redone_and_erased(paint: Desk) -> None:
    empty = labels(paint, 1)
    paint.stroke((40, 40), (100, 80), number=1)
    once = labels(paint, 1)
    paint.stroke((120, 30), number=1)
    twice = labels(paint, 1)
    assert not np.array_equal(once, twice)
    paint.page.keyboard.press("Control+z")
    assert np.array_equal(labels(paint, 1), once)
    paint.button("Undo").click()
    assert np.array_equal(labels(paint, 1), empty)
    paint.page.keyboard.press("Control+Shift+z")
    paint.button("Redo").click()
    assert np.array_equal(labels(paint, 1), twice)
    paint.page.keyboard.press("e")
    paint.stroke((120, 30), number=1)
    assert np.array_equal(labels(paint, 1), once)


def test_fill_stops_at_what_is_painted(paint: Desk) -> None:
    brush(paint, 8)
    ring: Places = [(40, 40), (100, 40), (100, 90), (40, 90), (40, 40)]
    places = paint.stroke(*ring, number=1)
    paint.button("Fill (F)").click()
    paint.stroke((70, 60), number=1)
    seen = labels(paint, 1)
    inside = binary_fill_holes(drawn((120, 160), places, size_of(paint)))
    assert np.array_equal(seen > 0, inside)


def test_two_fingers_move_and_draw_nothing(paint: Desk) -> None:
    before, how = labels(paint, 1), paint.told(1)
    x, y = paint.at(60, 60, number=1)
    touch = """([s, id, kind, x, y]) => s.dispatchEvent(new PointerEvent(kind, {pointerId: id, pointerType: "touch",
      clientX: x, clientY: y, bubbles: true, button: kind === "pointermove" ? -1 : 0, buttons: 1}))"""
    stage = paint.stage(1).element_handle()
    paint.page.evaluate("s => { s.setPointerCapture = () => {}; }", stage)
    for finger, kind, dx in [
        (5, "pointerdown", 0), (5, "pointermove", 10), (6, "pointerdown", 80), (6, "pointermove", 160),
        (5, "pointerup", 10), (6, "pointerup", 160),
    ]:  # fmt: skip
        paint.page.evaluate(touch, [stage, finger, kind, x + dx, y])
    assert np.array_equal(labels(paint, 1), before)
    assert paint.told(1)["scale"] > how["scale"] * 1.5


def test_strokes_do_not_wait_for_the_server(paint: Desk) -> None:
    paint.page.route("**/api/**", lambda route: None)
    paint.page.get_by_role("spinbutton", name="Width in px").fill("2048")
    paint.page.get_by_role("spinbutton", name="Height in px").fill("2048")
    paint.page.get_by_role("heading", name="Wanted").click()
    brush(paint, 200)
    places = paint.stroke((300, 300), (1500, 900), number=1)
    seen = labels(paint, 1)
    assert np.array_equal(seen > 0, drawn((2048, 2048), places, size_of(paint)) > 0)
    paint.page.unroute_all()


def test_two_things_are_proposed_where_there_are_two_and_taken_back(page: Desk) -> None:
    page.drop(wall=encode_png(two_things()))
    page.page.get_by_role("heading", name="wall").wait_for()
    page.room("Paint")
    page.button("Propose").click()
    expect(page.button("Undo")).to_be_enabled()
    found = labels(page, 0)
    assert set(np.unique(found)) == {0, 1}
    assert [label(found == n)[1] for n in (0, 1)] == [1, 1]
    assert ((found == found[0, 0]) != below()).mean() > 0.97
    count(page, 3)
    page.button("Propose").click()
    page.until(lambda: set(np.unique(labels(page, 0))) == {0, 1, 2})
    page.button("Undo").click()
    assert np.array_equal(labels(page, 0), found)
    page.button("Undo").click()
    assert not labels(page, 0).any()


@pytest.mark.parametrize("asked", ["1", "7", ""])
def test_a_count_that_is_not_allowed_is_told(paint: Desk, asked: str) -> None:
    paint.page.get_by_role("spinbutton", name="How many things").fill(asked)
    paint.button("Propose").click()
    expect(paint.page.get_by_role("alert")).to_contain_text("How many things: ")
    assert not labels(paint, 0).any()


def test_labels_look_as_what_is_marked_with_them(page: Desk) -> None:
    picture = np.zeros((192, 160, 3), np.uint8)
    picture[:, :, 0], picture[:, :, 2] = np.arange(160), np.arange(192)[:, None]
    picture[100:] = GREEN[:3]
    page.drop(wall=encode_png(picture))
    page.page.get_by_role("heading", name="wall").wait_for()
    page.room("Paint")
    brush(page, 120)
    page.stroke((160, 200), number=1)
    marked = labels(page, 1) == 1
    assert len(np.unique(looks(page)[marked], axis=0)) == 1  # it is marked nowhere: a colour
    flat = looks(page)[marked][0].tolist()
    brush(page, 20)
    page.stroke((30, 140), (120, 140), (120, 170), (30, 170), number=0)
    page.until(lambda: looks(page)[marked][0].tolist() != flat)
    shown = looks(page)
    assert np.abs(shown[marked].astype(int) - GREEN).max() <= 2
    corner = shown[:60, :60].astype(int)  # of the largest square that is not marked
    assert (np.diff(corner[50, :, 0])[-8:] == 1).all()
    assert (np.diff(corner[:, 50, 2])[-8:] == 1).all()
    swatch = page.button("Label 2").locator("canvas")
    script = "c => [...c.getContext('2d').getImageData(0, 0, 1, 1).data]"
    assert np.abs(np.array(swatch.evaluate(script)) - GREEN).max() <= 2
    page.button("Undo").click()
    page.until(lambda: looks(page)[marked][0].tolist() == flat)


def test_names_of_labels_stay_are_said_and_taken_back(paint: Desk) -> None:
    name = paint.page.get_by_role("textbox", name="Name of label 2")
    name.fill("Grout")
    name.press("Enter")
    expect(paint.button("Grout")).to_have_attribute("title", "Grout (2)")
    paint.stroke((5, 5), (50, 40), number=1)
    paint.button("Grow").click()
    expect(paint.page.get_by_role("alert")).to_contain_text("Grout is wanted, but marked nowhere in the example")
    expect(paint.page.get_by_role("status").filter(has_text="Grout is wanted")).to_be_visible()
    tiles = next(e["id"] for e in paint.served.get("/api/exemplars") if e["name"] == "tiles")
    paint.until(lambda: paint.served.get("/api/kept").get(tiles, {}).get("names") == {"1": "Grout"})
    paint.page.reload()
    expect(name).to_have_value("Grout")
    name.fill("Mortar")
    name.press("Enter")
    expect(paint.button("Mortar")).to_be_visible()
    paint.button("Undo").click()
    expect(name).to_have_value("Grout")
    paint.button("Redo").click()
    expect(name).to_have_value("Mortar")


def test_a_stroke_brings_a_first_look_and_the_next_one_lies_over_it(paint: Desk) -> None:
    seen = paint.page.get_by_role("status").filter(has_text=re.compile("^A (first|closer) look"))
    brush(paint, 60)
    paint.stroke((60, 60), (180, 200), number=0)
    expect(seen).to_be_visible()
    assert paint.told(1)["layers"] == 1
    assert not looks(paint)[..., 3].any()
    first = paint.seen(1)
    paint.page.route("**/api/drafts", lambda route: None)
    paint.stroke((40, 60), (100, 60), number=1)
    assert np.array_equal(looks(paint)[..., 3] == 255, labels(paint, 1) == 1)
    paint.page.unroute_all()
    paint.stroke((40, 80), number=1)
    expect(seen).to_be_visible()
    paint.until(lambda: not looks(paint)[..., 3].any())
    assert not np.array_equal(paint.seen(1), first)
    paint.radio("Labels").click()
    assert paint.told(1)["layers"] == 0
    assert looks(paint)[..., 3].all()
    paint.radio("Result").click()
    assert paint.told(1)["layers"] == 1
    assert paint.jobs == []


def test_a_label_that_is_marked_nowhere_is_told_before_anything_is_asked_for(paint: Desk) -> None:
    paint.stroke((5, 5), (50, 40), number=1)
    paint.button("Grow").click()
    expect(paint.page.get_by_role("alert")).to_contain_text("Label 2 is wanted, but marked nowhere in the example")
    assert paint.jobs == []
    paint.stroke((20, 20), (200, 150), number=0)
    paint.button("Grow").click()
    paint.grown()
    assert len(paint.jobs) == 1
