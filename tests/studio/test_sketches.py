"""Sketches of methods: small, true to the exemplar, and never in the way of a job."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

import numpy as np
import pytest
from studio.browser import Desk
from studio.served import Served, opened, pixels, png

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


def test_jobs_go_first(served: Served) -> None:
    """A sketch that is asked for while a job runs comes after it; one that is under way is given up, and begun anew."""
    fresh = [served.exemplar(fresh=png(pixels(seed=n + 40, height=100, width=110)))["id"] for n in range(2)]
    served.client.get(address(fresh[0], "repeat"))
    done: dict[str, float] = {}

    def ask(method: str) -> None:
        assert served.client.get(address(fresh[0], method)).status_code == 200
        done[method] = time.time()

    under_way = threading.Thread(target=ask, args=("wei-levoy",))
    under_way.start()
    time.sleep(0.5)
    job = served.job("grow", [fresh[1]], method="wei-levoy", size="240x240")
    later = threading.Thread(target=ask, args=("image-quilting",))
    later.start()
    ended = served.ended(job)
    assert ended["state"] == "done"
    for thread in (under_way, later):
        thread.join(120)
    assert min(done.values()) > ended["ended"]


def test_nobody_waits_for_a_sketch_that_is_not_wanted(served: Served) -> None:
    own = served.exemplar(own=png(pixels(seed=77, height=200, width=210)))["id"]
    job = served.job("grow", [own], method="wei-levoy", size="140x140")
    with pytest.raises(Exception, match="timed out"):
        served.client.get(address(own, "efros-leung"), timeout=0.3)
    assert served.ended(job)["state"] == "done"
    begun = time.time()
    served.bytes(address(own, "repeat"))
    assert time.time() - begun < 20


def test_methods_show_what_they_make_of_this_exemplar(page: Desk) -> None:
    page.sample("tiles")
    assert page.page.locator(".sketch img").count() == 0
    page.page.locator(".pick-head").click()
    first = page.page.locator(".method", has_text="auto").first.locator(".sketch img")
    expect(first).to_be_visible(timeout=60_000)
    assert first.evaluate("i => i.naturalWidth") == 192
    page.page.locator(".pick-head").click()
    page.page.wait_for_timeout(300)
    asked: list[str] = []
    page.page.on("request", lambda request: asked.append(request.url))
    page.page.wait_for_timeout(1500)
    assert not [url for url in asked if "/methods/" in url]
