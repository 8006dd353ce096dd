"""Limits on pixels and memory, checked before any work begins; whole.py writes files atomically.

A picture is refused by the size that its header states, or if unpacking it takes much memory for few bytes of file; any
work is refused if its estimated memory does not fit. Imports nothing heavy.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar

from ..foundation import InputError, ParameterError, ResourceError

MAX_PIXELS = 1 << 28
"""The largest limit that can be set."""

DEFAULT_PIXELS = 1 << 26
"""Default limit of the pixels of a picture: 8192x8192."""

VARIABLE = "INTARSIA_MAX_PIXELS"
"""The environment variable that sets another default, which is then the largest limit, too."""

SIDE = 1 << 20
MAX_CHANNELS = 64
FREE_BYTES_PER_PIXEL = 6
"""Bytes of memory for each pixel that is allowed, which a file may take however small it is."""

BYTES_PER_FILE_BYTE = 32
"""Bytes of memory for each byte of the file, which it may take beyond that: real textures hold what they unpack to."""

_asked: ContextVar[int | None] = ContextVar("max_pixels", default=None)


@contextmanager
def allowing(pixels: int | None) -> Iterator[None]:
    """Set the most pixels of a picture that is read in this context; None: the default of the environment.

    Raises ParameterError where the environment variable allows less, or that is more than 2**28.
    """
    if pixels is not None:
        ceiling = _of_environment() or MAX_PIXELS
        if not 1 <= pixels <= ceiling:
            raise ParameterError(f"--max-pixels {pixels} is not allowed; give 1 to {ceiling}{_why(ceiling)}.")
    token = _asked.set(pixels)
    try:
        yield
    finally:
        _asked.reset(token)


def most_pixels() -> int:
    """Return how many pixels a picture may have in this context."""
    return _asked.get() or _of_environment() or DEFAULT_PIXELS


def check_size(name: str, width: int, height: int, channels: int = 1, side: int = SIDE) -> None:
    """Raise InputError if the size that a header states is not allowed; asked before anything is unpacked."""
    if width < 1 or height < 1:
        raise InputError(f"{name} has no pixels ({width}x{height}); save it again.")
    if max(width, height) > side:
        raise InputError(f"{name} claims {width}x{height} px; at most {side} px a side are allowed, so crop it first.")
    most = most_pixels()
    if width * height > most:
        raise InputError(
            f"{name} claims {width}x{height} px; at most {most} pixels are allowed, so {_remedy(width * height)}."
        )
    if channels > MAX_CHANNELS:
        raise InputError(f"{name} has {channels} channels; at most {MAX_CHANNELS}, so save fewer.")


def check_decoding_cost(name: str, cost: float, held: int) -> None:
    """Raise InputError if a file of `held` bytes needs out of proportion much memory (`cost` bytes) to decode."""
    most = most_pixels()
    if cost <= max(FREE_BYTES_PER_PIXEL * most, BYTES_PER_FILE_BYTE * held) or most >= MAX_PIXELS:
        return
    raise InputError(
        f"{name} would take {_words(cost)} of memory, with {_words(held)} in the file; so small a one may take "
        f"{_words(FREE_BYTES_PER_PIXEL * most)}, so {_remedy(min(-(-int(cost) // FREE_BYTES_PER_PIXEL), MAX_PIXELS))}."
    )


def reason_of(e: OSError | ValueError) -> str:
    """Return the message of the operating system for an error, in lower case."""
    return str(getattr(e, "strerror", None) or e).lower()


def no_room(name: str) -> ResourceError:
    """Return the error for a file that does not fit into memory."""
    return ResourceError(f"{name} does not fit into memory; crop it first, or free some.")


def _remedy(needed: int) -> str:
    ceiling = _of_environment() or MAX_PIXELS
    if needed > ceiling:
        return f"crop it first (nobody may ask for more than {ceiling}{_why(ceiling)})"
    return f"crop it first, or allow more with --max-pixels {needed} ({VARIABLE}={needed})"


def _why(ceiling: int) -> str:
    return f", as {VARIABLE} says" if ceiling < MAX_PIXELS else ""


def _of_environment() -> int | None:
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return None
    if not text.isascii() or not text.isdigit() or not 1 <= int(text[:20]) <= MAX_PIXELS:
        raise ParameterError(f"{VARIABLE}={text[:40]} is not allowed; give 1 to {MAX_PIXELS} pixels, or unset it.")
    return int(text)


def _words(count: float) -> str:
    return f"{int(count) >> 20} MiB" if count >= 1 << 20 else f"{int(count)} bytes"


FLOOR = 720 << 20
"""Least bytes of address space for any command: Python, its libraries, and compiling.

