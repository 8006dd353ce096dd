"""Shared set-up: how hypothesis searches, and where the development textures are."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

pytest.register_assert_rewrite("intarsia.testing")

settings.register_profile(
    "intarsia", deadline=None, max_examples=12, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("thorough", parent=settings.get_profile("intarsia"), max_examples=200)
settings.load_profile(os.environ.get("INTARSIA_HYPOTHESIS", "intarsia"))

_COUNT = pytest.StashKey[int]()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Count the tests that need the development textures, so that skipping them says how many they are."""
    config.stash[_COUNT] = sum("textures" in getattr(item, "fixturenames", ()) for item in items)


@pytest.fixture(scope="session")
def textures(pytestconfig: pytest.Config) -> dict[str, Path]:
    """The development textures by name; tests that ask for them are skipped where there are none."""
    folder = os.environ.get("INTARSIA_TEXTURES")
    if not folder:
        pytest.skip(f"INTARSIA_TEXTURES is not set; tests of photographs left out: {pytestconfig.stash[_COUNT]}")
    found = {path.stem: path for path in sorted(Path(folder).glob("*.png")) if path.stem.count(".") == 0}
    if not found:
        pytest.fail(f"INTARSIA_TEXTURES={folder} holds no .png")
    return found
