"""Which parameters `make test` tries, and which are left to `make test-long`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product
from typing import Any

import pytest


def going_round(*lists: Sequence[Any]) -> list[Any]:
    """Every combination of the entries of some lists, as rows of parametrize.

    `make test` has every entry of the first list once, and with them those of the others in turn; the rest is long.
    """
    return [
        pytest.param(
            *(own[n] for own, n in zip(lists, at, strict=True)),
            marks=() if all(n == at[0] % len(own) for own, n in zip(lists, at, strict=True)) else pytest.mark.long,
        )
        for at in product(*(range(len(own)) for own in lists))
    ]


def but_some(every: Iterable[Any], *some: Any) -> list[Any]:
    """Every entry of a list as parametrize takes them; all but `some` are long."""
    return [pytest.param(one, marks=() if one in some else pytest.mark.long) for one in every]
