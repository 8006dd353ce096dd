"""Materials under a lamp: what is seen follows from the maps and from where the lamp is, pixel by pixel."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from studio.browser import Desk, desk
from studio.served import Served, png

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect

SIDE = 64


def surface(tilt: float = 0.6) -> dict[str, np.ndarray]:
    """Left half faces left, right half faces right; the lower half is rougher; brown."""
    albedo = np.full((SIDE, SIDE, 3), (190, 140, 100), np.uint8)
    n = np.zeros((SIDE, SIDE, 3))
    n[..., 0] = np.where(np.arange(SIDE) < SIDE // 2, -tilt, tilt)[None]
    n[..., 2] = math.sqrt(1 - tilt * tilt)
    rough = np.where(np.arange(SIDE) < SIDE // 2, 70, 200).astype(np.uint8)[:, None] + np.zeros((1, SIDE), np.uint8)
    return {"albedo": albedo, "normal": np.floor((n + 1) * 127.5 + 0.5).astype(np.uint8), "roughness": rough}


def dropped(page: Desk, name: str, **planes: np.ndarray) -> None:
    """Open a material, and light it."""
    page.drop(**{f"{name}_{plane}": png(pixels) for plane, pixels in planes.items()})
    page.page.get_by_role("heading", name=name).wait_for()
    page.radio("Lit").click()
    lamp(page).wait_for()
    page.still()


def lamp(page: Desk) -> Locator:
    return page.page.get_by_role("slider", name="Lamp")


def moved(page: Desk, x: float, y: float) -> np.ndarray:
    """Drag the lamp to a place of the stage, given in shares of it; what is seen then."""
    box, held = page.stage().bounding_box(), lamp(page).bounding_box()
    assert box is not None
    assert held is not None
    page.page.mouse.move(held["x"] + held["width"] / 2, held["y"] + held["height"] / 2)
    page.page.mouse.down()
    page.page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"], steps=3)
    page.page.mouse.up()
    return page.seen()


def at(page: Desk, seen: np.ndarray, u: float, v: float) -> np.ndarray:
    """The colour of a place of the picture, given in its pixels."""
    how = page.told()
    pixel: np.ndarray = seen[int(how["y"] + v * how["scale"]), int(how["x"] + u * how["scale"])]
    return pixel[:3].astype(int)


def test_left_and_right_are_lit_as_their_normals_say(page: Desk) -> None:
    dropped(page, "wall", **surface())
    left = moved(page, 0.02, 0.5)
    right = moved(page, 0.98, 0.5)
    for v in (16.5, 48.5):
        assert at(page, left, 16.5, v).sum() > 2 * at(page, left, 48.5, v).sum()
        assert at(page, right, 48.5, v).sum() > 2 * at(page, right, 16.5, v).sum()
    lamp(page).focus()
    before = at(page, page.seen(), 16.5, 16.5).sum()
    for _ in range(30):
        page.page.keyboard.press("ArrowLeft")
    assert lamp(page).get_attribute("aria-valuetext") == "38 % from the left, 50 % from the top"
    page.page.keyboard.press("Shift+ArrowUp")
    assert lamp(page).get_attribute("aria-valuetext") == "38 % from the left, 40 % from the top"
    assert at(page, page.seen(), 16.5, 16.5).sum() > 2 * before


def reflected(place: np.ndarray, source: np.ndarray, power: float, n: np.ndarray, colour: Any, rough: float) -> Any:
    """What of a lamp a place sends straight up, in sRGB: Lambert, and Cook and Torrance, written down anew."""
    base = np.array([c / 255 / 12.92 if c <= 10 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in colour])
    away = source - place
    distance = math.sqrt(away @ away)
    light, eye = away / distance, np.array([0.0, 0.0, 1.0])
    half = (light + eye) / math.sqrt((light + eye) @ (light + eye))
    nl, nv, nh, vh = max(n @ light, 0), max(n @ eye, 1e-3), max(n @ half, 0), max(eye @ half, 0)
    alpha = rough**2
    d = alpha**2 / (math.pi * (nh**2 * (alpha**2 - 1) + 1) ** 2)
    k = (rough + 1) ** 2 / 8
    g = nl / (nl * (1 - k) + k) * nv / (nv * (1 - k) + k)
    f = 0.04 + 0.96 * (1 - vh) ** 5
    gloss = d * g * f / (4 * nl * nv) if nl > 0 else 0.0
    radiance = ((1 - f) * base / math.pi + gloss) * nl * math.pi * power * (source[2] / distance) ** 2
    out = np.clip(radiance + 0.045 * power * base, 0, 1)
    return 255 * np.where(out <= 0.0031308, 12.92 * out, 1.055 * out ** (1 / 2.4) - 0.055)


def test_every_pixel_is_what_the_formulas_say(page: Desk) -> None:
    maps = surface(0.4)
    dropped(page, "check", **maps)
    seen, how, box = moved(page, 0.4, 0.35), page.told(), page.stage().bounding_box()
    assert box is not None
    page.page.get_by_role("slider", name="Distance").fill("60")
    page.page.get_by_role("slider", name="Brightness").fill("120")
    seen = page.seen()
    held = lamp(page).bounding_box()
    assert held is not None
    source = np.array([held["x"] + 22 - box["x"], held["y"] + 22 - box["y"], 0.6 * min(box["width"], box["height"])])
    for u, v in ((8, 8), (20, 50), (40, 12), (57, 57), (28, 30)):
        x, y = int(how["x"] + (u + 0.5) * how["scale"]), int(how["y"] + (v + 0.5) * how["scale"])
        n = maps["normal"][v, u] / 127.5 - 1
        normal = np.array([n[0], -n[1], n[2]]) / math.sqrt(n @ n)
        place = np.array([x + 0.5, y + 0.5, 0.0])
        said = reflected(place, source, 1.2, normal, maps["albedo"][v, u], maps["roughness"][v, u] / 255)
        np.testing.assert_allclose(seen[y, x, :3], said, atol=2.5, err_msg=str((u, v)))
        assert seen[y, x, 3] == 255


def test_a_lamp_that_is_higher_or_brighter_gives_more_light_aside(page: Desk) -> None:
    dropped(page, "plain", **surface(0.0))
    low = moved(page, 0.5, 0.5)
    page.page.get_by_role("slider", name="Distance").fill("140")
    high = page.seen()
    assert at(page, high, 2.5, 2.5).sum() > 1.2 * at(page, low, 2.5, 2.5).sum()
    page.page.get_by_role("slider", name="Brightness").fill("40")
    assert at(page, page.seen(), 32.5, 32.5).sum() < 0.8 * at(page, high, 32.5, 32.5).sum()


def test_tiles_are_lit_together(page: Desk) -> None:
    dropped(page, "tile", **surface())
    page.button("3 × 3").click()
    seen = moved(page, 0.5, 0.5)
    for tile in range(3):
        left, right = at(page, seen, 64 * tile + 16.5, 96.5).sum(), at(page, seen, 64 * tile + 48.5, 96.5).sum()
        assert (left < right) if tile == 0 else (left > right) if tile == 2 else abs(left - right) < 0.1 * left
    how = page.told()
    assert seen[int(how["y"]) - 3, int(how["x"]) + 9, 3] == 0


def test_green_that_points_down_is_understood(page: Desk) -> None:
    maps = surface()
    upright = np.ascontiguousarray(maps["normal"].transpose(1, 0, 2)[..., [1, 0, 2]])  # the upper half: negative green
    dropped(page, "gl", albedo=maps["albedo"], normal=upright)
    plain = moved(page, 0.5, 0.02)
    assert at(page, plain, 32.5, 16.5).sum() < at(page, plain, 32.5, 48.5).sum()
    dropped(page, "dx", albedo=maps["albedo"], nor_dx=upright)
    turned = moved(page, 0.5, 0.02)
    assert at(page, turned, 32.5, 16.5).sum() > 2 * at(page, turned, 32.5, 48.5).sum()


def test_slopes_come_from_the_height_where_there_are_no_normals(page: Desk) -> None:
    ridge = (4 * np.minimum(np.arange(SIDE), SIDE - 1 - np.arange(SIDE))).astype(np.uint8)
    height = np.broadcast_to(ridge, (SIDE, SIDE)).copy()
    dropped(page, "ridge", albedo=surface()["albedo"], height=height)
    left = moved(page, 0.02, 0.5)
    right = moved(page, 0.98, 0.5)
    assert at(page, left, 20.5, 32.5).sum() > 1.1 * at(page, left, 44.5, 32.5).sum()
    assert at(page, right, 44.5, 32.5).sum() > 1.1 * at(page, right, 20.5, 32.5).sum()


def above(page: Desk) -> dict[str, float]:
    """Where a picture lies that is put on a solid: smaller than it is seen flat, above what is set of it."""
    how, stage = page.told(), page.stage().bounding_box()
    panel = page.page.locator(".lamp-panel").bounding_box()
    assert stage is not None
    assert panel is not None
    part, middle = 1 - (panel["height"] + 24) / stage["height"], stage["width"] / 2
    return {"x": middle + (how["x"] - middle) * part, "y": how["y"] * part, "scale": how["scale"] * part}


def silhouette(page: Desk, seen: np.ndarray) -> tuple[float, float]:
    """The radius of what is seen, by its area and by its widest row, relative to half the picture."""
    opaque, how = seen[..., 3] == 255, above(page)
    half = SIDE * how["scale"] / 2
    return math.sqrt(opaque.sum() / math.pi) / half, opaque.sum(axis=1).max() / 2 / half


def test_a_ball_is_as_round_and_as_large_as_its_heights_leave_it(page: Desk) -> None:
    black = np.zeros((SIDE, SIDE), np.uint8)
    dropped(page, "ball", **surface(0.0), height=black)
    page.radio("Ball").click()
    for depth in (0, 25):
        page.page.get_by_role("slider", name="Depth").fill(str(depth))
        radius = 0.85 - 1.4 * depth / 100
        expected = 4 * radius / math.sqrt(16 - radius**2)  # from 4 radii away
        assert silhouette(page, page.seen()) == (pytest.approx(expected, rel=0.01), pytest.approx(expected, rel=0.01))
    panel, stage = page.page.locator(".lamp-panel").bounding_box(), page.stage().bounding_box()
    assert panel is not None
    assert stage is not None
    lowest = (page.seen()[..., 3] == 255).any(axis=1).nonzero()[0].max()
    assert lowest < panel["y"] - stage["y"], "what is set of it covers none of it"


def test_a_solid_is_turned_by_its_slider_and_by_dragging_and_stays_where_it_is(page: Desk) -> None:
    two = np.full((SIDE, SIDE, 3), (30, 30, 220), np.uint8)
    two[:, : SIDE // 2] = (220, 30, 30)
    dropped(page, "turned", **surface(0.0) | {"albedo": two})
    page.radio("Ball").click()
    view, turn = page.told(), page.page.get_by_role("slider", name="Turn")
    for degrees, channel in ((45, 0), (135, 2), (225, 0), (315, 2)):  # twice around the ball
        turn.fill(str(degrees))
        assert int(at(page, page.seen(), SIDE / 2, SIDE / 2).argmax()) == channel
    x, y = page.at(SIDE / 2, SIDE / 2)
    page.page.mouse.move(x, y)
    page.page.mouse.down()
    page.page.mouse.move(x + 180, y, steps=6)
    page.page.mouse.up()
    assert turn.input_value() == "225"
    assert int(at(page, page.seen(), SIDE / 2, SIDE / 2).argmax()) == 0
    assert page.told() == view


@pytest.mark.parametrize("shape", ["Plane", "Ball", "Cylinder", "Corner"])
def test_light_falls_on_a_solid_from_where_the_lamp_is(shape: str, page: Desk) -> None:
    dropped(page, shape.lower(), **surface(0.0))
    page.radio(shape).click()
    if shape in ("Plane", "Corner"):
        page.page.get_by_role("slider", name="Turn").fill("0" if shape == "Plane" else "45")
    part = above(page)["scale"] / page.told()["scale"]  # the lamp moves and comes nearer as the solid does
    page.page.get_by_role("slider", name="Distance", exact=True).fill(str(round(42 * part)))
    left, right = moved(page, 0.5 - 0.48 * part, 0.4 * part), moved(page, 0.5 + 0.48 * part, 0.4 * part)
    opaque = (left[..., 3] == 255).nonzero()[1]
    middle = (int(opaque.min()) + int(opaque.max())) // 2
    west, east = (slice(None), slice(None, middle), slice(3)), (slice(None), slice(middle, None), slice(3))
    assert left[west].sum() / left[east].sum() > 1.2 * right[west].sum() / right[east].sum()


def test_raised_parts_throw_shadows(page: Desk) -> None:
    step = np.zeros((SIDE, SIDE), np.uint8)
    step[:, 28:36] = 255
    dropped(page, "step", **surface(0.0), height=step)
    page.radio("Plane").click()
    page.page.get_by_role("slider", name="Turn").fill("0")
    page.page.get_by_role("slider", name="Depth").fill("25")
    page.page.get_by_role("slider", name="Distance", exact=True).fill("80")
    left, right = moved(page, 0.0, 0.3), moved(page, 1.0, 0.3)
    how = above(page)
    row, behind = int(how["y"] + 40 * how["scale"]), int(how["x"] + 41 * how["scale"])
    assert left[row, behind, :3].sum() < 0.75 * right[row, behind, :3].sum()


def test_a_grown_material_is_lit_and_its_planes_are_seen(page: Desk) -> None:
    page.sample("setts")
    page.quick()
    page.button("Grow").click()
    page.grown()
    plain = page.seen()
    page.radio("Lit").click()
    lamp(page).wait_for()
    page.until(lambda: not page.same(plain))
    first = moved(page, 0.1, 0.1)
    assert not np.array_equal(first, plain)
    assert not np.array_equal(first, moved(page, 0.9, 0.9))
    page.radio("Picture").click()
    expect(lamp(page)).to_be_hidden()
    assert np.array_equal(page.seen(), plain)
    page.page.get_by_role("combobox", name="Map").select_option("normal")
    page.until(lambda: page.seen()[..., 2].max() > 240)
    page.radio("Lit").click()
    lamp(page).wait_for()


def test_only_what_has_slopes_can_be_lit(page: Desk) -> None:
    page.sample("tiles")
    page.quick()
    page.button("Grow").click()
    page.grown()
    expect(page.radio("Pieces")).to_be_visible()
    expect(page.radio("Lit")).to_have_count(0)


def test_a_browser_without_webgl_says_so_in_one_line(browser: Browser, served: Served) -> None:
    with desk(browser, served) as page:
        page.page.add_init_script(
            """const get = HTMLCanvasElement.prototype.getContext;
            HTMLCanvasElement.prototype.getContext = function (kind, how) {
              return kind === "webgl2" ? null : get.call(this, kind, how);
            };"""
        )
        page.page.reload()
        page.sample("setts")
        plain = page.still()
        page.radio("Lit").click()
        expect(page.page.get_by_text("This browser has no WebGL 2, which light needs.")).to_be_visible()
        expect(lamp(page)).to_be_hidden()
        assert np.array_equal(page.seen(), plain)


def test_a_finger_drags_the_lamp(browser: Browser, served: Served) -> None:
    with desk(browser, served, has_touch=True, viewport={"width": 1024, "height": 768}) as page:
        dropped(page, "touched", **surface())
        held = lamp(page).bounding_box()
        assert held is not None
        x, y, view = held["x"] + 22, held["y"] + 22, page.told()
        fingers = page.page.context.new_cdp_session(page.page)
        for kind, far in (("touchStart", 0), ("touchMove", 60), ("touchMove", 160), ("touchEnd", 0)):
            points = [] if kind == "touchEnd" else [{"x": x + far, "y": y + far / 2}]
            fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        assert page.told() == view
        now = lamp(page).bounding_box()
        assert now is not None
        assert (now["x"] - held["x"], now["y"] - held["y"]) == (pytest.approx(160, abs=2), pytest.approx(80, abs=2))


def test_a_graphics_card_that_is_taken_away_is_asked_for_again(browser: Browser, served: Served) -> None:
    with desk(browser, served) as page:
        page.page.add_init_script(
            """const get = HTMLCanvasElement.prototype.getContext;
            window.cards = [];
            HTMLCanvasElement.prototype.getContext = function (kind, how) {
              const card = get.call(this, kind, how);
              if (kind === "webgl2") cards.push(card);
              return card;
            };"""
        )
        page.page.reload()
        dropped(page, "card", **surface())
        lit = page.seen()
        page.page.evaluate("cards[0].getExtension('WEBGL_lose_context').loseContext()")
        page.until(lambda: page.page.evaluate("cards.length") == 2)
        page.until(lambda: page.same(lit))
