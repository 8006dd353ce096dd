"""The endless canvas on the page: what is seen is the library's texture, wherever one goes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from studio.browser import Desk, desk, drawn
from studio.served import Served, opened, pixels, png

import intarsia as ia

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Request, expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect

PARALLEL = "parallel-controllable"
STILL = """() => {
  const room = document.querySelector("endless-room");
  return room && !room.busy && room.tiles.weave && room.tiles.missing === 0;
}"""
TILE = re.compile(r"/api/weaves/([0-9a-f]+)/(\d)/(-?\d+)/(-?\d+)\.png")


class Walk:
    """A page on which an endless texture is walked over."""

    def __init__(self, desk: Desk) -> None:
        self.desk, self.page = desk, desk.page
        self.asked: list[tuple[int, int, int]] = []
        self.given_up: list[str] = []
        self.weaves: list[Any] = []
        self.page.on("request", self._sent)
        self.page.on("requestfailed", lambda r: self.given_up.append(r.url) if TILE.search(r.url) else None)

    def _sent(self, request: Request) -> None:
        if found := TILE.search(request.url):
            self.asked.append((int(found[2]), int(found[3]), int(found[4])))
        elif request.method == "POST" and request.url.endswith("/api/weaves"):
            self.weaves.append(request.post_data_json)

    @property
    def sight(self) -> Locator:
        return self.page.locator("endless-sight")

    def still(self) -> Walk:
        """Wait until all that is in sight is there."""
        self.page.wait_for_timeout(120)
        self.page.wait_for_function(STILL, timeout=180_000)  # what a page before asked for is drawn first
        return self

    def told(self) -> Any:
        return self.sight.evaluate(
            "s => ({...s.window, scale: s.view.scale, dropped: s.tiles.dropped, came: s.tiles.came})"
        )

    def seen(self) -> np.ndarray:
        """The pixels of the canvas as they are drawn."""
        found = drawn(self.sight)
        assert (found[..., 3] == 255).all()
        return found[..., :3]

    def method(self, slug: str) -> Walk:
        self.page.locator(".pick-head").click()
        self.page.locator(".method", has_text=slug).click()
        return self.still()

    def leave(self) -> None:
        """Take the pointer away, so that no ring is drawn."""
        self.page.mouse.move(1200, 20)

    def stroke(self, *places: tuple[int, int]) -> None:
        """Draw from place to place of the sight."""
        box = self.sight.bounding_box()
        assert box is not None
        for n, (x, y) in enumerate(places):
            self.page.mouse.move(box["x"] + x, box["y"] + y, steps=4 if n else 1)
            if n == 0:
                self.page.mouse.down()
        self.page.mouse.up()
        self.leave()


@contextmanager
def walking(page: Desk) -> Iterator[Walk]:
    walk = Walk(page)
    page.drop(small=png(pixels()))
    page.page.get_by_role("heading", name="small").wait_for()
    page.room("Endless")
    yield walk.still()


@pytest.fixture
def walk(page: Desk) -> Iterator[Walk]:
    """An endless texture of a small exemplar."""
    with walking(page) as found:
        yield found


@pytest.fixture(scope="module")
def texture(tmp_path_factory: pytest.TempPathFactory) -> ia.Weave:
    """The same in the library."""
    path = tmp_path_factory.mktemp("weave") / "small.png"
    path.write_bytes(png(pixels()))
    return ia.weave(str(path), "repeat")


def parallel(texture: ia.Weave, seed: int = 0) -> ia.Weave:
    """The texture by another method."""
    return ia.weave(texture.exemplars[0], PARALLEL, seed)


def window(texture: ia.Weave, told: Any) -> np.ndarray:
    """What the library draws where the page looks."""
    x, y = told["x"], told["y"]
    return np.asarray(texture[y : y + told["height"], x : x + told["width"]])


def test_every_pixel_is_the_librarys_and_tiles_join(walk: Walk, texture: ia.Weave) -> None:
    walk.method("repeat")
    told = walk.told()
    assert told["scale"] == 1
    assert told["x"] < 0 < told["x"] + told["width"]
    assert np.array_equal(walk.seen(), window(texture, told))
    walk.method(PARALLEL)
    assert np.array_equal(walk.seen(), window(parallel(texture), walk.told()))


def test_panning_shows_what_lies_there(walk: Walk, texture: ia.Weave) -> None:
    walk.method("repeat")
    before, asked = walk.told(), len(walk.asked)
    walk.stroke((700, 400), (100, 100))
    walk.still()
    now = walk.told()
    assert (now["x"] - before["x"], now["y"] - before["y"]) == (600, 300)
    assert np.array_equal(walk.seen(), window(texture, now))
    new = walk.asked[asked:]
    assert new
    assert len(set(new)) == len(new)
    walk.sight.focus()
    for key in ("ArrowRight", "Shift+ArrowDown", "ArrowUp"):
        walk.page.keyboard.press(key)
    walk.still()
    keys = walk.told()
    assert (keys["x"] - now["x"], keys["y"] - now["y"]) == (50, 150)
    assert np.array_equal(walk.seen(), window(texture, keys))
    walk.page.keyboard.press("0")
    walk.still()
    assert walk.told() | {"came": 0, "dropped": 0} == before | {"came": 0, "dropped": 0}
    walk.page.mouse.move(400, 400)
    walk.page.mouse.wheel(0, -400)
    walk.still()
    assert walk.told()["scale"] > 1.5
    walk.page.get_by_role("button", name="100 %").click()
    walk.still()
    assert walk.told()["scale"] == 1
    assert np.array_equal(walk.seen(), window(texture, walk.told()))


def test_what_lies_nearest_the_middle_is_asked_first(walk: Walk) -> None:
    walk.method("repeat")
    walk.page.keyboard.press("Escape")
    start = len(walk.asked)
    walk.sight.evaluate("s => { s.view.move(-40 * 256, 30 * 256); s.redraw(); }")
    walk.still()
    told, places = walk.told(), walk.asked[start:]
    u, v = told["x"] + told["width"] / 2, told["y"] + told["height"] / 2
    far = [np.hypot((x + 0.5) * 256 - u, (y + 0.5) * 256 - v) for _, y, x in places]
    assert len(far) >= 12
    assert far == sorted(far)


def test_what_is_out_of_sight_is_given_up(walk: Walk, texture: ia.Weave) -> None:
    walk.method("repeat")
    walk.page.route(TILE, lambda route: None)
    start = len(walk.asked)
    walk.sight.evaluate("s => { s.view.move(-100 * 256, 0); s.redraw(); }")
    walk.page.wait_for_timeout(300)
    asked = walk.asked[start:]
    assert len(asked) == 3
    walk.sight.evaluate("s => { s.view.move(200 * 256, 0); s.redraw(); }")
    walk.page.wait_for_timeout(300)
    assert len(walk.given_up) == 3
    assert len(walk.asked) == start + 6
    walk.page.unroute(TILE)
    walk.still()
    assert not set(walk.asked[start + 3 :]) & set(asked)
    assert np.array_equal(walk.seen(), window(texture, walk.told()))
    walk.sight.evaluate("s => { s.view.move(-500 * 256, 0); s.redraw(); }")
    walk.page.get_by_role("link", name="Gallery", exact=True).click()
    walk.page.wait_for_timeout(400)
    count = len(walk.asked)
    walk.page.wait_for_timeout(400)
    assert len(walk.asked) == count


def test_far_out_it_is_drawn_reduced(walk: Walk, texture: ia.Weave) -> None:
    walk.page.set_viewport_size({"width": 840, "height": 480})  # 64 tiles are drawn for each that is reduced
    walk.method("repeat")
    for _ in range(12):
        half = "s => { s.view.zoom(s.view.scale / 2, s.canvas.width / 2, s.canvas.height / 2); s.redraw(); }"
        walk.sight.evaluate(half)
    walk.still()
    told = walk.told()
    assert told["scale"] == 1 / 8
    assert {level for level, _, _ in walk.asked[-4:]} == {3}
    known = window(texture, told).astype(float)
    high, wide = (n // 8 * 8 for n in known.shape[:2])
    known = known[:high, :wide].reshape(high // 8, 8, wide // 8, 8, 3).mean(axis=(1, 3))
    seen = walk.seen()[: high // 8, : wide // 8].astype(float)
    assert abs(seen.mean() - known.mean()) < 4
    walk.page.get_by_role("button", name="Start").click()
    walk.still()
    assert np.array_equal(walk.seen(), window(texture, walk.told()))


def test_a_dice_is_another_texture_and_methods_are_those_of_windows(walk: Walk, texture: ia.Weave) -> None:
    offered = walk.page.locator(".pick-list input").evaluate_all("all => all.map(one => one.value)")
    known = walk.desk.served.get("/api/schema")["methods"]
    assert set(offered) == {"auto", *(m["slug"] for m in known if "window" in m["supports"])}
    walk.method(PARALLEL)
    before = walk.seen()
    walk.desk.button("Another seed").click()
    walk.still()
    seed = int(walk.page.get_by_role("spinbutton", name="Seed").input_value())
    assert walk.weaves[-1]["options"]["seed"] == seed
    assert not np.array_equal(walk.seen(), before)
    assert np.array_equal(walk.seen(), window(parallel(texture, seed=seed), walk.told()))


def test_what_cannot_be_is_said_so(walk: Walk, texture: ia.Weave) -> None:
    walk.desk.wrong.clear()
    walk.page.locator(".pick-head").click()
    walk.page.locator(".method", has_text="best-tile").click()
    expect(walk.page.get_by_role("alert")).to_contain_text("no grid")
    assert [line for line in walk.desk.wrong if "400" not in line] == []
    walk.desk.wrong.clear()
    walk.method("repeat")
    assert np.array_equal(walk.seen(), window(texture, walk.told()))


def test_a_view_is_kept_and_its_command_copied(walk: Walk) -> None:
    walk.method(PARALLEL)
    walk.stroke((300, 200), (340, 240))
    walk.still()
    told, seen = walk.told(), walk.seen()
    walk.desk.button("Command").click()
    expect(walk.page.get_by_text("Command copied")).to_be_visible()
    command = walk.page.evaluate("navigator.clipboard.readText()")
    size, origin = f"{told['width']}x{told['height']}", f"{told['x']},{told['y']}"
    assert command == (
        f"intarsia weave small.png --origin={origin} -o small_woven.png --size={size} --method={PARALLEL} --seed=0"
    )
    walk.desk.button("Keep this view").click()
    expect(walk.page.get_by_text("it will be in the gallery")).to_be_visible()
    served = walk.desk.served
    job = served.ended(max(served.get("/api/jobs"), key=lambda job: job["created"]))
    drawn = served.bytes(f"/api/results/{job['result']}/view/albedo.png?side=4096")
    assert np.array_equal(opened(drawn), seen)
    walk.desk.room("Gallery")
    walk.page.wait_for_function("() => document.querySelector('.made img')?.naturalWidth > 0")


def test_a_server_that_knows_nothing_of_it_is_asked_anew(walk: Walk, texture: ia.Weave) -> None:
    walk.method("repeat")
    count = len(walk.weaves)
    walk.page.route(TILE, lambda route: route.fulfill(status=404, json={"error": "no."}), times=1)
    walk.sight.evaluate("s => { s.view.move(-30 * 256, 0); s.redraw(); }")
    walk.page.wait_for_timeout(400)
    walk.still()
    assert len(walk.weaves) == count + 1
    assert np.array_equal(walk.seen(), window(texture, walk.told()))
    walk.desk.wrong.clear()


def test_it_is_never_blank_and_says_what_goes_on(walk: Walk) -> None:
    walk.method(PARALLEL)
    before = walk.seen()
    walk.page.route(TILE, lambda route: None)
    says = walk.page.get_by_role("status").filter(has_text="Drawing what is in sight")
    expect(says).to_be_hidden()
    walk.desk.button("Another seed").click()
    expect(says).to_be_visible()
    assert np.array_equal(walk.seen(), before)  # what was seen stays until the new one comes
    walk.desk.room("Gallery")
    walk.desk.room("Endless")
    expect(says).to_be_visible()
    walk.desk.until(lambda: drawn(walk.sight)[..., 3].all())  # the example, dim
    dim = drawn(walk.sight)
    assert dim[..., 3].max() < 255
    assert dim[..., :3].std() > 10
    walk.page.unroute(TILE)
    walk.sight.evaluate("s => { s.view.move(-100 * 256, 0); s.redraw(); }")
    walk.still()
    expect(says).to_be_hidden()
    walk.seen()


def test_two_tabs_do_not_disturb_one_another(browser: Browser, served: Served, walk: Walk, texture: ia.Weave) -> None:
    walk.method(PARALLEL)
    with desk(browser, served) as other, walking(other) as second:
        second.method("repeat")
        walk.desk.button("Another seed").click()
        second.stroke((500, 300), (200, 100))
        walk.still()
        second.still()
        seed = walk.weaves[-1]["options"]["seed"]
        assert np.array_equal(walk.seen(), window(parallel(texture, seed), walk.told()))
        assert np.array_equal(second.seen(), window(texture, second.told()))


def test_where_one_was_is_kept(walk: Walk) -> None:
    walk.method("repeat")
    walk.sight.evaluate("s => { s.view.move(-1000, 300); s.redraw(); }")
    before = walk.still().told()
    walk.desk.room("Gallery")
    walk.desk.room("Endless")
    walk.still()
    assert walk.told() | {"came": 0, "dropped": 0} == before | {"came": 0, "dropped": 0}


def test_two_fingers_zoom_and_one_moves(browser: Browser, served: Served) -> None:
    size = {"width": 1024, "height": 768}
    with desk(browser, served, viewport=size, has_touch=True) as page, walking(page) as walk:
        walk.method("repeat")
        box = walk.sight.bounding_box()
        assert box is not None
        session = page.page.context.new_cdp_session(page.page)

        def touch(kind: str, *places: tuple[float, float]) -> None:
            points = [{"x": box["x"] + x, "y": box["y"] + y, "id": n} for n, (x, y) in enumerate(places)]
            session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        before = walk.told()
        touch("touchStart", (300, 300))
        touch("touchMove", (200, 260))
        touch("touchEnd")
        walk.still()
        now = walk.told()
        assert (now["x"] - before["x"], now["y"] - before["y"]) == (100, 40)
        touch("touchStart", (300, 300), (400, 300))
        for n in range(1, 6):
            touch("touchMove", (300 - 10 * n, 300), (400 + 10 * n, 300))
        touch("touchEnd")
        walk.still()
        assert walk.told()["scale"] == pytest.approx(2, rel=0.05)
