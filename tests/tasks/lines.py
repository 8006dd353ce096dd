"""Command lines of the tests of tasks."""

from __future__ import annotations

from pathlib import Path

from click.testing import CliRunner, Result

from intarsia.cli import cli


def run(*args: object, code: int = 0) -> Result:
    result = CliRunner().invoke(cli, [str(a) for a in args])
    assert result.exit_code == code, result.stderr
    return result


def check_refused(command: str, line: str, code: int, message: str) -> None:
    """A line is refused in one line, and `out.png` is not written."""
    said = run(command, *line.split(), "-q", code=code).stderr
    assert len(said.splitlines()) == 1
    assert message in said
    assert not Path("out.png").exists()
