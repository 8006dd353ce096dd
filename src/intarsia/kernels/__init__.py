"""Compiled loops that several rooms share: arrays in, arrays out.

Compiled kernels kept on disk, one file for each, checked before it is loaded and made anew where it is not whole.

An entry is a pickle with machine code: whoever can write one can run anything, and a damaged one can do anything. So a
folder that others may write to is not used, and of an entry nothing is read as code before its length and its digest
are found right. The digest covers what the entry is for, too: the entry of another kernel is as bad as a damaged one.

Who wants to know that kernels are compiled, or that something is wrong with the folder, asks here, without numba.
"""

from __future__ import annotations

import functools
import hashlib
import os
import shutil
import stat
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
_troubles: dict[str, str] = {}  # what kind -> the line that told of it


class Unfit(Exception):
    """What lies in the cache is not what belongs there."""


def on_trouble(tell: Callable[[str], None]) -> None:
    """Have `tell` called with each line about a cache that is damaged or cannot be used, also with earlier ones.

    Without a listener such a line is a RuntimeWarning. Each kind is told once in a process.
    """
    _listeners.append(tell)
    for line in _troubles.values():
        tell(line)


def troubled() -> bool:
    """Tell whether a line about the cache was said in this process."""
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
    """Leave out who waited, if nothing was compiled."""
    with suppress(ValueError):
        _waiting.remove(announce)


def compilation_begins() -> None:
    """Tell those who wait: a kernel is about to be compiled."""
    while _waiting:
        _waiting.pop(0)()


def read_entry(path: str, identity: bytes) -> bytes | None:
    """Return what an entry holds, None where there is no entry; a bad one is refused."""
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
    """Make an entry, all or nothing: also while others make the same one, or take the folder away."""
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
    """Remove what is no entry, whatever it is."""
    with suppress(OSError):
        try:
            os.unlink(path)
        except (IsADirectoryError, PermissionError):
            shutil.rmtree(path, ignore_errors=True)


def _flaw(found: os.stat_result) -> str | None:
    """Say why others than this user or the system's own could have put what lies in a folder or file, or None."""
    if stat.S_ISLNK(found.st_mode):
        return "it is a link"
    if not hasattr(os, "geteuid"):  # Windows, where a user's folders are his own
        return None
    if found.st_uid not in (os.geteuid(), 0):
        return "it belongs to another user"
    return "others may write to it" if found.st_mode & 0o022 else None


@functools.cache
def sources() -> tuple[Path, ...]:
    """Return the files that kernels are made of: those that rooms share, each room's own, and the isometries."""
    shared, own = (ROOT / "kernels").glob("*.py"), ROOT.rglob("*_kernels.py")
    return (ROOT / "foundation/geometry.py", *sorted(shared), *sorted(own))


@functools.cache
def cache_folder() -> str | None:
    """Return the folder for compiled kernels, made anew whenever any kernel changes; None where none can be used.

    A kernel that calls a changed one would stay as it was, so the folder's name follows from all sources. It lies in
    the user's cache folder, or in INTARSIA_CACHE; the three last used are kept.
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


def _sticky(found: os.stat_result) -> bool:
    """Tell whether a folder is one like /tmp, where nobody can touch what belongs to others."""
    return bool(found.st_mode & stat.S_ISVTX) and found.st_uid in (getattr(os, "geteuid", int)(), 0)


def not_kept(folder: str, why: str) -> None:
    say(
        "folder",
        f"compiled kernels are not kept in {folder} ({why}), so each start compiles them; "
        "name a folder of your own in INTARSIA_CACHE.",
    )


def _prune(home: Path) -> None:
    """Remove folders of kernels that were not used for longest. A process that still uses one compiles anew."""
    used = []
    for path in home.glob("kernels-" + "[0-9a-f]" * 16):
        with suppress(OSError):  # another process prunes, too
            found = path.lstat()
            if stat.S_ISDIR(found.st_mode) and not _flaw(found):
                used.append((found.st_mtime, path))
    for _, path in sorted(used)[:-KEPT]:
        shutil.rmtree(path, ignore_errors=True)
