"""How quick the page is, printed (`pytest -s`) and not judged: machines differ. What makes it so is judged."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from studio.browser import Desk, desk
from studio.served import Served, png

pytest.importorskip("playwright.sync_api", reason="no playwright")

BEGUN = """() => new Promise(done => {
  const look = () => document.querySelector(".card") ? done(performance.now()) : setTimeout(look, 4);
  look();
})"""
WATCH = """() => {
  window.gaps = [];
  let last = performance.now();
  const next = (now) => { gaps.push(now - last); last = now; window.watch = requestAnimationFrame(next); };
  window.watch = requestAnimationFrame(next);
}"""


def test_the_page_begins_with_few_small_files(browser: Any, served: Served) -> None:
    with desk(browser, served) as page:
        took = page.page.evaluate(BEGUN)
        sizes = "performance.getEntriesByType('resource').map(e => e.name.includes('/static/') ? e.decodedBodySize : 0)"
        files = [size for size in page.page.evaluate(sizes) if size]
        print(f"\nthe page can be used after {took:.0f} ms; {len(files)} files, {sum(files) // 1000} kB")
        assert len(files) < 100
        assert sum(files) < 400_000


@pytest.mark.parametrize("size", [pytest.param(32, marks=pytest.mark.long), 512])
def test_strokes_over_2048_px_never_ask_the_server(page: Desk, size: int) -> None:
    large = np.broadcast_to(np.arange(2048, dtype=np.uint8)[:, None, None], (2048, 2048, 3))
    page.drop(large=png(np.ascontiguousarray(large)))
    page.page.get_by_role("heading", name="large").wait_for()
    page.room("Paint")
    page.still()
    page.page.get_by_role("slider", name="Size of the brush").fill(str(round(100 * np.log(size) / np.log(512))))
    asked: list[str] = []
    page.page.on("request", lambda request: asked.append(request.url))
    page.page.evaluate(
        """() => {
          window.painted = [];
          const put = OffscreenCanvasRenderingContext2D.prototype.putImageData;
          OffscreenCanvasRenderingContext2D.prototype.putImageData = function (data, ...more) {
            painted.push(data.width * data.height);
            return put.call(this, data, ...more);
          };
        }"""
    )
    page.page.evaluate(WATCH)
    page.stroke(*[(600 + 4 * n, 1000 + 300 * np.sin(n / 9)) for n in range(150)], held=True)
    gaps, painted = page.page.evaluate("() => { cancelAnimationFrame(watch); return [gaps, painted]; }")
    print(f"\nbrush of {size} px: {len(gaps)} frames, median {np.median(gaps):.1f} ms, longest {max(gaps):.1f} ms")
    assert asked == []
    page.page.mouse.up()
    assert len(painted) >= 150
    assert max(painted) < (size + 80) ** 2


def test_files_of_the_page_are_asked_for_once(page: Desk) -> None:
    """They are kept under the path of their version."""
    page.page.reload()
    page.button("Choose files").wait_for()
    sizes = "performance.getEntriesByType('resource').filter(e => e.name.endsWith('.js')).map(e => e.transferSize)"
    found = page.page.evaluate(sizes)
    assert len(found) > 50
    assert set(found) == {0}
