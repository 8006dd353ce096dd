"""Mending on the page: what is brushed over is healed, the frame is dragged, the picture is made to tile."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from studio.browser import Desk
from studio.served import opened, png
from studio.test_page_paint import drawn

import intarsia as ia
from intarsia.tasks.completion import healed_scene

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


@pytest.fixture
def mend(page: Desk) -> Desk:
    """The room to mend in."""
    page.sample("tiles")
    page.room("Mend")
    return page


def test_what_is_brushed_over_is_healed(mend: Desk) -> None:
    places = mend.stroke((100, 100), (140, 120))
    mend.button("Heal").click()
    result = mend.served.get(f"/api/results/{mend.grown()}")
    assert (result["verb"], result["size"]) == ("heal", [256, 256])
    assert np.array_equal(mend.sent("mask"), drawn((256, 256), places, 32, 255))
    assert set(mend.jobs[0]["options"]) == {"mask"}
    mend.button("Command").click()
    said = mend.page.get_by_role("status").filter(has_text="copied")
    expect(said).to_have_text("Command copied; it needs mask.png, which is in the zip")


def test_nothing_brushed_over_is_said_so(mend: Desk) -> None:
    mend.button("Heal").click()
    expect(mend.page.get_by_role("alert")).to_contain_text("Brush over what must go")
    assert not mend.jobs


def test_the_frame_is_dragged_outwards(mend: Desk) -> None:
    mend.radio("Extend").click()
    mend.stroke((256, 128), (300, 128))
    mend.stroke((0, 0), (-20, -30))
    sides = [mend.page.get_by_label(name, exact=True) for name in ("Right", "Left", "Top")]
    right, left, top = (int(side.input_value()) for side in sides)
    assert (right, left, top) == (pytest.approx(44, abs=1), pytest.approx(20, abs=1), pytest.approx(30, abs=1))
    mend.page.get_by_label("Bottom").fill("12")
    mend.page.get_by_label("Top").fill("0")
    mend.button("Extend").click()
    result = mend.served.get(f"/api/results/{mend.grown()}")
    assert result["size"] == [256 + left + right, 256 + 12]
    assert mend.jobs[0]["options"] == {"left": left, "right": right, "bottom": 12}
    mend.button("Back to the picture").click()
    expect(mend.page.get_by_label("Right", exact=True)).to_be_visible()


def test_a_picture_is_made_to_tile(mend: Desk) -> None:
    mend.radio("Tile").click()
    mend.radio("Across").click()
    mend.button("Make it tile").click()
    result = mend.served.get(f"/api/results/{mend.grown()}")
    assert (result["verb"], mend.jobs[0]["options"]) == ("tile", {"axes": "x"})
    expect(mend.page.get_by_role("heading", name="Tiled, seed 0")).to_be_visible()


def made(page: Desk) -> np.ndarray:
    """The picture of the result that is on the stage, once it is another one than before."""
    result = page.served.get(f"/api/results/{page.grown()}")
    return opened(page.served.bytes(page.served.file(result, result["files"][-1])))


def test_each_step_acts_on_what_is_seen(mend: Desk) -> None:
    mend.stroke((100, 100), (140, 120))
    mend.button("Heal").click()
    healed = made(mend)
    mend.radio("Extend").click()
    expect(mend.page.get_by_role("heading", name="tiles_healed")).to_be_visible()
    mend.page.get_by_label("Right", exact=True).fill("12")
    mend.button("Extend").click()
    extended = made(mend)
    assert extended.shape == (256, 268, 3)
    assert np.array_equal(extended[:, :200], healed[:, :200])  # what lies far from the border stays as it was
    whole = opened(mend.served.bytes("/api/samples/tiles.png"))
    assert not np.array_equal(healed[100:120, 100:140], whole[100:120, 100:140])
    mend.button("Continue from this").click()
    expect(mend.page.get_by_role("heading", name="tiles_healed_extended")).to_be_visible()
    expect(mend.button("Continue from this")).to_be_hidden()
    assert (mend.told()["width"], mend.told()["height"]) == (268, 256)
    mend.radio("Tile").click()
    mend.button("Make it tile").click()
    mend.grown()
    names = {row["id"]: row["name"] for row in mend.served.get("/api/exemplars")}
    assert [names[job["exemplars"][0]] for job in mend.jobs] == ["tiles", "tiles_healed", "tiles_healed_extended"]


def test_the_way_back_leads_to_the_picture_as_it_was(mend: Desk) -> None:
    mend.stroke((100, 100), (140, 120))
    mend.button("Heal").click()
    mend.grown()
    for name in ("Heal", "Back to the picture"):
        assert mend.button(name).evaluate("b => b.scrollWidth <= b.clientWidth"), name
    mend.button("Back to the picture").click()
    expect(mend.page.get_by_role("heading", name="tiles", exact=True)).to_be_visible()
    assert mend.told()["layers"] == 1


def test_another_seed_mends_otherwise(page: Desk) -> None:
    """Without one the best pieces are taken, which are always the same."""
    noise = np.random.default_rng(8).integers(0, 255, (96, 96, 3), np.uint8)
    page.drop(noise=png(noise))
    page.page.get_by_role("heading", name="noise").wait_for()
    page.room("Mend")
    page.stroke((30, 40), (60, 50))
    page.button("Heal").click()
    first = made(page)
    page.button("Another seed").click()
    page.button("Heal").click()
    page.until(lambda: len(page.jobs) == 2)
    expect(page.page.get_by_role("heading", name=f"seed {page.jobs[1]['options']['seed']}")).to_be_visible()
    second = made(page)
    assert ("tolerance" in page.jobs[0]["options"], page.jobs[1]["options"]["tolerance"]) == (False, 0.1)
    assert not np.array_equal(first, second)
    assert np.array_equal(first[70:], second[70:])


def test_methods_of_mending_are_not_shown_by_what_they_grow_of_the_whole(mend: Desk) -> None:
    mend.page.locator(".pick-head").click()
    expect(mend.page.locator(".method").first).to_be_visible()
    expect(mend.page.locator(".sketch")).to_have_count(0)


def stained() -> np.ndarray:
    """Noise with a red stain, 21 px in radius, whose rim of 4 px is bright."""
    out = np.random.default_rng(3).integers(90, 130, (160, 160, 3), np.uint8)
    y, x = np.mgrid[:160, :160] - 79.5
    far = np.sqrt(y * y + x * x)
    out[far < 25] = (240, 240, 200)
    out[far < 21] = (200, 20, 20)
    return out


def test_the_rim_that_healing_takes_is_seen(page: Desk) -> None:
    page.drop(stain=png(stained()))
    page.page.get_by_role("heading", name="stain").wait_for()
    page.room("Mend")
    said = page.page.get_by_role("status").filter(has_text="rim")
    page.radio("With rim").click()
    expect(said).to_have_count(0)
    page.page.get_by_role("slider", name="Size of the brush").fill("60")
    page.stroke((80, 80), (80, 80.5))
    size = int(page.page.locator(".brush-size").inner_text().split()[0])
    assert 36 <= size <= 44
    expect(said).to_contain_text("px wide", timeout=60_000)
    hole = np.zeros((160, 160), np.uint8)
    masks = {path: opened(path.read_bytes()) for path in (page.served.folder / "images").glob("*.png")}
    image = next(p for p, m in masks.items() if m.shape == hole.shape and m.max() == 255)  # what was sent to be healed
    hole[:] = opened(image.read_bytes())
    scene = healed_scene(ia.Exemplar.of(stained()), hole > 0, (), ia.Wrap.NONE, None)
    grow = scene.recipe["heal"]["grow"]
    assert grow > 2
    expect(said).to_have_text(f"The rim is {grow} px wide.")
    exemplar = next(e["id"] for e in page.served.get("/api/exemplars") if e["name"] == "stain")
    answer = page.served.client.get(f"/api/exemplars/{exemplar}/rim/{image.stem}.png")
    assert answer.headers["x-grow"] == str(grow)
    assert scene.canvas.start is not None
    assert np.array_equal(opened(answer.content)[..., 3] > 0, scene.canvas.start.holes & (hole == 0))
    assert page.told()["layers"] == 2
    page.button("Heal").click()
    page.grown()
    assert page.jobs[0]["options"]["grow"] == "auto"
    page.button("Back to the picture").click()
    page.radio("As painted").click()
    expect(said).to_have_count(0)
    assert page.told()["layers"] == 1
    assert page.served.client.get(f"/api/exemplars/{exemplar}/rim/{'0' * 16}.png").status_code == 404
