"""Compiled kernels that several rooms share, and the disk cache of compiled kernels.

The cache has one file for each kernel, which is verified before it is loaded, and compiled again if it is damaged.

An entry is a pickle with machine code: whoever can write one can run anything, and a damaged one can do anything. So a
folder that others may write to is not used, and nothing of an entry is loaded before its length and its digest
are verified. The digest covers the identity of the kernel, too: the entry of another kernel counts as damaged.

Listeners for compilation and for trouble with the folder are registered here, without importing numba.
"""

from __future__ import annotations

import functools
import hashlib
import os
import platform
import shutil
import stat
import sys
import uuid
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

KEPT = 3
MARK = b"intarsia kernel1"
HEADER = len(MARK) + 8 + 32  # the mark, the length of what follows, its digest
LARGEST = 1 << 26  # bytes of an entry; ours have 20 to 900 kB
ROOT = Path(__file__).parents[1]
DAMAGED = "a compiled kernel in {} was damaged; it is compiled anew, which may take a minute."

_READ = os.O_RDONLY | sum(getattr(os, flag, 0) for flag in ("O_BINARY", "O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC"))
_WRITE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)

_waiting: list[Callable[[], None]] = []
_listeners: list[Callable[[str], None]] = []
_troubles: dict[str, str] = {}  # kind -> the line that reported it


class Unfit(Exception):
    """An entry of the cache is damaged, or of another kernel."""


def on_trouble(tell: Callable[[str], None]) -> None:
    """Call `tell` with each line about a cache that is damaged or cannot be used, also with earlier ones.

    Without a listener such a line is a RuntimeWarning. Each kind is reported once in a process.
    """
    _listeners.append(tell)
    for line in _troubles.values():
        tell(line)


def troubled() -> bool:
    """Return whether trouble with the cache was reported in this process."""
    return bool(_troubles)


def say(kind: str, line: str) -> None:
    if kind in _troubles:
        return
    _troubles[kind] = line
    for tell in _listeners:
        tell(line)
    if not _listeners:
        warnings.warn(line, RuntimeWarning, stacklevel=3)


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


def read_entry(path: str, identity: bytes) -> bytes | None:
    """Return the payload of an entry, None if there is no entry; raise Unfit if it is damaged."""
    try:
        handle = os.open(path, _READ)
    except FileNotFoundError:
        return None
    except OSError as e:  # such as a link
        raise Unfit from e
    try:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode) or not HEADER < found.st_size <= LARGEST or _flaw(found):
            raise Unfit
        with os.fdopen(handle, "rb", closefd=False) as file:
            header, payload = file.read(HEADER), file.read()
    except OSError as e:
        raise Unfit from e
    finally:
        os.close(handle)
    if header != _header(identity, payload):
        raise Unfit
    return payload


def write_entry(path: str, identity: bytes, payload: bytes) -> None:
    """Write an entry atomically, also while others write the same one, or remove the folder."""
    hidden = f"{path}.{os.getpid():x}-{uuid.uuid4().hex[:16]}"
    try:
        handle = os.open(hidden, _WRITE, 0o600)
    except FileNotFoundError:
        os.makedirs(os.path.dirname(path), mode=0o700, exist_ok=True)
        handle = os.open(hidden, _WRITE, 0o600)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(_header(identity, payload) + payload)
        os.replace(hidden, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(hidden)
        raise


def _header(identity: bytes, payload: bytes) -> bytes:
    digest = hashlib.sha256(identity)
    digest.update(payload)
    return MARK + len(payload).to_bytes(8, "little") + digest.digest()


def drop(path: str) -> None:
    """Remove a file or folder in place of an entry."""
    with suppress(OSError):
        try:
            os.unlink(path)
        except (IsADirectoryError, PermissionError):
            shutil.rmtree(path, ignore_errors=True)


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
    except OSError as e:
        not_kept(str(folder), (e.strerror or str(e)).lower())
        return None
    if flaw is not None:
        not_kept(str(folder), flaw)
        return None
    with suppress(OSError):  # it may be read only
        os.utime(folder)
    if fresh:
        _prune(home)
    return str(folder)


def is_warm() -> bool:
    """Return whether every kernel was compiled into the cache, for this computer."""
    folder = cache_folder()
    return folder is not None and os.path.isfile(os.path.join(folder, _warm_mark()))


def mark_warm() -> None:
    """Note in the cache that every kernel was compiled."""
    if (folder := cache_folder()) is not None:
        with suppress(OSError), open(os.path.join(folder, _warm_mark()), "wb"):
            pass


def _warm_mark() -> str:
    computer = hashlib.sha256("\n".join((sys.version, *platform.uname()[4:])).encode()).hexdigest()
    return f"warm-{computer[:16]}"


def _sticky(found: os.stat_result) -> bool:
    """Return whether a folder is one like /tmp, in which files can be changed by their owner only."""
    return bool(found.st_mode & stat.S_ISVTX) and found.st_uid in (getattr(os, "geteuid", int)(), 0)


def not_kept(folder: str, why: str) -> None:
    say(
        "folder",
        f"compiled kernels are not kept in {folder} ({why}), so each start compiles them; "
        "name a folder of your own in INTARSIA_CACHE.",
    )


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
