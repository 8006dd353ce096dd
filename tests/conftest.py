"""Shared set-up: how hypothesis searches, and where the development textures are."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from slow import TESTS, in_share, is_slow, listed

pytest.register_assert_rewrite("intarsia.testing", "search.search_contract")

settings.register_profile(
    "intarsia", deadline=None, max_examples=12, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("thorough", parent=settings.get_profile("intarsia"), max_examples=200)
settings.load_profile(os.environ.get("INTARSIA_HYPOTHESIS", "intarsia"))

@pytest.fixture(params=[pytest.param(False, id="some"), pytest.param(True, id="all", marks=pytest.mark.long)])
def thorough(request: pytest.FixtureRequest) -> bool:
    """Whether a test goes over all of its cases, as `make test-long` has it, or over few that are chosen well."""
    return bool(request.param)


_COUNT = pytest.StashKey[int]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """`make test-slow SHARE=3`: a third of the slow tests, drawn by the commit."""
    parser.addoption("--share", type=int, default=1, help="run one of so many equal parts of what is chosen")
    parser.addoption("--seed", default="", help="which part: another for another word")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark what is slow, and what needs the development textures; count these, so that skipping says how many."""
    slow, share, seed = listed(), config.getoption("--share"), config.getoption("--seed")
    for item in items:
        if is_slow(item.nodeid.removeprefix(f"{TESTS.name}/"), slow):
            item.add_marker("slow")
    if share > 1:
        items[:] = [item for item in items if in_share(item.nodeid, share, seed)]
    needing = [item for item in items if "textures" in getattr(item, "fixturenames", ())]
    for item in needing:
        item.add_marker("textures")
    config.stash[_COUNT] = len(needing)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Say in one line if the tests of the studio's page were left out."""
    from studio.browser import left_out

    if left_out() and any("studio" in arg or Path(arg).name == "tests" for arg in config.args):
        terminalreporter.write_line(left_out())


@pytest.fixture(scope="session")
def textures(pytestconfig: pytest.Config) -> dict[str, Path]:
    """The development textures by name, the only way to them; where there are none, who asks for them is skipped."""
    folder = os.environ.get("INTARSIA_TEXTURES")
    if not folder:
        pytest.skip(f"INTARSIA_TEXTURES is not set; tests of photographs left out: {pytestconfig.stash[_COUNT]}")
    found = {path.stem: path for path in sorted(Path(folder).glob("*.png")) if path.stem.count(".") == 0}
    if not found:
        pytest.fail(f"INTARSIA_TEXTURES={folder} holds no .png")
    return found
