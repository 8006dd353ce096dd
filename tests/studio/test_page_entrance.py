"""How a browser comes in, and stays in."""

from __future__ import annotations

import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from studio.served import Served, studio

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page


class Other(BaseHTTPRequestHandler):
    """Another server of this machine, which looks at the cookies that it gets."""

    seen: list[str]

    def do_GET(self) -> None:
        self.seen.append(self.headers.get("Cookie", ""))
        self.send_response(200)
        self.end_headers()

    def log_message(self, format: str, *args: object) -> None:
        """Nothing."""


def is_in(tab: Page, served: Served) -> None:
    """Wait until the page is there, all of it, at its plain address."""
    tab.get_by_role("region", name="Built-in samples").get_by_role("button").first.wait_for()
    assert tab.url.partition("#")[0] == served.address


def test_a_browser_comes_in_once_and_stays_in(
    browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BROWSER", "true %s")
    context, stranger = browser.new_context(), browser.new_context()
    tab, other = context.new_page(), stranger.new_page()
    with studio(tmp_path / "folder", browser=True) as served:
        until = time.monotonic() + 20
        while not (found := list(served.folder.glob("images/.under-way-*/open.html"))) and time.monotonic() < until:
            time.sleep(0.05)
        tab.goto(found[0].as_uri())
        is_in(tab, served)
        tab.reload()
        is_in(tab, served)
        tab.evaluate("localStorage.setItem('kept', 'yes')")
        second = context.new_page()
        second.goto(served.address)
        is_in(second, served)
        printed = served.entrance()
        for address in (printed, printed):  # the second time it was used already, by this browser
            second.goto(address)
            is_in(second, served)
        other.goto(printed)
        assert "printed last" in other.inner_text("body")
        other.goto(served.entrance())
        is_in(other, served)

        Other.seen = []
        server = ThreadingHTTPServer(("127.0.0.1", 0), Other)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        second.goto(f"http://127.0.0.1:{server.server_port}/")
        server.shutdown()
        server.server_close()
        assert Other.seen
        assert not any(Other.seen)
    with studio(tmp_path / "folder") as served:
        tab.goto(served.address)
        assert "printed last" in tab.inner_text("body")
        tab.goto(served.entrance())
        is_in(tab, served)
        assert tab.evaluate("localStorage.getItem('kept')") == "yes"  # the folder has kept its address
    context.close()
    stranger.close()
