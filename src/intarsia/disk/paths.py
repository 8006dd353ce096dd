"""What lies at a path, before anything of it is opened."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from ..errors import InputError


def ordinary(path: Path, name: str, instead: str = "a sample such as sample:brick") -> int:
    """Return the size of an ordinary file, and refuse all else without opening it; `instead` is what may be given."""
    try:
        state = os.stat(path)
    except FileNotFoundError:
        if os.path.islink(path):
            raise InputError(f"{name} is a link to a file that does not exist; mend the link.") from None
        raise InputError(f"{name} does not exist; check the name, or give {instead}.") from None
    except (OSError, ValueError) as e:
        reason = getattr(e, "strerror", None) or str(e)
        raise InputError(f"{name} cannot be opened ({reason.lower()}); check the name and the permissions.") from None
    if stat.S_ISDIR(state.st_mode):
        raise InputError(f"{name} is a folder; name a file in it.")
    if not stat.S_ISREG(state.st_mode):
        raise InputError(f"{name} is a pipe or a device; name an ordinary file.")
    return state.st_size
