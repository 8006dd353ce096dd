"""Compiled kernels kept on disk, one file for each, checked before it is loaded and made anew where it is not whole.

An entry is a pickle with machine code: whoever can write one can run anything, and a damaged one can do anything. So a
folder that others may write to is not used, and of an entry nothing is read as code before its length and its digest
are found right. The digest covers what the entry is for, too: the entry of another kernel is as bad as a damaged one.
"""

from __future__ import annotations

import functools
import hashlib
import os
import pickle
import re
import shutil
import stat
import sys
import uuid
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numba
from numba.core import caching, serialize
from numba.core.compiler import CompileResult
from numba.core.runtime import nrt

from .symbols import all_known, asked_of_others

KEPT = 3
MARK = b"intarsia kernel1"
HEADER = len(MARK) + 8 + 32  # the mark, the length of what follows, its digest
LARGEST = 1 << 26  # bytes of an entry; ours have 20 to 900 kB
ROOT = Path(__file__).parents[1]

_key_of: Any = caching.FunctionCache._index_key
_rebuild: Any = CompileResult._rebuild
_dumps: Any = serialize.dumps
_runtime: Any = nrt.rtsys

_READ = os.O_RDONLY | sum(getattr(os, flag, 0) for flag in ("O_BINARY", "O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC"))
_WRITE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)

_listeners: list[Callable[[str], None]] = []
_troubles: dict[str, str] = {}  # what kind -> the line that told of it


class _Unfit(Exception):
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


def _say(kind: str, line: str) -> None:
    if kind in _troubles:
        return
    _troubles[kind] = line
    for tell in _listeners:
        tell(line)
    if not _listeners:
        warnings.warn(line, RuntimeWarning, stacklevel=3)


class KernelCache(caching._Cache):
    """The compiled forms of one function: what numba asks when it is called with new types of arguments."""

    def __init__(self, function: Callable[..., Any], folder: Callable[[], str | None]) -> None:
        self._py_func, self._folder, self._enabled = function, folder, True

    @property
    def cache_path(self) -> str | None:
        """The folder of the entries; None where there is none to be used."""
        return self._folder()

    def enable(self) -> None:
        """Use the cache (again)."""
        self._enabled = True

    def disable(self) -> None:
        """Neither load nor save."""
        self._enabled = False

    def flush(self) -> None:
        """Forget all entries of this function."""
        folder = self._folder()
        if folder is not None:
            for path in Path(folder).glob(f"{self._name}-*.kernel"):
                _drop(str(path))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the function compiled for a signature, or None where no whole entry is kept."""
        folder = self._folder() if self._enabled else None
        if folder is None:
            return None
        _runtime.initialize(target_context)  # all that ready machine code needs; numba's own refresh takes 0.2 s
        path, identity = self._entry(folder, sig, target_context.codegen())
        try:
            payload = _read(path, identity)
            return None if payload is None else self._rebuilt(payload, target_context)
        except _Unfit:
            _drop(path)
            _say("entry", f"a compiled kernel in {folder} was damaged; it is compiled anew, which may take a minute.")
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled function; what cannot be kept is compiled again in the next process."""
        folder = self._folder() if self._enabled and data.library._finalized else None
        if folder is None or any(not loop.can_cache for loop in data.lifted) or data.library.has_dynamic_globals:
            return
        path, identity = self._entry(folder, sig, data.codegen)
        try:
            *whole, environments = data._reduce()
            needed = tuple(e for e in environments if e.consts)  # one without would hide that of a kernel of its own
            _write(path, identity, _dumps((asked_of_others(data.library._final_module), (*whole, needed))))
        except OSError as e:
            _not_kept(folder, (e.strerror or str(e)).lower())

    @property
    def _name(self) -> str:
        function = self._py_func
        return re.sub(r"[^\w.]", "", f"{function.__module__.rpartition('.')[2]}.{function.__qualname__}")

    def _entry(self, folder: str, sig: Any, codegen: Any) -> tuple[str, bytes]:
        """Return the file of an entry, and the bytes that say what it is for."""
        key = _key_of(self, sig, codegen)  # types, processor, bytecode
        made_by = (numba.__version__, sys.implementation.cache_tag, getattr(sys, "abiflags", ""))
        identity = repr((self._name, _stamp(self._py_func.__code__.co_filename), made_by, key)).encode()
        digest = hashlib.blake2b(identity, digest_size=12).hexdigest()
        return os.path.join(folder, f"{self._name}-{digest}.kernel"), identity

    @staticmethod
    def _rebuilt(payload: bytes, target_context: Any) -> Any:
        try:
            names, whole = pickle.loads(payload)
            if not all_known(names, target_context):
                target_context.refresh()
                if not all_known(names, target_context):
                    raise _Unfit  # to load it would end the process
            found = _rebuild(target_context, *whole)
            if not found.library.get_pointer_to_function(found.fndesc.llvm_cpython_wrapper_name):
                raise _Unfit  # nothing that Python could call
            return found
        except MemoryError:
            raise
        except Exception as e:  # whole, but of a numba that calls itself as this one does and is another
            raise _Unfit from e


def _read(path: str, identity: bytes) -> bytes | None:
    """Return what an entry holds, None where there is no entry; a bad one is refused."""
    try:
        handle = os.open(path, _READ)
    except FileNotFoundError:
        return None
    except OSError as e:  # such as a link
        raise _Unfit from e
    try:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode) or not HEADER < found.st_size <= LARGEST or _flaw(found):
            raise _Unfit
        with os.fdopen(handle, "rb", closefd=False) as file:
            header, payload = file.read(HEADER), file.read()
    except OSError as e:
        raise _Unfit from e
    finally:
        os.close(handle)
    if header != _header(identity, payload):
        raise _Unfit
    return payload


def _write(path: str, identity: bytes, payload: bytes) -> None:
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


def _drop(path: str) -> None:
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
    return (ROOT / "geometry.py", *sorted(shared), *sorted(own))


@functools.cache
def _stamp(path: str) -> str:
    """Return a digest of a source file that lies outside of this folder, whose own are in the folder's name."""
    if Path(path) in sources():
        return ""
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError:
        return path


@functools.cache
def cache_folder() -> str | None:
    """Return the folder for compiled kernels, made anew whenever any kernel changes; None where none can be used.

    A kernel that calls a changed one would stay as it was, so the folder's name follows from all sources. It lies in
    the user's cache folder, or in INTARSIA_CACHE; the three last used are kept.
    """
    digest = hashlib.sha256(b"".join(p.read_bytes() for p in sources())).hexdigest()[:16]
    config: Any = numba.config
    named = os.environ.get("INTARSIA_CACHE") or config.CACHE_DIR
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
        _not_kept(str(folder), (e.strerror or str(e)).lower())
        return None
    if flaw is not None:
        _not_kept(str(folder), flaw)
        return None
    with suppress(OSError):  # it may be read only
        os.utime(folder)
    if fresh:
        _prune(home)
    return str(folder)


def _sticky(found: os.stat_result) -> bool:
    """Tell whether a folder is one like /tmp, where nobody can touch what belongs to others."""
    return bool(found.st_mode & stat.S_ISVTX) and found.st_uid in (getattr(os, "geteuid", int)(), 0)


def _not_kept(folder: str, why: str) -> None:
    _say(
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
