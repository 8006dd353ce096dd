"""Commands in this process, as a line or word by word."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from click.testing import CliRunner, Result

from intarsia.cli import cli


def run(*words: object, code: int = 0, data: bytes | None = None) -> Result:
    """Run a command, which must end with this exit code; a single word is a whole line."""
    given = shlex.split(str(words[0])) if len(words) == 1 else [str(word) for word in words]
    result = CliRunner().invoke(cli, given, input=data)
    assert result.exit_code == code, result.stderr
    return result


def told(*words: object, code: int = 0) -> dict[str, Any]:
    """What a command says in JSON."""
    given = shlex.split(str(words[0])) if len(words) == 1 else words
    answer: dict[str, Any] = json.loads(run(*given, "--json", code=code).stdout)
    return answer


@contextmanager
def full_disk(room: int) -> Iterator[None]:
    """No file may grow beyond so many bytes."""
    import resource

    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
