"""A file that tells other programs of this user where the studio listens: for those that cannot start any themselves.

Such are plug-ins of programs in a sandbox, which reach loopback, and nothing outside else (docs/callers.md).
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..disk import atomic
from ..plugins import CONTRACT
from ..version import VERSION


def runtime_folder() -> Path:
    """Return the folder in which programs of this user find each other; private, and often gone after a restart."""
    named = os.environ.get("XDG_RUNTIME_DIR") or os.environ.get("LOCALAPPDATA")
    return Path(named or Path.home() / ".cache") / "intarsia"


@contextmanager
def announced(address: str, token: str, folder: str) -> Iterator[None]:
    """Have a file ``studio-PID.json`` lie there in this context; files of studios that were killed go."""
    place = runtime_folder() / f"studio-{os.getpid()}.json"
    told = {
        "contract": CONTRACT, "version": VERSION, "pid": os.getpid(), "address": address, "token": token,
        "folder": folder,
    }  # fmt: skip
    with suppress(OSError):  # without such a folder nobody looks there
        place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        for other in place.parent.glob("studio-*.json"):
            pid = other.stem.partition("-")[2]
            if os.name != "nt" and pid.isdigit() and not atomic.lives(int(pid)):
                other.unlink(missing_ok=True)
        place.unlink(missing_ok=True)
        number = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(number, "w", encoding="utf-8") as file:
            json.dump(told, file)
    try:
        yield
    finally:
        with suppress(OSError):
            place.unlink(missing_ok=True)
