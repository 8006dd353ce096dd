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
from .ahead import END, WITHOUT, lists, share


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
            _compile(left.pop())
            continue
        if words is None:
            os._exit(0)
        if words == [END]:
            while left:
                _compile(left.pop())
            return
        without = " ".join(words[1:])
        left = [line for line in left if line != without] if words[0] == WITHOUT else _lines(words)


def _lines(words: Iterable[str]) -> list[str]:
    lines: list[str] = []
    for word in reversed(list(words)):
        if "/" in word:
            part, parts = map(int, word.split("/"))
            lines += [f"warm {part}/{parts}", *share(part, parts)]
        else:
            lines += lists().get(word, [])
    return lines


def _compile(line: str) -> None:
    if line.startswith("warm "):
        from .warming import grow_share

        part, parts = map(int, line.removeprefix("warm ").split("/"))
        grow_share(part, parts, Run(1))
        return
    print(line, flush=True)
    with suppress(ValueError):  # of a list that is older than the kernel
        compile_line(line)
    print(flush=True)
