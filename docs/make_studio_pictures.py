"""Remake the pictures of the studio: the real page in a real browser, with built-in samples alone.

Needs the extra `studio`, playwright and /usr/bin/chromium. What is grown is the same on every machine; letters are not.
"""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import Locator, Page, sync_playwright

FOLDER = Path(__file__).resolve().parent / "images"
SIZE = {"width": 1280, "height": 720}
STILL = """() => {
  const room = document.querySelector("endless-room");
  return room && !room.busy && room.tiles.weave && room.tiles.missing === 0;
}"""
WAIT = 120_000  # ms that a picture may take to grow


@contextmanager
def studio() -> Iterator[str]:
    """Start a studio in a folder of its own; its address."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "intarsia", "studio", "--no-browser", "--folder", folder]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        assert process.stderr is not None
        found = re.search(r"http://\S+", process.stderr.readline())
        assert found is not None
        try:
            yield found[0]
        finally:
            process.send_signal(signal.SIGINT)
            process.communicate()


def press(page: Page, *names: str) -> None:
    """Press buttons, links or choices by their names."""
    for name in names:
        both = page.get_by_role("button", name=name, exact=True).or_(page.get_by_role("link", name=name, exact=True))
        both.or_(page.get_by_role("radio", name=name, exact=True)).last.click()


def opened(page: Page, sample: str) -> None:
    """Open a built-in sample."""
    press(page, "intarsia studio: begin")
    page.get_by_role("region", name="Built-in samples").get_by_role("button", name=sample).click()
    page.get_by_role("heading", name=sample).wait_for()


def grown(page: Page) -> None:
    """Wait for a result on the stage."""
    page.get_by_role("link", name="Download", exact=True).wait_for(timeout=WAIT)
    page.wait_for_timeout(500)


def stroke(page: Page, stage: Locator, *places: tuple[float, float]) -> None:
    """Draw over a stage; places are shares of it."""
    box = stage.bounding_box()
    assert box is not None
    for n, (x, y) in enumerate(places):
        page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"], steps=6 if n else 1)
        if n == 0:
            page.mouse.down()
    page.mouse.up()


def keep(page: Page, name: str) -> None:
    """Write what is seen now."""
    path = FOLDER / f"{name}.jpg"
    Image.open(BytesIO(page.screenshot())).convert("RGB").save(path, quality=82, optimize=True, progressive=True)
    print(f"{path.name}: {path.stat().st_size // 1000} kB")


def main() -> None:
    """Write the pictures."""
    with studio() as address, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox", "--disable-gpu"])
        page = browser.new_page(viewport=SIZE, color_scheme="dark")
        page.goto(address)
        page.get_by_role("region", name="Built-in samples").wait_for()
        page.locator(".card img").last.wait_for(state="attached")
        while not page.evaluate("[...document.querySelectorAll('img')].every(i => i.naturalWidth)"):
            page.wait_for_timeout(200)
        page.get_by_text("Getting ready").wait_for(state="hidden", timeout=WAIT)
        keep(page, "studio-start")
        opened(page, "tiles")
        press(page, "Both", "Grow")
        grown(page)
        opened(page, "stones")
        press(page, "Grow")
        grown(page)
        keep(page, "studio-grow")
        press(page, "4", "Grow")
        captions = page.locator(".sheet .caption").filter(has_text=re.compile(r"seed \d\D*\d\d"))
        captions.nth(3).wait_for(timeout=WAIT)
        page.wait_for_timeout(1000)
        keep(page, "studio-sheet")
        page.locator(".sheet .thumb").first.click()
        grown(page)
        press(page, "Pieces")
        page.wait_for_timeout(2000)
        page.mouse.move(560, 300)
        page.wait_for_timeout(800)
        page.mouse.move(562, 302)
        page.wait_for_timeout(500)
        keep(page, "studio-pieces")
        opened(page, "setts")
        press(page, "1", "Grow")
        grown(page)
        press(page, "Lit")
        page.get_by_role("slider", name="Lamp").wait_for()
        page.wait_for_timeout(1500)
        keep(page, "studio-lit")
        opened(page, "stones")
        press(page, "Inspect")
        page.get_by_role("heading", name="Automatic takes").wait_for(timeout=WAIT)
        for name in ("Rows of stones", "What stands out"):
            page.get_by_role("switch", name=name).click()
        page.wait_for_timeout(2500)
        keep(page, "studio-found")
        press(page, "Mend")
        stage = page.locator("studio-stage:visible").first
        page.wait_for_timeout(500)
        stroke(page, stage, (0.4, 0.4), (0.6, 0.45), (0.52, 0.6))
        keep(page, "studio-heal")
        opened(page, "planks")
        press(page, "Paint")
        page.wait_for_timeout(500)
        left, right = page.locator("studio-stage:visible").all()
        page.get_by_role("slider", name="Size of the brush").fill("72")
        stroke(page, left, (0.06, 0.25), (0.2, 0.25), (0.2, 0.75), (0.06, 0.75))
        stroke(page, right, (0.2, 0.35), (0.5, 0.6), (0.8, 0.4))
        keep(page, "studio-paint")
        opened(page, "pebbles")
        press(page, "Endless")
        page.wait_for_function(STILL, timeout=WAIT)
        page.mouse.move(560, 480)
        page.wait_for_timeout(300)
        keep(page, "studio-endless")
        page.emulate_media(color_scheme="light")
        press(page, "Gallery")
        page.wait_for_timeout(1500)
        keep(page, "studio-gallery")
        browser.close()


if __name__ == "__main__":
    main()
