"""Decorator of kernels: compiled serially by numba, without the interpreter lock, and cached on disk.

Every kernel of the package uses :func:`kernel`; nothing else calls numba. No `parallel=True`, no
`fastmath`: threads come from outside, and a decision never depends on the width of a vector register.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.core import event

from . import cache_folder, compilation_begins

F = TypeVar("F", bound=Callable[..., Any])

# no kernel divides by 0, by a test; an error made ready at every divisor takes longer to compile
OPTIONS: Any = {"nogil": True, "error_model": "numpy"}


def kernel(function: F) -> F:
    """Return `function` compiled at its first call, or loaded from the cache (see :mod:`intarsia.kernels`)."""
    config: Any = numba.config
    folder, before = cache_folder(), config.CACHE_DIR
    config.CACHE_DIR = folder or before
    try:
        return cast(F, numba.njit(cache=folder is not None, **OPTIONS)(function))
    finally:
        config.CACHE_DIR = before


class _Told(event.Listener):
    def on_start(self, _: object) -> None:
        compilation_begins()

    def on_end(self, _: object) -> None:
        """Do nothing."""


event.register("numba:compile", _Told())
