"""Compile a kernel: serial, without the interpreter lock, kept on disk where a folder is our own.

Every kernel of the package goes through :func:`kernel`; nothing else calls numba. No `parallel=True`, no
`fastmath`: threads come from outside, and a decision never depends on the width of a vector register.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba.core import config

from .cache import KernelCache, cache_folder
from .compiling import Kernel

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile `function` at its first call, or load what was compiled before (see :mod:`.cache`)."""
    settings: Any = config
    if settings.DISABLE_JIT:
        return function
    compiled: Any = Kernel(function)
    compiled._cache = KernelCache(function, cache_folder)
    return cast(F, compiled)
