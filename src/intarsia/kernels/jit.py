"""Compile a kernel: serial, without the interpreter lock, cached on disk where a folder is writable.

Every kernel of the package goes through :func:`kernel`; nothing else calls numba. No `parallel=True`, no
`fastmath`: threads come from outside, and a decision never depends on the width of a vector register.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile `function` at its first call; without a writable cache folder it is compiled in every process."""
    compiled: Any
    try:
        compiled = numba.njit(cache=True, nogil=True)(function)
    except RuntimeError:  # numba finds no folder that it may write to
        compiled = numba.njit(nogil=True)(function)
    return cast(F, compiled)


def on_first_compilation(announce: Callable[[], None]) -> None:
    """Call `announce` once, just before the first kernel that no cache holds is compiled in this process."""
    from numba.core import event

    class _Listener(event.Listener):
        told = False

        def on_start(self, event: Any) -> None:
            if not self.told:
                self.told = True
                announce()

        def on_end(self, event: Any) -> None:
            pass

    register: Any = event.register
    register("numba:compile", _Listener())
