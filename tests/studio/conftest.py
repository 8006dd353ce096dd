"""A studio that the tests of this folder share."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest
from studio.browser import Desk, chromium, desk, left_out
from studio.served import Served, pixels, png, studio

if TYPE_CHECKING:
    from playwright.sync_api import Browser


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave the tests of the page out where there is no browser; that is told at the end, once."""
    left = [item for item in items if "browser" in getattr(item, "fixturenames", ())] if left_out() else []
    if left:
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if item not in left]


@pytest.fixture(scope="session")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A studio, started once."""
    with studio(tmp_path_factory.mktemp("studio") / "folder") as found:
        yield found


@pytest.fixture(scope="session")
def small(served: Served) -> str:
    """A small exemplar that is there."""
    return str(served.exemplar(small=png(pixels()))["id"])


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """A browser; for one file at a time, as its driver keeps an event loop running."""
    with chromium() as found:
        yield found


@pytest.fixture
def page(browser: Browser, served: Served) -> Iterator[Desk]:
    """A page that was just opened."""
    with desk(browser, served) as found:
        yield found
