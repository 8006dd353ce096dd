"""What the process beside does: compile what it is told, and say what it works at; see :mod:`.ahead`."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterable
from contextlib import suppress
from queue import Empty, SimpleQueue
from threading import Thread

from ..kernels.compiling import process_is_brief
from ..kernels.listed import compile_line
from ..run import Run
from .ahead import GROW, ONLY, WITHOUT, lists


def work() -> None:
    """Be the process beside: compile what each line of the standard input says, until it is closed."""
    process_is_brief()
    warnings.simplefilter("ignore")  # the process that this one works for says what there is to say
    told: SimpleQueue[list[str] | None] = SimpleQueue()

    def listen() -> None:
        for line in sys.stdin:
            told.put(line.split())
        told.put(None)

    Thread(target=listen, daemon=True).start()
    left: list[str] = []
    while True:
        try:
            words = told.get(block=not left)
        except Empty:
            _do(left.pop())
            continue
        if words is None:
            os._exit(0)
        name, line = words[0], " ".join(words[1:])
        if name == WITHOUT:
            left = [other for other in left if other != line]
        else:
            left = [line] if name == ONLY else _lines(words)


def _lines(names: Iterable[str]) -> list[str]:
    return [line for name in reversed(list(names)) for line in lists().get(name, ())]


def do(line: str, run: Run) -> None:
    """Do what one line says: compile a kernel, or grow a tiny texture."""
    if line.startswith(GROW):
        from .tiny_textures import grow_tiny

        grow_tiny(int(line.removeprefix(GROW)), run)
    else:
        with suppress(ValueError):  # of a list that is older than the kernel
            compile_line(line)


def _do(line: str) -> None:
    print(line, flush=True)
    do(line, Run(1))
    print(flush=True)
