"""Compiled kernels that several rooms share, and the folder in which numba keeps them.

What numba keeps is a pickle with machine code: whoever can write one can run anything. So a folder that others may
write to is not used. Listeners for compilation and for trouble with the folder are registered here, without importing
numba.
"""

from __future__ import annotations

import functools
import hashlib
import os
import shutil
import stat
import tempfile
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

KEPT = 3
ROOT = Path(__file__).parents[1]

_waiting: list[Callable[[], None]] = []
_listeners: list[Callable[[str], None]] = []
_troubles: list[str] = []


def on_trouble(tell: Callable[[str], None]) -> None:
    """Call `tell` with the line about a folder that cannot be used, also if it was said before.

    Without a listener it is a RuntimeWarning. It is said once in a process.
    """
    _listeners.append(tell)
    for line in _troubles:
        tell(line)


def troubled() -> bool:
    """Return whether trouble with the cache was reported in this process."""
    return bool(_troubles)


def on_first_compilation(announce: Callable[[], None]) -> None:
    """Call `announce` once, just before the first kernel that no cache holds is compiled in this process."""
    _waiting.append(announce)


def no_longer(announce: Callable[[], None]) -> None:
    """Remove a listener that :func:`on_first_compilation` added."""
    with suppress(ValueError):
        _waiting.remove(announce)


def compilation_begins() -> None:
    """Call the listeners: a kernel is about to be compiled."""
    while _waiting:
        _waiting.pop(0)()


def _flaw(found: os.stat_result) -> str | None:
    """Return why others than this user or root may have written a folder or file, or None."""
    if stat.S_ISLNK(found.st_mode):
        return "it is a link"
    if not hasattr(os, "geteuid"):  # Windows, where folders belong to their user
        return None
    if found.st_uid not in (os.geteuid(), 0):
        return "it belongs to another user"
    return "others may write to it" if found.st_mode & 0o022 else None


@functools.cache
def sources() -> tuple[Path, ...]:
    """Return the source files of kernels: those of this room, each room's own, and the isometries."""
    shared, own = (ROOT / "kernels").glob("*.py"), ROOT.rglob("*_kernels.py")
    return (ROOT / "foundation/geometry.py", *sorted(shared), *sorted(own))


@functools.cache
def cache_folder() -> str | None:
    """Return the folder for compiled kernels, another one whenever any kernel changes; None if none can be used.

    A kernel that calls a changed one would not be compiled again, so the folder's name is a digest of all sources. It
    is in the user's cache folder, or in INTARSIA_CACHE; the three last used are kept.
    """
    digest = hashlib.sha256(b"".join(p.read_bytes() for p in sources())).hexdigest()[:16]
    named = os.environ.get("INTARSIA_CACHE") or os.environ.get("NUMBA_CACHE_DIR")
    home = Path(
        named or os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "intarsia")
    ).absolute()
    folder = home / f"kernels-{digest}"
    try:
        home.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not named and home.stat().st_mode & 0o022:
            home.chmod(0o700)  # an earlier release made it with the rights of any folder
        flaw = None if _sticky(home.stat()) else _flaw(home.stat())
        if flaw is None:
            fresh = not os.path.lexists(folder)
            folder.mkdir(mode=0o700, exist_ok=True)
            flaw = _flaw(folder.lstat())
            if flaw is None:
                tempfile.TemporaryFile(dir=folder).close()
                os.utime(folder)
    except OSError as e:
        flaw = (e.strerror or str(e)).lower()
    if flaw is not None:
        _not_kept(folder, flaw)
        return None
    if fresh:
        _prune(home)
    return str(folder)


def _sticky(found: os.stat_result) -> bool:
    """Return whether a folder is one like /tmp, in which files can be changed by their owner only."""
    return bool(found.st_mode & stat.S_ISVTX) and found.st_uid in (getattr(os, "geteuid", int)(), 0)


def _not_kept(folder: Path, why: str) -> None:
    line = (
        f"compiled kernels are not kept in {folder} ({why}), so each start compiles them; "
        "name a folder of your own in INTARSIA_CACHE."
    )
    _troubles.append(line)
    for tell in _listeners:
        tell(line)
    if not _listeners:
        warnings.warn(line, RuntimeWarning, stacklevel=4)


def _prune(home: Path) -> None:
    """Remove the least recently used folders of kernels. A process that still uses one compiles again."""
    used = []
    for path in home.glob("kernels-" + "[0-9a-f]" * 16):
        with suppress(OSError):  # another process prunes, too
            found = path.lstat()
            if stat.S_ISDIR(found.st_mode) and not _flaw(found):
                used.append((found.st_mtime, path))
    for _, path in sorted(used)[:-KEPT]:
        shutil.rmtree(path, ignore_errors=True)
