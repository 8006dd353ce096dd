"""Decorator of kernels: compiled serially by numba, without the interpreter lock, and cached on disk.

Every kernel of the package uses :func:`kernel`; nothing else calls numba. No `parallel=True`, no
`fastmath`: threads come from outside, and a decision never depends on the width of a vector register.

With the supported version of numba :mod:`.compiling` is used, which is faster and verifies each entry of the cache.
With any other only numba's public interface is used: it compiles longer, once, and gives the same numbers.
"""

from __future__ import annotations

import atexit
import functools
import hashlib
import stat
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import event

from . import DAMAGED, LARGEST, Unfit, cache_folder, compilation_begins, drop, not_kept, read_entry, say, write_entry

F = TypeVar("F", bound=Callable[..., Any])
config: Any = numba.config


def kernel(function: F) -> F:
    """Return `function` compiled at its first call, or loaded from the cache (see :mod:`intarsia.kernels`)."""
    return function if config.DISABLE_JIT else cast(F, compiled(function))


def plain(function: Callable[..., Any]) -> Any:
    """Return `function` compiled by numba's public interface, with numba's cache in a folder of our own."""
    folder, before = plain_folder(), config.CACHE_DIR
    config.CACHE_DIR = folder or before
    try:
        return numba.njit(nogil=True, error_model="numpy", cache=folder is not None)(function)
    finally:
        config.CACHE_DIR = before


@functools.cache
def plain_folder() -> str | None:
    """Return the folder of numba's own cache, whose files are verified here, as numba does not.

    A list of their digests is written when a process ends that compiled something. A file that differs from the list
    is removed before numba loads it: damaged, or of a process that was killed. Two processes may do this at once:
    numba expects that files are removed.
    """
    home = cache_folder()
    if home is None:
        return None
    folder, identity = Path(home, f"numba-{numba.__version__}"), numba.__version__.encode()
    listed: dict[str, str] = {}
    with suppress(Unfit):
        whole = read_entry(f"{folder}.list", identity) or b""
        listed = dict(line.split(" ", 1)[::-1] for line in whole.decode().splitlines())
    for name, digest in _digests(folder).items():
        if listed.get(name) != digest:
            drop(str(folder / name))
            if name in listed:
                say("entry", DAMAGED.format(folder))

    def write_list() -> None:
        lines = "".join(f"{digest} {name}\n" for name, digest in _digests(folder).items())
        try:
            write_entry(f"{folder}.list", identity, lines.encode())
        except OSError as e:
            not_kept(home, (e.strerror or str(e)).lower())

    class Told(event.Listener):
        def on_start(self, _: object) -> None:
            compilation_begins()
            atexit.unregister(write_list)
            atexit.register(write_list)

        def on_end(self, _: object) -> None:
            """Do nothing: files are listed when the process ends."""

    event.register("numba:compile", Told())
    return str(folder)


def _digests(folder: Path) -> dict[str, str]:
    """Return the digests of all files below a folder; empty for irregular or too large ones."""
    found = {}
    for path in sorted(folder.rglob("*.nb?")):
        with suppress(OSError):  # another process took it away
            about = path.lstat()
            whole = path.read_bytes() if stat.S_ISREG(about.st_mode) and about.st_size <= LARGEST else None
            found[path.relative_to(folder).as_posix()] = "" if whole is None else hashlib.sha256(whole).hexdigest()
    return found


try:
    from .compiling import compiled
except Exception:  # another numba, with other internals
    compiled = plain
