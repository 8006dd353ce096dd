"""Compile a kernel: serial, without the interpreter lock, cached on disk where a folder is writable.

Every kernel of the package goes through :func:`kernel`; nothing else calls numba. No `parallel=True`, no
`fastmath`: threads come from outside, and a decision never depends on the width of a vector register.
"""

from __future__ import annotations

import functools
import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

KEPT = 3
F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile `function` at its first call; without a writable cache folder it is compiled in every process."""
    compiled: Any
    config: Any = numba.config
    own = config.CACHE_DIR
    try:
        config.CACHE_DIR = own or cache_folder()
        compiled = numba.njit(cache=True, nogil=True)(function)
    except (RuntimeError, OSError):  # there is no folder that may be written to
        compiled = numba.njit(nogil=True)(function)
    finally:
        config.CACHE_DIR = own
    return cast(F, compiled)


@functools.cache
def cache_folder() -> str:
    """Return the folder for compiled kernels, made anew whenever any kernel changes.

    numba compares a cached kernel with its own file only; one that calls a changed kernel would stay as it was.
    It lies in the user's cache folder, or in INTARSIA_CACHE; the three newest are kept.
    """
    sources = sorted(Path(__file__).parent.glob("*.py"))
    digest = hashlib.sha256(b"".join(p.read_bytes() for p in sources)).hexdigest()[:16]
    home = os.environ.get("INTARSIA_CACHE") or os.path.join(
        os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "intarsia"
    )
    folder = Path(home) / f"kernels-{digest}"
    if not folder.exists():
        folder.mkdir(parents=True, exist_ok=True)
        others = sorted(folder.parent.glob("kernels-*"), key=lambda p: p.stat().st_mtime)
        for old in others[:-KEPT]:
            shutil.rmtree(old, ignore_errors=True)
    return str(folder)


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
