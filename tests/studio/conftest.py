"""A studio that the tests of this folder share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from studio.served import Served, pixels, png, studio


@pytest.fixture(scope="session")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A studio, started once."""
    with studio(tmp_path_factory.mktemp("studio") / "folder") as found:
        yield found


@pytest.fixture(scope="session")
def small(served: Served) -> str:
    """A small exemplar that is there."""
    return str(served.exemplar(small=png(pixels()))["id"])
