"""Who wants to know that kernels are about to be compiled. Imports nothing, so that it costs nothing to ask."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

_waiting: list[Callable[[], None]] = []


def on_first_compilation(announce: Callable[[], None]) -> None:
    """Call `announce` once, just before the first kernel that no cache holds is compiled in this process."""
    _waiting.append(announce)


def no_longer(announce: Callable[[], None]) -> None:
    """Leave out who waited, if nothing was compiled."""
    with suppress(ValueError):
        _waiting.remove(announce)


def compilation_begins() -> None:
    """Tell those who wait: a kernel is about to be compiled."""
    while _waiting:
        _waiting.pop(0)()
