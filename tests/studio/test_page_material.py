"""A material from a photograph: maps are proposed, lit at once, and taken as an engine reads them."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from PIL import Image
from studio.browser import Desk
from studio.served import Served, opened, pixels, png

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


def bricks() -> np.ndarray:
    """A photograph, nearly: dark bricks, and joints of light mortar between them."""
    y, x = np.mgrid[:96, :96]
    row = y // 16
    joint = (y % 16 < 3) | ((x + 12 * (row % 2)) % 24 < 3)
    grain = (7 * x + 13 * y + x * y) % 9
    return np.where(joint, 190, 80 + grain)[..., None].repeat(3, 2).astype(np.uint8)


def zipped(data: bytes) -> dict[str, Any]:
    """What an archive holds: pixels, or text."""
    with zipfile.ZipFile(io.BytesIO(data)) as held:
        return {n: opened(held.read(n)) if n.endswith("png") else held.read(n).decode() for n in held.namelist()}


def test_a_photograph_is_lit_after_one_press(page: Desk, served: Served) -> None:
    page.drop(bricks=png(bricks()))
    page.page.get_by_role("heading", name="bricks").wait_for()
    expect(page.radio("Lit")).to_have_count(0)
    page.button("Propose maps").click()
    for name in ("Height (proposed)", "Normal (proposed)", "Roughness (proposed)"):
        page.page.get_by_role("listitem").filter(has_text=name).wait_for()
    expect(page.page.get_by_role("listitem").filter(has_text="Albedo (proposed)")).to_have_count(0)
    expect(page.button("Propose maps")).to_have_count(0)
    page.radio("Lit").click()
    lamp = page.page.get_by_role("slider", name="Lamp")
    lamp.focus()
    left = page.still()
    for _ in range(12):
        page.page.keyboard.press("Shift+ArrowRight")
    right = page.still()
    assert (np.abs(left.astype(int) - right) > 20).any(axis=2).mean() > 0.1
    rows = served.get("/api/exemplars")
    height = next(row for row in rows if row["name"] == "bricks" and len(row["planes"]) == 4)
    seen = opened(served.bytes(f"/api/exemplars/{height['id']}/height.png"))[..., 0].astype(int)
    assert seen[8::16, 4:12].mean() > seen[1::16].mean() + 40, "light mortar lies deep"


def test_a_result_is_taken_for_an_engine(page: Desk) -> None:
    """The zip has the names, packing and green of the engine that was chosen; the next menu remembers it."""
    n = np.dstack([pixels()[..., 0] // 4 + 96, pixels()[..., 1] // 4 + 96, np.full((32, 36), 250, np.uint8)])
    rough = pixels(seed=5)[..., 2]
    page.drop(wall_albedo=png(pixels()), wall_normal=png(n), wall_roughness=png(rough))
    page.page.get_by_role("heading", name="wall").wait_for()
    page.quick()
    page.button("Grow").click()
    result = page.grown()
    page.button("More to take").click()
    menu = page.page.get_by_role("group", name="Downloads")
    expect(menu.get_by_text("Only the base colour goes.")).to_have_count(0)
    menu.get_by_label("For").select_option("For Unity")
    menu.get_by_label("For").select_option("For Unreal")
    with page.page.expect_download() as coming:
        menu.get_by_role("link", name="Zip", exact=True).evaluate("link => link.click()")  # does not wait for the file
        expect(page.page.get_by_text("The zip is in your downloads.", exact=True)).to_be_visible()
    path = coming.value.path()
    expect(menu).to_be_hidden()
    assert coming.value.suggested_filename == "wall_grown_image-quilting_unreal.zip"
    held = zipped(Path(path).read_bytes())
    assert held.keys() == {"T_wall_grown_BC.png", "T_wall_grown_N.png", "T_wall_grown_ORM.png", "told.txt"}
    made = page.served.get(f"/api/results/{result}")
    planes = {e["holds"]: opened(page.served.bytes(f"/api/results/{result}/files/{e['name']}")) for e in made["files"]
              if e["holds"] in ("albedo", "normal", "roughness")}  # fmt: skip
    assert np.array_equal(held["T_wall_grown_BC.png"], planes["albedo"])
    assert np.array_equal(held["T_wall_grown_N.png"][..., 1], 255 - planes["normal"][..., 1])
    assert np.array_equal(held["T_wall_grown_N.png"][..., ::2], planes["normal"][..., ::2])
    orm = held["T_wall_grown_ORM.png"]
    assert np.array_equal(orm[..., 1], planes["roughness"])
    assert (orm[..., 0] == 255).all()
    assert (orm[..., 2] == 0).all()
    assert "green of the normals was turned: Unreal reads DirectX" in held["told.txt"]


def test_a_lone_result_says_that_only_its_colour_goes_and_proposes_maps(page: Desk) -> None:
    page.drop(lone=png(pixels()))
    page.page.get_by_role("heading", name="lone").wait_for()
    page.quick()
    page.button("Grow").click()
    page.grown()
    page.button("More to take").click()
    menu = page.page.get_by_role("group", name="Downloads")
    expect(menu.get_by_text("Only the base colour goes.")).to_be_visible()
    menu.get_by_role("button", name="Propose maps").click()
    page.page.get_by_role("heading", name="lone_grown").wait_for()
    page.page.get_by_role("listitem").filter(has_text="Height (proposed)").wait_for()
    page.radio("Lit").wait_for()


def test_an_example_is_taken_for_an_engine_from_inspect(page: Desk) -> None:
    page.drop(plate_albedo=png(pixels()), plate_height=png(pixels()[..., 1]))
    page.page.get_by_role("heading", name="plate").wait_for()
    expect(page.page.locator("exemplar-card").get_by_role("link", name="Zip", exact=True)).to_be_visible()
    page.room("Inspect")
    page.page.get_by_label("For", exact=True).select_option("For Godot")
    with page.page.expect_download() as coming:
        page.page.get_by_role("link", name="Zip", exact=True).click()
    held = zipped(Path(coming.value.path()).read_bytes())
    assert held.keys() == {"plate_albedo.png", "plate_height.png", "told.txt"}
    assert np.array_equal(held["plate_albedo.png"], pixels())


def test_the_server_proposes_and_packs(served: Served) -> None:
    row = served.exemplar(sole=png(pixels()))
    assert [plane["proposed"] for plane in row["planes"]] == [False]
    made = served.client.post(f"/api/exemplars/{row['id']}/edit", json={"propose": True}).json()
    assert {plane["name"]: plane["proposed"] for plane in made["planes"]} == {
        "albedo": False, "normal": True, "roughness": True, "height": True,
    }  # fmt: skip
    again = served.client.post(f"/api/exemplars/{made['id']}/edit", json={"propose": True})
    assert again.status_code == 400
    assert "lacks no map" in again.text
    held = zipped(served.bytes(f"/api/exemplars/{made['id']}/for/unity.zip"))
    assert set(held) == {"sole_BaseMap.png", "sole_Normal.png", "sole_MaskMap.png", "sole_Height.png", "told.txt"}
    mask, rough = held["sole_MaskMap.png"], served.bytes(f"/api/exemplars/{made['id']}/roughness.png")
    assert np.array_equal(mask[..., 3], 255 - opened(rough)[..., 0])
    with Image.open(io.BytesIO(png(pixels()))) as whole:
        assert held["sole_BaseMap.png"].shape[:2] == whole.size[::-1]
    wrong = served.client.get(f"/api/exemplars/{made['id']}/for/lego.zip")
    assert wrong.status_code == 400
    assert "unreal" in wrong.text
