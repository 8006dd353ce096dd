"""Sketches of methods: small, true to the exemplar, and never in the way of a job."""

from __future__ import annotations

import asyncio
import time
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest
from studio.browser import Desk
from studio.served import Served, opened, pixels, png

from intarsia.studio.pictures import AGAIN, Pictures, Sketches
from intarsia.studio.processes import FailedError

if TYPE_CHECKING:
    from playwright.sync_api import expect
else:
    expect = pytest.importorskip("playwright.sync_api", reason="no playwright").expect


def address(exemplar: str, method: str) -> str:
    return f"/api/exemplars/{exemplar}/methods/{method}.png"


def test_a_sketch_is_made_of_the_exemplar(served: Served, small: str) -> None:
    data = served.bytes(address(small, "image-quilting"))
    grown, source = opened(data), pixels()
    assert grown.shape == (192, 192, 3)
    own = {tuple(colour) for colour in source.reshape(-1, 3)}
    assert {tuple(colour) for colour in grown.reshape(-1, 3)} <= own
    assert served.bytes(address(small, "image-quilting")) == data
    assert opened(served.bytes(address(small, "auto"))).shape[2] == 3


def test_a_large_exemplar_is_seen_whole_in_its_sketch(served: Served) -> None:
    y = np.broadcast_to(np.arange(1000)[:, None, None] * 255 // 999, (1000, 400, 3)).astype(np.uint8)
    large = served.exemplar(slope=png(y))["id"]
    grown = opened(served.bytes(address(large, "repeat")))
    assert grown.min() < 4
    assert grown.max() > 120


def test_what_a_method_cannot_serve_has_no_sketch(served: Served, small: str) -> None:
    answer = served.client.get(address(small, "best-tile"))
    assert (answer.status_code, answer.content) == (204, b"")
    assert served.client.get(address(small, "magic")).status_code == 400
    assert served.client.get(address("0" * 16, "auto")).status_code == 404


class Slow:
    """A process whose first sketch takes until it is cancelled; it notes what happens to it, in order."""

    def __init__(self) -> None:
        self.noted, self.stopped = list[str](), asyncio.Event()

    async def ask(self, do: str, gone: Any, **given: Any) -> Any:
        if await gone():
            raise FailedError("nobody waits for this any more.")
        self.noted.append("begun")
        if self.noted.count("begun") == 1:
            await self.stopped.wait()
            raise FailedError("cancelled", 130)
        self.noted.append("made")
        return {}, b"a sketch"

    def cancel(self) -> None:
        self.noted.append("given up")
        self.stopped.set()


def test_a_sketch_that_is_under_way_gives_way_to_a_job_and_is_made_anew_after_it() -> None:
    slow, busy = Slow(), False

    async def gone() -> bool:
        return False

    async def asked() -> None:
        nonlocal busy
        sketches = Sketches(cast(Any, SimpleNamespace(paths_of=lambda row: [])), Pictures(), lambda: busy)
        sketches.process = cast(Any, slow)
        answer = asyncio.ensure_future(sketches.get({"id": "0"}, "repeat", gone))
        while not slow.noted:
            await asyncio.sleep(0.01)
        busy = True
        await slow.stopped.wait()
        with pytest.raises(TimeoutError):  # as long as the job runs nothing is begun
            await asyncio.wait_for(asyncio.shield(answer), 3 * AGAIN)
        assert slow.noted == ["begun", "given up"]
        busy = False
        assert await answer == b"a sketch"
        assert slow.noted == ["begun", "given up", "begun", "made"]

    asyncio.run(asyncio.wait_for(asked(), 60))


def test_a_sketch_that_is_asked_for_while_a_job_runs_comes_after_it(served: Served) -> None:
    fresh = [served.exemplar(fresh=png(pixels(seed=n + 40, height=100, width=110)))["id"] for n in range(2)]
    job = served.job("grow", [fresh[0]], method="wei-levoy", size="240x240")
    while served.get(f"/api/jobs/{job['id']}")["state"] == "queued":
        time.sleep(0.01)
    served.bytes(address(fresh[1], "image-quilting"))
    done = time.time()
    ended = served.ended(job)
    assert ended["state"] == "done"
    assert done > ended["ended"]


def test_nobody_waits_for_a_sketch_that_is_not_wanted(served: Served) -> None:
    own = served.exemplar(own=png(pixels(seed=77, height=200, width=210)))["id"]
    job = served.job("grow", [own], method="wei-levoy", size="140x140")
    with pytest.raises(Exception, match="timed out"):
        served.client.get(address(own, "efros-leung"), timeout=0.3)
    assert served.ended(job)["state"] == "done"
    begun = time.time()
    served.bytes(address(own, "repeat"))
    assert time.time() - begun < 20


def test_a_method_is_chosen_by_keys_and_the_list_closes_when_it_is_left(page: Desk) -> None:
    page.sample("tiles")
    page.page.locator(".pick-head").focus()
    page.page.keyboard.press("Enter")
    methods = page.page.get_by_role("radiogroup", name="Method")
    methods.get_by_role("radio").first.focus()
    page.page.keyboard.press("ArrowDown")
    expect(methods.get_by_role("radio").nth(1)).to_be_checked()
    expect(page.page.locator(".pick-head")).to_contain_text("Square pieces")
    page.page.get_by_label("Seed", exact=True).focus()
    expect(methods).to_be_hidden()
    page.page.locator(".pick-head").click()
    page.page.mouse.click(8, 400)
    expect(methods).to_be_hidden()


def test_methods_show_what_they_make_of_this_exemplar(page: Desk) -> None:
    page.sample("tiles")
    assert page.page.locator(".sketch img").count() == 0
    page.page.locator(".pick-head").click()
    first = page.page.locator(".method", has_text="auto").first.locator(".sketch img")
    expect(first).to_be_visible(timeout=60_000)
    assert first.evaluate("i => i.naturalWidth") == 192
    box = first.bounding_box()
    assert box is not None
    assert min(box["width"], box["height"]) >= 112
    page.page.locator(".method", has_text="auto").first.hover()
    page.until(lambda: (first.bounding_box() or box)["width"] == pytest.approx(2 * box["width"]))
    expect(page.page.locator(".method", has_text="near-regular").locator(".tag")).to_have_text(["keeps rows", "quick"])
    page.page.locator(".pick-head").click()
    expect(first).to_be_hidden()
    asked: list[str] = []
    page.page.on("request", lambda request: asked.append(request.url))
    page.still()
    assert not [url for url in asked if "/methods/" in url]
