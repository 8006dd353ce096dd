"""Compiling beforehand: every kernel that a list names, then tiny textures, which run what no list names."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Any

from ..arguments import expect
from ..choosing.auto import AUTO_METHOD
from ..methods.base import method_class
from ..run import Run, cores, run_of
from .ahead import GROW, Beside, beside, every_kernel, lists, lists_for
from .helper import do
from .tiny_textures import kinds

MOST = 8  # processes: each needs a second to start and 200 MB, and the longest kernel takes three seconds


def warm(*methods: str, run: Run | None = None) -> int:
    """Make this process ready to grow by methods, named as ``intarsia methods`` does; return how many kernels it took.

    Kernels that were compiled once are loaded, in hundredths of a second, others compiled, in up to half a minute: a
    program that answers calls does so before the first of them. ``"auto"``, and no name at all, stands for choosing and
    for the methods that are chosen most often. ParameterError for a name that is none, CancelledError when the run is
    cancelled: what was made until then stays.
    """
    run, wanted = run_of(run), list[str]()
    for slug in methods or (AUTO_METHOD,):
        expect(slug, str, "methods", "names of methods")
        if slug != AUTO_METHOD:
            method_class(slug)
        wanted += [name for name in lists() if name == slug or (slug == AUTO_METHOD and name.startswith(f"{slug}-"))]
    kernels = dict.fromkeys(line for name in wanted for line in lists()[name])
    for number, line in enumerate(kernels):
        run.tick(number, len(kernels))
        do(line, run)
    run.tick(len(kernels), len(kernels))
    return len(kernels)


@contextmanager
def made_beside(run: Run) -> Iterator[None]:
    """Have a process beside make each kernel that is on no disk: a run that is cancelled stops at once then."""
    from ..kernels.cache import cache_folder
    from ..kernels.compiling import before_each
    from ..kernels.listed import line_of

    helpers: list[Beside | None] = []

    def make(kernel: Any, types: tuple[Any, ...]) -> None:
        if cache_folder() is None or not kernel.is_missing(types):
            return
        if not helpers:
            helpers.append(beside())
        if (helper := helpers[0]) is not None:
            helper.take_from(deque([line_of(kernel, types)]))
            while helper.taken and helper.running():
                run.check()
                time.sleep(0.01)

    before_each(make)
    try:
        yield
    finally:
        before_each(None)
        for helper in filter(None, helpers):
            helper.close()


def missing_kernels(slug: str) -> int:
    """Count the kernels that growing by a method needs, most likely, and that are neither loaded nor on disk."""
    from ..kernels.listed import kernel_of

    missing = 0
    for line in dict.fromkeys(line for name in lists_for(slug) for line in lists().get(name, ())):
        with suppress(ValueError):  # of a list that is older than the kernel
            kernel, types = kernel_of(line)
            missing += kernel.is_missing(types)
    return missing


def warm_up(run: Run) -> int:
    """Compile every kernel for this computer, where it is not yet; return how many textures were grown for it.

    Each thread of the run is a process here, as many as there are cores at most: numba compiles one function at a time.
    """
    pictures = len(kinds())
    started = (beside() for _ in range(min(run.workers, cores(), MOST) - 1))
    helpers = [helper for helper in started if helper is not None]
    try:
        for lines in (every_kernel(), [f"{GROW} {number}" for number in range(pictures)]):
            _do_all(deque(lines), helpers, run)
    finally:
        for helper in helpers:
            helper.close()
    return pictures


def _do_all(work: deque[str], helpers: list[Beside], run: Run) -> None:
    """Do what all lines say, from the first on, while the processes beside do so from the last on."""
    silent = replace(run, notes=[])  # nobody sees the textures
    for helper in helpers:
        helper.take_from(work)
    while line := _first(work):
        run.check()
        do(line, silent)
    for helper in helpers[:]:
        while helper.taken and helper.running():
            run.check()
            time.sleep(0.02)
        if not helper.running():
            helpers.remove(helper)
            helper.close()
            run.notes.append("a process that compiled beside this one ended early; its part was done here.")
            if helper.taken:
                do(helper.taken, silent)


def _first(work: deque[str]) -> str:
    try:
        return work.popleft()
    except IndexError:  # the last was taken by another process
        return ""
