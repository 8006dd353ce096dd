"""The page of a studio as a person has it before them: a real browser, real clicks, keys and strokes."""

from __future__ import annotations

import base64
import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from PIL import Image
from studio.served import Served

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Locator, Request

CHROMIUM = Path("/usr/bin/chromium")
QUIET = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip
DESK = {"width": 1280, "height": 720}


def left_out() -> str:
    """Why tests of the page are left out, in one line; nothing where they are run, or must be."""
    if (CHROMIUM.is_file() and find_spec("playwright") is not None) or os.environ.get("INTARSIA_BROWSER") == "required":
        return ""
    return "no /usr/bin/chromium, or no playwright: tests of the studio's page are left out"


@contextmanager
def chromium() -> Iterator[Browser]:
    """A browser for a while. Where there is none its tests are left out, or fail if INTARSIA_BROWSER=required."""
    if not CHROMIUM.is_file():
        pytest.fail(f"there is no {CHROMIUM}")
    from playwright.sync_api import expect, sync_playwright

    expect.set_options(timeout=60_000)  # a busy machine is no fault of the page
    with sync_playwright() as driver:
        found = driver.chromium.launch(executable_path=CHROMIUM, args=QUIET)
        yield found
        found.close()


class Desk:
    """One page of a studio, what it sent, and everything that went wrong on it."""

    def __init__(self, context: BrowserContext, served: Served, fresh: bool = True) -> None:
        self.served, self.page = served, context.new_page()
        self.page.set_default_timeout(60_000)
        self.wrong: list[str] = []
        self.jobs: list[Any] = []
        self.hosts: set[str] = set()
        self.page.on("console", lambda said: self.wrong.append(said.text) if said.type == "error" else None)
        self.page.on("pageerror", lambda error: self.wrong.append(str(error)))
        self.page.on("request", self._sent)
        if fresh:  # what other pages have left is not kept
            for key in served.get("/api/kept"):
                served.client.post(f"/api/kept/{key}", json={})
        self.page.goto(served.entrance())
        self.page.wait_for_url(lambda url: "enter=" not in url)

    def _sent(self, request: Request) -> None:
        self.hosts.add(request.url.split("/")[2])
        if request.method == "POST" and request.url.endswith("/api/jobs"):
            self.jobs.append(request.post_data_json)

    # what a person does

    def sample(self, name: str) -> None:
        """Open a built-in sample."""
        self.page.get_by_role("region", name="Built-in samples").get_by_role("button", name=name).click()
        self.page.get_by_role("heading", name=name).wait_for()

    def button(self, name: str) -> Locator:
        """A button by its whole name."""
        return self.page.get_by_role("button", name=name, exact=True)

    def radio(self, name: str) -> Locator:
        """One of a few choices, by its whole name."""
        return self.page.get_by_role("radio", name=name, exact=True)

    def room(self, name: str) -> None:
        """Go to another room."""
        self.page.get_by_role("link", name=name, exact=True).click()

    def drop(self, **files: bytes) -> None:
        """Drop files on the page: name without .png -> contents."""
        given = [[f"{name}.png", list(data)] for name, data in files.items()]
        self.page.evaluate(
            """files => {
              const data = new DataTransfer();
              for (const [name, bytes] of files) data.items.add(new File([new Uint8Array(bytes)], name));
              document.body.dispatchEvent(new DragEvent("drop", {dataTransfer: data, bubbles: true, cancelable: true}));
            }""",
            given,
        )

    def quick(self) -> None:
        """Choose what grows in a moment."""
        self.page.locator(".pick-head").click()
        self.page.locator(".method", has_text="image-quilting").click()
        self.page.get_by_role("spinbutton", name="Width in px").fill("96")
        self.page.get_by_role("spinbutton", name="Height in px").fill("80")

    def variants(self) -> Locator:
        """Grow the tiles with four seeds; their contact sheet."""
        self.sample("tiles")
        self.quick()
        self.radio("4").click()
        self.button("Grow").click()
        return self.page.get_by_role("region", name="Contact sheet")

    def grown(self) -> str:
        """Wait until a result is on the stage; its id. Where none comes, what the page and the server say of it."""
        from playwright.sync_api import TimeoutError as NoneCame

        link = self.page.get_by_role("link", name=re.compile("^Download( this map)?$"))
        try:
            link.wait_for(timeout=120_000)
        except NoneCame:
            lasts = self.served.get("/api/jobs")[-3:]
            raise AssertionError((self.page.locator("body").inner_text()[:3000], lasts, self.wrong)) from None
        found = re.search(r"/results/([0-9a-f]+)/", link.get_attribute("href") or "")
        assert found is not None
        return found[1]

    def sent(self, option: str, count: int = 1) -> np.ndarray:
        """The picture of numbers that came to the server with the last of so many jobs."""
        self.until(lambda: len(self.jobs) >= count)
        name = self.jobs[count - 1]["options"][option]
        name = name[0] if isinstance(name, list) else name
        return np.asarray(Image.open(self.served.folder / "images" / f"{name}.png"))

    def until(self, holds: Callable[[], object], within: float = 60) -> None:
        """Wait until something holds; a busy machine may take its time."""
        end = time.monotonic() + within
        while not holds():
            assert time.monotonic() < end, self.page.locator("body").inner_text()[:3000]
            self.page.wait_for_timeout(50)

    def same(self, pixels: np.ndarray, number: int = 0) -> bool:
        """Whether a stage shows exactly these pixels."""
        return np.array_equal(self.seen(number), pixels)

    def still(self, number: int = 0) -> np.ndarray:
        """The pixels of a stage, when it has shown the same ones five times."""
        seen: list[np.ndarray] = []

        def stays() -> bool:
            seen.append(self.seen(number))
            return len(seen) > 4 and all(np.array_equal(a, seen[-1]) for a in seen[-5:])

        self.until(stays)
        return seen[-1]

    # what is to be seen

    def stage(self, number: int = 0) -> Locator:
        """A stage that can be seen."""
        return self.page.locator("studio-stage:visible").nth(number)

    def told(self, number: int = 0) -> Any:
        """How a stage is: the size of what it shows, its scale, its place, its layers."""
        script = """s => ({...s.size, scale: s.view.scale, x: s.view.x, y: s.view.y, tiles: s.tiles,
          layers: s.layers.length, other: s.other !== null, divider: s.divider})"""
        return self.stage(number).evaluate(script)

    def seen(self, number: int = 0) -> np.ndarray:
        """The pixels of a stage's canvas as they are drawn: (H, W, 4)."""
        return drawn(self.stage(number))

    def at(self, x: float, y: float, number: int = 0) -> tuple[float, float]:
        """Where a place of the picture lies on the page."""
        box, how = self.stage(number).bounding_box(), self.told(number)
        assert box is not None
        return box["x"] + how["x"] + x * how["scale"], box["y"] + how["y"] + y * how["scale"]

    def stroke(self, *places: tuple[float, float], number: int = 0, held: bool = False) -> list[tuple[float, float]]:
        """Draw with the pointer from place to place of the picture, and hold it; the places where it really was."""
        real = []
        shown = "async s => { while (!s.size.width) await new Promise(requestAnimationFrame); }"
        self.stage(number).evaluate(shown)  # a person sees what is painted on
        how = self.told(number)
        box = self.stage(number).bounding_box()
        assert box is not None
        for n, place in enumerate(places):
            x, y = (round(v) for v in self.at(*place, number=number))
            self.page.mouse.move(x, y)
            real.append(((x - box["x"] - how["x"]) / how["scale"], (y - box["y"] - how["y"]) / how["scale"]))
            if n == 0:
                self.page.mouse.down()
        if not held:
            self.page.mouse.up()
        return real


@contextmanager
def desk(browser: Browser, served: Served, fresh: bool = True, **how: Any) -> Iterator[Desk]:
    """A page for a while; nothing went wrong on it, and it asked nobody else."""
    context = browser.new_context(**{"viewport": DESK, "color_scheme": "dark", **how})
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    found = Desk(context, served, fresh)
    yield found
    context.close()
    assert found.hosts == {f"{served.host}:{served.port}"}, found.hosts
    assert found.wrong == [], found.wrong


def drawn(stage: Any) -> np.ndarray:
    """The pixels of the canvas of a stage, or of endless sight, as they are drawn: (H, W, 4)."""
    script = """async s => {
      await new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
      const {width, height} = s.canvas;
      const pixels = s.canvas.getContext("2d").getImageData(0, 0, width, height).data;
      let text = ""; for (const byte of pixels) text += String.fromCharCode(byte);
      return [width, height, btoa(text)];
    }"""
    width, height, text = stage.evaluate(script)
    return np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width, 4)
