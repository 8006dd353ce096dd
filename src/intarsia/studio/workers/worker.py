"""A worker process of the studio: runs requests, one after another.

It reads lines of JSON from its standard input and answers with frames on its original standard output: a line of JSON
that gives the number of bytes that follow. It ends when its input does, so that none outlives its server.
"""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
from collections.abc import Callable
from importlib import import_module
from typing import Any, BinaryIO

Json = dict[str, Any]
Answer = tuple[Json, bytes]
Tell = Callable[..., None]
"""Sends progress: fields of JSON, and `data` as bytes."""

WORK = {
    "commands": ("command", "warm", "sketch"),
    "decoding": ("sets", "look", "labels", "see", "origins"),
    "drafts": ("draft",),
    "views": ("view", "places", "find", "overlay", "rim", "edit"),
    "labels": ("propose",),
    "endless": ("begin", "tile"),
}
"""The modules of this package and their requests: functions of the request and of a function that reports progress."""

_cancelled: set[int] = set()


class Channel:
    """Writes frames."""

    def __init__(self, out: BinaryIO) -> None:
        self._out, self._lock = out, threading.Lock()

    def send(self, said: Json, data: bytes = b"") -> None:
        """Send a frame; end this process if the server is gone."""
        line = json.dumps({**said, "bytes": len(data)}).encode()
        try:
            with self._lock:
                self._out.write(line + b"\n" + data)
                self._out.flush()
        except OSError:
            os._exit(1)


def main(limit: int, nice: int) -> None:
    """Run requests until the input ends.

    `limit`: bytes of address space at most, 0: no limit; `nice`: how far the priority is lowered.
    """
    if limit:
        _limit(limit)
    if nice and hasattr(os, "nice"):
        os.nice(nice)
    channel = Channel(os.fdopen(os.dup(1), "wb"))
    os.dup2(2, 1)  # what libraries print is no frame
    os.chdir(os.path.dirname(os.path.abspath(__file__)))  # a folder that is never removed
    import warnings

    warnings.simplefilter("ignore")
    from ...disk import prepare_memory

    prepare_memory()
    todo: queue.SimpleQueue[Json] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(sys.stdin.buffer, todo), daemon=True).start()
    channel.send({"ready": os.getpid()})
    while True:
        _do(todo.get(), channel)


def _limit(limit: int) -> None:
    """Limit the address space, and disable core dumps."""
    try:
        import resource
    except ImportError:  # Windows
        return
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    if hard == resource.RLIM_INFINITY or hard > limit:
        resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _read(lines: BinaryIO, todo: queue.SimpleQueue[Json]) -> None:
    """Queue requests; a cancel takes effect at once."""
    from ...cli import CANCEL

    for line in lines:
        said = json.loads(line)
        if said["do"] == "cancel":
            _cancelled.add(said["number"])
            CANCEL.set()
        else:
            todo.put(said)
    os._exit(0)


def _do(said: Json, channel: Channel) -> None:
    """Run one request, and send its result, or its error in one line."""
    from ...cli import CANCEL, describe_error

    number = said["number"]

    def tell(data: bytes = b"", **more: Any) -> None:
        channel.send({"number": number, **more}, data)

    CANCEL.clear()
    if number in _cancelled:
        CANCEL.set()
    try:
        (module,) = (module for module, does in WORK.items() if said["do"] in does)
        answer, data = getattr(import_module(f"intarsia.studio.workers.{module}"), said["do"])(said, tell)
        channel.send({"number": number, "done": answer}, data)
    except BaseException as e:
        code, line = describe_error(e)
        channel.send({"number": number, "failed": line, "code": 130 if CANCEL.is_set() else code})


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
