"""Undo in every room, and keys of the stage: by keys, wherever the focus is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from studio.browser import Desk
from studio.served import pixels, png

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


@pytest.fixture
def tiles(page: Desk) -> Desk:
    page.sample("tiles")
    return page


def keys(page: Desk, *pressed: str) -> None:
    for key in pressed:
        page.page.keyboard.press(key)


def test_keys_move_the_stage_while_a_button_has_the_focus_and_the_readout_follows(tiles: Desk) -> None:
    tiles.button("Another seed").focus()
    how, zoom = tiles.told(), tiles.page.get_by_label("Zoom", exact=True)
    keys(tiles, "ArrowRight", "ArrowDown")
    now = tiles.told()
    assert (now["x"], now["y"]) == (how["x"] - 50, how["y"] - 50)
    keys(tiles, "1")
    expect(zoom).to_have_text("100 %")
    keys(tiles, "+", "+")
    expect(zoom).to_have_text("156 %")
    assert tiles.told()["scale"] == pytest.approx(1.25**2)
    keys(tiles, "-")
    expect(zoom).to_have_text("125 %")
    keys(tiles, "0")
    assert tiles.told() == how
    tiles.radio("No").focus()
    keys(tiles, "ArrowRight")
    expect(tiles.radio("Across")).to_be_focused()
    tiles.page.get_by_role("spinbutton", name="Width in px").focus()
    keys(tiles, "1", "0")
    assert tiles.told() == how


def test_keys_belong_to_the_stage_that_was_touched_last(tiles: Desk) -> None:
    tiles.room("Paint")
    tiles.stroke((40, 40), (60, 60), number=1)
    left, right = tiles.told(0), tiles.told(1)
    tiles.page.get_by_role("link", name="Paint", exact=True).focus()
    keys(tiles, "ArrowLeft")
    assert tiles.told(0) == left
    assert tiles.told(1)["x"] == right["x"] + 50


def test_settings_are_undone_and_made_again_wherever_the_focus_is(tiles: Desk) -> None:
    tiles.radio("Both").click()
    tiles.button("3 times the example").click()
    tiles.page.get_by_role("link", name="Grow", exact=True).focus()
    keys(tiles, "Control+z")
    expect(tiles.button("2 times the example")).to_have_attribute("aria-pressed", "true")
    expect(tiles.page.get_by_text("Undone: size", exact=True)).to_be_visible()
    expect(tiles.radio("Both")).to_have_attribute("aria-checked", "true")
    keys(tiles, "Control+z", "Control+y", "Control+Shift+z")
    expect(tiles.button("3 times the example")).to_have_attribute("aria-pressed", "true")
    expect(tiles.radio("Both")).to_have_attribute("aria-checked", "true")


def test_what_was_changed_last_is_undone_first_painted_or_set(tiles: Desk) -> None:
    tiles.room("Paint")
    tiles.stroke((20, 20), (60, 60))
    tiles.page.mouse.move(1200, 20)  # else the ring of the brush is seen
    painted = tiles.still()
    tiles.page.get_by_label("Seed", exact=True).fill("9")
    tiles.page.get_by_role("link", name="Paint", exact=True).focus()
    keys(tiles, "Control+z")
    expect(tiles.page.get_by_label("Seed", exact=True)).to_have_value("")
    assert tiles.same(painted)
    keys(tiles, "Control+z")
    tiles.until(lambda: not tiles.same(painted))
    tiles.button("Redo").click()
    tiles.until(lambda: tiles.same(painted))
    tiles.button("Redo").click()
    expect(tiles.page.get_by_label("Seed", exact=True)).to_have_value("9")
    expect(tiles.button("Redo")).to_be_disabled()


def test_what_is_undone_of_the_painting_is_looked_at(tiles: Desk) -> None:
    tiles.room("Mend")
    tiles.stroke((20, 20), (40, 40))
    tiles.button("Heal").click()
    tiles.grown()
    picture = tiles.page.get_by_role("region", name="Picture", exact=True)
    expect(picture).to_be_hidden()
    keys(tiles, "Control+z")
    expect(picture).to_be_visible()
    expect(tiles.page.get_by_text("Undone: what was painted", exact=True)).to_be_visible()


def margins(page: Desk) -> list[int]:
    fields = [page.page.get_by_label(side, exact=True) for side in ("Left", "Right", "Top", "Bottom")]
    return [int(field.input_value()) for field in fields]


def test_the_frame_of_extending_is_seen_at_first_and_undone(tiles: Desk) -> None:
    tiles.room("Mend")
    tiles.radio("Extend").click()
    expect(tiles.page.get_by_text("Drag the frame outwards", exact=True)).to_be_visible()
    assert tiles.told()["x"] > 64  # there is room around the picture
    white = (tiles.seen()[..., :3] == 255).all(axis=2)
    x, y = (round(tiles.told()[axis] - 32 * tiles.told()["scale"]) for axis in "xy")
    assert white[y - 4 : y + 4, x - 4 : x + 4].mean() > 0.5  # a handle
    tiles.stroke((288, 128), (300, 128))
    assert margins(tiles) == [0, pytest.approx(44, abs=1), 0, 0]
    expect(tiles.page.get_by_text("Drag the frame outwards", exact=True)).to_be_hidden()
    tiles.button("25 % all around").click()
    assert margins(tiles) == [64, 64, 64, 64]
    how, stage = tiles.told(), tiles.stage().bounding_box()
    assert stage is not None
    assert how["x"] - 64 * how["scale"] > 0
    assert how["x"] + (256 + 64) * how["scale"] < stage["width"]
    tiles.page.get_by_label("Left").fill("7")
    tiles.page.get_by_role("link", name="Mend", exact=True).focus()
    keys(tiles, "Control+z")
    assert margins(tiles) == [64, 64, 64, 64]
    tiles.button("Undo").click()
    assert margins(tiles) == [0, pytest.approx(44, abs=1), 0, 0]
    keys(tiles, "Control+z")
    assert margins(tiles) == [0, 0, 0, 0]
    keys(tiles, "Control+y", "Control+y")
    assert margins(tiles) == [64, 64, 64, 64]
    keys(tiles, "Control+z", "Control+z")
    assert margins(tiles) == [0, 0, 0, 0]


def test_what_is_set_of_tiling_is_undone(tiles: Desk) -> None:
    tiles.room("Mend")
    tiles.radio("Tile").click()
    tiles.radio("Across").click()
    keys(tiles, "Control+z")
    expect(tiles.radio("Both")).to_have_attribute("aria-checked", "true")
    tiles.radio("Heal").click()
    expect(tiles.button("Undo")).to_be_disabled()


def test_what_was_deleted_comes_back_by_the_key(page: Desk) -> None:
    page.drop(gone=png(pixels(40, 44, seed=31)))
    page.page.get_by_role("heading", name="gone").wait_for()
    page.page.get_by_role("link", name="intarsia studio: begin").click()
    card = page.page.get_by_role("region", name="Opened before").get_by_role("button", name="gone", exact=True)
    card.hover()
    page.button("Delete gone").click()
    expect(card).to_have_count(0)
    keys(page, "Control+z")
    expect(card).to_have_count(1)
    expect(page.button("Undo")).to_have_count(0)


def test_what_was_deleted_comes_back_as_long_as_the_page_is_open(page: Desk) -> None:
    page.drop(kept=png(pixels(seed=48)))  # nobody else grows this one: its result is one card
    page.quick()
    page.button("Grow").click()
    result = page.grown()
    page.room("Gallery")
    made = page.page.locator(".made").filter(has=page.page.locator(f'img[src*="{result}"]'))
    made.get_by_role("button", name="Delete").click()
    expect(made).to_have_count(0)
    page.button("Dismiss").click()  # the offer is gone
    page.button("Bring back 1 deleted").click()
    expect(made).to_have_count(1)
    expect(page.button("Bring back 1 deleted")).to_have_count(0)


def test_undo_of_the_endless_room(tiles: Desk) -> None:
    tiles.room("Endless")
    seed = tiles.page.get_by_role("spinbutton", name="Seed")
    tiles.button("Another seed").click()
    other = seed.input_value()
    keys(tiles, "Control+z")
    expect(seed).to_have_value("")
    tiles.button("Redo").click()
    expect(seed).to_have_value(other)


def test_a_moved_readout_tells_each_move_of_a_frame(tiles: Desk) -> None:
    """Two keys within one frame of the screen: the second one is told as well."""
    zoom = tiles.page.get_by_label("Zoom", exact=True)
    expect(zoom).not_to_be_empty()
    pressed = """() => ["+", "+", "1"].forEach(key => dispatchEvent(new KeyboardEvent("keydown", {key})))"""
    tiles.page.evaluate(pressed)
    expect(zoom).to_have_text("100 %")
    assert np.isclose(tiles.told()["scale"], 1)