With less, LLVM crashes, and OpenBLAS (in numpy and scipy) asks for its buffers of 32 MiB a thread again and again.
"""

RESERVED = 240 << 20
"""Bytes of address space that are taken and never filled: the code of the libraries, and room for their heaps."""

ESTIMATE_MARGIN = 0.8
"""Work is refused if this share of its estimated memory does not fit: the estimate is right within 25 %."""


BLAS = "OPENBLAS_NUM_THREADS"
"""Read when numpy is imported; no result depends on it."""


HEAP_OPTIONS = ((-1, 64 << 20), (-3, 32 << 20))
"""Options of glibc's heap: it gives back what is free beyond so many bytes, and maps arrays of so many each by itself.

By itself it gives back each array as it is dropped, and the next one is made of pages that the system first clears: 70
thousand of 107 thousand for a picture of 512 px, which took 0.15 s of 2.5.
"""


def prepare_memory() -> None:
    """Raise ResourceError if the address space is too small for the libraries; set up the heap for its limit."""
    os.environ.setdefault(BLAS, "1")  # its threads cost each start 0.2 s of CPU, and shorten nothing that is done here
    limit = address_space()
    if limit is None:
        _set_heap(HEAP_OPTIONS)
        return
    if limit < FLOOR:
        raise ResourceError(
            f"the address space is limited to {limit >> 20} MiB, and Python's libraries need {FLOOR >> 20} MiB; "
            "raise the limit (ulimit -v)."
        )
    os.environ[BLAS] = "1"
    _set_heap(((-8, 1),))  # one heap for all threads, where each would reserve 64 MiB


def _set_heap(options: tuple[tuple[int, int], ...]) -> None:
    """Set options of glibc's heap, if there is one."""
    with suppress(OSError, AttributeError):
        import ctypes

        heap = ctypes.CDLL(None)
        for number, value in options:
            heap.mallopt(number, value)


def address_space() -> int | None:
    """Return the limit of this process's address space in bytes; None where there is none."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if limit == resource.RLIM_INFINITY else limit


def check_fits(needed: int, what: str, instead: str = "choose a smaller --size, or weave it") -> None:
    """Raise ResourceError if `needed` bytes, the peak of the whole process, do not fit into memory."""
    for there, whose in _limits():
        if needed * ESTIMATE_MARGIN > there:
            raise ResourceError(
                f"{what} takes about {needed >> 20} MiB of memory, and {whose} {max(there, 0) >> 20} MiB; {instead}."
            )


def peak_memory() -> int:
    """Return the peak memory of this process so far in bytes; 0 if the system does not report it."""
    return _numbers("/proc/self/status").get("VmHWM", 0)


def _limits() -> Iterator[tuple[int, str]]:
    """Yield each bound on the memory of this process in bytes, and words for what sets it."""
    limit = address_space()
    if limit is not None:
        yield limit - RESERVED, "the limit of the address space (ulimit -v) leaves"
    own = _numbers("/proc/self/status").get("VmRSS", 0)
    memory = _numbers("/proc/meminfo")
    if "MemAvailable" in memory:
        yield own + memory["MemAvailable"] + memory.get("SwapFree", 0), "this computer has"
    for most, used in _groups():
        yield own + most - used, "the limit of the container (cgroup) leaves"


def _numbers(path: str) -> dict[str, int]:
    """Return the entries of a file of lines `Name: N kB` in bytes; other lines are ignored."""
    found = {}
    with suppress(OSError), open(path, errors="replace") as lines:
        for line in lines:
            words = line.split()
            if len(words) == 3 and words[2] == "kB":
                found[words[0].rstrip(":")] = int(words[1]) << 10
    return found


def _groups(mounted: str = "/sys/fs/cgroup", own: str = "/proc/self/cgroup") -> Iterator[tuple[int, int]]:
    """Yield limit and use in bytes of every control group of this process; reclaimable pages do not count as used."""
    from pathlib import Path

    with suppress(OSError):
        for line in Path(own).read_text().splitlines():
            _, kinds, name = line.split(":", 2)
            if kinds not in ("", "memory"):
                continue
            names = ("max", "current", "inactive_file") if not kinds else (
                "limit_in_bytes", "usage_in_bytes", "total_inactive_file")  # fmt: skip
            place = Path(mounted, kinds, name.strip("/"))
            for folder in (place, *place.parents):
                with suppress(OSError, ValueError):
                    most, used = (int((folder / f"memory.{n}").read_text()) for n in names[:2])
                    stat = dict(line.split() for line in (folder / "memory.stat").read_text().splitlines())
                    yield most, used - int(stat.get(names[2], 0))
