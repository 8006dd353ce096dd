"""Compile a kernel: serial, without the interpreter lock, kept on disk where a folder is our own.

Every kernel of the package goes through :func:`kernel`; nothing else calls numba. No `parallel=True`, no
`fastmath`: threads come from outside, and a decision never depends on the width of a vector register.

Where the inside of numba is known, :mod:`.compiling` is quick, and checks each entry of the cache by itself. Of any
other numba only what is public is used: it compiles longer, once, and gives the same numbers.
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
events: Any = event


def kernel(function: F) -> F:
    """Compile `function` at its first call, or load what was compiled before (see :mod:`.cache`)."""
    return function if config.DISABLE_JIT else cast(F, compiled(function))


def plain(function: Callable[..., Any]) -> Any:
    """Compile by what is public of numba alone, kept where it keeps things, but in a folder of our own."""
    folder, before = plain_folder(), config.CACHE_DIR
    config.CACHE_DIR = folder or before
    try:
        return numba.njit(nogil=True, error_model="numpy", cache=folder is not None)(function)
    finally:
        config.CACHE_DIR = before


@functools.cache
def plain_folder() -> str | None:
    """The folder for what numba keeps by itself, which it does not check: of its files those stay that are whole.

    A list of their digests is written when a process ends that compiled something. A file that is not as the list says
    is removed before numba sees it: damaged, or of a process that was killed. Two processes may do all this at once:
    what one takes away the other compiles or finds missing, which numba expects.
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
            """Nothing: what is compiled is listed when the process ends."""

    events.register("numba:compile", Told())
    return str(folder)


def _digests(folder: Path) -> dict[str, str]:
    """The digests of all files below a folder; none of what is no plain file, or too large."""
    found = {}
    for path in sorted(folder.rglob("*.nb?")):
        with suppress(OSError):  # another process took it away
            about = path.lstat()
            whole = path.read_bytes() if stat.S_ISREG(about.st_mode) and about.st_size <= LARGEST else None
            found[path.relative_to(folder).as_posix()] = "" if whole is None else hashlib.sha256(whole).hexdigest()
    return found


try:
    from .compiling import compiled
except Exception:  # another numba, with another inside
    compiled = plain
