"""Painting on the page: labels are exactly those that the pointer drew, and are sent as they are."""

from __future__ import annotations

import base64
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.ndimage import binary_fill_holes
from studio.browser import Desk
from studio.served import opened

from intarsia import read
from intarsia.segments import segments

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect

Places = list[tuple[float, float]]


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
    """How red a stage's labels are shown: another number for each label."""
    shown = page.stage(number).evaluate(
        """s => { const labels = s.layers.length ? s.layers[0].picture : s.picture;
          const {width, height} = labels;
          const pixels = labels.getContext("2d").getImageData(0, 0, width, height).data;
          const reds = pixels.filter((_, n) => n % 4 === 0);
          let text = ""; for (const red of reds) text += String.fromCharCode(red);
          return [width, height, btoa(text)]; }"""
    )
    return np.frombuffer(base64.b64decode(shown[2]), np.uint8).reshape(shown[1], shown[0])


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
    ground = seen[119, 159]
    marked = seen != ground
    assert np.array_equal(marked, drawn((120, 160), places, size_of(paint)) > 0)
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
    marked = seen != seen[119, 159]
    inside = binary_fill_holes(drawn((120, 160), places, size_of(paint)))
    assert np.array_equal(marked, inside)


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
    assert np.array_equal(seen != seen[2047, 2047], drawn((2048, 2048), places, size_of(paint)) > 0)
    paint.page.unroute_all()


def test_labels_are_proposed_from_the_segments_and_taken_back(paint: Desk) -> None:
    paint.button("Propose").click()
    paint.until(lambda: len(np.unique(labels(paint, 0))) > 1)
    exemplar = paint.served.get("/api/exemplars")
    tiles = next(e["id"] for e in exemplar if e["name"] == "tiles")
    found = segments(read("sample:tiles"))
    proposed = opened(paint.served.bytes(f"/api/exemplars/{tiles}/found/labels.png"))
    areas = np.bincount(found.group_map.ravel())
    for number, group in enumerate(np.argsort(-areas, kind="stable")[:6]):
        assert (proposed[found.group_map == group] == number).all()
    assert proposed.max() == min(len(areas), 6) - 1
    paint.stroke((5, 5), (150, 110), number=1)
    paint.radio("Both").click()
    paint.button("Grow").click()
    assert np.array_equal(paint.sent("labels"), proposed)
    assert paint.jobs[0]["options"]["wrap"] == "both"
    paint.grown()
    paint.button("Paint on").click()
    for _ in ("both", "the stroke", "what was proposed"):
        paint.button("Undo").click()
    assert len(np.unique(labels(paint, 0))) == 1


def test_a_label_that_is_marked_nowhere_is_told_before_anything_is_asked_for(paint: Desk) -> None:
    paint.stroke((5, 5), (50, 40), number=1)
    paint.button("Grow").click()
    expect(paint.page.get_by_role("alert")).to_contain_text("Label 2 is wanted, but marked nowhere in the example")
    assert paint.jobs == []
    paint.stroke((20, 20), (200, 150), number=0)
    paint.button("Grow").click()
    paint.grown()
    assert len(paint.jobs) == 1
