"""How much memory there is, and whether a work fits: asked before it begins. Imports nothing heavy."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING

from ..errors import ResourceError
from ..lazy import lazy

if TYPE_CHECKING:
    import pathlib
else:
    pathlib = lazy("pathlib")

FLOOR = 720 << 20
"""Bytes of address space without which no command can work: of Python and its libraries, and of compiling.

With less, LLVM crashes, and OpenBLAS (in numpy and scipy) asks for its buffers of 32 MiB a thread again and again.
"""

RESERVED = 240 << 20
"""Bytes of address space that are taken and never filled: the code of the libraries, and room for their heaps."""

SURE = 0.8
"""A work of which this share does not fit is refused: what it takes is told within 25 %."""


def make_room() -> None:
    """Refuse to work in an address space where libraries crash or hang; take little of one that is limited."""
    limit = address_space()
    if limit is None:
        return
    if limit < FLOOR:
        raise ResourceError(
            f"the address space is limited to {limit >> 20} MiB, and Python's libraries need {FLOOR >> 20} MiB; "
            "raise the limit (ulimit -v)."
        )
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # read when numpy is imported; no result depends on it
    with suppress(OSError, AttributeError):
        import ctypes

        ctypes.CDLL(None).mallopt(-8, 1)  # one heap for all threads, where each would reserve 64 MiB


def address_space() -> int | None:
    """Return the limit of this process's address space in bytes; None where there is none."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if limit == resource.RLIM_INFINITY else limit


def check_fits(needed: int, what: str, instead: str = "choose a smaller --size, or weave it") -> None:
    """Refuse a work for which there is not enough memory; `needed` is what the whole process will take, in bytes."""
    for there, whose in _limits():
        if needed * SURE > there:
            raise ResourceError(
                f"{what} takes about {needed >> 20} MiB of memory, and {whose} {max(there, 0) >> 20} MiB; {instead}."
            )


def free_memory() -> int | None:
    """Return how many bytes this process may still take, as far as the system tells."""
    found = [max(most - used, 0) for most, used in _groups()]
    memory = _numbers("/proc/meminfo")
    if "MemAvailable" in memory:
        found.append(memory["MemAvailable"])
    if not found:
        with suppress(OSError, ValueError, AttributeError):
            found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return min(found, default=None)


def taken() -> int:
    """Return the most that this process has taken of memory so far, in bytes; 0 where the system does not tell."""
    return _numbers("/proc/self/status").get("VmHWM", 0)


def _limits() -> Iterator[tuple[int, str]]:
    """Yield what this process may grow to in bytes, and what sets that bound."""
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
    """Read a list of `Name: N kB` in bytes; lines of another form are left out."""
    found = {}
    with suppress(OSError):
        for line in pathlib.Path(path).read_text().splitlines():
            words = line.split()
            if len(words) == 3 and words[2] == "kB":
                found[words[0].rstrip(":")] = int(words[1]) << 10
    return found


def _groups(mounted: str = "/sys/fs/cgroup", own: str = "/proc/self/cgroup") -> Iterator[tuple[int, int]]:
    """Yield limit and use in bytes of every control group that this process is in; what can be freed is not used."""
    root = pathlib.Path(mounted)
    with suppress(OSError):
        for line in pathlib.Path(own).read_text().splitlines():
            _, kinds, name = line.split(":", 2)
            if kinds not in ("", "memory"):
                continue
            names = ("max", "current", "inactive_file") if not kinds else (
                "limit_in_bytes", "usage_in_bytes", "total_inactive_file")  # fmt: skip
            place = root / kinds / name.strip("/")
            for folder in (place, *place.parents):
                with suppress(OSError, ValueError):
                    most, used = (int((folder / f"memory.{n}").read_text()) for n in names[:2])
                    stat = dict(line.split() for line in (folder / "memory.stat").read_text().splitlines())
                    yield most, used - int(stat.get(names[2], 0))
                if folder == root:
                    break
