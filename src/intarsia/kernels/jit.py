"""Compile a kernel: serial, without the interpreter lock, kept on disk where a folder is our own.

Every kernel of the package goes through :func:`kernel`; nothing else calls numba. No `parallel=True`, no
`fastmath`: threads come from outside, and a decision never depends on the width of a vector register.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

from .cache import KernelCache, cache_folder, troubled

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile `function` at its first call, or load what was compiled before (see :mod:`.cache`)."""
    compiled: Any = numba.njit(nogil=True)(function)
    if hasattr(compiled, "enable_caching"):  # not so under NUMBA_DISABLE_JIT
        compiled._cache = KernelCache(function, cache_folder)
    return cast(F, compiled)


def on_first_compilation(announce: Callable[[], None]) -> None:
    """Call `announce` once, just before the first kernel that no cache holds is compiled in this process.

    It is not called where a line on the cache was said: that tells of the compilation, too.
    """
    from numba.core import event

    class _Listener(event.Listener):
        announced = False

        def on_start(self, event: Any) -> None:
            if not self.announced:
                self.announced = True
                if not troubled():
                    announce()

        def on_end(self, event: Any) -> None:
            pass

    register: Any = event.register
    register("numba:compile", _Listener())
